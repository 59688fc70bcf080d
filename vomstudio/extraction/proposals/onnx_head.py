"""Inputs and outputs of an ONNX file, read without the weights.

Only the part of the public schema (onnx.proto, IR version 8) that contains the names and shapes of
the inputs and outputs of a network is decoded.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

_GRAPH_FIELD = 7
_INITIALIZER_FIELD, _INPUT_FIELD, _OUTPUT_FIELD = 5, 11, 12
_TENSOR_NAME_FIELD = 8


@dataclass(frozen=True)
class NetworkShapes:
    """Shapes of the inputs and outputs; None represents a variable dimension.

    Inputs to which the file itself assigns values are not included.
    """

    inputs: tuple[tuple[int | None, ...], ...]
    outputs: tuple[tuple[int | None, ...], ...]


def read_shapes(raw_bytes: bytes) -> NetworkShapes:
    """Read the shapes of the inputs and outputs of an ONNX file.

    Raises
    ------
    ValueError
        If the bytes do not represent an ONNX file.
    """
    graphs = [value for field, value in _iterate_fields(raw_bytes) if field == _GRAPH_FIELD]
    if len(graphs) != 1 or not isinstance(graphs[0], memoryview):
        raise ValueError("no graph")
    initializer_names = set[bytes]()
    inputs, outputs = [], []
    for field, value in _iterate_fields(graphs[0]):
        if not isinstance(value, memoryview):
            continue
        if field == _INITIALIZER_FIELD:
            initializer_names |= {
                bytes(v)
                for f, v in _iterate_fields(value)
                if f == _TENSOR_NAME_FIELD and isinstance(v, memoryview)
            }
        elif field == _INPUT_FIELD:
            inputs.append((_read_field(value, 1), _read_shape(value)))
        elif field == _OUTPUT_FIELD:
            outputs.append(_read_shape(value))
    return NetworkShapes(
        tuple(shape for name, shape in inputs if bytes(name or b"") not in initializer_names),
        tuple(outputs),
    )


def _read_shape(info: memoryview) -> tuple[int | None, ...]:
    """Return the dimensions of a ValueInfoProto (type, tensor_type, shape)."""
    position: memoryview | None = info
    for field in (2, 1, 2):
        position = None if position is None else _read_field(position, field)
    if position is None:
        return ()
    sides: list[int | None] = []
    for field, dim in _iterate_fields(position):
        if field == 1 and isinstance(dim, memoryview):
            sizes = [
                value for f, value in _iterate_fields(dim) if f == 1 and isinstance(value, int)
            ]
            sides.append(sizes[0] if sizes and 0 < sizes[0] < 1 << 31 else None)
    return tuple(sides)


def _read_field(message: memoryview, number: int) -> memoryview | None:
    for field, value in _iterate_fields(message):
        if field == number and isinstance(value, memoryview):
            return value
    return None


def _iterate_fields(message: bytes | memoryview) -> Iterator[tuple[int, int | memoryview]]:
    """Yield the field numbers and values of a message.

    Raises
    ------
    ValueError
        If the bytes do not represent a message.
    """
    view, position = memoryview(message), 0
    while position < len(view):
        key, position = _read_varint(view, position)
        field, wire_type = key >> 3, key & 7
        if wire_type == 0:
            value, position = _read_varint(view, position)
            yield field, value
            continue
        if wire_type == 2:
            size, position = _read_varint(view, position)
        elif wire_type in (1, 5):
            size = 8 if wire_type == 1 else 4
        else:
            raise ValueError("no message")
        if field == 0 or position + size > len(view):
            raise ValueError("no message")
        yield field, view[position : position + size]
        position += size


def _read_varint(view: memoryview, position: int) -> tuple[int, int]:
    value = shift = 0
    while position < len(view) and shift < 64:
        byte = view[position]
        position += 1
        value |= (byte & 0x7F) << shift
        if byte < 0x80:
            return value, position
        shift += 7
    raise ValueError("no message")
