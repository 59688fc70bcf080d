"""Line or plane of known attitude or length that is used to register a model.

It is either a line that is level or vertical or has a known azimuth or length, or a plane or line
in the project that was measured with a compass.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.words import to_translate as _
from vomstudio.core.words import tr
from vomstudio.geology.notation import format_azimuth, format_line, format_plane
from vomstudio.geology.orientation import Line, Plane
from vomstudio.geometry.matrices import Point
from vomstudio.project import catalogue as of
from vomstudio.project import kind
from vomstudio.project.figures import Subject
from vomstudio.project.kind import GisLayer, Kind, KindGroup, Lookup, Sketch, get_line, midpoint
from vomstudio.project.measurement import (
    Measurement,
    MeasurementContext,
    Records,
    empty_measurement,
    is_metric,
    world_points,
)
from vomstudio.project.records import Feature, PickedFeature, get_feature

ClickedKind = Literal["level", "plumb", "azimuth", "length"]
ReadKind = Literal["plane", "lineation"]
KnownKind = Literal["level", "plumb", "azimuth", "length", "plane", "lineation"]
CLICKED_KINDS: tuple[tuple[ClickedKind, str], ...] = (
    ("level", _("Level line")),
    ("plumb", _("Plumb line")),
    ("azimuth", _("Line of known azimuth")),
    ("length", _("Known length")),
)
"""Kinds defined by clicking the two ends."""
READ_KINDS: tuple[tuple[ReadKind, str], ...] = (
    ("plane", _("Plane by compass")),
    ("lineation", _("Line by compass")),
)
"""Features of the project that were measured with a compass."""
KINDS: tuple[tuple[KnownKind, str], ...] = (*CLICKED_KINDS, *READ_KINDS)
GROUP = KindGroup("known_lines", _("Known lines and planes"), "spirit-level")


@dataclass(frozen=True)
class KnownLine(PickedFeature):
    """Known line or plane.

    Attributes
    ----------
    vertices : tuple of Point
        Two ends on the model in the file frame; empty for a compass reading.
    value : float or None
        Azimuth from the first to the second end (degrees), length (metres), or dip direction or
        trend of a compass reading. None for a level or plumb line, and as long as the value is
        unknown.
    sigma : float or None
        Standard deviation of the level, plumb line, azimuth or reading (degrees) or of the length
        (metres). If None, the default is used.
    check : bool
        Whether the line is compared with the registration but not used for it.
    inclination_deg : float or None
        Dip of a plane or plunge of a line that was measured with a compass.
    feature_id : str
        ID of the feature on the model that represents this plane or line; "" if the ends were
        clicked.

    Notes
    -----
    Azimuths are stored as read; the model's `Compass` states their north reference.
    """

    id: str
    name: str
    kind: KnownKind
    model_id: str
    model_hash: str
    vertices: tuple[Point, ...]
    value: float | None = None
    sigma: float | None = None
    check: bool = False
    notes: str = ""
    inclination_deg: float | None = None
    feature_id: str = ""

    @property
    def is_read(self) -> bool:
        """Whether this is a plane or line of the project that was measured with a compass."""
        return self.kind in ("plane", "lineation")

    @property
    def has_value(self) -> bool:
        """Whether a value applies; a level or plumb line is defined by its kind alone."""
        return self.kind not in ("level", "plumb")

    @property
    def is_complete(self) -> bool:
        """Whether all defining values are known."""
        if self.is_read:
            return self.value is not None and self.inclination_deg is not None
        return len(self.vertices) > 1 and not (self.has_value and self.value is None)


def measure(context: MeasurementContext, lines: Sequence[KnownLine]) -> list[Measurement]:
    """Return the positions in the World frame; no other quantities are measured."""
    measurements = []
    for line in lines:
        model = context.model(line.model_id)
        points = world_points(line, model)
        if line.is_read:
            points = _feature_centre(context.known.get(line.feature_id))
        measurement = empty_measurement(
            points, None, None, kind="known_line", metric=is_metric(model)
        )
        measurements.append(replace(measurement, text=known_text(line)))
    return measurements


def _feature_centre(measurement: Measurement | None) -> FloatArray:
    """Return the centre (1, 3) of the measured feature, or (0, 3) if it was deleted."""
    if measurement is None or not len(measurement.points):
        return np.zeros((0, 3))
    return np.asarray(kind.centre(measurement), np.float64)[None]


def dependencies(records: Records, line: KnownLine) -> list[Feature]:
    """Return the feature that was measured with a compass."""
    feature = get_feature(records, line.feature_id)
    return [] if feature is None else [feature]


def sketch(subject: Subject, measurements: Lookup) -> Sketch | None:
    """Return the drawing of a known line, or None if its position is unknown."""
    points = subject.measured.points
    if not len(points):
        return None
    line: KnownLine = subject.feature
    centre = midpoint(points) if len(points) > 1 else points[0]
    return Sketch(np.asarray(points), centre, label=known_text(line) if line.is_read else "–")


def known_text(line: KnownLine) -> str:
    """Return the known properties of the line in a few words."""
    if line.kind == "level":
        return tr("level")
    if line.kind == "plumb":
        return tr("vertical")
    if line.value is None:
        return tr("not entered yet")
    if line.is_read:
        return tr("compass reading {orientation}", orientation=_arrow_text(line))
    if line.kind == "azimuth":
        return tr("azimuth {degrees:.1f}°", degrees=line.value)
    return tr("{metres:.3f} m long", metres=line.value)


def _arrow_text(line: KnownLine) -> str:
    """Return dip and dip direction, or plunge and trend, in an unambiguous notation."""
    azimuth, inclination = line.value or 0.0, line.inclination_deg or 0.0
    digits = max(_digits(azimuth), _digits(inclination))
    return f"{inclination:.{digits}f} → {format_azimuth(azimuth, digits)}"


def format_reading(line: KnownLine, notation: str = "dipdir/dip") -> str:
    """Return the reading in a notation for planes, or as trend and plunge for a line.

    The text has as many digits as were read, and is empty as long as the value is unknown.
    """
    if line.value is None or line.inclination_deg is None:
        return ""
    digits = max(_digits(line.value), _digits(line.inclination_deg))
    if line.kind == "plane":
        return format_plane(
            Plane(line.value, line.inclination_deg), notation, digits, omit_hand_rule=True
        )
    return format_line(Line(line.value, line.inclination_deg), digits)


def _digits(angle_deg: float) -> int:
    """Return the number of decimals that an angle needs (at most two)."""
    return next((n for n in (0, 1) if abs(angle_deg - round(angle_deg, n)) < 1e-6), 2)


def about(subject: Subject) -> list[str]:
    """Return the known properties of the line."""
    line = subject.feature
    assert isinstance(line, KnownLine)
    lines = [tr("Known value: {what}", what=known_text(line))]
    if line.is_read:
        feature = get_feature(subject.records, line.feature_id)
        lines.append(
            tr("The measured plane or line is no longer in the project.")
            if feature is None
            else tr("On the model: {feature}.", feature=feature.name)
        )
    if line.check:
        lines.append(tr("It is only used to check the registration."))
    return lines


FIGURES = (of.ID, of.NAME, *of.PLACE, of.NOTES)
WHAT = replace(
    of.KIND,
    title=_("Kind"),
    explanation=_("Known quantity"),
    value=lambda subject: subject.feature.kind,
    words=(),
    format_text=None,
)
"""Used only in files; elsewhere, `kind` is the feature type."""

KIND = Kind(
    name="known_line",
    order=75,
    record=KnownLine,
    title=_("Known line"),
    icon="spirit-level",
    measure=measure,
    figures=FIGURES,
    attributes=(kind.NAME, kind.NOTES),
    sketch=sketch,
    about=about,
    headline=lambda measured: measured.text,
    dependency_ids=lambda line: (line.feature_id,) if line.feature_id else (),
    dependencies=dependencies,
    tool="known_line",
    layer=GisLayer("known_lines", "line", get_line, (of.ID, of.NAME, WHAT, of.NOTES), sparse=True),
    group=GROUP,
    color="#cc79a7",
    prefix=lambda line: "known",
)
