"""Registration of the model by ground control points, and its accuracy by check points."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from vomstudio.errors import GeometryError, UsageError
from vomstudio.io.control.control_files import agreed_crs, read_control, read_marks
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.photogrammetry.align.mapping import mean_error
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.place.ground_adjustment import KnownPoint
from vomstudio.photogrammetry.place.ground_calibration import LensVerdict, adjust_to_ground
from vomstudio.photogrammetry.place.mark_observations import NO_MARKS, PointMarks, marks_by_point
from vomstudio.photogrammetry.place.world_frame import integer_origin, moved
from vomstudio.progress import Progress
from vomstudio.registration.similarity import (
    Similarity,
    fit_robustly,
    fit_similarity,
    nearly_on_a_line,
    rotation_covariance,
)
from vomstudio.survey.check_results import named
from vomstudio.words import tr, tr_n

Array = npt.NDArray[np.float64]

WANTED_PHOTOS = 4
"""A point should be marked in so many photos (textbook 3.2.2)."""
WANTED_POINTS = 4
_WARN_DEG = 1.0


@dataclass(frozen=True)
class PointFit:
    """How a control or check point fits.

    role : "control", "check", "left out" for a control point that contradicts the others, or
        "unseen" for one that cannot be found in the model
    photos : in which it is marked and that are placed
    residual_m : (3,) its place in the model less the surveyed one, east, north, up; None where it
        cannot be had, being marked in fewer than two placed photos
    residual_px : root mean square distance of the surveyed point's projections from its marks
    """

    label: str
    role: str
    photos: int
    residual_m: tuple[float, float, float] | None
    residual_px: float | None

    @property
    def error_m(self) -> float | None:
        """Length of the residual."""
        return None if self.residual_m is None else math.dist(self.residual_m, (0.0, 0.0, 0.0))


@dataclass(frozen=True)
class ControlReport:
    """points : all of the table, in its order
    control_rms_m, check_rms_m : of the residuals' lengths; None without such points
    sigma_m : error of one coordinate, from the residuals of a similarity or as surveyed, whichever
        is more
    scale : units of the scene to metres
    rotation_error_deg : (about east, about north, about up), one sigma; tilt_error_deg : of the
        vertical
    adjusted : whether cameras and points were adjusted together with the control points
    decisions : what became of the lenses then, in words; lenses : the same in numbers
    """

    points: tuple[PointFit, ...]
    control_rms_m: float | None
    check_rms_m: float | None
    sigma_m: float
    scale: float
    rotation_error_deg: tuple[float, float, float]
    tilt_error_deg: float
    crs: str | None
    adjusted: bool
    decisions: tuple[str, ...]
    lenses: tuple[LensVerdict, ...]
    warnings: tuple[str, ...]


def place_by_control_files(
    scene: SparseScene,
    control: Path,
    marks: Path | None,
    crs: str | None = None,
    progress: Progress | None = None,
    *,
    threads: int = -1,
) -> tuple[SparseScene, ControlReport]:
    """Place the scene by the tables of control points and of their marks (see `io.control`).

    crs : of the points; None for what their file states, else a local frame in metres
    Raises InputError for tables that cannot be read, GeometryError where they cannot place it.
    """
    points = read_control(control)
    if marks is None:
        raise UsageError(
            tr(
                "Control points need a table of their marks in the photos. Name one with the "
                "columns label, photo, x and y."
            ),
            field="--marks",
        )
    return place_by_control(
        scene,
        points,
        read_marks(marks),
        agreed_crs(control, crs),
        threads=threads,
        progress=progress,
    )


def place_by_control(
    scene: SparseScene,
    control: Sequence[ControlPoint],
    marks: Sequence[Mark],
    crs: str | None = None,
    *,
    adjust: bool = True,
    threads: int = -1,
    progress: Progress | None = None,
) -> tuple[SparseScene, ControlReport]:
    """Place the scene by surveyed points and adjust it with them.

    crs : of the points, "EPSG:n", or None for a local frame in metres
    Raises GeometryError where fewer than three points, or points in one line, are marked in two or
    more placed photos.
    """
    ground, unknown = _marked_points(scene, control, marks)
    control_fit = ground.fitted(scene)
    fit = control_fit.fit
    placed = moved(scene, fit, ground.origin, crs)
    adjusted, decisions = False, []
    told: tuple[LensVerdict, ...] = ()
    if adjust:
        better, lenses = ground.adjusted(placed, control_fit.used, threads, progress)
        # A wrong lens makes good points contradict each other: judged again without it.
        again = ground.fitted(better)
        if again.used != control_fit.used:
            better, lenses = ground.adjusted(placed, again.used, threads, progress)
            again = ground.fitted(better)
        # Control points that no bundle of rays can meet bend the model: the tie points tell.
        adjusted = mean_error(better) <= 1.2 * mean_error(placed) + 0.1
        if adjusted:
            placed, control_fit = better, again
            told, decisions = lenses, [lens.reason for lens in lenses]
            if ground.ties:
                decisions.append(
                    tr_n(
                        "{count} marker without coordinates was used as a tie point.",
                        "{count} markers without coordinates were used as tie points.",
                        len(ground.ties),
                    )
                )
    used, sigma = control_fit.used, control_fit.sigma
    covariance = rotation_covariance(ground.local[used], max(sigma, 1e-9))
    turn = np.degrees(np.sqrt(np.diag(covariance)))
    points = tuple(
        _fit_of(placed, point, ground.local[i], ground.seen[i], i in used)
        for i, point in enumerate(control)
    )
    report = ControlReport(
        points,
        _rms(points, "control"),
        _rms(points, "check"),
        sigma,
        fit.scale,
        (float(turn[0]), float(turn[1]), float(turn[2])),
        math.hypot(turn[0], turn[1]),
        crs,
        adjusted,
        tuple(decisions),
        told,
        (),
    )
    warnings = [*unknown, *_warnings(report, adjust)]
    return placed, replace(report, warnings=tuple(warnings))


@dataclass(frozen=True, eq=False)
class _ControlFit:
    """used : rows of the control points that agree; sigma : of one coordinate of these"""

    fit: Similarity
    used: list[int]
    sigma: float


@dataclass(frozen=True, eq=False)
class _MarkedPoints:
    """Control points and tie points that are marked, prepared for the registration.

    control, seen : the points, and where they are marked
    local : (n, 3) their places less `origin`
    fitting : rows of those that can place the scene
    ties : markers without coordinates that tie photos together
    surveyed : usual error of a coordinate, as stated; 0 where none is
    pixel : metres of a pixel on the ground
    floor : misses below it contradict nothing
    """

    control: Sequence[ControlPoint]
    seen: list[PointMarks]
    local: Array
    origin: tuple[int, int, int]
    fitting: list[int]
    ties: list[PointMarks]
    surveyed: float
    pixel: float
    floor: float

    def fitted(self, scene: SparseScene) -> _ControlFit:
        """The similarity from the scene to the control points, robustly."""
        places = np.array([self.seen[i].place(scene) for i in self.fitting])
        wanted = self.local[list(self.fitting)]
        fit, good = fit_robustly(places, wanted, floor=self.floor)
        misses = (fit(places) - wanted)[good]
        freedom = 3 * int(good.sum()) - 7
        sigma = max(math.sqrt(float((misses**2).sum()) / freedom), self.surveyed)
        return _ControlFit(
            fit, [i for i, keep in zip(self.fitting, good, strict=True) if keep], sigma
        )

    def adjusted(
        self, placed: SparseScene, used: Sequence[int], threads: int, progress: Progress | None
    ) -> tuple[SparseScene, tuple[LensVerdict, ...]]:
        """The scene after an adjustment with these points and all ties."""
        usual = max(self.surveyed, self.pixel)
        known = [
            KnownPoint(
                self.local[i],
                self.control[i].sigma_m or usual,
                self.seen[i].views,
                self.seen[i].pixels,
            )
            for i in used
        ]
        known += [KnownPoint(None, 0.0, tie.views, tie.pixels) for tie in self.ties]
        return adjust_to_ground(placed, known, threads=threads, progress=progress)


def _marked_points(
    scene: SparseScene, control: Sequence[ControlPoint], marks: Sequence[Mark]
) -> tuple[_MarkedPoints, list[str]]:
    """What there is to place the scene by, and sentences about marks that are of no use. Raises
    GeometryError where it cannot place it."""
    seen, ties, unknown = _observations(scene, control, marks)
    world = np.array([p.position for p in control], np.float64).reshape(-1, 3)
    usable = [i for i, o in enumerate(seen) if np.isfinite(o.place(scene)).all()]
    fitting = [i for i in usable if not control[i].check]
    if len(fitting) < 3:
        text = tr(
            "Only {count} of the {total} control points can be located in the model. At least 3 "
            "are needed, each marked in two or more photos with a pose.",
            count=len(fitting),
            total=sum(not p.check for p in control),
        )
        raise GeometryError(" ".join([text, *unknown[:1]]))
    origin = integer_origin(world[fitting])
    local = world - origin
    places = np.array([seen[i].place(scene) for i in fitting])
    require_width(local[fitting])
    stated = [p.sigma_m for p in (control[i] for i in fitting) if p.sigma_m is not None]
    surveyed = float(np.median(stated)) if stated else 0.0
    first = fit_similarity(places, local[fitting])
    pixel = scene.pixel_at(places) * first.scale
    floor = 3 * math.hypot(surveyed, 2 * pixel)
    ground = _MarkedPoints(control, seen, local, origin, fitting, ties, surveyed, pixel, floor)
    return ground, unknown


def _observations(
    scene: SparseScene, control: Sequence[ControlPoint], marks: Sequence[Mark]
) -> tuple[list[PointMarks], list[PointMarks], list[str]]:
    """(of each point; of markers without coordinates that tie photos together; sentences about
    marks that are of no use)."""
    found, missing = marks_by_point(scene, marks)
    seen = [found.pop(point.label, NO_MARKS) for point in control]
    labels = {point.label for point in control}
    ties = {label: s for label, s in found.items() if np.isfinite(s.place(scene)).all()}
    useless = {mark.label for mark in marks} - labels - set(ties)
    said = []
    if missing:
        said.append(
            tr(
                "Marks in these photos are not used, since there is no pose for them: {photos}.",
                photos=named(sorted(missing)),
            )
        )
    if useless:
        said.append(
            tr(
                "Marks of these points are not used: {points}. They are not in the table of "
                "control points, and a tie point must be marked in two photos with a pose.",
                points=named(sorted(useless)),
            )
        )
    return seen, list(ties.values()), said


def require_width(local: Array) -> None:
    """Raises GeometryError where points (n, 3) lie on one line."""
    if nearly_on_a_line(local):
        raise GeometryError(
            tr(
                "The control points lie on one line, about which the model can rotate. Add a "
                "control point beside this line."
            )
        )


def _fit_of(
    scene: SparseScene,
    point: ControlPoint,
    local: Array,
    seen: PointMarks,
    used: bool,
) -> PointFit:
    place = seen.place(scene)
    residual = None
    if np.isfinite(place).all():
        dx, dy, dz = (float(v) for v in place - local)
        residual = (dx, dy, dz)
    rows, pixels = seen.views, seen.pixels
    distances = [
        float(np.linalg.norm(scene.views[r].project(local)[0] - pixel))
        for r, pixel in zip(rows, pixels, strict=True)
    ]
    finite = [d for d in distances if math.isfinite(d)]
    role = "check" if point.check else "control" if used else "left out"
    role = "unseen" if residual is None else role
    pixel_rms = math.sqrt(sum(d * d for d in finite) / len(finite)) if finite else None
    return PointFit(point.label, role, len(rows), residual, pixel_rms)


def _rms(points: Sequence[PointFit], role: str) -> float | None:
    errors = [p.error_m for p in points if p.role == role and p.error_m is not None]
    return math.sqrt(sum(e * e for e in errors) / len(errors)) if errors else None


def _warnings(report: ControlReport, adjust: bool) -> Iterator[str]:
    used = [p for p in report.points if p.role == "control"]
    out = [p.label for p in report.points if p.role == "left out"]
    unseen = [p.label for p in report.points if p.role == "unseen"]
    few = [p.label for p in used if p.photos < WANTED_PHOTOS]
    if out:
        yield tr(
            "Control points that contradict the others were left out: {points}.",
            points=", ".join(out),
        )
    if unseen:
        yield tr(
            "Points that are marked in fewer than two photos with a pose were not used: {points}.",
            points=", ".join(unseen),
        )
    if len(used) < WANTED_POINTS:
        yield tr(
            "With {count} control points there is no redundancy: a blunder cannot be detected. Use "
            "at least {wanted}.",
            count=len(used),
            wanted=WANTED_POINTS,
        )
    if few:
        yield tr(
            "These points are marked in fewer than {count} photos: {points}.",
            count=WANTED_PHOTOS,
            points=", ".join(few),
        )
    if not any(p.role == "check" for p in report.points):
        yield tr("There are no check points, so the registration is not verified independently.")
    if max(report.tilt_error_deg, report.rotation_error_deg[2]) > _WARN_DEG:
        yield tr(
            "The control points determine the model's azimuth only to about {azimuth:.1f}° and its "
            "tilt to about {tilt:.1f}°. Dip directions and dips can be wrong by as much. Place the "
            "points farther apart.",
            azimuth=report.rotation_error_deg[2],
            tilt=report.tilt_error_deg,
        )
    if adjust and not report.adjusted:
        yield tr(
            "The photos contradict the control points. The model was registered by a similarity "
            "and not adjusted to them."
        )
