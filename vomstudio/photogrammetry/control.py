"""The model placed by ground control points, and judged by check points."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from vomstudio.errors import GeometryError
from vomstudio.geometry.similarity import fit_robustly, fit_similarity, rotation_covariance
from vomstudio.io.control import ControlPoint, Mark
from vomstudio.photogrammetry.mapping import point_errors
from vomstudio.photogrammetry.scene import SparseScene
from vomstudio.photogrammetry.tied import KnownPoint, adjust_tied, triangulate
from vomstudio.progress import Progress

Array = npt.NDArray[np.float64]

# A point should be marked in so many photos (textbook 3.2.2).
_WANTED_PHOTOS = 4
_WANTED_POINTS = 4
_WARN_DEG = 1.0
# Second axis over first of points that are nearly on a line.
_THIN = 0.02


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
    warnings: tuple[str, ...]


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
    from vomstudio.photogrammetry.georeference import integer_origin, moved

    seen, unknown = _observations(scene, control, marks)
    world = np.array([p.position for p in control], np.float64).reshape(-1, 3)
    usable = [i for i, o in enumerate(seen) if np.isfinite(_place(scene, o)).all()]
    fitting = [i for i in usable if not control[i].check]
    if len(fitting) < 3:
        raise GeometryError(
            f"{len(fitting) or 'none'} of the {sum(not p.check for p in control)} control points "
            "can be found in the model; at least 3, each marked in two or more placed photos, are "
            f"needed{unknown and '; ' + unknown[0]}"
        )
    origin = integer_origin(world[fitting])
    local = world - origin
    places = np.array([_place(scene, seen[i]) for i in fitting])
    _require_width(local[fitting])
    stated = [p.sigma_m for p in (control[i] for i in fitting) if p.sigma_m is not None]
    surveyed = float(np.median(stated)) if stated else 0.0
    first = fit_similarity(places, local[fitting])
    pixel = scene.pixel_at(places) * first.scale
    floor = 3 * math.hypot(surveyed, 2 * pixel)
    fit, good = fit_robustly(places, local[fitting], floor=floor)
    used = [i for i, keep in zip(fitting, good, strict=True) if keep]
    misses = (fit(places) - local[fitting])[good]
    freedom = 3 * len(used) - 7
    sigma = max(math.sqrt(float((misses**2).sum()) / freedom), surveyed)
    covariance = rotation_covariance(local[used], max(sigma, 1e-9))
    turn = np.degrees(np.sqrt(np.diag(covariance)))
    placed = moved(scene, fit, origin, crs)
    adjusted = False
    if adjust:
        known = [
            KnownPoint(local[i], control[i].sigma_m or max(surveyed, pixel), *seen[i]) for i in used
        ]
        better = adjust_tied(placed, known, threads=threads, progress=progress)
        # Control points that no bundle of rays can meet bend the model: the tie points tell.
        adjusted = _mean_error(better) <= 1.2 * _mean_error(placed) + 0.1
        placed = better if adjusted else placed
    points = tuple(
        _fit_of(placed, point, local[i], seen[i], i in used) for i, point in enumerate(control)
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
        (),
    )
    warnings = [*unknown, *_warnings(report, adjust)]
    return placed, replace(report, warnings=tuple(warnings))


def _observations(
    scene: SparseScene, control: Sequence[ControlPoint], marks: Sequence[Mark]
) -> tuple[list[tuple[npt.NDArray[np.int64], Array]], list[str]]:
    """For each point (rows of views, pixels), and sentences about marks that are of no use."""
    rows: dict[str, int] = {}
    shorter: dict[str, list[int]] = {}
    for row, view in enumerate(scene.views):
        rows[view.name] = row
        shorter.setdefault(view.name.rsplit("/", 1)[-1].casefold(), []).append(row)
    number = {point.label: i for i, point in enumerate(control)}
    views: list[list[int]] = [[] for _ in control]
    pixels: list[list[tuple[float, float]]] = [[] for _ in control]
    no_photo, no_point = set(), set()
    for mark in marks:
        same = shorter.get(mark.photo.rsplit("/", 1)[-1].casefold(), [])
        row = rows.get(mark.photo, same[0] if len(same) == 1 else -1)
        if row < 0:
            no_photo.add(mark.photo)
        if mark.label not in number:
            no_point.add(mark.label)
        elif row >= 0:
            views[number[mark.label]].append(row)
            pixels[number[mark.label]].append((mark.x, mark.y))
    said = []
    if no_photo:
        said.append(f"marks in {_some(no_photo)} are not used: no such photo is placed")
    if no_point:
        said.append(f"marks of {_some(no_point)} are not used: no such point in the table")
    found = [
        (np.array(v, np.int64), np.array(p, np.float64).reshape(-1, 2))
        for v, p in zip(views, pixels, strict=True)
    ]
    return found, said


def _some(names: set[str]) -> str:
    shown = sorted(names)[:4]
    return ", ".join(shown) + (f" and {len(names) - 4} more" if len(names) > 4 else "")


def _place(scene: SparseScene, seen: tuple[npt.NDArray[np.int64], Array]) -> Array:
    rows, pixels = seen
    return triangulate([scene.views[r] for r in rows], pixels)


def _require_width(local: Array) -> None:
    axes = np.linalg.svd(local - local.mean(axis=0), compute_uv=False)
    if axes[1] < _THIN * axes[0]:
        raise GeometryError(
            "the control points lie on one line, about which the model could turn; add one "
            "beside it"
        )


def _mean_error(scene: SparseScene) -> float:
    errors = point_errors(scene)
    return float(np.nanmean(errors)) if len(errors) else 0.0


def _fit_of(
    scene: SparseScene,
    point: ControlPoint,
    local: Array,
    seen: tuple[npt.NDArray[np.int64], Array],
    used: bool,
) -> PointFit:
    place = _place(scene, seen)
    residual = None
    if np.isfinite(place).all():
        dx, dy, dz = (float(v) for v in place - local)
        residual = (dx, dy, dz)
    rows, pixels = seen
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
    few = [p.label for p in used if p.photos < _WANTED_PHOTOS]
    if out:
        yield f"control points that contradict the others were left out: {', '.join(out)}"
    if unseen:
        yield f"points marked in fewer than two placed photos tell nothing: {', '.join(unseen)}"
    if len(used) < _WANTED_POINTS:
        yield "3 control points leave nothing over to find a mistake with; use 4 or more"
    if few:
        yield f"marked in fewer than {_WANTED_PHOTOS} photos: {', '.join(few)}"
    if not any(p.role == "check" for p in report.points):
        yield "no check points judge the model independently of the points that placed it"
    if max(report.tilt_error_deg, report.rotation_error_deg[2]) > _WARN_DEG:
        yield (
            "the control points leave the model turned by about "
            f"{report.rotation_error_deg[2]:.1f}° and tilted by about "
            f"{report.tilt_error_deg:.1f}°: dips and dip directions can be wrong by as much; "
            "spread the points wider"
        )
    if adjust and not report.adjusted:
        yield "the photos contradict the control points; the model was placed without bending it"
