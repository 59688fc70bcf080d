"""A stroke of the brush, from press to release."""

from __future__ import annotations

import contextlib
import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from vomstudio.core.arrays import BoolArray, Float32Array, FloatArray, IntArray
from vomstudio.core.errors import VomError
from vomstudio.geometry import transform
from vomstudio.geometry.brush import PaintSurface
from vomstudio.geometry.heights.bends import bend_of
from vomstudio.geometry.heights.levels import level_gap
from vomstudio.geometry.moment_planes import fit_moments
from vomstudio.geometry.patches import Moments, moments, outline, runs_of
from vomstudio.project.records import SURROUNDINGS_RULE, Model, Painted
from vomstudio.studio.tools.interaction_types import Area, Hit
from vomstudio.studio.tools.painted_area import DOTS, known_ids, local_corners

# Live figures may take this part of the time of a stroke.
_LIVE_SHARE = 0.3
_QUICK_S = 0.01


@dataclass(eq=False)
class Stroke:
    """What one stroke of the brush adds to a patch or erases from it.

    chosen : (n,) whether each face or point of the model is in the patch
    touched : corners of what has been added or erased, as drawn; of points every `stride`-th
    quick : the surface's search tree stands, so that its resolution is known at once
    """

    model: Model
    surface: PaintSurface
    removes: bool
    chosen: BoolArray
    scale: float
    origin: FloatArray
    resolution: float | None
    quick: bool
    touched: list[Float32Array] = field(default_factory=list)
    stride: int = 1
    count: int = 0
    measured: int = 0
    measured_until: float = 0.0

    @classmethod
    def begin(
        cls, hit: Hit, model: Model, surface: PaintSurface, patch: Painted | None, *, removes: bool
    ) -> Stroke:
        """Start a stroke where the brush first meets a surface. patch : the one to change."""
        chosen = np.zeros(surface.count, np.bool_)
        if patch is not None:
            chosen[known_ids(patch, surface.count)] = True
        started = time.perf_counter()
        spacing = surface.resolution_near(np.array([hit.position]))
        # Until the search tree stands, one point has to do for the live figures.
        quick = time.perf_counter() - started < _QUICK_S
        return cls(
            model,
            surface,
            removes,
            chosen,
            transform.scale_of(model.to_world),
            transform.apply(model.to_world, [hit.position])[0],
            spacing,
            quick,
        )

    def paint(self, hit: Hit, radius: float) -> None:
        """Add or erase what lies within `radius`, in metres, of a hit."""
        ids = self.surface.within(hit.index, hit.position, radius / self.scale)
        ids = ids[self.chosen[ids] == self.removes]
        if not len(ids):
            return
        self.chosen[ids] = not self.removes
        self.count += len(ids)
        self.touched.append(
            local_corners(self.surface.corners(ids[:: self.stride]), self.model, self.origin)
        )

    def ids(self) -> IntArray:
        """(k,) indices of the faces or points in the patch now."""
        return np.flatnonzero(self.chosen)

    def figures(self, ids: IntArray, *, whole: bool) -> dict[str, Any]:
        """The fields of a patch that follow from its ids, by name; `whole` with those that only a
        record needs."""
        if whole:
            return record_figures(self.surface, ids)
        points, weights = self.surface.weighted(ids)
        figures = _moments_and_area(self.surface, ids, points, moments(points, weights))
        spacing = self.surface.resolution_near(points) if self.quick else self.resolution
        return {**figures, "resolution": spacing}

    # --- live figures ------------------------------------------------------------------------
    def due(self, now: float) -> bool:
        """Whether the live figures should be computed: the patch has changed, and there is time."""
        return self.count != self.measured and now >= self.measured_until

    def note_measured(self, started: float) -> None:
        """It has just been measured; the longer that took, the later it is done again."""
        now, self.measured = time.perf_counter(), self.count
        self.measured_until = now + (now - started) * (1.0 / _LIVE_SHARE - 1.0)

    def area(self) -> Area | None:
        """What it has touched, as it is drawn."""
        if not self.touched:
            return None
        if len(self.touched) > 1:
            self.touched = [np.concatenate(self.touched)]
        if self.surface.element == "point" and len(self.touched[0]) > 2 * DOTS:
            self.touched = [self.touched[0][::2]]
            self.stride *= 2
        return Area(self.origin, self.touched[0], np.zeros((0, 2, 3), np.float32))


def record_figures(surface: PaintSurface, ids: IntArray) -> dict[str, Any]:
    """The fields of a patch that follow from the ids (k,) of its faces or points, by name."""
    points, weights = surface.weighted(ids)
    known = moments(points, weights)
    ring: tuple[Any, ...] = ()
    with contextlib.suppress(VomError):
        ring = outline(points, fit_moments(known.n, known.mean, known.scatter).normal)
    return {
        **_moments_and_area(surface, ids, points, known),
        "runs": runs_of(ids),
        "outline": ring,
        "resolution": surface.resolution_near(points),
    }


def _moments_and_area(
    surface: PaintSurface,
    ids: IntArray,
    points: FloatArray,
    known: Moments,
) -> dict[str, Any]:
    normal = np.linalg.eigh(np.asarray(known.scatter))[1][:, 0]
    return {
        "n": known.n,
        "mean": known.mean,
        "scatter": known.scatter,
        "n_effective": known.n_effective,
        "area": surface.area_of(ids),
        "rule": SURROUNDINGS_RULE,
        "bent": False,
        "level_gap": level_gap(points, normal),
        "bend_deg": bend_of(points, normal),
    }
