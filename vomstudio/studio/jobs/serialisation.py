"""Conversion of dataclasses to JSON and back, for data exchanged between processes.

Dataclasses may contain text, finite numbers, booleans, None, paths, tuples, lists and mappings
with string keys, nested to any depth. `Any` accepts all of these. A field of a dataclass may
also be a small array of float64.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import types
import typing
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from vomstudio.core.errors import WorkerError
from vomstudio.core.findings import Finding

T = TypeVar("T")


def encode(value: Any, location: str = "") -> Any:
    """Convert a value to plain JSON values. Raises WorkerError for an unsupported field."""
    if isinstance(value, Finding):
        return value.to_dict()
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        prefix = f"{location}." if location else ""
        return {
            field.name: encode(
                item.tolist() if _is_array(type(item)) and field.type is not Any else item,
                prefix + field.name,
            )
            for field in dataclasses.fields(value)
            for item in [getattr(value, field.name)]
        }
    if isinstance(value, float) and not math.isfinite(value):
        raise WorkerError(Finding("job.unsendable", name=location, type=str(value)))
    if value is None or isinstance(value, str | int | float):
        return value
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, Mapping):
        return {key: encode(item, f"{location}[{key!r}]") for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [encode(item, f"{location}[{number}]") for number, item in enumerate(value)]
    raise WorkerError(Finding("job.unsendable", name=location, type=type(value).__name__))


def decode(cls: type[T], plain_value: Any) -> T:
    """Restore an encoded dataclass. Raises WorkerError for an invalid field."""
    value: T = _decode(cls, plain_value, "")
    return value


@functools.cache
def _hints(cls: type[Any]) -> Mapping[str, Any]:
    return typing.get_type_hints(cls)


def _decode(target: Any, plain_value: Any, location: str) -> Any:
    if target is Any:
        return plain_value
    if target is Finding:
        return _decode_finding(plain_value, location)
    if dataclasses.is_dataclass(target):
        return _decode_dataclass(target, plain_value, location)
    origin = typing.get_origin(target)
    if origin in (typing.Union, types.UnionType):
        return _decode_union(target, plain_value, location)
    if origin is typing.Literal:
        return (
            plain_value
            if plain_value in typing.get_args(target)
            else _raise_wrong_value(target, plain_value, location)
        )
    if _is_array(origin):
        import numpy as np

        try:
            return np.array(plain_value, np.float64)
        except (TypeError, ValueError):
            return _raise_wrong_value(origin, plain_value, location)
    if origin is tuple or origin in (list, Sequence):
        return _sequence(target, plain_value, location)
    if origin in (dict, Mapping):
        if not isinstance(plain_value, Mapping):
            return _raise_wrong_value(target, plain_value, location)
        inner_args = typing.get_args(target)[1]
        return {
            key: _decode(inner_args, item, f"{location}[{key!r}]")
            for key, item in plain_value.items()
        }
    return _decode_leaf(target, plain_value, location)


def _is_array(type_: Any) -> bool:
    """Return whether a type is a NumPy array, by its name to avoid importing NumPy."""
    return getattr(type_, "__module__", "") == "numpy" and type_.__name__ == "ndarray"


def _decode_finding(plain_value: Any, location: str) -> Finding:
    if not isinstance(plain_value, Mapping):
        misfit: Finding = _raise_wrong_value(Finding, plain_value, location)
        return misfit
    try:
        return Finding.from_dict(plain_value)
    except (KeyError, TypeError, IndexError):
        raise WorkerError(
            Finding("job.wrong-value", name=location, type="Finding", value=plain_value.get("code"))
        ) from None


def _decode_dataclass(cls: Any, plain_value: Any, location: str) -> Any:
    if not isinstance(plain_value, Mapping):
        return _raise_wrong_value(cls, plain_value, location)
    hints, prefix = _hints(cls), f"{location}." if location else ""
    fields = {field.name: field for field in dataclasses.fields(cls) if field.init}
    if unknown := sorted(set(plain_value) - set(fields)):
        raise WorkerError(Finding("job.unknown-field", type=cls.__name__, name=prefix + unknown[0]))
    for name, field in fields.items():
        is_needed = field.default is dataclasses.MISSING
        if name not in plain_value and is_needed and field.default_factory is dataclasses.MISSING:
            raise WorkerError(Finding("job.missing-field", name=prefix + name, type=cls.__name__))
    return cls(
        **{name: _decode(hints[name], plain_value[name], prefix + name) for name in plain_value}
    )


def _decode_union(target: Any, plain_value: Any, location: str) -> Any:
    kinds = typing.get_args(target)
    if plain_value is None and type(None) in kinds:
        return None
    kinds_without_none = [type_ for type_ in kinds if type_ is not type(None)]
    for type_ in kinds_without_none[:-1]:
        try:
            return _decode(type_, plain_value, location)
        except WorkerError:
            continue
    return _decode(kinds_without_none[-1], plain_value, location)


def _sequence(target: Any, plain_value: Any, location: str) -> Any:
    if not isinstance(plain_value, list | tuple):
        return _raise_wrong_value(target, plain_value, location)
    kinds = typing.get_args(target)
    if typing.get_origin(target) is not tuple:
        return [_decode(kinds[0], item, f"{location}[{n}]") for n, item in enumerate(plain_value)]
    if len(kinds) == 2 and kinds[1] is Ellipsis:
        kinds = (kinds[0],) * len(plain_value)
    if len(kinds) != len(plain_value):
        return _raise_wrong_value(target, plain_value, location)
    pairs = zip(kinds, plain_value, strict=True)
    return tuple(_decode(type_, item, f"{location}[{n}]") for n, (type_, item) in enumerate(pairs))


def _decode_leaf(target: Any, plain_value: Any, location: str) -> Any:
    if target is Path:
        return (
            Path(plain_value)
            if isinstance(plain_value, str | Path)
            else _raise_wrong_value(target, plain_value, location)
        )
    if target is float and isinstance(plain_value, int) and not isinstance(plain_value, bool):
        # An integer in a field of type float remains an integer (3, not 3.0).
        return plain_value
    is_valid = isinstance(plain_value, target) and (
        target is bool or not isinstance(plain_value, bool)
    )
    return plain_value if is_valid else _raise_wrong_value(target, plain_value, location)


def _raise_wrong_value(target: Any, plain_value: Any, location: str) -> Any:
    text = repr(plain_value)
    text = text if len(text) <= 40 else f"{text[:39]}…"
    name = getattr(target, "__name__", str(target))
    raise WorkerError(Finding("job.wrong-value", name=location, type=name, value=text))
