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

FIRST = "index.md"
_NUMBERS = "numbers.md"
_LINK = re.compile(r"\]\(([\w-]+\.md)(?:#[\w-]*)?\)")
_HEADING = re.compile(r"^##+ (.+)$", re.MULTILINE)
_TITLE = re.compile(r"^# (.+)$", re.MULTILINE)


@dataclass(frozen=True)
class Page:
    """path : of the Markdown file; title : its first heading"""

    path: Path
    title: str


def pages_in(folder: Path) -> list[Page]:
    """All pages of a folder: the first one, those to which it links in the order of its links, then
    the others by their names. Raises OSError."""
    return [page for pages in sections_in(folder).values() for page in pages]


def sections_in(folder: Path) -> dict[str, list[Page]]:
    """The same under the headings of the first page below which they are linked; the first page
    itself under "", those to which it does not link under "More". Raises OSError."""
    first = folder / FIRST
    found = {"": [Page(first, _title(first))]}
    known = {FIRST}

    def take(heading: str, names: Iterable[str]) -> None:
        for name in names:
            if name not in known and (folder / name).is_file():
                known.add(name)
                found.setdefault(heading, []).append(Page(folder / name, _title(folder / name)))

    before, *parts = _HEADING.split(read_small_text(first))
    take("", _LINK.findall(before))
    for heading, text in zip(parts[::2], parts[1::2], strict=True):
        take(heading.strip(), _LINK.findall(text))
    take("More", sorted(path.name for path in folder.glob("*.md")))
    return found


def _title(path: Path) -> str:
    found = _TITLE.search(read_small_text(path))
    return found.group(1).strip() if found else path.stem.replace("_", " ")


def heading_of(figure: Figure) -> str:
    """The heading under which a figure is explained on the page of numbers."""
    return f"{figure.title} ({figure.name})"


def address_of(figure: Figure) -> str:
    """Where a figure is explained: "PAGE.md#HEADING"."""
    return f"{_NUMBERS}#{anchor(heading_of(figure))}"


def anchor(heading: str) -> str:
    """What a link to a heading ends with after #, as the site and code hosts make it."""
    plain = re.sub(r"[^\w\s-]", "", heading.lower())
    return re.sub(r"[\s-]+", "-", plain).strip("-")
