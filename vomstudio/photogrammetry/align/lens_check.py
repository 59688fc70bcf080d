"""Findings on focal lengths after the alignment."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from vomstudio.core.findings import Finding

if TYPE_CHECKING:
    from vomstudio.photogrammetry.align.priors import Calibration

# Of a focal length, relative: by as much depths can be stretched.
_VAGUE = 0.05
_OTHER = 0.04


def of_lenses(cameras: Sequence[Calibration]) -> list[Finding]:
    """Focal lengths that are poorly constrained or wrong in EXIF, which stretch all depths."""
    vague: dict[str, float] = {}
    wrong: dict[str, float] = {}
    for camera in cameras:
        focal, sigma = camera.values[0], camera.sigma[0]
        if camera.exif_px is None:
            error = math.inf if camera.focal == "held" else sigma / focal
            # A NaN is no knowledge either.
            if not error <= _VAGUE:
                vague |= dict.fromkeys(camera.photos, error)
        elif abs(camera.exif_px / focal - 1) > max(_OTHER, 3 * sigma / focal):
            wrong |= dict.fromkeys(camera.photos, camera.exif_px / focal - 1)
    found = []
    if vague:
        error = max(vague.values())
        known = error if math.isfinite(error) else None
        found.append(Finding("focal-vague", photos=tuple(vague), value=known))
    if wrong:
        worst = max(wrong.values(), key=abs)
        percent = 100 * worst
        finding = Finding("focal-wrong", photos=tuple(wrong), value=worst, error_percent=percent)
        found.append(finding)
    return found
