"""Lines and discs of all features one after the other, as arrays for the graphics card."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from itertools import compress

import numpy as np

from vomstudio.core.arrays import BoolArray, ByteArray, Float32Array, FloatArray, IntArray
from vomstudio.rendering.prepare import vtk_data
from vomstudio.rendering.scene.area_layer import area_box
from vomstudio.rendering.view.drawing import FeatureDrawing

_BLOCK = 128


@dataclass(frozen=True, eq=False)
class Runs:
    """points : (n, 3) float32 off the origin; sizes : (m,) points of each run; colors : (n, 3)"""

    points: Float32Array
    sizes: IntArray
    colors: ByteArray

    @classmethod
    def of(
        cls, runs: list[FloatArray], colors: list[tuple[float, float, float]], origin: FloatArray
    ) -> Runs:
        """Runs (k, 3) in World, each in one colour."""
        sizes = np.array([len(run) for run in runs], np.int64)
        points = np.concatenate([np.zeros((0, 3)), *runs]) - origin
        known = {color: vtk_data.rgb(color) for color in set(colors)}
        rgb = np.array([known[color] for color in colors], np.uint8).reshape(-1, 3)
        return cls(points.astype(np.float32), sizes, np.repeat(rgb, sizes, axis=0))

    @classmethod
    def joined(cls, parts: Iterable[Runs]) -> Runs:
        """One after the other."""
        every = [Runs.of([], [], np.zeros(3)), *parts]
        return cls(
            np.concatenate([part.points for part in every]),
            np.concatenate([part.sizes for part in every]),
            np.concatenate([part.colors for part in every]),
        )


@dataclass(frozen=True, eq=False)
class _Made:
    """shown : the visible drawings of a block; boxes : (n, 2, 3) lowest and highest World corner of
    the line and disc of each, NaN where it has neither; box : (2, 3) around them and their areas,
    or (0, 3)"""

    shown: list[FeatureDrawing]
    lines: Runs
    discs: Runs
    boxes: FloatArray
    box: FloatArray


class FeatureRuns:
    """Kept in blocks in the order in which the features came, so that a change of one among
    thousands leaves the arrays of all other blocks as they are."""

    def __init__(self) -> None:
        self._origin: FloatArray = np.zeros(3)
        self._blocks: list[dict[str, FeatureDrawing]] = []
        self._home: dict[str, int] = {}
        self._made: dict[int, _Made] = {}

    def set_origin(self, origin: FloatArray) -> None:
        """(3,) World, what points are counted from."""
        self._origin = origin
        self._made.clear()

    def change(self, changes: Mapping[str, FeatureDrawing | None]) -> None:
        """Add, replace or (None) remove drawings."""
        for key, drawing in changes.items():
            home = self._home.get(key)
            if home is None and drawing is None:
                continue
            if home is None:
                if not self._blocks or len(self._blocks[-1]) >= _BLOCK:
                    self._blocks.append({})
                home = self._home[key] = len(self._blocks) - 1
            self._made.pop(home, None)
            if drawing is None:
                del self._blocks[home][key], self._home[key]
            else:
                self._blocks[home][key] = drawing
        if not self._home:
            self._blocks.clear()
            self._made.clear()

    @property
    def points(self) -> int:
        """Of the lines of the visible ones."""
        return sum(len(made.lines.points) for made in self._all())

    def lines(self) -> Runs:
        """Of the visible ones."""
        return Runs.joined(made.lines for made in self._all())

    def discs(self) -> Runs:
        """Of the visible ones."""
        return Runs.joined(made.discs for made in self._all())

    def some(self, wanted: Callable[[FloatArray], BoolArray]) -> tuple[Runs, Runs]:
        """Lines and discs of the visible ones whose boxes are wanted, in the order of all. wanted :
        of boxes (n, 2, 3), lowest and highest World corner, which"""
        made = self._all()
        boxes = np.concatenate([np.zeros((0, 2, 3)), *(each.boxes for each in made)])
        every = (drawing for each in made for drawing in each.shown)
        found = list(compress(every, wanted(boxes).tolist()))
        return lines_of(found, self._origin), discs_of(found, self._origin)

    def box(self) -> FloatArray:
        """(2, 3) lowest and highest World corner of what is visible, (0, 3) where nothing is."""
        boxes = np.concatenate([np.zeros((0, 3)), *(made.box for made in self._all())])
        return boxes if not len(boxes) else np.stack([boxes.min(axis=0), boxes.max(axis=0)])

    def _all(self) -> list[_Made]:
        for number, block in enumerate(self._blocks):
            if number not in self._made:
                self._made[number] = self._make([d for d in block.values() if d.visible])
        return [self._made[number] for number in range(len(self._blocks))]

    def _make(self, shown: list[FeatureDrawing]) -> _Made:
        boxes = _boxes_of([spots(drawing) for drawing in shown])
        areas = [area_box(d.area)[None] for d in shown if d.area is not None]
        every = np.concatenate([boxes, *areas])
        every = every[np.isfinite(every).all(axis=(1, 2))]
        box = np.zeros((0, 3))
        if len(every):
            box = np.stack([every[:, 0].min(axis=0), every[:, 1].max(axis=0)])
        return _Made(
            shown, lines_of(shown, self._origin), discs_of(shown, self._origin), boxes, box
        )


def spots(drawing: FeatureDrawing) -> FloatArray:
    """(n, 3) World points of the line and the disc of a drawing."""
    line = np.asarray(drawing.line, float).reshape(-1, 3)
    if drawing.disc is None:
        return line
    return np.concatenate([line, np.asarray(drawing.disc, float)])


def _boxes_of(runs: list[FloatArray]) -> FloatArray:
    """(n, 2, 3) lowest and highest corner of each run of points; NaN without points."""
    boxes = np.full((len(runs), 2, 3), np.nan)
    sizes = np.array([len(run) for run in runs], np.int64)
    filled = np.flatnonzero(sizes)
    if len(filled):
        points = np.concatenate(runs)
        starts = (np.cumsum(sizes) - sizes)[filled]
        # A point that is not finite is none, unless a run has no other.
        points[~np.isfinite(points).all(axis=1)] = np.nan
        boxes[filled, 0] = np.fmin.reduceat(points, starts, axis=0)
        boxes[filled, 1] = np.fmax.reduceat(points, starts, axis=0)
    return boxes


def lines_of(shown: list[FeatureDrawing], origin: FloatArray) -> Runs:
    """The lines of drawings, of at least two points."""
    lines = [(np.asarray(d.line, float).reshape(-1, 3), d.color) for d in shown]
    return _runs([(line, color) for line, color in lines if len(line) >= 2], origin)


def discs_of(shown: list[FeatureDrawing], origin: FloatArray) -> Runs:
    """The discs of drawings, of at least three corners."""
    rings = [(np.asarray(d.disc, float), d.color) for d in shown if d.disc is not None]
    return _runs([(ring, color) for ring, color in rings if len(ring) >= 3], origin)


def _runs(parts: list[tuple[FloatArray, tuple[float, float, float]]], origin: FloatArray) -> Runs:
    return Runs.of([points for points, _ in parts], [color for _, color in parts], origin)
