"""A line on a model that is known to be level, or whose azimuth or length is known, to place it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from vomstudio.document import catalogue as of
from vomstudio.document import kind
from vomstudio.document.figures import Subject
from vomstudio.document.kind import GisLayer, Kind, Lookup, OwnGroup, Sketch, half_way, line_of
from vomstudio.document.measurement import (
    Measurement,
    Measuring,
    is_metric,
    nothing_measured,
    world_points,
)
from vomstudio.document.records import Picked, Point
from vomstudio.words import to_translate as _
from vomstudio.words import tr

KnownKind = Literal["level", "azimuth", "length"]
KINDS: tuple[tuple[KnownKind, str], ...] = (
    ("level", _("Level line")),
    ("azimuth", _("Line of known azimuth")),
    ("length", _("Known length")),
)
GROUP = OwnGroup("known_lines", _("Known lines"), "spirit-level")


@dataclass(frozen=True)
class KnownLine(Picked):
    """vertices: its two ends on the model, file frame. value: the azimuth from the first end to the
    second (degrees from grid north) or the length (metres); None of a level line, and before it is
    known. sigma: of the level or the azimuth (degrees) or the length (metres), one sigma, None for
    what is usual. check: it judges the registration and takes no part in it.
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

    @property
    def complete(self) -> bool:
        """Something is known of it."""
        return len(self.vertices) > 1 and (self.kind == "level" or self.value is not None)


def measure(at: Measuring, lines: Sequence[KnownLine]) -> list[Measurement]:
    """Where they are, in World; there is nothing else to be measured."""
    found = []
    for line in lines:
        model = at.model(line.model_id)
        points = world_points(line, model)
        found.append(
            nothing_measured(points, None, None, kind="known_line", metric=is_metric(model))
        )
    return found


def sketch(subject: Subject, measured: Lookup) -> Sketch | None:
    points = subject.measured.points
    if not len(points):
        return None
    middle = half_way(points) if len(points) > 1 else points[0]
    return Sketch(np.asarray(points), middle, label="–")


def known(line: KnownLine) -> str:
    """What is known of it, in a few words."""
    if line.kind == "level":
        return tr("level")
    if line.value is None:
        return tr("not known yet")
    if line.kind == "azimuth":
        return tr("azimuth {degrees:.1f}°", degrees=line.value)
    return tr("{metres:.3f} m long", metres=line.value)


def about(subject: Subject) -> list[str]:
    """What is known of it."""
    line = subject.feature
    assert isinstance(line, KnownLine)
    said = [tr("Known of it: {what}", what=known(line))]
    if line.check:
        said.append(tr("It judges the registration and takes no part in it."))
    return said


FIGURES = (of.ID, of.NAME, *of.PLACE, of.NOTES)
WHAT = replace(
    of.KIND, title=_("Kind"), explanation=_("What is known"), value=lambda s: s.feature.kind,
    words=(), shown=None,
)  # fmt: skip
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
    headline=lambda measured: tr("Known line"),
    tool="known_line",
    layer=GisLayer("known_lines", "line", line_of, (of.ID, of.NAME, WHAT, of.NOTES), sparse=True),
    group=GROUP,
    color="#cc79a7",
    prefix=lambda line: "known",
)
