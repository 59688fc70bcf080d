"""Shapes and transforms of SVG as points (SVG 1.1, W3C 2011)."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray

Piece = tuple[FloatArray, bool]
"""Points (n, 2) and whether they close."""

CURVE_STEPS = 16
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_UNITS = {"": 1.0, "px": 1.0, "mm": 96 / 25.4, "cm": 96 / 2.54, "in": 96.0, "pt": 96 / 72}
_UNITS |= {"pc": 16.0, "q": 96 / 101.6}


_ANGLES = {"": 1.0, "deg": 1.0, "rad": math.degrees(1.0), "grad": 0.9, "turn": 360.0}


def transform_of(text: str) -> FloatArray:
    """(3, 3) of an attribute or a style `transform`. Raises ValueError."""
    matrix = np.eye(3)
    for word, inner in re.findall(r"\b(\w+)\s*\(([^()]*)\)", text):
        said = re.findall(rf"({NUMBER})\s*([A-Za-z]*)", inner)
        first = said[0][1].lower() if said else ""
        v = [float(number) * _UNITS.get(unit.lower(), 1.0) for number, unit in said]
        step = np.eye(3)
        if word == "matrix":
            step[:2] = np.array(v).reshape(3, 2).T
        elif word in ("translate", "translateX"):
            step[:2, 2] = (v[0], v[1] if len(v) > 1 else 0.0)
        elif word == "translateY":
            step[1, 2] = v[0]
        elif word == "scale":
            step[0, 0], step[1, 1] = v[0], v[1] if len(v) > 1 else v[0]
        elif word in ("scaleX", "scaleY"):
            step["XY".index(word[-1]), "XY".index(word[-1])] = v[0]
        elif word in ("rotate", "rotateZ"):
            turn = math.radians(v[0] * _ANGLES.get(first, 1.0))
            c, s = math.cos(turn), math.sin(turn)
            step[:2, :2] = ((c, -s), (s, c))
            if len(v) > 2:
                centre = np.array(v[1:3])
                step[:2, 2] = centre - step[:2, :2] @ centre
        elif word in ("skewX", "skewY"):
            lean = math.tan(math.radians(v[0] * _ANGLES.get(first, 1.0)))
            step[(0, 1) if word == "skewX" else (1, 0)] = lean
        matrix = matrix @ step
    return matrix


def numbers_in(element: Any) -> int:
    """Of its path or points, flags of arcs that stand together as one."""
    texts = [str(element.get(name) or "") for name in ("d", "points")]
    return sum(1 for text in texts for _ in re.finditer(NUMBER, text))


def shape_of(element: Any, tag: str, view: tuple[float, float] = (100.0, 100.0)) -> list[Piece]:
    """The pieces of a path, polyline, polygon, line, rectangle, circle or ellipse; none of anything
    else. view : width and height of what surrounds it, of which lengths may be hundredths. Raises
    ValueError, IndexError."""
    if tag == "path":
        return _path(str(element.get("d") or ""))
    if tag in ("polyline", "polygon"):
        numbers = [float(n) for n in re.findall(NUMBER, str(element.get("points") or ""))]
        points = np.array(numbers).reshape(-1, 2)
        return [(_closed(points) if tag == "polygon" else points, tag == "polygon")]
    if tag == "line":
        v = lengths(element, ("x1", "y1", "x2", "y2"), view)
        return [(np.array(v).reshape(2, 2), False)]
    if tag == "rect":
        return _rectangle(element, view)
    if tag in ("circle", "ellipse"):
        cx, cy = lengths(element, ("cx", "cy"), view)
        if tag == "circle":
            rx = ry = length(element.get("r"), math.hypot(*view) / math.sqrt(2))
        else:
            rx, ry = lengths(element, ("rx", "ry"), view)
        if rx <= 0 or ry <= 0:
            return []
        t = np.linspace(0.0, 2.0 * math.pi, 4 * CURVE_STEPS + 1)
        ring = np.stack([cx + rx * np.cos(t), cy + ry * np.sin(t)], axis=1)
        ring[-1] = ring[0]
        return [(ring, True)]
    return []


def _rectangle(element: Any, view: tuple[float, float]) -> list[Piece]:
    x, y, w, h, rx, ry = lengths(element, ("x", "y", "width", "height", "rx", "ry"), view)
    if w <= 0 or h <= 0:
        return []
    # One radius stands for both; neither reaches beyond the middle of its side.
    rx, ry = min(rx or ry, w / 2), min(ry or rx, h / 2)
    if rx <= 0 or ry <= 0:
        return [(np.array([[x, y], [x + w, y], [x + w, y + h], [x, y + h], [x, y]]), True)]
    quarter = np.linspace(0.0, 0.5 * math.pi, CURVE_STEPS + 1)
    middles = (
        (x + w - rx, y + h - ry),
        (x + rx, y + h - ry),
        (x + rx, y + ry),
        (x + w - rx, y + ry),
    )
    arcs = [
        np.stack([mx + rx * np.cos(quarter + turn), my + ry * np.sin(quarter + turn)], axis=1)
        for (mx, my), turn in zip(middles, np.arange(4) * 0.5 * math.pi, strict=True)
    ]
    return [(_closed(np.concatenate(arcs)), True)]


def _path(text: str) -> list[tuple[FloatArray, bool]]:
    """The pieces of a path's attribute `d`."""
    words = re.findall(rf"[MmLlHhVvCcSsQqTtAaZz]|{NUMBER}", _flags_apart(text))
    found: list[tuple[FloatArray, bool]] = []
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
        elif command in "Zz":
            # Nothing but a command may follow the end of a piece, and none comes before the first.
            raise ValueError(text)
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


def _bernstein(count: int) -> FloatArray:
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
    return re.sub(r"([Aa])([^A-DF-Za-df-z]*)", lambda arc: f"{arc[1]} {_arc_numbers(arc[2])}", text)


def _arc_numbers(text: str) -> str:
    """Seven by seven: two radii, a turn, two flags, an end."""
    found: list[str] = []
    at = 0
    # One pattern for all seven would try every way to cut a long number into several.
    while said := (_FLAG if len(found) % 7 in (3, 4) else _ONE).match(text, at):
        found.append(said[1])
        at = said.end()
    return " ".join([*found, text[at:]])


_FLAG, _ONE = re.compile(r"[\s,]*([01])"), re.compile(rf"[\s,]*({NUMBER})")


def _pairs(points: list[complex]) -> FloatArray:
    values = np.array(points)
    return np.stack([values.real, values.imag], axis=1)


def _closed(points: FloatArray) -> FloatArray:
    if len(points) and (points[0] != points[-1]).any():
        return np.concatenate([points, points[:1]])
    return points


def moved(points: FloatArray, matrix: FloatArray) -> FloatArray:
    return np.asarray(points @ matrix[:2, :2].T + matrix[:2, 2])


def lengths(element: Any, names: tuple[str, ...], view: tuple[float, float]) -> list[float]:
    """Of attributes in user units, 0 where nothing is said."""
    down = ("y", "height", "y1", "y2", "cy", "ry")
    return [length(element.get(name), view[1] if name in down else view[0]) for name in names]


def length(text: str | None, whole: float = 100.0) -> float:
    """In user units; 0 where nothing is said. whole : of which it may be hundredths"""
    found = re.match(rf"\s*({NUMBER})\s*(%|[A-Za-z]*)", text or "")
    if found is None:
        return 0.0
    value, unit = float(found.group(1)), found.group(2).lower()
    return value * whole / 100.0 if unit == "%" else value * _UNITS.get(unit, 1.0)
