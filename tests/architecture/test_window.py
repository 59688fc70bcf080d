"""Nobody reaches through the window: its parts are handed what they need."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
UI = ROOT / "vomstudio" / "ui"

WINDOWS = {"window", "parent", "main", "main_window"}
"""Names, with an underscore before them or without, that stand for the window or for a widget that
holds others."""
MOST_STEPS = 2
"""Attributes after such a name; three would be a reach into what somebody else is made of."""


def files() -> list[Path]:
    found = sorted(UI.rglob("*.py"))
    assert len(found) > 80, "the window has moved: bring this test up to date"
    return found


def tree_of(path: Path) -> ast.Module:
    return ast.parse(path.read_text("utf-8"), str(path))


def place(path: Path, node: ast.AST) -> str:
    return f"{path.relative_to(ROOT)}:{getattr(node, 'lineno', 0)}"


def names_of(node: ast.expr) -> list[str]:
    """The names of a chain such as `self._window.a().b[0].c`, from the left."""
    names: list[str] = []
    while True:
        if isinstance(node, ast.Attribute):
            names.append(node.attr)
            node = node.value
        elif isinstance(node, ast.Call):
            node = node.func
        elif isinstance(node, ast.Subscript):
            node = node.value
        else:
            break
    if isinstance(node, ast.Name):
        names.append(node.id)
    return names[::-1]


def steps_through_a_window(tree: ast.AST) -> Iterator[tuple[ast.Attribute, int]]:
    """Every attribute that is reached through a window, with the number of steps after it."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute):
            names = names_of(node)
            windows = [i for i, name in enumerate(names[:-1]) if name.lstrip("_") in WINDOWS]
            if windows:
                yield node, len(names) - 1 - windows[0]


def searches_among_children(tree: ast.AST) -> Iterator[ast.Attribute]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and node.attr in ("findChild", "findChildren"):
            yield node


def test_no_module_reaches_through_the_window() -> None:
    steps = [(k, place(f, n)) for f in files() for n, k in steps_through_a_window(tree_of(f))]
    most, _ = max(steps)
    print(f"{len(steps)} attributes of a window or parent, {most} steps at most")
    assert [where for count, where in steps if count > MOST_STEPS] == []


def test_no_module_searches_children_for_other_parts() -> None:
    found = [place(f, n) for f in files() for n in searches_among_children(tree_of(f))]
    print(f"{len(found)} searches among children")
    assert found == []


def test_only_window_start_imports_main_window() -> None:
    guilty = [
        place(path, node)
        for path in files()
        for node in ast.walk(tree_of(path))
        if isinstance(node, ast.ImportFrom) and node.module == "vomstudio.ui.shell.main_window"
    ]
    allowed = {"vomstudio/ui/shell/window_start.py"}
    assert {where.rpartition(":")[0] for where in guilty} == allowed


@pytest.mark.parametrize(
    ("text", "steps"),
    [
        ("main.a.b.c", 3),
        ("self._window.a.b().c", 3),
        ("self.window().rows[0].name.x", 3),
        ("window.files", 1),
        ("studio.project.journal.view", 0),
    ],
)
def test_access_through_window_is_detected(text: str, steps: int) -> None:
    found = [count for _, count in steps_through_a_window(ast.parse(text))]
    assert max(found, default=0) == steps


def lambdas_on_the_studio(tree: ast.AST) -> Iterator[ast.Call]:
    """Every connection of a signal of the studio to a lambda."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and any(isinstance(a, ast.Lambda) for a in node.args):
            names = names_of(node)
            if (
                names[-1] == "connect"
                and names[0] in ("studio", "self")
                and "studio" in (name.lstrip("_") for name in names[:2])
            ):
                yield node


def test_pages_connect_no_lambdas_to_the_studio() -> None:
    """Pages are deleted with the project. Qt disconnects their methods then, but no lambdas."""
    permanent = {UI / "panels" / name for name in ("net", "photos")}
    places = [
        place(path, call)
        for path in files()
        if path.is_relative_to(UI / "panels") or path.is_relative_to(UI / "widgets")
        if not permanent & set(path.parents)
        for call in lambdas_on_the_studio(tree_of(path))
    ]
    assert places == []


def test_lambda_connected_to_studio_is_detected() -> None:
    source = "studio.edited.connect(lambda _: self.x())\nself._studio.a.b.connect(lambda: 1)\n"
    assert len(list(lambdas_on_the_studio(ast.parse(source)))) == 2
    assert not list(lambdas_on_the_studio(ast.parse("self.box.toggled.connect(lambda _: 1)")))
