"""Comparison of a model from the sample's photos with the outcrop that they show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate
from vomstudio.geology.quality import total_error_deg
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.planes import fit_planes
from vomstudio.geometry.rotation_errors import errors_95_deg
from vomstudio.io.photos.cameras_file import Cameras
from vomstudio.products.sample.check import Check, plane_check
from vomstudio.project.sample import SamplePicks, SampleTruth

# Maximum distance of a model point, in ground sampling distances.
_MAX_DISTANCE_GSD = 4.0
_MIN_POINTS = 20
MODEL_OFFSET = to_translate("distance of model from outcrop, median")
MODEL_OFFSET_90 = to_translate("distance of model from outcrop, 90th percentile")
OUTCROP_OFFSET = to_translate("distance of outcrop from model, median")
CAMERA_CENTRES = to_translate("camera centre error, median")
_SAMPLE_POINTS = 40_000


def check_photos(
    estimated_cameras: Cameras,
    true_cameras: Cameras,
    cloud: FloatArray,
    outcrop: Mesh,
    picks: SamplePicks,
    truth: SampleTruth,
    gsd: float,
    rotation: FloatArray | None = None,
) -> tuple[Check, ...]:
    """Compare a model with the outcrop that its photos show.

    Parameters
    ----------
    estimated_cameras, true_cameras : Cameras
        Reconstructed cameras, and the true cameras of the photos.
    cloud : (n, 3) array
        Dense points in the World frame, m.
    outcrop : Mesh
        True surface in the World frame, m.
    picks : SamplePicks
    truth : SampleTruth
    gsd : float
        Ground sampling distance of the depth maps, m.
    rotation : (3, 3) array, optional
        Covariance of the rotation of the model due to its registration, for the total errors of
        planes.
    """
    from scipy.spatial import cKDTree

    shift = np.array(true_cameras.origin, np.float64)
    points = cloud - shift
    surface, normals = _sample_surface(outcrop, shift)
    # The photos also show the surroundings of the outcrop.
    low, high = surface.min(axis=0) - 0.2, surface.max(axis=0) + 0.2
    inner_points = points[((points > low) & (points < high)).all(axis=1)]
    distance, nearest_rows = cKDTree(surface).query(
        inner_points[:: max(1, len(inner_points) // _SAMPLE_POINTS)]
    )
    sample = inner_points[:: max(1, len(inner_points) // _SAMPLE_POINTS)]
    # Only the distance perpendicular to the surface counts, not that to the next point along it.
    offset = np.abs(((sample - surface[nearest_rows]) * normals[nearest_rows]).sum(axis=1))
    offset = np.where(distance < 0.25, offset, distance)
    tree = cKDTree(inner_points)
    visible_surface = surface[_are_visible(true_cameras, surface, normals)]
    outcrop_distances, _ = tree.query(visible_surface)
    return (
        _camera_check(estimated_cameras, true_cameras),
        _length(MODEL_OFFSET, float(np.median(offset))),
        _length(MODEL_OFFSET_90, float(np.percentile(offset, 90))),
        _length(OUTCROP_OFFSET, float(np.median(outcrop_distances))),
        *_plane_checks(inner_points, tree, picks, truth, shift, gsd, rotation),
    )


def photo_findings(checks: Sequence[Check]) -> tuple[Finding, ...]:
    """Report the errors of the model that was reconstructed from photos."""
    checks_by_name = {check.name: check for check in checks}
    stated_checks = [check for check in checks if check.within_total is not None]
    within_count = sum(bool(check.within_total) for check in stated_checks)
    worst_error = max((check.error for check in stated_checks), default=0.0)
    offset_mm, cameras = (
        1000 * checks_by_name[name].error for name in (MODEL_OFFSET, CAMERA_CENTRES)
    )
    return (
        Finding("sample.photo-model", model_mm=offset_mm, cameras_mm=cameras),
        Finding(
            "sample.photo-planes",
            held=within_count,
            count=len(stated_checks),
            worst_deg=worst_error,
        ),
    )


def _length(name: str, value: float) -> Check:
    return Check(name, 0.0, value, value, None, None, "m")


def _camera_check(estimated_cameras: Cameras, true_cameras: Cameras) -> Check:
    """Compare camera centres by their median distance."""
    positions = {view.name: view.centre + true_cameras.origin for view in true_cameras.views}
    distances = [
        float(np.linalg.norm(view.centre + estimated_cameras.origin - positions[view.name]))
        for view in estimated_cameras.views
        if view.name in positions
    ]
    return _length(CAMERA_CENTRES, float(np.median(distances)))


def _sample_surface(mesh: Mesh, shift: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Sample points on the faces in proportion to area, with their normals."""
    corners = mesh.vertices[mesh.faces] - shift
    cross_axis = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(cross_axis, axis=1)
    rng = np.random.default_rng(0)
    sample = rng.choice(len(corners), 4 * _SAMPLE_POINTS, p=size / size.sum())
    b = rng.random((len(sample), 2))
    is_folded = b.sum(axis=1) > 1
    b[is_folded] = 1 - b[is_folded]
    a = corners[sample]
    points = a[:, 0] + b[:, :1] * (a[:, 1] - a[:, 0]) + b[:, 1:] * (a[:, 2] - a[:, 0])
    return points, cross_axis[sample] / size[sample, None]


def _are_visible(cameras: Cameras, points: FloatArray, normals: FloatArray) -> BoolArray:
    """Return which points (n,) face at least three cameras and are within their photos.

    Occlusion is ignored.
    """
    count = np.zeros(len(points), int)
    for view in cameras.views:
        pixels = view.project(points)
        with np.errstate(invalid="ignore"):
            is_facing = ((view.centre - points) * normals).sum(axis=1) > 0
            count += is_facing & view.contains(pixels)
    return count >= 3


def _plane_checks(
    points: FloatArray,
    tree: Any,
    picks: SamplePicks,
    truth: SampleTruth,
    shift: FloatArray,
    gsd: float,
    rotation: FloatArray | None,
) -> list[Check]:
    """Measure every pick of the sample on the model, and compare it with the true plane."""
    checks = []
    for i, (name, kind) in enumerate(zip(picks.names, picks.kinds, strict=True)):
        distance, nearest_rows = tree.query(picks.of(i) - shift)
        nearby_rows = nearest_rows[distance < _MAX_DISTANCE_GSD * gsd]
        # Keep the order along the trace, in which the errors of neighbours are correlated.
        nearby_rows = nearby_rows[np.sort(np.unique(nearby_rows, return_index=True)[1])]
        if len(nearby_rows) < _MIN_POINTS or name not in truth.planes:
            continue
        fit = fit_planes(points[nearby_rows], np.array([0, len(nearby_rows)]))[0]
        check = plane_check(f"{kind} {name} on the photos' model", fit, truth.planes[name])
        registration_error_deg = None
        if rotation is not None:
            registration_error_deg = float(errors_95_deg(rotation, fit.normal)[0])
        total_deg = total_error_deg(fit, gsd, registration_deg=registration_error_deg)
        checks.append(replace(check, total_95=total_deg))
    return checks
