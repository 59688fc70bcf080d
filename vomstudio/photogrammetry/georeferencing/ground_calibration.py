"""Adjustment of a registered scene to ground control, with fixed or free focal lengths.

Control points and accurate camera positions can distinguish a longer lens from rock farther away
when the photos alone cannot. Their information on a focal length is the total information minus the
information of the tie points. If the tie points determine the focal length with error a, and both
together with error b, ground control alone determines it with error 1 / sqrt(1 / b² - 1 / a²),
times the ratio of its residuals to their errors. If this error is `MAX_RELATIVE_SIGMA` or less,
well below the errors of focal lengths from EXIF (2 to 5 %), the focal length is estimated.
Otherwise it remains unchanged, because a compromise between a guess and the misfit of the lens
model would be no better.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.geometry.cameras import Intrinsics
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.georeferencing.ground_adjustment import (
    KnownCentre,
    KnownPoint,
    bundle_adjust,
    focal_length_sigmas,
)

MAX_RELATIVE_SIGMA = 0.015
# Maximum factor by which the sigmas computed before the lens is estimated may be too large.
_MAX_TRIAL_FACTOR = 3.0


@dataclass(frozen=True)
class LensVerdict:
    """Result of testing whether ground control determines a focal length.

    Attributes
    ----------
    photos : tuple of str
    before_px, focal_px : float
        Focal length before and after.
    sigma_px : float
        Standard deviation of `focal_px`; 0 if the focal length is fixed.
    reason : Finding
    """

    photos: tuple[str, ...]
    freed: bool
    before_px: float
    focal_px: float
    sigma_px: float
    reason: Finding


def adjust_to_ground(
    scene: SparseScene,
    points: Sequence[KnownPoint],
    centres: Sequence[KnownCentre] = (),
    *,
    threads: int = -1,
    progress: Progress | None = None,
) -> tuple[SparseScene, tuple[LensVerdict, ...]]:
    """Adjust the scene (see `bundle_adjust`), and return a verdict on each lens.

    Raises Cancelled.
    """
    fixed_scene = bundle_adjust(scene, points, centres, threads=threads, progress=progress)
    order = list(dict.fromkeys(view.intrinsics for view in fixed_scene.views))
    ground_only_result, _ = _estimate_ground_sigmas(fixed_scene, points, centres, order, threads)
    free_order = [
        lens for lens in order if ground_only_result[lens] <= _MAX_TRIAL_FACTOR * MAX_RELATIVE_SIGMA
    ]
    result, sigma = fixed_scene, dict.fromkeys(order, 0.0)
    while free_order:
        trial = bundle_adjust(
            fixed_scene,
            points,
            centres,
            free_lenses=free_order,
            threads=threads,
            progress=progress,
        )
        new_lenses = _adjusted_lenses(fixed_scene, trial)
        trial_lenses = [new_lenses[lens] for lens in free_order]
        excess = ground_misfit(trial, points, centres)
        trial_sigmas, joint_sigmas = _estimate_ground_sigmas(
            trial, points, centres, trial_lenses, threads
        )
        ground_only_result |= {lens: trial_sigmas[new_lenses[lens]] * excess for lens in free_order}
        determined_lenses = [
            lens for lens in free_order if ground_only_result[lens] <= MAX_RELATIVE_SIGMA
        ]
        if determined_lenses == free_order:
            sigma |= {lens: joint_sigmas[new_lenses[lens]] * excess for lens in free_order}
            result = trial
            break
        free_order = determined_lenses
    new_lenses = _adjusted_lenses(fixed_scene, result)
    return result, tuple(
        _lens_verdict(
            fixed_scene,
            lens,
            new_lenses[lens],
            ground_only_result[lens],
            sigma[lens],
            lens in free_order,
        )
        for lens in order
    )


def ground_misfit(
    scene: SparseScene, points: Sequence[KnownPoint], centres: Sequence[KnownCentre] = ()
) -> float:
    """Return the ratio of the residuals of points and cameras to their errors, at least 1."""
    squared_residuals: list[float] = []
    for point in points:
        if point.position is None:
            continue
        for row, pixel in zip(point.views, point.pixels, strict=True):
            view = scene.views[row]
            size = float(view.depths(point.position[None])[0]) / float(
                np.mean(view.intrinsics.focal)
            )
            variance = point.mark_px**2 + (point.sigma / size) ** 2
            misclosure = view.project(point.position)[0] - pixel
            squared_residuals += (misclosure**2 / variance).tolist()
    for centre in centres:
        misclosure = (scene.views[centre.view].centre - centre.position) / centre.sigma
        squared_residuals += (misclosure**2).tolist()
    finite_squares = np.array([s for s in squared_residuals if math.isfinite(s)])
    if not len(finite_squares):
        return 1.0
    # The median of squared standard Gaussian errors is 0.455; unlike the mean, it is robust to
    # wrong positions.
    return max(1.0, math.sqrt(float(np.median(finite_squares)) / 0.455))


def _estimate_ground_sigmas(
    scene: SparseScene,
    points: Sequence[KnownPoint],
    centres: Sequence[KnownCentre],
    lenses: Sequence[Intrinsics],
    threads: int,
) -> tuple[dict[Intrinsics, float], dict[Intrinsics, float]]:
    """Return the relative errors of focal lengths from ground control.

    Returns two dictionaries: for ground control alone, and for ground control together with the tie
    points. Errors are infinite if undetermined.
    """
    joint_sigmas = focal_length_sigmas(scene, points, centres, free_lenses=lenses, threads=threads)
    ties = focal_length_sigmas(scene, (), (), free_lenses=lenses, threads=threads)
    ground_sigmas = {}
    for lens in lenses:
        added_information = joint_sigmas[lens] ** -2 - ties[lens] ** -2
        ground_sigmas[lens] = added_information**-0.5 if added_information > 0 else float("inf")
    return ground_sigmas, joint_sigmas


def _adjusted_lenses(
    old_scene: SparseScene, new_scene: SparseScene
) -> dict[Intrinsics, Intrinsics]:
    return {
        old_view.intrinsics: new_view.intrinsics
        for old_view, new_view in zip(old_scene.views, new_scene.views, strict=True)
    }


def _lens_verdict(
    scene: SparseScene,
    lens: Intrinsics,
    adjusted_lens: Intrinsics,
    ground_sigma: float,
    sigma: float,
    is_estimated: bool,
) -> LensVerdict:
    photos = tuple(view.name for view in scene.views if view.intrinsics == lens)
    focal_before, focal = lens.focal[0], adjusted_lens.focal[0]
    values = {
        "focal_px": focal,
        "required_percent": 100 * MAX_RELATIVE_SIGMA,
        "ground_percent": 100 * ground_sigma,
        "sigma_px": sigma * focal,
        "change_percent": 100 * (focal / focal_before - 1),
    }
    code = "lens.ground-estimated" if is_estimated else "lens.ground-held"
    reason = Finding(code, count=len(photos), **values)
    return LensVerdict(
        photos, is_estimated, focal_before, focal, sigma * focal if is_estimated else 0.0, reason
    )
