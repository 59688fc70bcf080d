"""Camera positions as observations in the bundle adjustment, where they are accurate enough to
improve the shape of the block.

Receivers that err by metres place and scale a model, but photos know its shape far better; the
positions of real-time kinematic receivers, or of many photos, tell bowing and focal length. The
rule: positions enter where their error over the root of their number is `USEFUL_PIXELS` pixels on
the ground or less. Each weighs by its own error (heights by twice that), and less the farther off
it is, so that a wrong one is not followed. What misses by more than it should counts as less
accurate; positions that the tie points contradict are not used.
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
FEWEST_POSITIONS = 5
_LEAST_SIGMA_M = 0.005
# Of satellites, all above the receiver.
HEIGHTS_WORSE = 2.0
# Stated errors that are too small by more are not believed.
_BELIEVED = 3.0


@dataclass(frozen=True, eq=False)
class GpsAdjustment:
    """adjusted : whether the positions entered the adjustment; reason : why or why not
    sigma_m : error of a horizontal coordinate, as it was used, of the middle one
    lenses : what became of the focal lengths
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
    """The scene, placed by the positions already, adjusted with them where that is of use.

    rows : of the views; positions : (n, 3) in the frame of the scene; sigmas_m : (n,) errors
    of their horizontal coordinates
    Raises Cancelled.
    """
    sigmas = np.maximum(sigmas_m, _LEAST_SIGMA_M)
    for _ in range(2):
        middle = float(np.median(sigmas))
        if refusal := _refusal(scene, sigmas):
            return scene, GpsAdjustment(False, refusal, middle)
        # A bent block misses good positions by more than they err: first it is only drawn to them.
        misses = np.linalg.norm(scene.centres[list(rows)] - positions, axis=1)
        wide = float(np.median(misses))
        start = scene
        if wide > _BELIEVED * middle:
            loose = known_centres(rows, positions, np.maximum(sigmas, wide))
            start = bundle_adjust(scene, (), loose, threads=threads, progress=progress)
        centres = known_centres(rows, positions, sigmas)
        bent, lenses = adjust_to_ground(start, (), centres, threads=threads, progress=progress)
        misfit = ground_misfit(bent, (), centres)
        if misfit <= _BELIEVED:
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
    if len(sigmas) < FEWEST_POSITIONS:
        return Finding("gps.too-few-to-adjust", positions=len(sigmas), least=FEWEST_POSITIONS)
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
    """Positions (n, 3) of cameras, with errors (n,) of a horizontal coordinate, as an adjustment
    wants them."""
    each = sigmas[:, None] * [1.0, 1.0, HEIGHTS_WORSE]
    return [KnownCentre(int(r), p, s) for r, p, s in zip(rows, positions, each, strict=True)]
