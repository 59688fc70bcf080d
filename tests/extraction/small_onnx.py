"""Tiny ONNX files, written byte by byte after the public schema (onnx.proto3, version 8 of the IR):
what a network answers is then known in closed form."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def _varint(value: int) -> bytes:
    value &= (1 << 64) - 1
    result = bytearray()
    while True:
        low, value = value & 0x7F, value >> 7
        result.append(low | (0x80 if value else 0))
        if not value:
            return bytes(result)


def _int(field: int, value: int) -> bytes:
    return _varint(field << 3) + _varint(value)


def _bytes(field: int, value: bytes | str) -> bytes:
    raw = value.encode() if isinstance(value, str) else value
    return _varint(field << 3 | 2) + _varint(len(raw)) + raw


def _tensor(name: str, values: np.ndarray) -> bytes:
    dims = b"".join(_int(1, d) for d in values.shape)
    return dims + _int(2, 1) + _bytes(8, name) + _bytes(9, values.astype("<f4").tobytes())


def _value(name: str, dims: Sequence[int | str]) -> bytes:
    shape = b"".join(_bytes(1, _int(1, d) if isinstance(d, int) else _bytes(2, d)) for d in dims)
    return _bytes(1, name) + _bytes(2, _bytes(1, _int(1, 1) + _bytes(2, shape)))


def _node(op: str, inputs: Sequence[str], outputs: Sequence[str], attributes: bytes = b"") -> bytes:
    return (
        b"".join(_bytes(1, i) for i in inputs)
        + b"".join(_bytes(2, o) for o in outputs)
        + _bytes(3, f"{op}_{outputs[0]}")
        + _bytes(4, op)
        + attributes
    )


def _ints(name: str, values: Sequence[int]) -> bytes:
    return _bytes(5, _bytes(1, name) + b"".join(_int(8, v) for v in values) + _int(20, 7))


def convolution(
    weights: np.ndarray,
    bias: float = 0.0,
    *,
    after: Sequence[str] = (),
    size: tuple[int | str, int | str] = ("h", "w"),
    pads: int | None = None,
) -> bytes:
    """A network of one convolution, weights (out, in, k, k), and functions of a value after it."""
    out, channels, k, _ = weights.shape
    pad = k // 2 if pads is None else pads
    nodes = [
        _node(
            "Conv",
            ["picture", "weights", "bias"],
            ["c0"],
            _ints("kernel_shape", [k, k]) + _ints("pads", [pad] * 4) + _ints("strides", [1, 1]),
        )
    ]
    last = "c0"
    for number, op in enumerate(after, 1):
        nodes.append(_node(op, [last], [f"c{number}"]))
        last = f"c{number}"
    graph = (
        b"".join(_bytes(1, n) for n in nodes)
        + _bytes(2, "small")
        + _bytes(5, _tensor("weights", weights))
        + _bytes(5, _tensor("bias", np.full(out, bias)))
        + _bytes(11, _value("picture", [1, channels, *size]))
        + _bytes(12, _value(last, [1, out, *size]))
    )
    return _int(1, 8) + _bytes(7, graph) + _bytes(8, _bytes(1, "") + _int(2, 13))
