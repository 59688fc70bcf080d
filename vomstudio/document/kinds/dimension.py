"""A length, an area, or a distance at right angles to the plane of another feature."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from vomstudio.document import catalogue as of
from vomstudio.document import kind
from vomstudio.document.figures import Figure, Subject
from vomstudio.document.kind import (
    Attribute,
    GisLayer,
    Kind,
    Lookup,
    OwnGroup,
    Sketch,
    centre,
    half_way,
    line_of,
    plane_below,
    plane_named,
)
from vomstudio.document.measurement import (
    Floats,
    Measurement,
    Measuring,
    is_metric,
    world_points,
)
from vomstudio.document.records import Picked, Point
from vomstudio.geology.intersections import stray95, t95
from vomstudio.geometry.lines import path_length, ring_area
from vomstudio.geometry.units import area_text, length_text
from vomstudio.words import to_translate as _
from vomstudio.words import tr

DimensionKind = Literal["distance", "polyline", "area", "thickness"]

KINDS: tuple[tuple[DimensionKind, str], ...] = (
    ("distance", _("Distance")),
    ("polyline", _("Polyline")),
    ("area", _("Area")),
    ("thickness", _("Thickness")),
)
GROUP = OwnGroup("dimensions", _("Measurements"), "ruler")


@dataclass(frozen=True)
class Dimension(Picked):
    """plane_id: of a thickness, the feature across whose plane it is measured."""

    id: str
    name: str
    kind: DimensionKind
    model_id: str
    model_hash: str
    vertices: tuple[Point, ...]
    plane_id: str = ""
    notes: str = ""


def measure(at: Measuring, dimensions: Sequence[Dimension]) -> list[Measurement]:
    return [_measure(at, dimension) for dimension in dimensions]


def _measure(at: Measuring, feature: Dimension) -> Measurement:
    model = at.model(feature.model_id)
    points = world_points(feature, model)
    problem = None
    figures: dict[str, float] = {}
    if feature.kind == "area":
        if len(points) < 3:
            problem = tr("An area needs at least 3 points.")
        else:
            figures = {
                "area_m2": ring_area(points),
                "perimeter_m": path_length(np.vstack([points, points[:1]])),
            }
    elif len(points) < 2:
        problem = tr("A length needs 2 points.")
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
            thickness, problem = _thickness(at, feature, step)
            figures |= thickness
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
    at: Measuring, feature: Dimension, step: Floats
) -> tuple[dict[str, float], str | None]:
    """Distance across the plane, and its 95 % error (of this one figure, not joint): points that
    lie apart along the bed turn a tilt of the plane into thickness, and each of the two lies on a
    surface as uneven as the plane's own points are."""
    plane = at.plane(feature.plane_id)
    if plane is None:
        if not feature.plane_id:
            return {}, tr("A thickness is measured across a plane. Choose one.")
        return {}, tr("The plane it is measured across was deleted or has no fit.")
    across = float(step @ plane.normal)
    figures = {"thickness_m": abs(across)}
    tilt = stray95(plane, step - across * plane.normal, joint=False)
    if tilt is not None:
        uneven = t95(plane.free) * float(np.sqrt(2.0)) * plane.roughness
        figures["thickness_error95_m"] = float(np.hypot(tilt, uneven))
    return figures, None


def sketch(subject: Subject, measured: Lookup) -> Sketch | None:
    points = subject.measured.points
    if not len(points):
        return None
    line = points
    if subject.feature.kind == "area" and len(points) > 2:
        line = np.vstack([points, points[:1]])
    return Sketch(line, half_way(line) if len(line) > 1 else centre(subject.measured))


# --- in words --------------------------------------------------------------------------------
# The figure that a dimension is made for, first in this order where it has it.
_MAIN: tuple[str, ...] = ("thickness_m", "area_m2", "length_m", "distance_m")


def headline(measured: Measurement) -> str | None:
    """The main figure of a dimension, with its error where that is known."""
    figures, metric = measured.dimension, measured.metric
    if not figures:
        return None
    for name in _MAIN:
        if name in figures:
            if name == "area_m2":
                return area_text(figures[name], metric=metric)
            error = figures.get(name.replace("_m", "_error95_m"))
            text = length_text(figures[name], metric=metric)
            return text if error is None else f"{text} ± {length_text(error, 2, metric=metric)}"
    return "–"


def words(measured: Measurement) -> list[str]:
    """The figures of a dimension, the one it is made for first."""
    figures = measured.dimension or {}

    def length(value: float, digits: int = 3) -> str:
        return length_text(value, digits, metric=measured.metric)

    lines = []
    if (value := figures.get("thickness_m")) is not None:
        error = figures.get("thickness_error95_m")
        lines.append(
            tr("Thickness {length}, 95 % error unknown", length=length(value))
            if error is None
            else tr(
                "Thickness {length}, 95 % error ± {error}",
                length=length(value),
                error=length(error, 2),
            )
        )
    if (value := figures.get("area_m2")) is not None:
        lines.append(area_text(value, metric=measured.metric))
    for name, said in (
        ("length_m", _("Length along the line {length}")),
        ("distance_m", _("Distance {length}")),
        ("perimeter_m", _("Perimeter {length}")),
    ):
        if name in figures:
            lines.append(tr(said, length=length(figures[name])))
    if "horizontal_m" in figures:
        up = figures["vertical_m"]
        lines.append(
            tr(
                "Horizontal {horizontal}, upward {vertical}"
                if up >= 0.0
                else "Horizontal {horizontal}, downward {vertical}",
                horizontal=length(figures["horizontal_m"]),
                vertical=length(abs(up)),
            )
        )
    return lines


def _figure(name: str) -> Callable[[Subject], Any]:
    return lambda s: (s.measured.dimension or {}).get(name)


def _length(name: str, title: str, explanation: str) -> Figure:
    return Figure(name, title, explanation, _figure(name), "length", "m")


WHAT = replace(
    of.KIND, title=_("Kind"), explanation=_("What is measured"), value=lambda s: s.feature.kind,
    words=(),
    shown=None,
)  # fmt: skip
"""Of files alone: elsewhere `kind` is the feature type."""
AREA = replace(of.AREA, explanation=_("Area inside the points"), value=_figure("area_m2"))
FIGURES = (
    AREA,
    _length("distance_m", _("Distance"), _("Straight distance from the first point to the last")),
    _length("horizontal_m", _("Horizontal"), _("Horizontal component of the distance")),
    _length("length_m", _("Length"), _("Length of the line through all points")),
    _length("perimeter_m", _("Perimeter"), _("Perimeter of the area")),
    _length("thickness_error95_m", _("± thickness"), _("95 % error of the thickness")),
    _length("thickness_m", _("Thickness"), _("Distance at right angles to the plane")),
    _length("vertical_m", _("Vertical"), _("Vertical component of the distance, positive upward")),
)

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
        Attribute("plane_id", _("Across"), "plane", applies=lambda d: d.kind == "thickness"),
        kind.NOTES,
    ),
    sketch=sketch,
    class_name=lambda dimension: str(dimension.kind),
    words=words,
    headline=headline,
    names=plane_named,
    below=plane_below,
    tool="measure",
    layer=GisLayer(
        "dimensions", "line", line_of, (of.ID, of.NAME, WHAT, *FIGURES, of.NOTES), sparse=True
    ),
    group=GROUP,
    color="#ffffff",
    prefix=lambda dimension: str(dimension.kind),
)  # fmt: skip
