"""The model made of the sample's photos, compared with the outcrop that they show."""

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

# What lies within so many ground sampling distances of the model is in it.
_NEAR_GSD = 4.0
_FEWEST = 20
MODEL_OFFSET = to_translate("model off the outcrop, median")
MODEL_OFFSET_90 = to_translate("model off the outcrop, 90 %")
OUTCROP_OFFSET = to_translate("outcrop off the model, median")
CAMERA_CENTRES = to_translate("camera centres, median")
_DRAWN = 40_000


def check_photos(
    found: Cameras,
    true: Cameras,
    cloud: FloatArray,
    outcrop: Mesh,
    picks: SamplePicks,
    truth: SampleTruth,
    gsd: float,
    rotation: FloatArray | None = None,
) -> tuple[Check, ...]:
    """Compare a model with the outcrop that its photos show.

    found, true : cameras of the reconstruction, and those that took the photos
    cloud : (n, 3) dense points in World
    outcrop : the true surface in World
    gsd : ground sampling distance of the depth maps, m
    rotation : (3, 3) covariance of the model's rotation by its registration, which the total errors
        of planes hold; None where it is not known
    """
    from scipy.spatial import cKDTree

    shift = np.array(true.origin, np.float64)
    points = cloud - shift
    surface, normals = _spread(outcrop, shift)
    # The photos show what is about the outcrop too.
    low, high = surface.min(axis=0) - 0.2, surface.max(axis=0) + 0.2
    inside = points[((points > low) & (points < high)).all(axis=1)]
    distance, nearest = cKDTree(surface).query(inside[:: max(1, len(inside) // _DRAWN)])
    sample = inside[:: max(1, len(inside) // _DRAWN)]
    # Across the surface: how far the next point of the outcrop lies along it says nothing.
    off = np.abs(((sample - surface[nearest]) * normals[nearest]).sum(axis=1))
    off = np.where(distance < 0.25, off, distance)
    tree = cKDTree(inside)
    seen = surface[_seen(true, surface, normals)]
    reached, _ = tree.query(seen)
    return (
        _camera_check(found, true),
        _length(MODEL_OFFSET, float(np.median(off))),
        _length(MODEL_OFFSET_90, float(np.percentile(off, 90))),
        _length(OUTCROP_OFFSET, float(np.median(reached))),
        *_plane_checks(inside, tree, picks, truth, shift, gsd, rotation),
    )


def photo_findings(checks: Sequence[Check]) -> tuple[Finding, ...]:
    """Report the errors of the model from photos."""
    by_name = {check.name: check for check in checks}
    stated = [check for check in checks if check.within_total is not None]
    held = sum(bool(check.within_total) for check in stated)
    worst = max((check.error for check in stated), default=0.0)
    off, cameras = (1000 * by_name[name].error for name in (MODEL_OFFSET, CAMERA_CENTRES))
    return (
        Finding("sample.photo-model", model_mm=off, cameras_mm=cameras),
        Finding("sample.photo-planes", held=held, count=len(stated), worst_deg=worst),
    )


def _length(name: str, value: float) -> Check:
    return Check(name, 0.0, value, value, None, None, "m")


def _camera_check(found: Cameras, true: Cameras) -> Check:
    """Median distance of the camera centres."""
    places = {view.name: view.centre + true.origin for view in true.views}
    misses = [
        float(np.linalg.norm(view.centre + found.origin - places[view.name]))
        for view in found.views
        if view.name in places
    ]
    return _length(CAMERA_CENTRES, float(np.median(misses)))


def _spread(mesh: Mesh, shift: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points over the faces by area, and the normals there."""
    corners = mesh.vertices[mesh.faces] - shift
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(across, axis=1)
    rng = np.random.default_rng(0)
    chosen = rng.choice(len(corners), 4 * _DRAWN, p=size / size.sum())
    b = rng.random((len(chosen), 2))
    folded = b.sum(axis=1) > 1
    b[folded] = 1 - b[folded]
    a = corners[chosen]
    points = a[:, 0] + b[:, :1] * (a[:, 1] - a[:, 0]) + b[:, 1:] * (a[:, 2] - a[:, 0])
    return points, across[chosen] / size[chosen, None]


def _seen(cameras: Cameras, points: FloatArray, normals: FloatArray) -> BoolArray:
    """Which points face three of the photos or more and lie in them; what stands before them is
    not asked."""
    count = np.zeros(len(points), int)
    for view in cameras.views:
        pixels = view.project(points)
        with np.errstate(invalid="ignore"):
            ahead = ((view.centre - points) * normals).sum(axis=1) > 0
            count += ahead & view.contains(pixels)
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
    """Every pick of the sample, on the model: its planes beside the true ones."""
    checks = []
    for i, (name, kind) in enumerate(zip(picks.names, picks.kinds, strict=True)):
        distance, nearest = tree.query(picks.of(i) - shift)
        there = nearest[distance < _NEAR_GSD * gsd]
        # In the order of the trace, along which neighbours err together.
        there = there[np.sort(np.unique(there, return_index=True)[1])]
        if len(there) < _FEWEST or name not in truth.planes:
            continue
        fit = fit_planes(points[there], np.array([0, len(there)]))[0]
        found = plane_check(f"{kind} {name} on the photos' model", fit, truth.planes[name])
        turn = None
        if rotation is not None:
            turn = float(errors_95_deg(rotation, fit.normal)[0])
        total = total_error_deg(fit, gsd, registration_deg=turn)
        checks.append(replace(found, total_95=total))
    return checks
