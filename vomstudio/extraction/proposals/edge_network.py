"""Edges as a network of the user's finds them in a picture: a local ONNX file, by OpenCV's dnn.

The file takes one picture, (1, 3, height, width) red, green and blue from 0 to 1 (or one channel of
grey), and gives the probability of an edge at each pixel, (1, 1, height, width). Of another size
than its own pictures are cut into tiles that overlap, of which the middles are kept.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from vomstudio.core.arrays import ByteArray, Float32Array
from vomstudio.core.errors import InputError
from vomstudio.core.files.memory_limit import limit_for_file
from vomstudio.core.files.regular import read_small
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import tr
from vomstudio.extraction.proposals.onnx_head import Head, head_of

_MOST_BYTES = 1 << 29
_TILE = 512
# Of a tile, so much on each side is another one's; less where a network has small tiles of its own.
_MARGIN = 64
_LEAST_SIDE, _MOST_SIDE = 16, 4096
_SLACK = 1e-3
_GREY = np.array([0.299, 0.587, 0.114], np.float32)


class EdgeNetwork:
    """path : of the file. Raises InputError for what is no such network."""

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        try:
            raw = read_small(self.path, _MOST_BYTES)
        except OSError as error:
            raise self._refused(Finding("file.unreadable", reason=error)) from error
        try:
            head = head_of(raw)
        except ValueError as error:
            raise self._refused(Finding("file.other-format", format="ONNX")) from error
        self.channels, self._sides = self._taken(head)
        self._net = self._loaded(raw)

    def probability(self, picture: ByteArray, progress: Progress) -> Float32Array:
        """(h, w) of each pixel of a picture (h, w, 3). Raises InputError where the network answers
        something else, Cancelled."""
        height, width = picture.shape[:2]
        tall, wide = self._tile(0, height), self._tile(1, width)
        up, left = _margin(tall, height), _margin(wide, width)
        found = np.empty((height, width), np.float32)
        rows, columns = _starts(height, tall, up), _starts(width, wide, left)
        done = 0
        progress.stage(tr("Detecting edges"), len(rows) * len(columns))
        for row in rows:
            for column in columns:
                progress.step(done)
                done += 1
                part = picture[row : row + tall, column : column + wide]
                answer = self._answer(part, tall, wide)
                # Nearer to the border of a tile than its margin another tile knows better.
                first = 0 if row == 0 else up
                begin = 0 if column == 0 else left
                high, broad = part.shape[:2]
                found[row + first : row + high, column + begin : column + broad] = answer[
                    first:high, begin:broad
                ]
        return found

    # --- the file ----------------------------------------------------------------------------
    def _taken(self, head: Head) -> tuple[int, tuple[int | None, int | None]]:
        """Channels, and height and width where they are its own."""
        if len(head.inputs) != 1 or len(head.outputs) != 1:
            raise self._refused(
                Finding(
                    "network.inputs-outputs",
                    inputs=len(head.inputs),
                    outputs=len(head.outputs),
                )
            )
        (shape,) = head.inputs
        if len(shape) != 4 or shape[0] not in (1, None) or shape[1] not in (1, 3, None):
            raise self._refused(
                Finding(
                    "network.input-shape",
                    shape=" x ".join("?" if side is None else str(side) for side in shape) or "?",
                )
            )
        for side in shape[2:]:
            if side is not None and not _LEAST_SIDE <= side <= _MOST_SIDE:
                raise self._refused(
                    Finding(
                        "network.input-size",
                        side=side,
                        minimum=_LEAST_SIDE,
                        maximum=_MOST_SIDE,
                    )
                )
        return shape[1] or 3, (shape[2], shape[3])

    def _loaded(self, raw: bytes) -> object:
        import cv2

        try:
            with limit_for_file(self.path):
                net = cv2.dnn.readNetFromONNX(np.frombuffer(raw, np.uint8))
        except (cv2.error, MemoryError) as error:
            raise self._refused(Finding("network.not-loaded", reason=_reason(error))) from error
        return net

    def _answer(self, part: ByteArray, tall: int, wide: int) -> Float32Array:
        """(tall, wide) for a part of a picture, which may be smaller."""
        import cv2

        high, broad = part.shape[:2]
        full = cv2.copyMakeBorder(
            np.ascontiguousarray(part), 0, tall - high, 0, wide - broad, cv2.BORDER_REPLICATE
        )
        values = full.astype(np.float32) / 255.0
        blob = (values @ _GREY)[None] if self.channels == 1 else values.transpose(2, 0, 1)
        try:
            with limit_for_file(self.path):
                self._net.setInput(np.ascontiguousarray(blob[None]))  # type: ignore[attr-defined]
                given = np.asarray(self._net.forward())  # type: ignore[attr-defined]
        except (cv2.error, MemoryError) as error:
            raise self._refused(
                Finding("network.failed", width=wide, height=tall, reason=_reason(error))
            ) from error
        if given.size != tall * wide or given.shape[-2:] != (tall, wide):
            raise self._refused(
                Finding(
                    "network.output-shape",
                    shape=" x ".join(map(str, given.shape)),
                    width=wide,
                    height=tall,
                )
            )
        answer = given.reshape(tall, wide).astype(np.float32)
        if not np.isfinite(answer).all():
            raise self._refused(Finding("network.not-finite"))
        low, top = float(answer.min()), float(answer.max())
        if low < -_SLACK or top > 1.0 + _SLACK:
            raise self._refused(Finding("network.not-probabilities", low=low, high=top))
        return np.clip(answer, 0.0, 1.0)

    def _tile(self, axis: int, size: int) -> int:
        """A side of the tiles: the network's own, or one that a small picture fits into, a multiple
        of 32 as networks that halve the picture want it."""
        own = self._sides[axis]
        return own if own is not None else min(_TILE, 32 * -(-size // 32))

    def _refused(self, finding: Finding) -> InputError:
        return InputError(finding, file=self.path)


def _margin(tile: int, size: int) -> int:
    return 0 if tile >= size else min(_MARGIN, tile // 4)


def _starts(size: int, tile: int, margin: int) -> list[int]:
    """Where tiles begin, each overlapping the last one by two margins."""
    if tile >= size:
        return [0]
    starts = list(range(0, size - tile, tile - 2 * margin))
    return [*starts, size - tile]


def _reason(error: BaseException) -> str:
    """The last words of OpenCV's message."""
    said = " ".join(str(error).split()) or tr("not enough memory")
    return said.rpartition("error: ")[2][:160]
