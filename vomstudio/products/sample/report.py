"""Report on the checks of the sample outcrop, as plain text and as HTML with pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from vomstudio.core.findings import Finding
from vomstudio.core.version import __version__
from vomstudio.core.words import to_translate, tr
from vomstudio.geology.notation import format_azimuth
from vomstudio.products.sample.check import Check

TITLE = to_translate("Measurements on the sample outcrop")


def format_text(checks: Sequence[Check], notes: Sequence[Finding]) -> str:
    """Format one line per check, and the number of regions that contain the true value."""
    rows = [_headings(), *map(_cells, checks)]
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    lines = [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]
    title = f"{tr(TITLE)} (VOM Studio {__version__})"
    return "\n".join([title, "", *lines, "", *map(str, (coverage_finding(checks), *notes))])


def _headings() -> tuple[str, ...]:
    return ("", tr("truth"), tr("measured"), tr("error"), tr("stated 95 %"), tr("within"))


def coverage_finding(checks: Sequence[Check]) -> Finding:
    """Report how often the true value lies within the stated region."""
    stated_checks = [check for check in checks if check.within is not None]
    within_count = sum(bool(check.within) for check in stated_checks)
    return Finding("sample.tally", held=within_count, count=len(stated_checks))


def format_html(
    checks: Sequence[Check], notes: Sequence[Finding], images: Mapping[str, str], seconds: float
) -> str:
    """Format the report as HTML; `images` maps file names to captions."""
    header, *body = [_headings(), *map(_cells, checks)]
    rows = "\n".join(
        f'<tr class="{"" if check.within else "out"}">'
        + "".join(f"<td>{escape(cell)}</td>" for cell in cells)
        + "</tr>"
        for cells, check in zip(body, checks, strict=True)
    )
    pictures = "\n".join(
        f'<figure><p><img src="{escape(name)}" alt="{escape(text)}"></p>'
        f"<figcaption>{escape(text)}</figcaption></figure>"
        for name, text in images.items()
    )
    paragraphs = "".join(
        f"<p>{escape(note)}</p>" for note in map(str, (coverage_finding(checks), *notes))
    )
    title = escape(tr(TITLE))
    units = escape(
        tr(
            "Angles in degrees from grid north: planes as dip direction/dip, lines as"
            " trend/plunge. Lengths in metres."
        )
    )
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title><style>
body {{ font: 15px/1.4 sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em; }}
table {{ border-collapse: collapse; }}
td, th {{ padding: .15em .8em .15em 0; text-align: left; border-bottom: 1px solid #ddd; }}
td {{ font-variant-numeric: tabular-nums; }} tr.out td {{ background: #fbe9d0; }}
img {{ max-width: 100%; }} figure {{ margin: 1.5em 0; }}
</style></head><body><h1>{title}</h1>{paragraphs}
{pictures}
<table><tr>{"".join(f"<th>{escape(cell)}</th>" for cell in header)}</tr>
{rows}</table>
<p>VOM Studio {__version__}, {seconds:.1f} s. {units}</p></body></html>
"""


def _cells(check: Check) -> tuple[str, ...]:
    digits, unit = (2, "°") if check.unit == "deg" else (3, f" {check.unit}")
    stated_text = (
        tr("not stated") if check.stated_95 is None else f"{check.stated_95:.{digits}f}{unit}"
    )
    within_text = {True: tr("yes"), False: tr("NO"), None: "-"}[check.within]
    return (
        tr(check.name),
        _value(check.truth),
        _value(check.measured),
        f"{check.error:.{digits}f}{unit}",
        stated_text,
        within_text,
    )


def _value(value: Mapping[str, float] | float | Any) -> str:
    if isinstance(value, Mapping):
        azimuth, angle = value.values()
        return f"{format_azimuth(azimuth, 1)}/{angle:04.1f}"
    return f"{value:.3f} m"
