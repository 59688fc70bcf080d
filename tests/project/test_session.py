"""One way in, one way to be told, and nothing that cannot be taken back."""

from __future__ import annotations

import dataclasses
import random

import numpy as np
import pytest

from tests.messages import refused
from tests.project.conftest import MODEL
from tests.samples import bed
from vomstudio.core.errors import DocumentError, GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geometry.frames import Frame
from vomstudio.project import edits
from vomstudio.project.journal.replay import replay
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.records import DEFAULT_TYPES, FeatureType, Model
from vomstudio.project.session import DISCARD_LABEL, RESTORE_TYPES_LABEL, Session


def test_edit_is_journalled_before_the_change_signal(session, journal):
    heard = []
    session.changed.connect(lambda edit: heard.append((edit.label, journal.kept[-1].label)))
    edit = edits.add_trace(session.records, bed("t1"))
    session.apply(edit)
    assert heard == [(edit.label, edit.label)]


def test_failed_journal_write_leaves_records_and_history_unchanged(session, journal):
    before, label = dict(session.records), session.undo_label
    journal.refuse = DocumentError(Finding("disk.full"))
    with refused("disk.full", DocumentError):
        session.apply(edits.add_trace(session.records, bed("t1")))
    assert dict(session.records) == before
    assert session.undo_label == label
    with refused("disk.full", DocumentError):
        session.undo()
    assert dict(session.records) == before


def test_stale_edit_is_rejected(session):
    session.apply(edits.add_trace(session.records, bed("t1")))
    rename = edits.set_attributes(session.records, ["t1"], name="X")
    session.apply(edits.set_attributes(session.records, ["t1"], notes="wet"))
    with refused("edit.stale", DocumentError):
        session.apply(rename)
    assert session.records["t1"].notes == "wet"


def test_undo_and_redo_restore_the_same_states(session):
    states = [dict(session.records)]
    for make in (
        lambda r: edits.add_trace(r, bed("t1")),
        lambda r: edits.add_trace(r, bed("t2")),
        lambda r: edits.set_attributes(r, ["t1", "t2"], set_name="S1"),
        lambda r: edits.declare_frame(r, "m1", Frame("crs", "EPSG:32633", 0.001, "y")),
        lambda r: edits.delete(r, ["t1"]),
    ):
        session.apply(make(session.records))
        states.append(dict(session.records))
    for state in reversed(states[:-1]):
        session.undo()
        assert dict(session.records) == state
    for state in states[1:]:
        session.redo()
        assert dict(session.records) == state
    assert session.redo_label is None


def test_new_edit_clears_the_redo_history(session):
    session.apply(edits.add_trace(session.records, bed("t1")))
    session.undo()
    session.apply(edits.add_trace(session.records, bed("t2")))
    assert session.redo_label is None
    session.redo()
    assert "t1" not in session.records


def test_reopened_journal_restores_records_and_undo_history(session, journal):
    session.apply(edits.add_trace(session.records, bed("t1")))
    session.apply(edits.add_trace(session.records, bed("t2")))
    session.undo()
    again = Session(journal)
    assert dict(again.records) == dict(session.records)
    again.redo()
    assert "t2" in again.records
    again.undo()
    again.undo()
    again.undo()
    assert [type(r).__name__ for r in again.records.values()].count("Model") == 0


def test_replay_up_to_any_journal_row_gives_the_records_at_that_time(session, journal):
    session.save()
    rng = random.Random(5)
    seen: dict[int, dict] = {}

    def note(*_):
        seen[len(journal.kept)] = dict(session.records)

    session.changed.connect(note)
    for number in range(120):
        traces = [r.id for r in session.of(Trace)]
        choice = rng.random()
        if choice < 0.4 or not traces:
            session.apply(edits.add_trace(session.records, bed(f"t{number}", rng.random())))
        elif choice < 0.55:
            session.apply(edits.delete(session.records, [rng.choice(traces)]))
        elif choice < 0.7:
            session.apply(
                edits.set_attributes(session.records, [rng.choice(traces)], notes=str(number))
            )
        elif choice < 0.85:
            if session.undo_label != "Open model cliff":
                session.undo()
        elif choice < 0.95:
            session.redo()
        elif choice < 0.98:
            session.save()
        elif session.dirty:
            session.discard_unsaved()
    assert len(seen) > 80
    for rows, records in seen.items():
        assert replay(journal.kept[:rows]).records == records


def test_discarding_unsaved_edits_restores_the_save_and_can_be_undone(session):
    session.apply(edits.add_trace(session.records, bed("t1")))
    session.save()
    session.apply(edits.add_trace(session.records, bed("t2")))
    session.apply(edits.delete(session.records, ["t1"]))
    assert session.dirty
    session.discard_unsaved()
    assert not session.dirty
    assert {"t1"} == {t.id for t in session.of(Trace)}
    session.undo()
    assert {"t2"} == {t.id for t in session.of(Trace)}
    assert session.dirty


def test_undoing_to_the_saved_state_clears_dirty(session):
    session.save()
    session.apply(edits.add_trace(session.records, bed("t1")))
    assert session.dirty
    session.undo()
    assert not session.dirty


def test_draft_is_restored_until_it_is_finished_or_cancelled(session, journal):
    session.set_draft({"tool": "trace", "vertices": [[0, 0, 0]]})
    assert Session(journal).draft.state["vertices"] == [[0, 0, 0]]
    session.apply(edits.add_trace(session.records, bed("t1")), finishes_draft=True)
    assert Session(journal).draft is None
    session.set_draft({"tool": "trace"})
    session.set_draft(None)
    assert Session(journal).draft is None


def test_damaged_row_is_reported_and_the_others_are_read(session, journal):
    session.apply(edits.add_trace(session.records, bed("t1")))
    session.apply(edits.add_trace(session.records, bed("t2")))
    bad = next(i for i, row in enumerate(journal.kept) if row.after and "t1" in row.after)
    journal.kept[bad] = dataclasses.replace(journal.kept[bad], after={"t1": {"kind": "?"}})
    again = Session(journal)
    assert "t2" in again.records
    assert "t1" not in again.records
    assert any(each.code == "journal.row-unreadable" for each in again.problems)


def test_trace_with_collinear_points_is_rejected(session):
    line = bed("t1", vertices=tuple((float(i), 2.0 * i, 3.0 * i) for i in range(5)))
    with pytest.raises(GeometryError):
        edits.add_trace(session.records, line)


def test_model_with_features_cannot_be_removed(session):
    session.apply(edits.add_trace(session.records, bed("t1")))
    with refused("model.in-use", DocumentError, count=1, model="cliff"):
        edits.remove_model(session.records, "m1")


def test_new_name_continues_after_the_highest_number(session):
    for id_ in ("t1", "t2", "t3"):
        session.apply(edits.add_trace(session.records, bed(id_)))
    session.apply(edits.delete(session.records, ["t2"]))
    session.apply(edits.add_trace(session.records, bed("t4")))
    assert [t.name for t in session.of(Trace)] == ["B01", "B03", "B04"]


def test_declaring_a_frame_moves_the_features_with_the_model(session):
    from vomstudio.project.measurement_cache import Measurements

    session.apply(edits.add_trace(session.records, bed("t1")))
    measurements = Measurements()
    before = measurements.of(session.records, ["t1"])["t1"]
    session.apply(edits.declare_frame(session.records, "m1", Frame("local", None, 0.001, "z")))
    after = measurements.of(session.records, ["t1"])["t1"]
    np.testing.assert_allclose(after.points, before.points * 0.001, rtol=1e-12)
    assert after.fit.dip_deg == pytest.approx(before.fit.dip_deg, abs=1e-9)
    assert after.fit.extent == pytest.approx(before.fit.extent * 0.001)
    # Y up: what was North is now the far side of down.
    session.apply(edits.declare_frame(session.records, "m1", Frame("local", None, 1.0, "y")))
    turned = measurements.of(session.records, ["t1"])["t1"]
    np.testing.assert_allclose(turned.points[:, 2], before.points[:, 1])
    np.testing.assert_allclose(turned.points[:, 1], -before.points[:, 2])


# --- opening ---------------------------------------------------------------------------------
def label_of(rows):
    return [(row.kind, row.label) for row in rows]


def test_new_project_has_default_types_and_nothing_to_save_or_undo(journal):
    session = Session(journal)
    assert label_of(journal.kept) == [("do", "New project"), ("save", "")]
    assert session.of(FeatureType) == list(DEFAULT_TYPES)
    assert (session.dirty, session.is_recovered, session.problems) == (False, False, ())
    assert session.undo_label is session.redo_label is session.draft is None
    assert dict(session.saved_records) == dict(session.records)
    session.undo()
    session.redo()
    assert len(journal.kept) == 2
    assert Session(journal).top == session.top == session.saved_top == 1
    assert len(journal.kept) == 2


def test_unsaved_work_is_reported_as_recovered_until_saved_or_discarded(session, journal):
    """The window asks whether to keep what a crash has left behind."""
    session.save()
    session.apply(edits.add_trace(session.records, bed("t1")))
    assert not session.is_recovered
    for end in (Session.save, Session.discard_unsaved):
        again = Session(journal)
        assert again.is_recovered
        end(again)
        assert not again.is_recovered
        assert not Session(journal).is_recovered
        again.apply(edits.add_trace(again.records, bed(f"n{again.top}")))
    # What was undone past the save is unsaved work as well.
    again = Session(journal)
    again.save()
    again.undo()
    assert Session(journal).is_recovered


def test_lost_default_types_are_restored_permanently(session, journal):
    session.apply(edits.add_trace(session.records, bed("t1")))
    session.save()
    journal.kept[0] = dataclasses.replace(journal.kept[0], problem=Finding("row.checksum"))
    again = Session(journal)
    assert again.undo_label == RESTORE_TYPES_LABEL
    assert again.of(FeatureType) == list(DEFAULT_TYPES)
    assert len(again.problems) == 1
    assert again.records["t1"] == session.records["t1"]
    again.apply(edits.add_trace(again.records, bed("t2")))
    again.discard_unsaved()
    assert again.of(FeatureType) == list(DEFAULT_TYPES)
    assert "t2" not in again.records
    assert len(Session(journal).of(FeatureType)) == len(DEFAULT_TYPES)


def test_damaged_project_without_records_is_not_treated_as_new(session, journal):
    """What was done and taken out again can still be brought back."""
    session.apply(edits.remove_model(session.records, "m1"))
    journal.kept[0] = dataclasses.replace(journal.kept[0], problem=Finding("row.checksum"))
    again = Session(journal)
    assert again.undo_label == RESTORE_TYPES_LABEL
    assert again.dirty
    again.undo()
    again.undo()
    assert again.records["m1"] == MODEL
    assert "New project" not in [row.label for row in journal.kept[1:]]


def test_discarding_unsaved_edits_reverts_type_changes(session):
    session.save()
    session.apply(edits.add_type(session.records, FeatureType("dyke", "Dyke", "#123456")))
    red = dataclasses.replace(DEFAULT_TYPES[0], color="#ff0000")
    session.apply(edits.change_type(session.records, red))
    session.discard_unsaved()
    assert session.of(FeatureType) == list(DEFAULT_TYPES)


def test_records_of_a_class_are_returned_in_insertion_order(session):
    for id_ in ("t2", "t1"):
        session.apply(edits.add_trace(session.records, bed(id_)))
    reading = Reading("r1", "R1", "bedding", "plane", 10.0, 20.0)
    session.apply(edits.add_features(session.records, [reading]))
    assert [f.id for f in session.features()] == ["t2", "t1", "r1"]
    assert [t.id for t in session.of(Trace)] == ["t2", "t1"]
    assert [m.id for m in session.of(Model)] == ["m1"]


def test_has_ever_contained_includes_undone_records(session, journal):
    assert session.has_ever_contained(Model)
    assert not session.has_ever_contained(Trace)
    session.apply(edits.add_trace(session.records, bed("t1")))
    assert session.has_ever_contained(Trace)
    assert session.has_ever_contained(Reading, Trace)
    session.undo()
    assert session.has_ever_contained(Trace)
    assert Session(journal).has_ever_contained(Trace)
    assert not session.has_ever_contained(Reading)


def test_records_and_history_are_read_only_outside_the_session(session):
    label = session.undo_label
    for mapping in (session.records, session.saved_records):
        with pytest.raises(TypeError):
            mapping["t1"] = bed("t1")
    for steps in (session.done_steps(), session.undone_steps()):
        steps.clear()
    assert session.undo_label == label


# --- steps -----------------------------------------------------------------------------------
class Heard:
    """What listeners are told, in order."""

    def __init__(self, session: Session) -> None:
        self.told = []
        session.changed.connect(lambda edit: self.told.append(edit))
        session.history_changed.connect(lambda _: self.told.append("history"))

    def since(self):
        told, self.told = self.told, []
        return told


def test_each_step_is_signalled_once_with_its_edit(session):
    heard = Heard(session)
    add = edits.add_trace(session.records, bed("t1"))
    session.apply(add)
    assert heard.since() == [add, "history"]
    session.undo()
    assert heard.since() == [add.inverse(), "history"]
    session.redo()
    assert heard.since() == [add, "history"]
    session.save()
    assert heard.since() == ["history"]
    session.apply(edits.add_trace(session.records, bed("t2")))
    session.save()
    heard.since()
    session.apply(edits.delete(session.records, ["t1"]))
    heard.since()
    session.discard_unsaved()
    edit, history = heard.since()
    assert history == "history"
    assert edit.label == session.undo_label == DISCARD_LABEL
    assert set(edit.after) == {"t1"}
    session.undo()
    session.undo()
    heard.since()
    while session.undo_label:
        session.undo()
    heard.since()
    session.undo()
    assert heard.since() == []


def test_journal_rows_reference_the_undone_or_redone_step(session, journal):
    one = edits.add_trace(session.records, bed("t1"))
    first = session.apply(one)
    other = edits.add_trace(session.records, bed("t2"))
    second = session.apply(other)
    assert (first, second) == (session.top - 1, session.top)
    session.undo()
    session.undo()
    session.redo()
    rows = [(row.kind, row.of_seq, row.label) for row in journal.kept[-3:]]
    assert rows == [
        ("undo", second, other.label),
        ("undo", first, one.label),
        ("redo", first, one.label),
    ]
    assert (session.undo_label, session.redo_label) == (one.label, other.label)
    assert [seq for seq, _ in session.done_steps()][-1] == first
    assert [seq for seq, _ in session.undone_steps()] == [second]
    again = Session(journal)
    assert again.done_steps() == session.done_steps()
    assert again.undone_steps() == session.undone_steps()


def test_settings_that_affect_results_are_stored_with_every_edit(journal):
    settings = {"good": 5.0}
    session = Session(journal, lambda: dict(settings))
    settings["good"] = 7.0
    session.apply(edits.add_model(session.records, MODEL))
    written = [row.settings for row in journal.kept if row.kind == "do"]
    assert written == [{"good": 5.0}, {"good": 7.0}]
    assert replay(journal.kept).settings == {"good": 7.0}


def test_consecutive_nudges_join_into_one_step(session, journal):
    def note(text: str, joins: int | None = None) -> int:
        return session.apply(edits.set_attributes(session.records, ["t1"], notes=text), joins=joins)

    session.apply(edits.add_trace(session.records, bed("t1")))
    steps = len(session.done_steps())
    at = note("1")
    at = note("2", at)
    at = note("3", at)
    assert len(session.done_steps()) == steps + 1
    assert [row.kind for row in journal.kept[-3:]] == ["do", "amend", "amend"]
    assert Session(journal).done_steps() == session.done_steps()
    session.undo()
    assert session.records["t1"].notes == ""
    session.redo()
    assert session.records["t1"].notes == "3"
    # A save is never taken back along with a nudge.
    session.save()
    later = note("4", at)
    assert len(session.done_steps()) == steps + 2
    session.undo()
    assert (session.records["t1"].notes, session.dirty) == ("3", False)
    # Nor is a step that is not the newest any more joined.
    newest = note("5")
    note("6", later)
    assert session.done_steps()[-2][0] == newest
    assert Session(journal).done_steps() == session.done_steps()


def test_save_records_the_state_at_that_time(session, journal):
    session.apply(edits.add_trace(session.records, bed("t1")))
    session.save()
    at, kept = session.top, dict(session.records)
    assert journal.kept[-1].kind == "save"
    session.apply(edits.delete(session.records, ["t1"]))
    assert (session.saved_top, dict(session.saved_records), session.dirty) == (at, kept, True)
    again = Session(journal)
    assert (again.saved_top, dict(again.saved_records), again.dirty) == (at, kept, True)
    again.discard_unsaved()
    assert [row.kind for row in journal.kept[-2:]] == ["discard", "save"]
    assert again.saved_top == again.top != at
    assert dict(again.saved_records) == dict(again.records) == kept
    assert not Session(journal).dirty


# --- drafts and journals ---------------------------------------------------------------------
def test_edit_references_the_draft_that_it_finishes(session, journal):
    state = {"tool": "trace"}
    session.set_draft(state)
    seq = session.draft.seq
    state["tool"] = "line"
    assert session.draft.state == {"tool": "trace"}
    assert (journal.kept[-1].kind, len(journal.kept)) == ("draft", seq)
    session.apply(edits.add_trace(session.records, bed("t1")))
    assert (journal.kept[-1].of_seq, session.draft.seq) == (None, seq)
    session.apply(edits.add_trace(session.records, bed("t2")), finishes_draft=True)
    assert (journal.kept[-1].of_seq, session.draft) == (seq, None)
    session.apply(edits.add_trace(session.records, bed("t3")), finishes_draft=True)
    assert journal.kept[-1].of_seq is None


def test_draft_survives_other_edits_undo_and_discard(session, journal):
    session.set_draft({"tool": "trace"})
    session.apply(edits.add_trace(session.records, bed("t1")))
    session.apply(edits.add_trace(session.records, bed("t2")))
    session.undo()
    session.discard_unsaved()
    assert session.draft.state == Session(journal).draft.state == {"tool": "trace"}


def test_cancelling_without_a_draft_writes_nothing(session, journal):
    rows = len(journal.kept)
    session.set_draft(None)
    assert len(journal.kept) == rows
    session.set_draft({"tool": "trace"})
    session.set_draft(None)
    assert session.draft is None
    assert [row.after for row in journal.kept[rows:]] == [{"tool": "trace"}, None]


def test_session_continues_in_a_journal_with_renumbered_rows(session, journal):
    """A project saved elsewhere is written shorter, without what was amended or left."""
    session.apply(edits.add_trace(session.records, bed("t1")))
    session.save()
    session.apply(edits.add_trace(session.records, bed("t2")))
    session.undo()
    session.set_draft({"tool": "trace"})
    numbers = {row.seq: row.seq + 100 for row in journal.kept}
    other = type(journal)()
    other.kept = [
        dataclasses.replace(row, seq=numbers[row.seq], of_seq=numbers.get(row.of_seq))
        for row in journal.kept
    ]
    done, undone = session.done_steps(), session.undone_steps()
    assert session.use_journal(other, numbers) is journal
    assert session.done_steps() == [(seq + 100, edit) for seq, edit in done]
    assert session.undone_steps() == [(seq + 100, edit) for seq, edit in undone]
    assert session.draft.seq == numbers[len(journal.kept)]
    assert session.draft.state == {"tool": "trace"}
    assert not session.dirty
    rows = len(journal.kept)
    session.redo()
    assert len(journal.kept) == rows
    assert (other.kept[-1].kind, other.kept[-1].of_seq) == ("redo", undone[0][0] + 100)
    assert Session(other).records == session.records


def test_session_continues_in_a_journal_with_the_same_row_numbers(session, journal):
    other = type(journal)()
    other.kept = list(journal.kept)
    before = session.done_steps(), session.saved_top
    assert session.use_journal(other) is journal
    assert (session.done_steps(), session.saved_top) == before
    session.save()
    assert len(other.kept) == len(journal.kept) + 1


def test_closing_a_session_closes_its_journal(session, journal, monkeypatch):
    closed = []
    monkeypatch.setattr(journal, "close", lambda: closed.append(True))
    session.close()
    assert closed == [True]
