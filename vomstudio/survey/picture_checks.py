"""What is wrong with single pictures: blur, enlarged pixels, light (textbook 2.4)."""

from __future__ import annotations

import math
from collections import defaultdict
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.survey.check_limits import Limits, Looked
from vomstudio.survey.check_results import Finding, named

if TYPE_CHECKING:
    from vomstudio.io.photos.photo import Photo


def of_pixels(seen: Looked, limits: Limits) -> list[Finding]:
    photos, looks = seen.photos, seen.looks
    found = []
    blurs = {i: look.blur_px for i, look in enumerate(looks) if look.blur_px is not None}
    if blurs:
        middle = float(np.median(list(blurs.values())))
        limit = max(limits.blur_px, limits.blur_times * middle)
        bad = tuple(photos[i].name for i, value in blurs.items() if value > limit)
        if bad:
            worst = max(blurs.values())
            found.append(
                Finding(
                    "blurred",
                    "warning",
                    bad,
                    f"{named(bad)}: edges are blurred by up to {worst:.1f} pixels (sigma), in the "
                    f"whole set by {middle:.1f}: leave them out where others see the same.",
                    worst,
                )
            )
        if middle > limits.soft_px:
            found.append(
                Finding(
                    "soft",
                    "warning",
                    (),
                    f"All photos are soft: edges are blurred by {middle:.1f} pixels (sigma), so "
                    f"the true resolution is about {middle / 0.8:.0f} times coarser than a pixel. "
                    "The focus was missed, or the pictures were enlarged.",
                    middle,
                )
            )
    found += _of_enlarging(seen, limits)
    found += _of_light(seen, limits)
    return found


def _of_enlarging(seen: Looked, limits: Limits) -> list[Finding]:
    from vomstudio.io.photos.camera_table import find_camera

    found = []
    photos = seen.photos
    zoomed = {p.name: p.digital_zoom for p in photos if p.digital_zoom and p.digital_zoom > 1.05}
    by_lens: dict[tuple[object, ...], list[Photo]] = defaultdict(list)
    for photo in photos:
        if photo.focal_mm and photo.focal_35mm:
            by_lens[photo.camera, photo.serial, photo.lens, photo.focal_mm].append(photo)
    for group in by_lens.values():
        least = min(p.focal_35mm or math.inf for p in group)
        for photo in group:
            # The same lens setting, yet a narrower picture: cut out of the middle and enlarged.
            if (photo.focal_35mm or 0) > 1.15 * least and photo.long_side >= max(
                p.long_side for p in group if p.focal_35mm == least
            ):
                zoomed.setdefault(photo.name, (photo.focal_35mm or 0) / least)
    if zoomed:
        most = max(value or 1.0 for value in zoomed.values())
        found.append(
            Finding(
                "digital-zoom",
                "warning",
                tuple(zoomed),
                f"{named(list(zoomed))} were zoomed digitally, by up to {most:.2g}: enlarged "
                "pixels hold no more detail, and the true pixel on the rock is as much larger.",
                most,
            )
        )
    enlarged = []
    for photo in photos:
        model = find_camera(photo.camera)
        if model is not None and photo.long_side > 1.05 * max(model.width_px, model.height_px):
            enlarged.append(photo.name)
    if enlarged:
        model = find_camera(next(p.camera for p in photos if p.name == enlarged[0]))
        assert model is not None
        found.append(
            Finding(
                "enlarged",
                "warning",
                tuple(enlarged),
                f"{named(enlarged)} have more pixels than a {model.label} takes "
                f"({model.width_px}): they were enlarged or stitched, and hold no more detail.",
                len(enlarged),
            )
        )
    looks = [look for look in seen.looks if look.blur_px is not None]
    traced = [look for look in looks if (look.resampled or 0.0) >= limits.resampled]
    middle = float(np.median([look.blur_px or 0.0 for look in looks])) if looks else 0.0
    # A trace alone is left by straightening or by a smaller picture too, which do no harm.
    if not enlarged and len(traced) > 0.6 * len(looks) and middle > limits.enlarged_px:
        found.append(
            Finding(
                "enlarged",
                "warning",
                (),
                f"The pixels bear the periodic trace of interpolation and are soft (edges of "
                f"{middle:.1f} pixels): digital zoom, or enlarged afterwards. They hold no more "
                "detail for it; use the camera's original files.",
                middle,
            )
        )
    return found


def _of_light(seen: Looked, limits: Limits) -> list[Finding]:
    found = []
    photos = seen.photos
    shut = {
        i
        for i, look in enumerate(seen.looks)
        if look.brightness is not None
        and (look.brightness < limits.darkest or (look.burnt or 0.0) > limits.burnt)
    }
    if shut:
        names = tuple(photos[i].name for i in sorted(shut))
        found.append(
            Finding(
                "exposure",
                "warning",
                names,
                f"{named(names)}: nearly black, or mostly burnt out; nothing can be recognised in "
                "them.",
                len(names),
            )
        )
    bright = {
        i: math.log2(look.brightness)
        for i, look in enumerate(seen.looks)
        if look.brightness is not None and look.brightness > 0 and i not in shut
    }
    if len(bright) >= 3:
        middle = float(np.median(list(bright.values())))
        jumps = tuple(photos[i].name for i, v in bright.items() if abs(v - middle) > limits.stops)
        if jumps:
            worst = max((v - middle for v in bright.values()), key=abs)
            found.append(
                Finding(
                    "brightness-jump",
                    "warning",
                    jumps,
                    f"{named(jumps)}: lighter or darker than the rest of the set by up to "
                    f"{abs(worst):.1f} stops; matching suffers, and the texture will show it.",
                    worst,
                )
            )
    exposures = [p.exposure_value for p in photos if p.exposure_value is not None]
    if len(exposures) >= 3:
        spread = float(np.quantile(exposures, 0.95) - np.quantile(exposures, 0.05))
        if spread > limits.light_stops:
            found.append(
                Finding(
                    "light-changed",
                    "warning",
                    (),
                    f"The camera metered light that changed by {spread:.1f} stops: sun and shade, "
                    "or hours apart. Shadows that move are matched as if they were rock.",
                    spread,
                )
            )
    taken = sorted(p.taken for p in photos if p.taken is not None)
    if len(taken) >= 2:
        hours = (taken[-1] - taken[0]).total_seconds() / 3600.0
        if hours > limits.hours:
            span = f"{hours:.0f} hours" if hours < 48 else f"{hours / 24:.0f} days"
            found.append(
                Finding(
                    "long-survey",
                    "info",
                    (),
                    f"The photos were taken over {span}: shadows move meanwhile; on several days "
                    "keep to the same hours.",
                    hours,
                )
            )
    return found
