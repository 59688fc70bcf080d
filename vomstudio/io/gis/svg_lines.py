"""Lines and outlines out of SVG, as Inkscape and other programs write it (SVG 1.1, W3C 2011)."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.errors import InputError
from vomstudio.files.regular import read_small
from vomstudio.io.gis.line_reading import ReadLine
from vomstudio.io.text.xml_tree import parse_xml
from vomstudio.words import tr

Array = npt.NDArray[np.float64]

CURVE_STEPS = 16
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_LARGEST = 256 << 20
_MOST_NUMBERS = 500_000
"""Of all paths: what is read in some seconds; hands draw a hundredth of it."""
_LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"
_MODE = "{http://www.inkscape.org/namespaces/inkscape}groupmode"
_NEVER_SEEN = ("defs", "clipPath", "mask", "pattern", "marker", "symbol", "metadata", "namedview")
_MM = {"": 1.0, "px": 1.0, "mm": 96 / 25.4, "cm": 96 / 2.54, "in": 96.0, "pt": 96 / 72, "pc": 16.0}


@dataclass(frozen=True, eq=False)
class SvgDrawing:
    """Coordinates are the file's user units, x right, y down.

    lines : with their transforms applied; images : (4, 2) corners of each picture in it, upper
    left, upper right, lower right, lower left; page : (4,) x, y, width, height; marks : what its
    descriptions say
    """

    lines: tuple[ReadLine, ...]
    images: tuple[Array, ...]
    page: Array | None
    marks: tuple[str, ...]


@np.errstate(all="ignore")
def read_svg(path: str | Path, passed_over: tuple[str, ...] = ()) -> SvgDrawing:
    """Paths (curves as pieces), polylines, polygons, lines and rectangles. passed_over : groups by
    id or label. Raises InputError where the file is no SVG."""
    path = Path(path)
    try:
        data = read_small(path, _LARGEST)
    except OSError as error:
        raise InputError(
            tr("The file cannot be read ({reason}).", reason=error.strerror), file=path
        ) from error
    # Pictures inside are longer than the parser lets an attribute be.
    root = parse_xml(re.sub(rb"""(["'])data:[^"']*""", rb"\1data:", data), path)
    if _tag(root) != "svg":
        raise InputError(tr("This is not an SVG drawing."), file=path)
    lines: list[ReadLine] = []
    images: list[Array] = []
    marks: list[str] = []
    room = _MOST_NUMBERS
    try:
        for element, matrix, layer in _walk(root, np.eye(3), "", passed_over):
            tag = _tag(element)
            if tag == "image":
                x, y, w, h = (_length(element.get(k)) for k in ("x", "y", "width", "height"))
                corners = np.array([[x, y], [x + w, y], [x + w, y + h], [x, y + h]])
                images.append(_moved(corners, matrix))
            elif tag == "desc":
                marks.append(str(element.text or ""))
            else:
                room -= _count_numbers(element)
                if room < 0:
                    raise InputError(
                        tr(
                            "The drawing has more than {limit} numbers, more than anybody draws. "
                            "Simplify its paths.",
                            limit=_MOST_NUMBERS,
                        ),
                        file=path,
                    )
                name = str(element.get(_LABEL) or element.get("id") or "")
                lines += [
                    ReadLine(layer, name, _moved(points, matrix), closed)
                    for points, closed in _shape(element, tag)
                    if len(points) > 1
                ]
    except (ValueError, IndexError, OverflowError) as error:
        raise InputError(
            tr("The drawing has a shape whose coordinates cannot be read; save it again."),
            file=path,
        ) from error
    return SvgDrawing(tuple(lines), tuple(images), _page(root), tuple(marks))


def _walk(
    element: Any, matrix: Array, layer: str, passed_over: tuple[str, ...]
) -> Iterator[tuple[Any, Array, str]]:
    tag = _tag(element)
    style = str(element.get("style") or "").replace(" ", "")
    if tag in _NEVER_SEEN or element.get("display") == "none" or "display:none" in style:
        return
    if tag == "g" and {element.get("id"), element.get(_LABEL)} & set(passed_over):
        return
    matrix = matrix @ transform_of(str(element.get("transform") or ""))
    if tag == "g" and (element.get(_MODE) == "layer" or not layer):
        layer = str(element.get(_LABEL) or element.get("id") or layer)
    yield element, matrix, layer
    for child in element:
        yield from _walk(child, matrix, layer, passed_over)


def transform_of(text: str) -> Array:
    """(3, 3) of an attribute `transform`. Raises ValueError."""
    matrix = np.eye(3)
    for word, inner in re.findall(r"\b(\w+)\s*\(([^()]*)\)", text):
        v = [float(number) for number in re.findall(_NUMBER, inner)]
        step = np.eye(3)
        if word == "matrix":
            step[:2] = np.array(v).reshape(3, 2).T
        elif word == "translate":
            step[:2, 2] = (v[0], v[1] if len(v) > 1 else 0.0)
        elif word == "scale":
            step[0, 0], step[1, 1] = v[0], v[1] if len(v) > 1 else v[0]
        elif word == "rotate":
            c, s = math.cos(math.radians(v[0])), math.sin(math.radians(v[0]))
            step[:2, :2] = ((c, -s), (s, c))
            if len(v) > 2:
                centre = np.array(v[1:3])
                step[:2, 2] = centre - step[:2, :2] @ centre
        elif word == "skewX":
            step[0, 1] = math.tan(math.radians(v[0]))
        elif word == "skewY":
            step[1, 0] = math.tan(math.radians(v[0]))
        matrix = matrix @ step
    return matrix


def _count_numbers(element: Any) -> int:
    """Of its path or points, flags of arcs that stand together as one."""
    texts = [str(element.get(name) or "") for name in ("d", "points")]
    return sum(1 for text in texts for _ in re.finditer(_NUMBER, text))


def _shape(element: Any, tag: str) -> list[tuple[Array, bool]]:
    if tag == "path":
        return _path(str(element.get("d") or ""))
    if tag in ("polyline", "polygon"):
        numbers = [float(n) for n in re.findall(_NUMBER, str(element.get("points") or ""))]
        points = np.array(numbers).reshape(-1, 2)
        return [(_closed(points) if tag == "polygon" else points, tag == "polygon")]
    if tag == "line":
        v = [_length(element.get(k)) for k in ("x1", "y1", "x2", "y2")]
        return [(np.array(v).reshape(2, 2), False)]
    if tag == "rect":
        x, y, w, h = (_length(element.get(k)) for k in ("x", "y", "width", "height"))
        return [(np.array([[x, y], [x + w, y], [x + w, y + h], [x, y + h], [x, y]]), True)]
    return []


def _path(text: str) -> list[tuple[Array, bool]]:
    """The pieces of a path's attribute `d`."""
    words = re.findall(rf"[MmLlHhVvCcSsQqTtAaZz]|{_NUMBER}", _flags_apart(text))
    found: list[tuple[Array, bool]] = []
    points: list[complex] = []
    at = start = control = 0j
    command, k = "", 0

    def take(count: int) -> list[float]:
        nonlocal k
        values = [float(word) for word in words[k : k + count]]
        if len(values) < count:
            raise ValueError(text)
        k += count
        return values

    while k < len(words):
        if words[k].isalpha():
            command = words[k]
            k += 1
        elif command in "Mm":
            command = "L" if command == "M" else "l"
        kind, base = command.upper(), at if command.islower() else 0j
        if kind == "Z":
            if points:
                found.append((_closed(_pairs(points)), True))
            points, at = [], start
            continue
        if kind == "M":
            if len(points) > 1:
                found.append((_pairs(points), False))
            x, y = take(2)
            at = start = control = base + complex(x, y)
            points = [at]
            continue
        if not points:
            points = [at]
        ends, control = _segment(kind, take, base, at, control)
        points += ends
        at = ends[-1]
    if len(points) > 1:
        found.append((_pairs(points), False))
    return found


def _segment(
    kind: str, take: Any, base: complex, at: complex, control: complex
) -> tuple[list[complex], complex]:
    """The points after `at`, and the control point that a smooth continuation mirrors."""
    if kind == "H":
        (x,) = take(1)
        end = complex(x + base.real, at.imag)
        return [end], end
    if kind == "V":
        (y,) = take(1)
        end = complex(at.real, y + base.imag)
        return [end], end
    if kind == "L":
        x, y = take(2)
        end = base + complex(x, y)
        return [end], end
    if kind == "A":
        rx, ry, turn, large, sweep, x, y = take(7)
        end = base + complex(x, y)
        return _arc(at, end, rx, ry, turn, bool(large), bool(sweep)), end
    count = {"C": 3, "S": 2, "Q": 2, "T": 1}[kind]
    v = take(2 * count)
    given = [base + complex(v[2 * i], v[2 * i + 1]) for i in range(count)]
    if kind in "ST":
        given = [2 * at - control, *given]
    corners = [at, *given]
    points = _BERNSTEIN[len(corners)] @ np.array(corners)
    return [*points.tolist()[:-1], given[-1]], given[-2]


def _bernstein(count: int) -> Array:
    """(CURVE_STEPS, count) weights of the corners of a Bezier curve at its points after the first
    (Farin 2002, Curves and Surfaces for CAGD, 5.1)."""
    t = np.linspace(0, 1, CURVE_STEPS + 1)[1:, None]
    k = np.arange(count)
    times = np.array([math.comb(count - 1, i) for i in k])
    return np.asarray(times * t**k * (1 - t) ** (count - 1 - k))


_BERNSTEIN = {count: _bernstein(count) for count in (3, 4)}
_ARC_STEPS = np.linspace(0, 1, 2 * CURVE_STEPS + 1)[1:-1]


def _arc(
    at: complex, end: complex, rx: float, ry: float, turn: float, large: bool, sweep: bool
) -> list[complex]:
    """An elliptical arc from its ends: SVG 1.1, F.6.5."""
    rx, ry = abs(rx), abs(ry)
    if rx == 0 or ry == 0 or at == end:
        return [end]
    axis = complex(math.cos(math.radians(turn)), math.sin(math.radians(turn)))
    half = (at - end) / 2 / axis
    x, y = half.real, half.imag
    grow = (x / rx) ** 2 + (y / ry) ** 2
    if grow > 1:
        rx, ry = rx * math.sqrt(grow), ry * math.sqrt(grow)
    square = (rx * ry) ** 2 / ((rx * y) ** 2 + (ry * x) ** 2) - 1
    root = math.sqrt(max(square, 0.0)) * (-1 if large == sweep else 1)
    middle = complex(root * rx * y / ry, -root * ry * x / rx)
    centre = middle * axis + (at + end) / 2
    first, last = (
        math.atan2((v - middle).imag / ry, (v - middle).real / rx) for v in (half, -half)
    )
    sweep_rad = (last - first) % (2 * math.pi)
    if not sweep:
        sweep_rad -= 2 * math.pi
    angles = first + sweep_rad * _ARC_STEPS
    points = (rx * np.cos(angles) + 1j * ry * np.sin(angles)) * axis + centre
    return [*points.tolist(), end]


def _flags_apart(text: str) -> str:
    """The two flags of an arc may stand together with what follows: `a1 1 0 01.5 2`."""

    def apart(match: re.Match[str]) -> str:
        number, gap = rf"({_NUMBER})", r"[\s,]*"
        form = (
            rf"{number}{gap}{number}{gap}{number}{gap}([01]){gap}([01]){gap}{number}{gap}{number}"
        )
        return match.group(1) + re.sub(form, r" \1 \2 \3 \4 \5 \6 \7 ", match.group(2))

    return re.sub(r"([Aa])([^A-DF-Za-df-z]*)", apart, text)


def _pairs(points: list[complex]) -> Array:
    values = np.array(points)
    return np.stack([values.real, values.imag], axis=1)


def _closed(points: Array) -> Array:
    if len(points) and (points[0] != points[-1]).any():
        return np.concatenate([points, points[:1]])
    return points


def _moved(points: Array, matrix: Array) -> Array:
    return np.asarray(points @ matrix[:2, :2].T + matrix[:2, 2])


def _page(root: Any) -> Array | None:
    box = [float(n) for n in re.findall(_NUMBER, str(root.get("viewBox") or ""))]
    if len(box) == 4 and box[2] > 0 and box[3] > 0:
        return np.array(box)
    size = [_length(root.get(k)) for k in ("width", "height")]
    return np.array([0.0, 0.0, *size]) if min(size) > 0 else None


def _length(text: str | None) -> float:
    """In user units; 0 where nothing is said."""
    found = re.match(rf"\s*({_NUMBER})\s*([a-z]*)", text or "")
    if found is None:
        return 0.0
    return float(found.group(1)) * _MM.get(found.group(2), 1.0)


def _tag(element: Any) -> str:
    return str(element.tag).rpartition("}")[2]
