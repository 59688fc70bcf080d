"""`vs.register`: arrays in, the command's names out. tests/registration tests the numbers."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

import vomstudio as vs

MODEL = np.random.default_rng(1).uniform(-10, 10, (7, 3))
WORLD = 2.0 * MODEL[:, [1, 2, 0]] + [500.0, 200.0, 30.0]
CHECK = np.arange(7) > 4
PROMISED = {
    "matrix", "scale", "control", "check", "rms_control_m", "rms_check_m", "rotation_error_deg",
    "rotation_error_95_deg", "scale_error_95", "click_sigma_m", "mark_scatter_px",
    "north_sigma_deg",
    "worth_adding", "known", "blunders", "warnings",
}  # fmt: skip


def test_the_object_has_the_names_of_the_command() -> None:
    noisy = WORLD + np.random.default_rng(3).normal(0, 0.01, WORLD.shape)
    found = vs.register(MODEL, noisy, check=CHECK)
    told = json.loads(json.dumps(found.as_dict()))
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


def test_remarks_are_python_warnings() -> None:
    with pytest.warns(vs.errors.VomWarning) as caught:
        vs.register(MODEL, WORLD)
    assert "control.no-check-points" in [each.message.code for each in caught]


@pytest.mark.parametrize(
    ("model", "world", "more", "said"),
    [
        (MODEL, WORLD[:5], {}, "7 points of the model and 5 of World do not form pairs"),
        (MODEL[:, :2], WORLD, {}, "three coordinates"),
        (
            MODEL,
            np.where(np.arange(21).reshape(7, 3) == 4, np.nan, WORLD),
            {},
            "Row 1 has no finite",
        ),
        (MODEL, WORLD, {"sigma_m": 0.1}, r"an array \(7, 3\)"),
        (MODEL, WORLD, {"sigma_m": np.zeros((7, 3))}, "Row 0 .and 6 more. has no positive errors"),
        (MODEL, WORLD, {"check": [1, 2]}, r"an array \(7,\) of bool"),
        (MODEL, WORLD, {"check": np.arange(7)}, "of bool"),
        ("a", WORLD, {}, "Numbers are needed"),
    ],
)
def test_what_are_no_pairs_is_refused(model: Any, world: Any, more: Any, said: str) -> None:
    with pytest.raises(vs.errors.InputError, match=said):
        vs.register(model, world, **more)


def test_too_few_points_are_refused() -> None:
    with pytest.raises(vs.errors.GeometryError, match="at least 3"):
        vs.register(MODEL[:2], WORLD[:2])
