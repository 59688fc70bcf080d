"""Values of a model as colours: which field, over which range, through which map. numpy only.

A field is a name of `PointCloud.fields` or `Mesh.fields`, or ELEVATION, the height in World, which
every model has. How it is shown follows from what it is: categories where the values are codes, a
map that closes in a circle for azimuths, a diverging one about zero where values have both signs,
else viridis.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from vomstudio.core.arrays import AnyArray, ByteArray, FloatArray, IntArray
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.field_style import (
    ELEVATION,
    PALETTES,
    PERCENTILES,
    FieldStyle,
    Kind,
    field_names,
)
from vomstudio.geometry.mesh import Mesh

__all__ = [
    "ELEVATION",
    "MISSING",
    "PALETTES",
    "PERCENTILES",
    "Category",
    "FieldStyle",
    "Kind",
    "Scale",
    "field_names",
    "make_scale",
    "map_table",
    "reader",
    "title_of",
    "unit_of",
]

MISSING = (128, 128, 128)
"""Colour of what has no value."""

SAMPLE = 200_000
PIECE = 1 << 19
MOST_CATEGORIES = 12
MOST_LABELS = 65_535


# ASPRS, LAS specification 1.4 R15, table 17.
LAS_CLASSES: dict[int, tuple[str, str]] = {
    0: (to_translate("never classified"), "#b0b8c4"),
    1: (to_translate("unclassified"), "#d8d2c4"),
    2: (to_translate("ground"), "#a6611a"),
    3: (to_translate("low vegetation"), "#b8e186"),
    4: (to_translate("medium vegetation"), "#4dac26"),
    5: (to_translate("high vegetation"), "#1b7837"),
    6: (to_translate("building"), "#e34a33"),
    7: (to_translate("low noise"), "#7b3294"),
    8: (to_translate("model key point"), "#fdb863"),
    9: (to_translate("water"), "#2c7fb8"),
    10: (to_translate("rail"), "#5e3c99"),
    11: (to_translate("road surface"), "#4d4d4d"),
    12: (to_translate("overlap"), "#f1b6da"),
    13: (to_translate("wire, guard"), "#ffff33"),
    14: (to_translate("wire, conductor"), "#ff7f00"),
    15: (to_translate("transmission tower"), "#6a6ab0"),
    16: (to_translate("wire connector"), "#c51b7d"),
    17: (to_translate("bridge deck"), "#80cdc1"),
    18: (to_translate("high noise"), "#e7298a"),
    19: (to_translate("overhead structure"), "#01665e"),
    20: (to_translate("ignored ground"), "#dfc27d"),
    21: (to_translate("snow"), "#f7f7f7"),
    22: (to_translate("temporal exclusion"), "#35978f"),
}
OTHER_COLORS = (
    "#e69f00",
    "#56b4e9",
    "#009e73",
    "#f0e442",
    "#0072b2",
    "#d55e00",
    "#cc79a7",
    "#8c564b",
    "#bcbd22",
    "#9467bd",
    "#17becf",
    "#e377c2",
)

# As `extraction.exposure` counts them.
_NAMED: dict[str, tuple[tuple[str, str], ...]] = {
    "exposure": (
        (to_translate("rock in a facet"), "#56b4e9"),
        (to_translate("rock in none"), "#d55e00"),
        (to_translate("vegetation"), "#009e73"),
        (to_translate("debris"), "#b0a890"),
    ),
    # As `extraction.measurable.CLASSES`.
    "measurable": (
        (to_translate("not measurable"), "#7f7f7f"),
        (to_translate("poor"), "#d55e00"),
        (to_translate("doubtful"), "#f0e442"),
        (to_translate("good"), "#009e73"),
    ),
}
"""Names and colours of the codes 0, 1 ... of fields of this name, up to a comma in it."""

_AZIMUTHS = ("azimuth", "dip_direction", "dipdir", "dip_dir", "strike", "trend", "aspect")
_CODES = ("return", "class", "segment", "label", "source_id", "user_data", "flag", "channel")
_SIGNED = ("distance_m",)
"""Whose zero means something also where all values lie on one side of it."""
_UNITS = (
    (("azimuth", "dip", "strike", "trend", "plunge", "aspect", "slope", "angle"), "°"),
    (("gps_time",), "s"),
)


@dataclass(frozen=True)
class Category:
    code: int
    name: str
    rgb: tuple[int, int, int]


@dataclass(frozen=True, eq=False)
class Scale:
    """Values to colours, and what a colour bar says of it.

    low, high : values of the first and the last colour; NaN for categories
    table : (k, 3) uint8
    below, above : there are values beyond the ends, which have the colours of the ends
    missing : there are points without a value
    """

    title: str
    unit: str
    kind: Kind
    low: float
    high: float
    table: ByteArray
    categories: tuple[Category, ...] = ()
    below: bool = False
    above: bool = False
    missing: bool = False

    def colors(self, values: AnyArray) -> ByteArray:
        """(n, 3) for values (n,)."""
        values = np.asarray(values, np.float64)
        known = np.isfinite(values)
        if self.kind == "categories":
            codes = np.array([c.code for c in self.categories], np.float64)
            places = np.searchsorted(codes, values)
            places = np.minimum(places, len(codes) - 1)
            known &= codes[places] == values
        else:
            width = self.high - self.low
            place = (np.where(known, values, self.low) - self.low) / (width if width > 0 else 1.0)
            if self.kind == "cyclic":
                place -= np.floor(place)
            places = np.clip(place * len(self.table), 0, len(self.table) - 1).astype(np.intp)
        out = self.table[places]
        if not known.all():
            out[~known] = MISSING
        return out

    def ticks(self, most: int = 6) -> list[tuple[float, str]]:
        """Round values from low to high, with their texts."""
        if self.kind == "categories" or not self.high > self.low:
            return []
        width = self.high - self.low
        if self.kind == "cyclic":
            steps = np.linspace(self.low, self.high, 5)
            return [(float(v), f"{v:g}") for v in steps]
        step = round_step(width / most)
        decimals = max(0, -math.floor(math.log10(step) + 1e-9))
        first = math.ceil(self.low / step - 1e-9)
        last = math.floor(self.high / step + 1e-9)
        return [(k * step, number(k * step, decimals)) for k in range(first, last + 1)]

    def end_texts(self) -> tuple[str, str]:
        """Both ends of the range as text, with enough digits to tell them apart."""
        width = self.high - self.low
        decimals = max(0, 2 - math.floor(math.log10(width))) if width > 0 else 3
        return number(self.low, min(decimals, 9)), number(self.high, min(decimals, 9))


def number(value: float, decimals: int) -> str:
    text = f"{value:.{decimals}f}"
    return text.lstrip("-") if float(text) == 0.0 else text.replace("-", "−")


def round_step(smallest: float) -> float:
    """The smallest 1, 2 or 5 times a power of ten that is at least `smallest`."""
    power = 10.0 ** math.floor(math.log10(smallest))
    for k in (1.0, 2.0, 5.0):
        if k * power >= smallest * (1.0 - 1e-9):
            return k * power
    return 10.0 * power


# -- fields of a model


def title_of(name: str) -> str:
    """A field's name as it is shown: without unit and CloudCompare's prefix."""
    bare = re.sub(r"\s*[\[(][^\])]*[\])]\s*$", "", name)
    bare = re.sub(r"^scalar_", "", bare, flags=re.IGNORECASE)
    bare = bare.removesuffix("_px").removesuffix("_m")
    return bare.replace("_", " ").strip() or name


def unit_of(name: str) -> str:
    """The unit that a field's name gives in brackets, else that of what it names, else none:
    lengths are in the file's own."""
    if name == ELEVATION:
        return "m"
    found = re.search(r"[\[(]([^\])]+)[\])]\s*$", name)
    if found:
        return found.group(1)
    for unit in ("px", "m"):
        if name.endswith(f"_{unit}"):
            return unit
    plain = _plain(name)
    return next((unit for words, unit in _UNITS if any(w in plain for w in words)), "")


def _plain(name: str) -> str:
    return title_of(name).lower().replace(" ", "_")


def reader(
    data: Mesh | PointCloud, name: str, to_world: FloatArray
) -> tuple[int, Callable[[Any], AnyArray]]:
    """How many values there are, and what gives those of some rows or of a slice."""
    points = data.vertices if isinstance(data, Mesh) else data.points
    if name == ELEVATION:
        row, shift = to_world[2, :3], float(to_world[2, 3])
        return len(points), lambda rows: points[rows] @ row + shift
    values = data.fields[name]
    return len(values), lambda rows: np.asarray(values[rows])


def _pieces(count: int) -> Iterator[slice]:
    for start in range(0, count, PIECE):
        yield slice(start, min(start + PIECE, count))


def make_scale(
    data: Mesh | PointCloud,
    style: FieldStyle,
    to_world: FloatArray,
    check: Callable[[], None] = lambda: None,
) -> Scale:
    """The scale of a field; `check` is called now and then and may raise to stop it."""
    count, read = reader(data, style.name, to_world)
    lowest, highest, missing = math.inf, -math.inf, False
    for part in _pieces(count):
        check()
        values = read(part)
        if values.dtype.kind == "f":
            good = np.isfinite(values)
            missing |= not good.all()
            values = values[good]
        if len(values):
            lowest = min(lowest, float(values.min()))
            highest = max(highest, float(values.max()))
    title, unit = title_of(style.name), unit_of(style.name)
    if lowest > highest:
        table = np.array([MISSING], np.uint8)
        return Scale(title, unit, "sequential", 0.0, 0.0, table, missing=True)
    codes = _codes(data, style.name, lowest, highest, check)
    if codes is not None:
        categories = tuple(_categories(style.name, codes))
        table = np.array([c.rgb for c in categories], np.uint8)
        return Scale(
            title, "", "categories", math.nan, math.nan, table, categories, False, False, missing
        )
    kind = _kind(style.name, lowest, highest)
    rows = np.unique(np.linspace(0, count - 1, min(count, SAMPLE)).astype(np.int64))
    some = np.asarray(read(rows), np.float64)
    some = some[np.isfinite(some)]
    low, high = _range(kind, style, some if len(some) else np.array([lowest, highest]))
    palette = style.palette or PALETTES[kind][0]
    if kind == "cyclic":
        return Scale(title, unit, kind, low, high, map_table(palette), missing=missing)
    return Scale(
        title,
        unit,
        kind,
        low,
        high,
        map_table(palette),
        below=lowest < low,
        above=highest > high,
        missing=missing,
    )


def _kind(name: str, lowest: float, highest: float) -> Kind:
    plain = _plain(name)
    if any(word in plain for word in _AZIMUTHS) and lowest >= -180.0 and highest <= 360.0:
        return "cyclic"
    if name == ELEVATION or plain in ("x", "y", "z"):
        return "sequential"
    signed = lowest < 0.0 < highest or name in _SIGNED
    return "diverging" if signed else "sequential"


def _range(kind: Kind, style: FieldStyle, sample: FloatArray) -> tuple[float, float]:
    if kind == "cyclic":
        return 0.0, 360.0
    first, last = np.percentile(sample, np.clip(style.percentiles, 0.0, 100.0))
    low, high = float(first), float(last)
    if kind == "diverging":
        # Zero keeps the middle of the map.
        high = max(abs(low), abs(high))
        low = -high
    low = low if style.low is None else style.low
    high = high if style.high is None else style.high
    if not high > low:
        # A field of one value has a range too.
        pad = max(abs(low), 1.0) * 1e-3
        low, high = low - pad, low + pad
    return low, high


def _codes(
    data: Mesh | PointCloud, name: str, lowest: float, highest: float, check: Callable[[], None]
) -> IntArray | None:
    """The codes that occur, where a field's values are codes."""
    plain = _plain(name)
    if name == ELEVATION or "intensity" in plain:
        return None
    values = data.fields[name]
    named = plain.partition(",")[0] in _NAMED or any(word in plain for word in _CODES)
    if values.dtype.kind == "f" and not named:
        return None
    if not 0.0 <= lowest <= highest <= 65535.0:
        return None
    seen = np.zeros(int(highest) + 1, np.bool_)
    for part in _pieces(len(values)):
        check()
        some = np.asarray(values[part])
        if some.dtype.kind == "f":
            some = some[np.isfinite(some)]
            if (some != np.floor(some)).any():
                return None
        seen[some.astype(np.int64)] = True
    codes = np.flatnonzero(seen)
    most = len(LAS_CLASSES) if "class" in plain else MOST_CATEGORIES
    most = MOST_LABELS if "label" in plain else most
    return codes if len(codes) <= most else None


def _categories(name: str, codes: IntArray) -> Iterator[Category]:
    las = "class" in _plain(name)
    own = _NAMED.get(_plain(name).partition(",")[0], ())
    # The others keep their colours where one of so many pieces is gone.
    labels = "label" in _plain(name)
    for place, code in enumerate(int(c) for c in codes):
        if code < len(own):
            title, color = own[code]
            yield Category(code, tr(title), _rgb(color))
            continue
        if las and code in LAS_CLASSES:
            title, color = LAS_CLASSES[code]
            yield Category(code, f"{code}  {tr(title)}", _rgb(color))
        else:
            text = f"{code}  {tr('user-defined')}" if las and code >= 64 else str(code)
            turn = (code if labels else place) % len(OTHER_COLORS)
            yield Category(code, text, _rgb(OTHER_COLORS[turn]))


def _rgb(color: str) -> tuple[int, int, int]:
    red, green, blue = (int(color[i : i + 2], 16) for i in (1, 3, 5))
    return red, green, blue


def map_table(name: str) -> ByteArray:
    """(256, 3) uint8 of one of matplotlib's maps."""
    from matplotlib import colormaps

    rgba = colormaps[name].resampled(256)(np.arange(256), bytes=True)
    return np.ascontiguousarray(rgba[:, :3])
