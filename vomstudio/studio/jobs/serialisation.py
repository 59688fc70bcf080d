"""Dataclasses to JSON and back: what may be sent between two processes.

What fits: dataclasses of text, numbers that are finite, truth values, None, paths, tuples, lists
and maps with names as keys, nested as one likes; `Any` stands for whatever of this is found. A
field of a dataclass may be a small array of float64.
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


def encode(value: Any, place: str = "") -> Any:
    """Plain JSON values. Raises WorkerError that names the field that cannot cross."""
    if isinstance(value, Finding):
        return value.to_dict()
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        inside = f"{place}." if place else ""
        return {
            field.name: encode(
                each.tolist() if _is_array(type(each)) and field.type is not Any else each,
                inside + field.name,
            )
            for field in dataclasses.fields(value)
            for each in [getattr(value, field.name)]
        }
    if isinstance(value, float) and not math.isfinite(value):
        raise WorkerError(Finding("job.unsendable", name=place, type=str(value)))
    if value is None or isinstance(value, str | int | float):
        return value
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, Mapping):
        return {key: encode(each, f"{place}[{key!r}]") for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [encode(each, f"{place}[{number}]") for number, each in enumerate(value)]
    raise WorkerError(Finding("job.unsendable", name=place, type=type(value).__name__))


def decode(cls: type[T], plain: Any) -> T:
    """The dataclass that was encoded. Raises WorkerError that names the field that does not fit."""
    made: T = _decode(cls, plain, "")
    return made


@functools.cache
def _hints(cls: type[Any]) -> Mapping[str, Any]:
    return typing.get_type_hints(cls)


def _decode(wanted: Any, plain: Any, place: str) -> Any:
    if wanted is Any:
        return plain
    if wanted is Finding:
        return _finding(plain, place)
    if dataclasses.is_dataclass(wanted):
        return _dataclass(wanted, plain, place)
    origin = typing.get_origin(wanted)
    if origin in (typing.Union, types.UnionType):
        return _union(wanted, plain, place)
    if origin is typing.Literal:
        return plain if plain in typing.get_args(wanted) else _misfit(wanted, plain, place)
    if _is_array(origin):
        import numpy as np

        try:
            return np.array(plain, np.float64)
        except (TypeError, ValueError):
            return _misfit(origin, plain, place)
    if origin is tuple or origin in (list, Sequence):
        return _sequence(wanted, plain, place)
    if origin in (dict, Mapping):
        if not isinstance(plain, Mapping):
            return _misfit(wanted, plain, place)
        inner = typing.get_args(wanted)[1]
        return {key: _decode(inner, each, f"{place}[{key!r}]") for key, each in plain.items()}
    return _leaf(wanted, plain, place)


def _is_array(kind: Any) -> bool:
    """Told by its name: what sends no arrays need not load NumPy."""
    return getattr(kind, "__module__", "") == "numpy" and kind.__name__ == "ndarray"


def _finding(plain: Any, place: str) -> Finding:
    if not isinstance(plain, Mapping):
        misfit: Finding = _misfit(Finding, plain, place)
        return misfit
    try:
        return Finding.from_dict(plain)
    except (KeyError, TypeError, IndexError):
        raise WorkerError(
            Finding("job.wrong-value", name=place, type="Finding", value=plain.get("code"))
        ) from None


def _dataclass(cls: Any, plain: Any, place: str) -> Any:
    if not isinstance(plain, Mapping):
        return _misfit(cls, plain, place)
    hints, inside = _hints(cls), f"{place}." if place else ""
    fields = {field.name: field for field in dataclasses.fields(cls) if field.init}
    if unknown := sorted(set(plain) - set(fields)):
        raise WorkerError(Finding("job.unknown-field", type=cls.__name__, name=inside + unknown[0]))
    for name, field in fields.items():
        needed = field.default is dataclasses.MISSING
        if name not in plain and needed and field.default_factory is dataclasses.MISSING:
            raise WorkerError(Finding("job.missing-field", name=inside + name, type=cls.__name__))
    return cls(**{name: _decode(hints[name], plain[name], inside + name) for name in plain})


def _union(wanted: Any, plain: Any, place: str) -> Any:
    kinds = typing.get_args(wanted)
    if plain is None and type(None) in kinds:
        return None
    others = [kind for kind in kinds if kind is not type(None)]
    for kind in others[:-1]:
        try:
            return _decode(kind, plain, place)
        except WorkerError:
            continue
    return _decode(others[-1], plain, place)


def _sequence(wanted: Any, plain: Any, place: str) -> Any:
    if not isinstance(plain, list | tuple):
        return _misfit(wanted, plain, place)
    kinds = typing.get_args(wanted)
    if typing.get_origin(wanted) is not tuple:
        return [_decode(kinds[0], each, f"{place}[{n}]") for n, each in enumerate(plain)]
    if len(kinds) == 2 and kinds[1] is Ellipsis:
        kinds = (kinds[0],) * len(plain)
    if len(kinds) != len(plain):
        return _misfit(wanted, plain, place)
    pairs = zip(kinds, plain, strict=True)
    return tuple(_decode(kind, each, f"{place}[{n}]") for n, (kind, each) in enumerate(pairs))


def _leaf(wanted: Any, plain: Any, place: str) -> Any:
    if wanted is Path:
        return Path(plain) if isinstance(plain, str | Path) else _misfit(wanted, plain, place)
    if wanted is float and isinstance(plain, int) and not isinstance(plain, bool):
        # A count that stands where a measure may stand stays a count: 3, not 3.0.
        return plain
    fits = isinstance(plain, wanted) and (wanted is bool or not isinstance(plain, bool))
    return plain if fits else _misfit(wanted, plain, place)


def _misfit(wanted: Any, plain: Any, place: str) -> Any:
    shown = repr(plain)
    shown = shown if len(shown) <= 40 else f"{shown[:39]}…"
    name = getattr(wanted, "__name__", str(wanted))
    raise WorkerError(Finding("job.wrong-value", name=place, type=name, value=shown))
