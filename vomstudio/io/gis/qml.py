"""QGIS styles for map layers (QML, version 3.22 or later).

Symbols depend on the type of a feature, and are rotated and labelled according to its attributes. A
saved style has a categorised renderer with one symbol per value of an attribute. Symbols consist of
symbol layers, whose properties may be expressions. Labels use QGIS's simple labelling.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from vomstudio.core.files.plain_characters import replace_control_characters

VERSION = "3.22.16"
Geometry = Literal["point", "line", "ring"]
_SYMBOL_TYPES = {"point": "marker", "line": "line", "ring": "fill"}
_GEOMETRY_TYPES = {"point": "0", "line": "1", "ring": "2"}


@dataclass(frozen=True)
class SymbolLayer:
    """Layer of a symbol.

    Parameters
    ----------
    kind : str
        Name in QGIS: SimpleMarker, SimpleLine or SimpleFill.
    values : mapping of str to str
        Properties of the symbol layer.
    by : mapping of str to str
        Properties that are defined by expressions.
    """

    kind: str
    values: Mapping[str, str]
    by: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class RendererCategory:
    """Symbol of the features with one value of the attribute; "" stands for all other values."""

    value: str
    label: str
    pieces: Sequence[SymbolLayer]


@dataclass(frozen=True)
class Labels:
    """Labels of a layer.

    Parameters
    ----------
    expression : str
        Expression for the text.
    by : mapping of str to str
        Placement properties defined by expressions (OffsetXY in millimetres).
    """

    expression: str
    color: str = "#1a1a1a"
    size_pt: float = 8.0
    by: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Style:
    """Style of a layer.

    Parameters
    ----------
    attribute : str or None
        Attribute whose values define the categories, or None for a single symbol.
    tip : str or None
        Expression for the map tip.
    """

    geometry: Geometry
    categories: Sequence[RendererCategory]
    attribute: str | None = None
    labels: Labels | None = None
    tip: str | None = None


def qml(style: Style) -> str:
    """Return a style as the text of a QML file."""
    root = ElementTree.Element("qgis", version=VERSION)
    root.extend(elements(style))
    ElementTree.SubElement(root, "layerGeometryType").text = _GEOMETRY_TYPES[style.geometry]
    ElementTree.indent(root)
    header = "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n"
    return header + replace_control_characters(ElementTree.tostring(root, encoding="unicode"))


def elements(style: Style) -> list[ElementTree.Element]:
    """Return the XML elements of a style, for a style file or a project layer."""
    children = [_renderer(style)]
    if style.labels is not None:
        children.append(_labeling(style.labels))
    if style.tip is not None:
        tip = ElementTree.Element("mapTip")
        tip.text = style.tip
        children.append(tip)
    return children


def _renderer(style: Style) -> ElementTree.Element:
    type_ = "singleSymbol" if style.attribute is None else "categorizedSymbol"
    root = ElementTree.Element(
        "renderer-v2", type=type_, enableorderby="0", symbollevels="0", forceraster="0"
    )
    if style.attribute is not None:
        root.set("attr", style.attribute)
        categories = ElementTree.SubElement(root, "categories")
        for index, category in enumerate(style.categories):
            ElementTree.SubElement(
                categories,
                "category",
                value=category.value,
                label=category.label,
                symbol=str(index),
                render="true",
            )
    symbols = ElementTree.SubElement(root, "symbols")
    for index, category in enumerate(style.categories):
        symbol = ElementTree.SubElement(
            symbols,
            "symbol",
            type=_SYMBOL_TYPES[style.geometry],
            name=str(index),
            alpha="1",
            clip_to_extent="1",
            force_rhr="0",
        )
        for piece in category.pieces:
            _add_symbol_layer(symbol, piece)
    return root


def _add_symbol_layer(symbol: ElementTree.Element, piece: SymbolLayer) -> None:
    layer = ElementTree.SubElement(
        symbol, "layer", {"class": piece.kind, "enabled": "1", "locked": "0", "pass": "0"}
    )
    values = ElementTree.SubElement(layer, "Option", type="Map")
    for name, value in piece.values.items():
        _add_option(values, name, value)
    _add_properties(layer, "data_defined_properties", piece.by)


def _add_properties(
    parent: ElementTree.Element, tag: str, expression_by_property: Mapping[str, str]
) -> None:
    root = ElementTree.SubElement(parent, tag)
    options = ElementTree.SubElement(root, "Option", type="Map")
    _add_option(options, "name", "")
    properties = ElementTree.SubElement(options, "Option", name="properties", type="Map")
    for name, expression in expression_by_property.items():
        entry = ElementTree.SubElement(properties, "Option", name=name, type="Map")
        _add_option(entry, "active", "true", "bool")
        _add_option(entry, "expression", expression)
        # 3 is QGIS's code for an expression, and 2 its code for a field.
        _add_option(entry, "type", "3", "int")
    _add_option(options, "type", "collection")


def _add_option(parent: ElementTree.Element, name: str, value: str, type_: str = "QString") -> None:
    ElementTree.SubElement(parent, "Option", name=name, value=value, type=type_)


def _labeling(labels: Labels) -> ElementTree.Element:
    root = ElementTree.Element("labeling", type="simple")
    settings = ElementTree.SubElement(root, "settings", calloutType="simple")
    text = ElementTree.SubElement(
        settings,
        "text-style",
        fieldName=labels.expression,
        isExpression="1",
        fontFamily="Sans Serif",
        fontSize=f"{labels.size_pt:g}",
        fontSizeUnit="Point",
        fontWeight="50",
        textColor=rgba(labels.color),
        textOpacity="1",
        namedStyle="Regular",
    )
    ElementTree.SubElement(
        text,
        "text-buffer",
        bufferDraw="1",
        bufferSize="0.6",
        bufferSizeUnits="MM",
        bufferColor="255,255,255,255",
        bufferOpacity="0.8",
    )
    ElementTree.SubElement(
        settings,
        "placement",
        placement="1",
        quadOffset="4",
        offsetType="0",
        offsetUnits="MM",
        xOffset="0",
        yOffset="0",
        priority="5",
        dist="0",
    )
    ElementTree.SubElement(
        settings,
        "rendering",
        drawLabels="1",
        displayAll="1",
        obstacle="0",
        scaleVisibility="0",
        labelPerPart="0",
        mergeLines="0",
        upsidedownLabels="0",
        fontLimitPixelSize="0",
        minFeatureSize="0",
        obstacleFactor="1",
        obstacleType="0",
        limitNumLabels="0",
        maxNumLabels="2000",
        scaleMin="0",
        scaleMax="0",
        zIndex="0",
        fontMinPixelSize="3",
        fontMaxPixelSize="10000",
    )
    _add_properties(settings, "dd_properties", labels.by)
    return root


def rgba(color: str, alpha: int = 255) -> str:
    """Convert "#rrggbb" to the colour notation of QGIS."""
    red, green, blue = (int(color[i : i + 2], 16) for i in (1, 3, 5))
    return f"{red},{green},{blue},{alpha}"


# Common elements ---------------------------------------------------------------------------------


def stroke(
    length_mm: float,
    width_mm: float,
    color: str,
    *,
    angle: str,
    offset: str,
    expression_by_property: Mapping[str, str],
) -> SymbolLayer:
    """Return a marker that consists of a straight line.

    Parameters
    ----------
    length_mm, width_mm : float
        Length and width of the line.
    color : str
    angle : str
        Expression for the rotation in degrees, clockwise from up.
    offset : str
        Offset "x,y" in millimetres before the rotation, with y down.
    expression_by_property : mapping
        Further properties defined by expressions, by name.
    """
    values = {
        "name": "line",
        "size": f"{length_mm:g}",
        "size_unit": "MM",
        "offset": offset,
        "offset_unit": "MM",
        "outline_color": rgba(color),
        "outline_style": "solid",
        "outline_width": f"{width_mm:g}",
        "outline_width_unit": "MM",
        "cap_style": "square",
        "joinstyle": "miter",
        "color": rgba(color),
        "horizontal_anchor_point": "1",
        "vertical_anchor_point": "1",
        "scale_method": "diameter",
        "angle": "0",
    }
    return SymbolLayer("SimpleMarker", values, {"angle": angle, **expression_by_property})


def mark(
    name: str,
    size_mm: float,
    color: str,
    *,
    offset: str = "0,0",
    expression_by_property: Mapping[str, str] = {},
) -> SymbolLayer:
    """Return a filled simple marker of QGIS."""
    values = {
        "name": name,
        "size": f"{size_mm:g}",
        "size_unit": "MM",
        "offset": offset,
        "offset_unit": "MM",
        "color": rgba(color),
        "outline_color": rgba(color),
        "outline_style": "solid",
        "outline_width": "0.2",
        "outline_width_unit": "MM",
        "joinstyle": "miter",
        "cap_style": "square",
        "horizontal_anchor_point": "1",
        "vertical_anchor_point": "1",
        "scale_method": "diameter",
        "angle": "0",
    }
    return SymbolLayer("SimpleMarker", values, expression_by_property)


def line(width_mm: float, color: str, expression_by_property: Mapping[str, str]) -> SymbolLayer:
    """Return a solid line."""
    values = {
        "line_color": rgba(color),
        "line_style": "solid",
        "line_width": f"{width_mm:g}",
        "line_width_unit": "MM",
        "capstyle": "round",
        "joinstyle": "round",
        "offset": "0",
        "offset_unit": "MM",
        "use_custom_dash": "0",
    }
    return SymbolLayer("SimpleLine", values, expression_by_property)


def fill(color: str, expression_by_property: Mapping[str, str]) -> SymbolLayer:
    """Return a transparent fill with an outline."""
    values = {
        "color": rgba(color, 70),
        "style": "solid",
        "outline_color": rgba(color),
        "outline_style": "solid",
        "outline_width": "0.3",
        "outline_width_unit": "MM",
        "joinstyle": "round",
        "offset": "0,0",
        "offset_unit": "MM",
    }
    return SymbolLayer("SimpleFill", values, expression_by_property)
