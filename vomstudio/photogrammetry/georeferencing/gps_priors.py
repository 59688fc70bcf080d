"""Camera positions as observations in the bundle adjustment, if they improve the block.

Receivers with errors of several metres can place and scale a model, but the photos determine its
shape far better. Positions from real-time kinematic receivers, or from many photos, also determine
bowing and focal length.

Positions are used if their error divided by the square root of their number is at most
`MAX_USEFUL_PIXELS` pixels on the ground. Each position is weighted by its own error (heights by
twice this error), and outliers are down-weighted. If the residuals exceed the errors, the errors
are increased. Positions that contradict the tie points are not used.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.georeferencing.ground_adjustment import KnownCentre, bundle_adjust
from vomstudio.photogrammetry.georeferencing.ground_calibration import (
    LensVerdict,
    adjust_to_ground,
    ground_misfit,
)

MAX_USEFUL_PIXELS = 3.0
MIN_POSITIONS = 5
_MIN_SIGMA_M = 0.005
# Ratio of vertical to horizontal errors. Heights are less accurate, since all satellites are above
# the receiver.
HEIGHT_ERROR_FACTOR = 2.0
# Maximum factor by which the stated errors may be too small.
_MAX_MISFIT = 3.0


@dataclass(frozen=True, eq=False)
class GpsAdjustment:
    """Adjustment with GPS positions.

    Attributes
    ----------
    adjusted : bool
        Whether the positions were used.
    reason : Finding
    sigma_m : float
        Median of the errors used for a horizontal coordinate.
    lenses : tuple of LensVerdict
        Treatment of the focal lengths.
    """

    adjusted: bool
    reason: Finding
    sigma_m: float
    lenses: tuple[LensVerdict, ...] = ()


def adjust_to_positions(
    scene: SparseScene,
    rows: Sequence[int],
    positions: FloatArray,
    sigmas_m: FloatArray,
    *,
    threads: int = -1,
    progress: Progress | None = None,
) -> tuple[SparseScene, GpsAdjustment]:
    """Adjust a scene placed by GPS positions together with these positions, if useful.

    Parameters
    ----------
    scene : SparseScene
    rows : sequence of int
        Rows of the views with positions.
    positions : (n, 3) array
        Positions in the frame of the scene.
    sigmas_m : (n,) array
        Errors of the horizontal coordinates of the positions.
    threads : int
        Number of threads; -1 uses all cores.
    progress : Progress, optional

    Raises
    ------
    Cancelled
        If `progress` requests it.
    """
    sigmas = np.maximum(sigmas_m, _MIN_SIGMA_M)
    for _ in range(2):
        median = float(np.median(sigmas))
        if refusal := _sigma_problem(scene, sigmas):
            return scene, GpsAdjustment(False, refusal, median)
        # A bent block misses good positions by more than their errors, so at first it is only
        # pulled towards them.
        distances = np.linalg.norm(scene.centres[list(rows)] - positions, axis=1)
        typical_distance = float(np.median(distances))
        start_scene = scene
        if typical_distance > _MAX_MISFIT * median:
            loose_centres = known_centres(rows, positions, np.maximum(sigmas, typical_distance))
            start_scene = bundle_adjust(
                scene, (), loose_centres, threads=threads, progress=progress
            )
        centres = known_centres(rows, positions, sigmas)
        bent_scene, lenses = adjust_to_ground(
            start_scene, (), centres, threads=threads, progress=progress
        )
        misfit = ground_misfit(bent_scene, (), centres)
        if misfit <= _MAX_MISFIT:
            break
        sigmas = sigmas * misfit
    error_before, error_after = (float(np.nanmean(s.errors_px)) for s in (scene, bent_scene))
    if error_after > 1.1 * error_before + 0.02:
        reason = Finding(
            "gps.contradicts-photos",
            accuracy_m=median,
            after_px=error_after,
            before_px=error_before,
        )
        return scene, GpsAdjustment(False, reason, median)
    reason = Finding("gps.adjusted", accuracy_m=median)
    return bent_scene, GpsAdjustment(True, reason, median, lenses)


def _sigma_problem(scene: SparseScene, sigmas: FloatArray) -> Finding | None:
    """Return why positions with the errors (n,) cannot improve the adjustment, or None."""
    if len(sigmas) < MIN_POSITIONS:
        return Finding("gps.too-few-to-adjust", positions=len(sigmas), least=MIN_POSITIONS)
    joint_sigma = 1 / math.sqrt(float((sigmas**-2.0).sum()))
    pixels = joint_sigma / scene.median_pixel_size(scene.points)
    if pixels <= MAX_USEFUL_PIXELS:
        return None
    return Finding(
        "gps.not-useful",
        accuracy_m=float(np.median(sigmas)),
        error_px=pixels,
        limit_px=MAX_USEFUL_PIXELS,
    )


def known_centres(
    rows: Sequence[int] | IntArray, positions: FloatArray, sigmas: FloatArray
) -> list[KnownCentre]:
    """Return positions (n, 3) with horizontal errors (n,) as input of an adjustment."""
    axis_sigmas = sigmas[:, None] * [1.0, 1.0, HEIGHT_ERROR_FACTOR]
    return [KnownCentre(int(r), p, s) for r, p, s in zip(rows, positions, axis_sigmas, strict=True)]
