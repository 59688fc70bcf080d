"""Planning of a photo survey (textbook 2.4 and 3.2).

Positions are in the frame of the outcrop, in metres: `along` is measured from its left end and `up`
from its foot (both as seen from the camera), and `away` is the distance from it towards the camera.
For flat ground seen from above, `away` is the height.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from vomstudio.core.arrays import IntArray
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.results import HIDDEN_IN_JSON, Result, to_dict
from vomstudio.geometry.plane_sizes import PlaneError, PlaneSizes
from vomstudio.photogrammetry.survey.plan_camera import PlanCamera
from vomstudio.photogrammetry.survey.registration_forecast import Forecast
from vomstudio.photogrammetry.survey.survey_options import (
    DEFAULT_APERTURE,
    MIN_OVERLAP,
    PlanOptions,
)
from vomstudio.photogrammetry.survey.survey_resolution import (
    ground_sampling_distance,
    gsd_for_plane,
)

Manner = Literal["handheld", "drone", "terrain"]

OBLIQUE_DEG = 30.0
"""Angle of oblique photos from the perpendicular. The textbook (3.2.1) recommends view directions
"up to 60 degrees with" the surface: horizontal and plunging at 30 degrees for a cliff, vertical
and plunging at 60 degrees over flat ground."""
RECOMMENDED_VIEWS = 4
_MAX_BLUR_PX = 2.0
_MAX_HAND_HEIGHT_M = 2.5
_TARGET_SIZE_PX = 20.0
_MAX_PHOTOS = 20_000


@dataclass(frozen=True)
class CameraStation(Result):
    """One photo: position and target of the camera, in the frame of the outcrop."""

    number: int
    kind: Literal["perpendicular", "oblique"]
    along_m: float
    up_m: float
    away_m: float
    target_along_m: float
    target_up_m: float

    @property
    def turn_deg(self) -> float:
        """Angle to the right of the perpendicular."""
        return math.degrees(math.atan2(self.target_along_m - self.along_m, self.away_m))

    @property
    def tilt_deg(self) -> float:
        """Angle above the perpendicular."""
        return math.degrees(
            math.atan2(
                self.target_up_m - self.up_m,
                math.hypot(self.target_along_m - self.along_m, self.away_m),
            )
        )

    def to_dict(self) -> dict[str, Any]:
        return {
            "number": self.number,
            "kind": self.kind,
            "along_m": round(self.along_m, 3),
            "up_m": round(self.up_m, 3),
            "away_m": round(self.away_m, 3),
            "turn_deg": round(self.turn_deg, 1),
            "tilt_deg": round(self.tilt_deg, 1),
        }


@dataclass(frozen=True)
class PlannedControlPoint(Result):
    """Point to lay out and survey, in the frame of the outcrop."""

    label: str
    use: Literal["control", "check"]
    along_m: float
    up_m: float

    def to_dict(self) -> dict[str, Any]:
        return {
            "label": self.label,
            "use": self.use,
            "along_m": round(self.along_m, 3),
            "up_m": round(self.up_m, 3),
        }


@dataclass(frozen=True, repr=False)
class SurveyPlan(PrintableResult):
    """Plan of a photo survey.

    Attributes
    ----------
    footprint_m, spacing_m : (float, float)
        Footprint of a photo, and spacing of the photos, along and up the outcrop.
    depth_of_field_m : (float, float or None)
        Nearest and farthest sharp distance; None if the latter is infinite.
    views_least, views_median : float
        Minimum and median number of photos that show a point of the outcrop.
    registration : tuple of Forecast
        Expected errors of the registration, if requested.
    """

    camera: PlanCamera
    manner: Manner = field(metadata=HIDDEN_IN_JSON)
    distance_m: float
    width_m: float = field(metadata=HIDDEN_IN_JSON)
    height_m: float = field(metadata=HIDDEN_IN_JSON)
    overlap: float
    gsd_m: float
    footprint_m: tuple[float, float]
    spacing_m: tuple[float, float]
    f_number: float
    depth_of_field_m: tuple[float, float | None]
    positions: tuple[CameraStation, ...]
    control_points: tuple[PlannedControlPoint, ...]
    views_least: int
    views_median: float
    warnings: tuple[Finding, ...] = field(default=())
    registration: tuple[Forecast, ...] = ()

    @property
    def smallest_plane_m(self) -> float:
        """Minimum size of a plane worth measuring, the textbook's 1000 pixels."""
        return self.planes.textbook

    @property
    def planes(self) -> PlaneSizes:
        """Expected errors of planes of different sizes, excluding the registration error."""
        return PlaneSizes.from_pixel_size(self.gsd_m)

    @property
    def plane_error(self) -> tuple[PlaneError, ...]:
        """Expected 95 % errors of planes of different sizes, excluding the registration."""
        return tuple(self.planes.curve())

    @property
    def photos(self) -> int:
        """Number of photos."""
        return len(self.positions)

    @property
    def target_size_m(self) -> float:
        """Size of a control point's mark: twenty pixels across."""
        return _TARGET_SIZE_PX * self.gsd_m

    def select_kind(self, kind: str) -> list[CameraStation]:
        """Return the stations of one kind, "perpendicular" or "oblique"."""
        return [station for station in self.positions if station.kind == kind]

    def to_dict(self) -> dict[str, Any]:
        return super().to_dict() | {
            "photos": self.photos,
            "smallest_plane_m": self.smallest_plane_m,
            "plane_error": [to_dict(plane_error) for plane_error in self.plane_error],
            "perpendicular": len(self.select_kind("perpendicular")),
            "oblique": len(self.select_kind("oblique")),
            "target_size_m": self.target_size_m,
        }


# -- the plan ------------------------------------------------------------------------------------
def depth_of_field(
    focal_mm: float, f_number: float, distance_m: float, circle_mm: float
) -> tuple[float, float | None]:
    """Return the nearest and farthest sharp distance, in metres; None for infinity.

    A distance is sharp if a point at it is imaged as a circle of at most `circle_mm` on the sensor
    when the lens is focused at `distance_m`. For a thin lens with the hyperfocal distance H = f^2 /
    (N c) + f, the limits are near = D (H - f) / (H + D - 2 f) and far = D (H - f) / (H - D).
    """
    f, d = focal_mm, distance_m * 1000.0
    hyperfocal = f * f / (f_number * circle_mm) + f
    near = d * (hyperfocal - f) / (hyperfocal + d - 2.0 * f)
    far = d * (hyperfocal - f) / (hyperfocal - d) / 1000.0 if d < hyperfocal else None
    return near / 1000.0, far


def distance_for_gsd(camera: PlanCamera, gsd_m: float) -> float:
    """Return the distance in metres at which a pixel covers `gsd_m` (eq. 18 solved for D)."""
    return gsd_m * camera.focal_mm * camera.width_px / camera.sensor_width_mm


def plan_survey(camera: PlanCamera, options: PlanOptions) -> SurveyPlan:
    """Compute stations, control points and figures of a survey.

    For the manner "terrain", the width and height are those of the ground. A camera without a
    diaphragm keeps its fixed f-number. If a distance is given, it is used, with a warning if it is
    too far for the given pixel size or smallest plane. Otherwise, the distance follows from the
    finer of these two.

    Raises
    ------
    UsageError
        If distance, pixel size and smallest plane are all missing, if the lens cannot focus at the
        distance, or if too many photos would be necessary.
    """
    width_m, height_m = options.width_m, options.height_m
    overlap, manner = options.overlap, options.manner
    warnings: list[Finding] = []
    aperture, aperture_warnings = _aperture(camera, options.aperture)
    warnings += aperture_warnings
    distance_m, gsd, distance_warnings = _distance(
        camera, options.distance_m, options.gsd_m, options.plane_m
    )
    warnings += distance_warnings
    footprint = gsd * camera.width_px, gsd * camera.height_px
    spacing = (1.0 - overlap) * footprint[0], (1.0 - overlap) * footprint[1]
    expected_count = (width_m / spacing[0] + 2.0) * (height_m / spacing[1] + 1.0) * 2.0
    if expected_count > _MAX_PHOTOS:
        raise UsageError(Finding("plan.too-many-photos", photos=expected_count))
    stations, min_views, median_views = _stations(
        camera, distance_m, width_m, height_m, footprint, spacing, manner
    )
    depth_of_field_m = depth_of_field(
        camera.focal_mm, aperture, distance_m, _MAX_BLUR_PX * camera.pixel_pitch_mm
    )
    warnings += _plan_findings(
        manner, stations, distance_m, width_m, height_m, footprint, min_views
    )
    return SurveyPlan(
        camera,
        manner,
        distance_m,
        width_m,
        height_m,
        overlap,
        gsd,
        footprint,
        spacing,
        aperture,
        depth_of_field_m,
        stations,
        _control_points(width_m, height_m),
        min_views,
        median_views,
        tuple(warnings),
    )


def _aperture(camera: PlanCamera, f_number: float | None) -> tuple[float, list[Finding]]:
    """Return the f-number that applies, and a warning if another was requested."""
    if camera.f_number is None:
        return DEFAULT_APERTURE if f_number is None else f_number, []
    if f_number in (None, camera.f_number):
        return camera.f_number, []
    finding = Finding("plan.fixed-aperture", camera=camera.name, f_number=camera.f_number)
    return camera.f_number, [finding]


def _distance(
    camera: PlanCamera, distance_m: float | None, gsd_m: float | None, plane_m: float | None
) -> tuple[float, float, list[Finding]]:
    """Return the distance and the pixel size on the rock in metres, and warnings.

    There is a warning if the pixel size is larger than requested. Raises UsageError if no value is
    given, or if the lens cannot focus at the distance.
    """
    warnings = []
    if plane_m is not None:
        gsd_m = min(gsd_m or math.inf, gsd_for_plane(plane_m))
    if distance_m is None:
        if gsd_m is None:
            options = ("--distance", "--gsd", "--plane")
            raise UsageError(Finding("option.none-given", options=options), field=options[0])
        distance_m = distance_for_gsd(camera, gsd_m)
    if distance_m * 1000.0 <= 2.0 * camera.focal_mm:
        raise UsageError(Finding("plan.too-close"), field="--distance")
    gsd = ground_sampling_distance(
        camera.sensor_width_mm, camera.focal_mm, distance_m, camera.width_px
    )
    if gsd_m is not None and gsd > gsd_m * (1.0 + 1e-9):
        warnings.append(
            Finding(
                "plan.too-far",
                distance=distance_m,
                gsd=1000 * gsd,
                wanted=1000 * gsd_m,
                closer=distance_for_gsd(camera, gsd_m),
            )
        )
    return distance_m, gsd, warnings


def _stations(
    camera: PlanCamera,
    distance: float,
    width: float,
    height: float,
    footprint: tuple[float, float],
    spacing: tuple[float, float],
    manner: Manner,
) -> tuple[tuple[CameraStation, ...], int, float]:
    """Return rows of perpendicular photos with obliques between them.

    They extend beyond the ends of the outcrop, and then (by drone) beyond its borders, until four
    photos show every part. Also returns the minimum and median number of views.
    """
    columns = max(1, math.ceil(width / spacing[0] - 1e-9))
    extensions = [(0, 0.0), (1, 0.0)]
    if manner != "handheld":
        extensions.append((1, spacing[1]))
    for extra_columns, margin in extensions:
        rows = _row_heights(height, footprint[1], spacing[1], margin)
        horizontal_positions = [
            i * width / columns for i in range(-extra_columns, columns + 1 + extra_columns)
        ]
        targets = [(u, v, 0.0, 0.0) for v in rows for u in horizontal_positions]
        targets += _oblique_targets(rows, width, footprint, manner)
        stations = tuple(
            _create_station(n, *target, distance) for n, target in enumerate(targets, 1)
        )
        views = _view_counts(camera, stations, width, height)
        if views.min() >= RECOMMENDED_VIEWS:
            break
    return stations, int(views.min()), float(np.median(views))


def _row_heights(
    extent: float, picture_height: float, spacing: float, margin: float
) -> list[float]:
    """Return the heights of rows that cover the extent and a margin; one row if sufficient."""
    remaining_height = extent + 2.0 * margin - picture_height
    if remaining_height <= 0:
        return [extent / 2.0]
    steps = math.ceil(remaining_height / spacing - 1e-9)
    return [picture_height / 2.0 - margin + i * remaining_height / steps for i in range(steps + 1)]


def _oblique_targets(
    rows: list[float], width: float, footprint: tuple[float, float], manner: Manner
) -> list[tuple[float, float, float, float]]:
    """Return the targets (along, up) of oblique photos, with turn and tilt in degrees.

    On foot, a cliff is photographed alternately from the left and the right; a drone photographs
    it from above. Flat ground is photographed from both ends.
    """
    count = max(1, math.ceil(width / ((1.0 - MIN_OVERLAP) * footprint[0]) - 1e-9))
    targets = []
    for r, v in enumerate(rows):
        for i in range(count + 1):
            u = i * width / count
            if manner == "drone":
                targets.append((u, v, 0.0, -OBLIQUE_DEG))
            else:
                targets.append((u, v, OBLIQUE_DEG if (i + r) % 2 else -OBLIQUE_DEG, 0.0))
    return targets


def _create_station(
    number: int, u: float, v: float, turn_deg: float, tilt_deg: float, distance: float
) -> CameraStation:
    """Return a camera at `distance` from its target, with this turn and tilt."""
    angle, tilt = math.radians(turn_deg), math.radians(tilt_deg)
    return CameraStation(
        number,
        "oblique" if turn_deg or tilt_deg else "perpendicular",
        u - distance * math.sin(angle) * math.cos(tilt),
        v - distance * math.sin(tilt),
        distance * math.cos(angle) * math.cos(tilt),
        u,
        v,
    )


def _view_counts(
    camera: PlanCamera, stations: tuple[CameraStation, ...], width: float, height: float
) -> IntArray:
    """Return the number of photos that show each point of an 11 x 7 grid over the outcrop."""
    u, v = np.meshgrid(np.linspace(0.0, width, 11), np.linspace(0.0, height, 7))
    points = np.column_stack([u.ravel(), v.ravel(), np.zeros(u.size)])
    half_x = camera.sensor_width_mm / 2.0 / camera.focal_mm
    half_y = camera.sensor_height_mm / 2.0 / camera.focal_mm
    counts = np.zeros(len(points), np.int64)
    for s in stations:
        rays = points - [s.along_m, s.up_m, s.away_m]
        axis = np.array([s.target_along_m - s.along_m, s.target_up_m - s.up_m, -s.away_m])
        axis /= np.linalg.norm(axis)
        right = np.cross(axis, [0.0, 1.0, 0.0])
        right /= np.linalg.norm(right)
        up = np.cross(right, axis)
        depth = rays @ axis
        with np.errstate(divide="ignore", invalid="ignore"):
            x, y = rays @ right / depth, rays @ up / depth
        counts += (depth > 0) & (np.abs(x) <= half_x + 1e-9) & (np.abs(y) <= half_y + 1e-9)
    return counts


def _control_points(width: float, height: float) -> tuple[PlannedControlPoint, ...]:
    """Return four points near the corners, one in the middle, and two check points (3.2.2)."""
    positions: list[tuple[Literal["control", "check"], float, float]] = [
        ("control", 0.08, 0.1),
        ("control", 0.92, 0.1),
        ("control", 0.92, 0.9),
        ("control", 0.08, 0.9),
        ("control", 0.5, 0.5),
        ("check", 0.3, 0.75),
        ("check", 0.7, 0.25),
    ]
    return tuple(
        PlannedControlPoint(f"P{i}", point_use, u * width, v * height)
        for i, (point_use, u, v) in enumerate(positions, 1)
    )


def _plan_findings(
    manner: Manner,
    stations: tuple[CameraStation, ...],
    distance: float,
    width: float,
    height: float,
    footprint: tuple[float, float],
    min_views: int,
) -> list[Finding]:
    findings: list[Finding] = []
    max_height_m = max(station.up_m for station in stations)
    if manner == "handheld" and max_height_m > _MAX_HAND_HEIGHT_M:
        single_row_distance_m = distance * height / footprint[1]
        if single_row_distance_m > distance * (1.0 + 1e-9):
            findings.append(
                Finding("plan.high-rows", height_m=max_height_m, distance_m=single_row_distance_m)
            )
        else:
            findings.append(Finding("plan.high-row", height_m=max_height_m))
    if min(width, height) < 0.2 * max(width, height):
        findings.append(Finding("plan.narrow-strip"))
    if min_views < RECOMMENDED_VIEWS:
        findings.append(Finding("plan.thin-border", count=min_views))
    return findings
