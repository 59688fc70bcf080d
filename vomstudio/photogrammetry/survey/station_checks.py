"""Checks of camera stations: overlap, view directions, distances, GPS (textbook 3.2)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.findings import Finding
from vomstudio.photogrammetry.survey.camera_positions import (
    median_accuracy,
    metres_from_gps,
    rotation_error95_deg,
    width_to_length_ratio,
)
from vomstudio.photogrammetry.survey.check_limits import Limits, SurveyMeasurements
from vomstudio.photogrammetry.survey.overlap import MIN_MATCHES, SetOverlap

if TYPE_CHECKING:
    from vomstudio.io.photos.photo import Photo


def best_overlap(pairs: SetOverlap, count: int) -> list[float]:
    """Return the largest overlap (0 to 1) of each of `count` photos with another one."""
    best_overlaps = [0.0] * count
    for pair in pairs.pairs:
        for i in (pair.first, pair.second):
            best_overlaps[i] = max(best_overlaps[i], pair.overlap)
    return best_overlaps


def pair_findings(
    measurements: SurveyMeasurements, best_overlaps: Sequence[float], limits: Limits
) -> list[Finding]:
    """Return findings on matches, overlap and baseline.

    best_overlaps : result of `best_overlap`
    """
    photos, pairs = measurements.photos, measurements.pairs
    count = len(photos)
    if count < 2:
        return []
    findings = []
    components = pairs.components(count)
    larger_components = [g for g in components if len(g) > 1]
    if not larger_components:
        return [
            Finding(
                "unmatched", "error", photos=[p.name for p in photos], value=0, least=MIN_MATCHES
            )
        ]
    findings += _component_findings(photos, components)
    low_overlap = tuple(
        photos[i].name for g in larger_components for i in g if best_overlaps[i] < limits.overlap
    )
    if low_overlap:
        max_overlap = max(
            best_overlaps[i]
            for g in larger_components
            for i in g
            if best_overlaps[i] < limits.overlap
        )
        findings.append(
            Finding("low-overlap", photos=low_overlap, value=max_overlap, overlap=100 * max_overlap)
        )
    views = float(np.median(pairs.views))
    if count >= limits.min_photos and views < limits.views and pairs.pairs:
        photos_with_few_views = tuple(
            p.name for i, p in enumerate(photos) if pairs.views[i] < limits.views
        )
        findings.append(Finding("few-views", photos=photos_with_few_views, value=views))
    findings += _same_position_findings(measurements, limits)
    return findings


def _component_findings(
    photos: Sequence[Photo], components: Sequence[Sequence[int]]
) -> list[Finding]:
    """Find photos without matches, and components without common matches.

    components : rows, largest first
    """
    findings = []
    unmatched = tuple(photos[g[0]].name for g in components if len(g) == 1)
    larger_components = [g for g in components if len(g) > 1]
    if unmatched:
        findings.append(Finding("unmatched", photos=unmatched, value=len(unmatched)))
    if len(larger_components) > 1:
        disconnected_photos = tuple(photos[i].name for g in larger_components[1:] for i in g)
        findings.append(
            Finding(
                "parts",
                photos=disconnected_photos,
                value=len(larger_components),
                sizes=[len(g) for g in larger_components],
            )
        )
    return findings


def _same_position_findings(measurements: SurveyMeasurements, limits: Limits) -> list[Finding]:
    photos = measurements.photos
    rotated_pairs: list[tuple[str, str]] = []
    identical_pairs: list[tuple[str, str]] = []
    for pair in measurements.pairs.pairs:
        if pair.baseline_ratio is None or pair.baseline_ratio > limits.max_baseline_ratio:
            continue
        names = photos[pair.first].name, photos[pair.second].name
        angle = pair.turn_deg or 0.0
        f1, f2 = photos[pair.first].focal_px, photos[pair.second].focal_px
        zoom = 1.0
        if f1 and f2:
            first_focal, second_focal = (
                f1 / photos[pair.first].long_side,
                f2 / photos[pair.second].long_side,
            )
            zoom = max(first_focal / second_focal, second_focal / first_focal)
        if angle > limits.turn_deg or zoom > limits.zoom:
            rotated_pairs.append(names)
        elif pair.overlap > limits.near_identical_overlap:
            identical_pairs.append(names)
    findings = []
    if rotated_pairs:
        photo_names = _photos_of_pairs(rotated_pairs)
        findings.append(Finding("same-position", photos=photo_names, value=len(rotated_pairs)))
    if identical_pairs:
        photo_names = _photos_of_pairs(identical_pairs)
        findings.append(Finding("near-identical", photos=photo_names, value=len(identical_pairs)))
    return findings


def _photos_of_pairs(pairs: Sequence[tuple[str, str]]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(name for pair in pairs for name in pair))


def direction_findings(
    measurements: SurveyMeasurements, axes: FloatArray, is_known: BoolArray, limits: Limits
) -> list[Finding]:
    """Find surveys with one view direction only, which causes doming (textbook 3.2.1)."""
    photos = measurements.photos
    gimbal_axes = _gimbal_axes(photos)
    if gimbal_axes is not None:
        axes, is_known = gimbal_axes, np.ones(len(photos), bool)
    if is_known.sum() < 3 or is_known.sum() < 0.5 * len(photos):
        return []
    used_axes = axes[is_known]
    mean_axis = used_axes.mean(axis=0)
    norm = float(np.linalg.norm(mean_axis))
    if norm < 0.2:
        return []
    angles = np.degrees(np.arccos(np.clip(used_axes @ mean_axis / norm, -1.0, 1.0)))
    # Ignore outliers: obliques are a tenth of the set, at least two.
    outlier_count = max(2, math.ceil(0.1 * len(angles)))
    spread = (
        float(np.sort(angles)[-outlier_count])
        if len(angles) >= outlier_count
        else float(angles.max())
    )
    if spread >= limits.doming_deg:
        return []
    is_down = gimbal_axes is not None and bool(
        np.all(gimbal_axes[:, 2] < -math.cos(math.radians(15.0)))
    )
    source = "photos" if gimbal_axes is None else "gimbal"
    return [Finding("one-direction", photos=(), value=spread, source=source, straight_down=is_down)]


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
    """Find pixel sizes an order of magnitude apart, from distances or from matched pairs."""
    photos = measurements.photos
    sizes: list[float | None] = list(gsd)
    if sum(value is not None for value in sizes) < len(photos):
        sizes = _relative_sizes(measurements.pairs, len(photos))
    known_sizes = {i: value for i, value in enumerate(sizes) if value is not None}
    if len(known_sizes) < 2:
        return []
    ratio = max(known_sizes.values()) / min(known_sizes.values())
    if ratio <= limits.gsd_ratio:
        return []
    median = float(np.median(list(known_sizes.values())))
    outlying_photos = tuple(
        photos[i].name
        for i, value in known_sizes.items()
        if max(value / median, median / value) > math.sqrt(limits.gsd_ratio)
    )
    return [Finding("gsd-spread", photos=outlying_photos, value=ratio)]


def _relative_sizes(pairs: SetOverlap, count: int) -> list[float | None]:
    sizes: dict[int, float] = {}
    best_pairs = sorted(
        (p for p in pairs.pairs if p.pixel_ratio is not None), key=lambda p: -p.matches
    )
    if best_pairs:
        sizes[best_pairs[0].first] = 1.0
    has_grown = True
    while has_grown:
        has_grown = False
        for pair in best_pairs:
            i, j, ratio = pair.first, pair.second, pair.pixel_ratio
            assert ratio is not None
            # A pixel of the first is `ratio` pixels of the second.
            if i in sizes and j not in sizes:
                sizes[j] = sizes[i] / ratio
            elif j in sizes and i not in sizes:
                sizes[i] = sizes[j] * ratio
            else:
                continue
            has_grown = True
            break
    return [sizes.get(i) for i in range(count)]


def position_findings(photos: Sequence[Photo], limits: Limits) -> list[Finding]:
    """Return findings on GPS positions: whether and how well they would register a model."""
    positions = metres_from_gps(photos)
    is_known = np.isfinite(positions[:, 0])
    located_photos = [photo for photo, k in zip(photos, is_known, strict=True) if k]
    names = tuple(photo.name for photo in located_photos)
    if not located_photos:
        return [Finding("no-gps", photos=(), value=0)]
    findings = []
    located_positions = positions[is_known]
    if len(located_photos) > 1 and _radius(located_positions) < 0.05:
        return [Finding("gps-equal", photos=names, value=len(located_photos))]
    if len(located_photos) < 0.5 * len(photos):
        findings.append(
            Finding("gps-few", photos=names, value=len(located_photos), total=len(photos))
        )
    if len(located_photos) >= 3:
        findings.append(_gps_accuracy_finding(located_photos, located_positions, limits))
    return findings


def _gps_accuracy_finding(
    located_photos: Sequence[Photo], positions: FloatArray, limits: Limits
) -> Finding:
    """Report how well positions (n, 3) of photos determine the rotation of a model."""
    sigma, has_stated_accuracy = median_accuracy(located_photos)
    error, _ = rotation_error95_deg(positions, sigma)
    if width_to_length_ratio(positions) < limits.min_width_ratio and error > limits.rotation_deg:
        return Finding("collinear", photos=(), value=width_to_length_ratio(positions))
    if error > limits.rotation_deg:
        return Finding(
            "gps-noise",
            photos=(),
            value=error,
            extent_m=2 * _radius(positions),
            sigma_m=sigma,
            stated=has_stated_accuracy,
        )
    return Finding(
        "gps-registration", photos=(), value=error, sigma_m=sigma, stated=has_stated_accuracy
    )


def _radius(positions: FloatArray) -> float:
    """Return the largest horizontal distance of positions (n, 3) from their mean."""
    return float(np.linalg.norm(positions[:, :2] - positions[:, :2].mean(axis=0), axis=1).max())
