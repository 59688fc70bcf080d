"""QGIS project (.qgs, version 3.22 or later) with the layers of a GeoPackage next to it."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from dataclasses import dataclass
from uuid import NAMESPACE_OID, uuid5

from vomstudio.core.files.plain_characters import replace_control_characters
from vomstudio.io.gis.qml import VERSION, Style, elements

_GEOMETRY_TYPES = {"point": "Point", "line": "Line", "ring": "Polygon"}


@dataclass(frozen=True)
class MapLayer:
    """Layer of the GeoPackage with its style.

    Parameters
    ----------
    extent : tuple of float
        x and y of the lower-left and upper-right corners.
    """

    name: str
    style: Style
    extent: tuple[float, float, float, float]


def qgs(title: str, source: str, layers: Sequence[MapLayer], crs: str | None) -> str:
    """Return the text of a QGIS project.

    Parameters
    ----------
    title : str
    source : str
        File name of the GeoPackage in the same folder.
    layers : sequence of MapLayer
        Layers, starting with the uppermost one.
    crs : str or None
        EPSG code or WKT, or None for a local frame.
    """
    root = ElementTree.Element("qgis", version=VERSION, projectname=title)
    ElementTree.SubElement(root, "title").text = title
    project_crs = ElementTree.SubElement(root, "projectCrs")
    project_crs.append(_crs(crs))
    tree = ElementTree.SubElement(root, "layer-tree-group")
    _add_empty_properties(tree)
    for index, layer in enumerate(layers):
        node = ElementTree.SubElement(
            tree,
            "layer-tree-layer",
            id=_id(index, layer),
            name=layer.name,
            checked="Qt::Checked",
            expanded="1",
            providerKey="ogr",
            source=_source(source, layer),
        )
        _add_empty_properties(node)
    custom_order = ElementTree.SubElement(tree, "custom-order", enabled="0")
    for index, layer in enumerate(layers):
        ElementTree.SubElement(custom_order, "item").text = _id(index, layer)
    canvas = ElementTree.SubElement(root, "mapcanvas", name="theMapCanvas", annotationsVisible="1")
    ElementTree.SubElement(canvas, "units").text = "meters"
    _add_extent(canvas, _common_extent([layer.extent for layer in layers]))
    ElementTree.SubElement(canvas, "rotation").text = "0"
    ElementTree.SubElement(canvas, "destinationsrs").append(_crs(crs))
    map_layers = ElementTree.SubElement(root, "projectlayers")
    for index, layer in enumerate(layers):
        _add_layer(map_layers, index, layer, source, crs)
    layer_order = ElementTree.SubElement(root, "layerorder")
    for index, layer in enumerate(layers):
        ElementTree.SubElement(layer_order, "layer", id=_id(index, layer))
    properties = ElementTree.SubElement(root, "properties")
    reference = ElementTree.SubElement(properties, "SpatialRefSys")
    ElementTree.SubElement(reference, "ProjectionsEnabled", type="int").text = "1"
    paths = ElementTree.SubElement(properties, "Paths")
    # The map and its GeoPackage can be moved together.
    ElementTree.SubElement(paths, "Absolute", type="bool").text = "false"
    ElementTree.indent(root)
    header = "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n"
    return header + replace_control_characters(ElementTree.tostring(root, encoding="unicode"))


def _add_empty_properties(node: ElementTree.Element) -> None:
    """Add an empty list of properties, without which QGIS does not read the node."""
    ElementTree.SubElement(ElementTree.SubElement(node, "customproperties"), "Option")


def _add_layer(
    map_layers: ElementTree.Element, index: int, layer: MapLayer, source: str, crs: str | None
) -> None:
    layer_element = ElementTree.SubElement(
        map_layers,
        "maplayer",
        type="vector",
        geometry=_GEOMETRY_TYPES[layer.style.geometry],
        labelsEnabled="1" if layer.style.labels is not None else "0",
        readOnly="0",
        hasScaleBasedVisibilityFlag="0",
        refreshOnNotifyEnabled="0",
        simplifyDrawingHints="0",
    )
    _add_extent(layer_element, layer.extent)
    ElementTree.SubElement(layer_element, "id").text = _id(index, layer)
    ElementTree.SubElement(layer_element, "datasource").text = _source(source, layer)
    ElementTree.SubElement(layer_element, "layername").text = layer.name
    ElementTree.SubElement(layer_element, "srs").append(_crs(crs))
    ElementTree.SubElement(layer_element, "provider", encoding="UTF-8").text = "ogr"
    layer_element.extend(elements(layer.style))


def _id(index: int, layer: MapLayer) -> str:
    """Return a unique ID of a layer.

    It is long because QGIS renames layers with short IDs, but not in the layer tree.
    """
    return f"{layer.name}_{uuid5(NAMESPACE_OID, f'{layer.name} {index}')}".replace("-", "_")


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


def _add_extent(parent: ElementTree.Element, extent: tuple[float, float, float, float]) -> None:
    root = ElementTree.SubElement(parent, "extent")
    for name, value in zip(("xmin", "ymin", "xmax", "ymax"), extent, strict=True):
        ElementTree.SubElement(root, name).text = repr(float(value))


def _common_extent(
    extents: Sequence[tuple[float, float, float, float]],
) -> tuple[float, float, float, float]:
    """Return the common extent with a margin so that symbols at the edge are complete."""
    if not extents:
        return 0.0, 0.0, 1.0, 1.0
    west, south, east, north = zip(*extents, strict=True)
    margin = 0.1 * max(max(east) - min(west), max(north) - min(south), 1.0)
    return min(west) - margin, min(south) - margin, max(east) + margin, max(north) + margin
