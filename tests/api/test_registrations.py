"""`vs.register`: arrays in, the command's names out. tests/registration tests the numbers."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

import vomstudio as vs
from tests.messages import refused

MODEL = np.random.default_rng(1).uniform(-10, 10, (7, 3))
WORLD = 2.0 * MODEL[:, [1, 2, 0]] + [500.0, 200.0, 30.0]
CHECK = np.arange(7) > 4
PROMISED = {
    "matrix",
    "scale",
    "control",
    "check",
    "rms_control_m",
    "rms_check_m",
    "rotation_error_deg",
    "rotation_error_95_deg",
    "scale_error_95",
    "click_sigma_m",
    "mark_scatter_px",
    "north_sigma_deg",
    "worth_adding",
    "known",
    "blunders",
    "warnings",
}


def test_result_has_same_field_names_as_command() -> None:
    noisy = WORLD + np.random.default_rng(3).normal(0, 0.01, WORLD.shape)
    found = vs.register(MODEL, noisy, check=CHECK)
    told = json.loads(json.dumps(found.to_dict()))
    assert set(told) == PROMISED
    assert set(told["rotation_error_deg"]) == {"about_up", "about_east", "about_north"}
    assert set(told["rotation_error_95_deg"]) == {
        "about_up",
        "about_east",
        "about_north",
        "weakest",
    }
    assert set(told["control"][0]) == {"label", "dx", "dy", "dz", "error_m", "pixels"}
    assert found.scale == pytest.approx(2.0, rel=0.01)
    assert "rms_check_m" in repr(found)
    assert found(MODEL) == pytest.approx(WORLD, abs=0.1)


def test_registration_findings_are_python_warnings() -> None:
    with pytest.warns(vs.errors.VomWarning) as caught:
        vs.register(MODEL, WORLD)
    assert "control.no-check-points" in [each.message.code for each in caught]


@pytest.mark.parametrize(
    ("model", "world", "more", "code", "values"),
    [
        (MODEL, WORLD[:5], {}, "array.lengths-differ", {"count": 7, "other_count": 5}),
        (MODEL[:, :2], WORLD, {}, "array.not-points", {"shape": (7, 2)}),
        (
            MODEL,
            np.where(np.arange(21).reshape(7, 3) == 4, np.nan, WORLD),
            {},
            "array.not-finite",
            {"first_row": 1, "count": 1, "field": "world_points"},
        ),
        (MODEL, WORLD, {"sigma_m": 0.1}, "array.shape", {"expected": "(7, 3)"}),
        (
            MODEL,
            WORLD,
            {"sigma_m": np.zeros((7, 3))},
            "array.not-positive",
            {"first_row": 0, "count": 7, "field": "sigma_m"},
        ),
        (MODEL, WORLD, {"check": [1, 2]}, "array.not-flags", {"count": 7, "field": "check"}),
        (MODEL, WORLD, {"check": np.arange(7)}, "array.not-flags", {"count": 7}),
        ("a", WORLD, {}, "file.missing", {"file": "a"}),
    ],
)
def test_unpaired_points_are_refused(
    model: Any, world: Any, more: Any, code: str, values: dict[str, Any]
) -> None:
    with refused(code, **values):
        vs.register(model, world, **more)


def test_too_few_points_are_refused() -> None:
    with refused("registration.too-few-points", vs.errors.GeometryError, least=3, count=2):
        vs.register(MODEL[:2], WORLD[:2])
