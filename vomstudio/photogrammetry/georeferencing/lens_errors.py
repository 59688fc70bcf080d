"""Effect of lens errors on a registered model: bowing, stretch, rotation and scale.

A block of photos with a wrong lens bends (James & Robson 2014, Earth Surface Processes and
Landforms 39, 1413-1420), and the residuals do not show this if only the photos determine the shape.
Each lens is therefore changed by its possible error, poses and points are adjusted to this change
(`lens_response`), and the scene is registered again. The displacement of its tie points is then
expressed as a rotation, a change of scale, a bowing and a stretch of depths.

A fixed focal length is assigned the error of EXIF values, or that of a typical lens. The errors of
the other parameters follow from the photos and the ground control, with neighbouring tie points
counted as one, but do not exceed the differences between lenses. The same applies to parameters
fixed at zero, since they may differ from zero by too little for these photos to show it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.geology.bowing import LensDeformation, fit_shape_change, model_shape
from vomstudio.geometry.cameras import CAMERA_MODELS, Intrinsics, View
from vomstudio.photogrammetry.align.priors import (
    MIN_EXIF_DIFFERENCE,
    UNKNOWN_FOCAL_SIGMA,
    Calibration,
)
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.georeferencing.ground_adjustment import (
    KnownCentre,
    KnownPoint,
    noise_px,
)
from vomstudio.photogrammetry.georeferencing.ground_calibration import LensVerdict
from vomstudio.photogrammetry.georeferencing.lens_response import LensResponse, compute_response
from vomstudio.registration.similarity import Similarity

_Z95 = 1.959963984540054
# Number of tie points per photo: a few dozen determine a lens as well as thousands of correlated
# ones.
_POINTS_PER_PHOTO = 60
# One-sigma priors for lenses of the same model: the radial terms, and the principal point as a
# share of the diagonal (see `align.priors`).
_K1_SIGMA, _K2_SIGMA, _CENTRE_SIGMA = 0.1, 0.05, 0.005 / np.sqrt(2.0)
# EXIF errors of 95 % of cameras are smaller; larger ones are detected (see `align.priors`).
_EXIF_SIGMA = MIN_EXIF_DIFFERENCE / _Z95
_MAX_LENSES = 20
_MAX_VIEWS = 1500
_MIN_POINTS = 20


@dataclass(frozen=True, eq=False)
class LensEffect:
    """Effect of lens errors on a model.

    Attributes
    ----------
    covariance : (7, 7) array
        Covariance of rotations about east, north and up (rad), of a relative change of scale, and
        of a translation, with respect to a point, as in `Scatter`. It includes the mean rotation of
        planes by bowing and stretch.
    bend : LensDeformation
        Bend that corresponds to the 95 % errors.
    """

    covariance: FloatArray
    bend: LensDeformation


def lens_effect(
    scene: SparseScene,
    cameras: Sequence[Calibration],
    centre: FloatArray,
    fit_placement: Callable[[SparseScene], Similarity] | None = None,
    points: Sequence[KnownPoint] = (),
    centres: Sequence[KnownCentre] = (),
    lenses: Sequence[LensVerdict] = (),
) -> LensEffect | None:
    """Compute the effect of lens errors on a registered scene.

    Returns None if there are no cameras, or if the effect cannot be computed.

    Parameters
    ----------
    scene : SparseScene
        Registered scene.
    cameras : sequence of Calibration
    centre : (3,) array
        Reference point of the covariance, in the frame of the scene.
    fit_placement : callable, optional
        Function that registers a similar scene. By default, a scene is registered by its own
        points.
    points, centres : sequence
        Inputs of the adjustment of the scene.
    lenses : sequence of LensVerdict
        Treatment of the lenses in this adjustment.
    """
    if not cameras or len(scene.points) < _MIN_POINTS or len(scene.views) > _MAX_VIEWS:
        return None
    focal_errors = dict(_focal_errors(scene, cameras, lenses))
    if not focal_errors:
        return None
    thin_scene = _thin_points(scene)
    extended_scene = _add_second_radial(thin_scene, focal_errors)
    response = compute_response(extended_scene, noise_px(extended_scene), points, centres)
    shape_middle, axes, half_extent = model_shape(scene.points)
    changes = []
    try:
        for change in _lens_changes(
            response, [focal_errors.get(lens) for lens in _lenses(thin_scene)]
        ):
            changed_scene = response.apply_change(change)
            fit = (
                _fit_by_tie_points(extended_scene, changed_scene)
                if fit_placement is None
                else fit_placement(changed_scene)
            )
            displacements = fit(changed_scene.points) - extended_scene.points
            changes.append(fit_shape_change(extended_scene.points, displacements))
    except (GeometryError, np.linalg.LinAlgError):
        return None
    shape_centre, _, _ = model_shape(extended_scene.points)
    rows = np.zeros((len(changes), 7))
    for row, shape_change in zip(rows, changes, strict=True):
        offsets = centre - shape_centre
        row[:3], row[3] = shape_change.rotation, shape_change.growth
        row[4:] = (
            shape_change.shift
            + np.cross(shape_change.rotation, offsets)
            + shape_change.growth * offsets
        )
    covariance = rows.T @ rows
    curvature = float(np.sqrt(sum(shape_change.curvature_per_m**2 for shape_change in changes)))
    scale_error = float(np.sqrt(sum(shape_change.stretch**2 for shape_change in changes)))
    if not np.isfinite([*covariance.ravel(), curvature, scale_error]).all():
        return None
    mean_squared_distance = float(
        (((scene.points - shape_middle) @ axes[:2].T) ** 2)
        .sum(axis=1)
        .clip(0, half_extent**2)
        .mean()
    )
    tilt = (2.0 * curvature) ** 2 * mean_squared_distance / 2.0 + (scale_error / 2.0) ** 2 / 2.0
    covariance[:3, :3] += tilt * axes[:2].T @ axes[:2]
    return LensEffect(
        covariance, LensDeformation(_Z95 * curvature, half_extent, _Z95 * scale_error)
    )


def compute_lens_bend(scene: SparseScene, cameras: Sequence[Calibration]) -> LensDeformation | None:
    """Return the bend of a scene that only photos determine, in the units of the scene.

    Returns None if it cannot be computed.
    """
    effect_of_lenses = lens_effect(scene, cameras, scene.points.mean(axis=0))
    return None if effect_of_lenses is None else effect_of_lenses.bend


def identity_placement(_scene: SparseScene) -> Similarity:
    """Return the identity, for a scene whose frame is fixed by its adjustment."""
    return Similarity(1.0, np.eye(3), np.zeros(3))


def _lenses(scene: SparseScene) -> list[Intrinsics]:
    return list(dict.fromkeys(view.intrinsics for view in scene.views))


def _focal_errors(
    scene: SparseScene, cameras: Sequence[Calibration], lenses: Sequence[LensVerdict]
) -> list[tuple[Intrinsics, float]]:
    """Return the lenses with the most photos, and the relative errors of their focal lengths.

    The error is 0 if the focal length was estimated.
    """
    camera_by_photo = {photo: camera for camera in cameras for photo in camera.photos}
    freed_photos = {photo for lens in lenses if lens.freed for photo in lens.photos}
    count: dict[Intrinsics, int] = {}
    focal_errors: dict[Intrinsics, float] = {}
    for view in scene.views:
        camera = camera_by_photo.get(view.name)
        if camera is None:
            continue
        count[view.intrinsics] = count.get(view.intrinsics, 0) + 1
        focal_error = _EXIF_SIGMA if camera.exif_px is not None else UNKNOWN_FOCAL_SIGMA
        is_focal_free = camera.focal == "freed" or view.name in freed_photos
        focal_errors[view.intrinsics] = 0.0 if is_focal_free else focal_error
    maximum = sorted(count, key=lambda lens: -count[lens])[:_MAX_LENSES]
    return [(lens, focal_errors[lens]) for lens in maximum]


def _thin_points(scene: SparseScene) -> SparseScene:
    """Select enough tie points in each photo, preferring those that most photos see."""
    remaining_counts = np.full(len(scene.views), _POINTS_PER_PHOTO)
    if len(scene.track_views) <= remaining_counts.sum():
        return scene
    rng = np.random.default_rng(0)
    order = rng.permutation(len(scene.points))
    order = order[np.argsort(-np.minimum(scene.track_lengths[order], 6), kind="stable")]
    is_kept = np.zeros(len(scene.points), bool)
    offsets = scene.track_offsets
    for point in order:
        point_views = scene.track_views[offsets[point] : offsets[point + 1]]
        if (remaining_counts[point_views] > 0).any():
            is_kept[point] = True
            remaining_counts[point_views] -= 1
        if not (remaining_counts > 0).any():
            break
    is_observed = np.repeat(is_kept, scene.track_lengths)
    return replace(
        scene,
        points=scene.points[is_kept],
        colors=scene.colors[is_kept],
        errors_px=scene.errors_px[is_kept],
        track_offsets=np.concatenate([[0], np.cumsum(scene.track_lengths[is_kept])]).astype(
            np.int64
        ),
        track_views=scene.track_views[is_observed],
        track_pixels=scene.track_pixels[is_observed],
    )


def _add_second_radial(scene: SparseScene, known_sigmas: dict[Intrinsics, float]) -> SparseScene:
    """Add k2, which has the largest effect on bowing, to lenses that lack it."""

    def add_k2(view: View) -> View:
        lens = view.intrinsics
        if lens.model != "SIMPLE_RADIAL" or lens not in known_sigmas:
            return view
        return replace(view, intrinsics=replace(lens, model="RADIAL", params=(*lens.params, 0.0)))

    return replace(scene, views=tuple(add_k2(view) for view in scene.views))


def _lens_changes(response: LensResponse, focal_errors: Sequence[float | None]) -> list[FloatArray]:
    """Return independent one-sigma changes (l,) of all lenses.

    focal_errors : relative error of each lens's focal length, 0 if estimated; None for a fixed lens
    """
    prior, is_fixed, focal_changes = [], [], []
    for lens, focal_error in zip(response.lenses, focal_errors, strict=True):
        diagonal = float(np.hypot(lens.width, lens.height))
        for name in CAMERA_MODELS[lens.model]:
            spread = {"c": _CENTRE_SIGMA * diagonal, "k": _K2_SIGMA, "p": 0.1 * _K2_SIGMA}.get(
                name[0], np.inf
            )
            prior.append(_K1_SIGMA if name == "k1" else spread)
            is_focal = name[0] == "f"
            is_fixed.append(focal_error is None or (is_focal and focal_error > 0.0))
            focal_changes.append((focal_error or 0.0) * lens.focal[0] if is_focal else 0.0)
    is_free = ~np.array(is_fixed)
    information = response.information + np.diag(np.array(prior) ** -2.0)
    free_information = information[np.ix_(is_free, is_free)]
    values, axes = np.linalg.eigh(free_information)
    values = np.maximum(values, 1e-12 * values[-1])
    changes = []
    for value, axis in zip(values, axes.T, strict=True):
        change = np.zeros(len(is_free))
        change[is_free] = axis / np.sqrt(value)
        changes.append(change)
    # The other parameters adapt to a wrong focal length.
    for k in np.flatnonzero(focal_changes):
        change = np.zeros(len(is_free))
        change[k] = focal_changes[k]
        pull = response.information[np.ix_(is_free, [k])][:, 0] * focal_changes[k]
        change[is_free] = -(axes / values) @ (axes.T @ pull)
        changes.append(change)
    return changes


def _fit_by_tie_points(old_scene: SparseScene, new_scene: SparseScene) -> Similarity:
    """Fit the similarity between two scenes by their tie points."""
    from vomstudio.registration.similarity import fit_similarity

    return fit_similarity(new_scene.points, old_scene.points)
