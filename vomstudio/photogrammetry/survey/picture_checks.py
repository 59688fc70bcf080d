"""Checks of individual pictures for blur, enlarged pixels and light (textbook 2.4)."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.findings import Finding
from vomstudio.photogrammetry.survey.check_limits import Limits, SurveyMeasurements

if TYPE_CHECKING:
    from vomstudio.io.photos.photo import Photo


def pixel_findings(measurements: SurveyMeasurements, limits: Limits) -> list[Finding]:
    """Return findings on blur, digital zoom, enlargement, exposure and light."""
    blurs = {
        photo.name: quality.blur_px
        for photo, quality in zip(measurements.photos, measurements.quality, strict=True)
        if quality.blur_px is not None
    }
    findings = blur_findings(blurs, limits)
    findings += _enlargement_findings(measurements, limits)
    findings += _light_findings(measurements, limits)
    return findings


def blur_findings(blurs: Mapping[str, float], limits: Limits) -> list[Finding]:
    """Return findings on blurred photos, and on sets in which no photo is sharp.

    The sharpest quarter of the photos shows what the camera can resolve, even if most photos are
    blurred. Above `soft_blur_px`, a photo is blurred whatever the others are like, unless even the
    sharpest quarter is that soft.

    Parameters
    ----------
    blurs : mapping of str to float
        Blur of the photos, as one sigma in pixels, by name.
    limits : Limits
    """
    if not blurs:
        return []
    values = np.array(list(blurs.values()))
    sharp = float(np.percentile(values, 25))
    is_soft = sharp > limits.soft_blur_px
    limit = max(limits.blur_px, limits.max_blur_ratio * sharp)
    if not is_soft:
        limit = min(limit, limits.soft_blur_px)
    findings = []
    blurred_photos = tuple(name for name, value in blurs.items() if value > limit)
    if blurred_photos:
        findings.append(
            Finding("blurred", photos=blurred_photos, value=float(values.max()), sharp=sharp)
        )
    if is_soft:
        median = float(np.median(values))
        findings.append(Finding("soft", photos=(), value=median, factor=median / 0.8))
    return findings


def _enlargement_findings(measurements: SurveyMeasurements, limits: Limits) -> list[Finding]:
    from vomstudio.io.photos.camera_table import find_camera

    findings = []
    photos = measurements.photos
    zoom_factors = {
        p.name: p.digital_zoom for p in photos if p.digital_zoom and p.digital_zoom > 1.05
    }
    photos_by_lens: dict[tuple[object, ...], list[Photo]] = defaultdict(list)
    for photo in photos:
        if photo.focal_mm and photo.focal_35mm:
            photos_by_lens[photo.camera, photo.serial, photo.lens, photo.focal_mm].append(photo)
    for group in photos_by_lens.values():
        min_focal = min(p.focal_35mm or math.inf for p in group)
        for photo in group:
            # A narrower picture with the same lens setting was cropped and enlarged.
            if (photo.focal_35mm or 0) > 1.15 * min_focal and photo.long_side >= max(
                p.long_side for p in group if p.focal_35mm == min_focal
            ):
                zoom_factors.setdefault(photo.name, (photo.focal_35mm or 0) / min_focal)
    if zoom_factors:
        max_zoom = max(value or 1.0 for value in zoom_factors.values())
        findings.append(Finding("digital-zoom", photos=tuple(zoom_factors), value=max_zoom))
    enlarged_photos = []
    for photo in photos:
        model = find_camera(photo.camera)
        if model is not None and photo.long_side > 1.05 * max(model.width_px, model.height_px):
            enlarged_photos.append(photo.name)
    if enlarged_photos:
        model = find_camera(next(p.camera for p in photos if p.name == enlarged_photos[0]))
        assert model is not None
        findings.append(
            Finding(
                "enlarged",
                photos=tuple(enlarged_photos),
                value=len(enlarged_photos),
                camera=model.label,
                width_px=model.width_px,
            )
        )
    measured_photos = [quality for quality in measurements.quality if quality.blur_px is not None]
    resampled_photos = [
        quality
        for quality in measured_photos
        if (quality.resampling_strength or 0.0) >= limits.resampling_strength
    ]
    median = (
        float(np.median([quality.blur_px or 0.0 for quality in measured_photos]))
        if measured_photos
        else 0.0
    )
    # Undistortion and reduction also leave a trace, but do no harm.
    if (
        not enlarged_photos
        and len(resampled_photos) > 0.6 * len(measured_photos)
        and median > limits.enlarged_blur_px
    ):
        findings.append(
            Finding(
                "enlarged",
                photos=[
                    p.name
                    for p, quality in zip(photos, measurements.quality, strict=True)
                    if (quality.resampling_strength or 0.0) >= limits.resampling_strength
                ],
                value=median,
            )
        )
    return findings


def _light_findings(measurements: SurveyMeasurements, limits: Limits) -> list[Finding]:
    findings = []
    photos = measurements.photos
    badly_exposed_rows = {
        i
        for i, quality in enumerate(measurements.quality)
        if quality.brightness is not None
        and (
            quality.brightness < limits.min_brightness
            or (quality.saturated_share or 0.0) > limits.saturated_share
        )
    }
    if badly_exposed_rows:
        names = tuple(photos[i].name for i in sorted(badly_exposed_rows))
        findings.append(Finding("exposure", photos=names, value=len(names)))
    log_brightness = {
        i: math.log2(quality.brightness)
        for i, quality in enumerate(measurements.quality)
        if quality.brightness is not None and quality.brightness > 0 and i not in badly_exposed_rows
    }
    if len(log_brightness) >= 3:
        median = float(np.median(list(log_brightness.values())))
        brightness_jumps = tuple(
            photos[i].name for i, v in log_brightness.items() if abs(v - median) > limits.stops
        )
        if brightness_jumps:
            worst_difference = max((v - median for v in log_brightness.values()), key=abs)
            findings.append(
                Finding(
                    "brightness-jump",
                    photos=brightness_jumps,
                    value=worst_difference,
                    stops=abs(worst_difference),
                )
            )
    return findings + _time_findings(photos, limits)


def _time_findings(photos: Sequence[Photo], limits: Limits) -> list[Finding]:
    """Find changes of light, by metered exposures and by the time of day."""
    findings = []
    exposures = [p.exposure_value for p in photos if p.exposure_value is not None]
    if len(exposures) >= 3:
        spread = float(np.quantile(exposures, 0.95) - np.quantile(exposures, 0.05))
        if spread > limits.max_exposure_stops:
            findings.append(Finding("light-changed", photos=(), value=spread))
    times = sorted(p.taken_at for p in photos if p.taken_at is not None)
    if len(times) >= 2:
        hours = (times[-1] - times[0]).total_seconds() / 3600.0
        if hours > limits.hours:
            findings.append(Finding("long-survey", photos=(), value=hours))
    return findings
