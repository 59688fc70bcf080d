"""What the panel of a tool says of the next click."""

from __future__ import annotations

import pytest

from tests import driver
from vomstudio.ui.base.controls import Label

pytestmark = pytest.mark.full


@pytest.mark.parametrize("tool", ["trace", "plane", "line", "contact", "station", "select"])
def test_active_tool_panel_does_not_ask_to_choose_the_tool(window, outcrop, tool) -> None:
    driver.open_outcrop(window, outcrop)
    window.actions_table.run(tool)
    driver.pause(50)
    panel = window.tool_panel.currentWidget()
    said = [label.text() for label in panel.findChildren(Label) if label.isVisible()]
    name = window.actions_table.all[tool].text().replace("&", "")
    assert said
    assert not [text for text in said if text.startswith(f"Choose {name}")]
