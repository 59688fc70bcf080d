"""`vomstudio info`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.messages import codes, messages

PROMISED = {
    "path",
    "kind",
    "points",
    "faces",
    "materials",
    "textures",
    "bounds",
    "crs",
    "units",
    "resolution_m",
    "fields",
    "warnings",
}
OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 2\nf 1 2 3\n"


def test_model_is_described_with_documented_fields(run, write) -> None:
    path = write(OBJ, "one.obj")
    (found,) = run("info", path, "--json").json["files"]
    assert found.keys() >= PROMISED
    assert (found["path"], found["kind"]) == (str(path), "mesh")
    assert (found["points"], found["faces"]) == (3, 1)
    assert found["bounds"] == [[0.0, 0.0, 0.0], [1.0, 1.0, 2.0]]


def test_a_text_table_of_points_is_described(run, write) -> None:
    (found,) = run("info", write("x;y;z;name\n1;2;3;a\n4;5;;b\n7;8;9;c\n"), "--json").json["files"]
    assert found.keys() >= PROMISED
    assert (found["kind"], found["points"]) == ("table", 3)
    assert found["fields"] == ["x", "y", "z", "name"]
    assert found["bounds"] == [[1, 2, 3], [7, 8, 9]]
    assert "1 row" in messages(found)[0]


def test_a_table_of_orientations_has_no_bounds(run, write) -> None:
    (found,) = run("info", write("strike,dip\n10,20\n"), "--json").json["files"]
    assert (found["kind"], found["bounds"]) == ("table", None)


def test_images_and_photo_folders_are_described(run, tmp_path: Path) -> None:
    from PIL import Image

    folder = tmp_path / "photos"
    folder.mkdir()
    for name in ("a.jpg", "b.JPG"):
        Image.fromarray(np.zeros((4, 6, 3), np.uint8)).save(folder / name, "JPEG")
    photos, picture = run("info", folder, folder / "a.jpg", "--json").json["files"]
    assert (photos["kind"], photos["photos"]) == ("photos", 2)
    assert (picture["kind"], picture["width"], picture["height"]) == ("raster", 6, 4)
    assert photos.keys() >= PROMISED


def test_all_files_are_reported_though_one_cannot_be_read(run, write, tmp_path: Path) -> None:
    good, bad = write(OBJ, "good.obj"), write(b"", "bad.obj")
    ran = run("info", bad, good, tmp_path / "missing.ply", "--json")
    assert ran.code == 2
    files = ran.json["files"]
    assert [f["path"] for f in files] == [str(bad), str(good), str(tmp_path / "missing.ply")]
    assert files[1]["kind"] == "mesh"
    assert files[0]["error"]["file"] == str(bad)
    assert ran.json["error"] == files[0]["error"]
    assert str(bad) in ran.err
    assert "missing.ply" in ran.err
    plain = run("info", bad, good)
    assert plain.code == 2
    assert "mesh" in plain.out


@pytest.mark.parametrize(
    ("content", "name"),
    [
        (b"", "a.ply"),
        (b"", "a.txt"),
        (b"\x00\x01", "a.csv"),
        (b"not an image", "a.png"),
        (b"\xff\xd8\xff\xe0 cut off", "a.jpg"),
        (b"some words", "a.docx"),
        (b"some words", "noending"),
    ],
)
def test_unreadable_file_is_refused_in_one_sentence(run, write, content: bytes, name: str):
    path = write(content, name)
    ran = run("info", path)
    assert ran.code == 2
    assert str(path) in ran.said
    assert ran.out == ""


def test_a_folder_without_photos_is_refused(run, tmp_path: Path) -> None:
    assert "no photos" in run("info", tmp_path).said


def test_survey_model_keeps_millimetres_and_nine_textures(run, data_dir: Path) -> None:
    path = data_dir / "brighton_model" / "brighton_utm15n.obj"
    (found,) = run("info", path, "--json").json["files"]
    assert found["faces"] == 133_830
    assert len(found["materials"]) == len(found["textures"]) == 9
    low, high = found["bounds"]
    assert [low[0], high[0]] == pytest.approx([576_665.72, 576_765.32], abs=0.005)
    assert [low[1], high[1]] == pytest.approx([5_188_117.06, 5_188_208.90], abs=0.005)


def test_a_table_of_nothing_but_a_header_is_refused(run, write) -> None:
    ran = run("info", write("x,y,z\n"), "--json")
    assert ran.code == 2
    assert ran.json["error"]["code"] == "table.no-rows"


def test_height_raster_has_bounds_and_crs(run, tmp_path: Path) -> None:
    import numpy as np

    from vomstudio.io.gis.raster import Raster, open_geotiff, write_tile

    path = tmp_path / "dem.tif"
    grid = Raster(5, 3, "float", (2.0, 0.0, 576000.0, 0.0, -2.0, 5188000.0), "EPSG:32615")
    with open_geotiff(path, grid) as dataset:
        write_tile(dataset, 0, 0, np.arange(15, dtype=np.float32).reshape(3, 5) + 100)
    (found,) = run("info", path, "--json").json["files"]
    assert (found["kind"], found["width"], found["height"]) == ("raster", 5, 3)
    assert found["bounds"] == [[576001, 5187995, 100], [576009, 5187999, 114]]
    assert found["crs"] == "EPSG:32615"
    assert found["points"] == 15
    assert messages(found) == []


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.e57", b"ASTM-E57" + bytes(200)),
        ("a.copc.laz", b"LASF" + bytes(400)),
        ("a.tif", b"II*\0" + bytes(30)),
        ("b.e57", b""),
        ("b.copc.laz", b""),
        ("b.tif", b""),
    ],
)
def test_damaged_files_are_reported_in_one_sentence(
    run, tmp_path: Path, name: str, content: bytes
) -> None:
    (tmp_path / name).write_bytes(content)
    for words in (("info", tmp_path / name), ("convert", tmp_path / name, tmp_path / "o.ply")):
        ran = run(*words)
        assert ran.code == 2
        assert name in ran.said
    assert [p.name for p in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize(
    ("code", "units", "label"),
    [
        ("EPSG:26917", ["m", "m", "m"], "x, m"),
        ("EPSG:26917+6360", ["m", "m", "us-ft"], "x, m"),
        ("EPSG:2264", ["us-ft", "us-ft", "us-ft"], "x, m"),
        ("EPSG:4326", ["degree", "degree", "unknown"], "x, degree"),
        (None, ["unknown", "unknown", "unknown"], "x "),
    ],
)
def test_units_are_those_of_file_and_lengths_are_in_metres(
    run, tmp_path: Path, code: str | None, units: list[str], label: str
) -> None:
    """A grid of spacing 1 in the file's unit, whose bounds laspy gives."""
    import laspy
    from pyproj import CRS

    header = laspy.LasHeader(version="1.4", point_format=6)
    header.scales = [1e-3] * 3
    if code is not None:
        header.add_crs(CRS.from_user_input(code))
    las = laspy.LasData(header)
    x, y = (values.ravel() for values in np.mgrid[10.0:30, 40.0:60])
    las.x, las.y, las.z = x, y, np.full(len(x), 100.0)
    las.write(tmp_path / "a.las")
    ran = run("info", tmp_path / "a.las", "--json")
    (found,) = ran.json["files"]
    metres = {"m": 1.0, "us-ft": 1200 / 3937}.get(units[0])
    high = {"m": 1.0, "us-ft": 1200 / 3937}.get(units[2])
    assert found["units"] == units
    if metres is None or high is None:
        assert found["resolution_m"] is None
        assert found["resolution"] == pytest.approx(1.0, rel=0.06)
        assert found["bounds"] == [[10, 40, 100], [29, 59, 100]]
    else:
        assert "resolution" not in found
        assert found["resolution_m"] == pytest.approx(metres, rel=0.06)
        corners = np.array(las_bounds(tmp_path / "a.las"))
        scaled = corners * [metres, metres, high]
        assert np.allclose(found["bounds"], scaled)
    text = run("info", tmp_path / "a.las")
    assert label in text.out
    assert ("x, m" in text.out) == (metres is not None)


def las_bounds(path: Path) -> list:
    import laspy

    with laspy.open(path) as file:
        return [file.header.mins, file.header.maxs]


def test_truncated_height_raster_is_reported(run, tmp_path: Path) -> None:
    from vomstudio.io.gis.raster import Raster, open_geotiff, write_tile

    whole, cut = tmp_path / "whole.tif", tmp_path / "cut.tif"
    grid = Raster(300, 200, "float", (2.0, 0.0, 576000.0, 0.0, -2.0, 5188000.0), "EPSG:32615")
    with open_geotiff(whole, grid) as dataset:
        write_tile(dataset, 0, 0, np.random.default_rng(1).random((200, 300)).astype(np.float32))
    cut.write_bytes(whole.read_bytes()[: whole.stat().st_size // 2])
    of_whole, of_cut = run("info", whole, cut, "--json").json["files"]
    assert messages(of_whole) == []
    assert codes(of_cut) == ["file.damaged"]


@pytest.mark.parametrize(
    ("crs", "turned", "known"),
    [
        ("EPSG:32615", 0.0, True),
        ("EPSG:32615", 0.3, False),  # its rows do not run eastward
        ("EPSG:4326", 0.0, False),  # degrees
        ("EPSG:2263", 0.0, False),  # feet
        ('LOCAL_CS["plane",UNIT["metre",1]]', 0.0, False),  # an oblique orthophoto
        (None, 0.0, False),
    ],
)
def test_orthophoto_has_bounds_and_crs(
    run, tmp_path: Path, crs: str | None, turned: float, known: bool
) -> None:
    import rasterio

    path = tmp_path / "ortho.tif"
    profile = {"driver": "GTiff", "width": 5, "height": 4, "count": 3, "dtype": "uint8"}
    transform = rasterio.Affine(0.5, turned, 576_000, 0, -0.5, 5_188_000)
    with rasterio.open(path, "w", crs=crs, transform=transform, **profile) as dataset:
        dataset.write(np.full((3, 4, 5), 9, np.uint8))
    ran = run("info", path, "--json")
    (found,) = ran.json["files"]
    assert ran.code == 0
    assert (found["kind"], found["width"], found["height"]) == ("raster", 5, 4)
    if not known:
        assert (found["crs"], found["bounds"], found["units"]) == (None, None, None)
        assert codes(found) == ["picture.place-unreadable"]
        return
    assert found["crs"] == crs
    assert found["bounds"] == [[576_000, 5_187_998, None], [576_002.5, 5_188_000, None]]
    assert (found["units"], found["resolution_m"]) == (["m", "m", "unknown"], 0.5)
    assert messages(found) == []
    said = run("info", path).out
    assert "576000.000 to 576002.500" in said
    assert "resolution, m  0.5" in said


def test_a_height_model_of_64_bit_numbers_is_described(run, tmp_path: Path) -> None:
    import rasterio

    path = tmp_path / "dem.tif"
    profile = {"driver": "GTiff", "width": 5, "height": 4, "count": 1, "crs": "EPSG:32633"}
    transform = rasterio.Affine(2, 0, 500_000, 0, -2, 200_000)
    with rasterio.open(path, "w", dtype="float64", transform=transform, **profile) as dataset:
        dataset.write(np.arange(20.0).reshape(4, 5), 1)
    ran = run("info", path, "--json")
    (found,) = ran.json["files"]
    assert ran.code == 0
    assert (found["kind"], found["width"], found["height"]) == ("raster", 5, 4)
    assert (found["points"], found["units"]) == (20, ["m", "m", "m"])
    assert found["bounds"] == [[500_001, 199_993, 0], [500_009, 199_999, 19]]


def test_point_table_uses_crs_of_prj_file(run, write, tmp_path: Path) -> None:
    rows = "x,y,z\n" + "".join(f"{500_000 + x},{5_000_000 + y},{x}\n" for x, y in np.ndindex(9, 9))
    for ending in (".csv", ".xyz"):
        (tmp_path / "a.prj").unlink(missing_ok=True)
        path = write(rows, f"a{ending}")
        (before,) = run("info", path, "--json").json["files"]
        assert (before["crs"], before["units"]) == (None, ["unknown"] * 3)
        (tmp_path / "a.prj").write_text("EPSG:2263")
        (feet,) = run("info", path, "--json").json["files"]
        assert (feet["crs"], feet["units"]) == ("EPSG:2263", ["us-ft"] * 3)
        assert np.allclose(feet["bounds"], np.array(before["bounds"]) * 1200 / 3937)
        assert feet["resolution_m"] == pytest.approx(2**0.25 * 1200 / 3937, rel=0.1)
    (tmp_path / "a.prj").write_text("EPSG:4326")
    (degrees,) = run("info", write(rows, "a.csv"), "--json").json["files"]
    assert (degrees["points"], degrees["crs"]) == (81, None)
    assert codes(degrees) == ["frame.not-degrees"]


@pytest.mark.parametrize(
    ("crs", "north", "code"),
    [
        ("EPSG:4326", 200_000, "frame.not-degrees"),
        ("EPSG:4978", 200_000, "frame.geocentric"),
        ("EPSG:3857", 5_000_000, "frame.not-metric"),
        ("EPSG:2263", 200_000, "frame.unit-converted"),
    ],
)
def test_point_table_has_same_findings_as_measuring_commands(
    run, write, tmp_path: Path, crs: str, north: int, code: str
) -> None:
    path = write("x,y,z\n" + "".join(f"{980_000 + i},{north + i * i},{i}\n" for i in range(9)))
    (tmp_path / "in.prj").write_text(crs)
    (described,) = run("info", path, "--json").json["files"]
    measured = run("threepoint", path, "--json").json
    expected = [measured["error"]["code"]] if "error" in measured else codes(measured)
    assert codes(described) == expected == [code]


def test_a_table_that_was_converted_keeps_its_crs(run, write, tmp_path: Path) -> None:
    rows = "x,y,z\n" + "".join(f"{500_000 + x},{5_000_000 + y},{x}\n" for x, y in np.ndindex(9, 9))
    assert run("convert", write(rows, "in.csv"), tmp_path / "o.csv", "--crs", "32633").code == 0
    (found,) = run("info", tmp_path / "o.csv", "--json").json["files"]
    assert (found["crs"], found["units"]) == ("EPSG:32633", ["m", "m", "m"])


@pytest.mark.parametrize(("bands", "kind"), [(4, "uint16"), (1, "complex64"), (5, "float32")])
def test_raster_unreadable_by_pillow_is_described(run, tmp_path: Path, bands, kind) -> None:
    import rasterio

    path = tmp_path / "a.tif"
    with rasterio.open(
        path,
        "w",
        driver="GTiff",
        width=30,
        height=20,
        count=bands,
        dtype=kind,
        crs="EPSG:32633",
        transform=rasterio.Affine(1, 0, 5e5, 0, -1, 2e5),
    ) as dataset:
        dataset.write(np.ones((bands, 20, 30), kind))
    (found,) = run("info", path, "--json").json["files"]
    assert (found["kind"], found["width"], found["height"]) == ("raster", 30, 20)
    assert (len(found["fields"]), found["crs"]) == (bands, "EPSG:32633")


def test_heights_without_georeference_are_reported(run, tmp_path: Path) -> None:
    from PIL import Image

    Image.fromarray(np.ones((20, 30), np.float32)).save(tmp_path / "a.tif")
    (found,) = run("info", tmp_path / "a.tif", "--json").json["files"]
    assert "dem.no-place" in codes(found)
