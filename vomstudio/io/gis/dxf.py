"""Drawings for CAD: DXF of release 12 (1992), which every program reads, as text written on the
go. Coordinates are the shortest decimals that give back each double.

Written here because libraries were measured to be slower or to lose something (two busy cores).
200,000 points took 0.9 s and 33 MB; ezdxf 1.4.5 18 s and 187 MB; its r12writer 3.0 s, coordinates
rounded to 1e-6, without colours of layers and without extended data; GDAL 4.4 s, coordinates off by
5e-9, neither. 100 planes with traces, discs and their figures took 0.15 s, with ezdxf 1.0 s, of
which its import is 0.3; 2000 took 2.8 s, with ezdxf 12.9. The files are read back by ezdxf and by
GDAL in the tests, every double the same.
"""

from __future__ import annotations

import functools
import itertools
import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TextIO

import numpy as np

from vomstudio.core.arrays import AnyArray, ByteArray

APPLICATION = "VOMSTUDIO"
LONGEST_NAME, LONGEST_TEXT = 31, 250
WHITE = 7
METRES = 6
POLYLINE_3D, CLOSED, VERTEX_3D = 8, 1, 32


def plain_text(text: str) -> str:
    """On one line of ASCII; other letters as DXF spells them."""
    flat = " ".join(text.split())
    return "".join(c if " " <= c <= "~" else _escaped(c) for c in flat)


def _escaped(letter: str) -> str:
    code = ord(letter)
    return f"\\U+{code:04X}" if code <= 0xFFFF else "?"


def layer_names(names: Iterable[str]) -> dict[str, str]:
    """A name that DXF of release 12 allows for each, in plain letters, none twice (compared without
    case)."""
    used: set[str] = set()
    result: dict[str, str] = {}
    for name in names:
        if name in result:
            continue
        # Accents go, as far as letters come apart from them.
        letters = unicodedata.normalize("NFKD", name.strip())
        letters = "".join(c for c in letters if not unicodedata.combining(c))
        plain = re.sub(r"[^\w$-]", "_", letters, flags=re.ASCII) or "layer"
        number, label = 1, plain[:LONGEST_NAME]
        while label.casefold() in used:
            number += 1
            label = f"{plain[: LONGEST_NAME - 4]}_{number}"
        used.add(label.casefold())
        result[name] = label
    return result


class Drawing:
    """Writes a drawing into an open file: the constructor its head, `close` its end."""

    def __init__(
        self,
        file: TextIO,
        layers: Mapping[str, int],
        bounds: AnyArray | None,
        comment: str = "",
        *,
        metric: bool,
    ) -> None:
        """layers : colour number by name, as from `layer_names`; bounds : (2, 3); metric : the unit
        is the metre, else nobody knows it"""
        self._file = file
        say = self._say
        if comment:
            say((999, plain_text(comment)[:LONGEST_TEXT]))
        say((0, "SECTION"), (2, "HEADER"), (9, "$ACADVER"), (1, "AC1009"))
        if metric:
            # Of later releases; a program that knows it not passes over it.
            say((9, "$INSUNITS"), (70, METRES))
        if bounds is not None:
            for name, corner in zip(("$EXTMIN", "$EXTMAX"), bounds.tolist(), strict=True):
                say((9, name), *zip((10, 20, 30), corner, strict=True))
        say((0, "ENDSEC"), (0, "SECTION"), (2, "TABLES"))
        say((0, "TABLE"), (2, "LTYPE"), (70, 1))
        say((0, "LTYPE"), (2, "CONTINUOUS"), (70, 0), (3, "Solid line"), (72, 65), (73, 0))
        say((40, 0.0), (0, "ENDTAB"), (0, "TABLE"), (2, "LAYER"), (70, len(layers) + 1))
        for name, color in {"0": WHITE, **layers}.items():
            say((0, "LAYER"), (2, plain_text(name)), (70, 0), (62, color), (6, "CONTINUOUS"))
        say((0, "ENDTAB"), (0, "TABLE"), (2, "APPID"), (70, 1))
        say((0, "APPID"), (2, APPLICATION), (70, 0), (0, "ENDTAB"), (0, "ENDSEC"))
        say((0, "SECTION"), (2, "ENTITIES"))

    def close(self) -> None:
        self._say((0, "ENDSEC"), (0, "EOF"))

    def points(self, points: AnyArray, layer: str, colors: AnyArray | None = None) -> None:
        """(n, 3) points; colors : (n,) colour numbers, those of the layer without."""
        if not len(points):
            return
        name = plain_text(layer).replace("%", "%%")
        columns = [points[:, k].tolist() for k in range(3)]
        form = f"0\nPOINT\n8\n{name}\n"
        if colors is not None:
            form += "62\n%d\n"
            columns.insert(0, colors.tolist())
        form += "10\n%r\n20\n%r\n30\n%r\n"
        self._file.write("".join(map(form.__mod__, zip(*columns, strict=True))))

    def point(self, point: AnyArray, layer: str, values: Mapping[str, Any]) -> None:
        self._say((0, "POINT"), (8, plain_text(layer)), *_place(point))
        self._values(values)

    def polyline(
        self, points: AnyArray, layer: str, values: Mapping[str, Any], closed: bool = False
    ) -> None:
        name = plain_text(layer)
        flags = POLYLINE_3D | (CLOSED if closed else 0)
        self._say((0, "POLYLINE"), (8, name), (66, 1), *_place(np.zeros(3)), (70, flags))
        self._values(values)
        for point in points:
            self._say((0, "VERTEX"), (8, name), *_place(point), (70, VERTEX_3D))
        self._say((0, "SEQEND"), (8, name))

    def line(self, points: AnyArray, layer: str) -> None:
        """Straight lines from point to point (n, 3); they have no figures."""
        for start, end in itertools.pairwise(points):
            self._say((0, "LINE"), (8, plain_text(layer)), *_place(start))
            self._say(*zip((11, 21, 31), end.tolist(), strict=True))

    def text(self, point: AnyArray, words: str, height: float, layer: str) -> None:
        """Words centred at a point (3,), upright on the map."""
        self._say((0, "TEXT"), (8, plain_text(layer)), *_place(point), (40, height))
        self._say((1, plain_text(words)), (72, 1), (73, 2))
        self._say(*zip((11, 21, 31), point.tolist(), strict=True))

    def faces(self, corners: AnyArray, layer: str) -> None:
        """(n, 3 or 4, 3) corners of triangles or flat quadrilaterals."""
        if not len(corners):
            return
        four = corners if corners.shape[1] == 4 else corners[:, [0, 1, 2, 2]]
        form = "0\n3DFACE\n8\n" + plain_text(layer).replace("%", "%%") + "\n"
        form += "".join(f"{10 + k}\n%r\n{20 + k}\n%r\n{30 + k}\n%r\n" for k in range(4))
        columns = four.reshape(-1, 12).T.tolist()
        self._file.write("".join(map(form.__mod__, zip(*columns, strict=True))))

    def _values(self, values: Mapping[str, Any]) -> None:
        """As extended data: one text `name=value` for each."""
        said = [f"{name}={_shown(value)}" for name, value in values.items() if _is_there(value)]
        if said:
            texts = [(1000, plain_text(text)[:LONGEST_TEXT]) for text in said]
            self._say((1001, APPLICATION), *texts)

    def _say(self, *groups: tuple[int, Any]) -> None:
        self._file.write("".join(f"{code}\n{_shown(value)}\n" for code, value in groups))


def _place(point: AnyArray) -> Sequence[tuple[int, float]]:
    return list(zip((10, 20, 30), point.tolist(), strict=True))


def _is_there(value: Any) -> bool:
    if value is None or value == "":
        return False
    return not (isinstance(value, float | np.floating) and not np.isfinite(value))


def _shown(value: Any) -> str:
    if isinstance(value, bool | np.bool_):
        return str(int(value))
    if isinstance(value, float | np.floating):
        return repr(float(value))
    return str(value)


# --- colour numbers ----------------------------------------------------------------------------


@functools.cache
def _palette() -> AnyArray:
    """(255, 3) RGB of the colour numbers from 1: 24 hues in ten shades each, and greys."""
    first = [
        (255, 0, 0),
        (255, 255, 0),
        (0, 255, 0),
        (0, 255, 255),
        (0, 0, 255),
        (255, 0, 255),
        (255, 255, 255),
        (128, 128, 128),
        (192, 192, 192),
    ]
    shades = []
    for number in range(10, 250):
        hue, value = (number // 10 - 1) / 4.0, (255, 165, 127, 76, 38)[number % 10 // 2]
        saturation = 0.5 if number % 2 else 1.0
        sectors = (np.array([5.0, 3.0, 1.0]) + hue) % 6
        strength = np.clip(np.minimum(sectors, 4 - sectors), 0, 1)
        shades.append(tuple((value * (1 - saturation * strength)).astype(int).tolist()))
    greys = [(g, g, g) for g in (0, 101, 102, 153, 204, 255)]
    return np.array([*first, *shades, *greys], np.float64)


@functools.cache
def color_table() -> AnyArray:
    """Return RGB (256, 3) by colour number; number 0 is white."""
    return np.concatenate([[[255, 255, 255]], _palette()]).astype(np.uint8)


@functools.cache
def _nearest() -> ByteArray:
    """The colour number nearest to each of 32 x 32 x 32 colours."""
    from scipy.spatial import cKDTree

    steps = np.arange(32) * 255.0 / 31.0
    cube = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), -1).reshape(-1, 3)
    _, rows = cKDTree(_palette()).query(cube)
    return np.asarray((rows + 1).astype(np.uint8))


def color_numbers(rgb: ByteArray) -> ByteArray:
    """(n,) numbers of the nearest colours that release 12 has."""
    r, g, b = (rgb.astype(np.int32) * 31 + 127).T // 255
    numbers: ByteArray = _nearest()[(r * 32 + g) * 32 + b]
    return numbers


def color_number(hex_: str) -> int:
    """Of "#rrggbb"; white (black on paper) where it is none."""
    if not re.fullmatch(r"#[0-9a-fA-F]{6}", hex_):
        return WHITE
    rgb = np.array([[int(hex_[k : k + 2], 16) for k in (1, 3, 5)]], np.uint8)
    return int(color_numbers(rgb)[0])
