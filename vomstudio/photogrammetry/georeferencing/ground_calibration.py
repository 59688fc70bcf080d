"""A registered scene adjusted to ground control, its focal lengths held or estimated by a rule.

Control points, and positions of cameras that are good to centimetres, can tell a longer lens from
rock farther away where the photos alone cannot. How well they do so is what they add to the
information that the tie points have: of a focal length that the tie points know to a and both
together to b, the ground alone knows it to 1 / sqrt(1 / b² - 1 / a²), and worse by as much as the
ground misses its stated errors. Where that is `LARGEST_SIGMA` or less, well within what focal
lengths from EXIF are wrong by (2 to 5 %), the focal length is estimated; otherwise it stays as it
was, since a value pulled between a guess and the tie points' own preference (the misfit of the
lens's model) is no better.
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
    focal_sigmas,
)

LARGEST_SIGMA = 0.015
# Estimates made before the lens is right miss what they become by no more.
_WORTH_A_TRIAL = 3.0


@dataclass(frozen=True)
class LensVerdict:
    """Whether ground control determines a focal length.

    photos : names
    before_px, focal_px : the focal length before and after
    sigma_px : of the latter, 0 where held
    reason : why
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
    """The scene adjusted (see `bundle_adjust`), and what became of each lens. Raises
    Cancelled."""
    held = bundle_adjust(scene, points, centres, threads=threads, progress=progress)
    order = list(dict.fromkeys(view.intrinsics for view in held.views))
    alone, _ = _sigmas_by_ground(held, points, centres, order, threads)
    free = [lens for lens in order if alone[lens] <= _WORTH_A_TRIAL * LARGEST_SIGMA]
    result, sigma = held, dict.fromkeys(order, 0.0)
    while free:
        trial = bundle_adjust(held, points, centres, free=free, threads=threads, progress=progress)
        became = _adjusted_lenses(held, trial)
        now = [became[lens] for lens in free]
        excess = ground_misfit(trial, points, centres)
        told, both = _sigmas_by_ground(trial, points, centres, now, threads)
        alone |= {lens: told[became[lens]] * excess for lens in free}
        good = [lens for lens in free if alone[lens] <= LARGEST_SIGMA]
        if good == free:
            sigma |= {lens: both[became[lens]] * excess for lens in free}
            result = trial
            break
        free = good
    became = _adjusted_lenses(held, result)
    return result, tuple(
        _verdict(held, lens, became[lens], alone[lens], sigma[lens], lens in free) for lens in order
    )


def ground_misfit(
    scene: SparseScene, points: Sequence[KnownPoint], centres: Sequence[KnownCentre] = ()
) -> float:
    """By what factor the scene misses control points and positions of cameras by more than they
    should err; 1 where it does not."""
    squares: list[float] = []
    for point in points:
        if point.position is None:
            continue
        for row, pixel in zip(point.views, point.pixels, strict=True):
            view = scene.views[row]
            size = float(view.depths(point.position[None])[0]) / float(
                np.mean(view.intrinsics.focal)
            )
            variance = point.mark_px**2 + (point.sigma / size) ** 2
            miss = view.project(point.position)[0] - pixel
            squares += (miss**2 / variance).tolist()
    for centre in centres:
        miss = (scene.views[centre.view].centre - centre.position) / centre.sigma
        squares += (miss**2).tolist()
    known = np.array([s for s in squares if math.isfinite(s)])
    if not len(known):
        return 1.0
    # The median of squares of Gaussian errors is 0.455: wrong positions do not move it.
    return max(1.0, math.sqrt(float(np.median(known)) / 0.455))


def _sigmas_by_ground(
    scene: SparseScene,
    points: Sequence[KnownPoint],
    centres: Sequence[KnownCentre],
    lenses: Sequence[Intrinsics],
    threads: int,
) -> tuple[dict[Intrinsics, float], dict[Intrinsics, float]]:
    """Relative sigma of each focal length by ground control alone, infinite where undetermined; and
    by ground control and tie points together, as `focal_sigmas` gives it."""
    both = focal_sigmas(scene, points, centres, free=lenses, threads=threads)
    ties = focal_sigmas(scene, (), (), free=lenses, threads=threads)
    told = {}
    for lens in lenses:
        added = both[lens] ** -2 - ties[lens] ** -2
        told[lens] = added**-0.5 if added > 0 else float("inf")
    return told, both


def _adjusted_lenses(before: SparseScene, after: SparseScene) -> dict[Intrinsics, Intrinsics]:
    return {
        old.intrinsics: new.intrinsics for old, new in zip(before.views, after.views, strict=True)
    }


def _verdict(
    scene: SparseScene,
    lens: Intrinsics,
    became: Intrinsics,
    alone: float,
    sigma: float,
    freed: bool,
) -> LensVerdict:
    photos = tuple(view.name for view in scene.views if view.intrinsics == lens)
    before, focal = lens.focal[0], became.focal[0]
    values = {
        "focal_px": focal,
        "required_percent": 100 * LARGEST_SIGMA,
        "ground_percent": 100 * alone,
        "sigma_px": sigma * focal,
        "change_percent": 100 * (focal / before - 1),
    }
    code = "lens.ground-estimated" if freed else "lens.ground-held"
    reason = Finding(code, count=len(photos), **values)
    return LensVerdict(photos, freed, before, focal, sigma * focal if freed else 0.0, reason)
