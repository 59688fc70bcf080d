"""Layers as KML 2.2 for Google Earth and similar programs, in WGS 84 degrees.

Planes and lines are drawn as map symbols at their heights; traces, lineations and patches are drawn
with their own geometry. Each feature type has its colour. Heights are those of the project and are
not converted; KML defines them as heights above the geoid.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.plain_characters import replace_control_characters
from vomstudio.core.findings import Finding
from vomstudio.geology.map_symbols import strike_and_dip_symbol, symbol_size, trend_arrow
from vomstudio.io.exchange.geojson import feature_properties
from vomstudio.io.gis.crs import to_degrees
from vomstudio.io.gis.layers import Layer

_NAMESPACE = "http://www.opengis.net/kml/2.2"
_WHITE = "#ffffff"


DescribeFunction = Callable[[str, Any], tuple[str, str]]
"""Function that returns the title of a column and the text of its value."""


def kml_text(
    out: Path,
    layers: Sequence[Layer],
    crs: str | None,
    colors: Mapping[str, str],
    title: str,
    *,
    describe: DescribeFunction = lambda column, value: (column, str(value)),
) -> str:
    """Return the KML text of the layers.

    Parameters
    ----------
    out : Path
        Path of the file to which the text will be written.
    layers : sequence of Layer
    crs : str or None
        CRS of the layers.
    colors : mapping of str to str
        Colours as "#rrggbb" by the name of the feature type in lower case.
    title : str
    describe : callable
        Function that returns the title and text of an attribute for the balloon of a feature.

    Raises
    ------
    InputError
        If the project has no CRS, or if a position is outside the area of the CRS.
    """
    if crs is None:
        raise InputError(Finding("kml.no-crs"), file=out)
    shapes = [shape for layer in layers for shape in layer.shapes]
    size = symbol_size(np.concatenate(shapes)) if shapes else 1.0
    root = ElementTree.Element("kml", xmlns=_NAMESPACE)
    document = _add_element(root, "Document")
    _add_element(document, "name", title)
    styles: dict[str, str] = {}
    for layer in layers:
        for color in dict.fromkeys(layer.colors_by_class(colors, _WHITE).values()):
            if color not in styles:
                styles[color] = f"style{len(styles)}"
                _add_style(document, styles[color], color)
    for layer in layers:
        folder = _add_element(document, "Folder")
        _add_element(folder, "name", layer.name)
        class_colors = layer.colors_by_class(colors, _WHITE)
        for row, word in enumerate(layer.classes):
            style = styles[class_colors[word]]
            placemark = _add_placemark(folder, layer, row, style, describe)
            _add_geometry(placemark, layer, row, _feature_lines(layer, row, size), crs, out)
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + replace_control_characters(
        ElementTree.tostring(root, encoding="unicode")
    )


def _feature_lines(layer: Layer, row: int, size: float) -> list[FloatArray]:
    """Return the polylines that represent a feature."""
    shape = layer.shapes[row]
    figures = feature_properties(layer, row)
    if layer.kind != "point":
        return [shape]
    if "dip_deg" in figures:
        is_overturned = bool(figures.get("overturned", False))
        angles = figures["dip_direction_deg"], figures["dip_deg"]
        return strike_and_dip_symbol(shape[0], *angles, size, is_overturned)
    if "plunge_deg" in figures:
        return trend_arrow(shape[0], figures["trend_deg"], figures["plunge_deg"], size)
    return []


def _add_placemark(
    folder: ElementTree.Element,
    layer: Layer,
    row: int,
    style: str,
    describe: DescribeFunction,
) -> ElementTree.Element:
    figures = feature_properties(layer, row)
    placemark = _add_element(folder, "Placemark")
    _add_element(placemark, "name", str(figures.get("name") or figures.get("id") or layer.name))
    _add_element(placemark, "styleUrl", f"#{style}")
    extended_data = _add_element(placemark, "ExtendedData")
    for name, value in figures.items():
        data = _add_element(extended_data, "Data", name=name)
        title, text = describe(name, value)
        _add_element(data, "displayName", title)
        _add_element(data, "value", text)
    return placemark


def _add_geometry(
    placemark: ElementTree.Element,
    layer: Layer,
    row: int,
    parts: Sequence[FloatArray],
    crs: str,
    out: Path,
) -> None:
    multi_geometry = _add_element(placemark, "MultiGeometry")
    if layer.kind == "point":
        _add_coordinates(_add_element(multi_geometry, "Point"), layer.shapes[row], crs, out)
    for part in parts:
        if layer.kind == "ring":
            area = _add_element(multi_geometry, "Polygon")
            _add_element(area, "altitudeMode", "absolute")
            boundary = _add_element(area, "outerBoundaryIs")
            _add_coordinates(
                _add_element(boundary, "LinearRing"), np.vstack([part, part[:1]]), crs, out
            )
        else:
            _add_coordinates(_add_element(multi_geometry, "LineString"), part, crs, out)


def _add_coordinates(parent: ElementTree.Element, points: FloatArray, crs: str, out: Path) -> None:
    degrees = to_degrees(crs, points[:, 0], points[:, 1])
    if degrees is None:
        raise InputError(Finding("kml.outside-area", crs=crs[:60]), file=out)
    _add_element(parent, "altitudeMode", "absolute")
    vertices = zip(*degrees, points[:, 2], strict=True)
    _add_element(
        parent, "coordinates", " ".join(f"{x:.9f},{y:.9f},{z:.4f}" for x, y, z in vertices)
    )


def _add_style(document: ElementTree.Element, name: str, color: str) -> None:
    # KML colours are in the order alpha, blue, green, red.
    red, green, blue = (color[i : i + 2] for i in (1, 3, 5))
    kml_color = f"ff{blue}{green}{red}".lower()
    style = _add_element(document, "Style", id=name)
    icon = _add_element(style, "IconStyle")
    _add_element(icon, "color", kml_color)
    _add_element(icon, "scale", "0.4")
    _add_element(_add_element(style, "LabelStyle"), "scale", "0.7")
    line = _add_element(style, "LineStyle")
    _add_element(line, "color", kml_color)
    _add_element(line, "width", "2")
    _add_element(_add_element(style, "PolyStyle"), "color", f"59{kml_color[2:]}")


def _add_element(
    parent: ElementTree.Element, tag: str, text: str | None = None, **attributes: str
) -> ElementTree.Element:
    child = ElementTree.SubElement(parent, tag, attributes)
    if text is not None:
        # Characters that are not allowed in XML would make the file unreadable.
        child.text = "".join(
            character for character in text if character >= " " or character in "\n\t"
        )
    return child
