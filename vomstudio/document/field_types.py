"""What the fields of a record may hold, by the annotations of its class.

A journal may come from anybody: a name that is a number, or a corner of two coordinates, is told
where the row is read, and not by whatever comes to use it.
"""

from __future__ import annotations

import math
import types
import typing
from collections.abc import Callable
from functools import lru_cache
from itertools import chain
from typing import Any, NamedTuple

Reader = Callable[[Any], Any]
"""From JSON's value to the field's. Raises ValueError where it is something else."""

_LARGEST = 1e300
_NUMBERS = frozenset((float, int))


class FieldTypes(NamedTuple):
    """simple : fields of one value, with the types that it may have. readers : all others that are
    known here; fields of neither are taken as they stand."""

    simple: dict[str, frozenset[type]]
    readers: dict[str, Reader]


@lru_cache(maxsize=64)
def field_types(cls: type) -> FieldTypes:
    simple: dict[str, frozenset[type]] = {}
    readers: dict[str, Reader] = {}
    for name, wanted in typing.get_type_hints(cls).items():
        options = typing.get_args(wanted) if isinstance(wanted, types.UnionType) else (wanted,)
        if set(options) <= {str, bool, types.NoneType}:
            simple[name] = frozenset(options)
        else:
            reader = _reader(options)
            if reader is not None:
                readers[name] = reader
    return FieldTypes(simple, readers)


def _reader(options: tuple[Any, ...]) -> Reader | None:
    readers = {option: _reader_of(option) for option in options if option is not types.NoneType}
    if len(readers) != 1 or None in readers.values():
        return None
    (read,) = readers.values()
    if types.NoneType not in options:
        return read
    return lambda value: None if value is None else typing.cast(Reader, read)(value)


def _reader_of(wanted: Any) -> Reader | None:
    origin, inside = typing.get_origin(wanted), typing.get_args(wanted)
    if wanted is float:
        return _number
    if wanted is int:
        return _whole
    if wanted is str:
        return _word
    if origin is typing.Literal:
        return _one_of(inside)
    if origin is not tuple:
        return None
    if inside[-1:] == (Ellipsis,):
        count, kinds = None, {inside[0]}
    else:
        count, kinds = len(inside), set(inside)
    if len(kinds) != 1:
        return None
    (kind,) = kinds
    width = typing.get_args(kind)
    if typing.get_origin(kind) is tuple and set(width) <= {float, Ellipsis}:
        return _rows(count, None if Ellipsis in width else len(width))
    read = _reader_of(kind)
    return None if read is None else _list(count, read)


def _number(value: Any) -> float | int:
    if type(value) not in _NUMBERS or not -_LARGEST < value < _LARGEST:
        raise ValueError
    return typing.cast(float, value)


def _whole(value: Any) -> int:
    if type(value) is not int or abs(value) >= 2**62:
        raise ValueError
    return value


def _word(value: Any) -> str:
    if type(value) is not str:
        raise ValueError
    return value


def _one_of(words: tuple[Any, ...]) -> Reader:
    known = frozenset(words)

    def read(value: Any) -> Any:
        if type(value) is not str or value not in known:
            raise ValueError
        return value

    return read


def _list(count: int | None, inside: Reader) -> Reader:
    def read(value: Any) -> tuple[Any, ...]:
        if not isinstance(value, list | tuple) or (count is not None and len(value) != count):
            raise ValueError
        return tuple(map(inside, value))

    return read


def _rows(count: int | None, width: int | None) -> Reader:
    """Rows of numbers, as the vertices of features are, which make up most of a journal."""

    def read(value: Any) -> tuple[tuple[float, ...], ...]:
        if not isinstance(value, list | tuple) or (count is not None and len(value) != count):
            raise ValueError
        if (
            not set(map(type, value)) <= {list, tuple}
            or not set(map(type, chain.from_iterable(value))) <= _NUMBERS
        ):
            raise ValueError
        if width is not None and value and set(map(len, value)) != {width}:
            raise ValueError
        try:
            total = sum(chain.from_iterable(value))
        except OverflowError:
            raise ValueError from None
        # What is no number stays none in a sum.
        if not -math.inf < total < math.inf:
            raise ValueError
        return tuple(map(tuple, value))

    return read
