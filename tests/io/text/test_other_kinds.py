"""Files of another kind given to a reader of tables are named by their content."""

from __future__ import annotations

import io
import json
import sqlite3
import zipfile
from pathlib import Path

import ezdxf
import numpy as np
import pyogrio
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from vomstudio.core.errors import InputError
from vomstudio.core.files.file_kinds import HEAD_BYTES, recognise_kind
from vomstudio.io.models.opening import read_model
from vomstudio.io.photos.own_cameras.reading import read_camera_file
from vomstudio.io.text.tables import read_table


def _json(value: object) -> bytes:
    return json.dumps(value, indent=1).encode()


def _zip(*names: str) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name in names:
            is_ods = name == "mimetype"
            archive.writestr(
                name, "application/vnd.oasis.opendocument.spreadsheet" if is_ods else ""
            )
    return stream.getvalue()


def _picture(kind: str) -> bytes:
    stream = io.BytesIO()
    Image.new("RGB", (300, 200)).save(stream, kind)
    return stream.getvalue()


_FEATURE = {"type": "Feature", "properties": {"dip": 30}, "geometry": None}
_SHOT = {"id": "G1", "observations": [{"shot_id": "a.jpg", "projection": [0, 0]}]}
CONTENTS = [
    ("geojson", _json({"type": "FeatureCollection", "features": [_FEATURE]})),
    ("geojson", b"\xef\xbb\xbf" + _json({"name": "x", "type": "FeatureCollection"})),
    ("geojson", ("﻿" + json.dumps(_FEATURE)).encode("utf-16")),
    ("geojson", b"\x1e" + json.dumps(_FEATURE).encode() + b"\n"),
    ("topojson", _json({"type": "Topology", "objects": {}})),
    ("esri-json", _json({"displayFieldName": "", "geometryType": "esriGeometryPoint"})),
    ("opensfm-gcp", _json({"points": [_SHOT]})),
    ("opensfm", _json([{"cameras": {}, "shots": {}}])),
    ("openmvg", _json({"sfm_data_version": "0.3", "views": []})),
    ("alicevision", _json({"version": ["1"], "views": [{"viewId": "1"}]})),
    ("nerf", _json({"frames": [{"transform_matrix": []}]})),
    ("json", _json({"a": [1, 2]})),
    ("json", _json([[1, 2], [3, 4]])),
    ("bundler", b"# Bundle file v0.3\n2 0\n1000.0 0.0 0.0\n"),
    ("nvm", b"NVM_V3\n\n2\n"),
    ("colmap", b"# Image list with two lines of data per image:\n#   IMAGE_ID\n"),
    ("kml", b'<?xml version="1.0"?>\n<!-- x -->\n<kml xmlns="http://www.opengis.net/kml/2.2">'),
    ("gpx", b'<gpx version="1.1">'),
    ("svg", b'<svg xmlns="http://www.w3.org/2000/svg">'),
    ("html", b"<!DOCTYPE html>\n<html><head>"),
    ("metashape-xml", b'<?xml version="1.0"?>\n<document version="1.5">\n <chunk label="1">'),
    ("blocks-exchange", b'<?xml version="1.0"?>\n<BlocksExchange version="3.2">'),
    ("xml", b'<?xml version="1.0"?><planes/>'),
    ("dxf", b"  0\r\nSECTION\r\n  2\r\nHEADER\r\n"),
    ("dxf", b"999\nVOM Studio\n0\nSECTION\n2\nHEADER\n"),
    ("dxf", b"AutoCAD Binary DXF\r\n\x1a\0\0"),
    ("dwg", b"AC1032\0\0\0\0\0"),
    ("shapefile", b"\0\0\x27\x0a" + bytes(96)),
    ("esri-grid", b"ncols 3\nnrows 2\nxllcorner 0\n"),
    ("gocad", b"GOCAD TSurf 1\nHEADER {\nname: a\n}\n"),
    ("ply", b"ply\nformat ascii 1.0\nelement vertex 3\n"),
    ("obj", b"# made\nmtllib a.mtl\nv 1 2 3\n"),
    ("obj", b"v 1 2 3\nv 4 5 6\nv 7 8 9\n"),
    ("stl", b"solid x\n facet normal 0 0 1\n"),
    ("las", b"LASF\0\0\0\0"),
    ("xlsx", _zip("[Content_Types].xml", "xl/workbook.xml")),
    ("ods", _zip("mimetype", "content.xml")),
    ("kmz", _zip("doc.kml")),
    ("office", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(100)),
    ("pdf", b"%PDF-1.7\n%\xe2\xe3\n"),
    ("jpeg", _picture("JPEG")),
    ("png", _picture("PNG")),
    ("tiff", _picture("TIFF")),
    ("picture", _picture("BMP")),
    ("picture", _picture("GIF")),
    ("picture", _picture("WEBP")),
    ("binary", b"\x00\x01\x02\x03"),
    ("binary", b"1 2 3\n4 5 \x006\n"),
]


@pytest.mark.parametrize(("kind", "content"), CONTENTS)
@pytest.mark.parametrize("name", ["file.csv", "file.txt", "file"])
def test_other_file_kind_is_reported(tmp_path: Path, kind: str, content: bytes, name: str) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        read_table(path)
    assert (caught.value.code, caught.value.values["kind"]) == ("file.other-kind", kind)
    assert caught.value.values["remedy"]


@pytest.mark.parametrize(
    ("ending", "driver", "kind"),
    [
        (".gpkg", "GPKG", "geopackage"),
        (".geojson", "GeoJSON", "geojson"),
        (".shp", "ESRI Shapefile", "shapefile"),
        (".kml", "KML", "kml"),
        (".gml", "GML", "gml"),
        (".dxf", "DXF", "dxf"),
    ],
)
def test_files_written_by_gdal_are_recognized(
    tmp_path: Path, ending: str, driver: str, kind: str
) -> None:
    path = tmp_path / f"planes{ending}"
    shapes = np.array([shapely.to_wkb(shapely.Point(k, k)) for k in range(3)], object)
    fields = {} if driver == "DXF" else {"dip": np.arange(3)}
    pyogrio.raw.write(
        path,
        shapes,
        list(fields.values()),
        list(fields),
        geometry_type="Point",
        crs="EPSG:4326",
        driver=driver,
    )
    assert recognise_kind(path.read_bytes()).key == kind  # type: ignore[union-attr]
    if driver == "ESRI Shapefile":
        beside = path.with_suffix(".dbf").read_bytes()
        assert recognise_kind(beside).key == "dbase"  # type: ignore[union-attr]


def test_sqlite_and_dxf_files_are_recognized(tmp_path: Path) -> None:
    with sqlite3.connect(tmp_path / "a.db") as db:
        db.execute("CREATE TABLE t (x)")
    assert recognise_kind((tmp_path / "a.db").read_bytes()).key == "sqlite"  # type: ignore[union-attr]
    for release in ("R12", "R2018"):
        ezdxf.new(release).saveas(tmp_path / "a.dxf")
        assert recognise_kind((tmp_path / "a.dxf").read_bytes()).key == "dxf"  # type: ignore[union-attr]


@pytest.mark.parametrize(
    "content",
    [
        b"x,y,z\n1,2,3\n4,5,6\n7,8,9\n",
        b"0\n1\n2\n",
        b"[m],[m],[m]\n1,2,3\n",
        b"<x> <y> <z>\n1 2 3\n",
        b"PAR1,PAR2,BM\n1,2,3\n",
        b"LASF,glTF,GIF8\n1,2,3\n",
        b"# comment\n\n1;2;3\n",
        b"solid,dip,strike\n1,2,3\n",
        b"v,x,y\n1,2,3\n",
        b"ply,dip,azimuth\n1,2,3\n",
        b"Version,Charset\n1,2\n",
        b'"a, b",c\n1,2\n',
        b"\x80 50 20\n",
    ],
)
def test_tables_are_not_taken_for_another_kind(tmp_path: Path, content: bytes) -> None:
    assert recognise_kind(content) is None


@given(
    st.lists(
        st.sampled_from([c for _, c in CONTENTS] + [b" ", b"\n", b"\0", b"<", b'{"']), max_size=6
    )
)
def test_arbitrary_content_never_raises(parts: list[bytes]) -> None:
    recognise_kind(b"".join(parts))


@pytest.mark.parametrize(
    "piece",
    [b"<?a?>", b"<!---->", b'"type" ', b"#\n", b" ", b"\n", b"999\n\n", b"<a", b"]", b"<!DOCTYPE"],
)
def test_recognition_time_is_linear(piece: bytes) -> None:
    for head in (b"", b'{"', b"<!DOCTYPE a [", b"solid\n"):
        recognise_kind((head + piece * HEAD_BYTES)[:HEAD_BYTES])


def test_model_and_camera_readers_report_other_file_kinds(tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    path.write_bytes(_json({"type": "FeatureCollection", "features": [_FEATURE]}))
    with pytest.raises(InputError) as caught:
        read_model(path)
    assert caught.value.values["kind"] == "geojson"
    for name, content, kind in (
        ("city.json", _json({"type": "CityJSON", "vertices": []}), "cityjson"),
        ("photos.nvm", b"NVM_V3\n2\n", "nvm"),
        (
            "blocks.xml",
            b'<?xml version="1.0"?>\n<BlocksExchange version="3.2"/>',
            "blocks-exchange",
        ),
    ):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(InputError) as caught:
            read_camera_file(tmp_path / name)
        assert (caught.value.code, caught.value.values["kind"]) == ("file.other-kind", kind)
