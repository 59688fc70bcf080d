"""`vomstudio register` of models whose cameras other programs wrote: a known move comes back."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial.transform import Rotation

from tests.io.photos import camera_files as files

Array = npt.NDArray[np.float64]
Write = Callable[..., Path]

VIEWS = files.ring()
TURN = Rotation.from_euler("zyx", [130.0, 12.0, -7.0], degrees=True).as_matrix()
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
def test_positions_place_a_model_of_any_program(run, write: Write, model: Path, kind) -> None:
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


def test_centres_alone_take_no_attitudes(run, write: Write, model: Path) -> None:
    path = reference(model.parent)
    table = write("photo,yaw,pitch,roll\nIMG_01.jpg,10,0,0\n")
    ran = run("register", model, "--attitudes", table, "--model-cameras", path)
    assert ran.code == 2
    assert "centres alone" in ran.said


def test_photos_of_other_names_are_said(run, write: Write, model: Path) -> None:
    colmap(model.parent)
    ran = run("register", model, "--cameras", write("photo,x,y,z\nDSC1.jpg,1,2,3\n"))
    assert ran.code == 2
    assert "DSC1.jpg" in ran.said
    assert "IMG_00.jpg" in ran.said
