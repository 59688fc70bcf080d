"""Type and set of what is made next belong to the tool, and to the project."""

from __future__ import annotations

from typing import Any

import pytest


@pytest.mark.full
def test_each_tool_remembers_its_own_type_and_set(studio: Any) -> None:
    studio.activate("trace")
    studio.set_next_type("fault", "F1")
    studio.activate("plane")
    assert (studio.next_type_id, studio.next_set) == ("fault", "F1")
    studio.set_next_type("joint", "J1")
    studio.activate("trace")
    assert (studio.next_type_id, studio.next_set) == ("fault", "F1")
    studio.activate("navigate")
    studio.activate("plane")
    assert (studio.next_type_id, studio.next_set) == ("joint", "J1")


def test_new_project_resets_the_next_type_and_set(studio: Any) -> None:
    studio.activate("trace")
    studio.set_next_type("fault", "F1")
    studio.activate("navigate")
    studio.new_project()
    assert (studio.next_type_id, studio.next_set) == ("bedding", "")
    studio.activate("trace")
    assert (studio.next_type_id, studio.next_set) == ("bedding", "")
