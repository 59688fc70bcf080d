"""The last message of a reconstruction says how well it fits what registered it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from vomstudio.ui.photos.photo_findings import finished_text


@pytest.mark.parametrize(
    ("registration", "said"),
    [
        ({"rms_control_m": 0.012, "rms_check_m": 0.018},
         "RMS of control points 1.20 cm, of check points 1.80 cm."),
        ({"rms_control_m": 0.012, "rms_check_m": None}, "1.20 cm; no check points."),
        ({"method": "camera positions (GPS)", "rms_m": 1.5}, "RMS of camera positions 1.5"),
        ({}, "faces."),
    ],
)  # fmt: skip
def test_residuals_are_told_by_what_they_are_of(registration: dict[str, Any], said: str) -> None:
    result: Any = SimpleNamespace(
        registered=27, photos=28, faces=150_000, registration=registration
    )
    text = finished_text("cliff", result)
    assert "27 of 28 photos" in text
    assert said in text
    assert text.endswith((".", "faces."))
