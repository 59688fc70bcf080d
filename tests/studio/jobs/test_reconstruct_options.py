"""Options of a reconstruction and the part of a scene that it makes."""

from __future__ import annotations

import pytest

from tests.messages import refused
from vomstudio.core.errors import UsageError
from vomstudio.studio.jobs.reconstruct_options import ReconstructOptions


def test_region_is_parsed_as_box_corners() -> None:
    assert ReconstructOptions(region="0,1,2, 3,4,5").box == (0.0, 1.0, 2.0, 3.0, 4.0, 5.0)
    assert ReconstructOptions().box is None


@pytest.mark.parametrize(
    ("region", "code"),
    [
        ("0,0,0,1,1", "region.not-a-box"),
        ("0,0,0,1,1,x", "region.not-a-box"),
        ("0,0,0,1,1,nan", "region.not-a-box"),
        ("0,0,0,1,1,0", "region.empty"),
    ],
)
def test_region_that_is_not_a_box_is_rejected(region: str, code: str) -> None:
    with refused(code, UsageError, field="--region"):
        ReconstructOptions(region=region)
