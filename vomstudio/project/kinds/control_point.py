"""A point of known coordinates that is found on a model, to place it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from vomstudio.core.arrays import FloatArray
from vomstudio.core.words import to_translate as _
from vomstudio.core.words import tr
from vomstudio.geometry.matrices import Point
from vomstudio.project import catalogue as of
from vomstudio.project import kind
from vomstudio.project.figures import Subject
from vomstudio.project.kind import GisLayer, Kind, Lookup, OwnGroup, Sketch
from vomstudio.project.measurement import (
    Measurement,
    Measuring,
    is_metric,
    nothing_measured,
    world_points,
)
from vomstudio.project.records import Picked

GROUP = OwnGroup("control_points", _("Control points"), "crosshairs-gps")


@dataclass(frozen=True)
class ControlPoint(Picked):
    """vertices: its place on the model, one point in the file frame; none before it is found.
    position: its coordinates, metres; None before they are known. sigma_m: of these, None where not
    stated. check: it judges the registration and takes no part in it."""

    id: str
    name: str
    model_id: str
    model_hash: str
    vertices: tuple[Point, ...] = ()
    position: Point | None = None
    sigma_m: Point | None = None
    check: bool = False
    notes: str = ""


def measure(at: Measuring, points: Sequence[ControlPoint]) -> list[Measurement]:
    """Where they are, in World; there is nothing else to be measured."""
    found = []
    for point in points:
        model = at.model(point.model_id)
        place = world_points(point, model)
        found.append(
            nothing_measured(place, None, None, kind="control_point", metric=is_metric(model))
        )
    return found


def place(subject: Subject) -> FloatArray | None:
    points = subject.measured.points
    return points if len(points) else None


def sketch(subject: Subject, measured: Lookup) -> Sketch | None:
    points = subject.measured.points
    return Sketch(points, points[0], label="–") if len(points) else None


def about(subject: Subject) -> list[str]:
    """What is known of it."""
    point = subject.feature
    assert isinstance(point, ControlPoint)
    said = []
    if point.position is None:
        said.append(tr("Its coordinates are not known yet."))
    else:
        x, y, z = point.position
        said.append(tr("Coordinates: {x:.3f}, {y:.3f}, {z:.3f} m", x=x, y=y, z=z))
    if not point.vertices:
        said.append(tr("It has not been found on the model yet."))
    if point.check:
        said.append(tr("It judges the registration and takes no part in it."))
    return said


FIGURES = (of.ID, of.NAME, *of.PLACE, of.NOTES)

KIND = Kind(
    name="control_point",
    order=70,
    record=ControlPoint,
    title=_("Control point"),
    icon="crosshairs-gps",
    measure=measure,
    figures=FIGURES,
    attributes=(kind.NAME, kind.NOTES),
    sketch=sketch,
    about=about,
    headline=lambda measured: tr("Control point"),
    tool="control",
    layer=GisLayer("control_points", "point", place, FIGURES, sparse=True),
    group=GROUP,
    color="#f0e442",
    prefix=lambda point: "control",
)
