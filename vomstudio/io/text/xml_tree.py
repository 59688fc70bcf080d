"""Small XML files as trees whose elements know their lines, so that errors can say where."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import isfinite, nan
from pathlib import Path
from xml.parsers import expat

from vomstudio.errors import InputError
from vomstudio.words import tr

LARGEST_FILE = 64 << 20
_DEEPEST = 64


@dataclass
class Element:
    """text : what stands in it before its first child"""

    tag: str
    attributes: dict[str, str]
    line: int
    text: str = ""
    children: list[Element] = field(default_factory=list)

    def all(self, tag: str) -> list[Element]:
        """Its children of this name."""
        return [child for child in self.children if child.tag == tag]

    def child(self, tag: str) -> Element | None:
        return next(iter(self.all(tag)), None)

    def below(self, tag: str) -> Iterator[Element]:
        """All elements of this name, itself included, in their order."""
        waiting = [self]
        while waiting:
            here = waiting.pop()
            if here.tag == tag:
                yield here
            waiting += reversed(here.children)


def read_xml(path: str | Path) -> Element:
    """The root of a file. Raises InputError with the line where it is no XML.

    Files that declare entities are refused: they can unfold to more than any memory holds.
    """
    path = Path(path)
    try:
        with path.open("rb") as stream:
            data = stream.read(LARGEST_FILE + 1)
    except OSError as error:
        raise InputError(
            tr("cannot be read ({strerror})", strerror=error.strerror), file=path
        ) from error
    if len(data) > LARGEST_FILE:
        raise InputError(
            tr("is larger than {LARGEST_FILE} MB", LARGEST_FILE=LARGEST_FILE >> 20), file=path
        )
    parser = expat.ParserCreate()
    parser.buffer_text = True
    open_: list[Element] = []
    roots: list[Element] = []

    def start(tag: str, attributes: dict[str, str]) -> None:
        made = Element(tag, attributes, parser.CurrentLineNumber)
        if len(open_) >= _DEEPEST:
            raise InputError(
                tr("has elements inside each other more than {DEEPEST} deep", DEEPEST=_DEEPEST),
                file=path,
                line=made.line,
                field=tag,
            )
        (open_[-1].children if open_ else roots).append(made)
        open_.append(made)

    def end(_: str) -> None:
        open_.pop()

    def characters(text: str) -> None:
        if not open_[-1].children:
            open_[-1].text += text

    def entity(name: str, *_: object) -> None:
        raise InputError(
            tr("declares an entity ({name}), which such files do not need; remove it", name=name),
            file=path,
            line=parser.CurrentLineNumber,
        )

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler, parser.EntityDeclHandler = characters, entity
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        raise InputError(
            tr("is not sound XML ({ErrorString})", ErrorString=expat.ErrorString(error.code)),
            file=path,
            line=error.lineno,
        ) from error
    except (LookupError, ValueError) as error:
        # An encoding that nobody knows.
        raise InputError(tr("cannot be read as text ({error})", error=error), file=path) from error
    return roots[0]


def is_xml(path: str | Path) -> bool:
    """By the first sign in it; False for what cannot be read."""
    try:
        with Path(path).open("rb") as stream:
            head = stream.read(256)
    except OSError:
        return False
    for mark in (b"\xef\xbb\xbf", b"\xff\xfe", b"\xfe\xff"):
        head = head.removeprefix(mark)
    return head.replace(b"\0", b"").lstrip().startswith(b"<")


def wrong(path: Path, element: Element, said: str, field: str | None = None) -> InputError:
    """An error that names file, line and element, or another field of it."""
    return InputError(said, file=path, line=element.line, field=field or element.tag)


def words(path: Path, parent: Element, tag: str) -> str:
    """What a child says. Raises InputError that names it where there is none or it is empty."""
    child = parent.child(tag)
    if child is None:
        raise wrong(path, parent, f"has no {tag}")
    text = child.text.strip()
    if not text:
        raise wrong(path, child, "is empty")
    return text


def attribute(path: Path, element: Element, name: str) -> str:
    """Raises InputError where there is none or it is empty."""
    value = element.attributes.get(name, "").strip()
    if not value:
        raise wrong(path, element, f"has no {name}")
    return value


def number(path: Path, element: Element, text: str, name: str = "") -> float:
    """A finite number. Raises InputError that names the element, and what of it."""
    try:
        value = float(text)
    except ValueError:
        value = nan
    if not isfinite(value):
        about = f"{name}: " if name else ""
        raise wrong(path, element, f"{about}'{text[:40]}' is not a number")
    return value


def numbers(path: Path, element: Element, text: str, count: int) -> tuple[float, ...]:
    """So many finite numbers with blanks between them. Raises InputError that names the element."""
    found = tuple(number(path, element, word) for word in text.split())
    if len(found) != count:
        raise wrong(path, element, f"holds {len(found)} numbers; {count} are needed")
    return found


class Once:
    """Labels that may stand once in a file, and the lines in which they do."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._lines: dict[object, int] = {}

    def add(self, key: object, element: Element, said: str, field: str | None = None) -> None:
        """Raises InputError for a second one; said : a sentence with {line} of the first."""
        if key in self._lines:
            raise wrong(self._path, element, said.replace("{line}", str(self._lines[key])), field)
        self._lines[key] = element.line
