"""Arrays on their way from one process to another: no pickles, which would be programs."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from vomstudio.core.arrays import AnyArray

_LENGTH = struct.Struct("<Q")


def packed(header: Mapping[str, Any], arrays: Sequence[AnyArray | None]) -> bytes:
    """Of plain data and arrays (n,) of numbers, dates, bytes or texts; None among objects stays."""
    parts = [_block(json.dumps(header).encode())]
    for array in arrays:
        given = np.empty(0, np.object_) if array is None else np.asarray(array)
        if given.dtype != np.object_:
            parts += [_block(given.dtype.str.encode()), _block(np.ascontiguousarray(given).data)]
        elif all(value is None or isinstance(value, bytes) for value in given):
            sizes = np.array([-1 if value is None else len(value) for value in given], np.int64)
            parts += [_block(b"bytes"), _block(sizes.data)]
            parts.append(_block(b"".join(value for value in given if value is not None)))
        else:
            said = [None if v is None or isinstance(v, bytes) else v for v in given.tolist()]
            parts += [_block(b"texts"), _block(json.dumps(said, default=str).encode())]
    return b"".join(parts)


def unpacked(data: bytes) -> tuple[dict[str, Any], Iterator[AnyArray]]:
    """What `packed` was given."""
    blocks = _blocks(memoryview(data))
    return json.loads(bytes(next(blocks))), _arrays(blocks)


def _arrays(blocks: Iterator[memoryview]) -> Iterator[AnyArray]:
    for kind in blocks:
        name = bytes(kind).decode()
        if name == "bytes":
            sizes, whole = np.frombuffer(next(blocks), np.int64), next(blocks)
            found = np.empty(len(sizes), np.object_)
            at = 0
            for i, size in enumerate(sizes.tolist()):
                if size >= 0:
                    found[i] = bytes(whole[at : at + size])
                    at += size
            yield found
        elif name == "texts":
            values = json.loads(bytes(next(blocks)))
            found = np.empty(len(values), np.object_)
            found[:] = values
            yield found
        else:
            yield np.frombuffer(next(blocks), np.dtype(name)).copy()


def _block(data: bytes | memoryview) -> bytes:
    held = bytes(data)
    return _LENGTH.pack(len(held)) + held


def _blocks(data: memoryview) -> Iterator[memoryview]:
    at = 0
    while at < len(data):
        (size,) = _LENGTH.unpack_from(data, at)
        at += _LENGTH.size
        yield data[at : at + size]
        at += size
