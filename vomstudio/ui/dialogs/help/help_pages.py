"""Files, order, titles and anchors of the documentation pages."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from vomstudio.core.files.regular import read_small_text

if TYPE_CHECKING:
    from vomstudio.project.figures import Figure

FIRST_PAGE = "index.md"
_NUMBERS_PAGE = "numbers.md"
_LINK_PATTERN = re.compile(r"\]\(([\w-]+\.md)(?:#[\w-]*)?\)")
_HEADING_PATTERN = re.compile(r"^##+ (.+)$", re.MULTILINE)
_TITLE_PATTERN = re.compile(r"^# (.+)$", re.MULTILINE)


@dataclass(frozen=True)
class Page:
    """Markdown file, whose first heading is the title."""

    path: Path
    title: str


def list_pages(folder: Path) -> list[Page]:
    """List all pages of a folder in the order in which the first page links to them.

    Raises
    ------
    OSError
        If a page cannot be read.
    """
    return [page for pages in list_sections(folder).values() for page in pages]


def list_sections(folder: Path) -> dict[str, list[Page]]:
    """List the pages of a folder by heading of the first page.

    Returns
    -------
    dict
        Pages, keyed by the heading under which the first page links to them. The key of the
        first page and of links before its first heading is "", and that of pages without a link is
        "More".

    Raises
    ------
    OSError
        If a page cannot be read.
    """
    first_page = folder / FIRST_PAGE
    sections = {"": [Page(first_page, _title(first_page))]}
    known_names = {FIRST_PAGE}

    def add_pages(heading: str, names: Iterable[str]) -> None:
        for name in names:
            if name not in known_names and (folder / name).is_file():
                known_names.add(name)
                sections.setdefault(heading, []).append(Page(folder / name, _title(folder / name)))

    introduction, *parts = _HEADING_PATTERN.split(read_small_text(first_page))
    add_pages("", _LINK_PATTERN.findall(introduction))
    for heading, text in zip(parts[::2], parts[1::2], strict=True):
        add_pages(heading.strip(), _LINK_PATTERN.findall(text))
    add_pages("More", sorted(path.name for path in folder.glob("*.md")))
    return sections


def _title(path: Path) -> str:
    match = _TITLE_PATTERN.search(read_small_text(path))
    return match.group(1).strip() if match else path.stem.replace("_", " ")


def figure_heading(figure: Figure) -> str:
    """Return the heading under which the page on numbers explains a figure."""
    return f"{figure.title} ({figure.name})"


def help_address(figure: Figure) -> str:
    """Return the address, as PAGE.md#HEADING, at which a figure is explained."""
    return f"{_NUMBERS_PAGE}#{anchor(figure_heading(figure))}"


def anchor(heading: str) -> str:
    """Return the anchor of a heading, as the documentation site and code hosts generate it."""
    text = re.sub(r"[^\w\s-]", "", heading.lower())
    return re.sub(r"[\s-]+", "-", text).strip("-")
