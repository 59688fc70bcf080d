"""Map styles of the project's layers.

Features have the colours of their types, planes have strike and dip symbols, and the line style
depends on the verdict.
"""

from __future__ import annotations

from collections.abc import Mapping

from vomstudio.core.words import tr
from vomstudio.io.gis import qml
from vomstudio.io.gis.layers import Layer
from vomstudio.io.gis.qml import Labels, RendererCategory, Style, SymbolLayer
from vomstudio.project.records import FeatureType, Record

_DEFAULT_COLOR = "#4d4d4d"
BAR_MM, TICK_MM, WIDTH_MM = 6.0, 2.2, 0.45
_LABEL_MM = 4.2

_FLAT_CONDITION, _STEEP_CONDITION = '"dip_deg" < 0.5', '"dip_deg" > 89.5'
_LINE_STYLE = (
    "CASE WHEN \"quality\" = 'poor' THEN 'dot' WHEN \"quality\" = 'doubtful' THEN 'dash' "
    "ELSE 'solid' END"
)
"""Solid, dashed and dotted, as used on maps for certain, approximate and inferred lines."""


def layer_style(layer: Layer, records: Mapping[str, Record]) -> Style:
    """Return the style of a layer returned by `project_layers`."""
    colors = {
        record.name.casefold(): record.color
        for record in records.values()
        if isinstance(record, FeatureType)
    }
    classes = layer.colors_by_class(colors, _DEFAULT_COLOR)
    if layer.by not in layer.columns or not classes:
        return Style(
            layer.kind,
            [RendererCategory("", layer.name, _pieces(layer, _DEFAULT_COLOR))],
            tip=_TOOLTIP,
        )
    categories = [
        RendererCategory(word, word or tr("no type"), _pieces(layer, color))
        for word, color in classes.items()
    ]
    if "" not in classes:
        # Style for features of unknown type that are added later in QGIS.
        categories.append(RendererCategory("", tr("other"), _pieces(layer, _DEFAULT_COLOR)))
    return Style(layer.kind, categories, layer.by, _labels(layer), _TOOLTIP)


_TOOLTIP = '[% coalesce("name", "id") %]'


def _pieces(layer: Layer, color: str) -> list[SymbolLayer]:
    if layer.kind == "line":
        return [qml.line(0.35, color, _quality(layer, "outlineStyle"))]
    if layer.kind == "ring":
        return [qml.fill(color, _quality(layer, "outlineStyle"))]
    if "dip_deg" in layer.columns and layer.name == "planes":
        return _strike_and_dip(layer, color)
    if "plunge_deg" in layer.columns and layer.name == "lines":
        return _arrow(layer, color)
    return [qml.mark("diamond", 2.4, color)]


def _quality(layer: Layer, name: str) -> dict[str, str]:
    return {name: _LINE_STYLE} if "quality" in layer.columns else {}


def _strike_and_dip(layer: Layer, color: str) -> list[SymbolLayer]:
    """Return the symbol layers of a bar along the strike and a tick down the dip.

    A vertical plane has a tick on both sides, a horizontal plane a cross, and an overturned plane a
    hook.
    """
    line_style = _quality(layer, "outlineStyle")
    strike, dip_direction = '"dip_direction_deg" - 90', '"dip_direction_deg"'
    half_tick = 0.5 * TICK_MM
    is_flat_or_steep = f"{_FLAT_CONDITION} OR {_STEEP_CONDITION}"
    tick = {
        "size": f"CASE WHEN {_FLAT_CONDITION} THEN {BAR_MM} WHEN {_STEEP_CONDITION} "
        f"THEN {2 * TICK_MM} ELSE {TICK_MM} END",
        "offset": f"CASE WHEN {is_flat_or_steep} THEN '0,0' ELSE '0,{-half_tick}' END",
    }
    pieces = [
        qml.stroke(
            BAR_MM, WIDTH_MM, color, angle=strike, offset="0,0", expression_by_property=line_style
        ),
        qml.stroke(
            TICK_MM,
            WIDTH_MM,
            color,
            angle=dip_direction,
            offset=f"0,{-half_tick}",
            expression_by_property={**line_style, **tick},
        ),
    ]
    if "overturned" in layer.columns:
        hook = qml.mark("half_arc", TICK_MM, color)
        values = {**hook.values, "outline_width": f"{WIDTH_MM:g}", "color": "0,0,0,0"}
        overrides = {"angle": f"{dip_direction} + 180", "enabled": 'coalesce("overturned", false)'}
        pieces.append(SymbolLayer(hook.kind, values, overrides))
    return pieces


def _arrow(layer: Layer, color: str) -> list[SymbolLayer]:
    """Return the symbol layers of an arrow along the trend; a horizontal line has two heads."""
    line_style = _quality(layer, "outlineStyle")
    arrowhead = qml.mark("arrowhead", 1.8, color, offset=f"0,{-BAR_MM}")
    overrides = {"angle": '"trend_deg" - 90'}
    values = {**arrowhead.values, "offset": f"{BAR_MM},0", "outline_width": f"{WIDTH_MM:g}"}
    opposite_values = {**values, "offset": "0,0"}
    return [
        qml.stroke(
            BAR_MM,
            WIDTH_MM,
            color,
            angle='"trend_deg"',
            offset=f"0,{-0.5 * BAR_MM}",
            expression_by_property=line_style,
        ),
        SymbolLayer(arrowhead.kind, values, overrides),
        SymbolLayer(
            arrowhead.kind,
            opposite_values,
            {"angle": '"trend_deg" + 90', "enabled": 'abs("plunge_deg") < 0.5'},
        ),
    ]


def _labels(layer: Layer) -> Labels | None:
    """Return the labels: the dip next to the tick, or the plunge at the tip of the arrow.

    Returns None for layers other than those of planes and lines.
    """
    if layer.name == "planes":
        return Labels(
            'round("dip_deg")', by={"OffsetXY": _offset_expression("dip_direction_deg", _LABEL_MM)}
        )
    if layer.name == "lines":
        distance_mm = BAR_MM + 2.4
        return Labels(
            'round("plunge_deg")', by={"OffsetXY": _offset_expression("trend_deg", distance_mm)}
        )
    return None


def _offset_expression(azimuth: str, distance_mm: float) -> str:
    """Return the expression for an offset along an azimuth; y points down on the page."""
    return (
        f"to_string({distance_mm} * sin(radians(\"{azimuth}\"))) || ',' || "
        f'to_string(-{distance_mm} * cos(radians("{azimuth}")))'
    )
