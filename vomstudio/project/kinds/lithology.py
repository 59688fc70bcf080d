"""Part of the outcrop with a single lithology: a closed outline on its surface."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate as _
from vomstudio.core.words import tr
from vomstudio.geology.beds.lithologies import LITHOLOGIES, lithology_color
from vomstudio.geometry import transform
from vomstudio.geometry.lines import path_length, ring_area
from vomstudio.geometry.matrices import Point
from vomstudio.geometry.units import area_text
from vomstudio.project import catalogue as of
from vomstudio.project import kind
from vomstudio.project.dimension_errors import registration_errors
from vomstudio.project.figures import Figure, Subject, text_figure
from vomstudio.project.kind import Attribute, GisLayer, Kind, KindGroup, Lookup, Sketch
from vomstudio.project.length_figures import (
    AREA,
    AREA_REGISTRATION,
    PERIMETER,
    PERIMETER_REGISTRATION,
)
from vomstudio.project.length_figures import headline as area
from vomstudio.project.length_figures import words as words_of_dimension
from vomstudio.project.measurement import (
    Measurement,
    MeasurementContext,
    is_metric,
    matrix_to_world,
    world_lines,
)
from vomstudio.project.records import Model, PickedFeature, RepeatableFeature

GROUP = KindGroup("lithologies", _("Lithologies"), "layers")
CHOICES = (("", _("unknown")), *((word, word) for word in LITHOLOGIES))


@dataclass(frozen=True)
class Lithology(PickedFeature, RepeatableFeature):
    """Outlined area of one lithology.

    Attributes
    ----------
    vertices : tuple of Point
        Outline in order, in the file frame of the model; the first point is not repeated.
    lithology : str
        Term from the forms of StraboSpot or another term from a file; "" if unknown.
    area : float or None
        Area of the model surface inside the outline, in file units squared; None if unknown, as on
        a point cloud.
    """

    id: str
    name: str
    model_id: str
    model_hash: str
    vertices: tuple[Point, ...]
    lithology: str = ""
    area: float | None = None
    notes: str = ""
    repeat_of: str | None = None
    interpreter: str | None = None


def measure(context: MeasurementContext, lithologies: Sequence[Lithology]) -> list[Measurement]:
    """Measure the areas of lithologies."""
    models = [context.model(inputs.model_id) for inputs in lithologies]
    lines = world_lines(lithologies, models)
    return [_measure(*inputs) for inputs in zip(lithologies, models, lines, strict=True)]


def _measure(feature: Lithology, model: Model | None, points: FloatArray) -> Measurement:
    figures: dict[str, float] = {}
    problem = None
    if len(points) < 3:
        problem = Finding("feature.too-few-points", count=3 - len(points), minimum=3)
    else:
        if feature.area is not None:
            figures["area_m2"] = feature.area * transform.scale_factor(matrix_to_world(model)) ** 2
        figures["perimeter_m"] = path_length(np.vstack([points, points[:1]]))
        figures["outline_m2"] = ring_area(points)
        figures |= registration_errors(figures, model, None)
    return Measurement(
        points,
        None,
        None,
        None,
        None,
        problem,
        dimension=figures or None,
        text=feature.lithology,
        metric=is_metric(model),
        kind="lithology",
    )


def ring(subject: Subject) -> FloatArray | None:
    """Return the outline (n, 3) in the World frame, or None for fewer than three points."""
    points = subject.measured.points
    return points if len(points) > 2 else None


def sketch(subject: Subject, measurements: Lookup) -> Sketch | None:
    """Return the outline, labelled with the lithology at the vertex nearest to the centre.

    Returns None if it has no points.
    """
    points = subject.measured.points
    if not len(points):
        return None
    line = np.vstack([points, points[:1]]) if len(points) > 2 else points
    distances = np.linalg.norm(points - points.mean(axis=0), axis=1)
    return Sketch(line, points[int(np.argmin(distances))], label=subject.feature.lithology or "–")


def words(measured: Measurement) -> list[str]:
    """Return the area on the surface, followed by the figures of the outline."""
    figures = measured.dimension or {}
    surface_text, *other_lines = words_of_dimension(measured) or [""]
    lines = (
        [tr("Surface {area}", area=surface_text), *other_lines]
        if "area_m2" in figures
        else [surface_text, *other_lines]
    )
    if not figures:
        return []
    if "outline_m2" in figures:
        flat_area_text = area_text(figures["outline_m2"], is_metric=measured.metric)
        lines.append(tr("Projected area {area}", area=flat_area_text))
    if figures and "area_m2" not in figures:
        lines.append(tr("The surface area is unknown, because it needs a mesh."))
    return lines


def headline(measurement: Measurement) -> str | None:
    """Return the lithology and the area, or None if both are unknown."""
    return ", ".join(filter(None, (measurement.text, area(measurement)))) or None


def about(subject: Subject) -> list[str]:
    """Describe the lithology."""
    word = subject.feature.lithology
    return [tr("Lithology: {lithology}", lithology=word)] if word else []


LITHOLOGY = text_figure(
    "lithology",
    _("Lithology"),
    _("Rock type of the StraboSpot list"),
    lambda subject: subject.feature.lithology or None,
    words=("lithology", "rock"),
)
SURFACE_AREA = replace(AREA, explanation=_("Area of the surface inside the outline"))
OUTLINE_AREA = Figure(
    "outline_m2",
    _("Outline"),
    _("Largest projected area of a lithology outline"),
    lambda subject: (subject.measured.dimension or {}).get("outline_m2"),
    "area",
    "m2",
)
FIGURES = (SURFACE_AREA, AREA_REGISTRATION, OUTLINE_AREA, PERIMETER, PERIMETER_REGISTRATION)

KIND = Kind(
    name="lithology",
    order=35,
    record=Lithology,
    title=_("Lithology"),
    icon="layers",
    measure=measure,
    figures=(of.ID, of.NAME, LITHOLOGY, *of.PLACE, *FIGURES, *of.MODEL_FIGURES, of.NOTES),
    attributes=(
        kind.NAME,
        Attribute("lithology", _("Lithology"), "word", CHOICES),
        kind.NOTES,
    ),
    sketch=sketch,
    words=words,
    headline=headline,
    about=about,
    tool="lithology",
    layer=GisLayer(
        "lithologies",
        "ring",
        ring,
        (of.ID, of.NAME, LITHOLOGY, SURFACE_AREA, OUTLINE_AREA, of.MODEL, of.NOTES),
        by="lithology",
    ),
    group=GROUP,
    color="#c2a36b",
    tint=lambda lithology: lithology_color(lithology.lithology),
    prefix=lambda lithology: "lithology",
    listed=True,
    filled=True,
    drawing_label=lambda lithology: lithology.lithology or lithology.name,
)
