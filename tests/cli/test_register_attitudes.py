"""`vomstudio register` by how photos were held: drones, phones and tables with a known turn."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial.transform import Rotation

from tests.cli.test_register_cameras import VIEWS, degrees, off_deg, world
from tests.io.photos import camera_files as files
from tests.io.photos import photo_maker as maker
from tests.messages import codes, messages
from tests.registrations import TURN
from vomstudio.geometry.cameras import View

Array = npt.NDArray[np.float64]
Write = Callable[..., Path]

ALL = {"north": True, "vertical": True, "scale": False, "position": False}


def there(view: View) -> Array:
    """Columns right, down, forward of a camera in World."""
    return TURN @ view.rotation.T


def gimbal(view: View) -> tuple[float, float, float]:
    """Yaw, pitch, roll as DJI writes them: turns about down, right and ahead."""
    right, down, forward = there(view).T
    ned = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    body = ned @ np.column_stack([forward, right, down])
    yaw, pitch, roll = Rotation.from_matrix(body).as_euler("ZYX", degrees=True)
    return float(yaw), float(pitch), float(roll)


def azimuth(view: View) -> float:
    east, north, _ = there(view)[:, 2]
    return float(np.degrees(np.arctan2(east, north)) % 360.0)


def portrait(view: View) -> View:
    """The same view by a camera whose right side was lowered by a quarter turn."""
    quarter = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    return View(view.name, view.intrinsics, quarter @ view.rotation, quarter @ view.translation)


@pytest.fixture
def model(tmp_path: Path) -> Path:
    folder = tmp_path / "model"
    folder.mkdir()
    return with_cameras(folder, VIEWS)


def with_cameras(folder: Path, views: Sequence[View]) -> Path:
    files.colmap_text(folder / "sparse" / "0", views)
    path = folder / "model.xyz"
    path.write_text("-5 -4 -3\n5 4 3\n5 -4 3\n-5 4 -3\n")
    return path


def drones(folder: Path, views: Sequence[View], turn: float = 0.0, **gps: bool) -> Path:
    for number, view in enumerate(views):
        yaw, pitch, roll = gimbal(view)
        xmp = maker.drone_xmp(
            GimbalYawDegree=f"{yaw + turn:+.6f}",
            GimbalPitchDegree=f"{pitch:+.6f}",
            GimbalRollDegree=f"{roll:+.6f}",
        )
        maker.write_photo(
            folder / view.name, seed=number, xmp=xmp, gps=located(view) if gps else {}
        )
    return folder


def located(view: View) -> maker.Fields:
    longitude, latitude, z = degrees(world(view.centre[None]))[0]
    return maker.at(latitude, longitude, z)


def phones(
    folder: Path,
    views: Sequence[View],
    off: float = 0.0,
    north: str | None = None,
    orientation: int = 1,
) -> Path:
    """Vertical by the accelerometer; the direction of the view where a north is given."""
    for number, view in enumerate(views):
        right, down, ahead = -there(view)[2]
        gps = {**located(view)}
        if north is not None:
            gps |= maker.looking((azimuth(view) + off) % 360.0, north)
        maker.write_photo(
            folder / view.name,
            (160, 120),
            seed=number,
            main={0x010F: maker.text("Apple"), 0x0112: maker.short(orientation)},
            exif={
                0x927C: maker.apple_note(-down, -right, -ahead),
                0x9003: maker.text("2024:05:12 10:00:00"),
            },
            gps=gps,
        )
    return folder


def up_of(told: dict) -> Array:
    """World's up in the frame of the model."""
    return np.array(told["matrix"])[:3, :3][2] / told["scale"]


# --- drones ---------------------------------------------------------------------------------------
def test_gimbal_angles_rotate_the_model(run, model: Path) -> None:
    folder = drones(model.parent / "photos", VIEWS)
    told = run("register", model, "--attitudes", "--json").json
    assert off_deg(told) < 1e-4
    assert told["known"] == ALL
    # Yaw rests on a compass, which may be wrong for all photos alike; the vertical does not.
    errors = told["rotation_error_95_deg"]
    assert errors["about_up"] == pytest.approx(19.6, abs=0.2)
    assert errors["about_east"] < 0.1
    assert "attitude.from-drone" in codes(told)
    sure = run("register", model, "--attitudes", folder, "--north-sigma", "2", "--json").json
    assert sure["rotation_error_95_deg"]["about_up"] == pytest.approx(3.92, abs=0.1)


def test_unmeasured_gimbal_angles_are_reported_and_not_used(run, model: Path) -> None:
    folder = model.parent / "photos"
    zero = maker.drone_xmp(
        GimbalYawDegree="+0.00", GimbalPitchDegree="+0.00", GimbalRollDegree="+0.00"
    )
    for number, view in enumerate(VIEWS):
        maker.write_photo(folder / view.name, seed=number, xmp=zero, gps=located(view))
    positions = ["register", model, "--cameras", folder, "--crs", "EPSG:32633", "--json"]
    told = run(*positions, "--attitudes", folder).json
    assert "photo.angles-not-measured" in codes(told)
    alone = run(*positions).json
    assert "photo.angles-not-measured" not in codes(alone)
    assert told["matrix"] == alone["matrix"]
    assert "attitudes" not in told
    refused = run("register", model, "--attitudes", folder, "--json")
    assert (refused.code, refused.json["error"]["code"]) == (2, "photo.angles-not-measured")


def test_zero_angles_in_geo_file_are_ignored(run, model: Path) -> None:
    rows = [f"{v.name} {' '.join(map(str, world(v.centre[None])[0]))} 0 0 0" for v in VIEWS]
    geo = model.parent / "geo.txt"
    geo.write_text("\n".join(["EPSG:32633", *rows]))
    told = run("register", model, "--cameras", geo, "--attitudes", geo, "--json").json
    assert "photo.angles-not-measured" in codes(told)
    assert off_deg(told) < 1e-4


def test_angles_in_exif_comment_rotate_the_model(run, model: Path) -> None:
    folder = model.parent / "photos"
    for number, view in enumerate(VIEWS):
        yaw, pitch, roll = gimbal(view)
        text = f"ASCII\0\0\0Roll {roll:.6f} Pitch {pitch:.6f} Yaw {yaw:.6f}".encode()
        maker.write_photo(folder / view.name, seed=number, exif={0x9286: (7, len(text), text)})
    told = run("register", model, "--attitudes", folder, "--json").json
    assert off_deg(told) < 1e-4
    assert "photo.angles-in-comment" in codes(told)


def test_altitude_of_xmp_is_used_if_exif_sign_contradicts(run, model: Path) -> None:
    """EXIF writes "below sea level" for heights above it."""
    folder = model.parent / "photos"
    for number, view in enumerate(VIEWS):
        longitude, latitude, z = degrees(world(view.centre[None]))[0]
        maker.write_photo(
            folder / view.name,
            seed=number,
            gps=maker.at(latitude, longitude, z, 1),
            xmp=maker.drone_xmp(AbsoluteAltitude=f"{z:+.3f}"),
        )
    told = run("register", model, "--cameras", folder, "--crs", "EPSG:32633", "--json").json
    assert "photo.altitude-sign" in codes(told)
    assert told["matrix"][2][3] == pytest.approx(320.0, abs=0.5)


def test_true_north_is_converted_to_grid_north(run, model: Path) -> None:
    """The convergence of a Mercator map is nearly (longitude - middle) sin(latitude)."""
    longitude, latitude, _ = degrees(world(np.zeros((1, 3))))[0]
    convergence = (longitude - 15.0) * np.sin(np.radians(latitude))
    drones(model.parent / "photos", VIEWS, convergence, gps=True)
    told = run("register", model, "--attitudes", "--crs", "EPSG:32633", "--json").json
    assert off_deg(told) < 0.01
    assert any(f"{-convergence:+.1f}°" in said for said in messages(told))


def test_photos_with_unstated_portrait_orientation_are_reported(run, model: Path) -> None:
    """A camera that was held upright and says nothing of it."""
    odd = [portrait(v) if number in (2, 5) else v for number, v in enumerate(VIEWS)]
    with_cameras(model.parent, odd)
    rows = ["photo,yaw,pitch,roll"]
    rows += [f"{v.name},{','.join(f'{a:.6f}' for a in gimbal(v))}" for v in VIEWS]
    table = model.parent / "table.csv"
    table.write_text("\n".join(rows))
    told = run("register", model, "--attitudes", table, "--json").json
    (said,) = [s for s in messages(told) if "left out" in s]
    assert "IMG_02.jpg, IMG_05.jpg" in said
    assert "portrait" in said
    assert off_deg(told) < 1e-4


# --- phones ---------------------------------------------------------------------------------------
@pytest.mark.parametrize("upright", [False, True])
def test_phones_without_compass_give_only_the_vertical(run, model: Path, upright: bool) -> None:
    views = [portrait(v) for v in VIEWS] if upright else VIEWS
    with_cameras(model.parent, views)
    folder = phones(model.parent / "photos", views, orientation=6 if upright else 1)
    told = run("register", model, "--attitudes", folder, "--json").json
    assert told["known"] == {**ALL, "north": False}
    np.testing.assert_allclose(up_of(told), TURN[2], atol=1e-5)
    assert [p["photo"] for p in told["attitudes"]] == [v.name for v in VIEWS]
    assert all(p["yaw_deg"] is None and abs(p["roll_deg"]) < 0.01 for p in told["attitudes"])


def test_phone_photos_rotated_upright_by_a_program_give_the_vertical(run, model: Path) -> None:
    """It saw them wider than high; the phone stored them as its sensor lies, on its side."""
    stored = [portrait(v) for v in VIEWS]
    lens = files.LENS
    folder = phones(model.parent / "photos", stored, orientation=6)
    for path in folder.iterdir():
        path.unlink()
    tall = [
        View(
            v.name,
            type(lens).pinhole(3000, 4000, 3200.0, 1500.0, 2000.0),
            v.rotation,
            v.translation,
        )
        for v in VIEWS
    ]
    text = files.colmap_text(model.parent / "sparse" / "0", tall)
    (text / "cameras.txt").write_text("1 SIMPLE_PINHOLE 3000 4000 3200 1500 2000\n")
    phones(model.parent / "photos", stored, orientation=6)
    told = run("register", model, "--attitudes", folder, "--json").json
    np.testing.assert_allclose(up_of(told), TURN[2], atol=1e-5)


def test_phone_headings_are_corrected_for_declination(run, model: Path) -> None:
    """Of the day and place of each photo; the declination itself has tests of its own."""
    from datetime import date

    from pyproj import Proj

    from vomstudio.registration.north import declination_deg

    longitude, latitude, _ = degrees(world(np.zeros((1, 3))))[0]
    convergence = Proj("EPSG:32633").get_factors(longitude, latitude).meridian_convergence
    declination = declination_deg(longitude, latitude, date(2024, 5, 12))
    assert 3.0 < declination < 6.0
    folder = phones(model.parent / "photos", VIEWS, convergence - declination, "M")
    told = run("register", model, "--attitudes", folder, "--crs", "EPSG:32633", "--json").json
    assert told["known"] == ALL
    assert off_deg(told) < 0.01
    np.testing.assert_allclose(up_of(told), TURN[2], atol=1e-5)
    assert 19.0 < told["rotation_error_95_deg"]["about_up"] < 25.0
    assert told["rotation_error_95_deg"]["about_east"] < 0.5
    given = run(
        "register",
        model,
        "--attitudes",
        folder,
        "--crs",
        "EPSG:32633",
        "--declination",
        declination + 1.0,
        "--json",
    ).json
    assert off_deg(given) == pytest.approx(1.0, abs=0.01)


def test_systematic_compass_error_is_detected_from_camera_positions(
    run, write: Write, model: Path
) -> None:
    folder = phones(model.parent / "photos", VIEWS, 15.0, "T")
    rows = ["photo,x,y,z"]
    rows += [f"{v.name},{','.join(f'{c:.4f}' for c in world(v.centre))}" for v in VIEWS]
    told = run(
        "register", model, "--attitudes", folder, "--cameras", write("\n".join(rows)), "--json"
    ).json
    assert off_deg(told) < 0.1
    (turn,) = (w for w in told["warnings"] if w["code"] == "registration.north-turned")
    assert turn["turn_deg"] == pytest.approx(15.0, abs=0.1)
    phones(folder, VIEWS, 90.0, "T")
    told = run(
        "register", model, "--attitudes", folder, "--cameras", write("\n".join(rows)), "--json"
    ).json
    assert [p["yaw_deg"] for p in told["attitudes"]] == pytest.approx([-90.0] * 9, abs=0.1)
    for photo in told["attitudes"]:
        assert (photo["pitch_deg"], photo["roll_deg"]) == pytest.approx((0, 0), abs=0.1)
    (turn,) = (w for w in told["warnings"] if w["code"] == "registration.north-quarter-turn")
    assert turn["correction_deg"] == -90.0


def test_single_wrong_compass_reading_is_left_out(run, model: Path) -> None:
    rng = np.random.default_rng(0)
    folder = model.parent / "photos"
    for number, view in enumerate(VIEWS):
        phones(folder, [view], 40.0 if number == 3 else float(rng.normal() * 2.0), "T")
    told = run("register", model, "--attitudes", folder, "--json").json
    (yaws,) = (w for w in told["warnings"] if w["code"] == "attitude.yaw-left-out")
    assert (yaws["photos"], yaws["off_deg"]) == (["IMG_03.jpg"], 40)
    assert off_deg(told) < 3.0


def test_single_wrong_vertical_is_reported_with_its_size(run, model: Path) -> None:
    """By less than is left out; what all photos share takes nothing from it."""
    rng = np.random.default_rng(1)
    shaken = []
    for number, view in enumerate(VIEWS):
        turn = Rotation.from_rotvec(np.radians(0.2) * rng.normal(size=3)).as_matrix()
        if number == 6:
            turn = Rotation.from_euler("z", 9.0, degrees=True).as_matrix()
        shaken.append(View(view.name, view.intrinsics, turn @ view.rotation, view.translation))
    folder = phones(model.parent / "photos", shaken)
    told = run("register", model, "--attitudes", folder, "--json").json
    (blunder,) = told["blunders"]
    assert blunder["label"] == "IMG_06.jpg"
    # The phone was rolled about its view, which looks down.
    fell, falls = -there(shaken[6])[2], -there(VIEWS[6])[2]
    off = np.degrees(np.arccos(fell @ falls))
    assert 5.0 < off < 9.0
    assert blunder["error_deg"] == pytest.approx(off, abs=0.3)


def test_rotated_photo_is_detected_from_its_vertical(run, model: Path) -> None:
    """A program turned it upright, and nothing in the photo says so."""
    odd = [portrait(v) if number == 4 else v for number, v in enumerate(VIEWS)]
    folder = phones(model.parent / "photos", odd)
    told = run("register", model, "--attitudes", folder, "--json").json
    named = {w["code"]: w for w in told["warnings"]}
    assert named["attitude.verticals-left-out"]["photos"] == ["IMG_04.jpg"]
    assert named["attitude.verticals-turned"]["turns_deg"] == [90]
    np.testing.assert_allclose(up_of(told), TURN[2], atol=1e-5)
    phones(folder, [portrait(v) for v in VIEWS])
    told = run("register", model, "--attitudes", folder, "--json").json
    assert "attitude.turned-photos" in codes(told)


# --- tables ---------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("head", "form"),
    [
        ("filename,azimuth,pitch,roll", "{n},{y},{p},{r}"),
        ("SourceFile,GimbalYawDegree,GimbalPitchDegree,GimbalRollDegree", "a/{n},{y},{p},{r}"),
        ("image;heading (true);pitch;bank", "{n};{y};{p};{r}"),
        ("#Label\tYaw\tPitch\tRoll", "{n}\t{y}\t{p}\t{r}"),
    ],
)
def test_attitude_tables_of_other_programs_are_read(
    run, write: Write, model: Path, head: str, form: str
) -> None:
    rows = [head]
    for view in VIEWS:
        y, p, r = (f"{a:.6f}" for a in gimbal(view))
        row = form.format(n=view.name, y=y, p=p, r=r)
        rows.append(row.replace(".", ",").replace(",jpg", ".jpg") if ";" in form else row)
    told = run("register", model, "--attitudes", write("\n".join(rows)), "--json").json
    assert off_deg(told) < 1e-4
    assert told["known"] == ALL


def test_geo_txt_angles_are_read_as_aircraft_angles(run, write: Write, model: Path) -> None:
    """By the matrices of Pix4D's convention: a camera that looks down has pitch 0."""
    ned = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    rows = ["EPSG:32633"]
    for view in VIEWS:
        right, down, forward = there(view).T
        body = ned @ np.column_stack([-down, right, forward])
        yaw, pitch, roll = Rotation.from_matrix(body).as_euler("ZYX", degrees=True)
        x, y, z = world(view.centre)
        rows.append(f"{view.name} {x} {y} {z} {yaw} {pitch} {roll} 0.5 1")
    table = write("\n".join(rows), "geo.txt")
    told = run("register", model, "--attitudes", table, "--json").json
    assert off_deg(told) < 1e-4
    assert any("OpenDroneMap" in said for said in messages(told))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda y, p, r: (y, p + 90, r), "subtracted from pitch"),
        (lambda y, p, r: (y, -p, r), "positive downwards"),
        (lambda y, p, r: (-y, p, r), "counterclockwise"),
        (lambda y, p, r: (y, p, r + 90 if r < 90 else r - 270), "subtracted from roll"),
        (lambda y, p, r: (y, p, r + 180 if r < 0 else r - 180), "upside down"),
    ],
)
def test_angles_in_other_conventions_are_reported(
    run, write: Write, model: Path, change, said: str
) -> None:
    rows = ["photo,yaw,pitch,roll"]
    for view in VIEWS:
        rows.append(f"{view.name},{','.join(f'{a:.6f}' for a in change(*gimbal(view)))}")
    told = run("register", model, "--attitudes", write("\n".join(rows)), "--json")
    if told.code:
        assert "subtract 90" in told.said
    else:
        assert any(said in each for each in messages(told.json))


@pytest.mark.parametrize(
    ("text", "line", "code"),
    [
        ("photo,yaw,pitch\nIMG_00.jpg,1,2\n", 1, "table.missing-column"),
        ("photo,yaw,pitch,roll\nIMG_00.jpg,1,120,0\n", 2, "cameras.pitch-from-nadir"),
        (
            "photo,yaw,pitch,roll\nIMG_00.jpg,1,2,3\nIMG_00.jpg,1,2,3\n",
            3,
            "table.repeated-label",
        ),
        ("photo,yaw,pitch,roll\nIMG_00.jpg,500,2,3\n", 2, "angle.out-of-range"),
        ("photo,yaw,pitch,roll,north\nIMG_00.jpg,5,2,3,south\n", 2, "table.unknown-word"),
        (
            "photo;yaw;pitch;roll\nIMG_00.jpg;5,1;2.0;3,0\nA;5.1;2,0;1\n",
            3,
            "table.mixed-decimals",
        ),
    ],
)
def test_attitude_table_errors_have_code_and_line(
    run, write: Write, model: Path, text: str, line: int, code: str
) -> None:
    ran = run("register", model, "--attitudes", write(text), "--json")
    assert ran.code == 2
    assert (ran.json["error"]["code"], ran.json["error"]["line"]) == (code, line)


def test_photos_without_angles_are_refused(run, model: Path) -> None:
    ran = run("register", model, "--attitudes")
    assert ran.code == 2
    assert "was found" in ran.said
    for number, view in enumerate(VIEWS):
        maker.write_photo(model.parent / "photos" / view.name, seed=number)
    ran = run("register", model, "--attitudes")
    assert ran.code == 2
    assert "gimbal" in ran.said


# --- azimuths by compass --------------------------------------------------------------------------
def test_azimuths_by_compass_need_a_declination(run) -> None:
    line = ("--bearing", "0,0,0,0,1,0,30")
    ran = run("register", "-", *line, "--north", "magnetic", "--json")
    assert (ran.code, ran.json["error"]["code"]) == (2, "north.no-declination")
    told = run("register", "-", *line, "--north", "magnetic", "--declination", "-7.5", "--json")
    turn = np.array(told.json["matrix"])[:3, :3]
    a = np.radians(22.5)
    np.testing.assert_allclose(turn @ [0, 1, 0], [np.sin(a), np.cos(a), 0], atol=1e-9)
    for bad in (("--declination", "east"), ("--date", "May"), ("--north-sigma", "-1")):
        assert run("register", "-", *line, *bad).code == 2


def test_declination_is_computed_from_date_and_position(run, write: Write) -> None:
    """Places come from the points, the azimuth adds nothing but its own sentence."""
    from datetime import date

    from vomstudio.registration.north import declination_deg

    corners = np.array([[0, 0, 0], [9, 0, 0], [0, 4, 1], [3, 2, 5], [5, 1, 0.5]], float)
    rows = ["label,model_x,model_y,model_z,x,y,z"]
    for number, corner in enumerate(corners):
        rows.append(f"P{number}," + ",".join(f"{v:.6f}" for v in (*corner, *world(corner))))
    east, north, _ = TURN[:, 0]
    longitude, latitude, _ = degrees(world(np.zeros((1, 3))))[0]
    convergence = (longitude - 15.0) * np.sin(np.radians(latitude))
    grid = np.degrees(np.arctan2(east, north))
    declination = declination_deg(longitude, latitude, date(2024, 5, 12))
    read = (grid - declination + convergence) % 360.0
    words = (
        "register",
        "-",
        "--pairs",
        write("\n".join(rows)),
        "--north",
        "magnetic",
        "--date",
        "2024-05-12",
        "--bearing",
        f"0,0,0,1,0,0,{read}",
    )
    told = run(*words, "--crs", "EPSG:32633", "--json").json
    # It agrees with the points to some thousandths of a degree.
    assert off_deg(told) < 0.01
    added = {each["code"]: each.get("correction_deg") for each in told["warnings"]}
    expected = pytest.approx(declination - convergence, abs=0.01)
    assert added["north.magnetic-corrected"] == expected
    assert not told["blunders"]
    # Without a CRS nobody knows where that is.
    assert run(*words, "--json").json["error"]["code"] == "north.no-declination"


def test_magnetic_table_without_date_is_not_corrected_with_warning(
    run, write: Write, model: Path
) -> None:
    rows = ["photo,yaw,pitch,roll,north"]
    for view in VIEWS:
        rows.append(f"{view.name},{','.join(f'{a:.6f}' for a in gimbal(view))},magnetic")
    table = write("\n".join(rows))
    told = run("register", model, "--attitudes", table, "--json").json
    assert off_deg(told) < 1e-4
    assert "north.not-corrected" in codes(told)
    corrected = run("register", model, "--attitudes", table, "--declination", "5", "--json").json
    assert off_deg(corrected) == pytest.approx(5.0, abs=1e-3)
