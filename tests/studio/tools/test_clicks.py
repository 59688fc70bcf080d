"""What is a click and what a drag, in every view."""

from __future__ import annotations

import math

import pytest

from vomstudio.studio.tools.interaction_types import MAX_CLICK_PX, is_click


@pytest.mark.parametrize("angle_deg", range(0, 360, 15))
def test_click_tolerance_is_the_same_in_all_directions(angle_deg: int) -> None:
    angle = math.radians(angle_deg)
    for length, expected in ((0.99 * MAX_CLICK_PX, True), (1.01 * MAX_CLICK_PX, False)):
        assert is_click(length * math.cos(angle), length * math.sin(angle)) is expected
