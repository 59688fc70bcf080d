"""Small XML files, through lxml, whose elements know their lines, so that errors can say where.

libxml2 itself bounds what entities unfold to, and fetches nothing. From line 65,536 on the line may
be that of what follows the element.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import isfinite, nan
from pathlib import Path
from typing import Any

from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import is_regular, open_regular, read_small
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr

Element = Any
"""Of lxml, which carries no types."""
LARGEST_FILE = 64 << 20
_DEEPEST = 64
# An element, of one or two, takes a hundred and more bytes once read; thousands of photos with
# their marks are far below.
_MOST_TAGS = 1_000_000


def read_xml(path: str | Path) -> Element:
    """The root of a file. Raises InputError with the line where it is no XML, as `parse_xml`."""
    path = Path(path)
    try:
        data = read_small(path, LARGEST_FILE)
    except OSError as error:
        raise InputError(Finding("file.unreadable", reason=error.strerror), file=path) from error
    return parse_xml(data, path)


def parse_xml(data: bytes, path: Path | None = None) -> Element:
    """The root; path : for errors. Comments and processing instructions are left out.

    Raises InputError where it is no XML, where elements stand in each other more than 64 deep,
    where there are more than a million tags, and where it declares entities, which can unfold to
    more than any memory holds.
    """
    from lxml import etree

    refuse_many_tags([data], path)
    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, remove_comments=True, remove_pis=True
    )
    try:
        root: Element = etree.fromstring(data, parser)
    except etree.XMLSyntaxError as error:
        said = error.msg.partition(", line ")[0].strip()
        raise InputError(
            Finding("file.damaged", reason=said, format="XML"), file=path, line=error.lineno
        ) from error
    declared = root.getroottree().docinfo.internalDTD
    for entity in () if declared is None else declared.iterentities():
        finding = Finding("file.declares-entity", name=entity.name)
        raise InputError(finding, file=path)
    for deep in root.xpath("/*" * (_DEEPEST + 1)):
        finding = Finding("file.too-many-parts", limit=_DEEPEST, parts=tr("nested elements"))
        raise InputError(finding, file=path, line=deep.sourceline, field=deep.tag)
    return root


def refuse_many_tags(blocks: Iterable[bytes], path: Path | None, most: int = _MOST_TAGS) -> None:
    """blocks : of the text in turn. Raises InputError for more tags, or for more than four
    attributes for each of as many."""
    tags = equals = 0
    for block in blocks:
        tags += block.count(b"<")
        equals += block.count(b"=")
        if tags > most or equals > 4 * most:
            limit = most if tags > most else 4 * most
            finding = Finding("file.too-many-parts", limit=limit, parts=tr("tags or attributes"))
            raise InputError(finding, file=path)


def is_xml(path: str | Path) -> bool:
    """By the first sign in it; False for what cannot be read."""
    if not is_regular(path):
        return False
    try:
        with open_regular(path) as stream:
            head = stream.read(256)
    except (InputError, OSError):
        return False
    for mark in (b"\xef\xbb\xbf", b"\xff\xfe", b"\xfe\xff"):
        head = head.removeprefix(mark)
    return head.replace(b"\0", b"").lstrip().startswith(b"<")


def wrong(path: Path, element: Element, cause: Finding, field: str | None = None) -> InputError:
    """An error that names file, line and element, or another field of it."""
    return InputError(cause, file=path, line=element.sourceline, field=field or element.tag)


def words(path: Path, parent: Element, tag: str) -> str:
    """What a child says. Raises InputError that names it where there is none or it is empty."""
    child = parent.find(tag)
    if child is None:
        raise wrong(path, parent, Finding("file.missing-element", name=tag))
    text = str(child.text or "").strip()
    if not text:
        raise wrong(path, child, Finding("table.value-missing"))
    return text


def attribute(path: Path, element: Element, name: str) -> str:
    """Raises InputError where there is none or it is empty."""
    value = str(element.get(name, "")).strip()
    if not value:
        raise wrong(path, element, Finding("file.missing-element", name=name))
    return value


def number(path: Path, element: Element, text: str, name: str = "") -> float:
    """A finite number. Raises InputError that names the element, and what of it."""
    try:
        value = float(text)
    except ValueError:
        value = nan
    if not isfinite(value):
        field = f"{element.tag}, {name}" if name else None
        raise wrong(path, element, Finding("table.not-a-number", cell=text[:40]), field)
    return value


def numbers(path: Path, element: Element, text: str, count: int) -> tuple[float, ...]:
    """So many finite numbers with blanks between them. Raises InputError that names the element."""
    found = tuple(number(path, element, word) for word in text.split())
    if len(found) != count:
        raise wrong(
            path,
            element,
            Finding("file.number-count", count=len(found), needed=count),
        )
    return found


class Once:
    """Labels that may stand once in a file, and the lines in which they do."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._lines: dict[object, int | None] = {}

    def add(
        self, key: object, element: Element, code: str, field: str | None = None, **values: str
    ) -> None:
        """Raise InputError with a code and the value `first_line` if the key is known."""
        if key in self._lines:
            finding = Finding(code, **values, first_line=self._lines[key])
            raise wrong(self._path, element, finding, field)
        self._lines[key] = element.sourceline
