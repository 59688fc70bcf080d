"""What the panel of slopes asks, worked out in a thread, and its command."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from vomstudio.core.options import option_words
from vomstudio.geology.slopes import SlopeFace
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import Feature, Record
from vomstudio.ui.widgets.copied_command import CommandArguments

if TYPE_CHECKING:
    from vomstudio.geology.orientation_rows import OrientationRows
    from vomstudio.geology.table_slopes import CriticalPlane, TableSlope


@dataclass(frozen=True, eq=False)
class SlopeQuestion:
    """features : those with a plane; measured : of each, by id"""

    records: Mapping[str, Record]
    features: Sequence[Feature]
    measured: Mapping[str, Measurement]
    face: SlopeFace


@dataclass(frozen=True, eq=False)
class SlopeAnswer:
    """critical : as `critical_planes` has it"""

    question: SlopeQuestion
    table: OrientationRows
    found: TableSlope
    critical: Mapping[str, tuple[CriticalPlane, ...]]


def answer(question: SlopeQuestion) -> SlopeAnswer:
    """In a thread: what `vomstudio slope` says of these planes."""
    from vomstudio.geology.table_slopes import critical_planes, table_slope
    from vomstudio.project.exports.feature_table import feature_table

    table = feature_table(question.records, question.features, question.measured)
    found = table_slope(table, question.face)
    return SlopeAnswer(question, table, found, critical_planes(table, question.face, found))


def write_figure(result: SlopeAnswer, path: Path) -> None:
    """In a thread: the nets, as svg, pdf or png."""
    from vomstudio.core.files.atomic import atomic_write
    from vomstudio.products.net.slope_figure import write_slope_figure

    format_ = path.suffix.lower().removeprefix(".")
    with atomic_write(path, True) as temporary:
        write_slope_figure(
            temporary, result.table, result.question.face, result.found, format=format_
        )


def words_of(face: SlopeFace, table: Path) -> CommandArguments:
    """The command that says the same of this table."""
    plane = face.plane
    return [
        "slope",
        table,
        ("--face", f"{plane.dip_direction_deg:.10g}/{plane.dip_deg:.10g}"),
        *option_words(face.options),
    ]
