"""Point of known coordinates that is marked on a model in order to register it."""

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
from vomstudio.project.kind import GisLayer, Kind, KindGroup, Lookup, Sketch
from vomstudio.project.measurement import (
    Measurement,
    MeasurementContext,
    empty_measurement,
    is_metric,
    world_points,
)
from vomstudio.project.records import PickedFeature

GROUP = KindGroup("control_points", _("Control points"), "crosshairs-gps")


@dataclass(frozen=True)
class ControlPoint(PickedFeature):
    """Control point.

    Attributes
    ----------
    vertices : tuple of Point
        Position on the model: one point in the file frame, or empty before it is marked.
    position : Point or None
        Known coordinates in metres, or None as long as they are unknown.
    sigma_m : Point or None
        Standard deviations of the coordinates, or None if not stated.
    check : bool
        Whether this is a check point, which is compared with the registration but not used for it.
    """

    id: str
    name: str
    model_id: str
    model_hash: str
    vertices: tuple[Point, ...] = ()
    position: Point | None = None
    sigma_m: Point | None = None
    check: bool = False
    notes: str = ""


def measure(context: MeasurementContext, points: Sequence[ControlPoint]) -> list[Measurement]:
    """Return the positions in the World frame; no other quantities are measured."""
    measurements = []
    for point in points:
        model = context.model(point.model_id)
        points_in_world = world_points(point, model)
        measurements.append(
            empty_measurement(
                points_in_world, None, None, kind="control_point", metric=is_metric(model)
            )
        )
    return measurements


def position_in_world(subject: Subject) -> FloatArray | None:
    """Return the position (1, 3) of a control point in the World frame; None if not marked."""
    points = subject.measured.points
    return points if len(points) else None


def sketch(subject: Subject, measurements: Lookup) -> Sketch | None:
    """Return the drawing of a control point, or None if it has not been marked."""
    points = subject.measured.points
    return Sketch(points, points[0], label="–") if len(points) else None


def about(subject: Subject) -> list[str]:
    """Return the known properties of the point."""
    point = subject.feature
    assert isinstance(point, ControlPoint)
    lines = []
    if point.position is None:
        lines.append(tr("Its coordinates are still unknown."))
    else:
        x, y, z = point.position
        lines.append(tr("Coordinates: {x:.3f}, {y:.3f}, {z:.3f} m", x=x, y=y, z=z))
    if not point.vertices:
        lines.append(tr("It has not been picked on the model yet."))
    if point.check:
        lines.append(tr("It is only used to check the registration."))
    return lines


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
    layer=GisLayer("control_points", "point", position_in_world, FIGURES, sparse=True),
    group=GROUP,
    color="#f0e442",
    prefix=lambda point: "control",
)
