"""`vomstudio compare`: the object that is promised, the field that is written, what is refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.messages import codes, messages, shown_codes, shown_values
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.models.opening import read_model
from vomstudio.io.models.writing import write_model

Write = Callable[..., Path]
PROMISED = {
    "n",
    "mean_m",
    "median_m",
    "std_m",
    "mad_m",
    "rms_m",
    "lod95_m",
    "significant_share",
}


def plane(up: float, seed: int = 1, noise: float = 0.0, n: int = 30) -> np.ndarray:
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.arange(n) * 0.1, np.arange(n) * 0.1)
    return np.column_stack([x.ravel(), y.ravel(), up + rng.normal(0, noise, n * n)])


def table(points: np.ndarray) -> str:
    return "".join(f"{x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in points)


def mesh(n: int = 30) -> Mesh:
    row = np.arange(n * n).reshape(n, n)
    a, b, c, d = row[:-1, :-1], row[:-1, 1:], row[1:, 1:], row[1:, :-1]
    faces = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    return Mesh(plane(0.0), faces.astype(np.int32))


def test_point_tables_are_read_as_clouds(run, write: Write) -> None:
    ran = run(
        "compare", write(table(plane(0.25)), "a.xyz"), write(table(plane(0.0)), "b.xyz"), "--json"
    )
    assert ran.code == 0, ran.err
    told = ran.json
    assert set(told) >= PROMISED
    assert (told["n"], told["beyond"]) == (900, 0)
    assert told["mean_m"] == pytest.approx(0.25)
    assert told["rms_m"] == pytest.approx(0.25)
    assert told["std_m"] == pytest.approx(0.0, abs=1e-9)
    assert told["lod95_m"] is None
    assert told["significant_share"] is None
    assert told["positive_toward"]["plunge_deg"] == pytest.approx(-90.0)
    assert codes(told) == ["frame.assumed", "frame.assumed", "comparison.no-unit"]


def test_report_separates_accuracy_and_precision(run, write: Write) -> None:
    ran = run(
        "compare",
        write(table(plane(0.25, 1, 0.01)), "a.xyz"),
        write(table(plane(0)), "b.xyz"),
        "--m3c2",
        "0.4",
        "--registration-error",
        "0.02",
    )
    assert ran.code == 0, ran.err
    for word in ("accuracy", "precision", "median absolute deviation", "Level of detection"):
        assert word in ran.out
    # 1.96 times the stated error, and what the noise adds.
    assert "0.04" in ran.out.split("median): ")[1][:6]


def test_distance_field_is_written_to_model(run, write: Write, tmp_path: Path) -> None:
    bench = write(table(plane(0.0, 2, 0.005)), "b.xyz")
    model = tmp_path / "model.ply"
    raised = mesh()
    raised.vertices[:, 2] = 0.1 + 0.02 * raised.vertices[:, 0]
    write_model(raised, None, model)
    out = tmp_path / "field.ply"
    ran = run(
        "compare", model, bench, "--m3c2", 0.3, "--registration-error", 0, "-o", out, "--json"
    )
    assert ran.code == 0, ran.err
    assert ran.json["out"] == str(out)
    data = read_model(out).data
    assert isinstance(data, Mesh)
    assert data.faces.shape == raised.faces.shape
    assert set(data.fields) == {"distance_m", "lod95_m", "significant"}
    truth = raised.vertices[:, 2]
    inside = np.all((truth[:, None] > 0, data.vertices[:, :2].min(1)[:, None] > 0.7), axis=0)[:, 0]
    inside &= data.vertices[:, :2].max(axis=1) < 2.2
    found = np.asarray(data.fields["distance_m"], float)
    assert found[inside] == pytest.approx(data.vertices[inside, 2], abs=0.01)
    assert np.asarray(data.fields["significant"])[inside].all()
    again = run("compare", model, bench, "-o", out)
    assert "output.exists" in shown_codes(again.said)


def test_different_reference_systems_are_refused(run, tmp_path: Path) -> None:
    for name, crs in (("a", "EPSG:32633"), ("b", "EPSG:32632")):
        write_model(PointCloud(plane(0.0) + [5e5, 5e6, 0]), crs, tmp_path / f"{name}.laz")
    ran = run("compare", tmp_path / "a.laz", tmp_path / "b.laz", "--json")
    assert ran.code == 2
    assert "UTM zone 33N" in ran.json["error"]["message"]


def test_clouds_without_overlap_are_refused(run, write: Write) -> None:
    far = plane(0.0) + [5e5, 5e6, 0.0]
    ran = run("compare", write(table(plane(0.0)), "a.xyz"), write(table(far), "b.xyz"))
    assert ran.code == 2
    assert "reference.no-overlap" in shown_codes(ran.said)


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (("--m3c2", "0"), "option.not-a-length"),
        (("--m3c2", "much"), "number.invalid"),
        (("--registration-error", "-1"), "option.too-small"),
    ],
)
def test_invalid_lengths_are_refused(run, write: Write, words: tuple[str, ...], code: str) -> None:
    model = write(table(plane(0.0)), "a.xyz")
    ran = run("compare", model, model, *words, "--json")
    assert ran.code == 2
    assert (ran.json["error"]["code"], ran.json["error"]["field"]) == (code, words[0])


def test_error_stated_by_reconstruction_is_used(run, write: Write, tmp_path: Path) -> None:
    model = write(table(plane(0.0, 1, 0.01)), "a.xyz")
    write('{"registration": {"rms_check_m": 0.06, "rms_control_m": 0.01}}', "reconstruction.json")
    (tmp_path / "other").mkdir()
    bench = tmp_path / "other" / "b.xyz"
    bench.write_text(table(plane(0.0, 2, 0.01)))
    told = run("compare", model, bench, "--m3c2", 0.4, "--json").json
    assert told["registration_error_m"] == pytest.approx(0.06 / np.sqrt(3))
    told = run("compare", bench, bench, "--m3c2", 0.4, "--json").json
    assert told["registration_error_m"] == 0.0
    assert any("--registration-error" in said for said in messages(told))


def test_orientations_of_both_are_compared_with_their_errors(run, write: Write) -> None:
    clouds = write(table(plane(0.25)), "a.xyz"), write(table(plane(0.0)), "b.xyz")
    head = "name,kind,dip_direction_deg,dip_deg,x,y,z,extent_m,total95_deg\n"
    own = write(head + "B1,bedding,90,30,0,0,0,2,3\nB2,bedding,90,40,5,0,0,2,\n", "own.csv")
    other = write(head + "B1,bedding,90,34,9,9,9,2,4\nX,bedding,90,41,5,0.5,0,2,1\n", "other.csv")
    ran = run("compare", *clouds, "--orientations", own, other, "--json")
    assert ran.code == 0, ran.err
    told = ran.json["orientations"]
    assert (told["n"], told["by_name"], told["by_nearness"]) == (2, 1, 1)
    first, second = told["matched"]
    assert (first["first"], first["second"], first["by"]) == ("B1", "B1", "name")
    assert first["angle_deg"] == pytest.approx(4.0)
    assert first["error95_deg"] == pytest.approx(5.0)
    assert first["agree"] is True
    assert (second["second"], second["by"], second["error95_deg"]) == ("X", "nearness", None)
    assert told["agree_share"] == 1.0
    said = run("compare", *clouds, "--orientations", own, other).out
    assert shown_values(said, "comparison.planes-matched").keys() == {"n", "named", "near"}
    assert shown_values(said, "comparison.planes-agree") == {"share_percent": "100"}
    lines = write("trend,plunge\n10,20\n", "lines.csv")
    assert run("compare", *clouds, "--orientations", own, lines).code == 2
