"""Brush stroke, from pressing to releasing the button."""

from __future__ import annotations

import contextlib
import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from vomstudio.core.arrays import BoolArray, Float32Array, FloatArray, IntArray
from vomstudio.core.errors import VomError
from vomstudio.geometry import transform
from vomstudio.geometry.brush import SelectableSurface
from vomstudio.geometry.heights.bends import measure_bend
from vomstudio.geometry.heights.levels import level_gap
from vomstudio.geometry.moment_planes import fit_moments
from vomstudio.geometry.patches import Moments, ids_to_runs, moments, outline
from vomstudio.project.records import SURROUNDINGS_RULE, Model
from vomstudio.studio.tools.interaction_types import Area, Hit
from vomstudio.studio.tools.painted_area import MAX_DOTS, local_corners

# Maximum share of a stroke's duration that is spent on live measurements.
MAX_LIVE_SHARE = 0.3
QUICK_FIT_S = 0.01


@dataclass(eq=False)
class Stroke:
    """Brush stroke that adds elements to a selection or erases them.

    Parameters
    ----------
    is_selected : (n,) bool
        Faces or points of the model that are selected.
    stroke_corners : list of float32 arrays
        Corners of the added or erased faces, or every `stride`-th added or erased point.
    is_quick : bool
        Whether the search tree of the surface exists, so that the resolution is available
        immediately.
    """

    model: Model
    surface: SelectableSurface
    is_removing: bool
    is_selected: BoolArray
    scale: float
    origin: FloatArray
    resolution: float | None
    is_quick: bool
    stroke_corners: list[Float32Array] = field(default_factory=list)
    stride: int = 1
    count: int = 0
    measured_count: int = 0
    next_measurement_time: float = 0.0

    @classmethod
    def begin(
        cls,
        hit: Hit,
        model: Model,
        surface: SelectableSurface,
        is_selected: BoolArray,
        *,
        is_removing: bool,
    ) -> Stroke:
        """Start a stroke that changes a copy of `is_selected` (n,) under the brush."""
        start_time = time.perf_counter()
        spacing = surface.local_resolution(np.array([hit.position]))
        # Until the search tree exists, live measurements use a single point.
        is_quick = time.perf_counter() - start_time < QUICK_FIT_S
        return cls(
            model,
            surface,
            is_removing,
            is_selected.copy(),
            transform.scale_factor(model.to_world),
            transform.apply(model.to_world, [hit.position])[0],
            spacing,
            is_quick,
        )

    def paint(self, hit: Hit, radius: float) -> None:
        """Add or erase the connected elements within `radius`, in metres, of a hit."""
        ids = self.surface.connected_ids_in_ball(hit.index, hit.position, radius / self.scale)
        ids = ids[self.is_selected[ids] == self.is_removing]
        if not len(ids):
            return
        self.is_selected[ids] = not self.is_removing
        self.count += len(ids)
        self.stroke_corners.append(
            local_corners(self.surface.corners(ids[:: self.stride]), self.model, self.origin)
        )

    def ids(self) -> IntArray:
        """Return the indices (k,) of the selected faces or points."""
        return np.flatnonzero(self.is_selected)

    def figures(self, ids: IntArray, *, is_whole: bool) -> dict[str, Any]:
        """Return the fields for measuring a patch of `ids`, or all its fields if `is_whole`."""
        if is_whole:
            return patch_fields(self.surface, ids)
        points, weights = self.surface.weighted_points(ids)
        figures = _moments_and_area(self.surface, ids, points, moments(points, weights))
        spacing = self.surface.local_resolution(points) if self.is_quick else self.resolution
        return {**figures, "resolution": spacing}

    # --- live measurement ---------------------------------------------------------------------
    def is_due(self, now: float) -> bool:
        """Return whether a live measurement is due because the selection has changed."""
        return self.count != self.measured_count and now >= self.next_measurement_time

    def record_measurement(self, start_time: float) -> None:
        """Schedule the next live measurement; slow measurements are made less often."""
        current_time, self.measured_count = time.perf_counter(), self.count
        self.next_measurement_time = current_time + (current_time - start_time) * (
            1.0 / MAX_LIVE_SHARE - 1.0
        )

    def area(self) -> Area | None:
        """Return the area of the stroke for drawing, or None if it is empty."""
        if not self.stroke_corners:
            return None
        if len(self.stroke_corners) > 1:
            self.stroke_corners = [np.concatenate(self.stroke_corners)]
        if self.surface.element == "point" and len(self.stroke_corners[0]) > 2 * MAX_DOTS:
            self.stroke_corners = [self.stroke_corners[0][::2]]
            self.stride *= 2
        return Area(self.origin, self.stroke_corners[0], np.zeros((0, 2, 3), np.float32))


def patch_fields(surface: SelectableSurface, ids: IntArray) -> dict[str, Any]:
    """Return the fields of a patch, derived from the ids (k,) of its faces or points."""
    points, weights = surface.weighted_points(ids)
    patch_moments = moments(points, weights)
    ring: tuple[Any, ...] = ()
    with contextlib.suppress(VomError):
        ring = outline(
            points, fit_moments(patch_moments.n, patch_moments.mean, patch_moments.scatter).normal
        )
    return {
        **_moments_and_area(surface, ids, points, patch_moments),
        "runs": ids_to_runs(ids),
        "outline": ring,
        "resolution": surface.local_resolution(points),
    }


def _moments_and_area(
    surface: SelectableSurface,
    ids: IntArray,
    points: FloatArray,
    patch_moments: Moments,
) -> dict[str, Any]:
    normal = np.linalg.eigh(np.asarray(patch_moments.scatter))[1][:, 0]
    return {
        "n": patch_moments.n,
        "mean": patch_moments.mean,
        "scatter": patch_moments.scatter,
        "n_effective": patch_moments.n_effective,
        "area": surface.selected_area(ids),
        "rule": SURROUNDINGS_RULE,
        "bent": False,
        "level_gap": level_gap(points, normal),
        "bend_deg": measure_bend(points, normal),
    }
