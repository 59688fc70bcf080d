"""Findings on focal lengths after the alignment."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from vomstudio.survey.check_results import Finding, named
from vomstudio.words import tr

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
        if math.isfinite(error):
            known = tr("Its error is {error:.0f} %.", error=100 * error)
        else:
            known = tr("It is assumed.")
        found.append(
            Finding(
                "focal-vague",
                "warning",
                tuple(vague),
                tr(
                    "The focal length of these photos is not in EXIF and is poorly constrained: "
                    "{photos}. {accuracy} Depths are stretched by as much. Lengths along the face "
                    "are sound once the model is scaled; dips are not.",
                    photos=named(tuple(vague)),
                    accuracy=known,
                ),
                error if math.isfinite(error) else None,
            )
        )
    if wrong:
        worst = max(wrong.values(), key=abs)
        found.append(
            Finding(
                "focal-wrong",
                "info",
                tuple(wrong),
                tr(
                    "The focal length in EXIF is {percent:.0f} % too long for these photos: "
                    "{photos}. They were zoomed digitally, cropped or resized. The estimated focal "
                    "length is used.",
                    photos=named(tuple(wrong)),
                    percent=100 * worst,
                )
                if worst > 0
                else tr(
                    "The focal length in EXIF is {percent:.0f} % too short for these photos: "
                    "{photos}. They were zoomed digitally, cropped or resized. The estimated focal "
                    "length is used.",
                    photos=named(tuple(wrong)),
                    percent=-100 * worst,
                ),
                worst,
            )
        )
    return found
