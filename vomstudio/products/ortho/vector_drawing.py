"""Scaled drawings in a plane: SVG with a frame, DXF with layers, and GeoPackage."""

from __future__ import annotations

import base64
import html
import io
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import ByteArray, FloatArray
from vomstudio.core.files.plain_characters import replace_control_characters
from vomstudio.geometry.units import round_length, scale_bar_text
from vomstudio.io.gis import dxf
from vomstudio.io.gis.layer_reading import SYMBOL_SUFFIX
from vomstudio.io.gis.layer_writing import write_layer
from vomstudio.io.gis.svg_lines import PROGRAM_CLASS
from vomstudio.products.figure_layout import arrange_columns
from vomstudio.products.ortho.interpretation import ProjectedItem
from vomstudio.products.ortho.legend_entries import LegendEntry, create_entries, explain_symbols

_MAX_CELLS = 1000
"""Maximum number of cells along a side of a table of coverage."""
LabelBox = tuple[float, float, float, float]
"""Bounding box: left, bottom, right, top."""

INK = "#141414"
_EDGE_COLOR = "#404040"
MAX_SIDE_MM = 250.0
"""Maximum length of the longer side of a drawing on paper."""
MARGIN_MM = 18.0
_RIGHT_MM, _TOP_MM, _BOTTOM_MM = 10.0, 10.0, 8.0
"""Margins of an SVG page."""
_TEXT_MM = 3.2
_ROW_MM, _COLUMN_GAP_MM = 1.6 * _TEXT_MM, 5.0
_MIN_TEXT_MM = 90.0
"""Minimum width of the texts below and above a narrow drawing."""
_LEGEND_OFFSET_MM = 21.0
"""Distance of the legend from the frame, with axis labels and scale bar between."""
_LABEL_MM = 2.6
_LETTER_WIDTH = 0.58
"""Mean width of a letter relative to its height."""
DIP_TICK_MM = 5.0
_GLYPH_MM = 6.0
_LABEL_GAP_MM = 0.4
"""Minimum distance between labels."""


@dataclass(frozen=True, eq=False)
class DrawingShape:
    """Shape of a drawing.

    Parameters
    ----------
    layer : str
    points : (n, 2) array
        Coordinates to the right and up, m.
    color : str
    is_closed : bool
    label : str
    dip_deg : float or None
        Dip of the tick of a single point, positive down to the right.
    is_filled : bool
        Whether the area inside has the colour of the shape.
    values : mapping
        Values of the columns in files.
    symbol : tuple of arrays
        Polylines of a map symbol, as in `ProjectedItem`.
    is_annotation : bool
        Whether the shape only annotates the drawing and is not a feature.
    legend : str
        Name in the legend; empty for the name of its type or layer.
    """

    layer: str
    points: FloatArray
    color: str = INK
    is_closed: bool = False
    label: str = ""
    dip_deg: float | None = None
    is_filled: bool = False
    values: Mapping[str, Any] = field(default_factory=dict)
    symbol: tuple[FloatArray, ...] = ()
    is_annotation: bool = False
    legend: str = ""

    def marks(self, half_length: float) -> list[FloatArray]:
        """Return the polylines (k, 2) of a plane symbol; `half_length` is half its length."""
        if self.symbol:
            return [self.points[0] + half_length * line for line in self.symbol]
        if self.dip_deg is None or len(self.points) > 1:
            return []
        a = math.radians(self.dip_deg)
        cross_vector = half_length * np.array([math.cos(a), -math.sin(a)])
        return [np.stack([self.points[0] - cross_vector, self.points[0] + cross_vector])]


@dataclass(frozen=True, eq=False)
class Drawing:
    """Drawing in a plane.

    Parameters
    ----------
    shapes : tuple of DrawingShape
    bounds : (2, 2) array
        Lower-left and upper-right corners, m.
    ends : (str, str)
        Text at the left and the right end.
    axes : (str, str)
        Labels of the horizontal and the vertical axis.
    title : tuple of str
        Lines of text below the drawing.
    picture : (h, w, 4) uint8 array, optional
        RGBA picture that fills the bounds.
    is_metric : bool
        Whether lengths are in metres.
    """

    shapes: tuple[DrawingShape, ...]
    bounds: FloatArray
    ends: tuple[str, str]
    axes: tuple[str, str]
    title: tuple[str, ...] = ()
    picture: ByteArray | None = None
    is_metric: bool = True

    @property
    def layers(self) -> list[str]:
        """Names of the layers, those with areas before those with lines."""
        ordered = sorted(self.shapes, key=lambda shape: not shape.is_filled)
        return list(dict.fromkeys(shape.layer for shape in ordered))

    @property
    def legend(self) -> list[LegendEntry]:
        """Legend entries of the feature types, without shapes that only annotate the drawing."""
        return create_entries([shape for shape in self.shapes if not shape.is_annotation])


def create_shape(projected_item: ProjectedItem) -> DrawingShape:
    """Convert a projected item to a shape.

    A plane is labelled with its name and its apparent dip or, on a map, its true dip. Another point
    is labelled with its name, unless the item has its own label (`symbol_label`). Lines and areas
    have only this label.
    """
    item, dip = projected_item.item, projected_item.apparent_dip_deg
    shown_dip = item.dip_deg if projected_item.symbol else dip
    label = item.symbol_label or (item.name if item.form == "point" else "")
    if item.normal is not None and shown_dip is not None:
        label = f"{item.name} {abs(shown_dip):.0f}°" if item.name else f"{abs(shown_dip):.0f}°"
    overturned_values = {"overturned": 1} if projected_item.symbol and item.overturned else {}
    return DrawingShape(
        item.layer,
        projected_item.points,
        item.color,
        item.form == "ring",
        label,
        dip,
        item.is_filled,
        {
            "id": item.id,
            "name": item.name,
            "kind": item.kind,
            "set": item.set,
            "dip_direction_deg": item.dip_direction_deg,
            "dip_deg": item.dip_deg,
            "apparent_dip_deg": dip,
            "away_m": float(projected_item.distance.mean()),
            **overturned_values,
        },
        projected_item.symbol,
    )


def paper_scale(bounds: FloatArray) -> int:
    """Return the scale denominator, which is 1, 2, 2.5 or 5 times a power of ten."""
    max_length = max(float((bounds[1] - bounds[0]).max()), 1e-6)
    min_scale = max_length * 1000 / MAX_SIDE_MM
    power = 10.0 ** math.floor(math.log10(min_scale))
    scale = next(power * k for k in (1, 2, 2.5, 5, 10) if power * k >= min_scale * (1 - 1e-9))
    return max(1, round(scale))


def choose_ticks(low: float, high: float) -> FloatArray:
    """Return four to ten round tick values within a range."""
    step = round_length(max((high - low) / 4, 1e-12))
    first_tick, last_tick = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return np.asarray(np.arange(first_tick, last_tick + 1) * step, np.float64)


def format_number(value: float) -> str:
    """Format a number with at most 12 significant digits."""
    return f"{value + 0.0:.12g}"


def left_margin_mm(bounds: FloatArray, text_mm: float) -> float:
    """Return the width of the margin for tick labels and axis label at text size `text_mm`."""
    ticks = choose_ticks(float(bounds[0, 1]), float(bounds[1, 1]))
    max_length = max((len(format_number(value)) for value in ticks.tolist()), default=0)
    return max(MARGIN_MM, 0.68 * text_mm * max_length + 7.5)


def _escape(text: str) -> str:
    return html.escape(replace_control_characters(text))


def svg_text(drawing: Drawing) -> str:
    """Return the drawing as SVG in millimetres at the scale of `paper_scale`.

    The group `plane` contains everything in metres in the plane with y down, so that the
    coordinates can be read back.
    """
    low, high = drawing.bounds
    scale = paper_scale(drawing.bounds)
    mm_per_m = 1000.0 / scale
    width, height = ((high - low) * mm_per_m).tolist()
    x_left, y_top = left_margin_mm(drawing.bounds, _TEXT_MM), _TOP_MM
    legend = _SvgLegend(drawing, max(width, _MIN_TEXT_MM))
    page = (
        x_left + max(width, _MIN_TEXT_MM) + _RIGHT_MM,
        height + y_top + _LEGEND_OFFSET_MM + legend.height_mm + _BOTTOM_MM,
    )
    matrix = (
        mm_per_m,
        mm_per_m,
        x_left - float(low[0]) * mm_per_m,
        y_top + float(high[1]) * mm_per_m,
    )
    out = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '
        'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
        f'width="{page[0]:.3f}mm" height="{page[1]:.3f}mm" '
        f'viewBox="0 0 {page[0]:.3f} {page[1]:.3f}" font-family="sans-serif" '
        f'font-size="{_TEXT_MM}">',
        f'<g id="page" class="{PROGRAM_CLASS}">'
        f'<rect width="{page[0]:.3f}" height="{page[1]:.3f}" fill="white"/></g>',
    ]
    transform = f'transform="matrix({matrix[0]!r} 0 0 {matrix[1]!r} {matrix[2]!r} {matrix[3]!r})"'
    if drawing.picture is not None:
        out.append(
            f'<image id="picture" x="{x_left:.6f}" y="{y_top:.6f}" width="{width:.6f}" '
            f'height="{height:.6f}" preserveAspectRatio="none" '
            f'xlink:href="data:image/png;base64,{_encode_png(drawing.picture)}"/>'
        )
    out.append(f'<g id="plane" {transform} stroke-width="{0.35 / mm_per_m:.6g}" fill="none">')
    ids: set[str] = set()
    for layer in drawing.layers:
        name = _escape(layer)
        out.append(f'<g id="{name}" inkscape:groupmode="layer" inkscape:label="{name}">')
        out += [
            _svg_shape(shape, mm_per_m, ids) for shape in drawing.shapes if shape.layer == layer
        ]
        out.append("</g>")
    out.append("</g>")
    out += _labels(drawing, matrix, scale)
    out += _frame(drawing, matrix, (x_left, y_top, width, height), scale, legend)
    return "\n".join([*out, "</svg>", ""])


def _svg_shape(shape: DrawingShape, mm_per_m: float, ids: set[str]) -> str:
    """Return the SVG element of a shape, whose id is unique among `ids`."""
    title = _escape(shape.label or str(shape.values.get("name", "")))
    if len(shape.points) == 1:
        x, y = (shape.points[0] * (1, -1)).tolist()
        class_attribute = f'class="{PROGRAM_CLASS}"'
        parts = [
            f'<circle {class_attribute} cx="{x!r}" cy="{y!r}" '
            f'r="{0.7 / mm_per_m:.6g}" fill="{shape.color}"/>'
        ]
        parts += [
            f'<polyline {class_attribute} points="{_svg_points(line)}" stroke="{shape.color}"/>'
            for line in shape.marks(DIP_TICK_MM / mm_per_m)
        ]
        return "".join(parts)
    position = _svg_points(shape.points)
    values = {
        "id": shape.values.get("id"),
        "data-kind": shape.values.get("kind"),
        "data-set": shape.values.get("set"),
    }
    if values["id"] in ids:
        del values["id"]
    else:
        ids.add(str(values["id"]))
    text = "".join(f' {key}="{_escape(str(value))}"' for key, value in values.items() if value)
    tag = "polygon" if shape.is_closed else "polyline"
    style_attributes = f'stroke="{shape.color}"'
    if shape.is_filled:
        style_attributes = f'stroke="{_EDGE_COLOR}" fill="{shape.color}" fill-opacity="0.5"'
    return f'<{tag}{text} points="{position}" {style_attributes}><title>{title}</title></{tag}>'


def _svg_points(points: FloatArray) -> str:
    return " ".join(f"{x!r},{-y + 0.0!r}" for x, y in points.tolist())


@dataclass(frozen=True, eq=False)
class PlacedLabel:
    """Label with its position.

    Parameters
    ----------
    shape : DrawingShape
    x, y : float
        Position of the text end nearest to the feature, at middle height, in metres in the plane.
    is_on_right : bool
        Whether the text ends at this position; otherwise it begins there.
    is_separate : bool
        Whether a line must connect the label to `anchor`.
    anchor : (float, float)
        Point that the label refers to.
    """

    shape: DrawingShape
    x: float
    y: float
    is_on_right: bool
    is_separate: bool
    anchor: tuple[float, float]

    @property
    def color(self) -> str:
        """Colour of the text; equals the colour of the shape unless the shape is filled."""
        return INK if self.shape.is_filled else self.shape.color


def place_labels(drawing: Drawing, scale: float, text_mm: float) -> list[PlacedLabel]:
    """Place labels beside their features without overlap and within the frame.

    Labels cover points and lines of features only if there is no other position. Labels that do not
    fit are omitted.

    Parameters
    ----------
    drawing : Drawing
    scale : float
        Scale denominator.
    text_mm : float
        Letter height on paper.
    """
    metres_per_mm = 0.001 * scale
    height, gap = 1.25 * text_mm * metres_per_mm, 1.2 * metres_per_mm
    positions = [shape.points for shape in drawing.shapes if len(shape.points) == 1]
    # Also avoid the end of the tick of a symbol, which shows the direction of dip.
    positions += [
        line[-1:]
        for shape in drawing.shapes
        if shape.symbol
        for line in shape.marks(DIP_TICK_MM * metres_per_mm)
    ]
    dots = np.concatenate([np.empty((0, 2)), *positions])
    symbol_lines = [
        line for shape in drawing.shapes for line in shape.marks(DIP_TICK_MM * metres_per_mm)
    ]
    lines = [
        shape.points for shape in drawing.shapes if len(shape.points) > 1 and not shape.is_filled
    ]
    symbol_coverage, line_coverage = (
        _Coverage(item, drawing.bounds, 0.25 * height) for item in (symbol_lines, lines)
    )
    occupied_boxes: list[LabelBox] = []
    labels = []
    for shape in drawing.shapes:
        if not shape.label:
            continue
        position = shape.points[len(shape.points) // 2]
        x, y = (_label_position_inside(shape.points) if shape.is_filled else position).tolist()
        width = _LETTER_WIDTH * text_mm * metres_per_mm * (len(shape.label) + 1)
        candidates = [
            (row, right, (left, label_y, left + width, label_y + height))
            for row in (0.0, -1.0, 1.0, -2.0, 2.0, -3.0)
            for label_y in (y + gap + row * height if row >= 0 else y - gap + row * height,)
            for right, left in ((False, x + gap), (True, x - gap - width))
        ]
        free_positions = [
            candidate
            for candidate in candidates
            if _is_free(candidate[2], drawing.bounds, occupied_boxes)
        ]
        if free_positions:
            row, right, box = min(
                free_positions,
                key=lambda s: (
                    _count_dots(s[2], dots) > 0,
                    2 * symbol_coverage.count(s[2]) + line_coverage.count(s[2]),
                ),
            )
            label_gap = _LABEL_GAP_MM * metres_per_mm
            occupied_boxes.append(
                (box[0] - label_gap, box[1] - label_gap, box[2] + label_gap, box[3] + label_gap)
            )
            centre = 0.5 * (box[1] + box[3])
            end = box[2] if right else box[0]
            labels.append(PlacedLabel(shape, end, centre, right, row not in (0.0, -1.0), (x, y)))
    return labels


class _Coverage:
    """Counter of the points along lines in a box, based on a table of cumulative counts."""

    def __init__(self, lines: Sequence[FloatArray], bounds: FloatArray, step: float) -> None:
        low, high = bounds
        self._low = low
        cells = np.clip(np.ceil((high - low) / step).astype(int), 1, _MAX_CELLS)
        self._step = (high - low) / cells
        points = np.concatenate([np.empty((0, 2)), *(_resample(line, step) for line in lines)])
        position = np.floor((points - low) / self._step).astype(int)
        position = position[((position >= 0) & (position < cells)).all(axis=1)]
        counts = np.zeros(cells + 1, np.int64)
        np.add.at(counts, (position[:, 0] + 1, position[:, 1] + 1), 1)
        self._sums = counts.cumsum(axis=0).cumsum(axis=1)

    def count(self, box: LabelBox) -> int:
        corners = (np.array(box).reshape(2, 2) - self._low) / self._step
        (x0, y0), (x1, y1) = np.clip(
            np.round(corners).astype(int), 0, np.array(self._sums.shape) - 1
        )
        sums = self._sums
        return int(sums[x1, y1] - sums[x0, y1] - sums[x1, y0] + sums[x0, y0])


def _is_free(box: LabelBox, bounds: FloatArray, occupied_label_boxes: list[LabelBox]) -> bool:
    (x_min, y_min), (x_max, y_max) = bounds.tolist()
    is_within = box[0] >= x_min and box[2] <= x_max and box[1] >= y_min and box[3] <= y_max
    return is_within and not any(
        _are_overlapping(box, occupied_box) for occupied_box in occupied_label_boxes
    )


def _count_dots(box: LabelBox, dots: FloatArray) -> int:
    """Count the dots in a box."""
    x, y = dots[:, 0], dots[:, 1]
    return int(((x > box[0]) & (x < box[2]) & (y > box[1]) & (y < box[3])).sum())


def _resample(line: FloatArray, step: float) -> FloatArray:
    """Return points (n, 2) along a polyline that are at most one step apart."""
    return np.concatenate(
        [
            np.linspace(a, b, max(2, math.ceil(float(np.hypot(*(b - a))) / step) + 1))
            for a, b in pairwise(line)
        ]
    )


def _are_overlapping(first_box: LabelBox, second_box: LabelBox) -> bool:
    return (
        first_box[0] < second_box[2]
        and second_box[0] < first_box[2]
        and first_box[1] < second_box[3]
        and second_box[1] < first_box[3]
    )


def _labels(drawing: Drawing, matrix: tuple[float, float, float, float], scale: float) -> list[str]:
    sx, sy, tx, ty = matrix
    elements = [f'<g id="labels" class="{PROGRAM_CLASS}">']
    for label in place_labels(drawing, scale, _LABEL_MM):
        x, y = label.x * sx + tx, -label.y * sy + ty
        if label.is_separate:
            anchor_x, anchor_y = label.anchor[0] * sx + tx, -label.anchor[1] * sy + ty
            elements.append(
                f'<line x1="{anchor_x:.3f}" y1="{anchor_y:.3f}" x2="{x:.3f}" y2="{y:.3f}" '
                f'stroke="{label.shape.color}" stroke-width="0.15"/>'
            )
        anchor = ' text-anchor="end"' if label.is_on_right else ""
        position_attributes = (
            f'x="{x:.3f}" y="{y + 0.35 * _LABEL_MM:.3f}" font-size="{_LABEL_MM}"{anchor}'
        )
        text = _escape(label.shape.label)
        # Draw a separate halo, because not all programs support paint-order.
        halo = 'fill="white" stroke="white" stroke-width="0.6" stroke-linejoin="round"'
        elements.append(f"<text {position_attributes} {halo}>{text}</text>")
        elements.append(f'<text {position_attributes} fill="{label.color}">{text}</text>')
    return [*elements, "</g>"]


def _label_position_inside(ring: FloatArray) -> FloatArray:
    """Return a position (2,) inside an area for its label."""
    import shapely

    position = shapely.make_valid(shapely.Polygon(ring)).representative_point()
    return np.array([position.x, position.y])


def _frame(
    drawing: Drawing,
    matrix: tuple[float, float, float, float],
    frame: tuple[float, float, float, float],
    scale: int,
    legend: _SvgLegend,
) -> list[str]:
    x_left, y_top, width, height = frame
    sx, sy, tx, ty = matrix
    low, high = drawing.bounds
    box = f'x="{x_left:.3f}" y="{y_top:.3f}" width="{width:.3f}" height="{height:.3f}"'
    out = [
        f'<g id="frame" class="{PROGRAM_CLASS}" stroke="{INK}" stroke-width="0.25" fill="{INK}">',
        f'<rect {box} fill="none"/>',
    ]

    def text(x: float, y: float, text: str, anchor: str, attributes: str = "") -> None:
        out.append(
            f'<text x="{x:.3f}" y="{y:.3f}" text-anchor="{anchor}" stroke="none" {attributes}>'
            f"{_escape(text)}</text>"
        )

    bottom = y_top + height
    for value in choose_ticks(float(low[0]), float(high[0])):
        x = value * sx + tx
        out.append(f'<line x1="{x:.3f}" y1="{bottom:.3f}" x2="{x:.3f}" y2="{bottom + 1.5:.3f}"/>')
        text(x, bottom + 5, format_number(value), "middle")
    max_length = 0.0
    for value in choose_ticks(float(low[1]), float(high[1])):
        max_length = max(max_length, _LETTER_WIDTH * _TEXT_MM * len(format_number(value)))
        y = -value * sy + ty
        out.append(f'<line x1="{x_left - 1.5:.3f}" y1="{y:.3f}" x2="{x_left:.3f}" y2="{y:.3f}"/>')
        text(x_left - 2.2, y + 1.1, format_number(value), "end")
    bold_style = 'font-weight="bold"'
    # The texts of a narrow drawing extend beyond it.
    text_width_mm = 1.3 * _LETTER_WIDTH * _TEXT_MM * (sum(map(len, drawing.ends)) + 2)
    overhang = min(max(0.5 * (text_width_mm - width), 0.0), x_left - 1.0)
    text(x_left - overhang, y_top - 3, drawing.ends[0], "start", bold_style)
    text(
        x_left + max(width + overhang, text_width_mm - overhang),
        y_top - 3,
        drawing.ends[1],
        "end",
        bold_style,
    )
    text(x_left + width / 2, bottom + 9.5, drawing.axes[0], "middle")
    x = max(x_left - max_length - 4.5, _TEXT_MM)
    text(
        x,
        y_top + height / 2,
        drawing.axes[1],
        "middle",
        f'transform="rotate(-90 {x:.3f} {y_top + height / 2:.3f})"',
    )
    length = round_length(0.25 * float(high[0] - low[0]))
    y = bottom + 14
    out.append(f'<rect x="{x_left:.3f}" y="{y:.3f}" width="{length * sx:.3f}" height="1.2"/>')
    bar = scale_bar_text(length, is_metric=drawing.is_metric)
    text(
        x_left + length * sx + 2, y + 1.6, f"{bar}, 1 : {scale:,}".replace(",000", " 000"), "start"
    )
    y = bottom + _LEGEND_OFFSET_MM
    for k, entry in enumerate(legend.entries):
        row, column = divmod(k, len(legend.columns))
        x = x_left + sum(legend.columns[:column]) + _COLUMN_GAP_MM * column
        out += _svg_glyphs(entry, x, y + row * _ROW_MM - 0.35 * _TEXT_MM)
        text(x + legend.glyphs_mm, y + row * _ROW_MM, entry.short_name, "start")
    y += legend.rows * _ROW_MM
    for line in legend.lines:
        text(x_left, y, line, "start")
        y += _ROW_MM
    out.append("</g>")
    return out


class _SvgLegend:
    """Legend in columns, and the lines of text below it."""

    def __init__(self, drawing: Drawing, width_mm: float) -> None:
        self.entries = drawing.legend
        remark = explain_symbols(self.entries)
        self.lines = [*([remark] if remark else []), *drawing.title]
        slots = max(
            (sum((entry.line, entry.area, entry.place)) for entry in self.entries), default=0
        )
        self.glyphs_mm = 1.2 * slots * _GLYPH_MM
        letter = 1.1 * _LETTER_WIDTH * _TEXT_MM
        widths = [self.glyphs_mm + letter * len(entry.short_name) for entry in self.entries]
        self.columns = arrange_columns(widths, width_mm, _COLUMN_GAP_MM)
        self.rows = math.ceil(len(self.entries) / len(self.columns))

    @property
    def height_mm(self) -> float:
        """Height of all rows."""
        return (self.rows + len(self.lines)) * _ROW_MM


def _svg_glyphs(entry: LegendEntry, start: float, middle: float) -> list[str]:
    """Return the line, area and point symbol of a legend entry, side by side from `start`."""
    stroke = f'stroke="{entry.color}" stroke-width="0.5"'
    glyphs = []
    if entry.line:
        right = start + _GLYPH_MM
        glyphs.append(
            f'<line x1="{start:.3f}" y1="{middle:.3f}" x2="{right:.3f}" y2="{middle:.3f}"'
            f" {stroke}/>"
        )
        start += 1.2 * _GLYPH_MM
    if entry.area:
        fill = f'fill="{entry.color}" fill-opacity="0.5"' if entry.is_filled else 'fill="none"'
        glyphs.append(
            f'<rect x="{start:.3f}" y="{middle - 1.2:.3f}" width="{_GLYPH_MM}" height="2.4" '
            f"{fill} {stroke}/>"
        )
        start += 1.2 * _GLYPH_MM
    if entry.place:
        x0 = start + 0.5 * _GLYPH_MM
        for mark in entry.marks():
            ends = " ".join(f"{x0 + 2.4 * x:.3f},{middle - 2.4 * y:.3f}" for x, y in mark.tolist())
            glyphs.append(f'<polyline points="{ends}" fill="none" {stroke}/>')
        glyphs.append(
            f'<circle cx="{x0:.3f}" cy="{middle:.3f}" r="0.6" fill="{entry.color}" {stroke}/>'
        )
    return glyphs


def _encode_png(picture: ByteArray) -> str:
    from PIL import Image

    file = io.BytesIO()
    Image.fromarray(picture).save(file, "PNG")
    return base64.b64encode(file.getvalue()).decode("ascii")


def write_dxf(path: Path, drawing: Drawing, comment: str = "") -> None:
    """Write a DXF file with one layer per layer of the drawing.

    Coordinates are to the right and up. The unit is stated if it is the metre, and column values
    are stored as extended data. The symbols and labels of each layer are on a separate layer, which
    is ignored when the drawing is read back.
    """
    scale = paper_scale(drawing.bounds)
    symbol_layers = {
        shape.layer: shape.layer if shape.is_annotation else shape.layer + SYMBOL_SUFFIX
        for shape in drawing.shapes
        if shape.label or shape.marks(1.0)
    }
    names = dxf.layer_names([*drawing.layers, *symbol_layers.values()])
    colors = {
        names[layer_name]: dxf.color_number(
            next(shape.color for shape in drawing.shapes if shape.layer == layer)
        )
        for layer in drawing.layers
        for layer_name in (layer, symbol_layers.get(layer, layer))
    }
    bounds = np.column_stack([drawing.bounds, np.zeros(2)])
    with open(path, "w", encoding="ascii", newline="\r\n") as file:
        title = comment or " - ".join(drawing.ends)
        out = dxf.DxfWriter(file, colors, bounds, title, is_metric=drawing.is_metric)
        for shape in drawing.shapes:
            points = np.column_stack([shape.points, np.zeros(len(shape.points))])
            values = {**shape.values, "label": shape.label}
            if shape.is_annotation:
                out.line(points, names[shape.layer])
            elif len(points) == 1:
                out.point(points[0], names[shape.layer], values)
            else:
                out.polyline(points, names[shape.layer], values, shape.is_closed)
        for shape in drawing.shapes:
            for line in shape.marks(0.001 * scale * DIP_TICK_MM):
                line_3d = np.column_stack([line, np.zeros(len(line))])
                out.line(line_3d, names[symbol_layers[shape.layer]])
        for shape, position in _place_texts(drawing, scale):
            out.text(
                position, shape.label, 0.001 * scale * _LABEL_MM, names[symbol_layers[shape.layer]]
            )
        out.close()


def _place_texts(drawing: Drawing, scale: float) -> list[tuple[DrawingShape, FloatArray]]:
    """Return each labelled shape with the centre (3,) of its text.

    Texts without a free position overlap others, since a CAD drawing can be enlarged.
    """
    height = 0.001 * scale * _LABEL_MM
    label_by_shape = {id(label.shape): label for label in place_labels(drawing, scale, _LABEL_MM)}
    positions = []
    for shape in drawing.shapes:
        if not shape.label:
            continue
        half_width = 0.5 * _LETTER_WIDTH * height * len(shape.label)
        label = label_by_shape.get(id(shape))
        if label is None:
            centre = shape.points[len(shape.points) // 2] + np.array([half_width + height, 0.0])
        else:
            centre = np.array(
                [label.x - half_width if label.is_on_right else label.x + half_width, label.y]
            )
        positions.append((shape, np.append(centre, 0.0)))
    return positions


def write_gpkg(path: Path, drawing: Drawing, crs: str | None, described_text: str) -> None:
    """Write a GeoPackage with one table per layer, and one for the map symbols of a layer.

    `described_text` is the description of every layer.

    Raises
    ------
    TargetError
    """
    import shapely

    path.unlink(missing_ok=True)
    is_appending = False
    for layer in drawing.layers:
        shapes = [shape for shape in drawing.shapes if shape.layer == layer]
        is_point = len(shapes[0].points) == 1
        kind = "Point" if is_point else "Polygon" if shapes[0].is_closed else "LineString"
        create_geometry = {"Point": shapely.points, "Polygon": shapely.polygons}.get(
            kind, shapely.linestrings
        )
        geometry = np.empty(len(shapes), object)
        for k, shape in enumerate(shapes):
            geometry[k] = create_geometry(shape.points[0] if is_point else shape.points)
        columns = {}
        for name in dict.fromkeys(key for shape in shapes for key in shape.values):
            values = [shape.values.get(name) for shape in shapes]
            if all(value is None or isinstance(value, int | float) for value in values):
                columns[name] = np.array(
                    [math.nan if value is None else value for value in values], float
                )
            else:
                columns[name] = np.array([value or "" for value in values], object)
        write_layer(
            path,
            layer,
            kind,
            geometry,
            columns,
            crs,
            description=described_text,
            append=is_appending,
        )
        is_appending = True
        shapes_with_symbols = [shape for shape in shapes if shape.symbol]
        if not shapes_with_symbols:
            continue
        half_length = 0.001 * paper_scale(drawing.bounds) * DIP_TICK_MM
        symbols = np.empty(len(shapes_with_symbols), object)
        for k, shape in enumerate(shapes_with_symbols):
            symbols[k] = shapely.multilinestrings(
                [shapely.linestrings(line) for line in shape.marks(half_length)]
            )
        texts = {
            "id": np.array(
                [str(shape.values.get("id", "")) for shape in shapes_with_symbols], object
            ),
            "label": np.array([shape.label for shape in shapes_with_symbols], object),
        }
        write_layer(
            path,
            layer + SYMBOL_SUFFIX,
            "MultiLineString",
            symbols,
            texts,
            crs,
            description=described_text,
            append=True,
        )
