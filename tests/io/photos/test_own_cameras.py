"""A model's own cameras come back from every program's files as they were."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial.transform import Rotation

from tests.io.photos import camera_files as files
from tests.messages import by_code, refused
from vomstudio.geometry.cameras import View
from vomstudio.io.photos.cameras_file import Cameras, write_cameras, write_cameras_csv
from vomstudio.io.photos.own_cameras.reading import find_own_cameras, read_own_cameras

Array = npt.NDArray[np.float64]

VIEWS = files.ring()
BOX = np.array([[-5.0, -4.0, -3.0], [5.0, 4.0, 3.0]])
TURN = Rotation.from_euler("zyx", [50.0, -20.0, 35.0], degrees=True).as_matrix()
PLACES = np.random.default_rng(4).normal(size=(20, 3)) * 3.0


def same(
    found: dict[str, View], views: list[View], lens: bool = True, metres: float = 1e-6
) -> None:
    assert len(found) == len(views)
    for view in views:
        there = found.get(view.name) or found[view.name.removesuffix(".jpg")]
        np.testing.assert_allclose(there.rotation, view.rotation, atol=1e-7)
        np.testing.assert_allclose(there.centre, view.centre, atol=metres)
        if lens:
            # Everything about lens and pose in one: where points are seen.
            np.testing.assert_allclose(there.project(PLACES), view.project(PLACES), atol=1e-3)


def written_by_colmap(folder: Path, binary: bool) -> Path:
    """By COLMAP itself."""
    import PIL.Image  # noqa: F401 - before pycolmap, which brings a zlib of its own
    import pycolmap

    made = pycolmap.Reconstruction()
    camera = pycolmap.Camera(
        camera_id=1, model="OPENCV", width=4000, height=3000, params=files.LENS.params
    )
    made.add_camera_with_trivial_rig(camera)
    for number, view in enumerate(VIEWS, 1):
        image = pycolmap.Image(name=view.name, camera_id=1, image_id=number)
        image.points2D = pycolmap.Point2DList([pycolmap.Point2D([1.5, 2.5])] * number)
        pose = pycolmap.Rigid3d(pycolmap.Rotation3d(view.rotation), view.translation)
        made.add_image_with_trivial_frame(image, pose)
    folder.mkdir()
    (made.write_binary if binary else made.write_text)(str(folder))
    return folder


def test_colmap_text(tmp_path: Path) -> None:
    folder = files.colmap_text(tmp_path / "sparse" / "0", VIEWS)
    same(read_own_cameras(folder).views, VIEWS)
    same(read_own_cameras(folder / "images.txt").views, VIEWS)


@pytest.mark.parametrize("binary", [True, False])
def test_colmap_as_it_writes_itself(tmp_path: Path, binary: bool) -> None:
    folder = written_by_colmap(tmp_path / "0", binary)
    same(read_own_cameras(folder).views, VIEWS)
    if binary:
        data = (folder / "images.bin").read_bytes()
        (folder / "images.bin").write_bytes(data[: len(data) // 2])
        with refused("file.damaged", format="COLMAP") as error:
            read_own_cameras(folder)
        assert error.value.field


def test_metashape_with_the_transform_of_its_chunk(tmp_path: Path) -> None:
    path = files.metashape_xml(tmp_path / "cameras.xml", VIEWS, 3.0, TURN, np.array([90.0, 8, -5]))
    same(read_own_cameras(path, BOX).views, VIEWS)
    same(read_own_cameras(path).views, VIEWS)
    # A model that was exported in the inner frame of the chunk.
    inner = [v.moved(1 / 3.0, TURN.T, -TURN.T @ [30.0, 8 / 3, -5 / 3]) for v in VIEWS]
    middle = TURN.T @ -np.array([90.0, 8, -5]) / 3.0
    found = read_own_cameras(path, middle + BOX / 3.0)
    same(found.views, inner)
    assert "cameras.frame" in by_code(found.warnings)


def test_metashape_on_earth(tmp_path: Path) -> None:
    """Against the axes of east, north and up at each camera, turned by the convergence there."""
    from pyproj import CRS, Proj, Transformer

    origin = np.array([398_000.0, 4_980_000.0, 320.0])
    on_map = [v.moved(1.0, np.eye(3), origin) for v in VIEWS]
    to_earth = Transformer.from_crs("EPSG:32633", "EPSG:4978", always_xy=True)
    to_degrees = Transformer.from_crs("EPSG:32633", "EPSG:4326", always_xy=True)
    geocentric = []
    for view in on_map:
        longitude, latitude = to_degrees.transform(*view.centre[:2])
        there = np.array(to_earth.transform(*view.centre))
        factors = Proj("EPSG:32633").get_factors(longitude, latitude)
        g = np.radians(factors.meridian_convergence)
        east, north = np.radians(longitude), np.radians(latitude)
        s, c, sn, cn = np.sin(east), np.cos(east), np.sin(north), np.cos(north)
        axes = np.array([[-s, c, 0], [-sn * c, -sn * s, cn], [cn * c, cn * s, sn]])
        # Grid to true east and north.
        true = np.array([[np.cos(g), np.sin(g), 0], [-np.sin(g), np.cos(g), 0], [0, 0, 1]])
        rotation = view.rotation @ true.T @ axes
        geocentric.append(View(view.name, view.intrinsics, rotation, -rotation @ there))
    path = tmp_path / "cameras.xml"
    shift = np.mean([v.centre for v in geocentric], axis=0)
    wkt = CRS.from_epsg(32633).to_wkt().replace("<", "&lt;")
    files.metashape_xml(path, geocentric, 2.0, TURN, shift, wkt)
    found = read_own_cameras(path, BOX + origin).views
    for view in on_map:
        there = found[view.name.removesuffix(".jpg")]
        turned = Rotation.from_matrix(there.rotation @ view.rotation.T).magnitude()
        assert np.degrees(turned) < 1e-4
        np.testing.assert_allclose(there.centre, view.centre, atol=1e-3)


def test_opensfm_and_opendronemap(tmp_path: Path) -> None:
    path = files.opensfm_json(tmp_path / "reconstruction.json", VIEWS)
    found = read_own_cameras(path, BOX)
    same(found.views, VIEWS)
    assert by_code(found.warnings)["cameras.several-parts"] == {"count": 2}
    origin = np.array([500_000.0, 4_000_000.0, 0.0])
    on_map = [v.moved(1.0, np.eye(3), origin) for v in VIEWS]
    shots = files.shots_geojson(tmp_path / "odm_report" / "shots.geojson", on_map)
    same(read_own_cameras(shots, BOX + origin).views, on_map, lens=False)
    # OpenDroneMap takes an offset off its meshes.
    (tmp_path / "odm_georeferencing").mkdir()
    (tmp_path / "odm_georeferencing" / "coords.txt").write_text(
        "WGS84 UTM 33N\n500000.0 4000000.0\n"
    )
    found = read_own_cameras(shots, BOX)
    same(found.views, VIEWS, lens=False)
    assert "cameras.frame" in by_code(found.warnings)


def test_tables_of_centres(tmp_path: Path) -> None:
    for write in (files.metashape_reference, files.metashape_angles):
        found = read_own_cameras(write(tmp_path / "a.txt", VIEWS))
        assert not found.views
        for view in VIEWS:
            there = found.centres[view.name.removesuffix(".jpg")]
            np.testing.assert_allclose(there, view.centre, atol=1e-8)


def test_our_own_files(tmp_path: Path) -> None:
    own = Cameras(tuple(VIEWS), Path("photos"), (100, 200, 300))
    moved = [v.moved(1.0, np.eye(3), np.array([100.0, 200, 300])) for v in VIEWS]
    write_cameras(tmp_path / "cameras.json", own)
    same(read_own_cameras(tmp_path / "cameras.json").views, moved, lens=False)
    write_cameras_csv(tmp_path / "cameras.csv", own)
    same(read_own_cameras(tmp_path / "cameras.csv").views, moved, lens=False, metres=1e-5)


def test_they_are_found_beside_the_model(tmp_path: Path) -> None:
    model = tmp_path / "model.ply"
    assert find_own_cameras(model) is None
    (tmp_path / "cameras.json").write_text('{"v2 dji": {"projection_type": "brown"}}')
    assert find_own_cameras(model) is None
    files.colmap_text(tmp_path / "sparse" / "0", VIEWS)
    assert find_own_cameras(model) == tmp_path / "sparse" / "0"
    files.metashape_xml(tmp_path / "cameras.xml", VIEWS, 1.0, np.eye(3), np.zeros(3))
    assert find_own_cameras(model) == tmp_path / "cameras.xml"


def test_cameras_that_look_elsewhere_are_doubted(tmp_path: Path) -> None:
    path = files.opensfm_json(tmp_path / "reconstruction.json", VIEWS)
    far = read_own_cameras(path, BOX + 1000.0)
    assert "cameras.not-looking" in by_code(far.warnings)


XML = (
    '<document><chunk><sensors><sensor id="0"><resolution width="{0}" height="3"/>{1}</sensor>'
    '</sensors>\n<cameras><camera id="0" sensor_id="0" label="A">\n<transform>{2}</transform>'
    "</camera></cameras></chunk></document>"
)
SHOT = '[{{"cameras": {{"a": {{"width": 4, "height": 3, "focal": 0.8}}}}, "shots": {{"A": {0}}}}}]'
FLAT = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"


@pytest.mark.parametrize(
    ("name", "text", "line", "field", "code"),
    [
        ("c.xml", XML.format(4, "", "1 2 3"), 3, "transform", "file.damaged"),
        ("c.xml", XML.format(4, "", "1 2 x"), 3, "transform", "file.damaged"),
        ("c.xml", XML.format("no", "", FLAT), 1, "resolution", "file.damaged"),
        ("c.xml", XML.format(4, "", FLAT.replace("1", "2")), 2, "camera A", "file.damaged"),
        ("c.xml", "<document><a/></document>", 1, "document", "file.other-format"),
        ("r.json", SHOT.format('{"camera": "b"}'), None, "shots/A", "file.damaged"),
        ("r.json", SHOT.format('{"camera": "a"}'), None, "shots/A/rotation", "file.damaged"),
        (
            "r.json",
            SHOT.format('{"camera": "a", "rotation": [1, 2], "translation": [0, 0, 0]}'),
            None,
            "shots/A/rotation",
            "file.damaged",
        ),
        ("r.json", "[1, 2", None, None, "file.damaged"),
        ("t.csv", "photo,x,y,z\nA,1,2,\n", 2, "z", "table.value-missing"),
        (
            "t.csv",
            "photo,longitude,latitude,altitude\nA,1,2,3\n",
            1,
            "photo",
            "cameras.centres-in-degrees",
        ),
    ],
)
def test_what_is_wrong_is_said_with_its_place(
    tmp_path: Path, name: str, text: str, line: int | None, field: str | None, code: str
) -> None:
    path = tmp_path / name
    path.write_text(text)
    with refused(code, line=line, field=field) as error:
        read_own_cameras(path)
    assert error.value.file is not None


def test_what_is_wrong_with_files_of_colmap_is_said(tmp_path: Path) -> None:
    folder = files.colmap_text(tmp_path / "0", VIEWS)
    images = folder / "images.txt"
    whole = images.read_text().split("\n")
    for cells in (["1", "0", "0"], ["1", *"9999000", "1", "A"]):
        images.write_text("\n".join([whole[0], " ".join(cells), "", *whole[3:]]))
        with refused("file.damaged", format="COLMAP", file=images, line=2):
            read_own_cameras(folder)
    (folder / "cameras.txt").write_text("1 OPENCV 40 30 1 2 3\n")
    with refused("file.damaged", format="COLMAP", line=1):
        read_own_cameras(folder)
    (folder / "cameras.bin").write_bytes(struct.pack("<Qii", 1, 1, 99) + bytes(16))
    (folder / "images.bin").write_bytes(bytes(8))
    with refused("file.damaged", format="COLMAP"):
        read_own_cameras(folder)


@pytest.mark.parametrize("model", ["SIMPLE_RADIAL_FISHEYE 4 3 2 2 1.5 0.1", "FOV 4 3 2 2 2 1.5 1"])
def test_lenses_that_are_not_known_are_named(tmp_path: Path, model: str) -> None:
    folder = files.colmap_text(tmp_path / "0", VIEWS)
    (folder / "cameras.txt").write_text(f"1 {model}\n")
    found = read_own_cameras(folder)
    assert len(found.views) == len(VIEWS)
    unknown = by_code(found.warnings).get("cameras.unknown-lens")
    assert (unknown is not None and unknown["model"] == "FOV") == model.startswith("FOV")
