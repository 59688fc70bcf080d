"""`vomstudio register --plumb`, and the common offset of readings by compass."""

from __future__ import annotations

import numpy as np
import pytest

import vomstudio as vs
from tests.cli.test_register import CORNERS, turn_of, world
from tests.registrations import TURN

UP = TURN.T @ [0.0, 0.0, 1.0]
START = np.array([1.0, 2.0, 0.5])
PLUMB = [*START, *(START - 3.0 * UP)]


def text(values: list[float]) -> str:
    return ",".join(f"{value:.9f}" for value in values)


def azimuth(degrees: float) -> str:
    a = np.radians(degrees)
    return text([*START, *(START + 4.0 * TURN.T @ [np.sin(a), np.cos(a), 0.0]), degrees])


def codes(ran) -> set[str]:
    return {each["code"] for each in ran.json["warnings"]}


def test_plumb_line_levels_model_by_command_and_python(run) -> None:
    ran = run("register", "-", "--plumb", text(PLUMB), "--json")
    assert ran.code == 0, ran.err
    assert turn_of(ran.json) @ UP == pytest.approx([0.0, 0.0, 1.0], abs=1e-6)
    assert ran.json["known"] == {
        "north": False,
        "vertical": True,
        "scale": False,
        "position": False,
    }
    with pytest.warns(vs.errors.VomWarning):
        placed = vs.register("-", plumb=PLUMB)
    assert placed.matrix == pytest.approx(np.array(ran.json["matrix"]), abs=1e-8)
    with pytest.warns(vs.errors.VomWarning):
        worse = vs.register("-", plumb=[[*PLUMB, 2.0]])
    assert worse.rotation_error_deg.about_east == pytest.approx(2.0, rel=1e-3)


@pytest.mark.parametrize("wrong", ["1,2,3,4,5", "1,2,3,1,2,3", "1,2,3,4,5,6,0", "1,2,3,4,5,6,46"])
def test_invalid_plumb_line_is_refused(run, wrong: str) -> None:
    ran = run("register", "-", "--plumb", wrong)
    assert ran.code == 2
    assert "--plumb" in ran.err


# --- the common offset ----------------------------------------------------------------------------
READ = ("register", "-", "--plumb", text(PLUMB), "--bearing", azimuth(40.0), "--json")


def test_magnetic_readings_share_default_north_error(run) -> None:
    ran = run(*READ, "--north", "magnetic", "--declination", "4")
    assert ran.json["north_sigma_deg"] == 2.0
    error = ran.json["rotation_error_deg"]["about_up"]
    # 3 degrees of the reading itself.
    assert error == pytest.approx(np.hypot(3.0, 2.0), rel=1e-3)
    assert "registration.compass-alone" in codes(ran)


def test_compass_only_registration_warns_unless_north_error_is_stated(run) -> None:
    grid = run(*READ)
    assert grid.json["north_sigma_deg"] == 0.0
    assert "registration.compass-alone" in codes(grid)
    for stated in ("0", "1.5"):
        ran = run(*READ, "--north", "magnetic", "--declination", "4", "--north-sigma", stated)
        assert ran.json["north_sigma_deg"] == float(stated)
        assert "registration.compass-alone" not in codes(ran)
    level = run("register", "-", "--plumb", text(PLUMB), "--json")
    assert level.json["north_sigma_deg"] is None
    assert "registration.compass-alone" not in codes(level)


def test_points_with_compass_give_no_compass_only_warning(run, tmp_path) -> None:
    table = tmp_path / "pairs.csv"
    rows = zip(CORNERS.tolist(), world(CORNERS).tolist(), strict=True)
    table.write_text(
        "label,model_x,model_y,model_z,x,y,z\n"
        + "\n".join(f"P{i}," + ",".join(map(repr, [*m, *w])) for i, (m, w) in enumerate(rows))
    )
    ran = run("register", "-", "--pairs", table, "--bearing", azimuth(40.0), "--json")
    assert ran.code == 0, ran.err
    assert "registration.compass-alone" not in codes(ran)


# --- the upright of photos ------------------------------------------------------------------------
@pytest.mark.parametrize("scaled", [False, True])
def test_unpositioned_photo_model_keeps_orientation_of_photos(run, tmp_path, scaled: bool) -> None:
    from vomstudio.geometry.cameras import Intrinsics, View
    from vomstudio.geometry.mesh import Mesh
    from vomstudio.io.models.writing import write_model
    from vomstudio.io.photos.cameras_file import Cameras, write_cameras

    model = tmp_path / "model.ply"
    write_model(Mesh(CORNERS, np.array([[0, 1, 2], [0, 1, 3]], np.int32)), None, model)
    view = View("a.jpg", Intrinsics.pinhole(40, 30, 30.0, 20.0, 15.0), np.eye(3), np.zeros(3))
    write_cameras(tmp_path / "cameras.json", Cameras((view,), tmp_path, is_scaled=scaled))
    lines = []
    for degrees, plunge in ((10.0, 0.0), (12.0, 1.0)):
        a, p = np.radians([degrees, plunge])
        along = np.array([np.sin(a) * np.cos(p), np.cos(a) * np.cos(p), -np.sin(p)])
        lines += ["--level", text([*START, *(START + 4.0 * along)])]
    ran = run("register", model, *lines, "--json")
    assert ran.code == 0, ran.err
    assert {"registration.parallel-level-lines"} <= codes(ran)
    assert ("registration.photo-upright" in codes(ran)) != scaled
    assert ("registration.poor" in codes(ran)) != scaled
    assert np.degrees(np.arccos(turn_of(ran.json)[2, 2])) < 1.0
    assert not ran.json["known"]["vertical"]
