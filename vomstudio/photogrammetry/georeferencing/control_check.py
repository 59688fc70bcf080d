"""Checks of control points and their marks before a reconstruction."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding, to_finding
from vomstudio.core.results import Result, to_dict
from vomstudio.core.words import tr, tr_n
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.io.photos.photo_names import photo_finder
from vomstudio.photogrammetry.align.photo_protocol import PhotoLike
from vomstudio.photogrammetry.georeferencing.control import (
    MIN_PHOTOS,
    MIN_POINTS,
    RECOMMENDED_PHOTOS,
    RECOMMENDED_POINTS,
)
from vomstudio.photogrammetry.georeferencing.control_adjustment import require_width
from vomstudio.photogrammetry.georeferencing.mark_observations import report_coincident_marks

_MAX_DISTANCE_M = 5000.0
"""Points farther than this from the cameras' GPS positions are taken to be in another CRS."""


@dataclass(frozen=True)
class PointCheck:
    """Check of a single point.

    Attributes
    ----------
    use : str
        "control" or "check".
    photos : int
        Number of photos in which the point is marked.
    """

    label: str
    use: str
    photos: int

    @property
    def is_usable(self) -> bool:
        """Whether the point is marked in enough photos to be located."""
        return self.photos >= MIN_PHOTOS

    @property
    def quality(self) -> str:
        """Quality "good", "doubtful" or "poor", depending on the number of photos."""
        return (
            "good"
            if self.photos >= RECOMMENDED_PHOTOS
            else "doubtful"
            if self.is_usable
            else "poor"
        )


@dataclass(frozen=True)
class ControlCheck(Result):
    """Check of control points.

    Attributes
    ----------
    problem : Finding or None
        Reason why the points cannot register a model.
    crs : str or None
        CRS of the points, "EPSG:n", as requested, stated or guessed; None for a local frame.
    crs_reason : Finding
        Source of the CRS.
    """

    points: tuple[PointCheck, ...]
    crs: str | None
    crs_reason: Finding
    problem: Finding | None
    warnings: tuple[Finding, ...]

    def _points_by_use(self, use: str) -> list[PointCheck]:
        return [point for point in self.points if point.use == use and point.is_usable]

    @property
    def summary(self) -> Finding:
        """Finding with the numbers of usable points and of the photos in which they are marked."""
        control, check = len(self._points_by_use("control")), len(self._points_by_use("check"))
        points = tr(
            "{control}, {check}",
            control=tr_n("{count} control point", "{count} control points", control),
            check=tr_n("{count} check point", "{count} check points", check),
        )
        photo_counts = [point.photos for point in self.points if point.is_usable]
        return Finding(
            "control.usable",
            points=points,
            control=control,
            check=check,
            least=min(photo_counts, default=0),
            most=max(photo_counts, default=0),
        )

    def to_dict(self) -> dict[str, Any]:
        points = [to_dict(point) | {"quality": point.quality} for point in self.points]
        return super().to_dict() | {"points": points, "summary": self.summary.to_dict()}


def check_control(
    control: Sequence[ControlPoint],
    marks: Sequence[Mark],
    photos: Sequence[PhotoLike],
    crs: str | None = None,
    crs_reason: Finding | None = None,
) -> ControlCheck:
    """Check whether points can register a model of these photos.

    Parameters
    ----------
    control : sequence of ControlPoint
    marks : sequence of Mark
    photos : sequence of PhotoLike
    crs : str, optional
        CRS of the points, if known. Otherwise the UTM zone of the photos' GPS positions is proposed
        if the points are near them.
    crs_reason : Finding, optional
        Source of `crs`; None if the user selected it.
    """
    find_photo = photo_finder([photo.name for photo in photos])
    photos_by_label: dict[str, set[int]] = {point.label: set() for point in control}
    unknown_photos: dict[str, None] = {}
    photos_by_unknown_label: dict[str, set[int]] = {}
    for mark in marks:
        number = find_photo(mark.photo)
        if number is None:
            unknown_photos.setdefault(mark.photo)
        if number is not None:
            (
                photos_by_label if mark.label in photos_by_label else photos_by_unknown_label
            ).setdefault(mark.label, set()).add(number)
    points = tuple(
        PointCheck(p.label, "check" if p.check else "control", len(photos_by_label[p.label]))
        for p in control
    )
    code, reason, crs_findings = _determine_crs(
        control, photos, crs, crs_reason or Finding("control.crs-chosen")
    )
    return ControlCheck(
        points,
        code,
        reason,
        _find_problem(control, points, unknown_photos, sorted(photos_by_unknown_label)),
        (
            *crs_findings,
            *report_coincident_marks(marks),
            *_table_findings(points, unknown_photos, photos_by_unknown_label),
        ),
    )


def _find_problem(
    control: Sequence[ControlPoint],
    points: Sequence[PointCheck],
    no_photo: dict[str, None],
    no_point: Sequence[str],
) -> Finding | None:
    positions = [
        p.position
        for p, point_check in zip(control, points, strict=True)
        if point_check.is_usable and point_check.use == "control"
    ]
    if len(positions) < MIN_POINTS:
        reasons = []
        if no_photo:
            reasons = [Finding("control.photos-missing", photos=sorted(no_photo))]
        elif no_point:
            reasons = [Finding("control.without-coordinates", labels=no_point)]
        return Finding(
            "control.too-few",
            count=len(positions),
            total=sum(point_check.use == "control" for point_check in points),
            least=MIN_POINTS,
            photos=MIN_PHOTOS,
            reasons=" ".join(item.message for item in reasons),
            reason_codes=[item.code for item in reasons],
        )
    try:
        local_points = np.array(positions, np.float64)
        require_width(local_points - local_points.mean(axis=0))
    except GeometryError as error:
        return to_finding(error)
    return None


def _table_findings(
    points: Sequence[PointCheck], no_photo: dict[str, None], others: dict[str, set[int]]
) -> Iterator[Finding]:
    used_points = [p for p in points if p.is_usable and p.use == "control"]
    unseen_labels = [p.label for p in points if not p.is_usable]
    points_with_few_marks = [p.label for p in used_points if p.photos < RECOMMENDED_PHOTOS]
    if MIN_POINTS <= len(used_points) < RECOMMENDED_POINTS:
        yield Finding("control.no-redundancy", count=len(used_points), least=RECOMMENDED_POINTS)
    if not any(p.is_usable and p.use == "check" for p in points):
        yield Finding("control.no-check-points")
    if unseen_labels:
        yield Finding("control.few-marks", labels=sorted(unseen_labels))
    if points_with_few_marks:
        yield Finding(
            "control.more-marks", wanted=RECOMMENDED_PHOTOS, labels=sorted(points_with_few_marks)
        )
    ties = sorted(label for label, rows in others.items() if len(rows) >= MIN_PHOTOS)
    unknown_labels = sorted(set(others) - set(ties))
    if ties:
        yield Finding("control.tie-points", labels=ties, count=len(ties))
    if unknown_labels:
        yield Finding("control.without-coordinates", labels=unknown_labels)
    if no_photo:
        yield Finding("control.photos-missing", photos=sorted(no_photo))


def _determine_crs(
    control: Sequence[ControlPoint],
    photos: Sequence[PhotoLike],
    crs: str | None,
    reason: Finding,
) -> tuple[str | None, Finding, list[Finding]]:
    """Return the CRS, its source, and findings about it; the CRS is None for a local frame."""
    from vomstudio.photogrammetry.georeferencing.georeference import (
        has_position,
        select_crs,
        world_positions,
    )

    placed_photos = [photo for photo in photos if has_position(photo)]
    if not placed_photos or not control:
        return crs, reason if crs else Finding("control.crs-local"), []
    guess = crs or select_crs(placed_photos, None)
    try:
        cameras = np.median(world_positions(placed_photos, guess), axis=0)
    except GeometryError as error:
        return crs, reason, [to_finding(error)]
    median = np.median([p.position for p in control], axis=0)
    distances = math.dist(cameras[:2], median[:2])
    if crs is None:
        if distances > _MAX_DISTANCE_M:
            return None, Finding("control.crs-local"), []
        return guess, Finding("control.crs-proposed", distance_m=distances), []
    if distances > _MAX_DISTANCE_M:
        return (
            crs,
            reason,
            [Finding("control.far-from-photos", crs=crs, distance_km=distances / 1000)],
        )
    return crs, reason, []
