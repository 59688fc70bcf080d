"""Conversion between dataclasses and plain JSON values, checked against annotations.

A file may come from an unknown source, so the reader rejects a value of the wrong type, such as a
name that is a number, before other code uses it.
"""

from __future__ import annotations

import dataclasses
import math
import types
import typing
from collections.abc import Callable, Mapping
from functools import lru_cache
from itertools import chain
from typing import Any, NamedTuple

from vomstudio.core.errors import DocumentError
from vomstudio.core.findings import Finding

PlainValues = dict[str, Any]
Reader = Callable[[Any], Any]
"""Function from a JSON value to the value of a field. Raises ValueError for a wrong type."""

_MAX_NUMBER = 1e300
_NUMBERS = frozenset((float, int))


class NestedFields(NamedTuple):
    """Fields that contain dataclasses.

    Parameters
    ----------
    parts : mapping of str to type
        Fields that contain one object or None.
    lists : mapping of str to type
        Fields that contain a tuple of objects.
    """

    parts: Mapping[str, type]
    lists: Mapping[str, type]


class FieldTypes(NamedTuple):
    """Permitted types or readers of the fields of a class; other fields are not checked.

    Parameters
    ----------
    simple_types : dict of str to frozenset of type
        Fields that contain text, booleans or None, with their permitted types.
    readers : dict of str to Reader
    """

    simple_types: dict[str, frozenset[type]]
    readers: dict[str, Reader]


def encode_fields(values: Mapping[str, Any], nested_fields: NestedFields) -> PlainValues:
    """Return the values of the fields as JSON values."""
    plain_items: PlainValues = {}
    for name, value in values.items():
        if name in nested_fields.parts and dataclasses.is_dataclass(value):
            plain_items[name] = dataclasses.asdict(typing.cast(Any, value))
        elif name in nested_fields.lists:
            plain_items[name] = [dataclasses.asdict(item) for item in value]
        else:
            plain_items[name] = value
    return plain_items


def decode_fields(cls: type, values: Mapping[str, Any], nested_fields: NestedFields) -> PlainValues:
    """Convert JSON values to the values of the fields of a class.

    Raises
    ------
    DocumentError
        If a value does not have the type of its field; the message names the field.
    """
    decoded_values: PlainValues = {}
    types_by_field, readers = field_types(cls)
    for name, value in values.items():
        permitted_types = types_by_field.get(name)
        if permitted_types is not None:
            if type(value) not in permitted_types:
                raise wrong_value_error(name)
            decoded_values[name] = value
        elif name in readers:
            decoded_values[name] = _read_field(readers[name], name, value)
        elif value is None and name in _optional_fields(cls):
            decoded_values[name] = None
        elif name in nested_fields.parts and value is not None:
            decoded_values[name] = _decode_object(
                nested_fields.parts[name], name, value, nested_fields
            )
        elif name in nested_fields.lists and isinstance(value, list):
            item = nested_fields.lists[name]
            decoded_values[name] = tuple(
                _decode_object(item, name, item_value, nested_fields) for item_value in value
            )
        elif name in nested_fields.parts or name in nested_fields.lists:
            raise wrong_value_error(name)
        else:
            decoded_values[name] = _to_tuples(value)
    return decoded_values


def known_fields(cls: type, values: Mapping[str, Any], kind: str) -> PlainValues:
    """Return the values if all their names are fields of a class.

    Raises
    ------
    DocumentError
        With the code ``record.unknown-field``.
    """
    unknown_names = values.keys() - _fields(cls)
    if unknown_names:
        raise DocumentError(
            Finding("record.unknown-field", kind=kind), field=sorted(unknown_names)[0]
        )
    return dict(values)


def wrong_value_error(name: str) -> DocumentError:
    """Return the error for a value that is not valid for a field."""
    return DocumentError(Finding("record.wrong-value"), field=name)


@lru_cache(maxsize=64)
def field_types(cls: type) -> FieldTypes:
    """Return the permitted types and readers of a class's fields from their annotations."""
    types_by_field: dict[str, frozenset[type]] = {}
    readers: dict[str, Reader] = {}
    for name, annotation in typing.get_type_hints(cls).items():
        is_union = isinstance(annotation, types.UnionType)
        options = typing.get_args(annotation) if is_union else (annotation,)
        if set(options) <= {str, bool, types.NoneType}:
            types_by_field[name] = frozenset(options)
        else:
            reader = _union_reader(options)
            if reader is not None:
                readers[name] = reader
    return FieldTypes(types_by_field, readers)


@lru_cache(maxsize=64)
def _fields(cls: type) -> frozenset[str]:
    return frozenset(field.name for field in dataclasses.fields(cls))


@lru_cache(maxsize=64)
def _optional_fields(cls: type) -> frozenset[str]:
    return frozenset(field.name for field in dataclasses.fields(cls) if field.default is None)


def _read_field(read: Reader, name: str, value: Any) -> Any:
    try:
        return read(value)
    except ValueError as error:
        raise wrong_value_error(name) from error


def _decode_object(cls: type, name: str, value: Any, nested_fields: NestedFields) -> Any:
    if not isinstance(value, Mapping):
        raise wrong_value_error(name)
    try:
        return cls(**decode_fields(cls, known_fields(cls, value, cls.__name__), nested_fields))
    except TypeError as error:
        raise DocumentError(
            Finding("record.missing-field", error=error, kind=cls.__name__), field=name
        ) from error


def _are_rows_of_numbers(values: list[Any]) -> bool:
    return set(map(type, values)) == {list} and set(map(type, chain(*values))) <= _NUMBERS


def _to_tuples(value: Any) -> Any:
    if isinstance(value, list | tuple):
        if value and type(value[0]) is list and _are_rows_of_numbers(list(value)):
            return tuple(map(tuple, value))
        # Coordinates make up most of a journal, so numbers are not visited one by one.
        return tuple([_to_tuples(v) if isinstance(v, list | tuple) else v for v in value])
    return value


def _union_reader(options: tuple[Any, ...]) -> Reader | None:
    readers = {option: _value_reader(option) for option in options if option is not types.NoneType}
    if len(readers) != 1 or None in readers.values():
        return None
    (read,) = readers.values()
    if types.NoneType not in options:
        return read
    return lambda value: None if value is None else typing.cast(Reader, read)(value)


def _value_reader(annotation: Any) -> Reader | None:
    origin, type_arguments = typing.get_origin(annotation), typing.get_args(annotation)
    if annotation is float:
        return _read_number
    if annotation is int:
        return _read_integer
    if annotation is str:
        return _read_text
    if origin is typing.Literal:
        return _choice_reader(type_arguments)
    if origin is not tuple:
        return None
    if type_arguments[-1:] == (Ellipsis,):
        count, kinds = None, {type_arguments[0]}
    else:
        count, kinds = len(type_arguments), set(type_arguments)
    if len(kinds) != 1:
        return None
    (kind,) = kinds
    width = typing.get_args(kind)
    if typing.get_origin(kind) is tuple and set(width) <= {float, Ellipsis}:
        return _rows_reader(count, None if Ellipsis in width else len(width))
    read = _value_reader(kind)
    return None if read is None else _list_reader(count, read)


def _read_number(value: Any) -> float | int:
    if type(value) not in _NUMBERS or not -_MAX_NUMBER < value < _MAX_NUMBER:
        raise ValueError
    return typing.cast(float, value)


def _read_integer(value: Any) -> int:
    if type(value) is not int or abs(value) >= 2**62:
        raise ValueError
    return value


def _read_text(value: Any) -> str:
    if type(value) is not str:
        raise ValueError
    return value


def _choice_reader(words: tuple[Any, ...]) -> Reader:
    known_words = frozenset(words)

    def read(value: Any) -> Any:
        if type(value) is not str or value not in known_words:
            raise ValueError
        return value

    return read


def _list_reader(count: int | None, item_reader: Reader) -> Reader:
    def read(value: Any) -> tuple[Any, ...]:
        if not isinstance(value, list | tuple) or (count is not None and len(value) != count):
            raise ValueError
        return tuple(map(item_reader, value))

    return read


def _rows_reader(count: int | None, width: int | None) -> Reader:
    """Return the reader for rows of numbers (vertices), which make up most of a journal."""

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
            value_sum = sum(chain.from_iterable(value))
        except OverflowError:
            raise ValueError from None
        # A sum that includes NaN is NaN.
        if not -math.inf < value_sum < math.inf:
            raise ValueError
        return tuple(map(tuple, value))

    return read
