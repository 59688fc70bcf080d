"""Colours of the values of a model: field, range and colour map.

A field is a name in `PointCloud.fields` or `Mesh.fields`, or ELEVATION, the height in the World
frame, which is available for every model. The colour map depends on the values: categories for
codes, a cyclic map for azimuths, a map diverging from zero for values of both signs, and
otherwise viridis.
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
    DEFAULT_PERCENTILES,
    ELEVATION,
    PALETTES,
    FieldStyle,
    PaletteKind,
    field_names,
)
from vomstudio.geometry.mesh import Mesh

__all__ = [
    "DEFAULT_PERCENTILES",
    "ELEVATION",
    "MISSING_COLOR",
    "PALETTES",
    "Category",
    "FieldStyle",
    "PaletteKind",
    "Scale",
    "colormap_table",
    "field_names",
    "field_title",
    "field_unit",
    "make_scale",
    "reader",
]

MISSING_COLOR = (128, 128, 128)
"""Colour of missing values."""

MAX_SAMPLE_VALUES = 200_000
PIECE_SIZE = 1 << 19
MAX_CATEGORIES = 12
MAX_LABEL_CODES = 65_535


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

# Defined in `extraction.exposure`.
NAMED_CATEGORIES: dict[str, tuple[tuple[str, str], ...]] = {
    "exposure": (
        (to_translate("rock in a facet"), "#56b4e9"),
        (to_translate("rock outside facets"), "#d55e00"),
        (to_translate("vegetation"), "#009e73"),
        (to_translate("debris"), "#b0a890"),
    ),
    # In the order of `extraction.measurable.QUALITY_CLASSES`.
    "measurable": (
        (to_translate("not measurable"), "#7f7f7f"),
        (to_translate("poor"), "#d55e00"),
        (to_translate("doubtful"), "#f0e442"),
        (to_translate("good"), "#009e73"),
    ),
}
"""Names and colours of the codes 0, 1 and so on in a field, keyed by the part of the field name
before a comma."""

AZIMUTH_NAMES = ("azimuth", "dip_direction", "dipdir", "dip_dir", "strike", "trend", "aspect")
CODE_NAMES = ("return", "class", "segment", "label", "source_id", "user_data", "flag", "channel")
SIGNED_NAMES = ("distance_m",)
"""Fields with a meaningful zero, even if all values have the same sign."""
NAME_UNITS = (
    (("azimuth", "dip", "strike", "trend", "plunge", "aspect", "slope", "angle"), "°"),
    (("gps_time",), "s"),
)


@dataclass(frozen=True)
class Category:
    """Class of points with a code, name and colour."""

    code: int
    name: str
    rgb: tuple[int, int, int]


@dataclass(frozen=True, eq=False)
class Scale:
    """Mapping of values to colours, with the contents of its colour bar.

    Parameters
    ----------
    low, high : float
        Values of the first and last colours; NaN for categories.
    table : (k, 3) uint8
    has_lower_values, has_higher_values : bool
        Whether values exist beyond the ends of the range; they have the colours of the ends.
    missing : bool
        Whether some points have no value.
    """

    title: str
    unit: str
    kind: PaletteKind
    low: float
    high: float
    table: ByteArray
    categories: tuple[Category, ...] = ()
    has_lower_values: bool = False
    has_higher_values: bool = False
    missing: bool = False

    def colors(self, values: AnyArray) -> ByteArray:
        """Return colours (n, 3) for values (n,)."""
        values = np.asarray(values, np.float64)
        is_valid = np.isfinite(values)
        if self.kind == "categories":
            codes = np.array([c.code for c in self.categories], np.float64)
            code_rows = np.searchsorted(codes, values)
            code_rows = np.minimum(code_rows, len(codes) - 1)
            is_valid &= codes[code_rows] == values
        else:
            width = self.high - self.low
            relative_values = (np.where(is_valid, values, self.low) - self.low) / (
                width if width > 0 else 1.0
            )
            if self.kind == "cyclic":
                relative_values -= np.floor(relative_values)
            code_rows = np.clip(relative_values * len(self.table), 0, len(self.table) - 1).astype(
                np.intp
            )
        out = self.table[code_rows]
        if not is_valid.all():
            out[~is_valid] = MISSING_COLOR
        return out

    def ticks(self, maximum: int = 6) -> list[tuple[float, str]]:
        """Return about `maximum` round values between `low` and `high`, with their texts.

        A cyclic scale has five values, and categories have none.
        """
        if self.kind == "categories" or not self.high > self.low:
            return []
        width = self.high - self.low
        if self.kind == "cyclic":
            steps = np.linspace(self.low, self.high, 5)
            return [(float(v), f"{v:g}") for v in steps]
        step = round_step(width / maximum)
        decimals = max(0, -math.floor(math.log10(step) + 1e-9))
        first = math.ceil(self.low / step - 1e-9)
        last_tick = math.floor(self.high / step + 1e-9)
        return [(k * step, number(k * step, decimals)) for k in range(first, last_tick + 1)]

    def end_texts(self) -> tuple[str, str]:
        """Return both ends of the range as text, with enough digits to distinguish them."""
        width = self.high - self.low
        decimals = max(0, 2 - math.floor(math.log10(width))) if width > 0 else 3
        return number(self.low, min(decimals, 9)), number(self.high, min(decimals, 9))


def number(value: float, decimals: int) -> str:
    text = f"{value:.{decimals}f}"
    return text.lstrip("-") if float(text) == 0.0 else text.replace("-", "−")


def round_step(smallest_value: float) -> float:
    """Return the smallest number 1, 2 or 5 times a power of ten not below `smallest_value`."""
    power = 10.0 ** math.floor(math.log10(smallest_value))
    for k in (1.0, 2.0, 5.0):
        if k * power >= smallest_value * (1.0 - 1e-9):
            return k * power
    return 10.0 * power


# -- fields of a model


def field_title(name: str) -> str:
    """Return the display name of a field, without its unit and CloudCompare's prefix."""
    title = re.sub(r"\s*[\[(][^\])]*[\])]\s*$", "", name)
    title = re.sub(r"^scalar_", "", title, flags=re.IGNORECASE)
    title = title.removesuffix("_px").removesuffix("_m")
    return title.replace("_", " ").strip() or name


def field_unit(name: str) -> str:
    """Return the unit in brackets in a field name, or else the unit of its quantity, or "".

    Lengths without a stated unit are in the unit of the file.
    """
    if name == ELEVATION:
        return "m"
    match = re.search(r"[\[(]([^\])]+)[\])]\s*$", name)
    if match:
        return match.group(1)
    for unit in ("px", "m"):
        if name.endswith(f"_{unit}"):
            return unit
    plain_name = _plain_name(name)
    return next((unit for words, unit in NAME_UNITS if any(w in plain_name for w in words)), "")


def _plain_name(name: str) -> str:
    return field_title(name).lower().replace(" ", "_")


def reader(
    data: Mesh | PointCloud, name: str, to_world: FloatArray
) -> tuple[int, Callable[[Any], AnyArray]]:
    """Return the number of values of a field, and a function that reads rows or a slice."""
    points = data.vertices if isinstance(data, Mesh) else data.points
    if name == ELEVATION:
        row, shift = to_world[2, :3], float(to_world[2, 3])
        return len(points), lambda rows: points[rows] @ row + shift
    values = data.fields[name]
    return len(values), lambda rows: np.asarray(values[rows])


def _pieces(count: int) -> Iterator[slice]:
    for start in range(0, count, PIECE_SIZE):
        yield slice(start, min(start + PIECE_SIZE, count))


def make_scale(
    data: Mesh | PointCloud,
    style: FieldStyle,
    to_world: FloatArray,
    check: Callable[[], None] = lambda: None,
) -> Scale:
    """Return the colour scale of a field; `check` is called regularly and may raise to stop."""
    count, field_numbers = reader(data, style.name, to_world)
    lowest_value, highest_value, has_missing = math.inf, -math.inf, False
    for part in _pieces(count):
        check()
        values = field_numbers(part)
        if values.dtype.kind == "f":
            is_finite = np.isfinite(values)
            has_missing |= not is_finite.all()
            values = values[is_finite]
        if len(values):
            lowest_value = min(lowest_value, float(values.min()))
            highest_value = max(highest_value, float(values.max()))
    title, unit = field_title(style.name), field_unit(style.name)
    if lowest_value > highest_value:
        table = np.array([MISSING_COLOR], np.uint8)
        return Scale(title, unit, "sequential", 0.0, 0.0, table, missing=True)
    codes = _codes(data, style.name, lowest_value, highest_value, check)
    if codes is not None:
        categories = tuple(_categories(style.name, codes))
        table = np.array([c.rgb for c in categories], np.uint8)
        return Scale(
            title,
            "",
            "categories",
            math.nan,
            math.nan,
            table,
            categories,
            False,
            False,
            has_missing,
        )
    kind = _kind(style.name, lowest_value, highest_value)
    rows = np.unique(np.linspace(0, count - 1, min(count, MAX_SAMPLE_VALUES)).astype(np.int64))
    sample = np.asarray(field_numbers(rows), np.float64)
    sample = sample[np.isfinite(sample)]
    low, high = _range(
        kind, style, sample if len(sample) else np.array([lowest_value, highest_value])
    )
    palette = style.palette or PALETTES[kind][0]
    if kind == "cyclic":
        return Scale(title, unit, kind, low, high, colormap_table(palette), missing=has_missing)
    return Scale(
        title,
        unit,
        kind,
        low,
        high,
        colormap_table(palette),
        has_lower_values=lowest_value < low,
        has_higher_values=highest_value > high,
        missing=has_missing,
    )


def _kind(name: str, lowest_value: float, highest_value: float) -> PaletteKind:
    plain_name = _plain_name(name)
    if (
        any(word in plain_name for word in AZIMUTH_NAMES)
        and lowest_value >= -180.0
        and highest_value <= 360.0
    ):
        return "cyclic"
    if name == ELEVATION or plain_name in ("x", "y", "z"):
        return "sequential"
    is_signed = lowest_value < 0.0 < highest_value or name in SIGNED_NAMES
    return "diverging" if is_signed else "sequential"


def _range(kind: PaletteKind, style: FieldStyle, sample: FloatArray) -> tuple[float, float]:
    if kind == "cyclic":
        return 0.0, 360.0
    bottom, top = np.percentile(sample, np.clip(style.percentiles, 0.0, 100.0))
    low, high = float(bottom), float(top)
    if kind == "diverging":
        # Zero remains at the centre of the colour map.
        high = max(abs(low), abs(high))
        low = -high
    low = low if style.low is None else style.low
    high = high if style.high is None else style.high
    if not high > low:
        # A constant field also needs a range.
        pad = max(abs(low), 1.0) * 1e-3
        low, high = low - pad, low + pad
    return low, high


def _codes(
    data: Mesh | PointCloud,
    name: str,
    lowest_value: float,
    highest_value: float,
    check: Callable[[], None],
) -> IntArray | None:
    """Return the codes that occur in a field, or None if its values are not codes."""
    plain_name = _plain_name(name)
    if name == ELEVATION or "intensity" in plain_name:
        return None
    values = data.fields[name]
    is_named = plain_name.partition(",")[0] in NAMED_CATEGORIES or any(
        word in plain_name for word in CODE_NAMES
    )
    if values.dtype.kind == "f" and not is_named:
        return None
    if not 0.0 <= lowest_value <= highest_value <= 65535.0:
        return None
    is_present = np.zeros(int(highest_value) + 1, np.bool_)
    for part in _pieces(len(values)):
        check()
        part_numbers = np.asarray(values[part])
        if part_numbers.dtype.kind == "f":
            part_numbers = part_numbers[np.isfinite(part_numbers)]
            if (part_numbers != np.floor(part_numbers)).any():
                return None
        is_present[part_numbers.astype(np.int64)] = True
    codes = np.flatnonzero(is_present)
    max_categories = len(LAS_CLASSES) if "class" in plain_name else MAX_CATEGORIES
    max_categories = MAX_LABEL_CODES if "label" in plain_name else max_categories
    return codes if len(codes) <= max_categories else None


def _categories(name: str, codes: IntArray) -> Iterator[Category]:
    is_las = "class" in _plain_name(name)
    names = NAMED_CATEGORIES.get(_plain_name(name).partition(",")[0], ())
    # The other categories keep their colours when one piece is removed.
    has_labels = "label" in _plain_name(name)
    for place, code in enumerate(int(c) for c in codes):
        if code < len(names):
            title, color = names[code]
            yield Category(code, tr(title), _rgb(color))
            continue
        if is_las and code in LAS_CLASSES:
            title, color = LAS_CLASSES[code]
            yield Category(code, f"{code}  {tr(title)}", _rgb(color))
        else:
            text = f"{code}  {tr('user-defined')}" if is_las and code >= 64 else str(code)
            color_index = (code if has_labels else place) % len(OTHER_COLORS)
            yield Category(code, text, _rgb(OTHER_COLORS[color_index]))


def _rgb(color: str) -> tuple[int, int, int]:
    red, green, blue = (int(color[i : i + 2], 16) for i in (1, 3, 5))
    return red, green, blue


def colormap_table(name: str) -> ByteArray:
    """Return one of matplotlib's colour maps as (256, 3) uint8."""
    from matplotlib import colormaps

    rgba = colormaps[name].resampled(256)(np.arange(256), bytes=True)
    return np.ascontiguousarray(rgba[:, :3])
