"""Line on the outcrop, such as a striation, a fold hinge or a mineral lineation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import cause_finding
from vomstudio.core.words import to_translate as _
from vomstudio.core.words import tr
from vomstudio.geology import orientation
from vomstudio.geology.common_rotation_errors import (
    differentiate_vectors,
    line_confidence_region,
    project_line,
    region,
)
from vomstudio.geology.intersections import UncertainPlane, deviation95
from vomstudio.geology.notation import format_error_deg
from vomstudio.geology.orientation import Line, Plane, slip_from_rake
from vomstudio.geology.quality import judge_line
from vomstudio.geology.slip import CONFIDENCES, SENSES, SlipConfidence, SlipSense, slip_rake
from vomstudio.geometry.lines import FittedLine, fit_line
from vomstudio.geometry.matrices import Point
from vomstudio.project import catalogue as of
from vomstudio.project import kind
from vomstudio.project.figures import Subject
from vomstudio.project.kind import (
    Attribute,
    GisLayer,
    Kind,
    Lookup,
    NetAppearance,
    Sketch,
    centre,
    get_line,
    midpoint,
    plane_dependencies,
    plane_ids,
)
from vomstudio.project.measurement import (
    Measurement,
    MeasurementContext,
    empty_measurement,
    is_metric,
    length_in_metres,
    matrix_to_world,
    world_points,
)
from vomstudio.project.records import PickedFeature, RepeatableFeature, TypedFeature, get_feature
from vomstudio.project.registration_errors import get_model, get_rotation_errors
from vomstudio.project.slip_figures import SLIP


@dataclass(frozen=True)
class Lineation(PickedFeature, RepeatableFeature, TypedFeature):
    """Lineation with two or more vertices.

    Attributes
    ----------
    plane_id : str
        ID of the feature whose plane contains the lineation, or "" if no plane is assigned. The
        direction is projected onto that plane and has a rake.
    slip : str
        Movement of the hanging wall along the lineation.
    slip_confidence : str
        Confidence of the sense of slip.

    Notes
    -----
    The other fields are described in Trace.
    """

    id: str
    name: str
    type_id: str
    model_id: str
    model_hash: str
    vertices: tuple[Point, ...]
    resolution: float | None = None
    plane_id: str = ""
    slip: SlipSense = ""
    set_name: str = ""
    notes: str = ""
    slip_confidence: SlipConfidence = ""
    repeat_of: str | None = None
    interpreter: str | None = None
    domain: str = ""


def measure(context: MeasurementContext, lines: Sequence[Lineation]) -> list[Measurement]:
    """Measure the directions of lines, with rake and slip if they lie on planes."""
    return [_measure(context, line) for line in lines]


def _measure(context: MeasurementContext, feature: Lineation) -> Measurement:
    model = context.model(feature.model_id)
    points = world_points(feature, model)
    resolution = length_in_metres(feature.resolution, matrix_to_world(model))
    metric = is_metric(model)
    base = context.plane(feature.plane_id)
    is_plane_missing = bool(feature.plane_id) and base is None
    plane = None if base is None else context.known[feature.plane_id].plane
    try:
        fit = fit_line(points)
        line, rake, off_plane_deg, slip = Line.from_vector(fit.direction), None, None, None
        largest = error_deg = fit.confidence95_deg
        axis = None
        if base is not None and plane is not None:
            off_plane_deg = orientation.angle_line_plane(line, plane)
            rake = orientation.compute_rake(line, plane)
            line = orientation.line_from_rake(plane, rake)
            slip = slip_rake(plane, rake, feature.slip)
            largest, error_deg, axis = _projected_error(line.vector(), fit, base)
    except GeometryError as error:
        return empty_measurement(
            points, resolution, cause_finding(error), kind="lineation", metric=metric
        )
    covariance = _registration_covariance(context, feature, line.vector(), base)
    registration = None if covariance is None else region(line.vector(), covariance).largest_deg
    total_region = line_confidence_region(line.vector(), covariance, largest, error_deg, axis)
    verdict = judge_line(
        fit,
        confidence95_deg=None if total_region is None else total_region.largest_deg,
        registration_deg=registration,
        off_plane_deg=off_plane_deg,
        is_plane_missing=is_plane_missing,
        is_plane_known=base is None or base.spread95 is not None,
        thresholds=context.thresholds,
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
        min_confidence95_deg=error_deg,
        confidence_axis=axis,
        rake_deg=rake,
        slip_rake_deg=slip,
        off_plane_deg=off_plane_deg,
        on_plane=plane,
        metric=metric,
        kind="lineation",
        registration_error_deg=registration,
        total=total_region,
    )


def _registration_covariance(
    context: MeasurementContext,
    feature: Lineation,
    direction: FloatArray,
    base: UncertainPlane | None,
) -> FloatArray | None:
    """Return the covariance (3, 3) due to the registrations of the models of line and plane.

    Returns None if neither is known.
    """
    plane = None if base is None else get_feature(context.records, feature.plane_id)
    rotation_errors = get_rotation_errors(
        [context.model(feature.model_id), get_model(context.records, plane)]
    )
    if not rotation_errors.of([0] if base is None else [0, 1]).has_known_errors:
        return None
    line = differentiate_vectors(direction, rotation_errors.of([0]))
    if base is not None:
        line = project_line(line, differentiate_vectors(base.normal, rotation_errors.of([1])))
    return np.asarray(line.covariance()[0])


def _projected_error(
    direction: FloatArray, fit: FittedLine, base: UncertainPlane
) -> tuple[float | None, float | None, FloatArray | None]:
    """Return the joint 95 % region (semi-axes and axis) of a line projected onto a plane.

    Within the plane, the error is that of the fit; across it, the error is that of the plane. All
    values are None if one of these errors is unknown.
    """
    deviation = deviation95(base, direction)
    if deviation is None or fit.confidence95_deg is None:
        return None, None, None
    fit_error_deg, plane_error_deg = (
        fit.confidence95_deg,
        float(np.degrees(np.arctan(deviation))),
    )
    if plane_error_deg > fit_error_deg:
        return plane_error_deg, fit_error_deg, base.normal
    return fit_error_deg, plane_error_deg, np.cross(base.normal, direction)


def sketch(subject: Subject, measurements: Lookup) -> Sketch | None:
    """Return the line, with an arrowhead in the direction of slip if known.

    Returns None if it has no points.
    """
    feature: Lineation = subject.feature
    points = subject.measured.points
    if not len(points):
        return None
    line = points
    slip = subject.measured.slip_rake_deg
    base = None if slip is None else measurements(feature.plane_id)
    if slip is not None and base is not None and base.plane is not None:
        line = _add_arrowhead(points, base.plane, slip)
    if len(points) < 2:
        position = centre(subject.measured)
        return Sketch(line, position, sign=position)
    return Sketch(line, midpoint(line[: len(feature.vertices)]), sign=midpoint(points))


def _add_arrowhead(ends: FloatArray, plane: Plane, slip_rake_deg: float) -> FloatArray:
    slip = slip_from_rake(plane, slip_rake_deg).vector()
    if (ends[-1] - ends[0]) @ slip < 0.0:
        ends = ends[::-1]
    size = 0.18 * float(np.linalg.norm(ends[-1] - ends[0]))
    cross_axis = np.cross(plane.normal(), slip)
    barb_ends = [ends[-1] + size * (0.5 * sign * cross_axis - slip) for sign in (1.0, -1.0)]
    return np.vstack([ends, barb_ends[0], ends[-1], barb_ends[1]])


def remarks(subject: Subject) -> list[str]:
    """Return a remark if the recorded sense of slip does not define a direction."""
    feature, measurement = subject.feature, subject.measured
    if not feature.slip or measurement.on_plane is None or measurement.slip_rake_deg is not None:
        return []
    return [tr("the sense of slip does not determine the direction of the line on this plane")]


def words(measured: Measurement) -> list[str]:
    """Describe the rake and the angle between the line and the plane."""
    lines = []
    if measured.rake_deg is not None:
        angle = format_error_deg(measured.off_plane_deg)
        lines.append(
            tr("Rake {rake:.0f}°, {angle} off its plane", rake=measured.rake_deg, angle=angle)
        )
    if measured.slip_rake_deg is not None:
        lines.append(tr("Slip of the hanging wall: rake {rake:.0f}°", rake=measured.slip_rake_deg))
    return lines


N_VERTICES = replace(of.N_POINTS, value=lambda subject: len(subject.feature.vertices))

KIND = Kind(
    name="lineation",
    order=20,
    record=Lineation,
    title=_("Lineation"),
    icon="arrow-top-right",
    measure=measure,
    figures=(
        *of.NAME_FIGURES,
        *of.LINE,
        *SLIP,
        *of.PLACE,
        *of.SIZE,
        *of.CONFIDENCE,
        of.REGISTRATION_ERROR,
        of.TOTAL_ERROR,
        *of.VERDICT,
        of.METHOD,
        *of.MODEL_FIGURES,
        of.NOTES,
    ),
    attributes=(
        kind.NAME,
        kind.TYPE,
        kind.SET,
        kind.DOMAIN,
        Attribute("plane_id", _("On plane"), "plane"),
        Attribute("slip", _("Slip"), "choice", SENSES, applies=lambda line: bool(line.plane_id)),
        Attribute(
            "slip_confidence",
            _("Confidence"),
            "choice",
            CONFIDENCES,
            applies=lambda line: bool(line.plane_id and line.slip),
        ),
        kind.NOTES,
    ),
    sketch=sketch,
    remarks=remarks,
    about=remarks,
    words=words,
    orientations=("line",),
    evidence="picked",
    dependency_ids=plane_ids,
    dependencies=plane_dependencies,
    tool="line",
    net=NetAppearance(),
    layer=GisLayer(
        "lineations",
        "line",
        get_line,
        (
            *of.NAME_FIGURES,
            N_VERTICES,
            of.TREND,
            of.PLUNGE,
            *SLIP,
            of.MAX_CONFIDENCE,
            of.QUALITY,
            of.NOTES,
        ),
    ),
)
