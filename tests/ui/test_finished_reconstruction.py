"""The last message of a reconstruction says how well it fits what registered it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from tests.messages import shown_codes, shown_values
from tests.tiers import first_in_default_tier
from vomstudio.ui.panels.photos.photo_findings import finished_reconstruction


@pytest.mark.parametrize(
    ("registration", "code", "values"),
    first_in_default_tier(
        [
            (
                {"rms_control_m": 0.012, "rms_check_m": 0.018},
                "registration.check-rms",
                {"control_m": "0.012", "check_m": "0.018"},
            ),
            (
                {"rms_control_m": 0.012, "rms_check_m": None},
                "registration.control-rms",
                {"control_m": "0.012"},
            ),
            (
                {"method": "camera positions (GPS)", "rms_m": 1.5},
                "registration.positions-rms",
                {"positions_m": "1.5"},
            ),
            ({}, None, {}),
        ]
    ),
)
def test_finish_message_states_the_kind_of_residuals(
    registration: dict[str, Any], code: str | None, values: dict[str, str]
) -> None:
    result: Any = SimpleNamespace(
        registered=27, photos=28, faces=150_000, registration=registration
    )
    finding = finished_reconstruction("cliff", result)
    counts = {"name": "cliff", "registered": 27, "photos": 28, "faces": 150_000}
    assert (finding.code, counts) == (
        "reconstruction.finished",
        {name: finding.values[name] for name in counts},
    )
    fit = finding.values["fit"]
    assert finding.message.endswith(fit or "faces.")
    if code is None:
        assert fit == ""
    else:
        assert code in shown_codes(fit)
        assert shown_values(fit, code) == values
        assert {name: str(finding.values[name]) for name in values} == values
