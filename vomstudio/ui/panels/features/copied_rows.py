"""Rows of the orientation table as a spreadsheet takes them: numbers, each column in one unit."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from vomstudio.core.files.spreadsheet_cells import escape_formula
from vomstudio.core.words import to_translate, tr
from vomstudio.project.figures import Figure
from vomstudio.ui.panels.features.feature_row import Row
from vomstudio.ui.panels.features.table_model import ORIENTATION, FeatureColumn

_UNITS = {"deg": "°", "m": "m", "m2": "m²", "": ""}
_AZIMUTHS = {
    "dipdir/dip": to_translate("Dip direction"),
    "strike/dip": to_translate("Strike"),
    "quadrant": to_translate("Strike"),
}


def as_text(rows: Sequence[Row], columns: Sequence[FeatureColumn]) -> str:
    """Lines of cells with tabs between them, the first with titles and units. An attitude takes two
    columns, in the notation of the rows; what is undefined or infinite is empty."""
    metric = all(row.measured.metric for row in rows)
    lines = [[cell for column in columns for cell in _titles(column, rows, metric)]]
    for row in rows:
        lines.append([cell for column in columns for cell in _cells(column, row)])
    return "\n".join("\t".join(line) for line in lines) + "\n"


def _titles(column: FeatureColumn, rows: Sequence[Row], metric: bool) -> list[str]:
    if column is ORIENTATION:
        azimuth, angle = tr(_AZIMUTHS.get(rows[0].notation, "Dip direction")), tr("Dip")
        if any(row.measured.plane is None for row in rows):
            azimuth = tr("{azimuth} or trend", azimuth=azimuth)
            angle = tr("{angle} or plunge", angle=angle)
        return [f"{azimuth} (°)", f"{angle} (°)"]
    title = tr(column.title)
    unit = "" if column.figure is None else _UNITS[column.figure.unit]
    if unit.startswith("m") and not metric:
        unit = tr("model units") if unit == "m" else tr("model units²")
    return [f"{title} ({unit})" if unit else title]


def _cells(column: FeatureColumn, row: Row) -> list[str]:
    if column is ORIENTATION:
        plane, line = row.measured.plane, row.measured.line
        if plane is not None:
            strike = row.notation in ("strike/dip", "quadrant")
            azimuth = plane.strike_rhr_deg if strike else plane.dip_direction_deg
            return [_number(azimuth, "deg"), _number(plane.dip_deg, "deg")]
        if line is not None:
            return [_number(line.trend_deg, "deg"), _number(line.plunge_deg, "deg")]
        return ["", ""]
    figure = column.figure
    if figure is None or figure.form in ("text", "flag") or figure.shown is not None:
        return [escape_formula(" ".join(column.text(row).split()).replace("–", ""))]
    return [_value(figure, row)]


def _value(figure: Figure, row: Row) -> str:
    return _number(row.value(figure), figure.unit)


def _number(value: Any, unit: str) -> str:
    if value is None or not math.isfinite(value):
        return ""
    # A hundredth of a degree is finer than any attitude is known.
    return f"{value:.2f}" if unit == "deg" else f"{value:.6g}"
