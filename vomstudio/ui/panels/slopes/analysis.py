"""Kinematic analysis of one slope face, its figure and its command line."""

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
class FaceSlopeRequest:
    """Input of the analysis: features that have a plane, and their measurements by id."""

    records: Mapping[str, Record]
    features: Sequence[Feature]
    measured: Mapping[str, Measurement]
    face: SlopeFace


@dataclass(frozen=True, eq=False)
class FaceSlopeResult:
    """Result of the analysis; `critical` is the result of `list_critical_planes`."""

    request: FaceSlopeRequest
    table: OrientationRows
    analysis: TableSlope
    critical: Mapping[str, tuple[CriticalPlane, ...]]


def analyze_slope(request: FaceSlopeRequest) -> FaceSlopeResult:
    """Analyse a slope as in the command `slope`. Runs in a worker thread."""
    from vomstudio.geology.table_slopes import list_critical_planes, table_slope
    from vomstudio.project.exports.feature_table import feature_table

    table = feature_table(request.records, request.features, request.measured)
    analysis = table_slope(table, request.face)
    return FaceSlopeResult(
        request, table, analysis, list_critical_planes(table, request.face, analysis)
    )


def write_figure(result: FaceSlopeResult, path: Path) -> None:
    """Write the nets as SVG, PDF or PNG. Runs in a worker thread."""
    from vomstudio.core.files.atomic import atomic_write
    from vomstudio.products.net.slope_figure import write_slope_figure

    format_ = path.suffix.lower().removeprefix(".")
    with atomic_write(path, True) as temporary:
        write_slope_figure(
            temporary, result.table, result.request.face, result.analysis, format=format_
        )


def slope_command(face: SlopeFace, table: Path) -> CommandArguments:
    """Return the command that reproduces the result from a table of planes."""
    plane = face.plane
    return [
        "slope",
        table,
        ("--face", f"{plane.dip_direction_deg:.10g}/{plane.dip_deg:.10g}"),
        *option_words(face.options),
    ]
