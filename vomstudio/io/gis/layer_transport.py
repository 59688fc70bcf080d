"""Serialisation of arrays between processes without pickle, which could execute code."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from vomstudio.core.arrays import AnyArray

_LENGTH_FORMAT = struct.Struct("<Q")


def pack(header: Mapping[str, Any], arrays: Sequence[AnyArray | None]) -> bytes:
    """Serialise plain data and arrays.

    Parameters
    ----------
    header : mapping
    arrays : sequence of (n,) array or None
        Numbers, bytes or text; None values among objects are preserved, and dates become text.
    """
    parts = [_block(json.dumps(header).encode())]
    for array in arrays:
        values = np.empty(0, np.object_) if array is None else np.asarray(array)
        if values.dtype.kind in "mM":
            values = values.astype(np.str_).astype(np.object_)
        if values.dtype != np.object_:
            parts += [_block(values.dtype.str.encode()), _block(np.ascontiguousarray(values).data)]
        elif all(value is None or isinstance(value, bytes) for value in values):
            sizes = np.array([-1 if value is None else len(value) for value in values], np.int64)
            parts += [_block(b"bytes"), _block(sizes.data)]
            parts.append(_block(b"".join(value for value in values if value is not None)))
        else:
            texts = [
                None if value is None or isinstance(value, bytes) else value
                for value in values.tolist()
            ]
            parts += [_block(b"texts"), _block(json.dumps(texts, default=str).encode())]
    return b"".join(parts)


def unpack(data: bytes) -> tuple[dict[str, Any], Iterator[AnyArray]]:
    """Return the header and the arrays that `pack` has serialised."""
    blocks = _blocks(memoryview(data))
    return json.loads(bytes(next(blocks))), _arrays(blocks)


def _arrays(blocks: Iterator[memoryview]) -> Iterator[AnyArray]:
    for kind in blocks:
        name = bytes(kind).decode()
        if name == "bytes":
            sizes, content = np.frombuffer(next(blocks), np.int64), next(blocks)
            array = np.empty(len(sizes), np.object_)
            offset = 0
            for i, size in enumerate(sizes.tolist()):
                if size >= 0:
                    array[i] = bytes(content[offset : offset + size])
                    offset += size
            yield array
        elif name == "texts":
            values = json.loads(bytes(next(blocks)))
            array = np.empty(len(values), np.object_)
            array[:] = values
            yield array
        else:
            yield np.frombuffer(next(blocks), np.dtype(name)).copy()


def _block(data: bytes | memoryview) -> bytes:
    content = bytes(data)
    return _LENGTH_FORMAT.pack(len(content)) + content


def _blocks(data: memoryview) -> Iterator[memoryview]:
    offset = 0
    while offset < len(data):
        (size,) = _LENGTH_FORMAT.unpack_from(data, offset)
        offset += _LENGTH_FORMAT.size
        yield data[offset : offset + size]
        offset += size
