"""Keys 1 to 9 choose the type of what is picked."""

from __future__ import annotations

import pytest

from tests import driver
from tests.tiers import first_in_default_tier
from tests.ui.conftest import add_cliff
from vomstudio.project.records import FeatureType


@pytest.mark.parametrize("tool", first_in_default_tier(["trace", "plane", "contact"]))
def test_number_key_selects_the_type_of_the_active_tool(window, studio, tool):
    add_cliff(studio)
    studio.activate(tool)
    types = studio.session.of(FeatureType)
    run = window.actions_table.run
    for number in (2, 3, 1):
        run(f"type_{number}")
        driver.pause(20)
        assert window.tool_panel.type_box().currentData() == types[number - 1].id
    if tool == "trace":
        assert studio.next_type_id == types[0].id


def test_without_a_tool_or_a_type_the_key_states_why(window, studio):
    add_cliff(studio)
    disabled_reason = window.actions_table.disabled_reason
    studio.activate("navigate")
    assert disabled_reason("type_1").code == "action.no-types"
    studio.activate("trace")
    assert disabled_reason("type_1") is None
    count = len(studio.session.of(FeatureType))
    assert count < 9
    assert disabled_reason("type_9").code == "action.no-such-type"
    assert disabled_reason("type_9").values == {"number": 9}
