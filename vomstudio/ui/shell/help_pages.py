"""The pages of the documentation: where they lie, in which order they are read, their titles."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

FIRST = "index.md"
_LINK = re.compile(r"\]\(([\w-]+\.md)(?:#[\w-]*)?\)")
_TITLE = re.compile(r"^# (.+)$", re.MULTILINE)


@dataclass(frozen=True)
class Page:
    """path : of the Markdown file; title : its first heading"""

    path: Path
    title: str


def pages_in(folder: Path) -> list[Page]:
    """All pages of a folder: the first one, those to which it links in the order of its links, then
    the others by their names. Raises OSError."""
    first = (folder / FIRST).read_text("utf-8")
    names = [FIRST, *_LINK.findall(first), *sorted(path.name for path in folder.glob("*.md"))]
    found = [folder / name for name in dict.fromkeys(names)]
    return [Page(path, _title(path)) for path in found if path.is_file()]


def _title(path: Path) -> str:
    found = _TITLE.search(path.read_text("utf-8"))
    return found.group(1).strip() if found else path.stem.replace("_", " ")


def anchor(heading: str) -> str:
    """What a link to a heading ends with after #, as the site and code hosts make it."""
    plain = re.sub(r"[^\w\s-]", "", heading.lower())
    return re.sub(r"[\s-]+", "-", plain).strip("-")
