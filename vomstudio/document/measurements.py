"""World coordinates and judged figures of the features, each worked out once per revision."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from operator import is_not
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.document.records import (
    FEATURES,
    Dimension,
    Feature,
    Group,
    Intersection,
    Lineation,
    Model,
    Patch,
    Reading,
    Record,
    Trace,
)
from vomstudio.errors import GeometryError
from vomstudio.geology import orientation
from vomstudio.geology.intersections import (
    UncertainPlane,
    intersection_line,
    mean_plane,
    scatter_deg,
    stray95,
    t95,
    uncertain_plane,
)
from vomstudio.geology.orientation import Line, Plane
from vomstudio.geology.quality import Thresholds, Verdict, judge, judge_line, wider_of
from vomstudio.geometry import transform
from vomstudio.geometry.lines import LineFit, fit_line, path_length, ring_area
from vomstudio.geometry.moment_planes import fit_moments
from vomstudio.geometry.planes import PlaneFit, fit_planes

Records = Mapping[str, Record]
Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Measurement:
    """What a feature says, in World; None where a figure does not apply or cannot be had.

    points : (n, 3) float64 its vertices; the centre of a patch, the place of a reading (n = 1); of
        an intersection the ends of a line as long as its planes
    resolution_m, outcrop_normal : the feature's own
    fit : of a trace or patch; line_fit : of a lineation. Where there is none `problem` says why
    plane, line : the orientation, whatever it comes from
    max/min_confidence95_deg : semi-axes of its joint 95 % region, confidence_axis (3,) the
        direction of the larger one where it is a line
    rake_deg : of a lineation in its plane, off_plane_deg : its angle from that plane,
    slip_rake_deg : directed, as in geology.orientation.slip_rake_of
    angle_deg : between the planes of an intersection
    area_m2 : of a patch's faces
    dimension : figures of a dimension by name, in m or m2
    metric : False where the model's scale is not known: lengths are then in units of its file
    """

    points: Floats
    resolution_m: float | None
    outcrop_normal: Floats | None
    fit: PlaneFit | None
    verdict: Verdict | None
    problem: str | None
    plane: Plane | None = None
    line: Line | None = None
    line_fit: LineFit | None = None
    max_confidence95_deg: float | None = None
    min_confidence95_deg: float | None = None
    confidence_axis: Floats | None = None
    rake_deg: float | None = None
    slip_rake_deg: float | None = None
    off_plane_deg: float | None = None
    angle_deg: float | None = None
    area_m2: float | None = None
    dimension: Mapping[str, float] | None = None
    metric: bool = True


class Measurements:
    """Measurements of a document's features, kept as long as what they rest on stays what it is."""

    def __init__(self, thresholds: Thresholds | None = None) -> None:
        self._thresholds = thresholds or Thresholds()
        self._kept: dict[str, tuple[tuple[Record | None, ...], Measurement]] = {}

    def of(self, records: Records, ids: Iterable[str]) -> dict[str, Measurement]:
        """The measurements of those `ids` that are features; new ones are fitted in one batch."""
        # The window asks for all of thousands at every edit: one pass, no generators.
        features, new, sources = [], [], {}
        for id_ in ids:
            feature = records.get(id_)
            if not isinstance(feature, FEATURES):
                continue
            features.append(feature)
            rests_on = sources_of(records, feature)
            kept = self._kept.get(id_)
            if kept is None or len(kept[0]) != len(rests_on) or any(map(is_not, kept[0], rests_on)):
                new.append(feature)
                sources[id_] = rests_on
        for feature, measurement in zip(new, self._measure(records, new), strict=True):
            self._kept[feature.id] = (sources[feature.id], measurement)
        return {feature.id: self._kept[feature.id][1] for feature in features}

    def one(self, records: Records, feature: Feature) -> Measurement:
        """The measurement of a feature that is not in the document."""
        return self._measure(records, [feature])[0]

    def _measure(self, records: Records, features: list[Any]) -> list[Measurement]:
        # An intersection of sets may rest on thousands of planes, of which one has changed.
        below = [plane.id for f in features for plane in planes_below(records, f)]
        known = self.of(records, dict.fromkeys(below)) if below else {}
        return measure_all(records, features, self._thresholds, known)

    def forget_all_but(self, records: Records) -> None:
        for id_ in [i for i in self._kept if i not in records]:
            del self._kept[id_]


def sources_of(records: Records, feature: Feature) -> tuple[Record | None, ...]:
    """The records that a feature's figures rest on, itself first."""
    if isinstance(feature, Reading):
        return (feature,)
    own = () if isinstance(feature, Intersection) else (_model(records, feature.model_id),)
    below = planes_below(records, feature)
    return (feature, *own, *(s for each in below for s in sources_of(records, each)))


def planes_below(records: Records, feature: Feature) -> list[Trace | Patch | Reading]:
    """The planes that a line, a dimension or an intersection rests on."""
    if isinstance(feature, Intersection):
        return [*members(records, feature.first), *members(records, feature.second)]
    if isinstance(feature, Lineation | Dimension):
        plane = records.get(feature.plane_id)
        return [plane] if isinstance(plane, Trace | Patch | Reading) else []
    return []


def members(records: Records, group: Group) -> list[Trace | Patch | Reading]:
    """The planes of a group, in the order of the records. Compass readings are no members of a
    group by type: they are another kind of evidence, to be compared, not pooled."""
    if group.feature_id:
        found = records.get(group.feature_id)
        return [found] if isinstance(found, Trace | Patch | Reading) else []
    return [
        r
        for r in records.values()
        if isinstance(r, Trace | Patch)
        and r.type_id == group.type_id
        and (not group.set_name or r.set_name == group.set_name)
    ]


def measure_all(
    records: Records,
    features: list[Any],
    thresholds: Thresholds | None = None,
    known: Mapping[str, Measurement] | None = None,
) -> list[Measurement]:
    """Measure features, the traces among them in one batch; `known` are measurements of planes
    that they rest on, by id, where these have been made already."""
    thresholds = thresholds or Thresholds()
    known = dict(known or {})
    below = {plane.id: plane for f in features for plane in planes_below(records, f)}
    missing = [plane for id_, plane in below.items() if id_ not in known]
    if missing:
        found = measure_all(records, missing, thresholds)
        known |= {plane.id: m for plane, m in zip(missing, found, strict=True)}
    traces = [f for f in features if isinstance(f, Trace)]
    fitted = measure([(t, _model(records, t.model_id)) for t in traces], thresholds)
    of_traces = iter(fitted)
    return [
        next(of_traces) if isinstance(f, Trace) else _measure_other(records, f, thresholds, known)
        for f in features
    ]


def _measure_other(
    records: Records, feature: Feature, thresholds: Thresholds, known: Mapping[str, Measurement]
) -> Measurement:
    if isinstance(feature, Patch):
        return measure_patch(feature, _model(records, feature.model_id), thresholds)
    if isinstance(feature, Reading):
        return _measure_reading(feature)
    if isinstance(feature, Lineation | Dimension):
        measured = (
            _measure_lineation(records, feature, thresholds, known)
            if isinstance(feature, Lineation)
            else _measure_dimension(records, feature, known)
        )
        return replace(measured, metric=_metric(_model(records, feature.model_id)))
    assert isinstance(feature, Intersection)
    return _measure_intersection(records, feature, thresholds, known)


# --- planes --------------------------------------------------------------------------------------
def measure(
    traces: list[tuple[Trace, Model | None]], thresholds: Thresholds | None = None
) -> list[Measurement]:
    """Fit and judge traces in World, all in one batch."""
    if not traces:
        return []
    thresholds = thresholds or Thresholds()
    points = [world_points(trace, model) for trace, model in traces]
    fits: list[tuple[PlaneFit | None, str | None]] = [(None, None)] * len(traces)
    for method in ("pca", "regression"):
        chosen = [i for i, (trace, _) in enumerate(traces) if trace.method == method]
        if not chosen:
            continue
        batch = fit_planes(
            np.concatenate([points[i] for i in chosen]),
            np.concatenate([[0], np.cumsum([len(points[i]) for i in chosen])]),
            method=method,
        )
        for row, i in enumerate(chosen):
            problem = batch.error[row]
            fits[i] = (None, problem) if problem else (batch[row], None)
    result = []
    for (trace, model), (fit, problem), own in zip(traces, fits, points, strict=True):
        rows = _rows(model)
        resolution = _length(trace.resolution, rows)
        face = (
            None
            if trace.outcrop_normal is None
            else transform.rotate(rows, [trace.outcrop_normal])[0]
        )
        verdict = (
            None
            if fit is None
            else judge(fit, resolution_m=resolution, outcrop_normal=face, thresholds=thresholds)
        )
        result.append(
            Measurement(
                own, resolution, face, fit, verdict, problem, **_of_fit(fit), metric=_metric(model)
            )
        )
    return result


def measure_one(
    trace: Trace, model: Model | None, thresholds: Thresholds | None = None
) -> Measurement:
    """A batch of one; raises GeometryError where no plane can be fitted."""
    measurement = measure([(trace, model)], thresholds)[0]
    if measurement.problem is not None:
        raise GeometryError(measurement.problem, field=trace.name or None)
    return measurement


def measure_patch(
    patch: Patch, model: Model | None, thresholds: Thresholds | None = None
) -> Measurement:
    """The plane of a patch, from its moments."""
    rows = _rows(model)
    scale = transform.scale_of(rows)
    turn = rows[:3, :3]
    centre = transform.apply(rows, [patch.mean])
    resolution = _length(patch.resolution, rows)
    size: dict[str, Any] = {
        "area_m2": None if patch.area is None else patch.area * scale**2,
        "metric": _metric(model),
    }
    try:
        fit = fit_moments(
            patch.n, centre[0], turn @ np.asarray(patch.scatter) @ turn.T, patch.n_effective
        )
    except GeometryError as error:
        return Measurement(centre, resolution, None, None, None, str(error), **size)
    verdict = judge(
        fit,
        resolution_m=resolution,
        outcrop_normal=None,
        kind="patch",
        thresholds=thresholds or Thresholds(),
    )
    return Measurement(centre, resolution, None, fit, verdict, None, **_of_fit(fit), **size)


def _measure_reading(reading: Reading) -> Measurement:
    points = np.array([] if reading.position is None else [reading.position], float).reshape(-1, 3)
    azimuth, inclination = reading.azimuth_deg, reading.inclination_deg
    return Measurement(
        points,
        None,
        None,
        None,
        None,
        None,
        plane=Plane(azimuth, inclination) if reading.geometry == "plane" else None,
        line=Line(azimuth, inclination) if reading.geometry == "line" else None,
    )


def _of_fit(fit: PlaneFit | None) -> dict[str, Any]:
    if fit is None:
        return {}
    return {
        "plane": Plane.from_normal(fit.normal),
        "max_confidence95_deg": fit.max_confidence95_deg,
        "min_confidence95_deg": fit.min_confidence95_deg,
    }


# --- lines ---------------------------------------------------------------------------------------
def _measure_lineation(
    records: Records,
    feature: Lineation,
    thresholds: Thresholds,
    known: Mapping[str, Measurement],
) -> Measurement:
    model = _model(records, feature.model_id)
    points = world_points(feature, model)
    resolution = _length(feature.resolution, _rows(model))
    base = _plane_of(records, feature.plane_id, known)
    gone = bool(feature.plane_id) and base is None
    try:
        fit = fit_line(points)
        line, rake, off, slip = Line.from_vector(fit.direction), None, None, None
        largest = smallest = fit.confidence95_deg
        axis = None
        if base is not None:
            plane = Plane.from_normal(base.normal)
            off = orientation.angle_line_plane(line, plane)
            rake = orientation.rake_of(line, plane)
            line = orientation.line_from_rake(plane, rake)
            slip = slip_rake(plane, rake, feature.slip)
            largest, smallest, axis = _in_plane_error(line.vector(), fit, base)
    except GeometryError as error:
        return Measurement(points, resolution, None, None, None, str(error))
    verdict = judge_line(
        fit,
        confidence95_deg=largest,
        off_plane_deg=off,
        plane_is_gone=gone,
        plane_is_known=base is None or base.spread95 is not None,
        thresholds=thresholds,
    )
    return Measurement(
        points,
        resolution,
        None,
        None,
        verdict,
        None,
        line=line,
        line_fit=fit,
        max_confidence95_deg=largest,
        min_confidence95_deg=smallest,
        confidence_axis=axis,
        rake_deg=rake,
        slip_rake_deg=slip,
        off_plane_deg=off,
    )


def _in_plane_error(
    direction: Floats, fit: LineFit, base: UncertainPlane
) -> tuple[float | None, float | None, Floats | None]:
    """Semi-axes and axis of the joint 95 % region of a line that was turned into a plane: along the
    plane it strays with the fit, across it with the plane."""
    across = stray95(base, direction)
    if across is None or fit.confidence95_deg is None:
        return None, None, None
    within, out = fit.confidence95_deg, float(np.degrees(np.arctan(across)))
    if out > within:
        return out, within, base.normal
    return within, out, np.cross(base.normal, direction)


def slip_rake(plane: Plane, rake_deg: float, sense: str) -> float | None:
    """The directed rake (-180, 180] of a slip along the axial rake [0, 180) with its sense of
    movement; None without one, or where the sense does not tell the direction: a normal or reverse
    movement along the strike, or on a vertical plane, which has no hanging wall; a strike slip
    down the dip; any sense on a horizontal plane."""
    if not sense or plane.undefined:
        return None
    if sense in ("normal", "reverse"):
        if rake_deg == 0.0 or plane.vertical:
            return None
        # The axial rake points down the dip; a reverse hanging wall moves the other way.
        return 180.0 - rake_deg if sense == "reverse" else -rake_deg
    if rake_deg == 90.0:
        return None
    # Rake 0 is left-lateral, and the axial rake's line has it where it is under 90.
    downward_is_sinistral = rake_deg < 90.0
    same = downward_is_sinistral == (sense == "sinistral")
    return (0.0 if same else 180.0) - rake_deg


def _measure_intersection(
    records: Records,
    feature: Intersection,
    thresholds: Thresholds,
    known: Mapping[str, Measurement],
) -> Measurement:
    groups = [members(records, group) for group in (feature.first, feature.second)]
    measured = [[known[plane.id] for plane in group] for group in groups]
    means = []
    scatter = 0.0
    try:
        for group, own in zip(groups, measured, strict=True):
            with_plane = [(r, m) for r, m in zip(group, own, strict=True) if m.plane is not None]
            if len(with_plane) == 1:
                planes = [_as_uncertain(*with_plane[0])]
            else:
                # The error of a mean comes from the scatter; their own ones take time.
                planes = [UncertainPlane(_normal(m), None) for _, m in with_plane]
            sound = [plane for plane in planes if plane is not None]
            means.append(mean_plane(sound))
            scatter = max(scatter, scatter_deg(sound, means[-1]))
        found = intersection_line(*means)
    except GeometryError as error:
        return Measurement(np.zeros((0, 3)), None, None, None, None, str(error))
    verdict = judge_line(
        None,
        confidence95_deg=found.max_confidence95_deg,
        scatter_deg=scatter,
        thresholds=thresholds,
    )
    return Measurement(
        _ends(found.line.vector(), means, measured),
        None,
        None,
        None,
        verdict,
        None,
        line=found.line,
        max_confidence95_deg=found.max_confidence95_deg,
        min_confidence95_deg=found.min_confidence95_deg,
        confidence_axis=found.confidence_axis,
        angle_deg=found.angle_deg,
    )


def _ends(
    direction: Floats, means: list[UncertainPlane], measured: list[list[Measurement]]
) -> Floats:
    """(2, 3) ends of a line as long as the longest of the planes, where the two planes through the
    middle of each group meet, or, where that is far away, midway between the groups."""
    extents = [m.fit.extent for own in measured for m in own if m.fit and m.fit.extent]
    centres = []
    for own in measured:
        placed = [m.fit.centroid if m.fit else m.points.mean(axis=0) for m in own if len(m.points)]
        if placed:
            centres.append(np.mean(placed, axis=0))
    if not extents or not centres:
        return np.zeros((0, 3))
    half = 0.5 * max(extents)
    middle = np.mean(centres, axis=0)
    if len(centres) == 2:
        rows = np.array([means[0].normal, means[1].normal])
        gaps = np.einsum("ij,ij->i", rows, np.array(centres) - middle)
        step = np.linalg.lstsq(rows, gaps, rcond=None)[0]
        apart = float(np.linalg.norm(centres[1] - centres[0]))
        if np.linalg.norm(step) <= half + apart:
            middle = middle + step
    return np.array([middle - half * direction, middle + half * direction])


# --- dimensions ----------------------------------------------------------------------------------
def _measure_dimension(
    records: Records, feature: Dimension, known: Mapping[str, Measurement]
) -> Measurement:
    points = world_points(feature, _model(records, feature.model_id))
    problem = None
    figures: dict[str, float] = {}
    if feature.kind == "area":
        if len(points) < 3:
            problem = "an area needs 3 points or more"
        else:
            figures = {
                "area_m2": ring_area(points),
                "perimeter_m": path_length(np.vstack([points, points[:1]])),
            }
    elif len(points) < 2:
        problem = "a length needs 2 points"
    else:
        step = points[-1] - points[0]
        figures = {
            "distance_m": float(np.linalg.norm(step)),
            "horizontal_m": float(np.hypot(step[0], step[1])),
            "vertical_m": float(step[2]),
        }
        if feature.kind == "polyline":
            figures["length_m"] = path_length(points)
        if feature.kind == "thickness":
            thickness, problem = _thickness(records, feature, step, known)
            figures |= thickness
    return Measurement(points, None, None, None, None, problem, dimension=figures or None)


def _thickness(
    records: Records, feature: Dimension, step: Floats, known: Mapping[str, Measurement]
) -> tuple[dict[str, float], str | None]:
    """Distance across the plane, and its 95 % error (of this one figure, not joint): points that
    lie apart along the bed turn a tilt of the plane into thickness, and each of the two lies on a
    surface as uneven as the plane's own points are."""
    plane = _plane_of(records, feature.plane_id, known)
    if plane is None:
        if not feature.plane_id:
            return {}, "a thickness needs a plane that it is measured across; choose one"
        return {}, "its plane is gone, or has none"
    across = float(step @ plane.normal)
    figures = {"thickness_m": abs(across)}
    tilt = stray95(plane, step - across * plane.normal, joint=False)
    if tilt is not None:
        uneven = t95(plane.free) * float(np.sqrt(2.0)) * plane.roughness
        figures["thickness_error95_m"] = float(np.hypot(tilt, uneven))
    return figures, None


# --- shared --------------------------------------------------------------------------------------
def _plane_of(
    records: Records, id_: str, known: Mapping[str, Measurement]
) -> UncertainPlane | None:
    feature = records.get(id_)
    if not isinstance(feature, Trace | Patch | Reading):
        return None
    return _as_uncertain(feature, known[id_])


def _normal(measured: Measurement) -> Floats:
    """Of something that has a plane."""
    if measured.fit is not None:
        return measured.fit.normal
    assert measured.plane is not None
    return measured.plane.normal()


def _as_uncertain(feature: Trace | Patch | Reading, measured: Measurement) -> UncertainPlane | None:
    """The plane with the error it is judged by; None where there is no plane."""
    fit, plane = measured.fit, measured.plane
    if plane is None:
        return None
    if fit is None or fit.error_rake_deg is None:
        return UncertainPlane(plane.normal(), None)
    tilt = orientation.line_from_rake(plane, fit.error_rake_deg).vector()
    largest, smallest = wider_of(fit, "patch" if isinstance(feature, Patch) else "trace")
    free = 1.0 if fit.n_effective is None else max(fit.n_effective - 3.0, 1.0)
    rough = 0.0 if fit.rms is None else fit.rms * float(np.sqrt(fit.n / max(fit.n - 3.0, 1.0)))
    return replace(uncertain_plane(plane.normal(), tilt, largest, smallest, free), roughness=rough)


def world_points(feature: Trace | Lineation | Dimension, model: Model | None) -> Floats:
    """(n, 3) vertices in World; in the file frame where the model is gone."""
    return transform.apply(_rows(model), np.asarray(feature.vertices, dtype=np.float64))


def _model(records: Records, model_id: str) -> Model | None:
    model = records.get(model_id)
    return model if isinstance(model, Model) else None


def _metric(model: Model | None) -> bool:
    return model is None or model.frame.has_metres


def _rows(model: Model | None) -> Floats:
    return np.eye(4) if model is None else transform.matrix(model.to_world)


def _length(value: float | None, rows: Floats) -> float | None:
    return None if value is None else value * transform.scale_of(rows)
