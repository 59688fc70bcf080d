"""Registration of the model by ground control points, and its accuracy at check points."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.geology.bowing import MIN_BOWING_POINTS, Bowing, fit_bowing
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.photogrammetry.align.priors import Calibration
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.georeferencing.control_adjustment import (
    BendingResult,
    GroundPoints,
    bend_to_control,
    require_width,
)
from vomstudio.photogrammetry.georeferencing.mark_observations import (
    NO_MARKS,
    PointMarks,
    marks_by_point,
    report_coincident_marks,
)
from vomstudio.photogrammetry.georeferencing.placement import Placement, placement_errors
from vomstudio.photogrammetry.georeferencing.world_frame import integer_origin, place_in_world
from vomstudio.registration.marks.mark_errors import (
    disagreeing_marks_finding,
    mark_error_px,
    mark_scatter_findings,
    max_mark_distance_px,
)
from vomstudio.registration.marks.wrong_marks import (
    WrongMark,
    do_rays_intersect,
    find_consistent_marks,
    find_misplaced_marks,
)
from vomstudio.registration.scatter import drift_findings
from vomstudio.registration.similarity import fit_similarity

MIN_POINTS, MIN_PHOTOS = 3, 2
RECOMMENDED_PHOTOS = 4
"""Recommended number of photos in which to mark a point (textbook 3.2.2)."""
RECOMMENDED_POINTS = 4
_WARNING_ROTATION_DEG = 1.0


@dataclass(frozen=True)
class PointFit:
    """Fit of a control or check point.

    Attributes
    ----------
    role : str
        "control", "check", "left out" (an outlier among the control points) or "unseen" (a point
        that cannot be located in the model).
    photos : int
        Number of placed photos in which the point is marked.
    residual_m : (float, float, float) or None
        Position in the model minus the surveyed position: east, north, up. None if the point cannot
        be located in the model.
    residual_px : float or None
        RMS distance between the projections of the surveyed point and its marks; None if it has no
        marks.
    surveyed : (float, float, float)
        Surveyed coordinates in the World frame, as given.
    """

    label: str
    role: str
    photos: int
    residual_m: tuple[float, float, float] | None
    residual_px: float | None
    surveyed: tuple[float, float, float]

    @property
    def error_m(self) -> float | None:
        """Length of the residual, in metres; None if the point cannot be located."""
        return None if self.residual_m is None else math.dist(self.residual_m, (0.0, 0.0, 0.0))


@dataclass(frozen=True, eq=False, kw_only=True)
class ControlReport(Placement):
    """Registration by ground control points.

    If the bundle was adjusted to the control points, bowing is computed from the check points,
    provided that there are enough of them.

    Parameters
    ----------
    points : tuple of PointFit
        All points of the table, in its order.
    control_rms_m, check_rms_m : float or None
        RMS length of the residuals of the control and check points; None if missing.
    mark_scatter_px : float
        Error of a mark in one direction, in pixels; included in the stated errors.
    drift : float
        Correlation between the errors of neighbouring points in the table; 0 if they are
        independent.
    """

    points: tuple[PointFit, ...]
    control_rms_m: float | None
    check_rms_m: float | None
    mark_scatter_px: float
    drift: float


def place_by_control(
    scene: SparseScene,
    control: Sequence[ControlPoint],
    marks: Sequence[Mark],
    crs: str | None = None,
    *,
    includes_adjustment: bool = True,
    cameras: Sequence[Calibration] = (),
    threads: int = -1,
    progress: Progress | None = None,
) -> tuple[SparseScene, ControlReport]:
    """Register the scene by surveyed points, and adjust it with them.

    Parameters
    ----------
    scene : SparseScene
    control : sequence of ControlPoint
    marks : sequence of Mark
    crs : str, optional
        CRS of the points, "EPSG:n". If None, they are in a local frame in metres.
    includes_adjustment : bool
        Whether to adjust the scene with the control points if this improves it.
    cameras : sequence of Calibration
        Calibrated cameras. If given, their errors are included in the stated errors.
    threads : int
        Number of threads; -1 uses all cores.
    progress : Progress, optional

    Raises
    ------
    GeometryError
        If fewer than three control points are marked in at least two placed photos, or if these
        points are collinear or contradict each other.
    Cancelled
    """
    ground_points, findings = _marked_points(scene, control, marks)
    control_fit = ground_points.fit_scene(scene)
    fit = control_fit.fit
    placed_scene = place_in_world(scene, fit, ground_points.origin, crs)
    bending = BendingResult(None, control_fit, (), (), None)
    if includes_adjustment:
        bending = bend_to_control(ground_points, placed_scene, control_fit, threads, progress)
    if bending.scene is not None:
        placed_scene, control_fit = bending.scene, bending.fit
    used_rows, scatter = control_fit.used, control_fit.scatter
    points = tuple(
        _fit_point(
            placed_scene,
            point,
            ground_points.local_positions[i],
            ground_points.control_marks[i],
            i in used_rows,
        )
        for i, point in enumerate(control)
    )
    report = ControlReport(
        **placement_errors(
            placed_scene,
            cameras,
            scatter,
            lambda other: ground_points.locate_points(other, used_rows),
            ground_points.local_positions[used_rows],
            lenses=None if bending.scene is None else bending.lenses,
            points=ground_points.known_points(used_rows, control_fit.sigma),
        ),
        scale=fit.scale,
        crs=crs,
        adjusted=bending.scene is not None,
        decisions=bending.decisions,
        lenses=bending.lenses,
        bowing=_bowing(
            points, bending.scene is not None, placed_scene.points + np.array(ground_points.origin)
        ),
        points=points,
        control_rms_m=_rms(points, "control"),
        check_rms_m=_rms(points, "check"),
        mark_scatter_px=ground_points.mark_px,
        drift=scatter.drift,
    )
    warnings = [
        *findings,
        *_control_findings(report),
        *([bending.refusal] if bending.refusal else []),
    ]
    return placed_scene, replace(report, warnings=tuple(warnings))


def _bowing(points: Sequence[PointFit], is_adjusted: bool, extent: FloatArray) -> Bowing | None:
    known_points = [p for p in points if p.role in ("control", "check") and p.residual_m]
    check_points = [p for p in known_points if p.role == "check"]
    if is_adjusted and len(check_points) >= MIN_BOWING_POINTS:
        known_points = check_points
    positions = np.array([p.surveyed for p in known_points], np.float64).reshape(-1, 3)
    residuals = np.array([p.residual_m for p in known_points], np.float64).reshape(-1, 3)
    return fit_bowing(positions, residuals, extent=extent)


def _marked_points(
    scene: SparseScene, control: Sequence[ControlPoint], marks: Sequence[Mark]
) -> tuple[GroundPoints, list[Finding]]:
    """Return the points that place the scene, and findings about unusable marks.

    Raises
    ------
    GeometryError
        If the points cannot place the scene.
    """
    control_marks, ties, mark_px, findings = _observations(scene, control, marks)
    ground_points = _prepare_ground_points(scene, control, control_marks, ties, mark_px, findings)
    # If two marks contradict each other, the position of the point as determined by the other
    # points shows which mark is wrong.
    ground_fit = ground_points.fit_scene(scene)
    placed_scene = place_in_world(scene, ground_fit.fit, ground_points.origin, None)
    limit = 6.0 * ground_fit.sigma / ground_points.pixel
    wrong_marks: list[WrongMark] = []
    for i, point in enumerate(control):
        other_rows = [k for k in ground_fit.used if k != i]
        if len(other_rows) >= RECOMMENDED_POINTS - 1 and len(control_marks[i].views) >= 2:
            point_marks = control_marks[i].match_views(placed_scene)
            rows, outliers = find_misplaced_marks(
                point.label,
                point_marks,
                ground_points.local_positions[i],
                max_mark_distance_px(mark_px),
                limit,
            )
            control_marks[i] = control_marks[i].select(rows)
            wrong_marks += outliers
    if wrong_marks:
        findings = [*findings, *(mark.finding for mark in wrong_marks)]
        ground_points = _prepare_ground_points(
            scene, control, control_marks, ties, mark_px, findings
        )
    return ground_points, findings


def _prepare_ground_points(
    scene: SparseScene,
    control: Sequence[ControlPoint],
    control_marks: list[PointMarks],
    ties: list[PointMarks],
    mark_px: float,
    causes: Sequence[Finding],
) -> GroundPoints:
    """Prepare the points for the registration.

    Raises GeometryError if the points cannot place the scene.

    mark_px : error of a mark in one direction
    """
    world = np.array([p.position for p in control], np.float64).reshape(-1, 3)
    usable_points = [
        i
        for i, marks in enumerate(control_marks)
        if do_rays_intersect(marks.match_views(scene), max_mark_distance_px(mark_px))
    ]
    fitting_rows = [i for i in usable_points if not control[i].check]
    if len(fitting_rows) < MIN_POINTS:
        unused_labels = [
            point.label
            for i, point in enumerate(control)
            if i not in usable_points and len(control_marks[i].views) >= 2
        ]
        causes = [disagreeing_marks_finding(unused_labels)] if unused_labels else causes[:1]
        raise GeometryError(
            Finding(
                "control.too-few",
                count=len(fitting_rows),
                total=sum(not p.check for p in control),
                least=MIN_POINTS,
                photos=MIN_PHOTOS,
                reasons=" ".join(cause.message for cause in causes),
                reason_codes=[cause.code for cause in causes],
            )
        )
    origin = integer_origin(world[fitting_rows])
    local_points = world - origin
    positions = np.array([control_marks[i].place(scene) for i in fitting_rows])
    require_width(local_points[fitting_rows])
    stated_sigmas = [p.sigma_m for p in (control[i] for i in fitting_rows) if p.sigma_m is not None]
    survey_sigma = float(np.median(stated_sigmas)) if stated_sigmas else 0.0
    first_fit = fit_similarity(positions, local_points[fitting_rows])
    pixel = scene.median_pixel_size(positions) * first_fit.scale
    mark_sigmas = [
        first_fit.scale
        * math.sqrt(np.linalg.eigvalsh(control_marks[i].covariance(scene, mark_px))[-1])
        for i in fitting_rows
    ]
    min_sigma = 3 * math.hypot(survey_sigma, max(2 * pixel, float(np.median(mark_sigmas))))
    return GroundPoints(
        control,
        control_marks,
        local_points,
        origin,
        fitting_rows,
        ties,
        survey_sigma,
        pixel,
        min_sigma,
        mark_px,
    )


def _observations(
    scene: SparseScene, control: Sequence[ControlPoint], marks: Sequence[Mark]
) -> tuple[list[PointMarks], list[PointMarks], float, list[Finding]]:
    """Assign the marks to control points, and find unusable marks.

    Returns
    -------
    control_marks : list of PointMarks
        Marks of each control point.
    ties : list of PointMarks
        Marks of points without coordinates, which only tie photos together.
    mark_px : float
        Error of a mark in one direction, pixels.
    findings : list of Finding
        Findings about unusable marks.
    """
    marks_by_label, missing_names = marks_by_point(scene, marks)
    findings: list[Finding] = []
    mark_px = mark_error_px(
        [point_marks.match_views(scene) for point_marks in marks_by_label.values()]
    )
    for label, point_marks in marks_by_label.items():
        rows, wrong_marks = find_consistent_marks(
            label, point_marks.match_views(scene), max_mark_distance_px(mark_px)
        )
        marks_by_label[label] = point_marks.select(rows)
        findings += [mark.finding for mark in wrong_marks]
    findings += report_coincident_marks(marks)
    control_marks = [marks_by_label.pop(point.label, NO_MARKS) for point in control]
    labels = {point.label for point in control}
    ties = {label: s for label, s in marks_by_label.items() if np.isfinite(s.place(scene)).all()}
    unknown_labels = {mark.label for mark in marks} - labels - set(ties)
    if missing_names:
        findings.append(Finding("control.photos-without-pose", photos=sorted(missing_names)))
    if unknown_labels:
        findings.append(Finding("control.without-coordinates", labels=sorted(unknown_labels)))
    return control_marks, list(ties.values()), mark_px, findings


def _fit_point(
    scene: SparseScene,
    point: ControlPoint,
    local_points: FloatArray,
    point_marks: PointMarks,
    is_used: bool,
) -> PointFit:
    place = point_marks.place(scene)
    residual = None
    if np.isfinite(place).all():
        dx, dy, dz = (float(v) for v in place - local_points)
        residual = (dx, dy, dz)
    rows, pixels = point_marks.views, point_marks.pixels
    distances = [
        float(np.linalg.norm(scene.views[r].project(local_points)[0] - pixel))
        for r, pixel in zip(rows, pixels, strict=True)
    ]
    finite_distances = [d for d in distances if math.isfinite(d)]
    role = "check" if point.check else "control" if is_used else "left out"
    role = "unseen" if residual is None else role
    pixel_rms = (
        math.sqrt(sum(d * d for d in finite_distances) / len(finite_distances))
        if finite_distances
        else None
    )
    return PointFit(point.label, role, len(rows), residual, pixel_rms, point.position)


def _rms(points: Sequence[PointFit], role: str) -> float | None:
    errors = [p.error_m for p in points if p.role == role and p.error_m is not None]
    return math.sqrt(sum(e * e for e in errors) / len(errors)) if errors else None


def _control_findings(report: ControlReport) -> Iterator[Finding]:
    used_points = [p for p in report.points if p.role == "control"]
    yield from report.findings(_WARNING_ROTATION_DEG, "control")
    yield from mark_scatter_findings(report.mark_scatter_px)
    yield from drift_findings({"points": report.drift})
    outlier_labels = [p.label for p in report.points if p.role == "left out"]
    unseen_labels = [p.label for p in report.points if p.role == "unseen" and p.photos < 2]
    unused_labels = [p.label for p in report.points if p.role == "unseen" and p.photos >= 2]
    points_with_few_marks = [p.label for p in used_points if p.photos < RECOMMENDED_PHOTOS]
    if outlier_labels:
        yield Finding("control.left-out", labels=outlier_labels)
    if unseen_labels:
        yield Finding("control.few-marks", labels=unseen_labels)
    if unused_labels:
        yield disagreeing_marks_finding(unused_labels)
    if len(used_points) < RECOMMENDED_POINTS:
        yield Finding("control.no-redundancy", count=len(used_points), least=RECOMMENDED_POINTS)
    if points_with_few_marks:
        yield Finding("control.more-marks", wanted=RECOMMENDED_PHOTOS, labels=points_with_few_marks)
    if not any(p.role == "check" for p in report.points):
        yield Finding("control.no-check-points")
