"""`vomstudio trace`: the object and table that are promised, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

PROMISED = {"table", "length_m", "snap_m", "plane"}


@pytest.fixture
def slope(tmp_path: Path) -> Path:
    """A slope with a dark bed at the height of 1 m."""
    y, x = (a.ravel() * 0.05 for a in np.mgrid[0:80, 0:80])
    z = 0.5 * y + 0.3 * np.sin(3.0 * x) + 0.01
    grey = np.where(np.abs(z - 1.0) < 0.02, 10, 200)
    path = tmp_path / "slope.csv"
    np.savetxt(
        path, np.column_stack([x, y, z, grey]), fmt="%.4f", delimiter=",", header="x,y,z,grey",
        comments="",
    )  # fmt: skip
    return path


@pytest.fixture
def clicks(tmp_path: Path) -> Path:
    path = tmp_path / "clicks.csv"
    path.write_text("x,y,z\n0.05,1.9,1.0\n2.0,2.1,1.0\n3.9,2.4,1.0\n")
    return path


def test_the_object_and_the_table(run, slope: Path, clicks: Path, tmp_path: Path) -> None:
    table = tmp_path / "bed.csv"
    words = ["trace", slope, "--through", clicks, "-o", table, "--cost", "grey"]
    ran = run(*words, "--json")
    assert ran.code == 0
    assert ran.json.keys() >= PROMISED
    assert ran.json["length_m"] > 3.85
    assert ran.json["snap_m"] < 0.1
    points = np.loadtxt(table, delimiter=",", skiprows=5, comments="#")
    assert len(points) == ran.json["vertices"] > 60
    assert np.abs(points[:, 2] - 1.0).max() < 0.1
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert steps.sum() == pytest.approx(ran.json["length_m"], abs=1e-4)
    plane = ran.json["plane"]
    assert plane["dip_deg"] < plane["total95_deg"]
    fitted = run("fit", table, "--json").json["planes"][0]
    assert fitted["n_points"] == ran.json["vertices"]
    assert fitted["dip_deg"] == pytest.approx(plane["dip_deg"], abs=1e-3)
    assert run(*words).code == 2
    assert run(*words, "--force").code == 0


def test_a_way_point_off_the_model_is_named_by_its_line(
    run, slope: Path, clicks: Path, tmp_path: Path
) -> None:
    clicks.write_text("x,y,z\n0.05,1.9,1.0\n2.0,2.1,5.0\n")
    words = ["trace", slope, "--through", clicks, "-o", tmp_path / "t.csv", "--cost", "grey"]
    failed = run(*words, "--json")
    assert failed.code == 2
    assert failed.json["error"]["line"] == 3
    assert failed.json["error"]["file"].endswith("clicks.csv")
    assert not (tmp_path / "t.csv").exists()


@pytest.mark.parametrize(
    ("text", "cost"),
    [
        ("x,y,z\n0.05,1.9,1.0\n", "grey"),
        ("x,y,z\n0.05,1.9,1.0\n0.05,1.9,1.0\n", "grey"),
        ("x,y,z\n0.05,1.9,1.0\n2.0,2.1,1.0\n", "shade"),
        ("x,y,z\n0.05,1.9,1.0\n2.0,2.1,1.0\n", "colour"),
    ],
)
def test_what_cannot_be_followed_is_refused(
    run, slope: Path, clicks: Path, tmp_path: Path, text: str, cost: str
) -> None:
    clicks.write_text(text)
    ran = run("trace", slope, "--through", clicks, "-o", tmp_path / "t.csv", "--cost", cost)
    assert ran.code == 2
    assert ran.said
    assert not (tmp_path / "t.csv").exists()
