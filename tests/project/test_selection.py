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


def test_last_selected_id_is_current(selection: Selection) -> None:
    assert (selection.ids, selection.current) == ((), None)
    selection.set(["b", "a", "b", "c"])
    assert (selection.ids, selection.current) == (("b", "a", "c"), "c")


def test_signal_is_emitted_only_if_the_selection_changes(
    selection: Selection, heard: list[tuple[str, ...]]
) -> None:
    selection.set(["a", "b"])
    selection.set(("a", "b"))
    selection.retain(["b", "a", "c"])
    assert heard == [("a", "b")]
    selection.set(["b", "a"])
    selection.set([])
    assert heard == [("a", "b"), ("b", "a"), ()]


def test_toggle_adds_and_removes_an_id(selection: Selection, heard: list[tuple[str, ...]]) -> None:
    selection.set(["a", "b"])
    selection.toggle("c")
    assert (selection.ids, selection.current) == (("a", "b", "c"), "c")
    selection.toggle("b")
    assert selection.ids == ("a", "c") == heard[-1]


def test_missing_ids_are_removed_from_the_selection(selection: Selection) -> None:
    selection.set(["a", "b", "c"])
    selection.retain(iter(["c", "a", "x"]))
    assert selection.ids == ("a", "c")
