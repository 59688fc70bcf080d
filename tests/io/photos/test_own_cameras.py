"""A model's own cameras come back from every program's files as they were."""

from __future__ import annotations

import csv
import json
import struct
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial.transform import Rotation

from tests.io.photos import camera_files as files
from tests.messages import by_code, refused
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.io.photos.cameras_file import Cameras, write_cameras, write_cameras_csv
from vomstudio.io.photos.own_cameras.reading import find_camera_file, read_camera_file
from vomstudio.io.photos.own_cameras.result import local_cameras

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


def test_colmap_text_cameras_are_read(tmp_path: Path) -> None:
    folder = files.colmap_text(tmp_path / "sparse" / "0", VIEWS)
    same(read_camera_file(folder).views, VIEWS)
    same(read_camera_file(folder / "images.txt").views, VIEWS)


@pytest.mark.parametrize("binary", [True, False])
def test_original_colmap_output_is_read(tmp_path: Path, binary: bool) -> None:
    folder = files.colmap_itself(tmp_path / "0", VIEWS, binary)
    same(read_camera_file(folder).views, VIEWS)
    if binary:
        data = (folder / "images.bin").read_bytes()
        (folder / "images.bin").write_bytes(data[: len(data) // 2])
        with refused("file.damaged", format="COLMAP") as error:
            read_camera_file(folder)
        assert error.value.field


def test_metashape_chunk_transform_is_applied(tmp_path: Path) -> None:
    path = files.metashape_xml(tmp_path / "cameras.xml", VIEWS, 3.0, TURN, np.array([90.0, 8, -5]))
    same(read_camera_file(path, BOX).views, VIEWS)
    same(read_camera_file(path).views, VIEWS)
    # A model that was exported in the inner frame of the chunk.
    inner = [v.moved(1 / 3.0, TURN.T, -TURN.T @ [30.0, 8 / 3, -5 / 3]) for v in VIEWS]
    middle = TURN.T @ -np.array([90.0, 8, -5]) / 3.0
    found = read_camera_file(path, middle + BOX / 3.0)
    same(found.views, inner)
    assert "cameras.frame" in by_code(found.warnings)


def test_metashape_geocentric_cameras_are_read(tmp_path: Path) -> None:
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
    found = read_camera_file(path, BOX + origin).views
    for view in on_map:
        there = found[view.name.removesuffix(".jpg")]
        turned = Rotation.from_matrix(there.rotation @ view.rotation.T).magnitude()
        assert np.degrees(turned) < 1e-4
        np.testing.assert_allclose(there.centre, view.centre, atol=1e-3)


def test_opensfm_and_opendronemap_cameras_are_read(tmp_path: Path) -> None:
    path = files.opensfm_json(tmp_path / "reconstruction.json", VIEWS)
    found = read_camera_file(path, BOX)
    same(found.views, VIEWS)
    assert by_code(found.warnings)["cameras.several-parts"] == {"count": 2}
    origin = np.array([500_000.0, 4_000_000.0, 0.0])
    on_map = [v.moved(1.0, np.eye(3), origin) for v in VIEWS]
    shots = files.shots_geojson(tmp_path / "odm_report" / "shots.geojson", on_map)
    same(read_camera_file(shots, BOX + origin).views, on_map, lens=False)
    # OpenDroneMap takes an offset off its meshes.
    (tmp_path / "odm_georeferencing").mkdir()
    (tmp_path / "odm_georeferencing" / "coords.txt").write_text(
        "WGS84 UTM 33N\n500000.0 4000000.0\n"
    )
    found = read_camera_file(shots, BOX)
    same(found.views, VIEWS, lens=False)
    assert "cameras.frame" in by_code(found.warnings)


def test_openmvg_cameras_are_read(tmp_path: Path) -> None:
    path = files.openmvg_json(tmp_path / "sfm_data.json", VIEWS)
    found = read_camera_file(path, BOX)
    same(found.views, VIEWS)
    assert not found.warnings
    assert find_camera_file(tmp_path / "model.ply") == path


@pytest.mark.parametrize(
    ("write", "name", "key"),
    [
        (files.openmvg_json, "sfm_data.json", "intrinsics"),
        (lambda *words: files.alicevision_json(*words, (1, 2, 6)), "cameras.sfm", "intrinsics"),
        (files.opensfm_json, "reconstruction.json", "cameras"),
    ],
)
def test_poses_without_lens_are_read_and_missing_lens_is_reported(
    tmp_path: Path, write: Callable[..., Path], name: str, key: str
) -> None:
    path = write(tmp_path / name, VIEWS)
    data = json.loads(path.read_text())
    for part in data if isinstance(data, list) else [data]:
        part[key] = type(part[key])()
    path.write_text(json.dumps(data))
    found = read_camera_file(path, BOX)
    missing = by_code(found.warnings)["cameras.lenses-missing"]
    assert len(missing["photos"]) == len(VIEWS)
    assert len(missing["lenses"]) == 1
    same(found.views, VIEWS, lens=False)


@pytest.mark.parametrize("version", [(1, 0, 0), (1, 2, 0), (1, 2, 6)])
def test_alicevision_cameras_are_read(tmp_path: Path, version: tuple[int, int, int]) -> None:
    path = files.alicevision_json(tmp_path / "cameras.sfm", VIEWS, version)
    found = read_camera_file(path, BOX)
    same(found.views, VIEWS)
    assert find_camera_file(tmp_path / "model.obj") == path


def test_meshroom_cameras_are_rotated_to_match_the_model(tmp_path: Path) -> None:
    path = files.alicevision_json(tmp_path / "cameras.sfm", VIEWS, (1, 2, 6))
    flip = np.diag([1.0, -1.0, -1.0])
    shift = np.array([0.0, 30.0, 60.0])
    away = [view.moved(1.0, np.eye(3), shift) for view in VIEWS]
    files.alicevision_json(path, away, (1, 2, 6))
    corners = np.sort((BOX + shift) @ flip, axis=0)
    found = read_camera_file(path, corners)
    same(found.views, [view.moved(1.0, flip, np.zeros(3)) for view in away])
    assert "cameras.frame" in by_code(found.warnings)


def test_nerfstudio_cameras_are_read(tmp_path: Path) -> None:
    path = files.nerfstudio_json(tmp_path / "transforms.json", VIEWS)
    same(read_camera_file(path, BOX).views, VIEWS)
    # The axes that nerfstudio exchanges when it takes cameras from COLMAP.
    applied = np.array([[1.0, 0, 0, 40.0], [0, 0, 1, 0], [0, -1, 0, 0]])
    files.nerfstudio_json(path, VIEWS, applied)
    found = read_camera_file(path, BOX)
    same(found.views, VIEWS)
    assert "cameras.frame" in by_code(found.warnings)


def with_lens(lens: Intrinsics) -> list[View]:
    return [replace(view, intrinsics=lens) for view in VIEWS]


def test_bundler_takes_sizes_from_the_photos(tmp_path: Path) -> None:
    views = with_lens(Intrinsics("RADIAL", 400, 300, (320.0, 200.0, 150.0, -0.05, 0.01)))
    path = files.bundler_out(tmp_path / "bundle.out", views)
    found = read_camera_file(path, BOX)
    same(found.views, views, lens=False)
    assert by_code(found.warnings)["cameras.sizes-unknown"]["count"] == len(views)
    files.photos_of(tmp_path, views)
    found = read_camera_file(path, BOX)
    same(found.views, views)
    assert not found.warnings
    (tmp_path / "list.txt").unlink()
    with refused("cameras.no-photo-list", photos=len(views) + 1):
        read_camera_file(path)


@pytest.mark.parametrize("k4", [0.0, 0.02])
def test_reality_capture_cameras_are_read(tmp_path: Path, k4: float) -> None:
    params = (320.0, 320.0, 201.0, 149.0, -0.05, 0.01, 1e-4, 2e-4, 0.002, 0.0, 0.0, 0.0)
    views = with_lens(Intrinsics("FULL_OPENCV", 400, 300, params))
    path = files.reality_capture_csv(tmp_path / "registration.csv", views, k4)
    files.photos_of(tmp_path, views)
    found = read_camera_file(path, BOX)
    assert not found.warnings
    same(found.views, views, lens=k4 == 0.0)
    if k4:
        # x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6 + k4 r^8), here on the axis y = 0 of the lens.
        view = found.views[views[0].name]
        x = np.linspace(0.0, 0.6, 7)
        r2 = x * x
        radial = x * (1 + r2 * (-0.05 + r2 * (0.01 + r2 * (0.002 + r2 * k4))))
        wanted = 320.0 * (radial + 2e-4 * 3 * r2) + 201.0
        pixels = view.intrinsics.project(np.column_stack([x, 0 * x, 0 * x + 1.0]))
        np.testing.assert_allclose(pixels[:, 0], wanted, atol=0.05)


def test_micmac_cameras_are_read(tmp_path: Path) -> None:
    folder = files.micmac_folder(tmp_path / "Ori-All", VIEWS, PLACES)
    for path in (folder, folder / f"Orientation-{VIEWS[0].name}.xml"):
        found = read_camera_file(path, BOX)
        same(found.views, VIEWS)
        assert not found.warnings
    assert find_camera_file(tmp_path / "model.ply") == folder
    # Points that are seen elsewhere show that lens or pose were not understood.
    files.micmac_folder(tmp_path / "Ori-Other", VIEWS, PLACES)
    lens = tmp_path / "Ori-Other" / "AutoCal_Foc-28000.xml"
    lens.write_text(lens.read_text().replace("<F>3200.0", "<F>3300.0"))
    found = read_camera_file(lens.parent, BOX)
    assert by_code(found.warnings)["cameras.unknown-lens"]["photos"] == len(VIEWS)
    assert find_camera_file(tmp_path / "model.ply") is None


def test_tables_of_camera_centres_are_read(tmp_path: Path) -> None:
    for write in (files.metashape_reference, files.metashape_angles):
        found = read_camera_file(write(tmp_path / "a.txt", VIEWS))
        assert not found.views
        for view in VIEWS:
            there = found.centres[view.name.removesuffix(".jpg")]
            np.testing.assert_allclose(there, view.centre, atol=1e-8)


def test_vomstudio_camera_files_round_trip(tmp_path: Path) -> None:
    own = Cameras(tuple(VIEWS), Path("photos"), (100, 200, 300))
    moved = [v.moved(1.0, np.eye(3), np.array([100.0, 200, 300])) for v in VIEWS]
    write_cameras(tmp_path / "cameras.json", own)
    same(read_camera_file(tmp_path / "cameras.json").views, moved, lens=False)
    write_cameras_csv(tmp_path / "cameras.csv", own)
    same(read_camera_file(tmp_path / "cameras.csv").views, moved, lens=False, metres=1e-5)


def test_errors_and_weak_photos_round_trip_in_vomstudio_files(tmp_path: Path) -> None:
    weak = frozenset({VIEWS[1].name})
    own = Cameras(tuple(VIEWS), Path("photos"), is_scaled=True, weak_names=weak)
    write_cameras(tmp_path / "cameras.json", own)
    found = read_camera_file(tmp_path / "cameras.json")
    assert found.weak_names == local_cameras(found).weak_names == weak
    errors = {view.name: (0.01 * i, 0.2 * i) for i, view in enumerate(VIEWS)}
    write_cameras_csv(tmp_path / "cameras.csv", own, errors)
    same(read_camera_file(tmp_path / "cameras.csv").views, VIEWS, lens=False, metres=1e-5)
    with (tmp_path / "cameras.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert float(rows[1]["position_error95_m"]) == pytest.approx(0.01)
    assert float(rows[1]["rotation_error95_deg"]) == pytest.approx(0.2)


def test_camera_files_are_found_beside_the_model(tmp_path: Path) -> None:
    model = tmp_path / "model.ply"
    assert find_camera_file(model) is None
    (tmp_path / "cameras.json").write_text('{"v2 dji": {"projection_type": "brown"}}')
    assert find_camera_file(model) is None
    files.colmap_text(tmp_path / "sparse" / "0", VIEWS)
    assert find_camera_file(model) == tmp_path / "sparse" / "0"
    files.metashape_xml(tmp_path / "cameras.xml", VIEWS, 1.0, np.eye(3), np.zeros(3))
    assert find_camera_file(model) == tmp_path / "cameras.xml"


def test_cameras_facing_away_from_model_are_reported(tmp_path: Path) -> None:
    path = files.opensfm_json(tmp_path / "reconstruction.json", VIEWS)
    far = read_camera_file(path, BOX + 1000.0)
    assert "cameras.not-looking" in by_code(far.warnings)


DAMAGED = ("file.damaged",)
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
        ("r.json", SHOT.format('{"camera": "b"}'), None, "shots/A/rotation", "file.damaged"),
        ("r.json", SHOT.format('{"camera": "a"}'), None, "shots/A/rotation", "file.damaged"),
        (
            "r.json",
            SHOT.format('{"camera": "a", "rotation": [1, 2], "translation": [0, 0, 0]}'),
            None,
            "shots/A/rotation",
            "file.damaged",
        ),
        ("r.json", "[1, 2", None, None, "file.damaged"),
        ("t.json", '{"frames": [{"transform_matrix": 1}]}', None, "frames/0/file_path", *DAMAGED),
        (
            "t.json",
            '{"frames": [{"file_path": "a", "transform_matrix": [[1, 0]]}], "w": 4, "h": 3}',
            None,
            "frames/0/transform_matrix",
            *DAMAGED,
        ),
        (
            "s.json",
            '{"sfm_data_version": "0.3", "views": [], "intrinsics": [{"key": 0}]}',
            None,
            "intrinsics/0/value",
            *DAMAGED,
        ),
        (
            "c.sfm",
            '{"version": ["1", "2"], "views": [{"viewId": "1"}], "intrinsics": []}',
            None,
            "/version",
            *DAMAGED,
        ),
        ("b.out", "# Bundle file v0.3\n1 0\n1 0 0\n1 0 0\n0 1 x\n", 5, None, *DAMAGED),
        ("b.out", "# Bundle file v0.3\n9 0\n1 0 0\n", 3, None, *DAMAGED),
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
def test_damaged_camera_file_is_reported_with_location(
    tmp_path: Path, name: str, text: str, line: int | None, field: str | None, code: str
) -> None:
    path = tmp_path / name
    path.write_text(text)
    with refused(code, line=line, field=field) as error:
        read_camera_file(path)
    assert error.value.file is not None


def test_damaged_colmap_file_is_reported(tmp_path: Path) -> None:
    folder = files.colmap_text(tmp_path / "0", VIEWS)
    images = folder / "images.txt"
    whole = images.read_text().split("\n")
    for cells in (["1", "0", "0"], ["1", *"9999000", "1", "A"]):
        images.write_text("\n".join([whole[0], " ".join(cells), "", *whole[3:]]))
        with refused("file.damaged", format="COLMAP", file=images, line=2):
            read_camera_file(folder)
    (folder / "cameras.txt").write_text("1 OPENCV 40 30 1 2 3\n")
    with refused("file.damaged", format="COLMAP", line=1):
        read_camera_file(folder)
    (folder / "cameras.bin").write_bytes(struct.pack("<Qii", 1, 1, 99) + bytes(16))
    (folder / "images.bin").write_bytes(bytes(8))
    with refused("file.damaged", format="COLMAP"):
        read_camera_file(folder)


@pytest.mark.parametrize("model", ["SIMPLE_RADIAL_FISHEYE 4 3 2 2 1.5 0.1", "FOV 4 3 2 2 2 1.5 1"])
def test_unknown_lens_models_are_reported(tmp_path: Path, model: str) -> None:
    folder = files.colmap_text(tmp_path / "0", VIEWS)
    (folder / "cameras.txt").write_text(f"1 {model}\n")
    found = read_camera_file(folder)
    assert len(found.views) == len(VIEWS)
    unknown = by_code(found.warnings).get("cameras.unknown-lens")
    assert (unknown is not None and unknown["model"] == "FOV") == model.startswith("FOV")
