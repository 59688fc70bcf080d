"""Headings and first lines of the figures in `docs/numbers.md`; ``python -m tests.ui.numbers_page``
renews them."""

from __future__ import annotations

import re
from pathlib import Path

from vomstudio.project import catalogue, slip_figures
from vomstudio.project.figures import Figure
from vomstudio.ui.dialogs.help.help_pages import anchor, figure_heading
from vomstudio.ui.panels.features.table_model import COLUMNS

PAGE = Path(__file__).resolve().parents[2] / "docs" / "numbers.md"
SHOWN = {
    figure.name: figure
    for figure in (
        *catalogue.ORIENTATION,
        catalogue.ANGLE_TO_PICK,
        catalogue.ANGLE,
        *(f for f in vars(slip_figures).values() if isinstance(f, Figure)),
        *(column.figure for column in COLUMNS if column.figure is not None),
    )
}
_UNITS = {"deg": "In degrees.", "m": "In metres.", "m2": "In square metres."}
_SECTION = re.compile(r"^### (.+ \((\w+)\))\n(.*)$", re.MULTILINE)


def renewed(page: str) -> str:
    """Return the page with the present titles and explanations of all figures.

    The first line of a section is written by this function, the others by hand.
    """

    def section(match: re.Match[str]) -> str:
        figure = SHOWN.get(match[2])
        return (
            match[0] if figure is None else f"### {figure_heading(figure)}\n{_first_line(figure)}"
        )

    for heading, name in re.findall(r"^### (.+ \((\w+)\))$", page, re.MULTILINE):
        if name in SHOWN:
            page = page.replace(
                f"](#{anchor(heading)})", f"](#{anchor(figure_heading(SHOWN[name]))})"
            )
    return _SECTION.sub(section, page)


def _first_line(figure: Figure) -> str:
    words = ", ".join(f"“{word}”" for word in figure.words)
    parts = (
        f"{figure.explanation.rstrip('.')}.",
        _UNITS.get(figure.unit, ""),
        f"Filter: {words}." if words else "",
    )
    return " ".join(part for part in parts if part)


if __name__ == "__main__":
    PAGE.write_text(renewed(PAGE.read_text("utf-8")), "utf-8")
