"""Vector files that would have GDAL open other files, ask servers, or never come to an end."""

from __future__ import annotations

import contextlib
import http.server
import json
import sqlite3
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyogrio
import pytest
import shapely

from tests.drawings import read_area, read_lines
from tests.frames import convert
from tests.messages import refused
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import InputError
from vomstudio.geometry.frames import Frame
from vomstudio.io.gis import vector_layers
from vomstudio.io.gis.line_reading import read_gis_lines
from vomstudio.io.text.set_columns import parse_rings
from vomstudio.project.imports.feature_lists import read_listed_features
from vomstudio.project.records import Model
from vomstudio.registration.by_model.stable import find_inside_polygons

SQUARE = [[0, 0], [300, 0], [300, 400], [0, 0]]


@pytest.fixture
def asked() -> Iterator[tuple[str, list[str]]]:
    """The address of a server on this machine, and what it was asked for."""
    pages: list[str] = []

    class Answer(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            pages.append(self.path)
            self.send_response(404)
            self.end_headers()

        do_HEAD = do_GET  # noqa: N815 - as the library names it

        def log_message(self, *_: object) -> None:
            pass

    server = http.server.HTTPServer(("127.0.0.1", 0), Answer)
    threading.Thread(target=server.serve_forever, args=(0.01,), daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/", pages
    server.shutdown()
    server.server_close()


def _polygons(path: Path) -> object:
    return find_inside_polygons(np.zeros((3, 3)), path)


READERS: list[Callable[[Path], object]] = [read_gis_lines, read_lines, read_area, _polygons]


def geojson(path: Path, kind: str, crs: dict[str, Any]) -> Path:
    coordinates = [SQUARE] if kind == "Polygon" else SQUARE
    shape = {"type": kind, "coordinates": coordinates}
    features = [{"type": "Feature", "properties": {}, "geometry": shape}]
    told = {"type": "FeatureCollection", "crs": crs, "features": features}
    path.write_text(json.dumps(told))
    return path


@pytest.mark.parametrize("read", READERS)
@pytest.mark.parametrize("kind", ["LineString", "Polygon"])
def test_the_crs_of_a_geojson_is_not_fetched(
    tmp_path: Path, asked: tuple[str, list[str]], read: Callable[[Path], object], kind: str
) -> None:
    address, pages = asked
    for number, crs in enumerate(
        (
            {"type": "link", "properties": {"href": f"{address}a", "type": "proj4"}},
            {"type": "url", "properties": {"url": f"{address}b"}},
            {"type": "name", "properties": {"name": f"{address}c"}},
        )
    ):
        with contextlib.suppress(InputError):
            read(geojson(tmp_path / f"{number}.geojson", kind, crs))
    assert pages == []


def refused_unasked(
    folder: Path, asked: tuple[str, list[str]], read: Callable[[Path], object], name: str
) -> None:
    """A virtual layer whose content lies on the network, or in another file, is not opened."""
    address, pages = asked
    geojson(folder / "private.geojson", "Polygon", {})
    for source in (f"/vsicurl/{address}x.geojson", str(folder / "private.geojson")):
        (folder / name).write_text(
            f'<OGRVRTDataSource><OGRVRTLayer name="contacts"><SrcDataSource>{source}'
            "</SrcDataSource><SrcLayer>private</SrcLayer></OGRVRTLayer></OGRVRTDataSource>"
        )
        with pytest.raises(InputError, match=name):
            read(folder / name)
    assert pages == []


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("read", READERS)
@pytest.mark.parametrize("name", ["a.geojson", "a.shp", "a.gpkg", "a.dxf", "a.vrt", "a.kml"])
def test_no_virtual_layer_is_opened(
    tmp_path: Path, asked: tuple[str, list[str]], read: Callable[[Path], object], name: str
) -> None:
    refused_unasked(tmp_path, asked, read, name)


@pytest.mark.parametrize("read", first_in_default_tier(READERS))
def test_unsafe_view_is_rejected_without_a_query(
    tmp_path: Path, read: Callable[[Path], object]
) -> None:
    path = tmp_path / "a.gpkg"
    wkb = np.array([shapely.to_wkb(shapely.Polygon(SQUARE))], object)
    pyogrio.raw.write(
        path, wkb, [], [], layer="real", geometry_type="Polygon", driver="GPKG", crs="EPSG:32633"
    )
    with contextlib.closing(sqlite3.connect(path)) as db, db:
        for table in ("gpkg_contents", "gpkg_geometry_columns"):
            columns = [row[1] for row in db.execute(f"PRAGMA table_info({table})")]
            given = ", ".join(
                "'endless'" if c in ("table_name", "identifier") else c for c in columns
            )
            db.execute(f"INSERT INTO {table} SELECT {given} FROM {table}")
        db.execute(
            "CREATE VIEW endless AS WITH RECURSIVE n(fid) AS (SELECT 1 UNION ALL SELECT fid + 1"
            " FROM n) SELECT n.fid, real.geom FROM n, real"
        )
    with pytest.raises(InputError) as error:
        read(path)
    assert (error.value.code, error.value.values["kind"]) == ("file.unsafe-schema", "view")


@pytest.mark.parametrize("driver", ["GPKG", "ESRI Shapefile", "GeoJSON", "DXF"])
@pytest.mark.filterwarnings("ignore")
def test_supported_formats_are_read(tmp_path: Path, driver: str) -> None:
    name = {"GPKG": "a.gpkg", "GeoJSON": "a.geojson", "DXF": "a.dxf"}.get(driver, "a.shp")
    wkb = np.array([shapely.to_wkb(shapely.LineString(SQUARE))], object)
    pyogrio.raw.write(
        tmp_path / name,
        wkb,
        [],
        [],
        geometry_type="LineString",
        driver=driver,
        crs=None if driver == "DXF" else "EPSG:32633",
    )
    assert len(read_gis_lines(tmp_path / name).lines) == 1
    assert len(read_lines(tmp_path / name).shapes) == 1


def test_kml_polygon_selects_points_in_the_project_crs(tmp_path: Path) -> None:
    (tmp_path / "a.kml").write_text(
        '<?xml version="1.0"?>\n<!-- drawn by hand -->\n'
        '<kml xmlns="http://www.opengis.net/kml/2.2"><Placemark><Polygon><outerBoundaryIs>'
        "<LinearRing><coordinates>14,45 15,45 15,46 14,45</coordinates></LinearRing>"
        "</outerBoundaryIs></Polygon></Placemark></kml>"
    )
    places = convert(np.array([[14.7, 45.1, 0.0], [14.2, 45.9, 0.0]]), "EPSG:32633", "EPSG:4326")
    inside, _ = find_inside_polygons(places, tmp_path / "a.kml", "EPSG:32633")
    assert inside.tolist() == [True, False]


@pytest.mark.parametrize("name", ["stations.geojson", "contacts.gpkg", "contacts.vrt", "a.kml"])
def test_no_virtual_layer_of_stations_and_contacts_is_opened(
    tmp_path: Path, asked: tuple[str, list[str]], name: str
) -> None:
    refused_unasked(tmp_path, asked, _listed, name)


def test_station_table_of_arbitrary_bytes_raises_input_error(tmp_path: Path) -> None:
    path = tmp_path / "stations.csv"
    for data in (
        b"name,x,y,z\na,1,2,3\n" + b"b," + b"9" * 200_000 + b",2,3\n",
        b"\xff\xfe\x00",
        b"name,x,y,z\n\xed\xa0\x80,1,2,3\n",
        b'name,x,y,z\n"a\0,1,2\n' * 3,
    ):
        path.write_bytes(data)
        with pytest.raises(InputError, match=r"stations\.csv"):
            _listed(path)


def _listed(path: Path) -> Any:
    model = Model("m1", "cliff", "cliff.obj", "mesh", "0" * 64, Frame("crs", "EPSG:32633"))
    return read_listed_features(path, model, {"m1": model}, "EPSG:32633")


@pytest.mark.parametrize("deep", [20, 1000, 300_000])
def test_deeply_nested_wkt_does_not_crash_the_process(tmp_path: Path, deep: int) -> None:
    """GEOS goes down with every bracket, to the end of the stack."""
    text = "GEOMETRYCOLLECTION Z (" * deep + "POINT Z (1 2 3)" + ")" * deep
    path = tmp_path / "stations.csv"
    path.write_text(f'name,wkt\na,"{text}"\n')
    with pytest.raises(InputError, match=r"stations\.csv"):
        _listed(path)
    with pytest.raises(shapely.errors.GEOSException):
        parse_rings(["POLYGON Z ((0 0 1, 1 0 1, 1 1 1, 0 0 1))", None, text])
    many = ", ".join("((0 0 1, 1 0 1, 1 1 1, 0 0 1))" for _ in range(50))
    assert [len(ring) for ring in parse_rings([f"MULTIPOLYGON Z ({many})", None])] == [3, 0]


def test_unknown_table_crs_is_reported_and_invalid_areas_are_ignored(tmp_path: Path) -> None:
    path = tmp_path / "lithologies.csv"
    ring = "POLYGON Z ((0 0 1, 1 0 1, 1 1 1, 0 0 1))"
    for crs in ("EPSG:3>", "EPSG:" + "9" * 70, "EPSG:326338"):
        path.write_text(f'# CRS: {crs}\nname,wkt\na,"{ring}"\n')
        assert [each.code for each in _listed(path).warnings] == ["frame.crs-unreadable"]
    for area in ("inf", "nan", "-1", "1e999", "x"):
        path.write_text(f'# CRS: EPSG:32633\nname,area_m2,wkt\na,{area},"{ring}"\n')
        assert _listed(path).features[0].area is None


@pytest.mark.parametrize("read", first_in_default_tier(READERS))
def test_too_many_layer_entries_are_rejected(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, read: Callable[[Path], object]
) -> None:
    monkeypatch.setattr(vector_layers, "MAX_OBJECTS", 4)
    path = tmp_path / "contours.gpkg"
    refusals: list[str | None] = []
    for count in (4, 5):
        wkb = np.array([shapely.to_wkb(shapely.Polygon(SQUARE))] * count, object)
        path.unlink(missing_ok=True)
        pyogrio.raw.write(
            path, wkb, [], [], layer="a", geometry_type="Polygon", driver="GPKG", crs="EPSG:32633"
        )
        try:
            read(path)
            refusals.append(None)
        except InputError as error:
            refusals.append(error.code)
    assert refusals[0] != "file.too-many-parts"
    assert refusals[1] == "file.too-many-parts"


def test_the_entries_of_all_layers_are_counted_together(tmp_path, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    monkeypatch.setattr(vector_layers, "MAX_OBJECTS", 4)
    path = tmp_path / "contours.gpkg"
    wkb = np.array([shapely.to_wkb(shapely.Polygon(SQUARE))] * 3, object)
    for name in "ab":
        pyogrio.raw.write(
            path,
            wkb,
            [],
            [],
            layer=name,
            geometry_type="Polygon",
            driver="GPKG",
            crs="EPSG:32633",
            append=name == "b",
        )
    with refused("file.too-many-parts", limit=4, parts="entries"):
        read_gis_lines(path)


@pytest.mark.full
def test_large_file_with_too_many_entries_is_rejected_by_the_subprocess(tmp_path) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "points.shp"
    wkb = np.array([shapely.to_wkb(shapely.Point(3, 4))] * 300_001, object)
    pyogrio.raw.write(path, wkb, [], [], geometry_type="Point", crs="EPSG:32633")
    with refused("file.too-many-parts", limit=300_000, file=path):
        read_gis_lines(path)


def test_kml_with_too_many_tags_is_rejected_before_gdal_reads_it(tmp_path) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "k.kml"
    begin = '<kml xmlns="http://www.opengis.net/kml/2.2"><Document>'
    path.write_text(begin + "<Placemark/>" * 2_000_000 + "</Document></kml>")
    with refused("file.too-many-parts", limit=2000000):
        read_gis_lines(path)
