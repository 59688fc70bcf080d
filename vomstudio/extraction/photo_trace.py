"""Trace followed in a photo, the result of `vomstudio trace --photo` and `vs.follow`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.results import HIDDEN_IN_JSON
from vomstudio.core.words import tr
from vomstudio.extraction.best_cost import AUTO, CostTrial, select_best_path
from vomstudio.extraction.calibrated_photos import CalibratedPhotos
from vomstudio.extraction.followed_trace import (
    MAX_SNAP_RESOLUTIONS,
    FollowedTrace,
    fit_trace_plane,
    index_vertices,
    require_on_model,
)
from vomstudio.extraction.path_costs import COLOUR_COSTS
from vomstudio.extraction.path_jumps import find_jumps
from vomstudio.extraction.photo_following import PhotoFollower, PhotoPath
from vomstudio.extraction.surface_graph import SurfaceGraph
from vomstudio.geology.doubtful_stretches import fit_remaining_plane
from vomstudio.geology.plane_bands import SetPrior
from vomstudio.geology.profiles import DEFAULT_THRESHOLDS, Thresholds

# If fewer vertices are confirmed, the line is reported as doubtful.
_MIN_CONFIRMED_SHARE = 0.8
# A step that exceeds both limits (in median steps and in resolutions) crosses a gap that is not
# visible in the photo.
_MAX_STEP_RATIO, _MIN_GAP_RESOLUTIONS = 10.0, 2.0


@dataclass(frozen=True, eq=False, repr=False)
class PhotoTrace(FollowedTrace):
    """Trace that was followed in a photo.

    Parameters
    ----------
    photo : str
    voters : tuple of str
        Names of the other photos with which the trace was compared.
    agreeing_share : float or None
        Share of the vertices visible in other photos that are confirmed by at least half of these
        photos; None if no vertex is visible in other photos.
    pixels : (n, 2) array
        Vertices in the photo; the centre of the top-left pixel is (0.5, 0.5).
    seen, agreeing : (n,) int arrays
        Number of other photos in which each vertex is visible, and number of those that confirm it.
    """

    photo: str
    voters: tuple[str, ...]
    agreeing_share: float | None
    pixels: FloatArray = field(repr=False, metadata=HIDDEN_IN_JSON)
    seen: IntArray = field(repr=False, metadata=HIDDEN_IN_JSON)
    agreeing: IntArray = field(repr=False, metadata=HIDDEN_IN_JSON)


def photo_trace(
    surface: SurfaceGraph,
    photos: CalibratedPhotos,
    way_points: FloatArray,
    *,
    cost: str,
    resolution: float,
    model: str,
    frame: str,
    thresholds: Thresholds = DEFAULT_THRESHOLDS,
    priors: Sequence[SetPrior] = (),
    name: str = "",
) -> PhotoTrace:
    """Follow a contact in a photo and fit its plane.

    Parameters
    ----------
    surface : SurfaceGraph
        Surface of a model in the World frame.
    photos : CalibratedPhotos
    way_points : (w, 3) or (w, 2) array
        Way-points in the World frame, m, or in pixels of the photo.
    cost : str
        One of `COLOUR_COSTS`, or "auto" for the best of them.
    resolution : float
        Resolution of the model, m.
    model, frame : str
        Names used in the orientation table.
    thresholds : Thresholds
    priors : sequence of SetPrior
    name : str
        Name of the cost in the result; by default, `cost`.

    Returns
    -------
    PhotoTrace

    Raises
    ------
    GeometryError
        If there are fewer than two distinct way-points, or if one of them is outside the model or
        the photo, or hidden in the photo.
    UsageError
        If the cost is not available for photos.
    InputError
        If a photo cannot be read.
    """
    marks = np.asarray(way_points, np.float64)
    follower = PhotoFollower(photos, COLOUR_COSTS[0] if cost == AUTO else cost)
    has_world_points = marks.shape[1] == 3
    if has_world_points:
        require_on_model(surface, marks, resolution)
        pixels = _project_way_points(photos, marks, resolution)
    else:
        pixels = marks
    vertices = index_vertices(surface)
    trials: tuple[CostTrial, ...] = ()
    if cost == AUTO:
        path, cost, trials = select_best_path(
            COLOUR_COSTS,
            lambda one: follower.with_cost(one).follow(pixels),
            vertices.local_resolution,
            vertices.outcrop_normal,
            lambda one: find_jumps(
                one.points,
                one.costs,
                one.way_point_rows,
                vertices.local_resolution(one.points) or 0.0,
            ),
        )
    else:
        path = follower.follow(pixels)
    cost = name or cost
    snap_targets = marks if has_world_points else follower.project(pixels)
    notes = tr(
        "followed through {count} way-points in the photo {photo}, using the cost {cost}",
        count=len(marks),
        cost=cost,
        photo=photos.name,
    )
    local_resolution = vertices.local_resolution(path.points) or 0.0
    remaining_trace = fit_remaining_plane(
        path.points, find_jumps(path.points, path.costs, path.way_point_rows, local_resolution)
    )
    plane, band, plane_warnings = fit_trace_plane(
        path.points,
        vertices,
        model=model,
        frame=frame,
        thresholds=thresholds,
        notes=notes,
        priors=priors,
        remaining_trace=remaining_trace,
    )
    steps = np.linalg.norm(np.diff(path.points, axis=0), axis=1)
    confirmed_share = _confirmed_share(path)
    path_warnings = _path_warnings(path, steps, confirmed_share, resolution)
    return PhotoTrace(
        points=path.points,
        length_m=float(steps.sum()),
        snap_m=float(np.linalg.norm(path.points[path.way_point_rows] - snap_targets, axis=1).max()),
        plane=plane,
        band=band,
        way_points=len(marks),
        cost=cost,
        vertices=len(path.points),
        warnings=(
            *photos.warnings,
            *path.warnings,
            *plane_warnings,
            *path_warnings,
        ),
        photo=photos.name,
        voters=path.voters,
        agreeing_share=confirmed_share,
        pixels=path.pixels,
        seen=path.seen,
        agreeing=path.agreeing,
        tried=trials,
        doubtful=() if remaining_trace is None else remaining_trace.stretches,
    )


def _project_way_points(
    photos: CalibratedPhotos, way_points: FloatArray, resolution: float
) -> FloatArray:
    """Project way-points from the World frame into the photo and return pixels (w, 2).

    Raises
    ------
    GeometryError
        If a way-point is not visible in the photo.
    """
    pixels = photos.views.pixels(photos.view_row, way_points)
    is_visible = photos.views.shows(photos.view_row, way_points, MAX_SNAP_RESOLUTIONS * resolution)
    for row in np.flatnonzero(~is_visible).tolist():
        raise GeometryError(Finding("path.not-shown", photo=photos.name, number=row + 1))
    return pixels


def _confirmed_share(path: PhotoPath) -> float | None:
    return path.confirmed_count / path.judged_count if path.judged_count else None


def _path_warnings(
    path: PhotoPath, steps: FloatArray, confirmed_share: float | None, resolution: float
) -> list[Finding]:
    warnings = []
    if path.missed_count:
        warnings.append(Finding("path.pixels-beside-model", count=path.missed_count))
    min_gap_m = max(_MAX_STEP_RATIO * float(np.median(steps)), _MIN_GAP_RESOLUTIONS * resolution)
    if gap_count := int((steps > min_gap_m).sum()):
        warnings.append(Finding("path.hidden-rock", count=gap_count, gap_m=float(steps.max())))
    if confirmed_share is not None and confirmed_share < _MIN_CONFIRMED_SHARE:
        warnings.append(Finding("path.unconfirmed", share_percent=100.0 * confirmed_share))
    return warnings
