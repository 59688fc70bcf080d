"""Checks of camera stations: overlap, view directions, distances, GPS (textbook 3.2)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.findings import Finding
from vomstudio.photogrammetry.survey.camera_positions import (
    accuracy_of,
    metres_from_gps,
    rotation_error95_deg,
    straightness,
)
from vomstudio.photogrammetry.survey.check_limits import Limits, SurveyMeasurements
from vomstudio.photogrammetry.survey.overlap import MIN_MATCHES, SetOverlap

if TYPE_CHECKING:
    from vomstudio.io.photos.photo import Photo


def best_overlap(pairs: SetOverlap, count: int) -> list[float]:
    """Return the largest overlap (0 to 1) of each of `count` photos with another one."""
    best = [0.0] * count
    for pair in pairs.pairs:
        for i in (pair.first, pair.second):
            best[i] = max(best[i], pair.overlap)
    return best


def pair_findings(
    measurements: SurveyMeasurements, best: Sequence[float], limits: Limits
) -> list[Finding]:
    """Return findings on matches, overlap and base; `best` is defined by `best_overlap`."""
    photos, pairs = measurements.photos, measurements.pairs
    count = len(photos)
    if count < 2:
        return []
    findings = []
    parts = pairs.components(count)
    larger = [g for g in parts if len(g) > 1]
    if not larger:
        return [
            Finding(
                "unmatched", "error", photos=[p.name for p in photos], value=0, least=MIN_MATCHES
            )
        ]
    findings += _component_findings(photos, parts)
    low_overlap = tuple(photos[i].name for g in larger for i in g if best[i] < limits.overlap)
    if low_overlap:
        max_overlap = max(best[i] for g in larger for i in g if best[i] < limits.overlap)
        findings.append(
            Finding("low-overlap", photos=low_overlap, value=max_overlap, overlap=100 * max_overlap)
        )
    views = float(np.median(pairs.views))
    if count >= limits.fewest_photos and views < limits.views and pairs.pairs:
        few = tuple(p.name for i, p in enumerate(photos) if pairs.views[i] < limits.views)
        findings.append(Finding("few-views", photos=few, value=views))
    findings += _same_position_findings(measurements, limits)
    return findings


def _component_findings(photos: Sequence[Photo], parts: Sequence[Sequence[int]]) -> list[Finding]:
    """Find photos without matches, and components without common matches.

    parts : rows, largest first
    """
    findings = []
    unmatched = tuple(photos[g[0]].name for g in parts if len(g) == 1)
    larger = [g for g in parts if len(g) > 1]
    if unmatched:
        findings.append(Finding("unmatched", photos=unmatched, value=len(unmatched)))
    if len(larger) > 1:
        small = tuple(photos[i].name for g in larger[1:] for i in g)
        findings.append(
            Finding("parts", photos=small, value=len(larger), sizes=[len(g) for g in larger])
        )
    return findings


def _same_position_findings(measurements: SurveyMeasurements, limits: Limits) -> list[Finding]:
    photos = measurements.photos
    turned: list[tuple[str, str]] = []
    twins: list[tuple[str, str]] = []
    for pair in measurements.pairs.pairs:
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
    findings = []
    if turned:
        photos_of_group = _photos_of_pairs(turned)
        findings.append(Finding("same-position", photos=photos_of_group, value=len(turned)))
    if twins:
        photos_of_group = _photos_of_pairs(twins)
        findings.append(Finding("near-identical", photos=photos_of_group, value=len(twins)))
    return findings


def _photos_of_pairs(pairs: Sequence[tuple[str, str]]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(name for pair in pairs for name in pair))


def direction_findings(
    measurements: SurveyMeasurements, axes: FloatArray, known: BoolArray, limits: Limits
) -> list[Finding]:
    """Find surveys with one view direction only, which causes doming (textbook 3.2.1)."""
    photos = measurements.photos
    gimbal = _gimbal_axes(photos)
    if gimbal is not None:
        axes, known = gimbal, np.ones(len(photos), bool)
    if known.sum() < 3 or known.sum() < 0.5 * len(photos):
        return []
    used = axes[known]
    middle = used.mean(axis=0)
    norm = float(np.linalg.norm(middle))
    if norm < 0.2:
        return []
    away = np.degrees(np.arccos(np.clip(used @ middle / norm, -1.0, 1.0)))
    # Ignore outliers: obliques are a tenth of the set, at least two.
    steady = max(2, math.ceil(0.1 * len(away)))
    spread = float(np.sort(away)[-steady]) if len(away) >= steady else float(away.max())
    if spread >= limits.doming_deg:
        return []
    down = gimbal is not None and bool(np.all(gimbal[:, 2] < -math.cos(math.radians(15.0))))
    source = "photos" if gimbal is None else "gimbal"
    return [Finding("one-direction", photos=(), value=spread, source=source, straight_down=down)]


def _gimbal_axes(photos: Sequence[Photo]) -> FloatArray | None:
    """Return the view directions (n, 3) east, north, up, or None if a photo states none."""
    axes = []
    for photo in photos:
        if photo.yaw_deg is None or photo.pitch_deg is None:
            return None
        yaw, pitch = math.radians(photo.yaw_deg), math.radians(photo.pitch_deg)
        axes.append(
            (
                math.sin(yaw) * math.cos(pitch),
                math.cos(yaw) * math.cos(pitch),
                math.sin(pitch),
            )
        )
    return np.array(axes)


def size_findings(
    measurements: SurveyMeasurements, gsd: Sequence[float | None], limits: Limits
) -> list[Finding]:
    """Find pixel sizes an order of magnitude apart, from distances or along matched pairs."""
    photos = measurements.photos
    sizes: list[float | None] = list(gsd)
    if sum(value is not None for value in sizes) < len(photos):
        sizes = _relative_sizes(measurements.pairs, len(photos))
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
    return [Finding("gsd-spread", photos=far, value=ratio)]


def _relative_sizes(pairs: SetOverlap, count: int) -> list[float | None]:
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


def position_findings(photos: Sequence[Photo], limits: Limits) -> list[Finding]:
    """Return findings on GPS positions: whether and how well they would register a model."""
    positions = metres_from_gps(photos)
    known = np.isfinite(positions[:, 0])
    placed = [photo for photo, k in zip(photos, known, strict=True) if k]
    names = tuple(photo.name for photo in placed)
    if not placed:
        return [Finding("no-gps", photos=(), value=0)]
    findings = []
    located = positions[known]
    if len(placed) > 1 and _radius(located) < 0.05:
        return [Finding("gps-equal", photos=names, value=len(placed))]
    if len(placed) < 0.5 * len(photos):
        findings.append(Finding("gps-few", photos=names, value=len(placed), total=len(photos)))
    if len(placed) >= 3:
        findings.append(_gps_accuracy_finding(placed, located, limits))
    return findings


def _gps_accuracy_finding(placed: Sequence[Photo], at: FloatArray, limits: Limits) -> Finding:
    """Report how well positions (n, 3) of photos determine the rotation of a model."""
    sigma, stated = accuracy_of(placed)
    error, _ = rotation_error95_deg(at, sigma)
    if straightness(at) < limits.straight and error > limits.rotation_deg:
        return Finding("collinear", photos=(), value=straightness(at))
    if error > limits.rotation_deg:
        return Finding(
            "gps-noise",
            photos=(),
            value=error,
            extent_m=2 * _radius(at),
            sigma_m=sigma,
            stated=stated,
        )
    return Finding("gps-registration", photos=(), value=error, sigma_m=sigma, stated=stated)


def _radius(at: FloatArray) -> float:
    """Return the largest horizontal distance of positions (n, 3) from their mean."""
    return float(np.linalg.norm(at[:, :2] - at[:, :2].mean(axis=0), axis=1).max())
