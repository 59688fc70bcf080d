"""Checks of a set of photos before the alignment (textbook 2.4 and 3.2).

Every rule states its limit and its source. The limits are conservative, because a wrong finding
reduces the trust in correct ones.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.words import tr
from vomstudio.geometry.plane_sizes import PlaneSizes
from vomstudio.geometry.units import length_text
from vomstudio.photogrammetry.survey import picture_checks, station_checks
from vomstudio.photogrammetry.survey.camera_positions import metres_from_gps
from vomstudio.photogrammetry.survey.check_limits import Limits, SurveyMeasurements
from vomstudio.photogrammetry.survey.check_results import (
    PhotoFigures,
    SurveyReport,
    assess,
    collect_advice,
    sort_by_severity,
)
from vomstudio.photogrammetry.survey.overlap import compare_photos, extract_features, optical_axes
from vomstudio.photogrammetry.survey.photo_quality import measure_quality
from vomstudio.photogrammetry.survey.survey_resolution import (
    expected_planes,
    ground_sampling_distance,
)

if TYPE_CHECKING:
    from vomstudio.io.photos.photo import Photo
    from vomstudio.io.photos.reading import PhotoFolder


def measure_folder(folder: PhotoFolder, progress: Progress | None = None) -> SurveyMeasurements:
    """Decode and compare all photos of a folder once.

    If a photo cannot be decoded, the `error` of its quality states the reason. Raises Cancelled.
    """
    progress = progress or SilentProgress()
    photos = tuple(folder.photos)
    progress.stage(tr("Measuring photo quality"), len(photos))
    quality, features = [], []
    for done_count, photo in enumerate(photos):
        progress.step(done_count)
        quality.append(measure_quality(photo))
        features.append(None if quality[-1].error else extract_features(photo))
    progress.step(len(photos))
    pairs = compare_photos(features, metres_from_gps(photos), progress)
    return SurveyMeasurements(photos, tuple(quality), tuple(features), pairs)


def check_photos(
    folder: PhotoFolder,
    *,
    distance_m: float | None = None,
    limits: Limits | None = None,
    progress: Progress | None = None,
) -> SurveyReport:
    """Check photos before the alignment.

    distance_m : distance from the camera to the rock; by default, the distance is derived from the
        height of a drone that looks down, and is otherwise unknown
    """
    return report(measure_folder(folder, progress), folder, distance_m, limits or Limits())


def report(
    measurements: SurveyMeasurements, folder: PhotoFolder, distance_m: float | None, limits: Limits
) -> SurveyReport:
    """Return the findings, figures and verdict for existing measurements.

    distance_m : distance from the camera to the rock, or None if unknown
    """
    photos = measurements.photos
    gsd = [pixel_size(photo, distance_m) for photo in photos]
    axes, is_known = optical_axes(measurements.pairs, len(photos))
    best_overlap = station_checks.best_overlap(measurements.pairs, len(photos))
    findings = [
        *_folder_findings(folder, measurements, limits),
        *station_checks.pair_findings(measurements, best_overlap, limits),
        *station_checks.direction_findings(measurements, axes, is_known, limits),
        *picture_checks.pixel_findings(measurements, limits),
        *station_checks.size_findings(measurements, gsd, limits),
        *station_checks.position_findings(photos, limits),
    ]
    findings = list(sort_by_severity(findings))
    known_gsd = [value for value in gsd if value is not None]
    median_gsd_m = float(np.median(known_gsd)) if known_gsd else None
    planes = None if median_gsd_m is None else PlaneSizes.from_pixel_size(median_gsd_m)
    figures = tuple(
        PhotoFigures(
            photo.name,
            gsd[i],
            measurements.quality[i].blur_px,
            float(measurements.pairs.views[i]),
            measurements.quality[i].brightness,
            best_overlap[i],
        )
        for i, photo in enumerate(photos)
    )
    return SurveyReport(
        "before",
        figures,
        tuple(findings),
        assess(findings, median_gsd_m, hint=_hint_findings(photos)),
        median_gsd_m,
        None if planes is None else planes.textbook,
        collect_advice(findings),
        () if planes is None else planes.curve(),
    )


def pixel_size(photo: Photo, distance_m: float | None = None) -> float | None:
    """Return the pixel size on the rock in metres (eq. 18).

    It follows from the given distance, or from the height of a drone that looks down. Returns None
    if the distance or the focal length is unknown.
    """
    if photo.focal_px is None:
        return None
    distance = distance_m
    height, pitch = photo.relative_altitude_m, photo.pitch_deg
    if distance is None and height is not None and pitch is not None and pitch <= -45.0:
        distance = height / math.sin(math.radians(-pitch))
    if distance is None or distance <= 0:
        return None
    # In pixels, the sensor width cancels: Sw / f = Iw / f_px.
    return ground_sampling_distance(photo.long_side, photo.focal_px, distance, photo.long_side)


def _hint_findings(photos: Sequence[Photo]) -> tuple[Finding, ...]:
    focal = [p.focal_px for p in photos if p.focal_px is not None]
    if not focal:
        return (Finding("survey.pixel-size-unknown"),)
    distance_m = 10.0
    gsd_m = distance_m / float(np.median(focal))
    pixel = length_text(gsd_m, 2)
    return (
        Finding("survey.pixel-size-at-distance", distance_m=distance_m, pixel=pixel),
        expected_planes(PlaneSizes.from_pixel_size(gsd_m)),
    )


def _folder_findings(
    folder: PhotoFolder, measurements: SurveyMeasurements, limits: Limits
) -> list[Finding]:
    findings = []
    count = len(measurements.photos)
    if count == 1:
        findings.append(Finding("one-photo", photos=(), value=1))
    elif count < limits.min_photos:
        findings.append(Finding("few-photos", photos=(), value=count, count=count))
    damaged_photos = tuple(
        p.name
        for p, quality in zip(measurements.photos, measurements.quality, strict=True)
        if quality.error
    )
    if damaged_photos:
        reason = next(quality.error for quality in measurements.quality if quality.error)
        findings.append(
            Finding("damaged", photos=damaged_photos, value=len(damaged_photos), reason=reason)
        )
    if folder.duplicates:
        names = tuple(name for name, _ in folder.duplicates)
        findings.append(Finding("duplicates", photos=names, value=len(names)))
    photos_without_focal = tuple(p.name for p in measurements.photos if p.focal_px is None)
    if photos_without_focal:
        findings.append(
            Finding(
                "no-focal-length",
                photos=photos_without_focal,
                value=len(photos_without_focal),
                count=len(photos_without_focal),
            )
        )
    return findings + _camera_findings(folder)


def _camera_findings(folder: PhotoFolder) -> list[Finding]:
    """Find sets with several cameras or settings, and photos rotated by a program."""
    settings = folder.cameras()
    if len(settings) < 2:
        return []
    groups = [_describe_group(group) for group in settings.values()]
    findings = [Finding("several-cameras", photos=(), value=len(settings), cameras=groups)]
    photo_sizes = {(g[0].camera, g[0].width, g[0].height) for g in settings.values()}
    rotated_sizes = {
        (camera, w, h) for camera, w, h in photo_sizes if w != h and (camera, h, w) in photo_sizes
    }
    if rotated_sizes:
        names = [p.name for p in folder.photos if (p.camera, p.width, p.height) in rotated_sizes]
        findings.append(Finding("survey.turned-photos", photos=names, value=len(names)))
    return findings


def _describe_group(group: Sequence[Photo]) -> str:
    """Describe photos that share a calibration: number, camera, size and focal length."""
    first_photo = group[0]
    camera = first_photo.camera or tr("unknown camera")
    if first_photo.focal_px:
        return tr(
            "{count} x {camera} ({width} x {height}, f = {focal:.0f} px)",
            count=len(group),
            camera=camera,
            width=first_photo.width,
            height=first_photo.height,
            focal=first_photo.focal_px,
        )
    return tr(
        "{count} x {camera} ({width} x {height})",
        count=len(group),
        camera=camera,
        width=first_photo.width,
        height=first_photo.height,
    )
