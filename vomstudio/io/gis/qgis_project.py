"""A map of QGIS (.qgs, from 3.22 on) whose layers are those of a GeoPackage beside it."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from dataclasses import dataclass
from uuid import NAMESPACE_OID, uuid5

from vomstudio.core.files.plain_characters import plain
from vomstudio.io.gis.qml import VERSION, Style, elements

_GEOMETRY = {"point": "Point", "line": "Line", "ring": "Polygon"}


@dataclass(frozen=True)
class MapLayer:
    """A layer of the GeoPackage with its style; extent: (x, y) of its lower and upper corner"""

    name: str
    style: Style
    extent: tuple[float, float, float, float]


def qgs(title: str, source: str, layers: Sequence[MapLayer], crs: str | None) -> str:
    """source: the GeoPackage's name in the same folder. layers: the uppermost first. crs: EPSG code
    or WKT, None where there is none."""
    root = ElementTree.Element("qgis", version=VERSION, projectname=title)
    ElementTree.SubElement(root, "title").text = title
    project_crs = ElementTree.SubElement(root, "projectCrs")
    project_crs.append(_crs(crs))
    tree = ElementTree.SubElement(root, "layer-tree-group")
    _no_properties(tree)
    for number, layer in enumerate(layers):
        node = ElementTree.SubElement(
            tree,
            "layer-tree-layer",
            id=_id(number, layer),
            name=layer.name,
            checked="Qt::Checked",
            expanded="1",
            providerKey="ogr",
            source=_source(source, layer),
        )
        _no_properties(node)
    custom = ElementTree.SubElement(tree, "custom-order", enabled="0")
    for number, layer in enumerate(layers):
        ElementTree.SubElement(custom, "item").text = _id(number, layer)
    canvas = ElementTree.SubElement(root, "mapcanvas", name="theMapCanvas", annotationsVisible="1")
    ElementTree.SubElement(canvas, "units").text = "meters"
    _extent(canvas, _around([layer.extent for layer in layers]))
    ElementTree.SubElement(canvas, "rotation").text = "0"
    ElementTree.SubElement(canvas, "destinationsrs").append(_crs(crs))
    held = ElementTree.SubElement(root, "projectlayers")
    for number, layer in enumerate(layers):
        _layer(held, number, layer, source, crs)
    order = ElementTree.SubElement(root, "layerorder")
    for number, layer in enumerate(layers):
        ElementTree.SubElement(order, "layer", id=_id(number, layer))
    properties = ElementTree.SubElement(root, "properties")
    reference = ElementTree.SubElement(properties, "SpatialRefSys")
    ElementTree.SubElement(reference, "ProjectionsEnabled", type="int").text = "1"
    paths = ElementTree.SubElement(properties, "Paths")
    # The map and its GeoPackage can be moved together.
    ElementTree.SubElement(paths, "Absolute", type="bool").text = "false"
    ElementTree.indent(root)
    head = "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n"
    return head + plain(ElementTree.tostring(root, encoding="unicode"))


def _no_properties(node: ElementTree.Element) -> None:
    """Without the empty list QGIS does not read the node."""
    ElementTree.SubElement(ElementTree.SubElement(node, "customproperties"), "Option")


def _layer(
    held: ElementTree.Element, number: int, layer: MapLayer, source: str, crs: str | None
) -> None:
    one = ElementTree.SubElement(
        held,
        "maplayer",
        type="vector",
        geometry=_GEOMETRY[layer.style.geometry],
        labelsEnabled="1" if layer.style.labels is not None else "0",
        readOnly="0",
        hasScaleBasedVisibilityFlag="0",
        refreshOnNotifyEnabled="0",
        simplifyDrawingHints="0",
    )
    _extent(one, layer.extent)
    ElementTree.SubElement(one, "id").text = _id(number, layer)
    ElementTree.SubElement(one, "datasource").text = _source(source, layer)
    ElementTree.SubElement(one, "layername").text = layer.name
    ElementTree.SubElement(one, "srs").append(_crs(crs))
    ElementTree.SubElement(one, "provider", encoding="UTF-8").text = "ogr"
    one.extend(elements(layer.style))


def _id(number: int, layer: MapLayer) -> str:
    """QGIS gives layers whose names are short another one, under which the tree has none."""
    return f"{layer.name}_{uuid5(NAMESPACE_OID, f'{layer.name} {number}')}".replace("-", "_")


def _source(source: str, layer: MapLayer) -> str:
    return f"./{source}|layername={layer.name}"


def _crs(crs: str | None) -> ElementTree.Element:
    root = ElementTree.Element("spatialrefsys", nativeFormat="Wkt")
    ElementTree.SubElement(root, "wkt").text = None if crs is None else _wkt(crs)
    if crs is not None and crs.startswith("EPSG:"):
        ElementTree.SubElement(root, "srid").text = crs.partition(":")[2]
        ElementTree.SubElement(root, "authid").text = crs
    return root


def _wkt(crs: str) -> str:
    from pyproj import CRS

    return str(CRS.from_user_input(crs).to_wkt())


def _extent(parent: ElementTree.Element, extent: tuple[float, float, float, float]) -> None:
    root = ElementTree.SubElement(parent, "extent")
    for name, value in zip(("xmin", "ymin", "xmax", "ymax"), extent, strict=True):
        ElementTree.SubElement(root, name).text = repr(float(value))


def _around(
    extents: Sequence[tuple[float, float, float, float]],
) -> tuple[float, float, float, float]:
    """All of them with a margin, so that symbols at the edge are whole."""
    if not extents:
        return 0.0, 0.0, 1.0, 1.0
    left, low, right, high = zip(*extents, strict=True)
    margin = 0.1 * max(max(right) - min(left), max(high) - min(low), 1.0)
    return min(left) - margin, min(low) - margin, max(right) + margin, max(high) + margin
