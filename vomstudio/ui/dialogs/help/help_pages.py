"""The pages of the documentation: where they lie, in which order they are read, their titles."""

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
_NUMBERS = "numbers.md"
_LINK = re.compile(r"\]\(([\w-]+\.md)(?:#[\w-]*)?\)")
_HEADING = re.compile(r"^##+ (.+)$", re.MULTILINE)
_TITLE = re.compile(r"^# (.+)$", re.MULTILINE)


@dataclass(frozen=True)
class Page:
    """path : of the Markdown file; title : its first heading"""

    path: Path
    title: str


def list_pages(folder: Path) -> list[Page]:
    """All pages of a folder: the first one, those to which it links in the order of its links, then
    the others by their names. Raises OSError."""
    return [page for pages in list_sections(folder).values() for page in pages]


def list_sections(folder: Path) -> dict[str, list[Page]]:
    """The same under the headings of the first page below which they are linked; the first page
    itself under "", those to which it does not link under "More". Raises OSError."""
    first = folder / FIRST_PAGE
    sections = {"": [Page(first, _title(first))]}
    known_names = {FIRST_PAGE}

    def add_pages(heading: str, names: Iterable[str]) -> None:
        for name in names:
            if name not in known_names and (folder / name).is_file():
                known_names.add(name)
                sections.setdefault(heading, []).append(Page(folder / name, _title(folder / name)))

    introduction, *parts = _HEADING.split(read_small_text(first))
    add_pages("", _LINK.findall(introduction))
    for heading, text in zip(parts[::2], parts[1::2], strict=True):
        add_pages(heading.strip(), _LINK.findall(text))
    add_pages("More", sorted(path.name for path in folder.glob("*.md")))
    return sections


def _title(path: Path) -> str:
    match = _TITLE.search(read_small_text(path))
    return match.group(1).strip() if match else path.stem.replace("_", " ")


def heading_of(figure: Figure) -> str:
    """The heading under which a figure is explained on the page of numbers."""
    return f"{figure.title} ({figure.name})"


def address_of(figure: Figure) -> str:
    """Where a figure is explained: "PAGE.md#HEADING"."""
    return f"{_NUMBERS}#{anchor(heading_of(figure))}"


def anchor(heading: str) -> str:
    """What a link to a heading ends with after #, as the site and code hosts make it."""
    text = re.sub(r"[^\w\s-]", "", heading.lower())
    return re.sub(r"[\s-]+", "-", text).strip("-")
