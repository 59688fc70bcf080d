"""Kept comparisons of a project of somebody else: what is none is left out."""

from __future__ import annotations

import copy
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.samples import HASH
from vomstudio.core.findings import Finding
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.matrices import IDENTITY
from vomstudio.project.comparisons import (
    StoredComparison,
    distances_file,
    store_comparison,
    stored_comparisons,
)
from vomstudio.project.records import Model
from vomstudio.registration.distances.comparison import compare

MODEL = Model("m1", "cliff", "/nowhere/cliff.obj", "mesh", HASH, Frame("local"))


@pytest.fixture
def made(tmp_path: Path) -> Path:
    """The description of a sound one."""
    x, y = (axis.ravel() * 0.1 for axis in np.mgrid[0:20, 0:20])
    ground = PointCloud(np.column_stack([x, y, 0.01 * np.sin(x)]))
    found = compare(replace(ground, points=ground.points + [0.0, 0.0, 0.02]), ground)
    path = distances_file(tmp_path, "one")
    path.parent.mkdir()
    np.savez(path, **found.as_fields())
    figures = found.to_dict()
    store_comparison(
        StoredComparison(
            "m1",
            "cliff",
            HASH,
            IDENTITY,
            "ground",
            "/nowhere/ground.xyz",
            IDENTITY,
            None,
            figures,
            "2026-01-01T00:00:00+00:00",
            "0.1.0",
            path,
        )
    )
    return path.with_suffix(".json")


def test_valid_comparison_is_found(made: Path, tmp_path: Path) -> None:
    (kept,) = stored_comparisons(tmp_path, "m1")
    assert kept.is_current(MODEL)


ODD: list[Any] = [7, "x", None, [], {}, [[1.0]], [[1.0] * 3] * 2, 10**400, True, [None]]


def test_any_invalid_value_in_a_stored_comparison_is_tolerated(made: Path, tmp_path: Path) -> None:
    from vomstudio.studio.jobs.placed_model import PlacedModel
    from vomstudio.ui.panels.comparison.compare_panel import ModelComparison, result_text

    sound = json.loads(made.read_text())
    places = [(name,) for name in sound] + [("figures", name) for name in sound["figures"]]
    shown = 0
    for place in places:
        for odd in ODD:
            told = copy.deepcopy(sound)
            inside = told if len(place) == 1 else told["figures"]
            inside[place[-1]] = odd
            made.write_text(json.dumps(told))
            for kept in stored_comparisons(tmp_path, "m1"):
                kept.is_current(MODEL)
                other = PlacedModel(
                    kept.benchmark, Path(kept.benchmark_path), tmp_path, IDENTITY, None
                )
                assert result_text(ModelComparison(other, other, dict(kept.figures), kept.fields))
                assert kept.made[:10]
                shown += 1
    assert shown, "some of these values are as good as others"


def test_stored_warnings_are_findings(made: Path, tmp_path: Path) -> None:
    stored = json.loads(made.read_text())
    finding = Finding("comparison.outdated", benchmark="scan", day="2026-01-01")
    stored["figures"]["warnings"] = [finding.to_dict()]
    made.write_text(json.dumps(stored))
    (kept,) = stored_comparisons(tmp_path, "m1")
    assert [Finding.from_dict(row) for row in kept.figures["warnings"]] == [finding]
    for odd in ("a sentence", {"code": "no-such-code"}, {"code": finding.code, "severity": "info"}):
        stored["figures"]["warnings"] = [odd]
        made.write_text(json.dumps(stored))
        assert stored_comparisons(tmp_path, "m1") == []


def test_invalid_comparison_does_not_hide_others(made: Path, tmp_path: Path) -> None:
    """They are sorted by the time at which they were made."""
    told = json.loads(made.read_text())
    made.with_name("two.npz").write_bytes(made.with_suffix(".npz").read_bytes())
    made.with_name("two.json").write_text(json.dumps(told | {"made": 5, "radius_m": 1.0}))
    assert [kept.fields.stem for kept in stored_comparisons(tmp_path, "m1")] == ["one"]


@pytest.mark.parametrize(
    "values",
    [np.array(["a"] * 400), np.zeros((20, 20)), np.zeros(400, complex), np.float64(3.0)],
)
def test_invalid_distances_are_not_loaded(values: Any, tmp_path: Path) -> None:
    from vomstudio.ui.panels.comparison.compare_panel import _read_stored_comparison

    path = tmp_path / "fields.npz"
    np.savez(path, distance_m=values)
    assert _read_stored_comparison(path) is None
