"""Text output: small tables for a terminal, and numbers with their usual digits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from vomstudio.project.tables.number_format import azimuth as azimuth
from vomstudio.project.tables.number_format import figures as figures
from vomstudio.project.tables.number_format import number as number


def table(headings: Sequence[str], units: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Align columns with headings and units: numbers to the right, words to the left."""
    lines = [list(headings), list(units), *map(list, rows)]
    widths = [max(len(line[i]) for line in lines) for i in range(len(headings))]
    is_right_aligned = [
        all(row[i] == "-" or row[i][:1].isdigit() or row[i][:1] == "-" for row in rows)
        for i in range(len(headings))
    ]
    aligned_lines = []
    for line in lines:
        cells = [
            cell.rjust(width) if is_right else cell.ljust(width)
            for cell, width, is_right in zip(line, widths, is_right_aligned, strict=True)
        ]
        aligned_lines.append("  ".join(cells).rstrip())
    return "\n".join(aligned_lines)


def label_lines(rows: Sequence[tuple[str, str]], width: int = 0, indent: str = "") -> str:
    """Return one line per label and text; labels are padded to `width` or the longest label."""
    width = width or max(len(label) for label, _ in rows)
    return "\n".join(f"{indent}{label:<{width}} {text}" for label, text in rows)


def inclination(value: Any, decimals: int = 1) -> str:
    """Return an inclination with two integer digits and a sign if negative; "-" if None."""
    if value is None:
        return "-"
    sign = "-" if round(value, decimals) < 0 else ""
    return f"{sign}{abs(value):0{3 + decimals if decimals else 2}.{decimals}f}"


def line(direction: Mapping[str, Any], decimals: int = 1) -> str:
    """Return `125.3/26.1` from trend_deg and plunge_deg."""
    return (
        f"{azimuth(direction['trend_deg'], decimals)}/"
        f"{inclination(direction['plunge_deg'], decimals)}"
    )


def plane(attitude: Mapping[str, Any], decimals: int = 1) -> str:
    """Return `132.0/41.5` from dip_direction_deg and dip_deg."""
    return (
        f"{azimuth(attitude['dip_direction_deg'], decimals)}/"
        f"{inclination(attitude['dip_deg'], decimals)}"
    )


def line_with_error(row: Mapping[str, Any]) -> str:
    """Return `125/26 ± 3.1°` from trend_deg, plunge_deg and the total or fit error (95 %)."""
    from vomstudio.geology.notation import format_attitude
    from vomstudio.geology.orientation import Line

    total = row["total95_deg"]
    error = row["max_confidence95_deg"] if total is None else total
    return format_attitude(Line(row["trend_deg"], row["plunge_deg"]), error)


def plane_with_error(row: Mapping[str, Any], error: str = "total95_deg") -> str:
    """Return `132/42 ± 2.4°` from dip_direction_deg, dip_deg and the column of the 95 % error."""
    from vomstudio.geology.notation import format_attitude
    from vomstudio.geology.orientation import Plane

    return format_attitude(Plane(row["dip_direction_deg"] or 0.0, row["dip_deg"]), row[error])
