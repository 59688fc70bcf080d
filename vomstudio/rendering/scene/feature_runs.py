"""Arrays of the lines and discs of all features for the graphics card."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from itertools import compress

import numpy as np

from vomstudio.core.arrays import BoolArray, ByteArray, Float32Array, FloatArray, IntArray
from vomstudio.rendering.prepare import vtk_data
from vomstudio.rendering.scene.area_layer import area_box
from vomstudio.rendering.view.drawing import FeatureDrawing

BLOCK_SIZE = 128


@dataclass(frozen=True, eq=False)
class Runs:
    """Sequences of points, such as polylines or rings.

    Parameters
    ----------
    points : (n, 3) float32
        Points minus the scene origin.
    sizes : (m,) int
        Number of points of each run.
    colors : (n, 3) uint8
    """

    points: Float32Array
    sizes: IntArray
    colors: ByteArray

    @classmethod
    def of(
        cls, runs: list[FloatArray], colors: list[tuple[float, float, float]], origin: FloatArray
    ) -> Runs:
        """Create runs from points (k, 3) in the World frame, with one colour per run."""
        sizes = np.array([len(run) for run in runs], np.int64)
        points = np.concatenate([np.zeros((0, 3)), *runs]) - origin
        rgb_by_color = {color: vtk_data.rgb(color) for color in set(colors)}
        rgb = np.array([rgb_by_color[color] for color in colors], np.uint8).reshape(-1, 3)
        return cls(points.astype(np.float32), sizes, np.repeat(rgb, sizes, axis=0))

    @classmethod
    def concatenate(cls, parts: Iterable[Runs]) -> Runs:
        """Concatenate runs."""
        all_runs = [Runs.of([], [], np.zeros(3)), *parts]
        return cls(
            np.concatenate([part.points for part in all_runs]),
            np.concatenate([part.sizes for part in all_runs]),
            np.concatenate([part.colors for part in all_runs]),
        )


def simplify(runs: Runs, spacings: FloatArray) -> Runs:
    """Remove vertices that are close to their predecessors, keeping the ends of each run.

    Parameters
    ----------
    runs : Runs
        Runs of at least two points each.
    spacings : (n,) float64
        Length of line, at each point, along which one vertex remains.
    """
    if not len(runs.sizes):
        return runs
    ends = np.cumsum(runs.sizes)
    starts = ends - runs.sizes
    lengths = np.zeros(len(runs.points))
    lengths[1:] = np.linalg.norm(np.diff(runs.points.astype(np.float64), axis=0), axis=1)
    lengths[1:] /= spacings[1:]
    lengths[starts] = 0.0
    numbers = np.floor(np.cumsum(lengths))
    is_kept = np.ones(len(numbers), np.bool_)
    is_kept[1:] = numbers[1:] != numbers[:-1]
    is_kept[starts] = is_kept[ends - 1] = True
    return Runs(
        runs.points[is_kept], np.add.reduceat(is_kept, starts, dtype=np.int64), runs.colors[is_kept]
    )


@dataclass(frozen=True, eq=False)
class _Block:
    """Cached arrays for a block of features.

    Parameters
    ----------
    drawings : list of FeatureDrawing
        Visible drawings of the block.
    boxes : (n, 2, 3) float64
        Minimum and maximum World corners of each feature's line and disc; NaN if it has neither.
    box : (2, 3) or (0, 3) float64
        Bounding box of all features in the block, including their areas.
    """

    drawings: list[FeatureDrawing]
    lines: Runs
    discs: Runs
    boxes: FloatArray
    box: FloatArray


class FeatureRuns:
    """Runs of features in blocks, so that a change rebuilds only a single block."""

    def __init__(self) -> None:
        self._origin: FloatArray = np.zeros(3)
        self._blocks: list[dict[str, FeatureDrawing]] = []
        self._block_by_feature: dict[str, int] = {}
        self._built_blocks: dict[int, _Block] = {}

    def set_origin(self, origin: FloatArray) -> None:
        """Set the origin (3,), in the World frame, that is subtracted from all points."""
        self._origin = origin
        self._built_blocks.clear()

    def change(self, changes: Mapping[str, FeatureDrawing | None]) -> None:
        """Add or replace drawings, and remove those with the value None."""
        for key, drawing in changes.items():
            block_number = self._block_by_feature.get(key)
            if block_number is None and drawing is None:
                continue
            if block_number is None:
                if not self._blocks or len(self._blocks[-1]) >= BLOCK_SIZE:
                    self._blocks.append({})
                block_number = self._block_by_feature[key] = len(self._blocks) - 1
            self._built_blocks.pop(block_number, None)
            if drawing is None:
                del self._blocks[block_number][key], self._block_by_feature[key]
            else:
                self._blocks[block_number][key] = drawing
        if not self._block_by_feature:
            self._blocks.clear()
            self._built_blocks.clear()

    @property
    def points(self) -> int:
        """Total number of points of the visible lines."""
        return sum(len(block.lines.points) for block in self._all_blocks())

    def lines(self) -> Runs:
        """Return the lines of the visible features."""
        return Runs.concatenate(block.lines for block in self._all_blocks())

    def discs(self) -> Runs:
        """Return the discs of the visible features."""
        return Runs.concatenate(block.discs for block in self._all_blocks())

    def visible_runs(self, is_needed: Callable[[FloatArray], BoolArray]) -> tuple[Runs, Runs]:
        """Return the lines and discs of the visible features selected by their boxes.

        `is_needed` receives World boxes (n, 2, 3), as minimum and maximum corners.
        """
        selected_drawings = self._select_drawings(is_needed)
        return line_runs(selected_drawings, self._origin), disc_runs(
            selected_drawings, self._origin
        )

    def line_runs_by_id(
        self,
        ids: frozenset[str],
        is_needed: Callable[[FloatArray], BoolArray] | None = None,
    ) -> Runs:
        """Return the lines of the visible features `ids`, by default without a spatial filter."""
        drawings = [drawing for drawing in self._select_drawings(is_needed) if drawing.id in ids]
        return line_runs(drawings, self._origin)

    def _select_drawings(
        self, is_needed: Callable[[FloatArray], BoolArray] | None
    ) -> list[FeatureDrawing]:
        blocks = self._all_blocks()
        drawings = [drawing for item in blocks for drawing in item.drawings]
        if is_needed is None:
            return drawings
        boxes = np.concatenate([np.zeros((0, 2, 3)), *(item.boxes for item in blocks)])
        return list(compress(drawings, is_needed(boxes).tolist()))

    def box(self) -> FloatArray:
        """Return the bounds (2, 3) of the visible features, or (0, 3) if no feature is visible."""
        boxes = np.concatenate([np.zeros((0, 3)), *(block.box for block in self._all_blocks())])
        return boxes if not len(boxes) else np.stack([boxes.min(axis=0), boxes.max(axis=0)])

    def _all_blocks(self) -> list[_Block]:
        for number, block in enumerate(self._blocks):
            if number not in self._built_blocks:
                self._built_blocks[number] = self._make([d for d in block.values() if d.visible])
        return [self._built_blocks[number] for number in range(len(self._blocks))]

    def _make(self, drawings: list[FeatureDrawing]) -> _Block:
        boxes = _bounding_boxes([spots(drawing) for drawing in drawings])
        areas = [area_box(d.area)[None] for d in drawings if d.area is not None]
        all_boxes = np.concatenate([boxes, *areas])
        all_boxes = all_boxes[np.isfinite(all_boxes).all(axis=(1, 2))]
        box = np.zeros((0, 3))
        if len(all_boxes):
            box = np.stack([all_boxes[:, 0].min(axis=0), all_boxes[:, 1].max(axis=0)])
        return _Block(
            drawings,
            line_runs(drawings, self._origin),
            disc_runs(drawings, self._origin),
            boxes,
            box,
        )


def spots(drawing: FeatureDrawing) -> FloatArray:
    """Return the World points (n, 3) of the line and disc of a drawing."""
    line = np.asarray(drawing.line, float).reshape(-1, 3)
    if drawing.disc is None:
        return line
    return np.concatenate([line, np.asarray(drawing.disc, float)])


def _bounding_boxes(runs: list[FloatArray]) -> FloatArray:
    """Return the bounding box (n, 2, 3) of each run, NaN if the run is empty."""
    boxes = np.full((len(runs), 2, 3), np.nan)
    sizes = np.array([len(run) for run in runs], np.int64)
    filled_rows = np.flatnonzero(sizes)
    if len(filled_rows):
        points = np.concatenate(runs)
        starts = (np.cumsum(sizes) - sizes)[filled_rows]
        # Non-finite points are ignored, unless a run has no finite points.
        points[~np.isfinite(points).all(axis=1)] = np.nan
        boxes[filled_rows, 0] = np.fmin.reduceat(points, starts, axis=0)
        boxes[filled_rows, 1] = np.fmax.reduceat(points, starts, axis=0)
    return boxes


def line_runs(drawings: list[FeatureDrawing], origin: FloatArray) -> Runs:
    """Return the lines of all drawings whose line has at least two points.

    The outlines of discs that are not filled are included.
    """
    lines = [(np.asarray(d.line, float).reshape(-1, 3), d.color) for d in drawings]
    lines += [
        (_close_ring(d.disc), d.color) for d in drawings if d.is_outlined and d.disc is not None
    ]
    return _runs([(line, color) for line, color in lines if len(line) >= 2], origin)


def disc_runs(drawings: list[FeatureDrawing], origin: FloatArray) -> Runs:
    """Return the filled discs of all drawings whose disc has at least three corners."""
    rings = [
        (np.asarray(d.disc, float), d.color)
        for d in drawings
        if d.disc is not None and not d.is_outlined
    ]
    return _runs([(ring, color) for ring, color in rings if len(ring) >= 3], origin)


def _close_ring(ring: FloatArray) -> FloatArray:
    points = np.asarray(ring, float).reshape(-1, 3)
    return np.concatenate([points, points[:1]])


def _runs(parts: list[tuple[FloatArray, tuple[float, float, float]]], origin: FloatArray) -> Runs:
    return Runs.of([points for points, _ in parts], [color for _, color in parts], origin)
