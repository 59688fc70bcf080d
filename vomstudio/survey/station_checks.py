"""Where photos were taken from: overlap, view directions, distances, GPS (textbook 3.2)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from vomstudio.survey.camera_positions import (
    accuracy_of,
    metres_from_gps,
    rotation_error95_deg,
    straightness,
)
from vomstudio.survey.check_limits import Limits, Looked
from vomstudio.survey.check_results import Finding, length, named
from vomstudio.survey.overlap import SetLook

if TYPE_CHECKING:
    from vomstudio.io.photos.photo import Photo

Array = npt.NDArray[np.float64]


def best_overlap(pairs: SetLook, count: int) -> list[float]:
    best = [0.0] * count
    for pair in pairs.pairs:
        for i in (pair.first, pair.second):
            best[i] = max(best[i], pair.overlap)
    return best


def of_pairs(seen: Looked, best: Sequence[float], limits: Limits) -> list[Finding]:
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
        those = _in_any(turned)
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
        those = _in_any(twins)
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


def _in_any(pairs: Sequence[tuple[str, str]]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(name for pair in pairs for name in pair))


def of_directions(
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


def of_sizes(seen: Looked, gsd: Sequence[float | None], limits: Limits) -> list[Finding]:
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


def of_positions(photos: Sequence[Photo], limits: Limits) -> list[Finding]:
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
