"""Maps of QGIS: what it reads of the GeoPackage and of the project beside it.

The same files were opened in QGIS 3.22.16: all layers with their symbols, turned and labelled.
"""

from __future__ import annotations

import shutil
import sqlite3
import xml.etree.ElementTree as ElementTree
from contextlib import closing
from pathlib import Path

import pytest

from vomstudio.io.gis import qml
from vomstudio.io.gis.qgis_project import MapLayer, qgs
from vomstudio.io.gis.qml import RendererCategory, Style
from vomstudio.project.exports.export import export_project

SPECIMEN = Path(__file__).parents[1] / "specimens" / "schema1.vom"


@pytest.fixture(scope="module")
def exported(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("map")
    shutil.copytree(SPECIMEN, folder / "a.vom")
    export_project(folder / "a.vom", "gpkg", folder / "a.gpkg")
    return folder / "a.gpkg"


def styles(path: Path) -> dict[str, ElementTree.Element]:
    with closing(sqlite3.connect(path)) as file:
        rows = file.execute(
            "SELECT f_table_name, f_geometry_column, useAsDefault, styleQML FROM layer_styles"
        ).fetchall()
    assert all(column == "geom" and default for _, column, default, _ in rows)
    return {name: ElementTree.fromstring(text) for name, _, _, text in rows}


def test_geopackage_version_is_supported_by_long_term_releases_of_qgis(exported) -> None:
    """QGIS 3.22 warns of version 1.4 of the GeoPackage, which `user_version` tells."""
    with closing(sqlite3.connect(exported)) as file:
        (version,) = file.execute("PRAGMA user_version").fetchone()
        (geometry,) = file.execute(
            "SELECT column_name FROM gpkg_geometry_columns WHERE table_name = 'planes'"
        ).fetchone()
    assert 10000 <= version <= 10300
    assert geometry == "geom"


def test_every_layer_has_a_style(exported) -> None:
    import pyogrio

    layers = {name for name, kind in pyogrio.list_layers(exported) if kind is not None}
    assert styles(exported).keys() == layers


def test_planes_are_turned_by_their_azimuth_and_labelled_with_their_dip(exported) -> None:
    planes = styles(exported)["planes"]
    angles = {
        found.get("value")
        for option in planes.iter("Option")
        if option.get("name") == "angle" and option.get("type") == "Map"
        for found in option
        if found.get("name") == "expression"
    }
    assert {'"dip_direction_deg" - 90', '"dip_direction_deg"'} <= angles
    (text,) = planes.iter("text-style")
    assert text.get("fieldName") == 'round("dip_deg")'


def test_types_have_the_colours_of_the_project(exported) -> None:
    planes = styles(exported)["planes"]
    (renderer,) = planes.iter("renderer-v2")
    assert renderer.get("attr") == "kind"
    symbols = {c.get("value"): c.get("symbol") for c in renderer.iter("category")}
    (symbol,) = [s for s in renderer.iter("symbol") if s.get("name") == symbols["bedding"]]
    colors = {o.get("value") for o in symbol.iter("Option") if o.get("name") == "outline_color"}
    assert colors == {"0,114,178,255"}


def test_verdict_determines_the_line_style(exported) -> None:
    traces = styles(exported)["traces"]
    said = [o.get("value", "") for o in traces.iter("Option") if o.get("name") == "expression"]
    assert said
    assert all("'poor' THEN 'dot'" in text for text in said)


def test_map_finds_its_layers_after_both_files_are_moved(exported) -> None:
    root = ElementTree.parse(exported.with_suffix(".qgs")).getroot()
    sources = [layer.findtext("datasource") for layer in root.iter("maplayer")]
    assert "./a.gpkg|layername=planes" in sources
    drawn = [node.get("id") for node in root.iter("layer-tree-layer")]
    assert drawn == [layer.findtext("id") for layer in root.iter("maplayer")]
    # Of a shorter name QGIS makes another one, and the tree would be empty.
    assert all(id_ is not None and len(id_) >= 17 for id_ in drawn)
    geometries = [layer.get("geometry") for layer in root.iter("maplayer")]
    assert geometries == sorted(geometries, key=["Point", "Line", "Polygon"].index)


def test_the_map_has_the_reference_system_of_its_layers() -> None:
    style = Style("point", [RendererCategory("", "all", [qml.mark("circle", 2, "#000000")])])
    text = qgs("t", "t.gpkg", [MapLayer("planes", style, (0, 0, 10, 10))], "EPSG:32633")
    root = ElementTree.fromstring(text)
    assert {e.text for e in root.iter("authid")} == {"EPSG:32633"}
    assert root.findtext("properties/SpatialRefSys/ProjectionsEnabled") == "1"


def test_names_with_xml_characters_are_kept(tmp_path) -> None:
    style = Style(
        "line", [RendererCategory('a "b" <c> & d', "a", [qml.line(0.3, "#102030", {})])], "kind"
    )
    (category,) = ElementTree.fromstring(qml.qml(style)).iter("category")
    assert category.get("value") == 'a "b" <c> & d'
