"""Scans of PTX files are read in their poses."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.messages import by_code, refused
from vomstudio.core.progress import SilentProgress
from vomstudio.io.models.formats import ptx
from vomstudio.io.models.opening import read_model

WORLD = np.array([[10.0, 20.0, 3.0], [11.0, 20.0, 3.5], [11.0, 22.0, 2.0]])


def scan(rotation: np.ndarray, place: np.ndarray, colors: str = "", gap: bool = True) -> str:
    """A scan of the points from a place, with one beam that did not return."""
    local = (WORLD - place) @ rotation
    rows = [*(f"{x!r} {y!r} {z!r} 0.25{colors}" for x, y, z in local.tolist())]
    if gap:
        rows.insert(1, f"0 0 0 0.5{colors and ' 0 0 0'}")
    text = " ".join
    axes = [text(map(repr, row)) for row in rotation.T.tolist()]
    matrix = [f"{axis} 0" for axis in axes]
    matrix.append(text(map(repr, [*place.tolist(), 1])))
    head = [str(len(rows)), "1", text(map(repr, place.tolist())), *axes, *matrix]
    return "\n".join([*head, *rows]) + "\n"


TURNS = [
    Rotation.from_euler("zyx", angles, degrees=True).as_matrix()
    for angles in ((40, 3, -2), (190, 0, 5))
]
PLACES = [np.array([5.0, 15.0, 1.0]), np.array([500000.0, 4000000.0, 300.0])]


@pytest.mark.parametrize("ending", [".ptx", ".txt"])
def test_scans_are_placed_by_their_poses(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"a{ending}"
    path.write_text(scan(TURNS[0], PLACES[0]) + scan(TURNS[1], PLACES[1]))
    loaded = read_model(path)
    assert loaded.kind == "cloud"
    np.testing.assert_allclose(loaded.data.points, np.vstack([WORLD, WORLD]), atol=1e-8)
    assert loaded.data.fields["scan"].tolist() == [0, 0, 0, 1, 1, 1]
    assert loaded.data.fields["intensity"].tolist() == [0.25] * 6
    assert loaded.units == ("m", "m", "m")
    assert not loaded.warnings


def test_single_scan_with_colors_is_read(tmp_path: Path) -> None:
    path = tmp_path / "a.ptx"
    path.write_text(scan(TURNS[0], PLACES[0], " 10 20 255"))
    data = read_model(path).data
    assert data.colors is not None
    assert data.colors.tolist() == [[10, 20, 255]] * 3
    assert list(data.fields) == ["intensity"]


def test_a_truncated_scan_is_read_and_reported(tmp_path: Path) -> None:
    path = tmp_path / "a.ptx"
    lines = scan(TURNS[0], PLACES[0]).splitlines()
    path.write_text("\n".join(lines[:-1]) + "\n")
    found = read_model(path)
    assert len(found.data.points) == 2
    assert by_code(found.warnings)["model.incomplete"]["promised"] == 4


@pytest.mark.parametrize(
    ("row", "text"),
    [(0, "inf"), (1, "-1"), (6, "2 0 0 0"), (6, "1 0 0"), (12, "1 2 x 4"), (12, "1 2")],
)
def test_damage_is_reported_with_its_line(tmp_path: Path, row: int, text: str) -> None:
    path = tmp_path / "a.ptx"
    lines = scan(TURNS[0], PLACES[0]).splitlines()
    lines[row] = text
    path.write_text("\n".join(lines) + "\n")
    with refused("file.damaged", format="PTX") as error:
        ptx.READER.read(path, SilentProgress())
    assert error.value.line is not None
