"""What is selected, and when others are told."""

from __future__ import annotations

import pytest

from vomstudio.project.selection import Selection


@pytest.fixture
def heard() -> list[tuple[str, ...]]:
    return []


@pytest.fixture
def selection(heard: list[tuple[str, ...]]) -> Selection:
    made = Selection()
    made.changed.connect(heard.append)
    return made


def test_the_last_chosen_is_the_current_one(selection: Selection) -> None:
    assert (selection.ids, selection.current) == ((), None)
    selection.set(["b", "a", "b", "c"])
    assert (selection.ids, selection.current) == (("b", "a", "c"), "c")


def test_others_are_told_of_changes_only(
    selection: Selection, heard: list[tuple[str, ...]]
) -> None:
    selection.set(["a", "b"])
    selection.set(("a", "b"))
    selection.retain(["b", "a", "c"])
    assert heard == [("a", "b")]
    selection.set(["b", "a"])
    selection.set([])
    assert heard == [("a", "b"), ("b", "a"), ()]


def test_a_click_with_a_key_held_adds_one_and_takes_it_away_again(
    selection: Selection, heard: list[tuple[str, ...]]
) -> None:
    selection.set(["a", "b"])
    selection.toggle("c")
    assert (selection.ids, selection.current) == (("a", "b", "c"), "c")
    selection.toggle("b")
    assert selection.ids == ("a", "c") == heard[-1]


def test_what_is_gone_is_selected_no_longer(selection: Selection) -> None:
    selection.set(["a", "b", "c"])
    selection.retain(iter(["c", "a", "x"]))
    assert selection.ids == ("a", "c")
