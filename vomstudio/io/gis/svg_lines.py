"""Lines and outlines from SVG files of Inkscape and other programs (SVG 1.1, W3C 2011)."""

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
from vomstudio.core.files.regular import read_small_file
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.io.gis.line_reading import FeatureAttributes, GisLine
from vomstudio.io.gis.svg_paths import (
    NUMBER,
    count_numbers,
    element_pieces,
    parse_length,
    parse_lengths,
    parse_transform,
    transform_points,
)
from vomstudio.io.text.xml_tree import parse_xml

PROGRAM_CLASS = "vomstudio"
"""Class of non-line elements in this program's drawings: frames, symbols and labels."""
_MAX_BYTES = 256 << 20
_MAX_NUMBERS = 500_000
"""Maximum in all paths, read in a few seconds; hand drawings have about 1 % of it."""
_LABEL_ATTRIBUTE = "{http://www.inkscape.org/namespaces/inkscape}label"
_MODE_ATTRIBUTE = "{http://www.inkscape.org/namespaces/inkscape}groupmode"
_ABSOLUTE_PATH_ATTRIBUTE = "{http://sodipodi.sourceforge.net/DTD/sodipodi-0.dtd}absref"
_LINK_ATTRIBUTE = "{http://www.w3.org/1999/xlink}href"
_FEATURE_ATTRIBUTES = ("id", "data-kind", "data-set")
_INVISIBLE_TAGS = (
    "defs",
    "clipPath",
    "mask",
    "pattern",
    "marker",
    "metadata",
    "namedview",
    "style",
)
_MAX_CLONE_DEPTH = 8
_MAX_SHAPES = 1_000_000


@dataclass(frozen=True, eq=False)
class SvgImage:
    """Picture in a drawing.

    Parameters
    ----------
    corners : (4, 2) float
        Corners of the frame in drawing units: upper left, upper right, lower right, lower left.
    name : str
        File name, or "" for an embedded picture.
    fit : {"none", "meet", "slice"}
        Whether the picture is stretched to the frame, fitted inside it, or covers all of it.
    align : tuple of float
        Horizontal and vertical alignment, 0 to 1.
    """

    corners: FloatArray
    name: str
    fit: str
    align: tuple[float, float]

    def fitted_corners(self, ratio: float) -> FloatArray:
        """Return the corners (4, 2) of the picture inside its frame.

        Parameters
        ----------
        ratio : float
            Width of the picture divided by its height.
        """
        width_vector, height_vector = (
            self.corners[1] - self.corners[0],
            self.corners[3] - self.corners[0],
        )
        width, height = float(np.hypot(*width_vector)), float(np.hypot(*height_vector))
        if self.fit == "none" or not (width > 0 and height > 0):
            return self.corners
        limit = max if self.fit == "slice" else min
        x, y = limit(height * ratio / width, 1.0), limit(width / ratio / height, 1.0)
        offset = (
            self.corners[0]
            + self.align[0] * (1 - x) * width_vector
            + self.align[1] * (1 - y) * height_vector
        )
        return np.array(
            [
                offset,
                offset + x * width_vector,
                offset + x * width_vector + y * height_vector,
                offset + y * height_vector,
            ]
        )


@dataclass(frozen=True, eq=False)
class SvgDrawing:
    """Content of a drawing in user units of the file, with x to the right and y down.

    Parameters
    ----------
    lines : tuple of GisLine
        Visible lines with their transforms applied.
    images : tuple of SvgImage
        Pictures, including hidden ones because lines may have been drawn on them.
    page : (4,) float or None
        x, y, width and height of the page.
    marks : tuple of str
        Descriptions in the drawing.
    """

    lines: tuple[GisLine, ...]
    images: tuple[SvgImage, ...]
    page: FloatArray | None
    marks: tuple[str, ...]


@np.errstate(all="ignore")
def read_svg(path: str | Path) -> SvgDrawing:
    """Read the shapes of a drawing, including clones.

    Shapes are paths (curves are split), polylines, polygons, lines, rectangles, circles and
    ellipses.

    Raises
    ------
    InputError
        If the file is not valid SVG.
    """
    path = Path(path)
    root = parse_xml(_simplify_svg(_content(path), path), path)
    if _tag(root) != "svg":
        raise InputError(Finding("file.other-format", format="SVG"), file=path)
    lines: list[GisLine] = []
    images: list[SvgImage] = []
    marks = [str(element.text or "") for element in root.iter() if _tag(element) == "desc"]
    remaining_numbers = _MAX_NUMBERS
    try:
        for element, context in _ElementWalk(root).iterate():
            tag = _tag(element)
            if tag == "image":
                images.append(_image(element, context))
            elif tag != "desc" and context.is_visible:
                remaining_numbers -= count_numbers(element)
                if remaining_numbers < 0:
                    raise InputError(
                        Finding("file.too-many-parts", limit=_MAX_NUMBERS, parts=tr("numbers")),
                        file=path,
                    )
                name = str(
                    element.get(_LABEL_ATTRIBUTE)
                    or _title(element)
                    or element.get("id")
                    or context.name
                )
                words = FeatureAttributes(
                    *(str(element.get(key) or "") for key in _FEATURE_ATTRIBUTES)
                )
                lines += [
                    GisLine(
                        context.layer,
                        name,
                        transform_points(points, context.matrix),
                        is_closed,
                        words=words,
                    )
                    for points, is_closed in element_pieces(element, tag, context.view)
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
    """Read a file that may be compressed (.svgz). Raises InputError."""
    size_error = InputError(Finding("file.too-large", limit_mb=_MAX_BYTES >> 20), file=path)
    try:
        data = read_small_file(path, _MAX_BYTES)
    except OSError as error:
        reason = error.strerror or error
        raise InputError(Finding("file.unreadable", reason=reason), file=path) from error
    if not data.startswith(b"\x1f\x8b"):
        return data
    try:
        with gzip.GzipFile(fileobj=io.BytesIO(data)) as compressed_file:
            data = compressed_file.read(_MAX_BYTES + 1)
    except (OSError, EOFError, zlib.error) as error:
        damage_finding = Finding("file.damaged", format="SVG", reason=error)
        raise InputError(damage_finding, file=path) from error
    if len(data) > _MAX_BYTES:
        raise size_error
    return data


_DOCTYPE = re.compile(rb"<!DOCTYPE\s+svg\b[^\[>]*(?:\[([^\]]*)\]\s*)?>")
_ENTITY = re.compile(
    rb"<!ENTITY\s+([\w.-]{1,64})\s+(?:\"([^\"&%<]{0,200})\"|'([^'&%<]{0,200})')\s*>"
)
_MAX_ENTITIES = 64


def _simplify_svg(data: bytes, path: Path) -> bytes:
    """Remove embedded pictures and expand entities.

    Embedded pictures exceed the parser's limit for attributes, and Illustrator declares entities
    for its namespaces. Raises InputError if the result is too large.
    """
    data = re.sub(rb"""(["'])data:[^"']*""", rb"\1data:", data)
    doctype = _DOCTYPE.search(data[:65_536])
    if doctype is None or not doctype.group(1):
        return data
    entities = _ENTITY.findall(doctype.group(1))
    if len(entities) > _MAX_ENTITIES or _ENTITY.sub(b"", doctype.group(1)).strip():
        return data
    body = data[doctype.end() :]
    for name, double_quoted_text, single_quoted_text in entities:
        body = body.replace(b"&" + name + b";", double_quoted_text or single_quoted_text)
        if len(body) > _MAX_BYTES:
            raise InputError(Finding("file.too-large", limit_mb=_MAX_BYTES >> 20), file=path)
    return data[: doctype.start()] + body


@dataclass(frozen=True, eq=False)
class _Context:
    """Context of an element.

    Parameters
    ----------
    matrix : (3, 3) float
        Transformation to drawing units.
    view : tuple of float
        Width and height of the innermost viewport.
    name : str
        Name of the clone.
    is_visible : bool
        Whether both `is_displayed` and `has_visibility` are True.
    is_displayed, has_visibility : bool
        Inherited values of display and visibility.
    uses : int
        Nesting depth of clones.
    """

    matrix: FloatArray
    view: tuple[float, float]
    layer: str = ""
    name: str = ""
    is_visible: bool = True
    is_displayed: bool = True
    has_visibility: bool = True
    uses: int = 0


class _ElementWalk:
    """Iterator over all elements of a drawing with their contexts."""

    def __init__(self, root: Any) -> None:
        self._root = root
        self._elements = {
            str(element.get("id")): element for element in root.iter() if element.get("id")
        }
        self._rules = _style_rules(root)
        self._count = 0

    def iterate(self) -> Iterator[tuple[Any, _Context]]:
        page = _page(self._root)
        view = (100.0, 100.0) if page is None else (float(page[2]), float(page[3]))
        return self._walk(self._root, _Context(np.eye(3), view))

    def _walk(self, element: Any, context: _Context) -> Iterator[tuple[Any, _Context]]:
        tag = _tag(element)
        if tag in _INVISIBLE_TAGS or PROGRAM_CLASS in str(element.get("class") or "").split():
            return
        if tag == "symbol" and not context.uses:
            return
        self._count += 1
        if self._count > _MAX_SHAPES:
            raise ValueError("too many shapes")
        context = self._child_context(element, tag, context)
        yield element, context
        if tag == "use":
            yield from self._clone(element, context)
        for child in element:
            yield from self._walk(child, context)

    def _child_context(self, element: Any, tag: str, context: _Context) -> _Context:
        """Return the context of an element, which also applies to its children."""
        style = self._style(element, tag)
        is_displayed = context.is_displayed and style.get("display") != "none"
        has_visibility = context.has_visibility
        if "visibility" in style:
            has_visibility = style["visibility"] not in ("hidden", "collapse")
        matrix = context.matrix @ _transform_matrix(style)
        layer, view = context.layer, context.view
        if tag == "g" and (element.get(_MODE_ATTRIBUTE) == "layer" or not layer):
            layer = str(element.get(_LABEL_ATTRIBUTE) or element.get("id") or layer)
        if tag in ("svg", "symbol") and element is not self._root:
            matrix, view = _viewport(element, matrix, context.view)
        return replace(
            context,
            matrix=matrix,
            view=view,
            layer=layer,
            is_displayed=is_displayed,
            has_visibility=has_visibility,
            is_visible=is_displayed and has_visibility,
        )

    def _clone(self, element: Any, context: _Context) -> Iterator[tuple[Any, _Context]]:
        link = str(element.get(_LINK_ATTRIBUTE) or element.get("href") or "")
        target = self._elements.get(link[1:]) if link.startswith("#") else None
        if target is None or context.uses >= _MAX_CLONE_DEPTH:
            return
        step = np.eye(3)
        step[:2, 2] = parse_lengths(element, ("x", "y"), context.view)
        name = str(element.get(_LABEL_ATTRIBUTE) or element.get("id") or context.name)
        inner_context = replace(
            context, matrix=context.matrix @ step, name=name, uses=context.uses + 1
        )
        yield from self._walk(target, inner_context)

    def _style(self, element: Any, tag: str) -> dict[str, str]:
        """Return the style, in increasing priority: attributes, style rules, style attribute."""
        properties = {
            name: str(element.get(name)) for name in _STYLE_PROPERTIES if element.get(name)
        }
        classes = str(element.get("class") or "").split()
        names = {tag, f"#{element.get('id')}", *(f".{word}" for word in classes)}
        rules = [rule for name in names for rule in self._rules.get(name, ())]
        for _, rule_properties in sorted(rules, key=lambda rule: rule[0]):
            properties |= rule_properties
        return properties | _declarations(str(element.get("style") or ""))


_STYLE_PROPERTIES = ("display", "visibility", "transform", "transform-origin")


def _declarations(text: str) -> dict[str, str]:
    """Return the properties of a style that are in `_STYLE_PROPERTIES`, in lower case."""
    properties = {}
    for item in text.split(";"):
        name, _, value = item.partition(":")
        if name.strip().lower() in _STYLE_PROPERTIES and value.strip():
            properties[name.strip().lower()] = value.replace("!important", "").strip()
    return properties


def _style_rules(root: Any) -> dict[str, list[tuple[int, dict[str, str]]]]:
    """Return the rules of embedded style sheets by selector (.class, #id, tag).

    Each rule consists of its number in the drawing and its properties.
    """
    rules_by_selector: dict[str, list[tuple[int, dict[str, str]]]] = {}
    rule_count = 0
    for sheet in root.iter():
        if _tag(sheet) != "style":
            continue
        first_part, *other_parts = str(sheet.text or "").split("/*")
        text = first_part + "".join(part.partition("*/")[2] for part in other_parts)
        for rule in text.split("}"):
            selectors, _, body = rule.partition("{")
            if properties := _declarations(body):
                rule_count += 1
                for selector in selectors.split(","):
                    rules_by_selector.setdefault(selector.strip(), []).append(
                        (rule_count, properties)
                    )
    return rules_by_selector


def _transform_matrix(style: dict[str, str]) -> FloatArray:
    """Return the matrix (3, 3) of a transform, about its origin if it has one."""
    if "transform" not in style:
        return np.eye(3)
    matrix = parse_transform(style["transform"])
    origin = re.findall(rf"{NUMBER}[A-Za-z]*", style.get("transform-origin", ""))
    if len(origin) < 2:
        return matrix
    shift = np.eye(3)
    shift[:2, 2] = [parse_length(word) for word in origin[:2]]
    inverse_shift = shift.copy()
    inverse_shift[:2, 2] *= -1
    return np.asarray(shift @ matrix @ inverse_shift)


def _viewport(
    element: Any, matrix: FloatArray, outer_view: tuple[float, float]
) -> tuple[FloatArray, tuple[float, float]]:
    """Return the matrix to the units of an inner viewport, and its size in these units."""
    x, y, width, height = parse_lengths(element, ("x", "y", "width", "height"), outer_view)
    width, height = width or outer_view[0], height or outer_view[1]
    step = np.eye(3)
    step[:2, 2] = (x, y) if _tag(element) == "svg" else (0.0, 0.0)
    box = [float(n) for n in re.findall(NUMBER, str(element.get("viewBox") or ""))]
    if len(box) != 4 or not (box[2] > 0 and box[3] > 0):
        return np.asarray(matrix @ step), (width, height)
    fit, align = _aspect(element)
    scale = np.array([width / box[2], height / box[3]])
    if fit != "none":
        scale[:] = scale.max() if fit == "slice" else scale.min()
    step[:2, 2] += np.array(align) * (np.array([width, height]) - scale * box[2:])
    step[0, 0], step[1, 1] = scale
    origin = np.eye(3)
    origin[:2, 2] = (-box[0], -box[1])
    return np.asarray(matrix @ step @ origin), (box[2], box[3])


def _aspect(element: Any) -> tuple[str, tuple[float, float]]:
    """Return the fit (none, meet or slice) and the alignment inside the frame."""
    text = str(element.get("preserveAspectRatio") or "xMidYMid")
    alignments = {"Min": 0.0, "Mid": 0.5, "Max": 1.0}
    match = re.search(r"x(Min|Mid|Max)Y(Min|Mid|Max)", text)
    fit = next((word for word in ("none", "slice") if word in text), "meet")
    return fit, (0.5, 0.5) if match is None else (
        alignments[match.group(1)],
        alignments[match.group(2)],
    )


def _image(element: Any, context: _Context) -> SvgImage:
    x, y, width, height = parse_lengths(element, ("x", "y", "width", "height"), context.view)
    corners = np.array([[x, y], [x + width, y], [x + width, y + height], [x, y + height]])
    link = str(element.get(_LINK_ATTRIBUTE) or element.get("href") or "")
    if link.startswith("data:") or not link:
        link = str(element.get(_ABSOLUTE_PATH_ATTRIBUTE) or "")
    fit, align = _aspect(element)
    name = re.split(r"[/\\]", link.partition("?")[0])[-1]
    return SvgImage(transform_points(corners, context.matrix), name, fit, align)


def _title(element: Any) -> str:
    """Return the title of a shape, which programs display as a tooltip."""
    return next((str(child.text or "").strip() for child in element if _tag(child) == "title"), "")


def _page(root: Any) -> FloatArray | None:
    box = [float(n) for n in re.findall(NUMBER, str(root.get("viewBox") or ""))]
    if len(box) == 4 and box[2] > 0 and box[3] > 0:
        return np.array(box)
    size = [parse_length(text, 0.0) for text in (root.get("width"), root.get("height"))]
    return np.array([0.0, 0.0, *size]) if min(size) > 0 else None


def _tag(element: Any) -> str:
    return str(element.tag).rpartition("}")[2]
