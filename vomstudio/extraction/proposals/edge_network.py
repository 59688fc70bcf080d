"""Edge detection in pictures by a local ONNX network, run by the dnn module of OpenCV.

The input is a single picture, (1, 3, height, width), with red, green and blue from 0 to 1 (or one
grey channel). The output is the edge probability of each pixel, (1, 1, height, width). A picture
whose size differs from the input size of the network is divided into overlapping tiles, and only
the central part of each tile is used.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from vomstudio.core.arrays import ByteArray, Float32Array
from vomstudio.core.errors import InputError
from vomstudio.core.files.memory_limit import limit_for_file
from vomstudio.core.files.regular import read_small_file
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import tr
from vomstudio.extraction.proposals.onnx_head import NetworkShapes, read_shapes

_MAX_BYTES = 1 << 29
_TILE_PX = 512
# Overlap on each side of a tile; smaller if the network has small fixed tiles.
_MARGIN_PX = 64
_MIN_SIDE_PX, _MAX_SIDE_PX = 16, 4096
_PROBABILITY_TOLERANCE = 1e-3
_GREY_WEIGHTS = np.array([0.299, 0.587, 0.114], np.float32)


class EdgeNetwork:
    """Network that detects edges in pictures.

    Parameters
    ----------
    path : str or Path
        ONNX file.

    Raises
    ------
    InputError
        If the file does not contain a suitable network.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        try:
            raw = read_small_file(self.path, _MAX_BYTES)
        except OSError as error:
            raise self._error(Finding("file.unreadable", reason=error)) from error
        try:
            shapes = read_shapes(raw)
        except ValueError as error:
            raise self._error(Finding("file.other-format", format="ONNX")) from error
        self.channels, self._input_sizes = self._check_shapes(shapes)
        self._network = self._load_network(raw)

    def compute_probability(self, picture: ByteArray, progress: Progress) -> Float32Array:
        """Compute the edge probability of each pixel.

        Parameters
        ----------
        picture : (h, w, 3) uint8 array
        progress : Progress

        Returns
        -------
        (h, w) float32 array

        Raises
        ------
        InputError
            If the network fails or its output is invalid.
        Cancelled
            Through `progress`.
        """
        height, width = picture.shape[:2]
        total_height, total_width = self._tile_size(0, height), self._tile_size(1, width)
        top_margin, left_margin = _margin(total_height, height), _margin(total_width, width)
        probabilities = np.empty((height, width), np.float32)
        rows, columns = (
            _tile_starts(height, total_height, top_margin),
            _tile_starts(width, total_width, left_margin),
        )
        done_count = 0
        progress.stage(tr("Detecting edges"), len(rows) * len(columns))
        for row in rows:
            for column in columns:
                progress.step(done_count)
                done_count += 1
                part = picture[row : row + total_height, column : column + total_width]
                output = self._run(part, total_height, total_width)
                # Within the margin, the adjacent tile is more reliable.
                first_row = 0 if row == 0 else top_margin
                first_column = 0 if column == 0 else left_margin
                part_height, part_width = part.shape[:2]
                probabilities[
                    row + first_row : row + part_height, column + first_column : column + part_width
                ] = output[first_row:part_height, first_column:part_width]
        return probabilities

    # --- the file ----------------------------------------------------------------------------
    def _check_shapes(self, header: NetworkShapes) -> tuple[int, tuple[int | None, int | None]]:
        """Return the number of channels, and the height and width if they are fixed."""
        if len(header.inputs) != 1 or len(header.outputs) != 1:
            raise self._error(
                Finding(
                    "network.inputs-outputs",
                    inputs=len(header.inputs),
                    outputs=len(header.outputs),
                )
            )
        (shape,) = header.inputs
        if len(shape) != 4 or shape[0] not in (1, None) or shape[1] not in (1, 3, None):
            raise self._error(
                Finding(
                    "network.input-shape",
                    shape=" x ".join("?" if side is None else str(side) for side in shape) or "?",
                )
            )
        for side in shape[2:]:
            if side is not None and not _MIN_SIDE_PX <= side <= _MAX_SIDE_PX:
                raise self._error(
                    Finding(
                        "network.input-size",
                        side=side,
                        minimum=_MIN_SIDE_PX,
                        maximum=_MAX_SIDE_PX,
                    )
                )
        return shape[1] or 3, (shape[2], shape[3])

    def _load_network(self, raw_bytes: bytes) -> object:
        import cv2

        try:
            with limit_for_file(self.path):
                net = cv2.dnn.readNetFromONNX(np.frombuffer(raw_bytes, np.uint8))
        except (cv2.error, MemoryError) as error:
            raise self._error(Finding("network.not-loaded", reason=_reason(error))) from error
        return net

    def _run(self, part: ByteArray, height: int, width: int) -> Float32Array:
        """Run the network on a part of a picture, padded to (height, width)."""
        import cv2

        part_height, part_width = part.shape[:2]
        padded_picture = cv2.copyMakeBorder(
            np.ascontiguousarray(part),
            0,
            height - part_height,
            0,
            width - part_width,
            cv2.BORDER_REPLICATE,
        )
        values = padded_picture.astype(np.float32) / 255.0
        blob = (values @ _GREY_WEIGHTS)[None] if self.channels == 1 else values.transpose(2, 0, 1)
        try:
            with limit_for_file(self.path):
                self._network.setInput(np.ascontiguousarray(blob[None]))  # type: ignore[attr-defined]
                output = np.asarray(self._network.forward())  # type: ignore[attr-defined]
        except (cv2.error, MemoryError) as error:
            raise self._error(
                Finding("network.failed", width=width, height=height, reason=_reason(error))
            ) from error
        if output.size != height * width or output.shape[-2:] != (height, width):
            raise self._error(
                Finding(
                    "network.output-shape",
                    shape=" x ".join(map(str, output.shape)),
                    width=width,
                    height=height,
                )
            )
        network_output = output.reshape(height, width).astype(np.float32)
        if not np.isfinite(network_output).all():
            raise self._error(Finding("network.not-finite"))
        low, top = float(network_output.min()), float(network_output.max())
        if low < -_PROBABILITY_TOLERANCE or top > 1.0 + _PROBABILITY_TOLERANCE:
            raise self._error(Finding("network.not-probabilities", low=low, high=top))
        return np.clip(network_output, 0.0, 1.0)

    def _tile_size(self, axis: int, size: int) -> int:
        """Return the size of the tiles: the size required by the network, or a multiple of 32."""
        fixed_side = self._input_sizes[axis]
        return fixed_side if fixed_side is not None else min(_TILE_PX, 32 * -(-size // 32))

    def _error(self, finding: Finding) -> InputError:
        return InputError(finding, file=self.path)


def _margin(tile: int, size: int) -> int:
    return 0 if tile >= size else min(_MARGIN_PX, tile // 4)


def _tile_starts(size: int, tile: int, margin: int) -> list[int]:
    """Return the starts of tiles that overlap the previous tile by at least two margins."""
    if tile >= size:
        return [0]
    starts = list(range(0, size - tile, tile - 2 * margin))
    return [*starts, size - tile]


def _reason(error: BaseException) -> str:
    """Return the last part of an OpenCV error message."""
    message = " ".join(str(error).split()) or tr("not enough memory")
    return message.rpartition("error: ")[2][:160]
