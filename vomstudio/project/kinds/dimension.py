"""Length, area, or distance perpendicular to the plane of another feature."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate as _
from vomstudio.geology.intersections import deviation95, t95
from vomstudio.geometry.lines import path_length, ring_area
from vomstudio.geometry.matrices import Point
from vomstudio.project import catalogue as of
from vomstudio.project import kind
from vomstudio.project.bed_descriptions import notes_with_beds
from vomstudio.project.dimension_errors import (
    direction_figures,
    point_errors,
    registration_errors,
    thickness_error,
)
from vomstudio.project.figures import Subject
from vomstudio.project.kind import (
    Attribute,
    GisLayer,
    Kind,
    KindGroup,
    Lookup,
    Sketch,
    centre,
    get_line,
    midpoint,
    plane_dependencies,
    plane_ids,
)
from vomstudio.project.length_figures import (
    AREA,
    AREA_REGISTRATION,
    LENGTH,
    LENGTH_REGISTRATION,
    PERIMETER,
    PERIMETER_REGISTRATION,
    figure_value,
    headline,
    length_figure,
    words,
)
from vomstudio.project.measurement import (
    Measurement,
    MeasurementContext,
    is_metric,
    length_in_metres,
    matrix_to_world,
    world_points,
)
from vomstudio.project.records import LoggedFeature, get_feature
from vomstudio.project.registration_errors import get_model

DimensionKind = Literal["distance", "polyline", "area", "thickness"]

KINDS: tuple[tuple[DimensionKind, str], ...] = (
    ("distance", _("Distance")),
    ("polyline", _("Polyline")),
    ("area", _("Area")),
    ("thickness", _("Thickness")),
)
GROUP = KindGroup("dimensions", _("Measurements"), "ruler")


@dataclass(frozen=True)
class Dimension(LoggedFeature):
    """Measured dimension. A thickness is perpendicular to the plane of feature `plane_id`.

    `resolution` is that of the model around the points in file units, or None if unknown.
    """

    id: str
    name: str
    kind: DimensionKind
    model_id: str
    model_hash: str
    vertices: tuple[Point, ...]
    plane_id: str = ""
    notes: str = ""
    beds: tuple[tuple[str, str, str], ...] = ()
    resolution: float | None = None


def measure(context: MeasurementContext, dimensions: Sequence[Dimension]) -> list[Measurement]:
    """Measure the lengths, the area and perimeter, or the thickness of each dimension."""
    return [_measure(context, dimension) for dimension in dimensions]


def _measure(context: MeasurementContext, feature: Dimension) -> Measurement:
    model = context.model(feature.model_id)
    points = world_points(feature, model)
    problem: Finding | None = None
    figures: dict[str, float] = {}
    step: FloatArray | None = None
    if feature.kind == "area":
        if len(points) < 3:
            problem = Finding("feature.too-few-points", count=3 - len(points), minimum=3)
        else:
            figures = {
                "area_m2": ring_area(points),
                "perimeter_m": path_length(np.vstack([points, points[:1]])),
            }
    elif len(points) < 2:
        problem = Finding("feature.too-few-points", count=2 - len(points), minimum=2)
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
            thickness, problem = _thickness(context, feature, step)
            figures |= thickness
    figures |= registration_errors(figures, model, step)
    if feature.kind == "distance" and step is not None:
        resolution_m = length_in_metres(feature.resolution, matrix_to_world(model))
        figures |= direction_figures(step, model) | point_errors(figures, resolution_m)
    return Measurement(
        points,
        None,
        None,
        None,
        None,
        problem,
        dimension=figures or None,
        metric=is_metric(model),
        kind="dimension",
    )


def _thickness(
    context: MeasurementContext, feature: Dimension, step: FloatArray
) -> tuple[dict[str, float], Finding | None]:
    """Return the figures of a thickness, or an empty mapping and the reason.

    They are the distance across the plane and its 95 % errors (for this figure alone). A tilt of
    the plane changes the thickness between points that are apart along the bed, and each of the two
    points is on a surface as rough as the plane.
    """
    plane = context.plane(feature.plane_id)
    if plane is None:
        if not feature.plane_id:
            return {}, Finding("thickness.no-plane")
        return {}, Finding("thickness.plane-lost")
    normal_offset = float(step @ plane.normal)
    figures = {"thickness_m": abs(normal_offset)}
    tilt = deviation95(plane, step - normal_offset * plane.normal, is_joint=False)
    if tilt is not None:
        roughness = t95(plane.degrees_of_freedom) * float(np.sqrt(2.0)) * plane.roughness
        figures["thickness_error95_m"] = float(np.hypot(tilt, roughness))
    plane_model = get_model(context.records, get_feature(context.records, feature.plane_id))
    registration_error = thickness_error(
        step, plane.normal, context.model(feature.model_id), plane_model
    )
    if registration_error is not None:
        figures["thickness_registration95_m"] = registration_error
    if tilt is not None:
        figures["thickness_total95_m"] = float(
            np.hypot(figures["thickness_error95_m"], registration_error or 0.0)
        )
    return figures, None


def sketch(subject: Subject, measurements: Lookup) -> Sketch | None:
    """Return the drawing of a dimension, or None if it has no points."""
    points = subject.measured.points
    if not len(points):
        return None
    line = points
    if subject.feature.kind == "area" and len(points) > 2:
        line = np.vstack([points, points[:1]])
    return Sketch(line, midpoint(line) if len(line) > 1 else centre(subject.measured))


MEASURED_QUANTITY = replace(
    of.KIND,
    title=_("Kind"),
    explanation=_("Measured quantity"),
    value=lambda subject: subject.feature.kind,
    words=(),
    format_text=None,
)
"""Used only in files; elsewhere, `kind` is the feature type."""
FIGURES = (
    AREA,
    AREA_REGISTRATION,
    length_figure(
        "distance_m", _("Distance"), _("Straight distance from the first point to the last")
    ),
    length_figure(
        "distance_registration95_m",
        _("Reg. ± dist."),
        _("95 % error of the distance due to the registered scale"),
        short="reg_distan",
    ),
    length_figure(
        "distance_error95_m",
        _("± distance"),
        _("95 % error of the distance due to resolution and registration"),
        short="dist_error",
    ),
    replace(of.TREND, value=figure_value("trend_deg")),
    replace(of.PLUNGE, value=figure_value("plunge_deg")),
    length_figure("horizontal_m", _("Horizontal"), _("Horizontal component of the distance")),
    length_figure(
        "horizontal_registration95_m",
        _("Reg. ± horiz."),
        _("95 % error of the horizontal component due to registered scale and rotation"),
        short="reg_horizo",
    ),
    LENGTH,
    LENGTH_REGISTRATION,
    PERIMETER,
    PERIMETER_REGISTRATION,
    length_figure("thickness_error95_m", _("± thickness"), _("95 % error of the thickness")),
    length_figure("thickness_m", _("Thickness"), _("Distance perpendicular to the plane")),
    length_figure(
        "thickness_registration95_m",
        _("Reg. ± thick."),
        _(
            "95 % error of the thickness due to registered scale, and rotation if the plane is"
            " fixed"
        ),
        short="reg_thick",
    ),
    length_figure(
        "thickness_total95_m",
        _("Total ± thick."),
        _("Total 95 % error of the thickness (plane, roughness, registration)"),
        short="tot_thick",
    ),
    length_figure(
        "vertical_m", _("Vertical"), _("Vertical component of the distance, positive upward")
    ),
    length_figure(
        "vertical_registration95_m",
        _("Reg. ± vert."),
        _("95 % error of the vertical component due to registered scale and rotation"),
        short="reg_vertic",
    ),
)

NOTES = replace(of.NOTES, value=notes_with_beds)

KIND = Kind(
    name="dimension",
    order=40,
    record=Dimension,
    title=_("Measurement"),
    icon="ruler",
    measure=measure,
    figures=(of.ID, of.NAME, *FIGURES, of.NOTES),
    attributes=(
        kind.NAME,
        Attribute(
            "plane_id",
            _("Across"),
            "plane",
            applies=lambda dimension: dimension.kind == "thickness",
        ),
        kind.NOTES,
    ),
    sketch=sketch,
    class_name=lambda dimension: str(dimension.kind),
    words=words,
    headline=headline,
    dependency_ids=plane_ids,
    dependencies=plane_dependencies,
    tool="measure",
    layer=GisLayer(
        "dimensions",
        "line",
        get_line,
        (of.ID, of.NAME, MEASURED_QUANTITY, *FIGURES, NOTES),
        sparse=True,
    ),
    group=GROUP,
    color="#ffffff",
    prefix=lambda dimension: str(dimension.kind),
)
