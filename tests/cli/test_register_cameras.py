"""`vomstudio register` of models whose cameras other programs wrote: a known move comes back."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial.transform import Rotation

from tests.io.photos import camera_files as files
from tests.io.photos.photo_maker import at, text, write_photo
from tests.messages import codes, shown_codes
from tests.registrations import TURN

Array = npt.NDArray[np.float64]
Write = Callable[..., Path]

VIEWS = files.ring()
SCALE, SHIFT = 2.5, np.array([398_000.0, 4_980_000.0, 320.0])
CORNERS = np.array([[x, y, z] for x in (-5, 5) for y in (-4, 4) for z in (-3, 3)], float)


def world(model: Array) -> Array:
    return SCALE * np.asarray(model) @ TURN.T + SHIFT


def off_deg(told: dict) -> float:
    turn = np.array(told["matrix"])[:3, :3] / told["scale"]
    return float(np.degrees(Rotation.from_matrix(turn @ TURN.T).magnitude()))


@pytest.fixture
def model(tmp_path: Path) -> Path:
    folder = tmp_path / "model"
    folder.mkdir()
    path = folder / "model.ply"
    corners = "".join(f"{x} {y} {z}\n" for x, y, z in CORNERS)
    path.write_text(
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty double x\nproperty double y\n"
        "property double z\nend_header\n" + corners
    )
    return path


def colmap(folder: Path) -> Path:
    return files.colmap_text(folder / "sparse" / "0", VIEWS)


def metashape(folder: Path) -> Path:
    turn = Rotation.from_euler("zyx", [50.0, -20.0, 35.0], degrees=True).as_matrix()
    return files.metashape_xml(folder / "cameras.xml", VIEWS, 3.0, turn, np.array([90.0, 8, -5]))


def opensfm(folder: Path) -> Path:
    return files.opensfm_json(folder / "reconstruction.json", VIEWS)


def shots(folder: Path) -> Path:
    return files.shots_geojson(folder / "shots.geojson", VIEWS)


def reference(folder: Path) -> Path:
    return files.metashape_reference(folder / "reference.txt", VIEWS)


@pytest.mark.parametrize("kind", [colmap, metashape, opensfm, shots, reference])
def test_camera_positions_register_model_of_any_program(
    run, write: Write, model: Path, kind
) -> None:
    path = kind(model.parent)
    rows = ["photo,x,y,z"]
    rows += [f"{v.name},{','.join(f'{c:.6f}' for c in world(v.centre))}" for v in VIEWS]
    table = write("\n".join(rows))
    words = [model, "--cameras", table, "--json"]
    named = run("register", *words, "--model-cameras", path).json
    assert off_deg(named) < 1e-4
    assert named["scale"] == pytest.approx(SCALE, rel=1e-6)
    if kind is not reference:
        # Under the names that the programs give them, they are found.
        assert run("register", *words).json["matrix"] == named["matrix"]
    # The placement alone needs no model.
    alone = run("register", "-", *words[1:], "--model-cameras", path).json
    np.testing.assert_allclose(alone["matrix"], named["matrix"], rtol=1e-6)


def test_camera_file_with_only_centres_is_refused_for_attitudes(
    run, write: Write, model: Path
) -> None:
    path = reference(model.parent)
    table = write("photo,yaw,pitch,roll\nIMG_01.jpg,10,0,0\n")
    ran = run("register", model, "--attitudes", table, "--model-cameras", path)
    assert ran.code == 2
    assert "only camera centres" in ran.said


def test_unmatched_photo_names_are_reported(run, write: Write, model: Path) -> None:
    colmap(model.parent)
    ran = run("register", model, "--cameras", write("photo,x,y,z\nDSC1.jpg,1,2,3\n"))
    assert ran.code == 2
    assert "DSC1.jpg" in ran.said
    assert "IMG_00.jpg" in ran.said


# --- given positions ------------------------------------------------------------------------------
THERE = world(np.array([view.centre for view in VIEWS]))


def degrees(places: Array) -> Array:
    from pyproj import Transformer

    back = Transformer.from_crs("EPSG:32633", "EPSG:4326", always_xy=True)
    return np.column_stack([*back.transform(places[:, 0], places[:, 1]), places[:, 2]])


def table_of(places: Array, head: str, places_figures: int = 4, join: str = ",") -> str:
    rows = [
        join.join([v.name, *(f"{c:.{places_figures}f}" for c in there)])
        for v, there in zip(VIEWS, places, strict=True)
    ]
    return "\n".join([head, *rows]) + "\n"


@pytest.mark.parametrize(
    ("head", "more"),
    [
        ("EPSG:32633", ""),
        ("WGS84 UTM 33N", " 10 0 0"),
        ("+proj=utm +zone=33 +datum=WGS84 +units=m +no_defs", " 10 0 0 0.05 0.1 and more"),
    ],
)
def test_geo_txt_names_its_crs(run, write: Write, model: Path, head: str, more: str) -> None:
    colmap(model.parent)
    text_ = table_of(THERE, "", join=" ").splitlines()
    table = write("\n".join([head, *(row + more for row in text_[1:])]), "geo.txt")
    told = run("register", model, "--cameras", table, "--json").json
    assert off_deg(told) < 0.01
    np.testing.assert_allclose(np.array(told["matrix"])[:3, 3], SHIFT, atol=0.01)


def test_geo_txt_in_another_crs_is_converted(run, write: Write, model: Path) -> None:
    colmap(model.parent)
    table = write(table_of(degrees(THERE), "EPSG:4326", 9, " "), "geo.txt")
    ran = run("register", model, "--cameras", table)
    assert ran.code == 2
    # The zone of the photos is proposed.
    assert "EPSG:32633" in ran.said
    told = run("register", model, "--cameras", table, "--crs", "EPSG:32633", "--json").json
    assert off_deg(told) < 0.01
    (heights,) = (w for w in told["warnings"] if w["code"] == "cameras.heights")
    assert heights["geoid_m"] is None
    stated = write("# EPSG:4326\n" + table_of(degrees(THERE), "photo,x,y,z", 9), "in.csv")
    again = run("register", model, "--cameras", stated, "--crs", "EPSG:32633", "--json").json
    np.testing.assert_allclose(again["matrix"], told["matrix"], rtol=1e-6)


def test_positions_in_feet_are_converted_to_given_crs(run, write: Write, model: Path) -> None:
    colmap(model.parent)
    foot = 1200 / 3937
    head = "+proj=utm +zone=33 +datum=WGS84 +units=us-ft +no_defs"
    table = write(table_of(THERE / [foot, foot, 1], head, join=" "), "geo.txt")
    ran = run("register", model, "--cameras", table)
    assert ran.code == 2
    assert "frame.not-in-metres" in shown_codes(ran.said)
    told = run("register", model, "--cameras", table, "--crs", "EPSG:32633", "--json").json
    assert off_deg(told) < 0.01
    assert told["scale"] == pytest.approx(SCALE, rel=1e-5)


def test_the_reference_of_metashape_gives_positions(run, write: Write, model: Path) -> None:
    colmap(model.parent)
    rows = [
        "# CoordinateSystem: WGS 84 (EPSG::4326)",
        "#Label,X/Longitude,Y/Latitude,Z/Altitude,X_est,Y_est,Z_est",
    ]
    for view, (longitude, latitude, z) in zip(VIEWS, degrees(THERE), strict=True):
        rows.append(f"{view.name},{longitude:.10f},{latitude:.10f},{z:.4f},1,2,3")
    table = write("\n".join(rows), "reference.txt")
    told = run("register", model, "--cameras", table, "--crs", "EPSG:32633", "--json").json
    assert off_deg(told) < 0.01


def test_gps_heights_of_different_kinds_are_reported(run, model: Path) -> None:
    colmap(model.parent)
    folder = model.parent / "taken here"
    for number, (view, (longitude, latitude, z)) in enumerate(
        zip(VIEWS, degrees(THERE), strict=True)
    ):
        # One receiver wrote heights above the ellipsoid, the geoid is 45 m above that.
        other = number == 4
        gps = at(latitude, longitude, z + 45.0 * other, 2 if other else 0)
        if number == 5:
            gps = {tag: value for tag, value in gps.items() if tag not in (5, 6)}
        write_photo(folder / view.name, seed=number, main={0x0110: text("A")}, gps=gps)
    told = run("register", model, "--cameras", folder, "--crs", "EPSG:32633", "--json").json
    assert off_deg(told) < 0.1
    named = {each["code"]: each for each in told["warnings"]}
    assert named["cameras.without-height"]["photos"] == ["IMG_05.jpg"]
    assert named["cameras.other-heights"]["photos"] == ["IMG_04.jpg"]
    assert named["cameras.heights"]["heights"] == "sea level"


@pytest.mark.parametrize(
    ("changed", "code"),
    [
        (THERE[:, [1, 0, 2]], "control.swapped-columns"),
        (THERE / [1, 1, 0.3048], "control.other-unit"),
        (THERE / [0.3048, 0.3048, 1], "control.other-unit"),
    ],
)
def test_swapped_columns_and_wrong_units_are_reported(
    run, write: Write, model: Path, changed: Array, code: str
) -> None:
    colmap(model.parent)
    told = run("register", model, "--cameras", write(table_of(changed, "photo,x,y,z")), "--json")
    assert code in codes(told.json)


def test_longitude_and_latitude_exchanged_are_refused(run, write: Write, model: Path) -> None:
    colmap(model.parent)
    table = write(table_of(degrees(THERE)[:, [1, 0, 2]], "photo,longitude,latitude,altitude", 9))
    ran = run("register", model, "--cameras", table, "--crs", "EPSG:32633", "--json")
    assert (ran.code, ran.json["error"]["code"]) == (2, "control.swapped-degrees")


@pytest.mark.parametrize(
    ("text_", "line", "code"),
    [
        ("EPSG:32633\nIMG_00.jpg 1,5 2,5 3,5\n", 2, "table.decimal-comma"),
        ("EPSG:32633\nIMG_00.jpg 1\n", 2, "table.column-count"),
        ("EPSG:32633\nIMG_00.jpg 1 2 3 0 0 0 -1 1\n", 2, "table.not-positive"),
        ("EPSG:32633\nA 1 2 3\nA 1 2 3\n", 3, "table.repeated-label"),
        ("WGS84 UTM 99N\nA 1 2 3\n", 1, "frame.unknown-crs"),
        ("EPSG:99999\nA 1 2 3\n", 1, None),
        ("EPSG:32633\nA 1 2\n", None, None),
    ],
)
def test_geo_txt_errors_have_code_and_line(
    run, write: Write, model: Path, text_: str, line: int | None, code: str | None
) -> None:
    colmap(model.parent)
    ran = run("register", model, "--cameras", write(text_, "geo.txt"), "--json")
    assert ran.code == 2
    assert code is None or ran.json["error"]["code"] == code
    assert line is None or ran.json["error"]["line"] == line
