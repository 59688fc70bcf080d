"""Lines and outlines out of SVG, as Inkscape and other programs write it (SVG 1.1, W3C 2011)."""

from __future__ import annotations

import gzip
import io
import re
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import read_small
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.io.gis.line_reading import FeatureWords, ReadLine
from vomstudio.io.gis.svg_paths import (
    NUMBER,
    length,
    lengths,
    moved,
    numbers_in,
    shape_of,
    transform_of,
)
from vomstudio.io.text.xml_tree import parse_xml

OWN_CLASS = "vomstudio"
"""Of elements of our own drawings that are no line of anybody: frames, symbols, labels."""
_LARGEST = 256 << 20
_MOST_NUMBERS = 500_000
"""Of all paths: what is read in some seconds; hands draw a hundredth of it."""
_LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"
_MODE = "{http://www.inkscape.org/namespaces/inkscape}groupmode"
_ABSOLUTE = "{http://sodipodi.sourceforge.net/DTD/sodipodi-0.dtd}absref"
_LINK = "{http://www.w3.org/1999/xlink}href"
_WORDS = ("id", "data-kind", "data-set")
_NEVER_SEEN = ("defs", "clipPath", "mask", "pattern", "marker", "metadata", "namedview", "style")
_DEEPEST_USE = 8
_MOST_SHAPES = 1_000_000


@dataclass(frozen=True, eq=False)
class SvgImage:
    """corners : (4, 2) of its place in the drawing's units, upper left, upper right, lower right,
    lower left; name : of the file that is shown, "" where the picture is in the drawing; fit :
    "none" stretches it to its place, "meet" puts it inside, "slice" covers all of it; align : 0 to
    1 across and down
    """

    corners: FloatArray
    name: str
    fit: str
    align: tuple[float, float]

    def shown(self, ratio: float) -> FloatArray:
        """(4, 2) corners of a picture of this width by height in its place."""
        across, down = self.corners[1] - self.corners[0], self.corners[3] - self.corners[0]
        wide, high = float(np.hypot(*across)), float(np.hypot(*down))
        if self.fit == "none" or not (wide > 0 and high > 0):
            return self.corners
        limit = max if self.fit == "slice" else min
        x, y = limit(high * ratio / wide, 1.0), limit(wide / ratio / high, 1.0)
        at = self.corners[0] + self.align[0] * (1 - x) * across + self.align[1] * (1 - y) * down
        return np.array([at, at + x * across, at + x * across + y * down, at + y * down])


@dataclass(frozen=True, eq=False)
class SvgDrawing:
    """Coordinates are the file's user units, x right, y down.

    lines : with their transforms applied, without what is hidden; images : also those that are
    hidden, since lines lie on them all the same; page : (4,) x, y, width, height; marks : what its
    descriptions say
    """

    lines: tuple[ReadLine, ...]
    images: tuple[SvgImage, ...]
    page: FloatArray | None
    marks: tuple[str, ...]


@np.errstate(all="ignore")
def read_svg(path: str | Path) -> SvgDrawing:
    """Paths (curves as pieces), polylines, polygons, lines, rectangles, circles and ellipses, also
    where they are used again (clones). Raises InputError where the file is no SVG."""
    path = Path(path)
    root = parse_xml(_plain_svg(_content(path), path), path)
    if _tag(root) != "svg":
        raise InputError(Finding("file.other-format", format="SVG"), file=path)
    lines: list[ReadLine] = []
    images: list[SvgImage] = []
    marks = [str(element.text or "") for element in root.iter() if _tag(element) == "desc"]
    room = _MOST_NUMBERS
    try:
        for element, at in _Walk(root).all():
            tag = _tag(element)
            if tag == "image":
                images.append(_image(element, at))
            elif tag != "desc" and at.seen:
                room -= numbers_in(element)
                if room < 0:
                    raise InputError(
                        Finding("file.too-many-parts", limit=_MOST_NUMBERS, parts=tr("numbers")),
                        file=path,
                    )
                name = str(element.get(_LABEL) or _title(element) or element.get("id") or at.name)
                words = FeatureWords(*(str(element.get(key) or "") for key in _WORDS))
                lines += [
                    ReadLine(at.layer, name, moved(points, at.matrix), closed, words=words)
                    for points, closed in shape_of(element, tag, at.view)
                    if len(points) > 1
                ]
    except (ValueError, IndexError, OverflowError) as error:
        raise InputError(
            Finding(
                "file.damaged", format="SVG", reason=tr("the coordinates of a shape cannot be read")
            ),
            file=path,
        ) from error
    return SvgDrawing(tuple(lines), tuple(images), _page(root), tuple(marks))


def _content(path: Path) -> bytes:
    """Of a file that may be packed (.svgz)."""
    too_large = InputError(Finding("file.too-large", limit_mb=_LARGEST >> 20), file=path)
    try:
        data = read_small(path, _LARGEST)
    except OSError as error:
        reason = error.strerror or error
        raise InputError(Finding("file.unreadable", reason=reason), file=path) from error
    if not data.startswith(b"\x1f\x8b"):
        return data
    try:
        with gzip.GzipFile(fileobj=io.BytesIO(data)) as packed:
            data = packed.read(_LARGEST + 1)
    except (OSError, EOFError, zlib.error) as error:
        damaged = Finding("file.damaged", format="SVG", reason=error)
        raise InputError(damaged, file=path) from error
    if len(data) > _LARGEST:
        raise too_large
    return data


_DOCTYPE = re.compile(rb"<!DOCTYPE\s+svg\b[^\[>]*(?:\[([^\]]*)\]\s*)?>")
_ENTITY = re.compile(
    rb"<!ENTITY\s+([\w.-]{1,64})\s+(?:\"([^\"&%<]{0,200})\"|'([^'&%<]{0,200})')\s*>"
)
_MOST_ENTITIES = 64


def _plain_svg(data: bytes, path: Path) -> bytes:
    """Without the pictures inside, which are longer than the parser lets an attribute be, and
    without the short words that Illustrator declares for its namespaces, written out."""
    data = re.sub(rb"""(["'])data:[^"']*""", rb"\1data:", data)
    head = _DOCTYPE.search(data[:65_536])
    if head is None or not head.group(1):
        return data
    said = _ENTITY.findall(head.group(1))
    if len(said) > _MOST_ENTITIES or _ENTITY.sub(b"", head.group(1)).strip():
        return data
    body = data[head.end() :]
    for name, double, single in said:
        body = body.replace(b"&" + name + b";", double or single)
        if len(body) > _LARGEST:
            raise InputError(Finding("file.too-large", limit_mb=_LARGEST >> 20), file=path)
    return data[: head.start()] + body


@dataclass(frozen=True, eq=False)
class _Place:
    """Where an element stands. matrix : (3, 3) to the drawing's units; view : width and height of
    the innermost viewport; seen : not hidden; visible : of what inherits it; name : of the clone;
    uses : how many clones it is inside of"""

    matrix: FloatArray
    view: tuple[float, float]
    layer: str = ""
    name: str = ""
    seen: bool = True
    shown: bool = True
    visible: bool = True
    uses: int = 0


class _Walk:
    """All elements of a drawing with their places."""

    def __init__(self, root: Any) -> None:
        self._root = root
        self._by_id = {str(e.get("id")): e for e in root.iter() if e.get("id")}
        self._rules = _style_rules(root)
        self._count = 0

    def all(self) -> Iterator[tuple[Any, _Place]]:
        page = _page(self._root)
        view = (100.0, 100.0) if page is None else (float(page[2]), float(page[3]))
        return self._of(self._root, _Place(np.eye(3), view))

    def _of(self, element: Any, at: _Place) -> Iterator[tuple[Any, _Place]]:
        tag = _tag(element)
        if tag in _NEVER_SEEN or OWN_CLASS in str(element.get("class") or "").split():
            return
        if tag == "symbol" and not at.uses:
            return
        self._count += 1
        if self._count > _MOST_SHAPES:
            raise ValueError("more shapes than can be meant")
        at = self._inside(element, tag, at)
        yield element, at
        if tag == "use":
            yield from self._used(element, at)
        for child in element:
            yield from self._of(child, at)

    def _inside(self, element: Any, tag: str, at: _Place) -> _Place:
        """The place of an element, for itself and what is in it."""
        style = self._style(element, tag)
        shown = at.shown and style.get("display") != "none"
        visible = at.visible
        if "visibility" in style:
            visible = style["visibility"] not in ("hidden", "collapse")
        matrix = at.matrix @ _placed(style)
        layer, view = at.layer, at.view
        if tag == "g" and (element.get(_MODE) == "layer" or not layer):
            layer = str(element.get(_LABEL) or element.get("id") or layer)
        if tag in ("svg", "symbol") and element is not self._root:
            matrix, view = _viewport(element, matrix, at.view)
        return replace(
            at,
            matrix=matrix,
            view=view,
            layer=layer,
            shown=shown,
            visible=visible,
            seen=shown and visible,
        )

    def _used(self, element: Any, at: _Place) -> Iterator[tuple[Any, _Place]]:
        link = str(element.get(_LINK) or element.get("href") or "")
        target = self._by_id.get(link[1:]) if link.startswith("#") else None
        if target is None or at.uses >= _DEEPEST_USE:
            return
        step = np.eye(3)
        step[:2, 2] = lengths(element, ("x", "y"), at.view)
        name = str(element.get(_LABEL) or element.get("id") or at.name)
        inner = replace(at, matrix=at.matrix @ step, name=name, uses=at.uses + 1)
        yield from self._of(target, inner)

    def _style(self, element: Any, tag: str) -> dict[str, str]:
        """What counts here of its attributes, of the rules of the drawing, and of its own style:
        each goes before the one before it."""
        found = {name: str(element.get(name)) for name in _STYLED if element.get(name)}
        words = str(element.get("class") or "").split()
        names = {tag, f"#{element.get('id')}", *(f".{word}" for word in words)}
        rules = [rule for name in names for rule in self._rules.get(name, ())]
        for _, said in sorted(rules, key=lambda rule: rule[0]):
            found |= said
        return found | _declarations(str(element.get("style") or ""))


_STYLED = ("display", "visibility", "transform", "transform-origin")


def _declarations(text: str) -> dict[str, str]:
    """Of `_STYLED` in a style, in small letters."""
    found = {}
    for each in text.split(";"):
        name, _, value = each.partition(":")
        if name.strip().lower() in _STYLED and value.strip():
            found[name.strip().lower()] = value.replace("!important", "").strip()
    return found


def _style_rules(root: Any) -> dict[str, list[tuple[int, dict[str, str]]]]:
    """Of the style sheets inside: simple selectors (.class, #id, tag), each with what counts here
    and which rule of the drawing it is."""
    found: dict[str, list[tuple[int, dict[str, str]]]] = {}
    rules = 0
    for sheet in root.iter():
        if _tag(sheet) != "style":
            continue
        first, *others = str(sheet.text or "").split("/*")
        text = first + "".join(part.partition("*/")[2] for part in others)
        for rule in text.split("}"):
            selectors, _, body = rule.partition("{")
            if said := _declarations(body):
                rules += 1
                for selector in selectors.split(","):
                    found.setdefault(selector.strip(), []).append((rules, said))
    return found


def _placed(style: dict[str, str]) -> FloatArray:
    """(3, 3) of a transform, about its origin where it has one."""
    if "transform" not in style:
        return np.eye(3)
    matrix = transform_of(style["transform"])
    said = re.findall(rf"{NUMBER}[A-Za-z]*", style.get("transform-origin", ""))
    if len(said) < 2:
        return matrix
    there = np.eye(3)
    there[:2, 2] = [length(word) for word in said[:2]]
    back = there.copy()
    back[:2, 2] *= -1
    return np.asarray(there @ matrix @ back)


def _viewport(
    element: Any, matrix: FloatArray, outer: tuple[float, float]
) -> tuple[FloatArray, tuple[float, float]]:
    """Of a drawing inside the drawing: to its own units, and how wide and high it is in them."""
    x, y, w, h = lengths(element, ("x", "y", "width", "height"), outer)
    w, h = w or outer[0], h or outer[1]
    step = np.eye(3)
    step[:2, 2] = (x, y) if _tag(element) == "svg" else (0.0, 0.0)
    box = [float(n) for n in re.findall(NUMBER, str(element.get("viewBox") or ""))]
    if len(box) != 4 or not (box[2] > 0 and box[3] > 0):
        return np.asarray(matrix @ step), (w, h)
    fit, align = _aspect(element)
    scale = np.array([w / box[2], h / box[3]])
    if fit != "none":
        scale[:] = scale.max() if fit == "slice" else scale.min()
    step[:2, 2] += np.array(align) * (np.array([w, h]) - scale * box[2:])
    step[0, 0], step[1, 1] = scale
    origin = np.eye(3)
    origin[:2, 2] = (-box[0], -box[1])
    return np.asarray(matrix @ step @ origin), (box[2], box[3])


def _aspect(element: Any) -> tuple[str, tuple[float, float]]:
    """none, meet or slice, and where it stands in its place."""
    said = str(element.get("preserveAspectRatio") or "xMidYMid")
    share = {"Min": 0.0, "Mid": 0.5, "Max": 1.0}
    found = re.search(r"x(Min|Mid|Max)Y(Min|Mid|Max)", said)
    fit = next((word for word in ("none", "slice") if word in said), "meet")
    return fit, (0.5, 0.5) if found is None else (share[found.group(1)], share[found.group(2)])


def _image(element: Any, at: _Place) -> SvgImage:
    x, y, w, h = lengths(element, ("x", "y", "width", "height"), at.view)
    corners = np.array([[x, y], [x + w, y], [x + w, y + h], [x, y + h]])
    link = str(element.get(_LINK) or element.get("href") or "")
    if link.startswith("data:") or not link:
        link = str(element.get(_ABSOLUTE) or "")
    fit, align = _aspect(element)
    name = re.split(r"[/\\]", link.partition("?")[0])[-1]
    return SvgImage(moved(corners, at.matrix), name, fit, align)


def _title(element: Any) -> str:
    """What a program shows when the cursor rests on a shape."""
    return next((str(e.text or "").strip() for e in element if _tag(e) == "title"), "")


def _page(root: Any) -> FloatArray | None:
    box = [float(n) for n in re.findall(NUMBER, str(root.get("viewBox") or ""))]
    if len(box) == 4 and box[2] > 0 and box[3] > 0:
        return np.array(box)
    size = [length(text, 0.0) for text in (root.get("width"), root.get("height"))]
    return np.array([0.0, 0.0, *size]) if min(size) > 0 else None


def _tag(element: Any) -> str:
    return str(element.tag).rpartition("}")[2]
