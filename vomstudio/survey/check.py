"""What a set of photos is worth, before anything is aligned (textbook 2.4 and 3.2).

Every rule names its number and its source. Limits lean to the side of silence: a finding that is
wrong costs the trust in those that are right.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.progress import Progress, Silent
from vomstudio.survey import picture_checks, station_checks
from vomstudio.survey.camera_positions import metres_from_gps
from vomstudio.survey.check_limits import Limits, Looked
from vomstudio.survey.check_results import (
    Finding,
    PhotoFigures,
    SurveyReport,
    length,
    named,
    next_time,
    ordered,
    verdict_of,
)
from vomstudio.survey.overlap import features_of, look_at_set, optical_axes
from vomstudio.survey.photo_limits import ground_sampling_distance, smallest_plane
from vomstudio.survey.photo_quality import look_at

if TYPE_CHECKING:
    from vomstudio.io.photos.photo import Photo
    from vomstudio.io.photos.reading import PhotoFolder


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
    best = station_checks.best_overlap(seen.pairs, len(photos))
    findings = [
        *_of_the_folder(folder, seen, limits),
        *station_checks.of_pairs(seen, best, limits),
        *station_checks.of_directions(seen, axes, known_axes, limits),
        *picture_checks.of_pixels(seen, limits),
        *station_checks.of_sizes(seen, gsd, limits),
        *station_checks.of_positions(photos, limits),
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
