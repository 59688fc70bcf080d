"""The command line on the sample outcrop, whose truth is known from outside."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vomstudio.cli import main
from vomstudio.core.paths import resource


def vector(trend_deg: float, plunge_deg: float) -> np.ndarray:
    t, p = np.radians([trend_deg, plunge_deg])
    return np.array([np.sin(t) * np.cos(p), np.cos(t) * np.cos(p), -np.sin(p)])


def angle_deg(a: np.ndarray, b: np.ndarray) -> float:
    """Between two axes."""
    return float(np.degrees(np.arccos(min(1.0, abs(a @ b)))))


def pole(plane: dict[str, Any]) -> np.ndarray:
    return vector(float(plane["dip_direction_deg"]) + 180.0, 90.0 - float(plane["dip_deg"]))


def answer(capfd: pytest.CaptureFixture[str], *words: object) -> dict[str, Any]:
    code = main([str(word) for word in words] + ["--json"])
    out, err = capfd.readouterr()
    assert code == 0, err
    result: dict[str, Any] = json.loads(out)
    return result


def test_the_sample_is_measured_to_within_the_stated_confidence(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    table = tmp_path / "planes.csv"
    planes = answer(capfd, "fit", resource("outcrop", "picks.csv"), "--by", "trace", "-o", table)
    lines = resource("outcrop", "truth.csv").read_text("utf-8").splitlines()
    truth = {row["trace"]: row for row in csv.DictReader(s for s in lines if s[0] != "#")}
    assert sorted(row["id"] for row in planes["planes"]) == sorted(truth)
    for row in planes["planes"]:
        error = angle_deg(pole(row), pole(truth[row["id"]]))
        # At 95 % one in twenty may lie outside, but hardly by half as much again.
        assert error < 1.5 * row["max_confidence95_deg"], row["id"]
        assert row["max_confidence95_deg"] < 3.0

    fold = answer(capfd, "fold", table)
    beta = vector(fold["beta"]["trend_deg"], fold["beta"]["plunge_deg"])
    words = lines[0].replace(",", " ").split()
    axis = vector(*(float(words[words.index(name) + 1]) for name in ("trend", "plunge")))
    assert fold["used"] == 8
    assert angle_deg(beta, axis) < 1.0


@pytest.mark.slow
def test_three_clicks_give_good_planes_for_half_of_the_traces() -> None:
    """At the first, the middle and the last of each pick, with nothing else known."""
    from vomstudio.extraction.best_cost import follow_best
    from vomstudio.extraction.surface_graph import SurfaceGraph
    from vomstudio.geology.orientation import Plane
    from vomstudio.geology.quality import judge, total_error_deg
    from vomstudio.geometry.planes import fit_plane
    from vomstudio.geometry.surface import VertexSurface
    from vomstudio.studio.world_models import read_in_world

    def rows(name: str) -> list[dict[str, str]]:
        with resource("sample", name).open(newline="") as stream:
            return list(csv.DictReader(line for line in stream if not line.startswith("#")))

    truth = {r["name"]: r for r in rows("truth.csv") if r["dip_deg"]}
    picked: dict[str, list[list[float]]] = {}
    for row in rows("picks.csv"):
        if row["pick"] in truth:
            picked.setdefault(row["pick"], []).append([float(row[k]) for k in "xyz"])
    assert len(picked) == 31
    data = read_in_world(resource("sample", "sample.obj")).data
    surface, near = SurfaceGraph(data), VertexSurface(np.asarray(data.vertices))
    near.build()
    good = good_and_off = held = 0
    for name, points in picked.items():
        clicks = np.array([points[0], points[len(points) // 2], points[-1]])
        path, _, _ = follow_best(surface, clicks, near.local_resolution)
        fit, resolution = fit_plane(path.points), near.local_resolution(path.points)
        stated = total_error_deg(fit, resolution)
        plane = Plane(float(truth[name]["dip_direction_deg"]), float(truth[name]["dip_deg"]))
        error = np.degrees(np.arccos(min(1.0, abs(float(fit.normal @ plane.normal())))))
        held += stated is None or error <= stated
        verdict = judge(
            fit, resolution_m=resolution, outcrop_normal=near.outcrop_normal(path.points)
        )
        good += verdict.quality == "good"
        good_and_off += verdict.quality == "good" and error > 5.0
    assert good >= 16
    assert good_and_off == 0
    assert held >= 29
