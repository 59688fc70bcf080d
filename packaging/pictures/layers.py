"""The layers of the program as a picture: what import-linter is told in pyproject.toml, and what
every package says of itself in the first line of its docstring."""

from __future__ import annotations

import ast
import re
import textwrap
import tomllib
from html import escape
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = "vomstudio"
LAYERS = "Imports point down only"
SCREENLESS = "The command line and everything under the window never reach Qt or VTK"

_WIDTH, _LEFT, _GAP, _LINE = 1000, 60, 7, 15
_SCREEN, _PLAIN, _INK = "#cfe2f3", "#eeeae1", "#222222"


def contract(name: str) -> dict[str, object]:
    """One contract of import-linter, as it stands in pyproject.toml."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    found: list[dict[str, object]] = project["tool"]["importlinter"]["contracts"]
    return next(each for each in found if each["name"] == name)


def layers() -> list[list[str]]:
    """The packages and modules of each layer, the highest layer first."""
    rows = contract(LAYERS)["layers"]
    assert isinstance(rows, list)
    return [[re.sub(r"\W", "", part) for part in re.split(r"[|:]", row)] for row in rows]


def drawn() -> str:
    """The picture, as SVG."""
    rows = layers()
    sources = contract(SCREENLESS)["source_modules"]
    assert isinstance(sources, list)
    # The version imports nothing at all, so that no contract needs to name it.
    plain = {name.removeprefix(f"{PACKAGE}.") for name in sources} | {"version"}
    boxes: list[str] = []
    y = 10
    for names in rows:
        wide = (_WIDTH - _LEFT - 10 - _GAP * (len(names) - 1)) / len(names)
        tall = 34 if len(names) == 1 else 30 + _LINE * max(len(_words(n, wide)) for n in names)
        for place, name in enumerate(names):
            color = _PLAIN if name in plain else _SCREEN
            boxes += _box(name, _LEFT + place * (wide + _GAP), y, wide, tall, color)
        y += tall + _GAP
    arrow = f"M 30 14 V {y - 12} m -8 -12 l 8 14 l 8 -14"
    y += 24
    height = y + 16
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{_WIDTH}" height="{height}" '
            f'viewBox="0 0 {_WIDTH} {height}" font-family="sans-serif" fill="{_INK}">',
            f'<rect width="{_WIDTH}" height="{height}" fill="white"/>',
            f'<path d="{arrow}" fill="none" stroke="{_INK}" stroke-width="2"/>',
            *boxes,
            _text(20, y, "Imports point down only.", 13),
            f'<rect x="270" y="{y - 14}" width="22" height="18" fill="{_SCREEN}"/>',
            _text(300, y, "may reach Qt or VTK", 13),
            f'<rect x="500" y="{y - 14}" width="22" height="18" fill="{_PLAIN}"/>',
            _text(530, y, "works without a screen", 13),
            "</svg>",
            "",
        ]
    )


def _box(name: str, x: float, y: float, wide: float, tall: float, color: str) -> list[str]:
    made = [
        f'<rect x="{x:g}" y="{y:g}" width="{wide:g}" height="{tall:g}" rx="4" fill="{color}" '
        f'stroke="#8a8a8a"/>',
        _text(x + 10, y + 22, name, 15, bold=True),
    ]
    if _beside(wide):
        return [*made, _text(x + 170, y + 22, _words(name, wide)[0], 12)]
    lines = enumerate(_words(name, wide))
    return made + [_text(x + 10, y + 40 + line * _LINE, words, 12) for line, words in lines]


def _beside(wide: float) -> bool:
    """A narrow box has its words below its name, a wide one beside it."""
    return wide > 700


def _words(name: str, wide: float) -> list[str]:
    return [said(name)] if _beside(wide) else textwrap.wrap(said(name), int((wide - 16) / 6.8))


def _text(x: float, y: float, words: str, size: int, *, bold: bool = False) -> str:
    weight = ' font-weight="bold"' if bold else ""
    return f'<text x="{x:g}" y="{y:g}" font-size="{size}"{weight}>{escape(words)}</text>'


def said(name: str) -> str:
    """What a package or module says of itself: the first paragraph of its docstring."""
    folder = ROOT / PACKAGE / name
    path = folder / "__init__.py" if folder.is_dir() else folder.with_suffix(".py")
    docstring = ast.get_docstring(ast.parse(path.read_text("utf-8"))) or ""
    return " ".join(docstring.split("\n\n")[0].replace("`", "").split())
