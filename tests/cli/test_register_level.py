"""`vomstudio register --level`: horizontal lines on the outcrop level its model."""

from __future__ import annotations

import numpy as np
import pytest

import vomstudio as vs
from tests.cli.conftest import Run
from tests.cli.test_register import CORNERS, SCALE, turn_of, world
from tests.messages import error_of, refused
from tests.registrations import TURN
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.models.writing import write_model

UP = TURN.T @ [0.0, 0.0, 1.0]


def level_line(azimuth_deg: float, sigma: str = "") -> str:
    """Two places on the model, 4 units apart, that are at one height in World."""
    a = np.radians(azimuth_deg)
    along = TURN.T @ [np.sin(a), np.cos(a), 0.0]
    start = np.array([1.0, 2.0, 0.5])
    return ",".join(f"{v:.9f}" for v in (*start, *(start + 4.0 * along))) + sigma


def test_two_level_lines_determine_only_the_vertical(run) -> None:
    lines = [level_line(10.0), level_line(100.0)]
    ran = run("register", "-", "--level", lines[0], "--level", lines[1], "--json")
    assert ran.code == 0, ran.err
    told = ran.json
    assert turn_of(told) @ UP == pytest.approx([0.0, 0.0, 1.0], abs=1e-6)
    assert told["known"] == {
        "north": False,
        "vertical": True,
        "scale": False,
        "position": False,
    }
    # Half a degree (1 sigma) of each line is the error about the other.
    errors = told["rotation_error_deg"]
    assert errors["about_up"] is None
    assert np.hypot(errors["about_east"], errors["about_north"]) == pytest.approx(
        np.sqrt(0.5), rel=0.02
    )


def test_one_level_line_leaves_tilt_about_it_undetermined(run) -> None:
    ran = run("register", "-", "--level", level_line(10.0), "--json")
    assert ran.code == 0, ran.err
    assert ran.json["known"]["vertical"] is False


def test_level_line_error_can_be_stated_and_combined_with_scale(run) -> None:
    given = [level_line(10.0, ",2"), level_line(100.0, ",2")]
    options = [word for text in given for word in ("--level", text)]
    ends = ",".join(f"{v:.9f}" for v in (*CORNERS[0], *CORNERS[1]))
    length = float(np.linalg.norm(world(CORNERS[1]) - world(CORNERS[0])))
    told = run("register", "-", *options, "--scale", f"{ends},{length}", "--json").json
    assert told["known"]["scale"] is True
    assert told["scale"] == pytest.approx(SCALE, rel=1e-6)
    errors = told["rotation_error_deg"]
    assert np.hypot(errors["about_east"], errors["about_north"]) == pytest.approx(
        np.sqrt(8.0), rel=0.02
    )


@pytest.mark.parametrize(
    ("text", "code", "values"),
    [
        ("1,2,3,4,5", "line.not-six-numbers", {"text": "1,2,3,4,5"}),
        ("1,2,3,4,5,nan", "line.not-six-numbers", {"text": "1,2,3,4,5,nan"}),
        ("1,2,3,1,2,3", "line.one-place", {}),
        ("1,2,3,4,5,6,0", "number.not-positive", {"value": 0}),
        ("1,2,3,4,5,6,46", "option.out-of-range", {"value": 46, "minimum": 0, "maximum": 45}),
        ("1,2,3,4,5,6,1e-200", "accuracy.out-of-range", {"value": 1e-200}),
    ],
)
def test_invalid_level_line_is_refused(
    run: Run, text: str, code: str, values: dict[str, object]
) -> None:
    ran = run("register", "-", "--level", text, "--json")
    assert ran.code == 2
    error_of(ran.json, code, field="--level", **values)


@pytest.mark.full
def test_true_vertical_lies_within_stated_error_of_level_lines() -> None:
    """Of 400 models by 3 to 6 lines of half a degree: 95 % for each axis."""
    from scipy.spatial.transform import Rotation

    from vomstudio.registration.evidence import Evidence, register
    from vomstudio.registration.level_evidence import KnownDirection

    rng = np.random.default_rng(8)
    inside = []
    for _ in range(400):
        lines = []
        for _ in range(int(rng.integers(3, 7))):
            a, tilt = rng.uniform(0, 2 * np.pi), np.radians(rng.normal(0.0, 0.5))
            along = [np.sin(a) * np.cos(tilt), np.cos(a) * np.cos(tilt), np.sin(tilt)]
            end = TURN.T @ np.array(along)
            ends = float(end[0]), float(end[1]), float(end[2])
            lines.append(KnownDirection((0.0, 0.0, 0.0), ends))
        found = register(Evidence(level_lines=lines))
        error = found.rotation_error_95_deg
        if error.about_east is None or error.about_north is None:
            continue
        up = np.array(found.matrix)[:3, :3] / found.scale @ UP
        # What is level leans by the turn across it.
        turn, _ = Rotation.align_vectors([[0.0, 0.0, 1.0]], [up])
        east, north, _ = np.degrees(turn.as_rotvec())
        inside.append([abs(east) <= error.about_east, abs(north) <= error.about_north])
    assert len(inside) > 350
    share = np.mean(inside, axis=0)
    assert ((share > 0.92) & (share < 0.98)).all()


def test_python_function_registers_model_file(tmp_path) -> None:
    path = tmp_path / "cliff.ply"
    write_model(Mesh(CORNERS, np.array([[0, 1, 2], [0, 1, 3]], np.int32)), None, path)
    table = tmp_path / "cameras.csv"
    centres = CORNERS * 1.3 + [0.0, -9.0, 4.0]
    names = [f"p{i}.jpg" for i in range(len(centres))]

    def text(places: np.ndarray) -> str:
        rows = (f"{n},{x:.4f},{y:.4f},{z:.4f}" for n, (x, y, z) in zip(names, places, strict=True))
        return "\n".join(["photo,x,y,z", *rows])

    table.write_text(text(centres))
    given = tmp_path / "gps.csv"
    given.write_text(text(world(centres)))
    with pytest.warns(vs.errors.VomWarning):
        found = vs.register(path, cameras=given, model_cameras=table, crs="EPSG:32633")
    assert found.scale == pytest.approx(SCALE, rel=1e-5)
    assert found(CORNERS) == pytest.approx(world(CORNERS), abs=0.01)
    lines = [[float(v) for v in level_line(az).split(",")] for az in (10.0, 100.0)]
    with pytest.warns(vs.errors.VomWarning):
        level = vs.register("-", level=lines)
    assert level.known.vertical
    with refused("file.number-count", count=2, needed=(6, 7), field="level"):
        vs.register("-", level=[[1.0, 2.0]])
    with refused("argument.requires-type", option="cameras", argument="model_points"):
        vs.register(CORNERS, world(CORNERS), cameras=given)
    with pytest.raises(vs.errors.UsageError):
        vs.register(path)
