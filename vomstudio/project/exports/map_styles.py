"""How the project's layers look on a map: types by their colours, planes by strike and dip,
verdicts by the style of their lines."""

from __future__ import annotations

from collections.abc import Mapping

from vomstudio.core.words import tr
from vomstudio.io.gis import qml
from vomstudio.io.gis.layers import Layer
from vomstudio.io.gis.qml import Category, Labels, Piece, Style
from vomstudio.project.records import FeatureType, Record

_OTHER = "#4d4d4d"
BAR_MM, TICK_MM, WIDTH_MM = 6.0, 2.2, 0.45
_LABEL_MM = 4.2

_FLAT, _STEEP = '"dip_deg" < 0.5', '"dip_deg" > 89.5'
_STYLE_BY = (
    "CASE WHEN \"quality\" = 'poor' THEN 'dot' WHEN \"quality\" = 'doubtful' THEN 'dash' "
    "ELSE 'solid' END"
)
"""Solid, dashed, dotted: as maps draw what is certain, approximate, inferred."""


def style_of(layer: Layer, records: Mapping[str, Record]) -> Style:
    """Of one of the layers of `project_layers`."""
    colors = {r.name.casefold(): r.color for r in records.values() if isinstance(r, FeatureType)}
    classes = layer.colors_of(colors, _OTHER)
    if layer.by not in layer.columns or not classes:
        return Style(layer.kind, [Category("", layer.name, _pieces(layer, _OTHER))], tip=_TIP)
    categories = [
        Category(word, word or tr("no type"), _pieces(layer, color))
        for word, color in classes.items()
    ]
    if "" not in classes:
        # What is added in QGIS later, with a type that is not here.
        categories.append(Category("", tr("other"), _pieces(layer, _OTHER)))
    return Style(layer.kind, categories, layer.by, _labels(layer), _TIP)


_TIP = '[% coalesce("name", "id") %]'


def _pieces(layer: Layer, color: str) -> list[Piece]:
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
    return {name: _STYLE_BY} if "quality" in layer.columns else {}


def _strike_and_dip(layer: Layer, color: str) -> list[Piece]:
    """A bar along the strike, a tick down the dip; on both sides where vertical, a cross where
    horizontal, a hook where overturned."""
    by = _quality(layer, "outlineStyle")
    strike, dip_direction = '"dip_direction_deg" - 90', '"dip_direction_deg"'
    half = 0.5 * TICK_MM
    both = f"{_FLAT} OR {_STEEP}"
    tick = {
        "size": f"CASE WHEN {_FLAT} THEN {BAR_MM} WHEN {_STEEP} THEN {2 * TICK_MM} "
        f"ELSE {TICK_MM} END",
        "offset": f"CASE WHEN {both} THEN '0,0' ELSE '0,{-half}' END",
    }
    pieces = [
        qml.stroke(BAR_MM, WIDTH_MM, color, angle=strike, offset="0,0", by=by),
        qml.stroke(
            TICK_MM, WIDTH_MM, color, angle=dip_direction, offset=f"0,{-half}", by={**by, **tick}
        ),
    ]
    if "overturned" in layer.columns:
        hook = qml.mark("half_arc", TICK_MM, color)
        values = {**hook.values, "outline_width": f"{WIDTH_MM:g}", "color": "0,0,0,0"}
        turned = {"angle": f"{dip_direction} + 180", "enabled": 'coalesce("overturned", false)'}
        pieces.append(Piece(hook.kind, values, turned))
    return pieces


def _arrow(layer: Layer, color: str) -> list[Piece]:
    """From the place along the trend; a head at both ends where horizontal."""
    by = _quality(layer, "outlineStyle")
    head = qml.mark("arrowhead", 1.8, color, offset=f"0,{-BAR_MM}")
    turned = {"angle": '"trend_deg" - 90'}
    values = {**head.values, "offset": f"{BAR_MM},0", "outline_width": f"{WIDTH_MM:g}"}
    back = {**values, "offset": "0,0"}
    return [
        qml.stroke(
            BAR_MM, WIDTH_MM, color, angle='"trend_deg"', offset=f"0,{-0.5 * BAR_MM}", by=by
        ),
        Piece(head.kind, values, turned),
        Piece(head.kind, back, {"angle": '"trend_deg" + 90', "enabled": 'abs("plunge_deg") < 0.5'}),
    ]


def _labels(layer: Layer) -> Labels | None:
    """The dip beside the tick, the plunge at the arrow's tip."""
    if layer.name == "planes":
        return Labels('round("dip_deg")', by={"OffsetXY": _beside("dip_direction_deg", _LABEL_MM)})
    if layer.name == "lines":
        away = BAR_MM + 2.4
        return Labels('round("plunge_deg")', by={"OffsetXY": _beside("trend_deg", away)})
    return None


def _beside(azimuth: str, away_mm: float) -> str:
    """Expression of an offset along an azimuth; on the page y runs down."""
    return (
        f"to_string({away_mm} * sin(radians(\"{azimuth}\"))) || ',' || "
        f'to_string(-{away_mm} * cos(radians("{azimuth}")))'
    )
