"""Every kind of file that is read: a small sound one, made by our own writers or by hand, and who
reads it.

A kind is one file or several that belong together; the names of all files are different, so that a
file that is kept tells its kind.
"""

from __future__ import annotations

import importlib.util
import io
import json
import shutil
import sqlite3
import struct
import tempfile
import warnings
from collections.abc import Callable, Mapping
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

SPECIMENS = Path(__file__).parents[1] / "specimens"


# --- who reads --------------------------------------------------------------------------------
def _model(path: Path) -> object:
    from vomstudio.io.models.opening import read_model

    return read_model(path)


def _streamed(path: Path) -> object:
    from vomstudio.io.models import copc

    return copc.stream(path, 1000).overview()


def _cache(path: Path) -> object:
    from vomstudio.io.models.model_cache import open_cache_folder

    return open_cache_folder(path.parent)


def _photo(path: Path) -> object:
    from vomstudio.io.photos.pixels import thumbnail
    from vomstudio.io.photos.reading import read_photo

    return read_photo(path), thumbnail(path)


def _texture(path: Path) -> object:
    from vomstudio.core.errors import InputError
    from vomstudio.rendering.prepare.textures import TextureProblem, load_texture, overview

    try:
        return load_texture(path, 4096), overview(path)
    except TextureProblem as problem:
        # A sentence that is shown where the surface is drawn without it.
        raise InputError(str(problem)) from problem


def _mask(path: Path) -> object:
    from vomstudio.io.photos.drawn_masks import load_mask

    return load_mask(path, 32, 24)


def _xmp(path: Path) -> object:
    from vomstudio.core.errors import InputError
    from vomstudio.core.files.regular import read_whole_file
    from vomstudio.io.photos.xmp import read_drone_tags

    try:
        return read_drone_tags(read_whole_file(path))
    except OSError as error:
        # The program finds it within a photo.
        raise InputError(str(error), file=path) from error


def _of(module: str, name: str) -> Callable[[Path], object]:
    def read(path: Path) -> object:
        import importlib

        return getattr(importlib.import_module(module), name)(path)

    return read


_CONTROL = "vomstudio.io.control."
_TEXT = "vomstudio.io.text."
_OBSERVED = f"{_CONTROL}observation_tables"
_control = _of(f"{_CONTROL}control_files", "read_control")
_marks = _of(f"{_CONTROL}control_files", "read_marks")
_RESULTS = "vomstudio.photogrammetry.pipeline.photo_results"
_cameras = _of("vomstudio.io.photos.own_cameras.reading", "read_camera_file")
_lines = _of("vomstudio.io.gis.line_reading", "read_gis_lines")


def _layer(path: Path) -> object:
    from tests.drawings import read_lines

    return read_lines(path), _lines(path)


def _area(path: Path) -> object:
    from tests.drawings import read_area

    return read_area(path)


def _settings(path: Path) -> object:
    from vomstudio.io.settings import read_settings

    return read_settings(path)


def _journal(path: Path) -> object:
    from vomstudio.project.journal.database import read_replay

    return read_replay(path.parent)


def _drawing(path: Path) -> object:
    from vomstudio.products.ortho.back_projection import read_drawing, read_sidecar

    return read_drawing(path, read_sidecar(path.with_suffix(".json")))


def _run(path: Path) -> object:
    from vomstudio.project.reconstructions import read_reconstruction

    return read_reconstruction(path.parent, "p", "run")


def _of_folder(module: str, name: str, loader: str = "") -> Callable[[Path], object]:
    """A reader of the folder that a file is in, or of what a stage has left."""

    def read(path: Path) -> object:
        import importlib

        found = importlib.import_module(module)
        if loader:
            return found.load_result(getattr(found, name), path)
        return getattr(found, name).load(path.parent)

    return read


def _listed(path: Path) -> object:
    from vomstudio.geometry.frames import Frame
    from vomstudio.project.imports.feature_lists import read_listed_features
    from vomstudio.project.records import Model

    model = Model("m1", "cliff", "cliff.obj", "mesh", "0" * 64, Frame("crs", "EPSG:32633"))
    return read_listed_features(path, model, {"m1": model}, "EPSG:32633")


def _features(path: Path) -> object:
    from vomstudio.photogrammetry.align.features import Features

    return Features.load(path)


def _depths(path: Path) -> object:
    from vomstudio.photogrammetry.dense.depthmaps import DepthMap

    return DepthMap.load(path)


def _comparison(path: Path) -> object:
    from vomstudio.project.comparisons import stored_comparisons

    return stored_comparisons(path.parents[1], "m1")


WITH_E57 = importlib.util.find_spec("pye57") is not None
"""Without the package no byte of such a file is read."""

READERS: dict[str, tuple[str, Callable[[Path], object]]] = {
    **({"e.e57": ("e.e57", _model)} if WITH_E57 else {}),
    **{
        name: (name, _model)
        for name in (
            "a.obj",
            "a.ply",
            "a.glb",
            "a.gltf",
            "a.stl",
            "s.stl",
            "b.las",
            "b.laz",
            "b.xyz",
            "b.ply",
            "s.ptx",
            "c.tif",
            "o.ply",
        )
    },
    "d.copc.laz": ("d.copc.laz", _streamed),
    "meta.json": ("meta.json", _cache),
    **{name: (name, _photo) for name in ("p.jpg", "p.png", "p.tiff")},
    **{name: (name, _texture) for name in ("t.webp", "t.bmp", "t.tga")},
    "p_mask.png": ("p_mask.png", _mask),
    "x.xmp": ("x.xmp", _xmp),
    "control.csv": ("control.csv", _control),
    "gcp_list.txt": ("gcp_list.txt", _control),
    "d.xml": ("d.xml", _control),
    "app.xml": ("app.xml", _control),
    "marks.csv": ("marks.csv", _marks),
    "markers.xml": ("markers.xml", _marks),
    "geo.txt": ("geo.txt", _of(_OBSERVED, "read_positions")),
    "positions.csv": ("positions.csv", _of(_OBSERVED, "read_positions")),
    "pairs.csv": ("pairs.csv", _of(_OBSERVED, "read_pairs")),
    "bars.csv": ("bars.csv", _of(_OBSERVED, "read_scale_bars")),
    "levels.csv": ("levels.csv", _of(_OBSERVED, "read_level_lines")),
    "compass.csv": ("compass.csv", _of(_OBSERVED, "read_compass")),
    "attitudes.csv": ("attitudes.csv", _of(f"{_CONTROL}attitude_tables", "read_attitudes")),
    **{
        name: (name, _cameras)
        for name in (
            "cameras.json",
            "cameras.xml",
            "reconstruction.json",
            "shots.geojson",
            "sfm_data.json",
            "cameras.sfm",
            "transforms.json",
            "bundle.out",
            "Orientation-IMG_00.jpg.xml",
            "centres.csv",
            "images.txt",
        )
    },
    "t.csv": ("t.csv", _of("vomstudio.io.gate.orientation_files", "read_orientations")),
    "field.csv": ("field.csv", _of("vomstudio.project.imports.field_table", "read_field_table")),
    "slips.txt": ("slips.txt", _of("vomstudio.io.gate.orientation_files", "read_slips")),
    "log.csv": ("log.csv", _of("vomstudio.io.gate.point_tables", "read_boundaries")),
    "points.csv": ("points.csv", _of("vomstudio.io.gate.point_tables", "read_points")),
    "pixels.csv": ("pixels.csv", _of(f"{_TEXT}pixel_tables", "read_pixels")),
    **{
        name: (name, _layer)
        for name in (
            "l.geojson",
            "l.gpkg",
            "l.shp",
            "l.dxf",
        )
    },
    "area.geojson": ("area.geojson", _area),
    "k.kml": ("k.kml", _layer),
    "stations.csv": ("stations.csv", _listed),
    "contacts.geojson": ("contacts.geojson", _listed),
    "w.tif": ("w.tif", _model),
    "scene.npz": ("scene.npz", _of_folder("vomstudio.photogrammetry.base.scene", "SparseScene")),
    "cloud.npz": ("cloud.npz", _of_folder(_RESULTS, "load_cloud", "load_result")),
    "mesh.npz": ("mesh.npz", _of_folder(_RESULTS, "load_mesh", "load_result")),
    "features.npz": ("features.npz", _features),
    "depth.npz": ("depth.npz", _depths),
    "drawn.svg": ("drawn.svg", _drawing),
    "settings.toml": ("settings.toml", _settings),
    "journal.sqlite": ("journal.sqlite", _journal),
    "run/reconstruction.json": ("run/reconstruction.json", _run),
    "r.registration.json": (
        "r.registration.json",
        _of("vomstudio.io.models.registration_file", "read_registration"),
    ),
    "comparisons/c.json": ("comparisons/c.json", _comparison),
}
"""By kind: the file that is named, and who reads it."""
GO_ON = ("comparisons/c.json", "features.npz", "settings.toml")
"""Kinds without which work goes on: they are kept, or computed, anew."""


# --- sound files ------------------------------------------------------------------------------
Files = dict[str, bytes]


def seeds() -> dict[str, Files]:
    """Small sound files by kind, each with those that lie beside it."""
    with tempfile.TemporaryDirectory() as made:
        place = Path(made)
        found = {name: {name: data} for name, data in {**_models(place), **_texts()}.items()}
        found |= {name: {name: data} for name, data in _pictures().items()}
        found |= _of_several(place / "several", found)
        found |= _other_cameras(place / "cameras") | _layers(place / "layers")
        found |= _stages(place / "stages") | _with_world_file(place / "world")
    missing = READERS.keys() - found.keys()
    assert not missing, missing
    return {kind: found[kind] for kind in READERS}


def _models(folder: Path) -> Files:
    from vomstudio.geometry.cloud import PointCloud
    from vomstudio.geometry.mesh import Mesh
    from vomstudio.io.models.writing import write_model

    chance = np.random.default_rng(1)
    x, y = (a.ravel() for a in np.meshgrid(np.arange(8.0), np.arange(8.0)))
    points = np.column_stack([x, y, chance.random(64)]) + [500000.0, 5200000.0, 800.0]
    corner = np.array([i for i in range(55) if i % 8 < 7])
    faces = np.concatenate(
        [
            np.stack([corner, corner + 1, corner + 8], 1),
            np.stack([corner + 1, corner + 9, corner + 8], 1),
        ]
    ).astype(np.int32)
    mesh = Mesh(points, faces)
    cloud = PointCloud(points, chance.integers(0, 255, (64, 3)).astype(np.uint8))
    for name in ("a.obj", "a.ply", "a.glb"):
        write_model(mesh, "EPSG:32632", folder / name)
    for name in ("b.las", "b.laz", "b.xyz", "b.ply"):
        write_model(cloud, "EPSG:32632", folder / name)
    found = {p.name: p.read_bytes() for p in folder.iterdir() if p.suffix not in (".prj", ".txt")}
    corners = [points[f] - points[0] for f in faces]
    triangles = b"".join(struct.pack("<12fH", 0, 0, 1, *t.ravel(), 0) for t in corners)
    found["a.stl"] = bytes(80) + struct.pack("<I", len(faces)) + triangles
    text = "".join(
        "facet normal 0 0 1\nouter loop\n"
        + "".join(f"vertex {a:.3f} {b:.3f} {c:.3f}\n" for a, b, c in t)
        + "endloop\nendfacet\n"
        for t in corners[:9]
    )
    found["s.stl"] = f"solid s\n{text}endsolid s\n".encode()
    pose = "1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"
    rows = "".join(f"{x:.3f} {y:.3f} {z:.3f} 0.5\n" for x, y, z in (points - points[0]).tolist())
    found["s.ptx"] = f"8\n8\n0 0 0\n{pose}{rows}".encode()
    if WITH_E57:
        found["e.e57"] = _scan(folder / "e.e57", points)
    import rasterio
    from rasterio import Affine

    with rasterio.open(
        folder / "c.tif",
        "w",
        driver="GTiff",
        width=16,
        height=16,
        count=1,
        dtype="float32",
        crs="EPSG:32632",
        transform=Affine(1, 0, 500000, 0, -1, 5200000),
        compress="deflate",
    ) as file:
        file.write(chance.random((1, 16, 16), np.float32))
    import laspy

    from tests.io.models.copc_maker import write_copc

    las = laspy.LasData(laspy.LasHeader(version="1.4", point_format=7))
    las.header.scales = [0.001] * 3
    las.x, las.y, las.z = (chance.random((3000, 3)) * [40, 30, 5]).T
    write_copc(folder / "d.copc.laz", las)
    for name in ("c.tif", "d.copc.laz"):
        found[name] = (folder / name).read_bytes()
    return found


def _scan(path: Path, points: Any) -> bytes:
    import pye57

    colors = ("colorRed", "colorGreen", "colorBlue")
    with pye57.E57(str(path), mode="w") as file:
        for number in range(2):
            data = {f"cartesian{axis}": points[:, k] for k, axis in enumerate("XYZ")}
            data |= {name: np.arange(len(points), dtype=np.uint8) for name in colors}
            data["cartesianInvalidState"] = (np.arange(len(points)) < number).astype(np.int8)
            file.write_scan_raw(
                data, rotation=np.array([1.0, 0.0, 0.0, 0.0]), translation=np.zeros(3)
            )
    return path.read_bytes()


_PAGE = 1024


def _e57_sealed(data: bytes) -> bytes:
    """With the checksum of every page as its content has it now (ASTM E2807, 5.3): CRC-32C."""
    made = bytearray(data)
    for begin in range(0, len(made) - _PAGE + 1, _PAGE):
        crc = 0xFFFFFFFF
        for byte in made[begin : begin + _PAGE - 4]:
            crc = _CRC[(crc ^ byte) & 0xFF] ^ (crc >> 8)
        made[begin + _PAGE - 4 : begin + _PAGE] = struct.pack(">I", crc ^ 0xFFFFFFFF)
    return bytes(made)


def _crc_of(byte: int) -> int:
    for _ in range(8):
        byte = (byte >> 1) ^ (0x82F63B78 if byte & 1 else 0)
    return byte


_CRC = [_crc_of(byte) for byte in range(256)]
SEALED: dict[str, Callable[[bytes], bytes]] = {".e57": _e57_sealed}
"""By the ending: makes checksums right again, without which nothing behind them is reached."""


_XMP = (
    b'<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF xmlns:rdf='
    b'"http://www.w3.org/1999/02/22-rdf-syntax-ns#"><rdf:Description xmlns:drone-dji='
    b'"http://www.dji.com/drone-dji/1.0/" drone-dji:GimbalYawDegree="10.5" '
    b'drone-dji:GimbalPitchDegree="-30.0"/></rdf:RDF></x:xmpmeta>'
)


def _pictures() -> Files:
    from PIL import Image

    made = {"x.xmp": _XMP}
    pixels = np.random.default_rng(2).integers(0, 255, (24, 32, 3)).astype(np.uint8)
    exif = Image.Exif()
    exif[0x010F], exif[0x0110], exif[0x0112] = "DJI", "FC3582", 6
    exif.get_ifd(0x8769).update({0x920A: 6.72, 0xA405: 24})
    exif.get_ifd(0x8825).update({1: "N", 2: (46.0, 30.0, 1.5), 3: "E", 4: (7.0, 0.0, 1.0)})
    for name, kind in (("p.jpg", "JPEG"), ("p.png", "PNG"), ("p.tiff", "TIFF")):
        stream = io.BytesIO()
        options: dict[str, Any] = {} if kind == "PNG" else {"xmp": _XMP}
        if kind == "TIFF":
            options["compression"] = "tiff_deflate"
        Image.fromarray(pixels).save(stream, kind, exif=exif, **options)
        made[name] = stream.getvalue()
    for name, kind in (("t.webp", "WEBP"), ("t.bmp", "BMP"), ("t.tga", "TGA")):
        stream = io.BytesIO()
        Image.fromarray(pixels).save(stream, kind)
        made[name] = stream.getvalue()
    stream = io.BytesIO()
    Image.fromarray(pixels[..., 0] > 99).save(stream, "PNG")
    return {**made, "p_mask.png": stream.getvalue()}


def _texts() -> Files:
    lens = {"model": "PINHOLE", "width": 40, "height": 30, "params": [40.0, 40.0, 20.0, 15.0]}
    view = {"name": "p.jpg", "rotation": np.eye(3).tolist(), "translation": [0.0, 0.0, 5.0], **lens}
    cameras = {
        "format": "vomstudio cameras",
        "version": 1,
        "crs": None,
        "scaled": True,
        "origin": [0, 0, 0],
        "photos": ".",
        "views": [view],
    }
    written = {
        "t.csv": 'id,strike,dip,set,note,x,y,z\n1,30,45,S0,a,1,2,3\n2,120,60,S0,"b, c",2,2,3\n'
        "3,211.5,88,J1,'=d,3,2,3\n",
        "field.csv": "station;dip dir;dip;date;notes\nA1;211;88;2024-05-01;=d\nA2;30;45;;x\n",
        "slips.txt": "strike\tdip\ttrend\tplunge\tsense\n20\t60\t100\t59.6\tNL\n"
        "195\t55\t290\t54.9\tNR\n",
        "log.csv": "name,x,y,z,lithology,notes\na,0,0,0,sandstone,coarse\nb,10,0,0,lime,\n",
        "points.csv": "x,y,z,pick\n1,2,3,a\n4,5,6,a\n7,8,9,b\n",
        "pixels.csv": "column,row\n10,20\n30.5,40\n",
        "control.csv": "label,x,y,z,sigma,use\na,500000,5200000,800,0.02,control\n"
        "b,500010,5200000,801,0.02,check\n",
        "marks.csv": "label,photo,x,y\na,p.jpg,10.5,11\nb,p.jpg,20,3.25\n",
        "gcp_list.txt": "EPSG:32632\n500000 5200000 800 10 11 p.jpg a\n"
        "500010 5200000 801 3 4 p.jpg b\n",
        "geo.txt": "EPSG:32632\np.jpg 500000 5200000 800 10 -30 0 0.1 0.2\n"
        "q.jpg 500010 5200000 801\n",
        "positions.csv": "photo,x,y,z,sigma\np.jpg,500000,5200000,800,0.1\n"
        "q.jpg,500010,5200000,801,0.1\n",
        "pairs.csv": "label,model_x,model_y,model_z,x,y,z,use\nA,0,0,0,100,200,50,\n"
        "B,9,0,0,100,218,50,\nC,0,8,1,84,200,52,check\n",
        "bars.csv": "from,to,length_m,sigma_m\na,b,1.5,0.001\nb,c,2,0.002\n",
        "levels.csv": "photo,x1,y1,x2,y2\np.jpg,10,20,30,21\nq.jpg,1,2,30,4\n",
        "compass.csv": "dip_direction,dip,model_x,model_y,model_z\n120,45,0,0.6,0.8\n"
        "200,30,0.1,0,1\n",
        "attitudes.csv": "photo,yaw,pitch,roll,sigma_yaw,sigma_pitch,sigma_roll,north\n"
        "p.jpg,10,-30,1,2,1,1,grid\nq.jpg,20,-35,2,2,1,1,true\n",
        "centres.csv": "photo,x,y,z\np.jpg,1,2,3\nq.jpg,2,2,3\nr.jpg,3,2,4\n",
        "settings.toml": "[measuring]\nmethod = 'pca'\n",
        "d.xml": "<document><chunks/><chunk><markers><marker id='0' label='a'>"
        "<reference x='1' y='2' z='3' sxyz='0.01' enabled='true'/></marker></markers>"
        "<reference>LOCAL</reference></chunk></document>",
        "app.xml": "<DicoAppuisFlottant><OneAppuisDAF><Pt>0 0 0</Pt><NamePt>a</NamePt>"
        "<Incertitude>1 1 1</Incertitude></OneAppuisDAF></DicoAppuisFlottant>",
        "markers.xml": "<SetOfMesureAppuisFlottants><MesureAppuiFlottant1Im><NameIm>p.jpg</NameIm>"
        "<OneMesureAF1I><NamePt>a</NamePt><PtIm>10 20</PtIm></OneMesureAF1I>"
        "</MesureAppuiFlottant1Im></SetOfMesureAppuisFlottants>",
        "stations.csv": "# CRS: EPSG:32633\nname,x,y,z,type,number,wkt\na,1,2,3,sample,KB-17,\n"
        "b,4,5,6,station,,POINT Z (4 5 6)\n",
        "contacts.geojson": json.dumps(_geojson("LineString", [[1, 2, 3], [4, 5, 6]])),
        "k.kml": '<kml xmlns="http://www.opengis.net/kml/2.2"><Document><Placemark><name>a</name>'
        "<LineString><coordinates>7,46,1 7.1,46.1,2</coordinates></LineString></Placemark>"
        "</Document></kml>",
        "area.geojson": json.dumps(_geojson("Polygon", [[[0, 0], [9, 0], [9, 9], [0, 0]]])),
        "cameras.json": json.dumps(cameras),
    }
    return {name: text.encode() for name, text in written.items()}


def _geojson(kind: str, coordinates: object) -> dict[str, Any]:
    feature = {
        "type": "Feature",
        "properties": {"name": "a", "n": 3},
        "geometry": {"type": kind, "coordinates": coordinates},
    }
    crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32633"}}
    return {"type": "FeatureCollection", "crs": crs, "features": [feature]}


def _of_several(folder: Path, single: Mapping[str, Files]) -> dict[str, Files]:
    """Models with sidecars, a cache, a journal, results of runs."""
    from vomstudio.geometry.mesh import Mesh
    from vomstudio.io.models import model_cache
    from vomstudio.io.models.reader import LoadedModel

    folder.mkdir()
    obj = (
        "mtllib o.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nusemtl a\nf 1/1 2/2 3/3\n"
    )
    with_texture = {
        "a.obj": obj.encode(),
        "o.mtl": b"newmtl a\nKd 1 .5 0\nmap_Kd -s 1 1 1 o.png\n",
        "o.png": single["p.png"]["p.png"],
    }
    prj = 'LOCAL_CS["a",UNIT["metre",1]]'
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4").tobytes()
    corners = np.array([0, 1, 2], "<u2").tobytes()
    gltf = {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": "g.bin", "byteLength": len(positions) + len(corners)}],
        "bufferViews": [
            {"buffer": 0, "byteLength": len(positions)},
            {"buffer": 0, "byteOffset": len(positions), "byteLength": len(corners)},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3},
            {"bufferView": 1, "componentType": 5123, "type": "SCALAR", "count": 3},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "nodes": [{"mesh": 0, "scale": [1, 2, 3]}],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
    }
    mesh = Mesh(np.eye(3), np.array([[0, 1, 2]], np.int32))
    kept = LoadedModel(mesh, "mesh", None, (), Path("/nowhere/a.obj"), "0" * 64)
    model_cache.save(kept, folder / "cache")
    shutil.copy(SPECIMENS / "schema1.vom" / "journal.sqlite", folder / "j.sqlite")
    # Small enough that a changed byte meets a row.
    with closing(sqlite3.connect(folder / "j.sqlite", isolation_level=None)) as db:
        db.execute("PRAGMA journal_mode = DELETE")
        db.execute("VACUUM")
    result = {
        "photos": 9,
        "registered": 8,
        "reprojection_error_px": 0.5,
        "settings": {"quality": "low"},
        "versions": {"vomstudio": "1"},
        "registration": {"scale": 1.0, "residuals": []},
    }
    rows = np.eye(4).tolist()
    stream = io.BytesIO()
    np.savez(stream, distance=np.zeros(3))
    comparison = {
        "model_id": "m1",
        "model_name": "a",
        "content_hash": "0",
        "to_world": rows,
        "benchmark": "b",
        "benchmark_path": "b.ply",
        "benchmark_to_world": rows,
        "radius_m": None,
        "made": "2024",
        "version": "1",
        "figures": {
            "n": 3,
            "beyond": 0,
            "mean_m": 0.0,
            "median_m": 0.0,
            "std_m": None,
            "mad_m": 0.0,
            "rms_m": 0.0,
            "lod95_m": None,
            "significant_share": None,
            "warnings": [],
            "positive_toward": {"trend_deg": 10.0, "plunge_deg": 20.0},
        },
    }
    return {
        "a.obj": with_texture,
        "o.ply": {
            "o.ply": single["b.ply"]["b.ply"],
            "o.prj": prj.encode(),
            "o.offset.txt": b"offset 500000 5200000 800\nEPSG:32632\n",
        },
        "a.gltf": {"a.gltf": json.dumps(gltf).encode(), "g.bin": positions + corners},
        "meta.json": {p.name: p.read_bytes() for p in (folder / "cache").iterdir()},
        "journal.sqlite": {"journal.sqlite": (folder / "j.sqlite").read_bytes()},
        "r.registration.json": _registration(folder),
        "run/reconstruction.json": {
            "run/reconstruction.json": json.dumps(result).encode(),
            "run/request.json": json.dumps({"photos": "."}).encode(),
        },
        "comparisons/c.json": {
            "comparisons/c.json": json.dumps(comparison).encode(),
            "comparisons/c.npz": stream.getvalue(),
        },
    }


def _registration(folder: Path) -> Files:
    from tests.registrations import registration
    from vomstudio.io.models.registration_file import write_registration

    model = folder / "r.ply"
    model.write_bytes(b"a model")
    path = write_registration(registration(), [model])
    return {path.name: path.read_bytes()}


def _other_cameras(folder: Path) -> dict[str, Files]:
    from tests.io.photos import camera_files
    from vomstudio.geometry.cameras import Intrinsics

    folder.mkdir()
    views = camera_files.ring(4)
    camera_files.colmap_text(folder / "colmap", views)
    camera_files.metashape_xml(
        folder / "cameras.xml", views, 2.0, np.eye(3), np.zeros(3), "LOCAL_CS[]"
    )
    camera_files.opensfm_json(folder / "reconstruction.json", views)
    camera_files.openmvg_json(folder / "sfm_data.json", views)
    camera_files.alicevision_json(folder / "cameras.sfm", views, (1, 2, 6))
    camera_files.nerfstudio_json(folder / "transforms.json", views, np.eye(3, 4))
    small = Intrinsics("RADIAL", 40, 30, (32.0, 20.0, 15.0, -0.05, 0.01))
    radial = [replace(view, intrinsics=small) for view in views]
    camera_files.bundler_out(folder / "bundle.out", radial)
    orientations = camera_files.micmac_folder(folder / "Ori-All", views, np.eye(3))
    shots = {
        "type": "FeatureCollection",
        "features": [
            {
                "type": "Feature",
                "properties": {
                    "filename": view.name,
                    "camera": "a",
                    "focal": 0.8,
                    "width": 4000,
                    "height": 3000,
                    "translation": view.centre.tolist(),
                    "rotation": [0.1, 0.2, 0.3],
                },
                "geometry": {"type": "Point", "coordinates": view.centre.tolist()},
            }
            for view in views
        ],
    }
    return {
        "images.txt": {p.name: p.read_bytes() for p in (folder / "colmap").iterdir()},
        **{
            name: {name: (folder / name).read_bytes()}
            for name in (
                "cameras.xml",
                "reconstruction.json",
                "sfm_data.json",
                "cameras.sfm",
                "transforms.json",
            )
        },
        "bundle.out": {n: (folder / n).read_bytes() for n in ("bundle.out", "list.txt")},
        f"Orientation-{views[0].name}.xml": {
            path.name: path.read_bytes() for path in orientations.iterdir()
        },
        "shots.geojson": {"shots.geojson": json.dumps(shots).encode()},
    }


def _with_world_file(folder: Path) -> dict[str, Files]:
    """A height model whose place, values without heights, and unit stand beside it."""
    import rasterio
    from rasterio.errors import NotGeoreferencedWarning

    folder.mkdir()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NotGeoreferencedWarning)
        with rasterio.open(
            folder / "w.tif", "w", driver="GTiff", width=8, height=8, count=1, dtype="float32"
        ) as file:
            file.write(np.random.default_rng(3).random((1, 8, 8), np.float32))
    auxiliary = (
        '<PAMDataset><PAMRasterBand band="1"><NoDataValue>-99</NoDataValue><UnitType>m</UnitType>'
        '<Metadata><MDI key="STATISTICS_MAXIMUM">1</MDI></Metadata></PAMRasterBand></PAMDataset>'
    )
    return {
        "w.tif": {
            "w.tif": (folder / "w.tif").read_bytes(),
            "w.tfw": b"1\n0\n0\n-1\n500000\n5200000\n",
            "w.tif.aux.xml": auxiliary.encode(),
            "w.prj": b'LOCAL_CS["a",UNIT["metre",1]]',
        }
    }


def _stages(folder: Path) -> dict[str, Files]:
    """What a reconstruction leaves for its next run."""
    from vomstudio.geometry.cloud import PointCloud
    from vomstudio.geometry.mesh import Mesh
    from vomstudio.photogrammetry.align.features import Features
    from vomstudio.photogrammetry.base.scene import SparseScene, view_to_dict
    from vomstudio.photogrammetry.pipeline.photo_results import save_cloud, save_mesh

    folder.mkdir()
    points = np.eye(3)
    save_cloud(folder / "cloud.npz", PointCloud(points, np.zeros((3, 3), np.uint8)))
    save_mesh(folder / "mesh.npz", Mesh(points, np.array([[0, 1, 2]], np.int32)))
    Features(
        np.zeros((2, 6), np.float32),
        np.zeros((2, 128), np.uint8),
        np.zeros((2, 3), np.uint8),
        32,
        24,
    ).save(folder / "features.npz")
    made = SPECIMENS / "schema1.vom" / "reconstruction" / "photos-preview" / "work"
    scene = next(made.glob("frame-*"))
    depth = folder / "depth.npz"
    view = json.dumps(view_to_dict(SparseScene.load(scene).views[0]))
    np.savez(depth, view=np.array(view), depth=points, normals=points, confidence=points)
    return {
        "scene.npz": {name: (scene / name).read_bytes() for name in ("scene.npz", "scene.json")},
        **{
            name: {name: (folder / name).read_bytes()}
            for name in ("cloud.npz", "mesh.npz", "features.npz", "depth.npz")
        },
    }


def _layers(folder: Path) -> dict[str, Files]:
    import pyogrio
    import shapely

    folder.mkdir()
    lines = [shapely.LineString([(k, 0), (k + 3, 5), (k + 4, 9)]) for k in range(4)]
    shapes, names = np.array(shapely.to_wkb(lines), object), np.array(list("abcd"), object)
    for name, driver in (
        ("l.gpkg", "GPKG"),
        ("l.shp", "ESRI Shapefile"),
        ("l.geojson", "GeoJSON"),
        ("l.dxf", "DXF"),
    ):
        with warnings.catch_warnings():
            # A DXF has no place for a CRS.
            warnings.simplefilter("ignore")
            pyogrio.raw.write(
                folder / name,
                shapes,
                [] if driver == "DXF" else [names],
                [] if driver == "DXF" else ["name"],
                geometry_type="LineString",
                driver=driver,
                crs=None if driver == "DXF" else "EPSG:32633",
            )
    svg = (
        '<svg xmlns="http://www.w3.org/2000/svg" width="100" height="80" viewBox="0 0 100 80">'
        '<g transform="translate(1 2)"><path d="M 1 1 L 9 9 C 1 2 3 4 5 6 z"/>'
        '<polyline points="1,1 20,30"/></g></svg>'
    )
    sidecar = {
        "pixel_to_world": np.eye(4).tolist(),
        "geotransform": [1, 0, 0, 0, -1, 80],
        "width": 100,
        "height": 80,
        "plane_coordinates": None,
        "crs": "EPSG:32633",
        "picture_id": "a",
    }
    return {
        **{name: {name: (folder / name).read_bytes()} for name in ("l.gpkg", "l.geojson", "l.dxf")},
        "l.shp": {p.name: p.read_bytes() for p in folder.iterdir() if p.suffix in _OF_SHAPES},
        "drawn.svg": {"drawn.svg": svg.encode(), "drawn.json": json.dumps(sidecar).encode()},
    }


_OF_SHAPES = (".shp", ".dbf", ".shx", ".prj", ".cpg")
