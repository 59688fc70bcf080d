"""Camera positions as observations in the bundle adjustment, if they improve the block.

Receivers with errors of metres place and scale a model, but photos determine its shape far better.
Positions of real-time kinematic receivers, or of many photos, determine bowing and focal length.
The rule: positions are used if their error over the root of their number is `USEFUL_PIXELS` pixels
on the ground or less. Each is weighted by its own error (heights by twice that), and outliers are
down-weighted. If residuals exceed the errors, these are increased; positions that the tie points
contradict are not used.
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

USEFUL_PIXELS = 3.0
MIN_POSITIONS = 5
_MIN_SIGMA_M = 0.005
# Ratio of errors of heights, since all satellites are above the receiver.
HEIGHT_ERROR_FACTOR = 2.0
# Maximum factor by which stated errors may be too small.
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
        Used error of a horizontal coordinate, median.
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
    """Adjust a scene, already placed by the positions, with them if useful.

    Parameters
    ----------
    scene : SparseScene
    rows : sequence of int
        Of the views.
    positions : (n, 3) array
        In the frame of the scene.
    sigmas_m : (n,) array
        Errors of their horizontal coordinates.
    threads : int
    progress : Progress, optional
        Raises Cancelled.
    """
    sigmas = np.maximum(sigmas_m, _MIN_SIGMA_M)
    for _ in range(2):
        middle = float(np.median(sigmas))
        if refusal := _refusal(scene, sigmas):
            return scene, GpsAdjustment(False, refusal, middle)
        # A bent block misses good positions by more than they err: first it is only drawn to them.
        misses = np.linalg.norm(scene.centres[list(rows)] - positions, axis=1)
        wide = float(np.median(misses))
        start = scene
        if wide > _MAX_MISFIT * middle:
            loose = known_centres(rows, positions, np.maximum(sigmas, wide))
            start = bundle_adjust(scene, (), loose, threads=threads, progress=progress)
        centres = known_centres(rows, positions, sigmas)
        bent, lenses = adjust_to_ground(start, (), centres, threads=threads, progress=progress)
        misfit = ground_misfit(bent, (), centres)
        if misfit <= _MAX_MISFIT:
            break
        sigmas = sigmas * misfit
    before, after = (float(np.nanmean(s.errors_px)) for s in (scene, bent))
    if after > 1.1 * before + 0.02:
        reason = Finding(
            "gps.contradicts-photos", accuracy_m=middle, after_px=after, before_px=before
        )
        return scene, GpsAdjustment(False, reason, middle)
    reason = Finding("gps.adjusted", accuracy_m=middle)
    return bent, GpsAdjustment(True, reason, middle, lenses)


def _refusal(scene: SparseScene, sigmas: FloatArray) -> Finding | None:
    """Return why positions with these errors (n,) cannot improve the adjustment, or None."""
    if len(sigmas) < MIN_POSITIONS:
        return Finding("gps.too-few-to-adjust", positions=len(sigmas), least=MIN_POSITIONS)
    together = 1 / math.sqrt(float((sigmas**-2.0).sum()))
    pixels = together / scene.pixel_at(scene.points)
    if pixels <= USEFUL_PIXELS:
        return None
    return Finding(
        "gps.not-useful",
        accuracy_m=float(np.median(sigmas)),
        error_px=pixels,
        limit_px=USEFUL_PIXELS,
    )


def known_centres(
    rows: Sequence[int] | IntArray, positions: FloatArray, sigmas: FloatArray
) -> list[KnownCentre]:
    """Return positions (n, 3) with horizontal errors (n,) as input of an adjustment."""
    each = sigmas[:, None] * [1.0, 1.0, HEIGHT_ERROR_FACTOR]
    return [KnownCentre(int(r), p, s) for r, p, s in zip(rows, positions, each, strict=True)]
