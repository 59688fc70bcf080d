"""Records and edits as plain values and back, and journals played from their first row."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import pytest

from tests.messages import refused
from tests.project.test_edits import FEATURES, LINE, MEETING, MODEL, PATCH, READING, TRACE
from vomstudio.core.errors import DocumentError
from vomstudio.core.findings import Finding
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.registrations import NorthReference, Registration
from vomstudio.project.codec import decode, decode_edit, encode, encode_edit
from vomstudio.project.edit import Edit, change
from vomstudio.project.journal.replay import JournalRow, replay
from vomstudio.project.kinds.known_line import KnownLine
from vomstudio.project.records import (
    DEFAULT_TYPES,
    Asset,
    Compass,
    Group,
    ImageMark,
    MarkedPoint,
    Mask,
    PhotoSet,
    ReconstructionRecord,
    Record,
)

BY = Registration("g1", "control", "control", Frame("crs", "EPSG:32633"))
PLACED = replace(MODEL, id="m2", placement=BY)
EVERY: tuple[Record, ...] = (
    *FEATURES,
    MODEL,
    DEFAULT_TYPES[6],
    BY,
    replace(
        BY, id="g2", read_north=NorthReference("magnetic", 3.25, 3.5, False, "2024-05-12", 0.5)
    ),
    Compass("compass-m1", "m1", "magnetic", "2024-05-12", (11.35, 46.5), None, 0.5),
    KnownLine(
        "w2", "B01", "plane", "m1", "0" * 64, (), 213.0, 3.0, inclination_deg=45.0, feature_id="t1"
    ),
    PhotoSet("s1", "photos", "photos", "EPSG:32633"),
    Mask("k1", "s1", "1.jpg", Asset("masks/a.png", 10)),
    MarkedPoint("q1", "s1", "A", (1.0, 2.0, 3.0), 0.01, True),
    ImageMark("i9", "q1", "1.jpg", 1.5, 2.5),
    ReconstructionRecord(
        "c1", "s1", "cliff", "cliff", "low", "0" * 64, (("a", "b"),), 3, 2, 0.5, "4", "x"
    ),
)


def by_json(plain: Any) -> Any:
    return json.loads(json.dumps(plain))


@pytest.mark.parametrize("record", EVERY, ids=lambda r: type(r).__name__)
def test_every_record_survives_json(record: Record) -> None:
    assert decode(by_json(encode(record))) == record


def test_a_placement_by_registration_is_written_as_its_id() -> None:
    plain = by_json(encode(PLACED))
    assert plain["placement"] == {"registration": "g1"}
    assert decode(plain, {"g1": BY}) == PLACED
    for there in ({}, {"g1": MODEL}):
        with refused("record.missing", DocumentError, kind="registration"):
            decode(plain, there)


@pytest.mark.parametrize(
    ("change_", "code", "values"),
    [
        ({"record": "dyke"}, "record.unknown-kind", {"kind": "dyke", "field": "record"}),
        ({"record": None}, "record.unknown-kind", {"kind": None}),
        ({"record": ["trace"]}, "record.unknown-kind", {"kind": ("trace",)}),
        ({"colour": 1}, "record.unknown-field", {"kind": "intersection", "field": "colour"}),
        ({"first": 7}, "record.wrong-value", {"field": "first"}),
        ({"first": {"feature": "t1"}}, "record.unknown-field", {"field": "feature"}),
    ],
)
def test_unreadable_record_is_reported(
    change_: dict[str, Any], code: str, values: dict[str, Any]
) -> None:
    with refused(code, DocumentError, **values):
        decode(by_json(encode(MEETING)) | change_)
    plain = encode(MEETING)
    del plain["first"]
    with refused("record.missing-field", DocumentError):
        decode(plain)


# Edits


START = {r.id: r for r in EVERY}


@pytest.mark.parametrize(
    "after",
    [
        {"t1": replace(TRACE, notes="wet", set_name="S1")},
        {"i1": replace(MEETING, second=Group("", "fault", "S1"))},
        {"m1": replace(MODEL, placement=Frame("scaled", None, 2.0, "y"))},
        {"m1": replace(MODEL, placement=BY)},
        {"m2": PLACED, "t1": None, "new": replace(READING, id="new")},
        {"m1": replace(MODEL, placement=replace(BY, id="g2")), "g2": replace(BY, id="g2")},
        {"m2": replace(MODEL, id="m2", placement=replace(BY, id="g2")), "g2": replace(BY, id="g2")},
        {"p1": replace(TRACE, id="p1")},
    ],
)
def test_edit_survives_json(after: dict[str, Record | None]) -> None:
    edit = change(START, "Do", after)
    before, made = by_json(encode_edit(edit))
    back = decode_edit("Do", before, made, START)
    assert back == edit
    assert list(back.after) == list(edit.after)


def test_only_changed_fields_of_a_record_are_written() -> None:
    edit = change(START, "Do", {"t1": replace(TRACE, notes="wet"), "p1": None})
    before, after = encode_edit(edit)
    assert before["t1"] == {"notes": ""}
    assert after["t1"] == {"notes": "wet"}
    assert before["p1"] == encode(PATCH)
    assert after["p1"] is None
    whole = encode_edit(change(START, "Do", {"p1": replace(TRACE, id="p1")}))
    assert whole[1]["p1"]["record"] == "trace"


def test_change_of_a_missing_record_is_reported() -> None:
    _, after = encode_edit(change(START, "Do", {"t1": replace(TRACE, notes="wet")}))
    with refused("record.without-base", DocumentError, record="t1"):
        decode_edit("Do", {}, after, {})
    with refused("record.unknown-field", DocumentError):
        decode_edit("Do", {}, {"t1": {"colour": 1}}, START)


# Journals


class Played:
    """Rows as a session writes them."""

    def __init__(self) -> None:
        self.rows: list[JournalRow] = []
        self.records: dict[str, Record] = {}

    def row(self, kind: str, of: int | None = None, edit: Edit | None = None, **more: Any) -> int:
        before, after = (None, None) if edit is None else by_json(encode_edit(edit))
        seq = len(self.rows) + 1
        given = {"before": before, "after": after, "settings": None} | more
        label = "" if edit is None else edit.label
        self.rows.append(
            JournalRow(seq, kind, of, label, time="", version="", **given)  # type: ignore[arg-type]
        )
        return seq

    def do(self, after: dict[str, Record | None], kind: str = "do", **more: Any) -> int:
        edit = change(self.records, f"Do {len(self.rows) + 1}", after)
        edit.swap(self.records)
        return self.row(kind, edit=edit, **more)


def test_journal_is_replayed_with_undo_and_redo() -> None:
    played = Played()
    first = played.do({"t1": TRACE}, settings={"a": 1})
    played.row("save")
    second = played.do({"t1": replace(TRACE, notes="x")}, settings={"a": 2})
    third = played.do({"p1": PATCH})
    played.row("undo", third)
    played.row("undo", second)
    found = replay(played.rows)
    assert found.records == {"t1": TRACE} == found.saved_records
    assert [seq for seq, _ in found.done] == [first]
    assert [seq for seq, _ in found.undone] == [third, second]
    assert (found.top, found.saved_top) == (first, first)
    assert found.settings == {"a": 2}
    assert found.problems == []
    played.row("redo", second)
    found = replay(played.rows)
    assert found.records == {"t1": replace(TRACE, notes="x")}
    assert [seq for seq, _ in found.undone] == [third]
    assert found.top == second
    assert replay([]).top == 0


def test_new_step_clears_the_redo_steps() -> None:
    for kind in ("do", "discard"):
        played = Played()
        played.do({"t1": TRACE})
        last = played.do({"p1": PATCH})
        played.row("undo", last)
        del played.records["p1"]
        played.do({"l1": LINE}, kind)
        found = replay(played.rows)
        assert found.undone == []
        assert set(found.records) == {"t1", "l1"}


def test_amended_step_is_merged_with_the_previous_one() -> None:
    played = Played()
    played.do({"t1": TRACE})
    nudged = played.do({"t1": replace(TRACE, notes="1")})
    again = played.do({"t1": replace(TRACE, notes="2")}, "amend", of=nudged)
    found = replay(played.rows)
    assert [seq for seq, _ in found.done] == [1, again]
    assert found.done[-1][1].before == {"t1": TRACE}
    assert found.done[-1][1].after == {"t1": replace(TRACE, notes="2")}
    # Where the row before it is damaged it stands for itself.
    played.rows[1] = replace(played.rows[1], problem=Finding("row.checksum"))
    found = replay(played.rows)
    assert [seq for seq, _ in found.done] == [1, again]
    assert found.records["t1"] == replace(TRACE, notes="2")


def test_amendment_of_a_lost_step_becomes_a_separate_step() -> None:
    played = Played()
    moved = played.do({"t1": TRACE})
    played.do({"t1": replace(TRACE, notes="1")}, "amend", of=moved)
    before, after = encode_edit(change({}, "Nudge", {"t1": replace(TRACE, notes="1")}))
    played.rows[0] = replace(played.rows[0], problem=Finding("row.checksum"))
    played.rows[1] = replace(played.rows[1], before=by_json(before), after=by_json(after))
    found = replay(played.rows)
    assert [seq for seq, _ in found.done] == [2]
    assert found.records == {"t1": replace(TRACE, notes="1")}
    assert len(found.problems) == 1


def test_unsaved_project_has_no_save_to_return_to() -> None:
    played = Played()
    played.do({"t1": TRACE})
    found = replay(played.rows)
    assert (found.saved_records, found.saved_top, found.top) == ({}, 0, 1)


def test_drafts_are_kept_until_finished_or_discarded() -> None:
    played = Played()
    draft = played.row("draft", after={"clicks": 3})
    found = replay(played.rows)
    assert found.draft is not None
    assert (found.draft.seq, found.draft.state) == (draft, {"clicks": 3})
    played.do({"p1": PATCH})
    assert replay(played.rows).draft is not None
    played.do({"t1": TRACE}, of=draft)
    assert replay(played.rows).draft is None
    played.row("draft", after={"clicks": 1})
    played.row("draft")
    assert replay(played.rows).draft is None


def test_damaged_row_is_reported_and_skipped_together_with_its_undo() -> None:
    played = Played()
    played.do({"t1": TRACE})
    lost = played.do({"p1": PATCH})
    kept = played.do({"l1": LINE})
    played.rows[1] = replace(played.rows[1], problem=Finding("row.checksum"))
    found = replay(played.rows)
    assert set(found.records) == {"t1", "l1"}
    (problem,) = found.problems
    assert problem.code == "journal.row-unreadable"
    assert problem.values["reason_code"] == "row.checksum"
    assert (problem.values["row"], problem.values["kind"]) == (2, "do")
    assert problem.values["label"] == "Do 2"
    played.row("undo", lost)
    found = replay(played.rows)
    assert found.problems[-1].values["reason_code"] == "row.target-missing"
    assert f"row {lost}" in found.problems[-1].message
    assert found.top == kept
    played.row("undo", 1)
    found = replay(played.rows)
    assert found.records == {}
    assert [seq for seq, _ in found.undone] == [kept, 1]


def test_gaps_and_rows_of_unknown_kind_are_reported() -> None:
    played = Played()
    played.do({"t1": TRACE})
    gap = Finding("journal.rows-missing", count=3, first=2, last=4)
    played.row("gap", notice=gap)
    played.row("vote")
    found = replay(played.rows)
    assert found.problems[0] == gap
    assert found.problems[1].values["reason_code"] == "row.unknown-kind"
    assert len(found.problems) == 2
    assert found.records == {"t1": TRACE}


def test_placement_that_is_not_a_registration_id_is_rejected() -> None:
    """Such as an object, which cannot be a key."""
    plain = encode(PLACED) | {"placement": {"registration": {"a": {"b": {}}}}}
    with refused("record.missing", DocumentError, kind="registration", field="placement"):
        decode(plain)
