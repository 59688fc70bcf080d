"""What a set of photos is worth, before anything is aligned (textbook 2.4 and 3.2).

Every rule names its number and its source. Limits lean to the side of silence: a finding that is
wrong costs the trust in those that are right.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from vomstudio.photogrammetry.camera_positions import (
    accuracy_of,
    metres_from_gps,
    rotation_error95_deg,
    straightness,
)
from vomstudio.photogrammetry.findings import (
    Finding,
    PhotoFigures,
    SurveyReport,
    length,
    named,
    next_time,
    ordered,
    verdict_of,
)
from vomstudio.photogrammetry.overlap import (
    Features,
    SetLook,
    features_of,
    look_at_set,
    optical_axes,
)
from vomstudio.photogrammetry.photo_quality import PhotoLook, look_at
from vomstudio.photogrammetry.survey import ground_sampling_distance, smallest_plane
from vomstudio.progress import Progress, Silent

if TYPE_CHECKING:
    from vomstudio.io.photos import Photo, PhotoFolder

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Limits:
    """views : photos that should see each place (3.2.1: four or five)
    overlap : of a photo with its best neighbour; the book's 60 % less what the estimate errs by
    doming_deg : spread of view directions that counts as one direction; the book wants obliques up
        to 30 degrees from the perpendicular (3.2.1)
    same_place : baseline over distance; turn_deg and zoom : what makes it another photo
    blur_px : sigma; and blur_times the median of the set
    darkest : mean linear light, and burnt : share of pixels, beyond which nothing is seen
    stops : of brightness in the pictures; light_stops : of the exposure that the light asked for
    gsd_ratio : an order of magnitude (3.2.1)
    rotation_deg : 95 % error of an orientation by GPS that the user should hear of
    straight : width over length of camera positions that counts as one line
    resampled : see photo_quality.interpolation_period; enlarged_px : blur that confirms it
    """

    views: float = 4.0
    fewest_photos: int = 5
    overlap: float = 0.50
    doming_deg: float = 10.0
    same_place: float = 0.01
    turn_deg: float = 5.0
    zoom: float = 1.25
    near_identical: float = 0.97
    blur_px: float = 1.8
    blur_times: float = 1.8
    soft_px: float = 2.5
    stops: float = 1.0
    light_stops: float = 2.0
    darkest: float = 0.005
    burnt: float = 0.6
    gsd_ratio: float = 10.0
    rotation_deg: float = 5.0
    straight: float = 0.05
    resampled: float = 25.0
    enlarged_px: float = 1.25
    hours: float = 3.0


@dataclass(frozen=True, eq=False)
class Looked:
    """What was measured of a folder: per photo, and between them."""

    photos: tuple[Photo, ...]
    looks: tuple[PhotoLook, ...]
    features: tuple[Features | None, ...]
    pairs: SetLook


def look_at_folder(folder: PhotoFolder, progress: Progress | None = None) -> Looked:
    """Decode and compare all photos once."""
    progress = progress or Silent()
    photos = tuple(folder.photos)
    progress.stage("looking at photos", len(photos))
    looks, features = [], []
    for done, photo in enumerate(photos):
        progress.step(done)
        look = look_at(photo)
        looks.append(look)
        features.append(None if look.error else features_of(photo))
    progress.step(len(photos))
    pairs = look_at_set(features, metres_from_gps(photos), progress)
    return Looked(photos, tuple(looks), tuple(features), pairs)


def check_photos(
    folder: PhotoFolder,
    *,
    distance_m: float | None = None,
    limits: Limits | None = None,
    progress: Progress | None = None,
) -> SurveyReport:
    """The whole check before alignment. distance_m : from camera to rock, where the user knows it;
    drones that look down know their height."""
    return report(look_at_folder(folder, progress), folder, distance_m, limits or Limits())


def report(
    seen: Looked, folder: PhotoFolder, distance_m: float | None, limits: Limits
) -> SurveyReport:
    photos = seen.photos
    gsd = [pixel_size(photo, distance_m) for photo in photos]
    axes, known_axes = optical_axes(seen.pairs, len(photos))
    best = _best_overlap(seen.pairs, len(photos))
    findings = [
        *_of_the_folder(folder, seen, limits),
        *_of_pairs(seen, best, limits),
        *_of_directions(seen, axes, known_axes, limits),
        *_of_pixels(seen, limits),
        *_of_sizes(seen, gsd, limits),
        *_of_positions(photos, limits),
    ]
    findings = list(ordered(findings))
    known = [value for value in gsd if value is not None]
    middle = float(np.median(known)) if known else None
    figures = tuple(
        PhotoFigures(
            photo.name,
            gsd[i],
            seen.looks[i].blur_px,
            float(seen.pairs.views[i]),
            seen.looks[i].brightness,
            best[i],
        )
        for i, photo in enumerate(photos)
    )
    return SurveyReport(
        "before",
        figures,
        tuple(findings),
        verdict_of(findings, middle, hint=_hint(photos)),
        middle,
        None if middle is None else smallest_plane(middle),
        next_time(findings),
    )


def pixel_size(photo: Photo, distance_m: float | None = None) -> float | None:
    """Metres on the rock per pixel by eq. 18, from the distance given or the height of a drone that
    looks down; None where either the distance or the focal length is unknown."""
    if photo.focal_px is None:
        return None
    distance = distance_m
    height, pitch = photo.relative_altitude_m, photo.pitch_deg
    if distance is None and height is not None and pitch is not None and pitch <= -45.0:
        distance = height / math.sin(math.radians(-pitch))
    if distance is None or distance <= 0:
        return None
    # In pixels the sensor's width cancels: Sw / f = Iw / f_px.
    return ground_sampling_distance(photo.long_side, photo.focal_px, distance, photo.long_side)


def _hint(photos: Sequence[Photo]) -> str:
    focal = [p.focal_px for p in photos if p.focal_px is not None]
    if not focal:
        return "Neither focal length nor distance is known, so that the size of a pixel is not"
    per_10_m = 10.0 / float(np.median(focal))
    return (
        f"At 10 m from the rock one pixel would cover {length(per_10_m)}, and planes down to about "
        f"{length(smallest_plane(per_10_m))} across could be measured (1000 pixels)"
    )


# ------------------------------------------------------------------------------------------------
def _of_the_folder(folder: PhotoFolder, seen: Looked, limits: Limits) -> list[Finding]:
    found = []
    count = len(seen.photos)
    if count == 1:
        found.append(
            Finding("one-photo", "error", (), "One photo has no depth: a model needs several.", 1)
        )
    elif count < limits.fewest_photos:
        found.append(
            Finding(
                "few-photos",
                "warning",
                (),
                f"There are only {count} photos: each place of the rock should be seen in four or "
                "five, and what two or three see is not checked by anything.",
                count,
            )
        )
    damaged = tuple(p.name for p, look in zip(seen.photos, seen.looks, strict=True) if look.error)
    if damaged:
        reason = next(look.error for look in seen.looks if look.error)
        found.append(
            Finding(
                "damaged",
                "warning",
                damaged,
                f"{named(damaged)} cannot be decoded ({reason}) and will be left out.",
                len(damaged),
            )
        )
    if folder.duplicates:
        names = tuple(name for name, _ in folder.duplicates)
        found.append(
            Finding(
                "duplicates",
                "info",
                names,
                f"{named(names)}: the same file as another; left out.",
                len(names),
            )
        )
    unknown = tuple(p.name for p in seen.photos if p.focal_px is None)
    if unknown:
        found.append(
            Finding(
                "no-focal-length",
                "info",
                unknown,
                f"The focal length of {len(unknown)} photos is not known: it must be found by the "
                "alignment, which takes well-spread photos with obliques.",
                len(unknown),
            )
        )
    settings = folder.cameras()
    if len(settings) > 1:
        sizes = ", ".join(
            f"{len(g)} x {g[0].camera or 'unknown camera'} ({g[0].width} x {g[0].height}"
            + (f", f = {g[0].focal_px:.0f} px)" if g[0].focal_px else ")")
            for g in list(settings.values())[:4]
        )
        sides = {(g[0].camera, g[0].width, g[0].height) for g in settings.values()}
        turned = any((c, h, w) in sides for c, w, h in sides if w != h)
        found.append(
            Finding(
                "several-cameras",
                "info",
                (),
                f"There are {len(settings)} cameras or settings, each calibrated by itself: "
                f"{sizes}{' ...' if len(settings) > 4 else ''}."
                + (
                    " Some were turned by a program; photos as the camera stored them hang "
                    "together better."
                    if turned
                    else ""
                ),
                len(settings),
            )
        )
    return found


def _best_overlap(pairs: SetLook, count: int) -> list[float]:
    best = [0.0] * count
    for pair in pairs.pairs:
        for i in (pair.first, pair.second):
            best[i] = max(best[i], pair.overlap)
    return best


def _of_pairs(seen: Looked, best: Sequence[float], limits: Limits) -> list[Finding]:
    photos, pairs = seen.photos, seen.pairs
    count = len(photos)
    if count < 2:
        return []
    found = []
    parts = pairs.parts(count)
    lonely = tuple(photos[g[0]].name for g in parts if len(g) == 1)
    larger = [g for g in parts if len(g) > 1]
    if not larger:
        return [
            Finding(
                "unmatched",
                "error",
                (),
                "No two of the photos show the same rock: a quick comparison finds fewer than 16 "
                "common points in every pair.",
                0,
            )
        ]
    if lonely:
        found.append(
            Finding(
                "unmatched",
                "warning",
                lonely,
                f"{named(lonely)}: {'matches' if len(lonely) == 1 else 'match'} no other photo; "
                "too little overlap, blur, or another subject.",
                len(lonely),
            )
        )
    if len(larger) > 1:
        sizes = ", ".join(str(len(g)) for g in larger)
        small = tuple(photos[i].name for g in larger[1:] for i in g)
        found.append(
            Finding(
                "parts",
                "warning",
                small,
                f"The photos fall into {len(larger)} parts that share no rock ({sizes} photos): "
                "they would become separate models.",
                len(larger),
            )
        )
    thin = tuple(photos[i].name for g in larger for i in g if best[i] < limits.overlap)
    if thin:
        most = max(best[i] for g in larger for i in g if best[i] < limits.overlap)
        found.append(
            Finding(
                "low-overlap",
                "warning",
                thin,
                f"{named(thin)}: {'overlaps' if len(thin) == 1 else 'overlap'} the nearest photo "
                f"by no more than {most:.0%} (60 % or more is wanted).",
                most,
            )
        )
    views = float(np.median(pairs.views))
    if count >= limits.fewest_photos and views < limits.views and pairs.pairs:
        few = tuple(p.name for i, p in enumerate(photos) if pairs.views[i] < limits.views)
        found.append(
            Finding(
                "few-views",
                "warning",
                few,
                f"Half of the rock is seen by {views:.0f} photos or fewer; four to five are wanted "
                "for every place.",
                views,
            )
        )
    found += _of_positions_seen(seen, limits)
    return found


def _of_positions_seen(seen: Looked, limits: Limits) -> list[Finding]:
    photos = seen.photos
    turned: list[tuple[str, str]] = []
    twins: list[tuple[str, str]] = []
    for pair in seen.pairs.pairs:
        if pair.baseline_ratio is None or pair.baseline_ratio > limits.same_place:
            continue
        names = photos[pair.first].name, photos[pair.second].name
        turn = pair.turn_deg or 0.0
        f1, f2 = photos[pair.first].focal_px, photos[pair.second].focal_px
        zoom = 1.0
        if f1 and f2:
            one, two = f1 / photos[pair.first].long_side, f2 / photos[pair.second].long_side
            zoom = max(one / two, two / one)
        if turn > limits.turn_deg or zoom > limits.zoom:
            turned.append(names)
        elif pair.overlap > limits.near_identical:
            twins.append(names)
    found = []
    if turned:
        those = tuple(dict.fromkeys(name for pair in turned for name in pair))
        found.append(
            Finding(
                "same-position",
                "warning",
                those,
                f"{named(those)} were taken from one position with another direction or zoom: a "
                "rotation shows no depth, and confuses the alignment (one position, one photo).",
                len(turned),
            )
        )
    if twins:
        those = tuple(dict.fromkeys(name for pair in twins for name in pair))
        found.append(
            Finding(
                "near-identical",
                "info",
                those,
                f"{named(those)} show almost the same from the same place: all but one can be left "
                "out.",
                len(twins),
            )
        )
    return found


def _of_directions(
    seen: Looked, axes: Array, known: npt.NDArray[np.bool_], limits: Limits
) -> list[Finding]:
    """One view direction only: doming (textbook 3.2.1)."""
    photos = seen.photos
    gimbal = _gimbal_axes(photos)
    source = "the drone's gimbal says"
    if gimbal is not None:
        axes, known = gimbal, np.ones(len(photos), bool)
    else:
        source = "estimated from the pictures"
    if known.sum() < 3 or known.sum() < 0.5 * len(photos):
        return []
    used = axes[known]
    middle = used.mean(axis=0)
    norm = float(np.linalg.norm(middle))
    if norm < 0.2:
        return []
    away = np.degrees(np.arccos(np.clip(used @ middle / norm, -1.0, 1.0)))
    # A stray estimate is no oblique photo; a tenth of the set (two at least) is.
    steady = max(2, math.ceil(0.1 * len(away)))
    spread = float(np.sort(away)[-steady]) if len(away) >= steady else float(away.max())
    if spread >= limits.doming_deg:
        return []
    down = gimbal is not None and bool(np.all(gimbal[:, 2] < -math.cos(math.radians(15.0))))
    what = "All photos look straight down" if down else "All photos look in nearly one direction"
    return [
        Finding(
            "one-direction",
            "warning",
            (),
            f"{what} (within {max(spread, 0.1):.2g} degrees, {source}): the model may be bent like "
            "a dome, and focal length and distance cannot be told apart, so the focal length is "
            "better held at its EXIF value. Oblique photos up to 30 degrees from the perpendicular "
            "prevent both.",
            spread,
        )
    ]


def _gimbal_axes(photos: Sequence[Photo]) -> Array | None:
    """Directions of view (n, 3) east, north, up, where every photo states its own."""
    found = []
    for photo in photos:
        if photo.yaw_deg is None or photo.pitch_deg is None:
            return None
        yaw, pitch = math.radians(photo.yaw_deg), math.radians(photo.pitch_deg)
        found.append(
            (
                math.sin(yaw) * math.cos(pitch),
                math.cos(yaw) * math.cos(pitch),
                math.sin(pitch),
            )
        )
    return np.array(found)


def _of_pixels(seen: Looked, limits: Limits) -> list[Finding]:
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
    from vomstudio.io.camera_table import find_camera

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


def _of_sizes(seen: Looked, gsd: Sequence[float | None], limits: Limits) -> list[Finding]:
    """Pixel sizes an order of magnitude apart: from distances, else along the matched pairs."""
    photos = seen.photos
    sizes: list[float | None] = list(gsd)
    if sum(value is not None for value in sizes) < len(photos):
        sizes = _relative_sizes(seen.pairs, len(photos))
    known = {i: value for i, value in enumerate(sizes) if value is not None}
    if len(known) < 2:
        return []
    ratio = max(known.values()) / min(known.values())
    if ratio <= limits.gsd_ratio:
        return []
    middle = float(np.median(list(known.values())))
    far = tuple(
        photos[i].name
        for i, value in known.items()
        if max(value / middle, middle / value) > math.sqrt(limits.gsd_ratio)
    )
    return [
        Finding(
            "gsd-spread",
            "warning",
            far,
            f"Pixels on the rock differ by a factor of {ratio:.0f} between the photos: keep them "
            "within an order of magnitude.",
            ratio,
        )
    ]


def _relative_sizes(pairs: SetLook, count: int) -> list[float | None]:
    sizes: dict[int, float] = {}
    best = sorted((p for p in pairs.pairs if p.pixel_ratio is not None), key=lambda p: -p.matches)
    if best:
        sizes[best[0].first] = 1.0
    grown = True
    while grown:
        grown = False
        for pair in best:
            i, j, ratio = pair.first, pair.second, pair.pixel_ratio
            assert ratio is not None
            # A pixel of the first is `ratio` pixels of the second.
            if i in sizes and j not in sizes:
                sizes[j] = sizes[i] / ratio
            elif j in sizes and i not in sizes:
                sizes[i] = sizes[j] * ratio
            else:
                continue
            grown = True
            break
    return [sizes.get(i) for i in range(count)]


def _of_positions(photos: Sequence[Photo], limits: Limits) -> list[Finding]:
    positions = metres_from_gps(photos)
    known = np.isfinite(positions[:, 0])
    placed = [photo for photo, k in zip(photos, known, strict=True) if k]
    names = tuple(photo.name for photo in placed)
    if not placed:
        return [
            Finding(
                "no-gps",
                "info",
                (),
                "The photos say no position: scale and orientation must come from control points, "
                "or from a measured length and a known direction in the scene.",
                0,
            )
        ]
    found = []
    at = positions[known]
    size = float(np.linalg.norm(at[:, :2] - at[:, :2].mean(axis=0), axis=1).max())
    if len(placed) > 1 and size < 0.05:
        return [
            Finding(
                "gps-equal",
                "warning",
                names,
                f"All {len(placed)} GPS positions are the same: the receiver had not updated, or "
                "wrote a place of the network. They can register nothing.",
                len(placed),
            )
        ]
    if len(placed) < 0.5 * len(photos):
        found.append(
            Finding(
                "gps-few",
                "info",
                names,
                f"Only {len(placed)} of {len(photos)} photos have a GPS position.",
                len(placed),
            )
        )
    if len(placed) >= 3:
        sigma, stated = accuracy_of(placed)
        error, _ = rotation_error95_deg(at, sigma)
        said = f"{length(sigma)} {'as the files state' if stated else 'assumed'}"
        if straightness(at) < limits.straight and error > limits.rotation_deg:
            found.append(
                Finding(
                    "collinear",
                    "warning",
                    (),
                    "The camera positions lie in one line: nothing holds a model that is "
                    "registered by them against turning about it.",
                    straightness(at),
                )
            )
        elif error > limits.rotation_deg:
            found.append(
                Finding(
                    "gps-noise",
                    "warning",
                    (),
                    f"The camera positions spread over {length(2 * size)} and are good to {said}: "
                    f"registered by them the model can be turned by {error:.0f} degrees (95 %), "
                    "and every dip with it. Control points are needed.",
                    error,
                )
            )
        else:
            found.append(
                Finding(
                    "gps-registration",
                    "info",
                    (),
                    f"Registered by the camera positions (good to {said}) the model can be turned "
                    f"by {error:.1f} degrees (95 %).",
                    error,
                )
            )
    return found
