"""Small XML files read with lxml, whose elements have line numbers for error messages.

libxml2 limits the expansion of entities, and no network is used. From line 65,536 on, the line
number may be that of the following element.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import isfinite, nan
from pathlib import Path
from typing import Any

from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import is_regular_file, open_regular_file, read_small_file
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr

Element = Any
"""Element of lxml, which has no type annotations."""
MAX_FILE_BYTES = 64 << 20
_MAX_DEPTH = 64
# An element with one or two tags takes more than 100 bytes of memory; files of thousands of photos
# contain far fewer.
_MAX_TAGS = 1_000_000


def read_xml(path: str | Path) -> Element:
    """Return the root of a file. Raises InputError with the line, as `parse_xml` does."""
    path = Path(path)
    try:
        data = read_small_file(path, MAX_FILE_BYTES)
    except OSError as error:
        raise InputError(Finding("file.unreadable", reason=error.strerror), file=path) from error
    return parse_xml(data, path)


def parse_xml(data: bytes, path: Path | None = None) -> Element:
    """Return the root of an XML text, without comments and processing instructions.

    Parameters
    ----------
    data : bytes
    path : Path, optional
        File name for error messages.

    Raises
    ------
    InputError
        If the text is not XML, is nested more than 64 levels deep, has more than a million tags, or
        declares entities, whose expansion may exceed the memory.
    """
    from lxml import etree

    refuse_many_tags([data], path)
    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, remove_comments=True, remove_pis=True
    )
    try:
        root: Element = etree.fromstring(data, parser)
    except etree.XMLSyntaxError as error:
        reason = error.msg.partition(", line ")[0].strip()
        raise InputError(
            Finding("file.damaged", reason=reason, format="XML"), file=path, line=error.lineno
        ) from error
    internal_dtd = root.getroottree().docinfo.internalDTD
    for entity in () if internal_dtd is None else internal_dtd.iterentities():
        finding = Finding("file.declares-entity", name=entity.name)
        raise InputError(finding, file=path)
    for element in root.xpath("/*" * (_MAX_DEPTH + 1)):
        finding = Finding("file.too-many-parts", limit=_MAX_DEPTH, parts=tr("nested elements"))
        raise InputError(finding, file=path, line=element.sourceline, field=element.tag)
    return root


def refuse_many_tags(blocks: Iterable[bytes], path: Path | None, max_tags: int = _MAX_TAGS) -> None:
    """Raise InputError if there are too many tags, or more than four attributes per tag.

    Parameters
    ----------
    blocks : iterable of bytes
        Successive parts of the text.
    path : Path or None
    max_tags : int
    """
    tag_count = equals_count = 0
    for block in blocks:
        tag_count += block.count(b"<")
        equals_count += block.count(b"=")
        if tag_count > max_tags or equals_count > 4 * max_tags:
            limit = max_tags if tag_count > max_tags else 4 * max_tags
            finding = Finding("file.too-many-parts", limit=limit, parts=tr("tags or attributes"))
            raise InputError(finding, file=path)


def is_xml(path: str | Path) -> bool:
    """Return whether a file begins with `<`; return False if it cannot be read."""
    if not is_regular_file(path):
        return False
    try:
        with open_regular_file(path) as stream:
            header = stream.read(256)
    except (InputError, OSError):
        return False
    for mark in (b"\xef\xbb\xbf", b"\xff\xfe", b"\xfe\xff"):
        header = header.removeprefix(mark)
    return header.replace(b"\0", b"").lstrip().startswith(b"<")


def element_error(
    path: Path, element: Element, cause: Finding, field: str | None = None
) -> InputError:
    """Return an error with the file, the line, and `field` or else the element."""
    return InputError(cause, file=path, line=element.sourceline, field=field or element.tag)


def words(path: Path, parent: Element, tag: str) -> str:
    """Return the text of a child element. Raises InputError if it is missing or empty."""
    child = parent.find(tag)
    if child is None:
        raise element_error(path, parent, Finding("file.missing-element", name=tag))
    text = str(child.text or "").strip()
    if not text:
        raise element_error(path, child, Finding("table.value-missing"))
    return text


def attribute(path: Path, element: Element, name: str) -> str:
    """Return the value of an attribute. Raises InputError if it is missing or empty."""
    value = str(element.get(name, "")).strip()
    if not value:
        raise element_error(path, element, Finding("file.missing-element", name=name))
    return value


def number(path: Path, element: Element, text: str, name: str = "") -> float:
    """Parse a finite number. Raises InputError with the element and `name`."""
    try:
        value = float(text)
    except ValueError:
        value = nan
    if not isfinite(value):
        field = f"{element.tag}, {name}" if name else None
        raise element_error(path, element, Finding("table.not-a-number", cell=text[:40]), field)
    return value


def numbers(path: Path, element: Element, text: str, count: int) -> tuple[float, ...]:
    """Parse `count` finite numbers separated by spaces. Raises InputError with the element."""
    values = tuple(number(path, element, word) for word in text.split())
    if len(values) != count:
        raise element_error(
            path,
            element,
            Finding("file.number-count", count=len(values), needed=count),
        )
    return values


class UniqueKeys:
    """Register of the unique keys in a file, with their line numbers."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._lines: dict[object, int | None] = {}

    def add(
        self, key: object, element: Element, code: str, field: str | None = None, **values: str
    ) -> None:
        """Add a key. Raises InputError with the value `first_line` if it already exists."""
        if key in self._lines:
            finding = Finding(code, **values, first_line=self._lines[key])
            raise element_error(self._path, element, finding, field)
        self._lines[key] = element.sourceline
