"""Formatting of orientation table rows for a spreadsheet, with one unit per column."""

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
_AZIMUTH_TITLES = {
    "dipdir/dip": to_translate("Dip direction"),
    "strike/dip": to_translate("Strike"),
    "quadrant": to_translate("Strike"),
}


def format_rows(rows: Sequence[Row], columns: Sequence[FeatureColumn]) -> str:
    """Format rows as tab-separated lines below a line with titles and units.

    An attitude has two columns, in the notation of the rows. Cells of undefined and infinite values
    are empty.
    """
    is_metric = all(row.measured.metric for row in rows)
    lines = [[cell for column in columns for cell in _format_titles(column, rows, is_metric)]]
    for row in rows:
        lines.append([cell for column in columns for cell in _format_cells(column, row)])
    return "\n".join("\t".join(line) for line in lines) + "\n"


def _format_titles(column: FeatureColumn, rows: Sequence[Row], is_metric: bool) -> list[str]:
    if column is ORIENTATION:
        azimuth, angle = tr(_AZIMUTH_TITLES.get(rows[0].notation, "Dip direction")), tr("Dip")
        if any(row.measured.plane is None for row in rows):
            azimuth = tr("{azimuth} or trend", azimuth=azimuth)
            angle = tr("{angle} or plunge", angle=angle)
        return [f"{azimuth} (°)", f"{angle} (°)"]
    title = tr(column.title)
    unit = "" if column.figure is None else _UNITS[column.figure.unit]
    if unit.startswith("m") and not is_metric:
        unit = tr("model units") if unit == "m" else tr("model units²")
    return [f"{title} ({unit})" if unit else title]


def _format_cells(column: FeatureColumn, row: Row) -> list[str]:
    if column is ORIENTATION:
        plane, line = row.measured.plane, row.measured.line
        if plane is not None:
            is_strike = row.notation in ("strike/dip", "quadrant")
            azimuth = plane.strike_rhr_deg if is_strike else plane.dip_direction_deg
            return [_format_number(azimuth, "deg"), _format_number(plane.dip_deg, "deg")]
        if line is not None:
            return [_format_number(line.trend_deg, "deg"), _format_number(line.plunge_deg, "deg")]
        return ["", ""]
    figure = column.figure
    if figure is None or figure.form in ("text", "flag") or figure.format_text is not None:
        return [escape_formula(" ".join(column.text(row).split()).replace("–", ""))]
    return [_format_value(figure, row)]


def _format_value(figure: Figure, row: Row) -> str:
    return _format_number(row.value(figure), figure.unit)


def _format_number(value: Any, unit: str) -> str:
    if value is None or not math.isfinite(value):
        return ""
    # No attitude is known to within 0.01°.
    return f"{value:.2f}" if unit == "deg" else f"{value:.6g}"
