"""`vomstudio register`: known places, from every kind of observation."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from pyproj import Transformer
from scipy.spatial.transform import Rotation

from tests.messages import codes, messages, shown_codes
from tests.registrations import TURN
from tests.tiers import first_in_default_tier
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.io.models.opening import read_model
from vomstudio.io.photos.cameras_file import Cameras, write_cameras

Array = npt.NDArray[np.float64]
Write = Callable[..., Path]

SCALE, SHIFT = 2.5, np.array([398_000.0, 4_980_000.0, 320.0])
CORNERS = np.array(
    [[0, 0, 0], [9, 0, 0], [0, 4, 1], [3, 2, 5], [5, 1, 0.5], [7, 3, 4], [1, 3, 3], [8, 2, 1]],
    float,
)


def world(model: Array) -> Array:
    return SCALE * np.asarray(model) @ TURN.T + SHIFT


def matrix_of(told: dict) -> Array:
    return np.array(told["matrix"])


def turn_of(told: dict) -> Array:
    return matrix_of(told)[:3, :3] / told["scale"]


def off_deg(told: dict) -> float:
    return float(np.degrees(Rotation.from_matrix(turn_of(told) @ TURN.T).magnitude()))


def pairs_text(model: Array, there: Array, header: str = "", join: str = ",") -> str:
    rows = [
        join.join([f"P{i}", *(f"{v:.6f}" for v in (*a, *b))])
        for i, (a, b) in enumerate(zip(model, there, strict=True))
    ]
    return "\n".join([*([header] if header else []), *rows]) + "\n"


HEADER = "label,model_x,model_y,model_z,x,y,z"


# --- points ---------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    "header",
    [
        HEADER,
        "",
        "#Label,Model_X,Model_Y,Model_Z,X,Y,Z",
        "# label, model x, model y, model z, easting, northing, elevation",
    ],
)
def test_pairs_give_registration_with_any_header(run, write: Write, header: str) -> None:
    table = write(pairs_text(CORNERS, world(CORNERS), header))
    ran = run("register", "-", "--pairs", table, "--json")
    assert ran.code == 0, ran.err
    told = ran.json
    assert told["scale"] == pytest.approx(SCALE, rel=1e-6)
    np.testing.assert_allclose(turn_of(told), TURN, atol=1e-6)
    np.testing.assert_allclose(matrix_of(told)[:3, 3], SHIFT, atol=1e-4)
    assert told["known"] == dict.fromkeys(("north", "vertical", "scale", "position"), True)
    assert told["blunders"] == []
    assert [p["label"] for p in told["control"]] == [f"P{i}" for i in range(8)]


def test_decimal_commas_and_semicolons_are_read(run, write: Write) -> None:
    text = pairs_text(CORNERS, world(CORNERS), HEADER.replace(",", ";"), ";").replace(".", ",")
    told = run("register", "-", "--pairs", write(text), "--json").json
    np.testing.assert_allclose(turn_of(told), TURN, atol=1e-6)


def test_check_points_are_excluded_from_the_fit(run, write: Write) -> None:
    there = world(CORNERS)
    there[6:] += [5.0, -3.0, 2.0]
    rows = pairs_text(CORNERS, there).splitlines()
    uses = ["control"] * 6 + ["check"] * 2
    text = "\n".join([HEADER + ",use", *(f"{r},{u}" for r, u in zip(rows, uses, strict=True))])
    told = run("register", "-", "--pairs", write(text), "--json").json
    np.testing.assert_allclose(turn_of(told), TURN, atol=1e-6)
    assert len(told["control"]), len(told["check"]) == (6, 2)
    for point in told["check"]:
        # Fitted less given.
        assert [point["dx"], point["dy"], point["dz"]] == pytest.approx([-5, 3, -2], abs=1e-3)
        assert point["error_m"] == pytest.approx(np.sqrt(38), abs=1e-3)
    assert told["rms_check_m"] == pytest.approx(np.sqrt(38), abs=1e-3)


def test_blunder_is_reported_with_its_size(run, write: Write) -> None:
    there = world(CORNERS) + np.random.default_rng(3).normal(size=CORNERS.shape) * 0.01
    there[4, 0] += 2.0
    told = run("register", "-", "--pairs", write(pairs_text(CORNERS, there, HEADER)), "--json").json
    (found,) = told["blunders"]
    assert found["label"] == "P4"
    assert found["error_m"] == pytest.approx(2.0, abs=0.1)
    assert "registration.blunder" in codes(told)


def test_exchanged_easting_and_northing_are_recognised(run, write: Write) -> None:
    there = world(CORNERS)[:, [1, 0, 2]]
    told = run("register", "-", "--pairs", write(pairs_text(CORNERS, there, HEADER)), "--json").json
    assert "control.swapped-columns" in codes(told)
    assert np.linalg.det(turn_of(told)) == pytest.approx(1.0)


def test_registered_model_is_written(run, write: Write, tmp_path: Path) -> None:
    faces = "3 0 1 2\n3 1 4 3\n3 2 3 5\n"
    head = (
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty double x\nproperty double y\n"
        "property double z\nelement face 3\nproperty list uchar int vertex_indices\nend_header\n"
    )
    corners = "".join(f"{x} {y} {z}\n" for x, y, z in CORNERS)
    model = write(head + corners + faces, "model.ply")
    table = write(pairs_text(CORNERS, world(CORNERS), HEADER))
    out = tmp_path / "placed.obj"
    ran = run("register", model, "--pairs", table, "--crs", "EPSG:32633", "-o", out, "--json")
    assert ran.code == 0, ran.err
    assert ran.json["out"] == str(out)
    placed = read_model(out)
    there = world(CORNERS)
    np.testing.assert_allclose(placed.data.bounds, [there.min(0), there.max(0)], atol=1e-3)
    again = run("register", model, "--pairs", table, "-o", out, "--json")
    assert again.code != 0
    assert again.json["error"]["code"] == "output.exists"


def test_registration_is_written_as_json(run, write: Write, tmp_path: Path) -> None:
    table = write(pairs_text(CORNERS, world(CORNERS), HEADER))
    out = tmp_path / "place.json"
    ran = run("register", "-", "--pairs", table, "-o", out, "--json")
    kept = json.loads(out.read_text("utf-8"))
    assert kept["matrix"] == ran.json["matrix"]


# --- lengths, azimuths, compass -------------------------------------------------------------------
# --- the frame of the file --------------------------------------------------------------------
@pytest.mark.parametrize("stated", [False, True])
def test_positions_are_converted_to_another_crs(run, write: Write, stated: bool) -> None:
    there = world(CORNERS)
    to_other = Transformer.from_crs(32633, 32632, always_xy=True)
    x, y = to_other.transform(there[:, 0], there[:, 1])
    expected = write(pairs_text(CORNERS, np.column_stack([x, y, there[:, 2]]), HEADER), "32.csv")
    comment = "# CRS: EPSG:32633\n" if stated else ""
    table = write(comment + pairs_text(CORNERS, there, HEADER), "33.csv")
    options = ("--to-crs", "EPSG:32632", "--json", *(() if stated else ("--crs", "EPSG:32633")))
    told = run("register", "-", "--pairs", table, *options).json
    same = run("register", "-", "--pairs", expected, "--crs", "EPSG:32632", "--json").json
    assert "frame.reprojected" in codes(told)
    np.testing.assert_allclose(matrix_of(told), matrix_of(same), rtol=0, atol=1e-4)


def test_positions_in_degrees_are_converted(run, write: Write) -> None:
    there = world(CORNERS)
    degrees = Transformer.from_crs(32633, 4326, always_xy=True).transform(there[:, 0], there[:, 1])
    rows = ["label,model_x,model_y,model_z,x,y,z"]
    for i, (a, x, y, z) in enumerate(zip(CORNERS, *degrees, there[:, 2], strict=True)):
        rows.append(f"P{i},{a[0]},{a[1]},{a[2]},{x:.11f},{y:.11f},{z:.4f}")
    table = write("\n".join(rows) + "\n")
    words = ("register", "-", "--pairs", table, "--crs", "EPSG:4326", "--json")
    told = run(*words, "--to-crs", "EPSG:32633").json
    assert told["scale"] == pytest.approx(SCALE, rel=1e-4)
    assert off_deg(told) < 0.01
    assert run(*words).code == 2


def test_positions_without_a_crs_cannot_be_converted(run, write: Write) -> None:
    table = write(pairs_text(CORNERS, world(CORNERS), HEADER))
    ran = run("register", "-", "--pairs", table, "--to-crs", "EPSG:32632", "--json")
    assert ran.json["error"]["code"] == "frame.no-crs"


def test_stated_axis_and_unit_fill_in_unobserved_parts(run, write: Write) -> None:
    model = write("x,y,z\n" + "".join(f"{x},{y},{z}\n" for x, y, z in CORNERS), "m.csv")
    north = ("--bearing", "0,0,0,0,0,-9,0", "--up", "y", "--unit", "cm")
    told = run("register", model, *north, "--json").json
    # y of the file is up, and minus z is north.
    y_up = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], float)
    np.testing.assert_allclose(matrix_of(told)[:3, :3], 0.01 * y_up, atol=1e-9)
    assert told["known"]["scale"]


def test_a_stated_unit_fixes_the_scale(run, write: Write) -> None:
    model = write("x,y,z\n" + "".join(f"{x},{y},{z}\n" for x, y, z in CORNERS), "m.csv")
    pairs = write(pairs_text(CORNERS, world(CORNERS), HEADER))
    told = run("register", model, "--pairs", pairs, "--unit", "km", "--json").json
    assert told["scale"] == pytest.approx(1000.0)
    kept = run("register", model, "--pairs", pairs, "--unit", "m", "--json").json
    same = run("register", model, "--pairs", pairs, "--keep-scale", "--json").json
    assert matrix_of(kept) == pytest.approx(matrix_of(same))


@pytest.mark.parametrize("option", [("--up", "y"), ("--unit", "cm")])
def test_up_and_unit_options_need_a_model_file(run, write: Write, option: tuple[str, str]) -> None:
    pairs = write(pairs_text(CORNERS, world(CORNERS), HEADER))
    error = run("register", "-", "--pairs", pairs, *option, "--json").json["error"]
    assert (error["code"], error["option"]) == ("option.needs-model", option[0])


# --- other observations -----------------------------------------------------------------------
def test_one_length_and_one_azimuth_give_partial_registration(run) -> None:
    told = run(
        "register", "-", "--scale", "0,0,0,2,0,0,5", "--bearing", "0,0,0,1,0,0,30", "--json"
    ).json
    assert told["scale"] == pytest.approx(2.5)
    # East of the model now points to 030; what is up stays up.
    np.testing.assert_allclose(turn_of(told) @ [1, 0, 0], [0.5, np.sqrt(0.75), 0], atol=1e-9)
    np.testing.assert_allclose(turn_of(told) @ [0, 0, 1], [0, 0, 1], atol=1e-9)
    assert told["known"] == {"north": True, "vertical": False, "scale": True, "position": False}
    assert told["rotation_error_95_deg"]["about_east"] is None
    assert told["rotation_error_95_deg"]["weakest"]["error_deg"] is None


def test_compass_planes_rotate_model_with_stated_error(run, write: Write) -> None:
    rng = np.random.default_rng(5)
    rows = ["dip_direction,dip,model_x,model_y,model_z,sigma_deg"]
    for normal in Rotation.random(12, random_state=4).as_matrix()[:, 0]:
        there = TURN @ normal + rng.normal(size=3) * np.radians(1.5)
        plane = Plane.from_normal(there / np.linalg.norm(there))
        rows.append(
            f"{plane.dip_direction_deg},{plane.dip_deg},{normal[0]},{normal[1]},{normal[2]},1.5"
        )
    told = run("register", "-", "--orientations", write("\n".join(rows)), "--json").json
    worst = told["rotation_error_95_deg"]["weakest"]["error_deg"]
    # The worst of one axis; the angle here is that about all three.
    assert off_deg(told) < 1.8 * worst < 4.0
    assert told["scale"] == 1.0
    assert told["known"] == {"north": True, "vertical": True, "scale": False, "position": False}


def test_azimuth_option_applies_to_orientation_table(run, tmp_path: Path) -> None:
    table = tmp_path / "compass.csv"
    table.write_text(
        "azimuth,dip,model_x,model_y,model_z\n90,90,1,0,0\n0,90,0,1,0\n45,30,0.3536,0.3536,0.866\n"
    )
    words = ("register", "-", "--orientations", table, "--json")
    asked = run(*words)
    assert asked.json["error"]["code"] == "orientation.ambiguous-azimuth"
    by_direction = run(*words, "--azimuth", "dipdir")
    assert by_direction.code == 0
    np.testing.assert_allclose(by_direction.json["matrix"], np.eye(4), atol=1e-3)


@pytest.mark.full
def test_strike_entered_as_dip_direction_is_reported(run, write: Write) -> None:
    rows = ["id,dip_direction,dip,model_x,model_y,model_z,sigma_deg"]
    for number, normal in enumerate(Rotation.random(9, random_state=8).as_matrix()[:, 0]):
        plane = Plane.from_normal(TURN @ normal)
        azimuth = (plane.dip_direction_deg + (90.0 if number == 5 else 0.0)) % 360.0
        rows.append(f"B{number},{azimuth},{plane.dip_deg},{normal[0]},{normal[1]},{normal[2]},2")
    told = run("register", "-", "--orientations", write("\n".join(rows)), "--json").json
    assert "B5" in [b["label"] for b in told["blunders"]]


def test_scale_bars_can_be_check_bars(run, write: Write) -> None:
    table = write(pairs_text(CORNERS, world(CORNERS), HEADER))
    longer = 1.1 * SCALE * np.linalg.norm(CORNERS[1] - CORNERS[0])
    bars = write(f"from,to,length_m,sigma_m,use\nP0,P1,{longer},0.01,check\n", "bars.csv")
    told = run("register", "-", "--pairs", table, "--scale-bars", bars, "--json").json
    assert told["scale"] == pytest.approx(SCALE, rel=1e-6)
    (bar,) = (each for each in told["warnings"] if each["code"] == "scale.check-bar")
    assert bar["name"] == "P0 - P1"
    assert bar["error_m"] == pytest.approx(-2.25, abs=0.005)
    unknown = write("from,to,length_m\nP0,Q,3\n", "bars.csv")
    ran = run("register", "-", "--pairs", table, "--scale-bars", unknown)
    assert ran.code == 2
    assert "Q" in ran.said


# --- cameras --------------------------------------------------------------------------------------
def looking_at(centre: Array, target: Array) -> Array:
    """Rotation of a level camera from the scene to it."""
    forward = (target - centre) / np.linalg.norm(target - centre)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(forward, right), forward])


LENS = Intrinsics.pinhole(4000, 3000, 3200.0, 2000.0, 1500.0)


def cameras_beside(folder: Path, centres: Array, targets: Array) -> Path:
    """A model with cameras of which the World poses are level, and their places in World."""
    views = []
    for number, (centre, target) in enumerate(zip(centres, targets, strict=True)):
        there, at = world(centre[None])[0], world(target[None])[0]
        rotation = looking_at(there, at) @ TURN
        views.append(View(f"IMG_{number:02d}.jpg", LENS, rotation, -rotation @ centre))
    write_cameras(folder / "cameras.json", Cameras(tuple(views), Path("photos")), force=True)
    corners = "".join(f"{x} {y} {z}\n" for x, y, z in CORNERS)
    model = folder / "model.ply"
    model.write_text(
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty double x\nproperty double y\n"
        "property double z\nend_header\n" + corners
    )
    return model


@pytest.fixture
def stations(tmp_path: Path) -> tuple[Path, Array, list[View]]:
    """Nine cameras around the rock, their centres on the model and their views."""
    rng = np.random.default_rng(2)
    angles = np.linspace(0.0, 2.4, 9)
    centres = np.column_stack([4 + 14 * np.cos(angles), 2 + 14 * np.sin(angles), 2 + angles])
    centres += rng.normal(size=centres.shape)
    targets = CORNERS.mean(axis=0) + rng.normal(size=centres.shape)
    model = cameras_beside(tmp_path, centres, targets)
    from vomstudio.io.photos.cameras_file import read_cameras

    return model, centres, list(read_cameras(tmp_path / "cameras.json").views)


def test_camera_positions_register_model_and_outliers_are_left_out(
    run, write: Write, stations
) -> None:
    model, centres, _ = stations
    there = world(centres) + np.random.default_rng(1).normal(size=centres.shape) * 0.02
    there[3] += [40.0, 0.0, 0.0]
    rows = [f"IMG_{i:02d},{x},{y},{z}" for i, (x, y, z) in enumerate(there)]
    table = write("\n".join(["photo,x,y,z", *rows]))
    told = run("register", model, "--cameras", table, "--json").json
    worst = told["rotation_error_95_deg"]["weakest"]["error_deg"]
    assert off_deg(told) < worst < 1.0
    assert any("IMG_03" in said and "left out" in said for said in messages(told))


def test_positions_in_degrees_need_a_crs_and_use_it(run, write: Write, stations) -> None:
    from pyproj import Transformer

    model, centres, _ = stations
    to_degrees = Transformer.from_crs("EPSG:32633", "EPSG:4326", always_xy=True)
    rows = []
    for i, (x, y, z) in enumerate(world(centres)):
        longitude, latitude = to_degrees.transform(x, y)
        rows.append(f"IMG_{i:02d}.jpg,{latitude:.10f},{longitude:.10f},{z:.4f}")
    table = write("\n".join(["file,latitude,longitude,altitude", *rows]))
    ran = run("register", model, "--cameras", table)
    assert ran.code == 2
    assert "--crs" in ran.said
    told = run("register", model, "--cameras", table, "--crs", "EPSG:32633", "--json").json
    assert off_deg(told) < 0.01
    assert any("ellipsoid" in said for said in messages(told))


def test_collinear_cameras_and_excessive_noise_are_refused(
    run, write: Write, tmp_path: Path
) -> None:
    line = np.column_stack([np.linspace(0, 20, 8), np.full(8, -15.0), np.full(8, 2.0)])
    model = cameras_beside(tmp_path, line, line + [0.0, 15.0, 0.0])

    def code(there: Array) -> str:
        rows = [f"IMG_{i:02d},{x},{y},{z}" for i, (x, y, z) in enumerate(there)]
        table = write("\n".join(["photo,x,y,z", *rows]))
        ran = run("register", model, "--cameras", table, "--json")
        assert ran.code == 2
        return ran.json["error"]["code"]

    assert code(world(line)) == "collinear"
    ring = line + np.random.default_rng(0).normal(size=line.shape)
    model = cameras_beside(tmp_path, ring, line + [0.0, 15.0, 0.0])
    noise = np.random.default_rng(1).normal(size=line.shape) * 60.0
    assert code(world(ring) + noise) == "cameras.unsure"


def angles_of(view: View) -> tuple[float, float, float]:
    """Yaw, pitch and roll of a camera, by what these words mean, not by the program's matrices."""
    right, _, forward = view.rotation @ TURN.T
    yaw = np.degrees(np.arctan2(forward[0], forward[1]))
    pitch = np.degrees(np.arcsin(forward[2]))
    level = np.cross(forward, [0.0, 0.0, 1.0])
    level /= np.linalg.norm(level)
    roll = np.degrees(np.arctan2(-(right @ np.cross(level, forward)), right @ level))
    return float(yaw), float(pitch), float(roll)


@pytest.mark.parametrize("roll_deg", [0.0, 20.0, -90.0])
def test_attitudes_turn_the_model(run, write: Write, tmp_path: Path, stations, roll_deg) -> None:
    model, _, views = stations
    # The camera is tilted clockwise as the photographer sees it: the scene in it turns back.
    c, s = np.cos(np.radians(roll_deg)), np.sin(np.radians(roll_deg))
    tilted = [
        View(v.name, LENS, np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) @ v.rotation, v.translation)
        for v in views
    ]
    write_cameras(tmp_path / "cameras.json", Cameras(tuple(tilted), Path("photos")), force=True)
    rows = []
    for number, view in enumerate(views):
        yaw, pitch, roll = angles_of(view)
        assert roll == pytest.approx(0.0, abs=1e-6)
        rows.append(f"IMG_{number:02d}.jpg,{yaw % 360.0},{pitch},{roll_deg}")
    table = write("\n".join(["photo,yaw,pitch,roll", *rows]))
    told = run("register", model, "--attitudes", table, "--json").json
    assert off_deg(told) < 1e-4
    assert told["known"] == {"north": True, "vertical": True, "scale": False, "position": False}


def test_systematic_compass_error_increases_azimuth_error(run, write: Write, stations) -> None:
    model, _, views = stations
    rows = []
    for number, view in enumerate(views):
        yaw, pitch, roll = angles_of(view)
        rows.append(
            f"IMG_{number:02d}.jpg,{(yaw + 14.0) % 360.0},{pitch},{roll},1,0.5,0.5,magnetic"
        )
    head = "photo,yaw,pitch,roll,sigma_yaw,sigma_pitch,sigma_roll,north"
    told = run("register", model, "--attitudes", write("\n".join([head, *rows])), "--json").json
    errors = told["rotation_error_95_deg"]
    assert 14.0 < errors["about_up"] < 25.0
    # The vertical does not suffer from it.
    assert errors["about_east"] < 1.0
    assert (turn_of(told) @ TURN.T)[2] == pytest.approx([0, 0, 1], abs=1e-6)


def test_horizon_lines_of_one_view_leave_tilt_undetermined(
    run, write: Write, tmp_path: Path, stations
) -> None:
    model, _, views = stations

    def told_by(chosen: list[View]) -> dict:
        rows = [f"{v.name},100,1500,3900,1500" for v in chosen]
        table = write("\n".join(["photo,x1,y1,x2,y2", *rows]))
        return run("register", model, "--horizon", table, "--json").json

    one = told_by(views[:1])
    assert not one["known"]["vertical"]
    several = told_by(views)
    assert several["known"]["vertical"]
    assert not several["known"]["north"]
    # Up is where it is; north stays as it was.
    up = turn_of(several) @ TURN.T @ [0, 0, 1]
    assert np.degrees(np.arccos(min(1.0, up[2]))) < 0.5 or up[2] < -0.999


def marked_corners(write: Write, views, label: str = "P{}", photo: str = "{}"):
    """A table of the corners P0, P1..., and the rows of their marks in the photos; label, photo :
    as they are written there."""
    rows = (f"P{i},{x},{y},{z}" for i, (x, y, z) in enumerate(world(CORNERS)))
    control = write("\n".join(["label,x,y,z", *rows]), "control.csv")
    marks = ["label,photo,x,y"]
    for number, corner in enumerate(CORNERS):
        for view in views:
            x, y = view.project(corner)[0]
            marks.append(f"{label.format(number)},{photo.format(view.name)},{x},{y}")
    return control, marks


def test_marks_in_photos_locate_control_points(run, write: Write, stations) -> None:
    model, _, views = stations
    control, marks = marked_corners(write, views[:4])
    told = run(
        "register",
        model,
        "--gcp",
        control,
        "--marks",
        write("\n".join(marks), "marks.csv"),
        "--json",
    ).json
    assert off_deg(told) < 1e-3
    assert told["scale"] == pytest.approx(SCALE, rel=1e-5)
    assert [p["pixels"] for p in told["control"]] == pytest.approx([0.0] * 8, abs=0.01)


def test_mark_residuals_are_reported_in_pixels(run, write: Write, stations) -> None:
    """A check point that is given 0.1 m too far along the image plane of a camera 35 m away is seen
    0.1 / distance x focal length beside its marks."""
    model, _, views = stations
    there = world(CORNERS)
    view = views[0]
    across = view.rotation[0] @ TURN.T
    there[7] += 0.1 * across
    rows = [
        f"P{i},{x},{y},{z},{'check' if i == 7 else 'control'}" for i, (x, y, z) in enumerate(there)
    ]
    control = write("\n".join(["label,x,y,z,use", *rows]), "control.csv")
    marks = ["label,photo,x,y"]
    for number, corner in enumerate(CORNERS):
        for each in views[:2]:
            x, y = each.project(corner)[0]
            marks.append(f"P{number},{each.name},{x},{y}")
    told = run(
        "register",
        model,
        "--gcp",
        control,
        "--marks",
        write("\n".join(marks), "marks.csv"),
        "--json",
    ).json
    (point,) = told["check"]
    depth = SCALE * float(view.depths(CORNERS[7:])[0])
    other = views[1]
    seen_by_other = 3200.0 * 0.1 * float(across @ (other.rotation[0] @ TURN.T))
    wanted = np.sqrt(
        (
            (3200.0 * 0.1 / depth) ** 2
            + (seen_by_other / (SCALE * other.depths(CORNERS[7:])[0])) ** 2
        )
        / 2
    )
    assert point["pixels"] == pytest.approx(wanted, rel=0.05)


# --- bad input ------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("text", "code"),
    [
        (pairs_text(CORNERS[:2], CORNERS[:2], HEADER), "registration.too-few-points"),
        (
            pairs_text(np.outer(range(5), [1, 2, 3]), np.outer(range(5), [2, 4, 6]), HEADER),
            "control.collinear",
        ),
    ],
)
def test_points_that_define_no_registration_are_refused(
    run, write: Write, text: str, code: str
) -> None:
    ran = run("register", "-", "--pairs", write(text), "--json")
    assert (ran.code, ran.json["error"]["code"]) == (2, code)


@pytest.mark.parametrize(
    ("text", "code", "line"),
    [
        ("label,x,y,z\nA,1,2,3\n", "table.missing-column", 1),
        (HEADER + "\nA,1,2,3,4,5,6\nA,2,3,4,5,6,7\n", "table.repeated-label", 3),
        (HEADER + "\nA,1,2,3,4,5,\n", "table.value-missing", 2),
        (HEADER + "\n", "table.no-rows", 1),
        (HEADER + ",use\nA,1,2,3,4,5,6,perhaps\n", "table.unknown-word", 2),
        (HEADER + ",sigma_x,sigma_y,sigma_z\nA,1,2,3,4,5,6,0,1,1\n", "table.not-positive", 2),
    ],
)
def test_table_errors_have_code_and_line(
    run, write: Write, text: str, code: str, line: int
) -> None:
    ran = run("register", "-", "--pairs", write(text), "--json")
    assert ran.code == 2
    assert (ran.json["error"]["code"], ran.json["error"]["line"]) == (code, line)


@pytest.mark.parametrize(
    ("words", "code"),
    [
        ((), "registration.no-observations"),
        (("--scale", "1,2,3"), "line.not-seven-numbers"),
        (("--scale", "0,0,0,1,0,0,-2"), "number.not-positive"),
        (("--scale", "0,0,0,0,0,0,2"), "line.one-place"),
        (("--bearing", "0,0,0,0,0,1,20"), "line.no-azimuth"),
        (("--cameras",), "option.needs-cameras"),
        (("--marks", "x.csv"), "option.requires"),
    ],
)
def test_option_errors_have_code_and_field(run, words: tuple[str, ...], code: str) -> None:
    ran = run("register", "-", *words, "--json")
    assert (ran.code, ran.json["error"]["code"]) == (2, code)
    if words:
        assert ran.json["error"]["field"] in (words[0], "MODEL")


# --- another model --------------------------------------------------------------------------------
def wall_and_copy(folder: Path) -> tuple[Path, Path, Array]:
    """A reference with a CRS, a model of it that stands 2 degrees and 0.3 m off, and where points
    of it belong."""
    from tests.registration.rock_faces import sampled
    from vomstudio.geometry.cloud import PointCloud
    from vomstudio.io.models.writing import write_model

    rng = np.random.default_rng(4)
    there = np.array([398_000.0, 4_980_000.0, 320.0])
    reference = sampled(6_000, rng, 0.01, 12.0) + there
    truth = sampled(5_000, rng, 0.01, 12.0) + there
    turn = Rotation.from_rotvec(np.radians(2.0) * np.array([0.6, 0.64, 0.48])).as_matrix()
    middle = there + [6.0, 0.0, 6.0]
    model = (truth - middle) @ turn.T + middle + [0.2, -0.15, 0.17]
    paths = folder / "reference.laz", folder / "model.laz"
    for path, points in zip(paths, (reference, model), strict=True):
        write_model(PointCloud(points), "EPSG:32633", path)
    return *paths, truth


def test_reference_surface_registers_model_with_error(run, tmp_path: Path) -> None:
    reference, model, truth = wall_and_copy(tmp_path)
    out = tmp_path / "placed.laz"
    ran = run("register", model, "--reference", reference, "-o", out, "--json")
    assert ran.code == 0, ran.err
    told = ran.json
    assert told["known"] == dict.fromkeys(("north", "vertical", "scale", "position"), True)
    assert told["rotation_error_95_deg"]["weakest"]["error_deg"] < 0.3
    assert told["reference"]["scale_fitted"] is False
    assert told["reference"]["overlap"] > 0.8
    assert told["scale"] == pytest.approx(1.0, abs=1e-9)
    placed = read_model(out)
    assert placed.crs == "EPSG:32633"
    assert placed.data.points == pytest.approx(truth, abs=0.05)
    ran = run("register", model, "--reference", reference)
    assert "reference.fitted" in shown_codes(ran.out)
    compared = run("compare", out, reference, "--json").json
    assert abs(compared["mean_m"]) < 0.01


@pytest.mark.full
def test_points_give_coarse_registration_refined_by_reference(
    run, write: Write, tmp_path: Path
) -> None:
    from vomstudio.geometry.cloud import PointCloud
    from vomstudio.io.models.writing import write_model

    reference, _, truth = wall_and_copy(tmp_path)
    own = (truth - truth.mean(axis=0)) @ TURN * 0.4
    model = tmp_path / "own.ply"
    write_model(PointCloud(own), None, model)
    picks = [10, 900, 2000, 3500]
    noisy = truth[picks] + np.random.default_rng(1).normal(0, 0.05, (4, 3))
    table = write(pairs_text(own[picks], noisy, HEADER))
    assert run("register", model, "--reference", reference).code == 2
    coarse = run("register", model, "--pairs", table, "--json").json
    told = run("register", model, "--reference", reference, "--pairs", table, "--json").json
    matrix = matrix_of(told)
    assert own @ matrix[:3, :3].T + matrix[:3, 3] == pytest.approx(truth, abs=0.05)
    assert told["scale"] == pytest.approx(2.5, rel=0.003)
    assert told["reference"]["scale_fitted"] is True
    assert len(told["control"]) == 4
    fine, rough = (t["rotation_error_95_deg"]["weakest"]["error_deg"] for t in (told, coarse))
    assert fine < 0.5 * rough


def test_two_points_complement_but_do_not_replace_reference(
    run, write: Write, tmp_path: Path
) -> None:
    """Two points alone leave a turn about their line; with the surfaces they are two more
    observations."""
    reference, model, truth = wall_and_copy(tmp_path)
    own = read_model(model).data.points
    table = write(pairs_text(own[[10, 900]], truth[[10, 900]], HEADER))
    assert run("register", model, "--pairs", table).code == 2
    told = run("register", model, "--reference", reference, "--pairs", table, "--json").json
    matrix = matrix_of(told)
    assert own @ matrix[:3, :3].T + matrix[:3, 3] == pytest.approx(truth, abs=0.05)
    assert len(told["control"]) == 2
    assert told["rms_control_m"] < 0.05


@pytest.mark.full
def test_mask_limits_the_part_of_reference_used(run, write: Write, tmp_path: Path) -> None:
    reference, model, truth = wall_and_copy(tmp_path)
    low, high = truth.min(axis=0), truth.max(axis=0)
    ring = [
        [low[0], low[1] - 1],
        [high[0] - 3, low[1] - 1],
        [high[0] - 3, high[1] + 1],
        [low[0], high[1] + 1],
        [low[0], low[1] - 1],
    ]
    layer = {
        "type": "FeatureCollection",
        "crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32633"}},
        "features": [
            {
                "type": "Feature",
                "properties": {},
                "geometry": {"type": "Polygon", "coordinates": [ring]},
            }
        ],
    }
    mask = write(json.dumps(layer), "stable.geojson")
    told = run("register", model, "--reference", reference, "--stable", mask, "--json").json
    assert told["reference"]["overlap"] < 0.85
    assert told["reference"]["stable_m"] is None
    cloud = write(
        "\n".join(f"{x} {y} {z}" for x, y, z in truth[truth[:, 0] < high[0] - 3]), "m.xyz"
    )
    told = run("register", model, "--reference", reference, "--stable", cloud, "--json").json
    assert told["reference"]["stable_m"] > 0.3
    assert run("register", model, "--pairs", mask, "--stable", mask).code == 2
    assert "--reference" in run("register", "-", "--scale", "0,0,0,1,0,0,5", "--stable", mask).said
    assert "MODEL" in run("register", "-", "--reference", reference).said


def test_project_model_is_registered_to_reference(run, tmp_path: Path) -> None:
    reference, model, truth = wall_and_copy(tmp_path)
    project = tmp_path / "wall.vom"
    import vomstudio as vs

    with vs.Project.create(project) as made:
        made.add_model(model)
        made.save()
    ran = run("project", project, "register", "--reference", reference, "--json")
    assert ran.code == 0, ran.err
    assert ran.json["turned_deg"] == pytest.approx(2.0, abs=0.1)
    assert ran.json["reference"]["overlap"] > 0.8
    with vs.Project.open(project) as again:
        (placed,) = again.models
        assert placed.crs == "EPSG:32633"
        assert placed.read().points == pytest.approx(truth, abs=0.05)
        record = again._open_project().find_model(None).registration
    assert record.method == "reference"
    assert record.name.endswith(f" {reference.name}")
    covariance = np.array(record.covariance)
    told = ran.json["rotation_error_deg"]
    assert np.degrees(np.sqrt(covariance[2, 2])) == pytest.approx(told["about_up"], rel=1e-6)
    assert run("project", project, "undo").code == 0
    with vs.Project.open(project) as again:
        assert again.models[0].read().points != pytest.approx(truth, abs=0.05)
    refused = run("project", project, "register", "--json").json["error"]
    assert refused["code"] == "registration.no-observations"


@pytest.mark.parametrize("places", ["0,0,0", "0,0,0\n1,0,0", "0,0,0\n1,0,0\n2,0,0\n3,0,0"])
def test_error_for_insufficient_pairs_names_the_file(run, tmp_path: Path, places: str) -> None:
    table = tmp_path / "pairs.csv"
    rows = [f"p{i},{place},{place}" for i, place in enumerate(places.splitlines())]
    table.write_text("\n".join(["label,model_x,model_y,model_z,x,y,z", *rows]))
    failed = run("register", "-", "--pairs", table, "--json")
    assert (failed.code, failed.json["error"]["file"]) == (2, str(table))


@pytest.mark.parametrize(
    ("label", "photo", "said"),
    first_in_default_tier(
        [("p{}", "{}", "p0 (P0?)"), ("P{}", "x/DSC{}", "DSC"), ("P 0{}", "{}", "P 00 (P0?)")]
    ),
)
def test_unmatched_marks_are_reported_as_the_cause(
    run, write: Write, stations, label: str, photo: str, said: str
) -> None:
    model, _, views = stations
    control, marks = marked_corners(write, views[:3], label, photo)
    ran = run("register", model, "--gcp", control, "--marks", write("\n".join(marks), "marks.csv"))
    assert ran.code == 2
    assert said in ran.err
    assert "registration.no-observations" not in shown_codes(ran.err)
