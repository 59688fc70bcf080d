"""What a report tells of a project's history: what was done to what, and nobody's words."""

from __future__ import annotations

import re
from typing import Any

import pytest

from vomstudio.project.journal.outline import outline
from vomstudio.project.journal.replay import JournalRow


def row(
    kind: str = "do", label: str = "", before: Any = None, after: Any = None, of: int | None = None
) -> JournalRow:
    return JournalRow(7, kind, of, label, before, after, "2026-02-03", "0.2", {"s": 1})


def told(**values: Any) -> str:
    (line,) = outline([row(**values)])
    return line


TRACE = {"record": "trace", "name": "Anna", "notes": "", "vertices": [[1.5, 2.5, 3.5]]}


def test_a_line_begins_with_number_kind_time_and_version() -> None:
    assert told(kind="save") == "7 save, 2026-02-03, version 0.2"
    assert told(kind="undo", of=3).startswith("7 undo of 3, ")
    lines = outline([row("save"), row("redo", of=1)])
    assert [line.split(",")[0] for line in lines] == ["7 save", "7 redo of 1"]


@pytest.mark.parametrize(
    ("label", "said"),
    [
        ("Add bedding trace Anna's bed", "Add bedding trace …"),
        ("Delete 12 features", "Delete 12 features"),
        ("Move 1234 vertices", "Move … vertices"),
        ("Rename the trace Upper Cliff of Anna", "Rename the trace … of …"),
        ("Anna", "…"),
    ],
)
def test_outline_of_a_label_contains_only_known_words_and_small_numbers(
    label: str, said: str
) -> None:
    assert told(kind="undo", label=label) == f"7 undo, 2026-02-03, version 0.2; {said}"


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ({"t": None}, {"t": TRACE}, "trace added (name, notes, vertices)"),
        ({"t": TRACE}, {"t": None}, "trace removed"),
        ({}, {"t": TRACE}, "trace added (name, notes, vertices)"),
        (None, None, None),
        ({"t": TRACE}, {"t": TRACE | {"notes": "x", "new": 1}}, "trace changed (notes, new)"),
        ({"t": TRACE}, {"t": {"record": "trace"}}, "trace changed (name, notes, vertices)"),
        ({"t": {"notes": ""}}, {"t": {"notes": "x"}}, "unknown changed (notes)"),
        ({"t": None}, {"t": None}, "nothing"),
        ({"t": 5}, {"t": "x"}, "nothing"),
        ({"t": None}, {"t": {"record": "a name!", "b c": 1, "d": 2}}, "unknown added (unknown, d)"),
        ([1], "x", None),
    ],
)
def test_outline_of_a_record_contains_its_kind_and_field_names(
    before: Any, after: Any, said: str | None
) -> None:
    begin = "7 do, 2026-02-03, version 0.2"
    assert told(before=before, after=after) == (begin if said is None else f"{begin}; {said}")


def test_change_of_many_records_is_listed_once() -> None:
    before = dict.fromkeys("abc") | {"d": TRACE}
    line = told(before=before, after=dict.fromkeys("abc", TRACE) | {"d": None})
    made, gone = line.split("; ")[1:]
    count, *_, first, second, third = re.findall(r"\w+", made)
    assert (count, first, second, third) == ("3", "name", "notes", "vertices")
    assert gone == told(before={"t": TRACE}, after={"t": None}).split("; ")[1]


@pytest.mark.parametrize(
    ("after", "said"),
    [
        (None, "discarded"),
        ([1], "discarded"),
        ({}, "tool unknown, vertices 0"),
        ({"tool": "trace", "vertices": [[1, 2, 3], [4, 5, 6]]}, "tool trace, vertices 2"),
        ({"tool": "Anna's", "vertices": "abc"}, "tool unknown, vertices 0"),
    ],
)
def test_outline_of_a_draft_contains_its_tool_and_number_of_clicks(after: Any, said: str) -> None:
    assert told(kind="draft", after=after).split("; ")[1:] == [said]


def test_invalid_kind_is_listed_as_unknown() -> None:
    assert told(kind="Anna's bed").startswith("7 unknown,")
