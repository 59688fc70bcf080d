"""Where a text sends its reader to a menu, the entry is there under that name."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtWidgets import QMenu

pytestmark = pytest.mark.full

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
_MENUS = ("File", "Edit", "View", "Photos", "Model", "Interpret", "Analyse", "Help")
_PATH = re.compile(rf"\b({'|'.join(_MENUS)}) > (.{{3,80}})")


def texts() -> Iterator[tuple[str, str]]:
    """Name and text of every page, and of every string of the program."""
    for page in PAGES:
        yield page.name, page.read_text(encoding="utf-8")
    for module in sorted((ROOT / "vomstudio").rglob("*.py")):
        for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                yield f"{module.name}:{node.lineno}", node.value


def paths() -> dict[tuple[str, str], str]:
    """Menu and what follows, with a place where it stands."""
    found = {}
    for where, text in texts():
        for menu, rest in _PATH.findall(" ".join(text.replace("*", "").split())):
            found[menu, rest] = where
    return found


def leads_somewhere(menu: QMenu, rest: str) -> bool:
    """Whether the words begin with an entry, and go on into the menu that it may be."""
    menu.aboutToShow.emit()
    for action in menu.actions():
        name = action.text().replace("&", "").rstrip("…")
        if not name or not re.match(rf"{re.escape(name)}(?!\w)", rest):
            continue
        inner, more = action.menu(), rest[len(name) :].lstrip("…")
        if not more.startswith(" > "):
            return True
        if isinstance(inner, QMenu) and leads_somewhere(inner, more[3:]):
            return True
    return False


def test_every_menu_path_named_in_a_text_exists(window) -> None:
    bar = {a.text().replace("&", ""): a.menu() for a in window.menuBar().actions()}
    found = paths()
    assert len(found) > 15
    lost = [
        f"{where}: {menu} > {rest}"
        for (menu, rest), where in found.items()
        if not leads_somewhere(bar[menu], rest)
    ]
    assert lost == []


@pytest.mark.parametrize("rest", ["Export the moon", "Theme > Purple", "Ope"])
def test_nonexistent_menu_path_is_detected(window, rest: str) -> None:
    (file,) = (a.menu() for a in window.menuBar().actions() if a.text() == "&File")
    assert not leads_somewhere(file, rest)
