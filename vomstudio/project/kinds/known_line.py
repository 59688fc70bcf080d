"""A line or plane on a model of which something is known, to place it: a line that is level or
vertical, or whose azimuth or length is known; a plane or line of the project that was read by
compass."""

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
from vomstudio.project.kind import GisLayer, Kind, Lookup, OwnGroup, Sketch, half_way, line_of
from vomstudio.project.measurement import (
    Measurement,
    Measuring,
    Records,
    is_metric,
    nothing_measured,
    world_points,
)
from vomstudio.project.records import Feature, Picked, get_feature

ClickedKind = Literal["level", "plumb", "azimuth", "length"]
ReadKind = Literal["plane", "lineation"]
KnownKind = Literal["level", "plumb", "azimuth", "length", "plane", "lineation"]
CLICKED: tuple[tuple[ClickedKind, str], ...] = (
    ("level", _("Level line")),
    ("plumb", _("Plumb line")),
    ("azimuth", _("Line of known azimuth")),
    ("length", _("Known length")),
)
"""Whose two ends are clicked."""
READ: tuple[tuple[ReadKind, str], ...] = (
    ("plane", _("Plane by compass")),
    ("lineation", _("Line by compass")),
)
"""Features of the project that were read by compass."""
KINDS: tuple[tuple[KnownKind, str], ...] = (*CLICKED, *READ)
GROUP = OwnGroup("known_lines", _("Known lines and planes"), "spirit-level")


@dataclass(frozen=True)
class KnownLine(Picked):
    """vertices: its two ends on the model, file frame; none of what was read by compass. value: the
    azimuth from the first end to the second (degrees) or the length (metres); the dip direction of
    a plane or trend of a line that was read; None of a level or plumb line, and before it is known.
    sigma: of the level, the plumb, the azimuth or the reading (degrees) or the length (metres), one
    sigma, None for what is usual. check: it judges the registration and takes no part in it.
    inclination_deg: dip of a plane or plunge of a line that was read; feature_id: the feature that
    is this plane or line on the model, "" where the ends were clicked.

    Azimuths are as they were read: the model's `Compass` says from which north.
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
    def by_compass(self) -> bool:
        """A plane or line of the project that was read."""
        return self.kind in ("plane", "lineation")

    @property
    def has_value(self) -> bool:
        """Whether a number belongs to it: a level or plumb line is known by its kind alone."""
        return self.kind not in ("level", "plumb")

    @property
    def complete(self) -> bool:
        """Something is known of it."""
        if self.by_compass:
            return self.value is not None and self.inclination_deg is not None
        return len(self.vertices) > 1 and not (self.has_value and self.value is None)


def measure(at: Measuring, lines: Sequence[KnownLine]) -> list[Measurement]:
    """Where they are, in World; there is nothing else to be measured."""
    found = []
    for line in lines:
        model = at.model(line.model_id)
        points = world_points(line, model)
        if line.by_compass:
            points = _middle(at.known.get(line.feature_id))
        measured = nothing_measured(points, None, None, kind="known_line", metric=is_metric(model))
        found.append(replace(measured, said=known(line)))
    return found


def _middle(measured: Measurement | None) -> FloatArray:
    """(1, 3) of the feature that was read, (0, 3) where it is gone."""
    if measured is None or not len(measured.points):
        return np.zeros((0, 3))
    return np.asarray(kind.centre(measured), np.float64)[None]


def below(records: Records, line: KnownLine) -> list[Feature]:
    """The feature that was read."""
    found = get_feature(records, line.feature_id)
    return [] if found is None else [found]


def sketch(subject: Subject, measured: Lookup) -> Sketch | None:
    points = subject.measured.points
    if not len(points):
        return None
    line: KnownLine = subject.feature
    middle = half_way(points) if len(points) > 1 else points[0]
    return Sketch(np.asarray(points), middle, label=known(line) if line.by_compass else "–")


def known(line: KnownLine) -> str:
    """What is known of it, in a few words."""
    if line.kind == "level":
        return tr("level")
    if line.kind == "plumb":
        return tr("vertical")
    if line.value is None:
        return tr("not known yet")
    if line.by_compass:
        return tr("read as {orientation}", orientation=_with_arrow(line))
    if line.kind == "azimuth":
        return tr("azimuth {degrees:.1f}°", degrees=line.value)
    return tr("{metres:.3f} m long", metres=line.value)


def _with_arrow(line: KnownLine) -> str:
    """Dip and dip direction, or plunge and trend: whatever the notation, nobody takes that for
    another one."""
    azimuth, inclination = line.value or 0.0, line.inclination_deg or 0.0
    digits = max(_digits(azimuth), _digits(inclination))
    return f"{inclination:.{digits}f} → {format_azimuth(azimuth, digits)}"


def as_read(line: KnownLine, notation: str = "dipdir/dip") -> str:
    """The reading of a plane in one of the notations for planes, of a line as trend and plunge,
    with as many digits as were read; "" before it is known."""
    if line.value is None or line.inclination_deg is None:
        return ""
    digits = max(_digits(line.value), _digits(line.inclination_deg))
    if line.kind == "plane":
        return format_plane(Plane(line.value, line.inclination_deg), notation, digits, bare=True)
    return format_line(Line(line.value, line.inclination_deg), digits)


def _digits(angle_deg: float) -> int:
    """Decimals that it needs, two at most."""
    return next((n for n in (0, 1) if abs(angle_deg - round(angle_deg, n)) < 1e-6), 2)


def about(subject: Subject) -> list[str]:
    """What is known of it."""
    line = subject.feature
    assert isinstance(line, KnownLine)
    said = [tr("Known of it: {what}", what=known(line))]
    if line.by_compass:
        of_it = get_feature(subject.records, line.feature_id)
        said.append(
            tr("The plane or line that was read is no longer in the project.")
            if of_it is None
            else tr("On the model it is {feature}.", feature=of_it.name)
        )
    if line.check:
        said.append(tr("It judges the registration and takes no part in it."))
    return said


FIGURES = (of.ID, of.NAME, *of.PLACE, of.NOTES)
WHAT = replace(
    of.KIND,
    title=_("Kind"),
    explanation=_("What is known"),
    value=lambda s: s.feature.kind,
    words=(),
    shown=None,
)
"""Of files alone: elsewhere `kind` is the feature type."""

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
    headline=lambda measured: measured.said,
    names=lambda line: (line.feature_id,) if line.feature_id else (),
    below=below,
    tool="known_line",
    layer=GisLayer("known_lines", "line", line_of, (of.ID, of.NAME, WHAT, of.NOTES), sparse=True),
    group=GROUP,
    color="#cc79a7",
    prefix=lambda line: "known",
)
