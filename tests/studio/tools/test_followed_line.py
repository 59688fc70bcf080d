"""A trace that follows a contact: way-points, and the pieces between them as they come."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.messages import shown_codes, shown_values
from tests.project.conftest import MODEL, MemoryJournal
from tests.studio.tools.fakes import Context, event
from vomstudio.core.findings import Finding
from vomstudio.project import edits
from vomstudio.project.journal.replay import replay
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.session import Session
from vomstudio.studio.tools.followed_line import FollowedPath
from vomstudio.studio.tools.following import UNDO_LABELS
from vomstudio.studio.tools.interaction_types import Pointer
from vomstudio.studio.tools.trace import TraceTool

A, B, C = (0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (2.0, 2.0, 0.5)


@pytest.fixture
def context() -> Context:
    session = Session(MemoryJournal())
    session.apply(edits.add_model(session.records, MODEL))
    return Context(session, session._journal)


@pytest.fixture
def tool(context) -> TraceTool:
    made = TraceTool(context)
    made.follow("dark")
    return made


def bowed(ends) -> np.ndarray:
    """A way between two places with a bend in its middle."""
    one, other = map(np.asarray, ends)
    t = np.linspace(0.0, 1.0, 9)[:, None]
    return one + (other - one) * t + np.array([0.0, 0.0, 1.6]) * t * (1.0 - t)


def answer_all(context) -> None:
    asked, context.paths.asked = context.paths.asked, []
    for _, _, ends, _, callback in asked:
        callback(FollowedPath(bowed(ends)))


def clicks(tool, *points) -> None:
    for point in points:
        tool.pointer(event(at=point))


def test_verdict_is_shown_only_after_the_path_arrives(tool, context):
    clicks(tool, A, B, C)
    assert tool.is_searching
    assert shown_codes(context.shown[-1].reading[-1]) == {"follow.searching"}
    assert context.shown[-1].verdict is None
    answer_all(context)
    assert context.shown[-1].verdict is not None


def test_finished_trace_has_all_path_vertices_and_notes_its_way_points(tool, context):
    clicks(tool, A, B, C)
    assert tool.is_searching
    answer_all(context)
    assert not tool.is_searching
    assert context.shown[-1].line.shape == (3, 3)
    assert context.shown[-1].path.shape == (17, 3)
    tool.finish()
    (trace,) = context.session.of(Trace)
    assert len(trace.vertices) == 17
    assert trace.vertices[0] == A
    assert trace.vertices[-1] == C
    assert "3 way-points" in trace.notes


def test_measurement_uses_the_whole_path(tool, context):
    clicks(tool, A, B, C)
    answer_all(context)
    assert tool.measurement.fit.n == 17


def test_path_is_requested_once(tool, context):
    clicks(tool, A, B)
    tool.pointer(event(Pointer.MOVE))
    tool.pointer(event(Pointer.MOVE))
    assert len(context.paths.asked) == 1


def test_path_to_the_cursor_is_shown_before_the_click(tool, context):
    clicks(tool, A)
    tool.pointer(event(Pointer.MOVE, at=B))
    ((_, cost, ends, live, callback),) = context.paths.asked
    assert (cost, ends, live) == ("dark", (A, B), True)
    callback(FollowedPath(bowed(ends)))
    assert np.allclose(context.shown[-1].ahead, bowed((A, B)))
    # The click takes it as it is.
    clicks(tool, B)
    assert not tool.is_searching


def test_path_to_an_older_cursor_position_is_ignored(tool, context):
    clicks(tool, A)
    tool.pointer(event(Pointer.MOVE, at=B))
    tool.pointer(event(Pointer.MOVE, at=C))
    (_, _, first, _, late), (_, _, second, _, callback) = context.paths.asked
    shown = len(context.shown)
    late(FollowedPath(bowed(first)))
    assert len(context.shown) == shown
    callback(FollowedPath(bowed(second)))
    assert np.allclose(context.shown[-1].ahead, bowed(second))


def test_dragging_a_way_point_updates_its_paths_and_can_be_undone(tool, context):
    clicks(tool, A, B, C)
    answer_all(context)
    before = context.shown[-1].path
    tool.pointer(event(Pointer.DRAG_START, at=B, handle=1))
    tool.pointer(event(Pointer.DRAG_MOVE, at=(2.0, 1.0, 0.0)))
    answer_all(context)
    tool.pointer(event(Pointer.DRAG_END, at=(2.0, 1.0, 0.0)))
    answer_all(context)
    assert not tool.is_searching
    assert len(tool.vertices) == 3
    assert not np.array_equal(context.shown[-1].path, before)
    assert tool.undo()
    assert np.array_equal(context.shown[-1].path, before)


def test_trace_finished_during_a_search_is_added_when_the_path_arrives(tool, context):
    clicks(tool, A, B, C)
    assert tool.finish() is None
    assert not context.session.of(Trace)
    answer_all(context)
    (trace,) = context.session.of(Trace)
    assert len(trace.vertices) == 17
    assert not tool.is_open


def test_missing_path_is_reported_and_replaced_by_a_straight_segment(tool, context):
    clicks(tool, A, B)
    ((_, _, _, _, callback),) = context.paths.asked
    callback(Finding("model.not-open"))
    assert context.said[-1].code == "model.not-open"
    assert not tool.is_searching
    assert np.array_equal(context.shown[-1].path, [A, B])


def test_paths_of_a_cancelled_trace_are_ignored(tool, context):
    clicks(tool, A, B)
    tool.cancel()
    shown = len(context.shown)
    answer_all(context)
    assert len(context.shown) == shown
    assert not tool.is_open


def test_following_can_be_switched_while_a_trace_is_open(tool, context):
    clicks(tool, A, B, C)
    tool.follow(None)
    assert context.shown[-1].path is None
    assert not tool.is_searching
    tool.finish()
    (trace,) = context.session.of(Trace)
    assert trace.vertices == (A, B, C)
    assert trace.notes == ""


def test_restored_draft_keeps_its_way_points_and_searches_paths_again(tool, context):
    clicks(tool, A, B, C)
    state = replay(context.journal.kept).draft.state
    tool.clear_state()
    context.paths.asked = []
    again = TraceTool(context)
    assert again.restore(state)
    assert again.cost == "dark"
    assert again.vertices == (A, B, C)
    assert again.is_searching
    answer_all(context)
    again.finish()
    assert len(context.session.of(Trace)[0].vertices) == 17


def test_a_continued_trace_is_picked_point_by_point(tool, context):
    clicks(tool, A, B, C)
    answer_all(context)
    made = tool.finish()
    context.paths.asked = []
    tool.continue_feature(made)
    assert not tool.is_path
    assert len(tool.vertices) == 17
    clicks(tool, (3.0, 3.0, 1.0))
    tool.finish()
    assert not context.paths.asked
    assert len(context.session.of(Trace)[0].vertices) == 18


def is_in_photo(photo: str, at, kind=Pointer.CLICK, handle=None):
    return replace(event(kind, at=at, handle=handle), is_in_photo=True, photo=photo)


def voted(ends, photo: str) -> FollowedPath:
    return FollowedPath(
        bowed(ends), photo, ("other.jpg", "third.jpg"), checked_count=8, confirmed_count=6
    )


def test_clicks_in_a_photo_are_followed_there_and_votes_are_noted(tool, context):
    tool.pointer(is_in_photo("d/a.jpg", A))
    tool.pointer(is_in_photo("d/a.jpg", B))
    assert context.paths.photos == ["d/a.jpg"]
    ((_, _, ends, _, callback),) = context.paths.asked
    callback(voted(ends, "d/a.jpg"))
    assert tool.votes is not None
    assert "a.jpg" in tool.votes
    assert "75 %" in tool.votes
    context.paths.asked = []
    tool.pointer(event(at=C))
    assert context.paths.photos[-1] == "", "a click on the outcrop is followed over it"
    answer_all(context)
    tool.finish()
    (trace,) = context.session.of(Trace)
    assert "3 way-points" in trace.notes
    assert "2 other photos" in trace.notes


def test_clicked_path_in_a_photo_is_requested_again_with_votes(tool, context):
    tool.pointer(is_in_photo("a.jpg", A))
    tool.pointer(is_in_photo("a.jpg", B, Pointer.MOVE))
    ((_, _, ends, live, callback),) = context.paths.asked
    assert live
    callback(FollowedPath(bowed(ends), "a.jpg", is_final=False))
    assert np.allclose(context.shown[-1].ahead, bowed((A, B)))
    context.paths.asked = []
    tool.pointer(is_in_photo("a.jpg", B))
    ((_, _, ends, live, callback),) = context.paths.asked
    assert not live
    assert tool.is_searching
    assert np.allclose(context.shown[-1].path, bowed((A, B))), "seen until the votes are there"
    callback(voted(ends, "a.jpg"))
    assert not tool.is_searching


def test_way_point_dragged_in_a_photo_is_followed_in_that_photo(tool, context):
    clicks(tool, A, B)
    answer_all(context)
    tool.pointer(is_in_photo("b.jpg", B, Pointer.DRAG_START, handle=1))
    tool.pointer(is_in_photo("b.jpg", C, Pointer.DRAG_MOVE))
    tool.pointer(is_in_photo("b.jpg", C, Pointer.DRAG_END))
    assert context.paths.photos[-1] == "b.jpg"
    tool.follow_in_photos(False)
    assert context.paths.photos[-1] == ""


def test_curvature_path_in_a_photo_follows_the_surface(tool, context):
    tool.follow("curvature")
    tool.pointer(is_in_photo("a.jpg", A))
    tool.pointer(is_in_photo("a.jpg", B))
    assert context.paths.photos == [""]


def test_reason_for_not_following_in_the_photo_is_reported_once(tool, context):
    tool.pointer(is_in_photo("a.jpg", A))
    tool.pointer(is_in_photo("a.jpg", B))
    ((_, _, ends, _, callback),) = context.paths.asked
    finding = Finding("photo.not-showing", photo="a.jpg")
    callback(FollowedPath(bowed(ends), warnings=(finding,)))
    assert context.said == [finding]
    assert tool.votes is None


def test_draft_stores_the_photo_of_each_way_point(tool, context):
    tool.pointer(is_in_photo("a.jpg", A))
    tool.pointer(is_in_photo("a.jpg", B))
    state = replay(context.journal.kept).draft.state
    tool.clear_state()
    context.paths.asked, context.paths.photos = [], []
    again = TraceTool(context)
    assert again.restore(state)
    assert context.paths.photos == ["a.jpg"]
    # What is no list of names is left aside.
    for strange in ("a.jpg", [1, None], [["x"]], {}):
        assert TraceTool(context).restore({**state, "photos": strange})


# --- going on while a way is searched for --------------------------------------------------------
D, E, F = (0.0, 0.0, 1.0), (2.0, 0.0, 1.0), (2.0, 2.0, 1.5)


def answer_until_all_is_there(context) -> None:
    while context.paths.asked:
        answer_all(context)


def ends(context) -> list:
    return [(t.vertices[0], t.vertices[-1]) for t in context.session.of(Trace)]


def test_clicks_after_enter_belong_to_the_next_trace(tool, context):
    clicks(tool, A, B, C)
    assert tool.finish() is None
    clicks(tool, D, E, F)
    tool.finish()
    clicks(tool, A, B)
    answer_until_all_is_there(context)
    assert ends(context) == [(A, C), (D, F)]
    assert tool.vertices == (A, B)


def test_a_double_click_ends_the_next_trace_too(tool, context):
    clicks(tool, A, B, C)
    tool.pointer(event(Pointer.DOUBLE_CLICK, at=C))
    clicks(tool, D, E, F)
    tool.pointer(event(Pointer.DOUBLE_CLICK, at=F))
    answer_until_all_is_there(context)
    assert ends(context) == [(A, C), (D, F)]
    assert not tool.is_open


def test_click_on_a_vertex_of_a_finishing_trace_starts_the_next_one(tool, context):
    clicks(tool, A, B, C)
    tool.finish()
    tool.pointer(event(at=C, handle=2))
    answer_until_all_is_there(context)
    assert tool.vertices == (C,)


def test_pending_clicks_are_reported_and_no_path_to_the_cursor_is_shown(tool, context):
    clicks(tool, A, B, C)
    tool.finish()
    assert shown_codes(context.shown[-1].reading[-1]) == {"follow.finishing"}
    clicks(tool, D, E)
    *_, finishing, waiting = context.shown[-1].reading
    assert shown_codes(finishing) == {"follow.finishing"}
    assert shown_values(waiting, "follow.clicks-waiting") == {"count": "2"}
    tool.pointer(event(Pointer.MOVE, at=F))
    assert context.shown[-1].rubber is None
    assert context.shown[-1].ahead is None


def test_undo_removes_pending_click_then_finish_then_vertex(tool, context):
    clicks(tool, A, B, C)
    tool.finish()
    clicks(tool, D)
    assert tool.undo_label == UNDO_LABELS["click-next"]
    assert tool.undo()
    assert tool.undo_label == UNDO_LABELS["finish"]
    assert tool.undo()
    assert tool.vertices == (A, B, C)
    assert tool.undo()
    assert tool.vertices == (A, B)
    answer_until_all_is_there(context)
    assert tool.is_open
    assert not context.session.of(Trace)


def test_escape_discards_pending_clicks_before_the_trace(tool, context):
    clicks(tool, A, B, C)
    tool.finish()
    clicks(tool, D, E)
    tool.cancel()
    answer_until_all_is_there(context)
    assert ends(context) == [(A, C)]
    assert not tool.is_open


def test_pending_clicks_are_not_added_to_a_trace_that_fails_to_finish(tool, context):
    straight = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (2.0, 0.0, 0.0))
    clicks(tool, *straight)
    tool.finish()
    clicks(tool, D)
    context.session._journal.refuse = OSError("disk full")
    asked, context.paths.asked = context.paths.asked, []
    for _, _, ends_, _, callback in asked:
        callback(FollowedPath(np.array(ends_)))
    assert tool.vertices == straight


class Rock:
    """A surface of 2 cm that lies in no plane."""

    def local_resolution(self, points):
        return 0.02

    def outcrop_normal(self, points):
        return None


def hopping(ends) -> FollowedPath:
    """A way that bends in the plane z = 0, of which the second third is 15 cm above it, behind rock
    that costs much."""
    one, other = map(np.asarray, ends)
    t = np.linspace(0.0, 1.0, 61)[:, None]
    points = one + (other - one) * t + np.array([0.4, -0.6, 0.0]) * t * (1.0 - t)
    points[20:40, 2] += 0.15
    costs = np.full(61, 0.1)
    costs[[19, 20, 39, 40]] = 1.0
    return FollowedPath(points, costs=costs)


def test_stretch_on_a_parallel_contact_is_drawn_and_recorded(tool, context, monkeypatch):
    monkeypatch.setattr(Context, "surface", lambda self, model_id: Rock())
    ends = (0.0, 0.0, 0.0), (2.0, 0.5, 0.0), (3.0, 2.0, 0.0)
    clicks(tool, *ends)
    for number, (_, _, leg, _, callback) in enumerate(list(context.paths.asked)):
        way = hopping(leg)
        callback(way if number else replace(way, points=way.points * [1.0, 1.0, 0.0]))
    assert not tool.is_searching
    (part,) = context.shown[-1].doubtful
    assert part[:, 2] == pytest.approx(0.15, abs=0.151)
    assert np.median(part[:, 2]) == pytest.approx(0.15)
    assert context.shown[-1].verdict != "good"
    total = tool.measurement.total95_deg
    tool.finish()
    (trace,) = context.session.of(Trace)
    ((first, last),) = trace.doubtful
    assert np.median(np.array(trace.vertices)[first : last + 1, 2]) == pytest.approx(0.15)
    assert replay(context.journal.kept).records[trace.id] == trace
    kept, plain = context.measure(trace), context.measure(replace(trace, doubtful=()))
    assert kept.total95_deg == pytest.approx(total)
    assert kept.total95_deg >= max(plain.total95_deg, kept.stretch_error_deg)
    assert plain.stretch_error_deg is None
    assert len(kept.verdict.reasons) == len(plain.verdict.reasons) + 1
    # It goes with its vertices, and the rest of the trace with it.
    shorter = edits.set_vertices(
        context.session.records, trace.id, trace.vertices[10:], resolution=0.02, outcrop_normal=None
    ).after[trace.id]
    assert shorter.doubtful == ((first - 10, last - 10),)
    gone = edits.set_vertices(
        context.session.records,
        trace.id,
        trace.vertices[:first],
        resolution=0.02,
        outcrop_normal=None,
    ).after[trace.id]
    assert gone.doubtful == ()
