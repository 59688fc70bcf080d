"""`vomstudio register --without`: a wrong reading is named, and left out when asked."""

from __future__ import annotations

import csv
from typing import Any

import numpy as np
import pytest

import vomstudio as vs
from tests.messages import by_code, refused
from tests.registration.test_compass_checks import normals


def readings_table(path, wrong: str) -> None:
    rng = np.random.default_rng(8)
    azimuth, dip = rng.uniform(0, 360, 6), rng.uniform(30, 80, 6)
    model = normals(azimuth, dip)
    with path.open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["id", "dip_direction", "dip", "model_x", "model_y", "model_z"])
        for i, (a, d, m) in enumerate(zip(azimuth, dip, model, strict=True)):
            a += 90.0 if f"B{i}" == wrong else rng.normal()
            writer.writerow([f"B{i}", f"{a % 360:.1f}", f"{d:.1f}", *(f"{v:.6f}" for v in m)])


@pytest.mark.full
@pytest.mark.filterwarnings("ignore::vomstudio.core.errors.VomWarning")
def test_wrong_reading_is_reported_and_left_out_on_request(run, tmp_path) -> None:
    table = tmp_path / "readings.csv"
    readings_table(table, "B4")
    ran = run("register", "-", "--orientations", str(table), "--json")
    assert ran.code == 0, ran.err
    assert ran.json["blunders"][0]["label"] == "B4"
    assert ran.json["without"][0]["azimuth_off_deg"] == -90.0
    assert "B4" in run("register", "-", "--orientations", str(table)).out
    left = run("register", "-", "--orientations", str(table), "--without", "B4", "--json")
    assert left.code == 0, left.err
    (finding,) = (w for w in left.json["warnings"] if w["code"] == "registration.without")
    assert finding["labels"] == ["B4"]
    assert "without" not in left.json
    turn = np.array(left.json["matrix"])[:3, :3]
    assert turn == pytest.approx(np.eye(3), abs=0.05)
    again = vs.register("-", orientations=table, without="B4")
    assert np.array(again.matrix)[:3, :3] == pytest.approx(turn, abs=1e-9)


def test_without_option_applies_to_control_points(run, tmp_path) -> None:
    table = tmp_path / "pairs.csv"
    rows = [(0, 0, 0), (9, 0, 0), (0, 8, 1), (3, 2, 7), (5, 6, 0.5)]
    lines = ["label,model_x,model_y,model_z,x,y,z"]
    lines += [f"P{i},{x},{y},{z},{x + 3.0 * (i == 3)},{y},{z}" for i, (x, y, z) in enumerate(rows)]
    table.write_text("\n".join(lines))
    wrong = run("register", "-", "--pairs", str(table), "--json").json
    right = run("register", "-", "--pairs", str(table), "--without", "P3", "--json").json
    assert wrong["rms_control_m"] > 0.3
    assert right["rms_control_m"] == pytest.approx(0.0, abs=1e-9)
    assert [point["label"] for point in right["control"]] == ["P0", "P1", "P2", "P4"]


def test_unknown_label_is_refused_with_similar_ones(run, tmp_path) -> None:
    table = tmp_path / "readings.csv"
    readings_table(table, "")
    ran = run("register", "-", "--orientations", str(table), "--without", "B44")
    assert ran.code == 2
    assert "B4" in ran.err
    assert "--without" in ran.err


@pytest.mark.full
def test_suspicious_readings_are_reported(run, tmp_path) -> None:
    table = tmp_path / "readings.csv"
    readings_table(table, "")
    rows = table.read_text().splitlines()

    def findings(lines: list[str]) -> dict[str, dict[str, Any]]:
        table.write_text("\n".join([*lines, ""]))
        answer = run("register", "-", "--orientations", str(table), "--json").json
        return by_code(answer["warnings"])

    assert "compass.radians" not in findings(rows)
    small = [
        ",".join([c[0], f"{np.radians(float(c[1])):.5f}", f"{np.radians(float(c[2])):.5f}", *c[3:]])
        for c in (row.split(",") for row in rows[1:])
    ]
    assert "compass.radians" in findings([rows[0], *small])
    assert findings([*rows, rows[2]])["compass.repeated-names"]["labels"] == ("B1",)
    # Of two sources of north one may be off: not of a compass alone.
    table.write_text("\n".join([*rows, ""]))
    found = run("register", "-", "--orientations", str(table), "--json").json
    assert "registration.compass-alone" in [each["code"] for each in found["warnings"]]


@pytest.mark.parametrize(("column", "value"), [("sigma", "500"), ("sigma", "0"), ("sigma", "-2")])
def test_invalid_accuracy_is_refused_with_its_line(run, tmp_path, column, value) -> None:
    table = tmp_path / "readings.csv"
    readings_table(table, "")
    rows = table.read_text().splitlines()
    table.write_text(
        "\n".join([f"{rows[0]},{column}", *(f"{row},{value}" for row in rows[1:]), ""])
    )
    ran = run("register", "-", "--orientations", str(table))
    assert ran.code == 2
    assert "line 2" in ran.err


def test_invalid_azimuths_and_labels_are_refused(run) -> None:
    assert run("register", "-", "--bearing", "0,0,0,1,0,0,400").code == 2
    with refused("argument.wrong-type", type="int", expected="list", field="without"):
        vs.register("-", level=[[0, 0, 0, 1, 0, 0]], without=3)
