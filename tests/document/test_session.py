"""One way in, one way to be told, and nothing that cannot be taken back."""

from __future__ import annotations

import dataclasses
import random

import numpy as np
import pytest

from tests.samples import bed
from vomstudio.document import edits
from vomstudio.document.journal import replay
from vomstudio.document.kinds.trace import Trace
from vomstudio.document.records import Frame
from vomstudio.document.session import Session
from vomstudio.errors import DocumentError, GeometryError


def test_an_edit_is_in_the_journal_before_anyone_hears_of_it(session, journal):
    heard = []
    session.changed.connect(lambda edit: heard.append((edit.label, journal.kept[-1].label)))
    session.apply(edits.add_trace(session.records, bed("t1")))
    assert heard == [("Add bedding trace B01", "Add bedding trace B01")]


def test_a_journal_that_cannot_be_written_leaves_everything_as_it_was(session, journal):
    before = dict(session.records)
    journal.refuse = DocumentError("disk full")
    with pytest.raises(DocumentError, match="disk full"):
        session.apply(edits.add_trace(session.records, bed("t1")))
    assert dict(session.records) == before
    assert session.undo_label == "Open model cliff"
    with pytest.raises(DocumentError, match="disk full"):
        session.undo()
    assert dict(session.records) == before


def test_an_edit_made_on_other_records_is_refused(session):
    session.apply(edits.add_trace(session.records, bed("t1")))
    rename = edits.set_attributes(session.records, ["t1"], name="X")
    session.apply(edits.set_attributes(session.records, ["t1"], notes="wet"))
    with pytest.raises(DocumentError, match="has changed"):
        session.apply(rename)
    assert session.records["t1"].notes == "wet"


def test_undo_and_redo_walk_through_the_same_states(session):
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


def test_a_new_edit_forgets_what_was_undone(session):
    session.apply(edits.add_trace(session.records, bed("t1")))
    session.undo()
    session.apply(edits.add_trace(session.records, bed("t2")))
    assert session.redo_label is None
    session.redo()
    assert "t1" not in session.records


def test_a_reopened_journal_has_the_records_and_the_way_back(session, journal):
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


def test_at_every_row_of_a_random_session_the_journal_tells_what_was_on_the_screen(
    session, journal
):
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


def test_discarding_goes_back_to_the_save_and_can_be_taken_back(session):
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


def test_undoing_back_to_the_save_is_not_a_change(session):
    session.save()
    session.apply(edits.add_trace(session.records, bed("t1")))
    assert session.dirty
    session.undo()
    assert not session.dirty


def test_a_draft_is_offered_back_until_it_is_finished_or_cancelled(session, journal):
    session.set_draft({"tool": "trace", "vertices": [[0, 0, 0]]})
    assert Session(journal).draft.state["vertices"] == [[0, 0, 0]]
    session.apply(edits.add_trace(session.records, bed("t1")), finishes_draft=True)
    assert Session(journal).draft is None
    session.set_draft({"tool": "trace"})
    session.set_draft(None)
    assert Session(journal).draft is None


def test_a_damaged_row_is_named_and_the_rest_opens(session, journal):
    session.apply(edits.add_trace(session.records, bed("t1")))
    session.apply(edits.add_trace(session.records, bed("t2")))
    bad = next(i for i, row in enumerate(journal.kept) if row.after and "t1" in row.after)
    journal.kept[bad] = dataclasses.replace(journal.kept[bad], after={"t1": {"kind": "?"}})
    again = Session(journal)
    assert "t2" in again.records
    assert "t1" not in again.records
    assert any("row" in problem for problem in again.problems)


def test_a_trace_through_collinear_points_is_refused(session):
    line = bed("t1", vertices=tuple((float(i), 2.0 * i, 3.0 * i) for i in range(5)))
    with pytest.raises(GeometryError):
        edits.add_trace(session.records, line)


def test_a_model_that_carries_features_is_not_removed(session):
    session.apply(edits.add_trace(session.records, bed("t1")))
    with pytest.raises(DocumentError, match="carries 1 feature"):
        edits.remove_model(session.records, "m1")


def test_names_take_the_next_free_number(session):
    for id_ in ("t1", "t2", "t3"):
        session.apply(edits.add_trace(session.records, bed(id_)))
    session.apply(edits.delete(session.records, ["t2"]))
    session.apply(edits.add_trace(session.records, bed("t4")))
    assert [t.name for t in session.of(Trace)] == ["B01", "B03", "B04"]


def test_declaring_a_frame_moves_the_features_with_the_model(session):
    from vomstudio.document.measurements import Measurements

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
