"""What an ONNX file takes and gives, without its weights: as much of the public schema (onnx.proto,
version 8 of the IR) as names the inputs and outputs of a network with their shapes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

_GRAPH = 7
_INITIALIZER, _INPUT, _OUTPUT = 5, 11, 12
_NAME_OF_TENSOR = 8


@dataclass(frozen=True)
class Head:
    """inputs, outputs : their shapes, None where a side is free or not told; those that the file
    itself gives values are no inputs"""

    inputs: tuple[tuple[int | None, ...], ...]
    outputs: tuple[tuple[int | None, ...], ...]


def head_of(raw: bytes) -> Head:
    """Raises ValueError for what is no ONNX file."""
    graphs = [value for field, value in _fields(raw) if field == _GRAPH]
    if len(graphs) != 1 or not isinstance(graphs[0], memoryview):
        raise ValueError("no graph")
    given = set[bytes]()
    inputs, outputs = [], []
    for field, value in _fields(graphs[0]):
        if not isinstance(value, memoryview):
            continue
        if field == _INITIALIZER:
            given |= {
                bytes(v)
                for f, v in _fields(value)
                if f == _NAME_OF_TENSOR and isinstance(v, memoryview)
            }
        elif field == _INPUT:
            inputs.append((_part(value, 1), _shape(value)))
        elif field == _OUTPUT:
            outputs.append(_shape(value))
    return Head(
        tuple(shape for name, shape in inputs if bytes(name or b"") not in given), tuple(outputs)
    )


def _shape(info: memoryview) -> tuple[int | None, ...]:
    """Of a ValueInfoProto: type, tensor_type, shape, its dims."""
    at: memoryview | None = info
    for field in (2, 1, 2):
        at = None if at is None else _part(at, field)
    if at is None:
        return ()
    sides: list[int | None] = []
    for field, dim in _fields(at):
        if field == 1 and isinstance(dim, memoryview):
            told = [value for f, value in _fields(dim) if f == 1 and isinstance(value, int)]
            sides.append(told[0] if told and 0 < told[0] < 1 << 31 else None)
    return tuple(sides)


def _part(message: memoryview, wanted: int) -> memoryview | None:
    for field, value in _fields(message):
        if field == wanted and isinstance(value, memoryview):
            return value
    return None


def _fields(message: bytes | memoryview) -> Iterator[tuple[int, int | memoryview]]:
    """Numbers and values of a message's fields. Raises ValueError where it is none."""
    view, at = memoryview(message), 0
    while at < len(view):
        key, at = _varint(view, at)
        field, kind = key >> 3, key & 7
        if kind == 0:
            value, at = _varint(view, at)
            yield field, value
            continue
        if kind == 2:
            size, at = _varint(view, at)
        elif kind in (1, 5):
            size = 8 if kind == 1 else 4
        else:
            raise ValueError("no message")
        if field == 0 or at + size > len(view):
            raise ValueError("no message")
        yield field, view[at : at + size]
        at += size


def _varint(view: memoryview, at: int) -> tuple[int, int]:
    value = shift = 0
    while at < len(view) and shift < 64:
        byte = view[at]
        at += 1
        value |= (byte & 0x7F) << shift
        if byte < 0x80:
            return value, at
        shift += 7
    raise ValueError("no message")
