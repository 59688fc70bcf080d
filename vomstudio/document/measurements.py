"""World coordinates and judged figures of the features, each worked out once per revision."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
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
    uncertain_plane,
)
from vomstudio.geology.orientation import Line, Plane
from vomstudio.geology.quality import Thresholds, Verdict, judge, judge_line
from vomstudio.geometry import transform
from vomstudio.geometry.lines import LineFit, fit_line, path_length, ring_area
from vomstudio.geometry.moment_planes import fit_moments
from vomstudio.geometry.planes import PlaneFit, fit_planes

Records = Mapping[str, Record]
Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Measurement:
    """What a feature says, in World; None where a figure does not apply or cannot be had.

    points : (n, 3) float64 its vertices; the centre of a patch, the place of a reading (n = 1)
    resolution_m, outcrop_normal : the feature's own
    fit : of a trace or patch; line_fit : of a lineation. Where there is none `problem` says why
    plane, line : the orientation, whatever it comes from
    max/min_confidence95_deg : semi-axes of its joint 95 % region
    rake_deg : of a lineation in its plane, off_plane_deg : its angle from that plane,
    slip_rake_deg : directed, as in geology.orientation.slip_rake_of
    angle_deg : between the planes of an intersection
    area_m2 : of a patch's faces
    dimension : figures of a dimension by name, in m or m2
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
    rake_deg: float | None = None
    slip_rake_deg: float | None = None
    off_plane_deg: float | None = None
    angle_deg: float | None = None
    area_m2: float | None = None
    dimension: Mapping[str, float] | None = None


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
        for feature, measurement in zip(
            new, measure_all(records, new, self._thresholds), strict=True
        ):
            self._kept[feature.id] = (sources[feature.id], measurement)
        return {feature.id: self._kept[feature.id][1] for feature in features}

    def forget_all_but(self, records: Records) -> None:
        for id_ in [i for i in self._kept if i not in records]:
            del self._kept[id_]


def sources_of(records: Records, feature: Feature) -> tuple[Record | None, ...]:
    """The records that a feature's figures rest on, itself first."""
    if isinstance(feature, Reading):
        return (feature,)
    if isinstance(feature, Intersection):
        below = [*members(records, feature.first), *members(records, feature.second)]
    else:
        plane = records.get(feature.plane_id) if not isinstance(feature, Trace | Patch) else None
        below = [plane] if isinstance(plane, Trace | Patch | Reading) else []
    own = () if isinstance(feature, Intersection) else (_model(records, feature.model_id),)
    return (feature, *own, *(s for each in below for s in sources_of(records, each)))


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
    records: Records, features: list[Any], thresholds: Thresholds | None = None
) -> list[Measurement]:
    """Measure features, the traces among them in one batch."""
    thresholds = thresholds or Thresholds()
    traces = [f for f in features if isinstance(f, Trace)]
    fitted = measure([(t, _model(records, t.model_id)) for t in traces], thresholds)
    of_traces = iter(fitted)
    return [
        next(of_traces) if isinstance(f, Trace) else _measure_other(records, f, thresholds)
        for f in features
    ]


def _measure_other(records: Records, feature: Feature, thresholds: Thresholds) -> Measurement:
    if isinstance(feature, Patch):
        return measure_patch(feature, _model(records, feature.model_id), thresholds)
    if isinstance(feature, Reading):
        return _measure_reading(feature)
    if isinstance(feature, Lineation):
        return _measure_lineation(records, feature, thresholds)
    if isinstance(feature, Dimension):
        return _measure_dimension(records, feature, thresholds)
    assert isinstance(feature, Intersection)
    return _measure_intersection(records, feature, thresholds)


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
        result.append(Measurement(own, resolution, face, fit, verdict, problem, **_of_fit(fit)))
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
    area = None if patch.area is None else patch.area * scale**2
    try:
        fit = fit_moments(
            patch.n, centre[0], turn @ np.asarray(patch.scatter) @ turn.T, patch.n_effective
        )
    except GeometryError as error:
        return Measurement(centre, resolution, None, None, None, str(error), area_m2=area)
    verdict = judge(
        fit,
        resolution_m=resolution,
        outcrop_normal=None,
        kind="patch",
        thresholds=thresholds or Thresholds(),
    )
    return Measurement(centre, resolution, None, fit, verdict, None, area_m2=area, **_of_fit(fit))


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
def _measure_lineation(records: Records, feature: Lineation, thresholds: Thresholds) -> Measurement:
    model = _model(records, feature.model_id)
    points = world_points(feature, model)
    resolution = _length(feature.resolution, _rows(model))
    plane = _plane_of(records, feature.plane_id, thresholds)
    gone = bool(feature.plane_id) and plane is None
    try:
        fit = fit_line(points)
        line, rake, off, slip = Line.from_vector(fit.direction), None, None, None
        if plane is not None:
            off = orientation.angle_line_plane(line, plane)
            rake = orientation.rake_of(line, plane)
            line = orientation.line_from_rake(plane, rake)
            slip = slip_rake(plane, rake, feature.slip)
    except GeometryError as error:
        return Measurement(points, resolution, None, None, None, str(error))
    verdict = judge_line(fit, off_plane_deg=off, plane_is_gone=gone, thresholds=thresholds)
    return Measurement(
        points,
        resolution,
        None,
        None,
        verdict,
        None,
        line=line,
        line_fit=fit,
        max_confidence95_deg=fit.confidence95_deg,
        min_confidence95_deg=fit.confidence95_deg,
        rake_deg=rake,
        slip_rake_deg=slip,
        off_plane_deg=off,
    )


def slip_rake(plane: Plane, rake_deg: float, sense: str) -> float | None:
    """The directed rake (-180, 180] of a slip along the axial rake [0, 180) with its sense of
    movement; None without one, or where the sense does not tell the direction (a normal or reverse
    movement along the strike, a strike slip down the dip)."""
    if not sense:
        return None
    if sense in ("normal", "reverse"):
        if rake_deg == 0.0:
            return None
        # The axial rake points down the dip; a reverse hanging wall moves the other way.
        return 180.0 - rake_deg if sense == "reverse" else -rake_deg
    if rake_deg == 90.0:
        return None
    # Rake 0 is left-lateral, and the axial rake's line has it where it is under 90.
    downward_is_sinistral = rake_deg < 90.0
    return -rake_deg if downward_is_sinistral == (sense == "sinistral") else 180.0 - rake_deg


def _measure_intersection(
    records: Records, feature: Intersection, thresholds: Thresholds
) -> Measurement:
    nothing = np.zeros((0, 3))
    try:
        means = [
            mean_plane(
                [
                    u
                    for each in members(records, group)
                    if (u := _uncertain(records, each, thresholds)) is not None
                ]
            )
            for group in (feature.first, feature.second)
        ]
        found = intersection_line(*means)
    except GeometryError as error:
        return Measurement(nothing, None, None, None, None, str(error))
    verdict = judge_line(None, confidence95_deg=found.max_confidence95_deg, thresholds=thresholds)
    centres = [
        m.points.mean(axis=0)
        for group in (feature.first, feature.second)
        for each in members(records, group)
        if len((m := measure_all(records, [each], thresholds)[0]).points)
    ]
    return Measurement(
        np.mean(centres, axis=0)[None] if centres else nothing,
        None,
        None,
        None,
        verdict,
        None,
        line=found.line,
        max_confidence95_deg=found.max_confidence95_deg,
        min_confidence95_deg=found.min_confidence95_deg,
        angle_deg=found.angle_deg,
    )


# --- dimensions ----------------------------------------------------------------------------------
def _measure_dimension(records: Records, feature: Dimension, thresholds: Thresholds) -> Measurement:
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
            thickness, problem = _thickness(records, feature, step, thresholds)
            figures |= thickness
    return Measurement(points, None, None, None, None, problem, dimension=figures or None)


def _thickness(
    records: Records, feature: Dimension, step: Floats, thresholds: Thresholds
) -> tuple[dict[str, float], str | None]:
    """Distance across the plane, and its joint 95 % error from the plane's attitude: points that
    lie apart along the bed turn a tilt of the plane into thickness."""
    base = records.get(feature.plane_id)
    plane = (
        _uncertain(records, base, thresholds) if isinstance(base, Trace | Patch | Reading) else None
    )
    if plane is None:
        return {}, "its plane is gone, or has none"
    across = float(step @ plane.normal)
    figures = {"thickness_m": abs(across)}
    if plane.spread95 is not None:
        along = step - across * plane.normal
        figures["thickness_error95_m"] = float(
            np.sqrt(max(float(along @ plane.spread95 @ along), 0.0))
        )
    return figures, None


# --- shared --------------------------------------------------------------------------------------
def _plane_of(records: Records, id_: str, thresholds: Thresholds) -> Plane | None:
    feature = records.get(id_)
    if not isinstance(feature, Trace | Patch | Reading):
        return None
    return measure_all(records, [feature], thresholds)[0].plane


def _uncertain(
    records: Records, feature: Trace | Patch | Reading, thresholds: Thresholds
) -> UncertainPlane | None:
    measured = measure_all(records, [feature], thresholds)[0]
    if measured.fit is not None:
        fit = measured.fit
        return uncertain_plane(
            fit.normal, fit.axes, fit.max_confidence95_deg, fit.min_confidence95_deg
        )
    if measured.plane is not None:
        return UncertainPlane(measured.plane.normal(), None)
    return None


def world_points(feature: Trace | Lineation | Dimension, model: Model | None) -> Floats:
    """(n, 3) vertices in World; in the file frame where the model is gone."""
    return transform.apply(_rows(model), np.asarray(feature.vertices, dtype=np.float64))


def _model(records: Records, model_id: str) -> Model | None:
    model = records.get(model_id)
    return model if isinstance(model, Model) else None


def _rows(model: Model | None) -> Floats:
    return np.eye(4) if model is None else transform.matrix(model.to_world)


def _length(value: float | None, rows: Floats) -> float | None:
    return None if value is None else value * transform.scale_of(rows)
