"""`vomstudio trace`: the object and table that are promised, and what is refused."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from tests.extraction.small_onnx import convolution
from tests.extraction.test_photo_following import clicks as wall_clicks
from tests.extraction.test_photo_following import wall, written
from tests.messages import error_of

PROMISED = {"table", "length_m", "snap_m", "plane"}


@pytest.fixture
def slope(tmp_path: Path) -> Path:
    """A slope with a dark bed at the height of 1 m."""
    y, x = (a.ravel() * 0.05 for a in np.mgrid[0:80, 0:80])
    z = 0.5 * y + 0.3 * np.sin(3.0 * x) + 0.01
    grey = np.where(np.abs(z - 1.0) < 0.02, 10, 200)
    path = tmp_path / "slope.csv"
    np.savetxt(
        path,
        np.column_stack([x, y, z, grey]),
        fmt="%.4f",
        delimiter=",",
        header="x,y,z,grey",
        comments="",
    )
    return path


@pytest.fixture
def clicks(tmp_path: Path) -> Path:
    path = tmp_path / "clicks.csv"
    path.write_text("x,y,z\n0.05,1.9,1.0\n2.0,2.1,1.0\n3.9,2.4,1.0\n")
    return path


def test_trace_is_reported_and_written_to_table(
    run, slope: Path, clicks: Path, tmp_path: Path
) -> None:
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


def test_way_point_off_model_is_reported_with_its_line(
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
def test_untraceable_input_is_refused(
    run, slope: Path, clicks: Path, tmp_path: Path, text: str, cost: str
) -> None:
    clicks.write_text(text)
    ran = run("trace", slope, "--through", clicks, "-o", tmp_path / "t.csv", "--cost", cost)
    assert ran.code == 2
    assert ran.said
    assert not (tmp_path / "t.csv").exists()


DARK = np.full((1, 3, 1, 1), -1.0 / 3.0)
"""One minus the lightness, with a bias of one."""


@pytest.mark.full
def test_edges_detected_by_network_are_followed(run, tmp_path: Path) -> None:
    y, x = (a.ravel() * 0.05 for a in np.mgrid[0:80, 0:80])
    z = 0.5 * y + 0.3 * np.sin(3.0 * x) + 0.01
    grey = np.where(np.abs(z - 1.0) < 0.02, 10, 250) + np.zeros((3, 1))
    model, clicks, network = (tmp_path / n for n in ("s.csv", "c.csv", "n.onnx"))
    np.savetxt(
        model,
        np.column_stack([x, y, z, *grey]),
        fmt="%.4f",
        delimiter=",",
        header="x,y,z,r,g,b",
        comments="",
    )
    clicks.write_text("x,y,z\n0.05,1.9,1.0\n2.0,2.1,1.0\n3.9,2.4,1.0\n")
    network.write_bytes(convolution(DARK, bias=1.0))
    words = ["trace", model, "--through", clicks, "--cost", "onnx"]
    ran = run(*words, "--onnx-model", network, "-o", tmp_path / "t.csv", "--json")
    assert ran.code == 0, ran.said
    assert ran.json["cost"] == "onnx"
    points = np.loadtxt(tmp_path / "t.csv", delimiter=",", skiprows=5, comments="#")
    assert np.median(np.abs(points[:, 2] - 1.0)) < 0.05
    seen = run(
        "trace",
        model,
        "--propose",
        "--cost",
        "onnx",
        "--onnx-model",
        network,
        "-o",
        tmp_path / "p.csv",
        "--json",
    )
    assert seen.code == 0, seen.said
    assert seen.json["cost"] == "onnx"
    notes = seen.json["proposals"][0]["plane"]["notes"]
    assert "onnx" in re.findall(r"\w+", notes)
    network.write_bytes(b"nothing")
    out = tmp_path / "n.csv"
    option, missing = "--onnx-model", tmp_path / "none.onnx"
    for more, code, values in (
        ([option, network], "file.other-format", {"file": network, "format": "ONNX"}),
        ([option, missing], "file.unreadable", {"file": missing}),
        ([], "edges.no-network", {"field": option}),
        ([option, network, "--cost", "dark"], "edges.network-unused", {"field": option}),
    ):
        ran = run(*words, *more, "-o", out, "--json")
        assert (ran.code, out.exists()) == (2, False)
        error_of(ran.json, code, **values)


@pytest.fixture(scope="module")
def photographed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A wall as a file, its photos and cameras, and way-points on its bed."""
    folder = tmp_path_factory.mktemp("photographed")
    made = wall(4)
    written(made, folder)
    mesh = made.mesh()
    lines = [
        "ply",
        "format ascii 1.0",
        f"element vertex {len(mesh.vertices)}",
        "property double x",
        "property double y",
        "property double z",
        f"element face {len(mesh.faces)}",
        "property list uchar int vertex_indices",
        "end_header",
        *(" ".join(f"{v:.9f}" for v in p) for p in mesh.vertices),
        *(f"3 {a} {b} {c}" for a, b, c in mesh.faces),
    ]
    (folder / "wall.ply").write_text("\n".join(lines) + "\n")
    rows = [",".join(f"{v:.6f}" for v in p) for p in wall_clicks(made)]
    (folder / "clicks.csv").write_text("\n".join(["x,y,z", *rows]) + "\n")
    return folder


@pytest.mark.full
def test_a_trace_is_followed_in_a_photo(run, photographed: Path, tmp_path: Path) -> None:
    table = tmp_path / "bed.csv"
    words = [
        "trace",
        photographed / "wall.ply",
        "--photo",
        photographed / "p0.png",
        "--cameras",
        photographed / "cameras.json",
        "--through",
        photographed / "clicks.csv",
        "-o",
        table,
    ]
    ran = run(*words, "--json")
    assert ran.code == 0, ran.said
    assert ran.json.keys() >= PROMISED | {"photo", "voters", "agreeing_share"}
    assert ran.json["photo"] == "p0.png"
    assert sorted(ran.json["voters"]) == ["p1.png", "p2.png"]
    assert ran.json["snap_m"] < 0.02
    points = np.loadtxt(table, delimiter=",", skiprows=6)
    assert points.shape == (ran.json["vertices"], 3)
    made = wall(4)
    assert np.median(np.abs(points @ made.normal - made.level)) < 0.006
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert steps.sum() == pytest.approx(ran.json["length_m"], abs=1e-4)
    assert run("fit", table, "--json").json["planes"][0]["n_points"] == len(points)
    # The same by the columns and rows of the photo, the photo by its name, the cameras beside the
    # model.
    clicks = tmp_path / "pixels.csv"
    from vomstudio.io.photos.cameras_file import read_cameras

    pixels = read_cameras(photographed / "cameras.json").views[0].project(wall_clicks(made))
    clicks.write_text("column,row\n" + "\n".join(f"{x:.4f},{y:.4f}" for x, y in pixels) + "\n")
    again = run(
        "trace",
        photographed / "wall.ply",
        "--photo",
        "p0.png",
        "--through",
        clicks,
        "-o",
        tmp_path / "again.csv",
        "--json",
    )
    assert again.code == 0, again.said
    assert (tmp_path / "again.csv").read_text() == table.read_text()


@pytest.mark.full
@pytest.mark.parametrize("more", [["--cost", "auto"], ["--cost", "onnx"]])
def test_photo_trace_supports_automatic_cost_and_network(run, photographed, tmp_path, more) -> None:
    network = tmp_path / "n.onnx"
    network.write_bytes(convolution(DARK, bias=1.0))
    if "onnx" in more:
        more = [*more, "--onnx-model", network]
    ran = run(
        "trace",
        photographed / "wall.ply",
        "--photo",
        "p0.png",
        "--through",
        photographed / "clicks.csv",
        "-o",
        tmp_path / "t.csv",
        "--json",
        *more,
    )
    assert ran.code == 0, ran.said
    made = wall(4)
    points = np.loadtxt(tmp_path / "t.csv", delimiter=",", skiprows=6)
    assert np.median(np.abs(points @ made.normal - made.level)) < 0.01
    tried = ran.json["tried"]
    if "auto" in more:
        assert {one["cost"] for one in tried} == {"colour", "dark", "light", "gradient"}
        assert ran.json["cost"] == tried[0]["cost"]
        known = [one["error95_deg"] for one in tried]
        # Some are good here: all are in the order of their errors.
        assert known[0] < 5.0
        assert known == sorted(known)
    else:
        assert ran.json["cost"] == "onnx"
        assert sorted(ran.json["voters"]) == ["p1.png", "p2.png"]


@pytest.mark.parametrize(
    ("more", "code", "values"),
    [
        (["--photo", "p9.png"], "photo.no-camera", {"photo": "p9.png"}),
        (
            ["--photo", "p0.png", "--cost", "curvature"],
            "option.not-a-choice",
            {"value": "curvature", "field": "--cost"},
        ),
        (["--photo", "p0.png", "--cameras", "none.json"], "file.missing", {"file": "none.json"}),
        (
            ["--cameras", "cameras.json"],
            "option.requires",
            {"option": "--cameras", "other": "--photo"},
        ),
    ],
)
def test_untraceable_photo_input_is_refused(
    run, photographed: Path, tmp_path: Path, more: list[str], code: str, values: dict[str, object]
) -> None:
    ran = run(
        "trace",
        photographed / "wall.ply",
        "--through",
        photographed / "clicks.csv",
        "-o",
        tmp_path / "t.csv",
        *more,
        "--json",
    )
    assert ran.code == 2
    error_of(ran.json, code, **values)
    assert not (tmp_path / "t.csv").exists()


def test_drawing_cannot_be_followed_in_photo(run, slope: Path, tmp_path: Path) -> None:
    ran = run(
        "trace",
        slope,
        "--from-ortho",
        "drawn.gpkg",
        "--photo",
        "p0.png",
        "-o",
        tmp_path / "t.csv",
        "--json",
    )
    assert ran.code == 2
    error = ran.json["error"]
    assert (error["code"], error["option"], error["other"]) == (
        "option.requires",
        "--photo",
        "--through",
    )


def test_lines_are_proposed_and_written(run, slope: Path, tmp_path: Path) -> None:
    table = tmp_path / "seen.csv"
    ran = run("trace", slope, "--propose", "--cost", "grey", "-o", table, "--json")
    assert ran.code == 0, ran.said
    assert ran.json["table"] == str(table)
    first = ran.json["proposals"][0]
    assert first.keys() >= {"line", "length_m", "evidence", "doubt", "plane"}
    rows = [line.split(",") for line in table.read_text().splitlines() if line[0] != "#"]
    assert rows[0] == ["line", "x", "y", "z"]
    heights = np.array([float(row[3]) for row in rows[1:] if row[0] == first["line"]])
    assert np.median(np.abs(heights - 1.0)) < 0.05
    assert "needs colours" in run("trace", slope, "--propose", "-o", tmp_path / "n.csv").said
    words = ["trace", slope, "--propose", "-o", tmp_path / "n.csv", "--json"]
    error = run(*words, "--into", tmp_path).json["error"]
    assert (error["code"], error["option"], error["other"]) == (
        "option.requires",
        "--into",
        "--from-ortho",
    )
    both = run("trace", slope, "--propose", "--through", slope, "-o", tmp_path / "n.csv")
    assert both.code == 2
