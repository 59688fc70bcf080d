"""Where a page names a control of the window in italics, the window has it under that name."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = ("first_steps", "folds", "photos", "registration", "window", "worked_example")
ITALICS = re.compile(r"(?<!\*)\*([A-Z][^*]{2,40})\*(?!\*)")
OTHER_WORDS = {
    "Export Cameras": "a menu entry of Metashape",
    "First": "a column of a table on the page",
    "Mathematical Geology": "a journal",
    "Stands first": "a column of a table on the page",
}
"""Italic words that are not names of controls, with their meaning."""


@cache
def source() -> str:
    """Return the source of the program, without mnemonics and dots."""
    modules = sorted((ROOT / "vomstudio").rglob("*.py"))
    return "".join(m.read_text("utf-8") for m in modules).replace("&", "").replace("…", "")


def is_in_program(name: str) -> bool:
    """Return whether the program has a text that consists of a name."""
    return f'"{name}"' in source()


def control_names(page: str) -> list[str]:
    """Return the names of controls on a page; a path through menus gives one for each step."""
    text = re.sub(r"`[^`]*`", "", page)
    paths = (" ".join(name.split()).rstrip(".:…") for name in ITALICS.findall(text))
    return [name for path in paths if path not in OTHER_WORDS for name in path.split(" > ")]


@pytest.mark.parametrize("page", PAGES)
def test_every_control_that_a_page_names_is_in_the_window(page: str) -> None:
    names = control_names((ROOT / "docs" / f"{page}.md").read_text("utf-8"))
    assert [name for name in names if not is_in_program(name)] == []


def test_control_names_are_extracted_and_unknown_ones_detected() -> None:
    pages = [(ROOT / "docs" / f"{page}.md").read_text("utf-8") for page in PAGES]
    assert sum(len(control_names(page)) for page in pages) > 50
    assert control_names("Choose *Take plane*, *Results > Report* or **Fit**.") == [
        "Take plane",
        "Results",
        "Report",
    ]
    assert not is_in_program("Take plane")
    assert is_in_program("Reconstruction settings")
