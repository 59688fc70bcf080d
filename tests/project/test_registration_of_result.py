"""The registration that the result of a reconstruction states, as a record."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from vomstudio.io.models.reconstruction_file import result_registration

COVARIANCE = np.diag([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]) * 1e-6
TURN = {"about_up": 0.1, "about_east": 0.06, "about_north": 0.08}


def result(**told: Any) -> dict[str, Any]:
    own = {
        "method": "ground control points",
        "rotation_error_deg": TURN,
        "scale_error": 0.002,
        "covariance": COVARIANCE.tolist(),
        "centre": [1.0, 2.0, 3.0],
    }
    return {"frame": "EPSG:32633", "scaled": True, "registration": own | told}


def test_points_and_covariance_of_the_result_are_recorded() -> None:
    points = [
        {"label": "A", "role": "control", "residual_m": [0.1, 0.0, -0.1], "surveyed": [5, 6, 7]},
        {"label": "B", "role": "check", "residual_m": [0.0, 0.0, 0.2], "surveyed": [8, 9, 7]},
        {"label": "C", "role": "left out", "residual_m": [9.0, 0, 0], "surveyed": [8, 9, 7]},
        {"label": "D", "role": "unseen", "residual_m": None, "surveyed": [8, 9, 7]},
    ]
    record = result_registration(result(points=points), "run")
    assert [(p.label, p.check) for p in record.control] == [("A", False), ("B", True)]
    assert record.control[0].model == pytest.approx((5.1, 6.0, 6.9))
    assert record.control[0].world == (5.0, 6.0, 7.0)
    covariance = record.rotation_covariance()
    assert covariance is not None
    assert np.diag(covariance) == pytest.approx([1e-6, 2e-6, 3e-6])
    assert record.centre == (1.0, 2.0, 3.0)


def test_used_camera_positions_become_control_points() -> None:
    rows = [
        {"name": f"{i}.jpg", "dx": 0.5, "dy": 0.0, "dz": 1.0, "used": i < 2, "surveyed": [i, 0, 9]}
        for i in range(3)
    ]
    told = result(method="camera positions (GPS)", residuals=rows)
    record = result_registration(told, "run")
    assert [p.label for p in record.control] == ["0.jpg", "1.jpg"]
    assert record.control[1].residual == (0.5, 0.0, 1.0)


@pytest.mark.parametrize("bad", [None, [], [[1.0] * 7] * 6, [["x"] * 7] * 7, [[None] * 7] * 7, "7"])
def test_damaged_covariance_is_ignored_and_axis_errors_are_kept(bad: Any) -> None:
    record = result_registration(result(covariance=bad, points=[{"role": "control"}, 3]), "run")
    assert record.covariance is None
    assert record.control == ()
    assert record.rotation_error_deg == (0.1, 0.06, 0.08)
