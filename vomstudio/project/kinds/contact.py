"""Contact or fault line that is drawn but not fitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate as _
from vomstudio.geometry.lines import path_length
from vomstudio.geometry.matrices import Point
from vomstudio.project import catalogue as of
from vomstudio.project import kind
from vomstudio.project.bed_descriptions import notes_with_beds
from vomstudio.project.dimension_errors import registration_errors
from vomstudio.project.figures import Subject
from vomstudio.project.kind import GisLayer, Kind, Lookup, Sketch, centre, get_line, midpoint
from vomstudio.project.length_figures import LENGTH, LENGTH_REGISTRATION, headline, words
from vomstudio.project.measurement import (
    Measurement,
    MeasurementContext,
    is_metric,
    world_lines,
)
from vomstudio.project.records import LoggedFeature, RepeatableFeature, TypedFeature


@dataclass(frozen=True)
class Contact(LoggedFeature, RepeatableFeature, TypedFeature):
    """Line without a plane. `vertices` are in order, in the file frame of the model."""

    id: str
    name: str
    type_id: str
    model_id: str
    model_hash: str
    vertices: tuple[Point, ...]
    set_name: str = ""
    notes: str = ""
    repeat_of: str | None = None
    interpreter: str | None = None
    beds: tuple[tuple[str, str, str], ...] = ()
    domain: str = ""


def measure(context: MeasurementContext, contacts: Sequence[Contact]) -> list[Measurement]:
    """Measure the lengths of contact lines."""
    models = [context.model(contact.model_id) for contact in contacts]
    measurements = []
    for points, model in zip(world_lines(contacts, models), models, strict=True):
        problem = (
            None
            if len(points) > 1
            else Finding("feature.too-few-points", count=2 - len(points), minimum=2)
        )
        figures = {} if problem else {"length_m": path_length(points)}
        figures |= registration_errors(figures, model, None)
        measurements.append(
            Measurement(
                points,
                None,
                None,
                None,
                None,
                problem,
                dimension=figures or None,
                metric=is_metric(model),
                kind="contact",
            )
        )
    return measurements


def sketch(subject: Subject, measurements: Lookup) -> Sketch | None:
    """Return the drawing of a contact, or None if it has no points."""
    points = subject.measured.points
    if not len(points):
        return None
    return Sketch(points, midpoint(points) if len(points) > 1 else centre(subject.measured))


NOTES = replace(of.NOTES, value=notes_with_beds)

KIND = Kind(
    name="contact",
    order=15,
    record=Contact,
    title=_("Contact line"),
    icon="vector-line",
    measure=measure,
    figures=(*of.NAME_FIGURES, *of.PLACE, LENGTH, LENGTH_REGISTRATION, *of.MODEL_FIGURES, of.NOTES),
    attributes=(kind.NAME, kind.TYPE, kind.SET, kind.DOMAIN, kind.NOTES),
    sketch=sketch,
    words=words,
    headline=headline,
    tool="contact",
    layer=GisLayer("contacts", "line", get_line, (*of.NAME_FIGURES, LENGTH, NOTES)),
    listed=True,
)
