"""A contact followed between clicks, with mouse and keyboard, in the window that people use."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from tests import driver
from tests.driver import click, drag, key, look_at, move, pixel, wait
from tests.journeys.conftest import SCREENS
from tests.messages import shown_values
from vomstudio.geology.orientation import planes_to_normals
from vomstudio.project.kinds.patch import Patch
from vomstudio.studio.tools.plane import PlaneTool
from vomstudio.studio.tools.trace import TraceTool
from vomstudio.ui.panels.tools.trace import TracePanel

SHIFT = Qt.KeyboardModifier.ShiftModifier


@pytest.fixture
def following(window, outcrop, picks):
    """The outcrop, a bed in view, and the trace tool that follows dark lines."""
    driver.open_outcrop(window, outcrop)
    # The bed goes on below the net.
    window.docks.close_page("stereonet")
    look_at(window, picks["B01"], 0.0, 10.0)
    key(window, Qt.Key.Key_T)
    box = driver.tool_panel(window, TracePanel).follow_box
    box.setCurrentIndex(box.findData("dark"))
    return window


def way_points(window, points: np.ndarray) -> list[QPoint]:
    """Pixels of the first, the middle and the last one."""
    return [pixel(window, points[i]) for i in (0, len(points) // 2, -1)]


def test_three_clicks_make_a_trace_of_many_points(following, picks):
    window, studio = following, following.studio
    tool = studio.get_tool(TraceTool)
    for at in way_points(window, picks["B01"]):
        click(window.viewport, at)
    wait(lambda: tool.is_open and not tool.is_searching, "the way between the clicks")
    assert len(tool.vertices) == 3
    assert window.viewport.preview.path is not None
    assert len(window.viewport.preview.path) > 20
    driver.keep_picture(window, "following")
    key(window, Qt.Key.Key_Return)
    (trace,) = driver.traces(window)
    assert len(trace.vertices) > 20
    assert "3 way-points" in trace.notes
    studio.undo()
    assert tool.is_open or not driver.traces(window)


@pytest.mark.full
@pytest.mark.parametrize("screen", SCREENS, indirect=True)
def test_ten_traces_take_at_most_twenty_actions(screen, following, picks, truth):
    """A click, and a double click where the trace ends: the way between them is followed."""
    window, viewport, actions = following, following.viewport, 0
    look_at(window, np.concatenate(list(picks.values())), 0.0, 10.0)
    # Two of the beds are picked a second time, between other points.
    lines = [*picks.items(), ("B01", picks["B01"][2:-2]), ("B03", picks["B03"][2:-2])]
    for number, (_, points) in enumerate(lines):
        seen = [p for p in points if is_reached(window, p)]
        click(viewport, pixel(window, seen[0]))
        end = pixel(window, seen[-1])
        click(viewport, end)
        QTest.mouseDClick(viewport, driver.LEFT, driver.NONE, end)
        QTest.mouseRelease(viewport, driver.LEFT, driver.NONE, end)
        actions += 2
        wait(lambda n=number: len(driver.traces(window)) == n + 1, "the trace")
    driver.keep_picture(window, f"ten-traces-{screen}")
    assert actions <= 25
    traces = driver.traces(window)
    measured = window.studio.measured(trace.id for trace in traces)
    for trace, (name, _) in zip(traces, lines, strict=True):
        assert len(trace.vertices) > 10
        plane, verdict = measured[trace.id].plane, measured[trace.id].verdict
        normals = planes_to_normals(
            [plane.dip_direction_deg, truth[name][0]], [plane.dip_deg, truth[name][1]]
        )
        angle_deg = np.degrees(np.arccos(min(abs(float(normals[0] @ normals[1])), 1.0)))
        # A way that leaves its contact for the next one is no good plane.
        assert angle_deg < 8.0 or verdict.quality != "good", (name, angle_deg)


def is_reached(window, point: np.ndarray) -> bool:
    """Whether a person can click a point: it is in sight, and nothing lies over it."""
    at = pixel(window, point)
    hit = window.viewport.pick(at.x(), at.y())
    above = window.childAt(window.viewport.mapTo(window, at))
    return (
        hit is not None
        and above is window.viewport
        and float(np.linalg.norm(window.viewport.world_position(hit) - point)) < 0.03
    )


@pytest.mark.full
def test_path_previews_ahead_of_the_click_and_waypoints_can_be_dragged(following, picks):
    window = following
    tool = window.studio.get_tool(TraceTool)
    first, middle, last = way_points(window, picks["B01"])
    click(window.viewport, first)
    move(window.viewport, last)
    wait(lambda: window.viewport.preview.ahead is not None, "the way to the cursor")
    click(window.viewport, last)
    wait(lambda: not tool.is_searching, "the way")
    before = window.viewport.preview.path
    drag(window.viewport, last, middle)
    wait(lambda: not tool.is_searching, "the way to where it was dragged")
    assert len(tool.vertices) == 2
    assert not np.array_equal(window.viewport.preview.path, before)


@pytest.mark.full
def test_a_key_switches_following_on_and_off(following):
    window = following
    tool = window.studio.get_tool(TraceTool)
    key(window, Qt.Key.Key_T, SHIFT)
    assert tool.cost is None
    assert driver.tool_panel(window, TracePanel).follow_box.currentData() is None
    # What was followed last is followed again.
    key(window, Qt.Key.Key_T, SHIFT)
    assert tool.cost == "dark"
    window.studio.cancel_tool()


@pytest.mark.full
def test_following_key_activates_the_trace_tool_if_nothing_is_picked(following):
    window, studio = following, following.studio
    tool = studio.get_tool(TraceTool)
    key(window, Qt.Key.Key_N)
    key(window, Qt.Key.Key_T, SHIFT)
    # It follows on, as it did before: what nobody sees is not switched off.
    assert (studio.tool_name, tool.cost) == ("trace", "dark")
    key(window, Qt.Key.Key_T, SHIFT)
    assert tool.cost is None
    key(window, Qt.Key.Key_N)
    key(window, Qt.Key.Key_T, SHIFT)
    assert (studio.tool_name, tool.cost) == ("trace", "dark")


@pytest.mark.full
def test_the_best_of_all_costs_is_followed_as_on_the_command_line(following, picks, tmp_path):
    from vomstudio.extraction.best_cost import available_costs, rank_path
    from vomstudio.extraction.following import Follower
    from vomstudio.extraction.surface_graph import SurfaceGraph
    from vomstudio.geometry import transform

    window, studio = following, following.studio
    tool = studio.get_tool(TraceTool)
    box = driver.tool_panel(window, TracePanel).follow_box
    box.setCurrentIndex(box.findData("auto"))
    for at in way_points(window, picks["B01"]):
        click(window.viewport, at)
    wait(lambda: tool.is_open and not tool.is_searching, "the ways by all costs", 120.0)
    clicks = np.array(tool.vertices)
    driver.keep_picture(window, "following-best")
    by = tool.effective_cost
    assert by in available_costs(SurfaceGraph(studio.models[tool.trace.model_id].data))
    assert box.currentData() == "auto"
    assert box.currentText().endswith(f": {box.itemText(box.findData(by))}")
    # The same by hand: each cost, leg by leg, and the one of the least stated error.
    model = driver.model(window)
    surface = SurfaceGraph(studio.models[model.id].data)
    near = studio.surface(model.id)
    ranks = {}
    for cost in available_costs(surface):
        legs = [Follower(surface, cost).follow(clicks[i : i + 2]).points for i in range(2)]
        line = np.concatenate([legs[0], legs[1][1:]])
        world = transform.apply(model.to_world, line)
        ranks[cost] = rank_path(world, lambda _, at=line: near.local_resolution(at))[0]
    assert ranks[by] == min(ranks.values())
    key(window, Qt.Key.Key_Return)
    (trace,) = driver.traces(window)
    assert shown_values(trace.notes, "follow.by-best-cost")["cost"] == by
    assert len(trace.vertices) > 20


@pytest.mark.full
def test_finishing_a_trace_during_path_search_does_not_affect_next_clicks(following, picks):
    """As fast as somebody clicks who knows the outcrop: the first way takes longest."""
    window, studio = following, following.studio
    tool = studio.get_tool(TraceTool)
    first = way_points(window, picks["B01"])
    for at in first:
        click(window.viewport, at)
    key(window, Qt.Key.Key_Return)
    for at in (pixel(window, picks["B02"][i]) for i in (0, -1)):
        click(window.viewport, at)
    wait(lambda: driver.traces(window), "the first trace", 60.0)
    wait(lambda: tool.is_open and not tool.is_searching, "the second")
    (trace,) = driver.traces(window)
    assert "3 way-points" in trace.notes
    assert len(tool.vertices) == 2
    studio.cancel_tool()


@contextlib.contextmanager
def slow_search(window) -> Iterator[None]:
    """The thread that searches paths is busy until the end of the block."""
    paths = window.studio.workspace.tools.paths
    done = threading.Event()
    paths._background.run(done.wait, lambda _: None)
    try:
        yield
    finally:
        done.set()


def pending(window) -> list[QPoint]:
    """Where clicks are marked that have not taken effect yet."""
    preview = window.viewport.preview
    places = (
        [] if preview is None or preview.pending_positions is None else preview.pending_positions
    )
    return [pixel(window, place) for place in places]


@pytest.mark.full
def test_waiting_clicks_are_marked_and_a_tool_key_ends_the_queue(following, picks):
    window, studio = following, following.studio
    trace, plane = studio.get_tool(TraceTool), studio.get_tool(PlaneTool)
    with slow_search(window):
        for at in way_points(window, picks["B01"]):
            click(window.viewport, at)
        key(window, Qt.Key.Key_Return)
        assert trace.is_finishing
        following_clicks = [pixel(window, picks["B02"][i]) for i in (0, -1)]
        for at in following_clicks:
            click(window.viewport, at)
        for at, shown in zip(following_clicks, pending(window), strict=True):
            assert (at - shown).manhattanLength() <= 3
        driver.keep_picture(window, "following-waiting")
        key(window, Qt.Key.Key_P)
        key(window, Qt.Key.Key_G)
        assert studio.tool_name == "plane"
        assert pending(window) == []
        # The next click is for the plane, and waits with a mark as well.
        rock = pixel(window, picks["B01"][1]) + QPoint(0, 40)
        click(window.viewport, rock)
        assert (pending(window)[0] - rock).manhattanLength() <= 3
        key(window, Qt.Key.Key_Return)
        # The type of the plane is not that of the trace.
        key(window, Qt.Key.Key_3)
        assert driver.traces(window) == []
    wait(lambda: driver.traces(window), "the trace")
    wait(lambda: studio.session.of(Patch), "the plane")
    assert [each.type_id for each in driver.traces(window)] == ["bedding"]
    assert [each.type_id for each in studio.session.of(Patch)] == ["joint"]
    assert not trace.is_open
    assert not plane.is_open
    assert pending(window) == []


@pytest.mark.full
def test_tool_key_keeps_a_trace_still_being_searched(following, picks):
    window, studio = following, following.studio
    with slow_search(window):
        for at in way_points(window, picks["B01"]):
            click(window.viewport, at)
        key(window, Qt.Key.Key_L)
        assert studio.tool_name == "line"
    wait(lambda: driver.traces(window), "the trace")
    assert studio.tool_name == "line"


@pytest.mark.full
def test_esc_and_backspace_drop_the_waiting_clicks_of_another_tool(following, picks):
    window, studio = following, following.studio
    with slow_search(window):
        for at in way_points(window, picks["B01"]):
            click(window.viewport, at)
        key(window, Qt.Key.Key_P)
        rock = pixel(window, picks["B01"][1]) + QPoint(0, 40)
        click(window.viewport, rock)
        click(window.viewport, rock + QPoint(40, 0))
        assert len(pending(window)) == 2
        key(window, Qt.Key.Key_Backspace)
        assert len(pending(window)) == 1
        click(window.viewport, rock + QPoint(80, 0))
        key(window, Qt.Key.Key_Z, driver.CTRL)
        assert len(pending(window)) == 1
        key(window, Qt.Key.Key_Escape)
        assert pending(window) == []
        assert studio.get_tool(TraceTool).is_finishing
        # One more step back, and the trace is being picked as before.
        key(window, Qt.Key.Key_Z, driver.CTRL)
        assert studio.tool_name == "trace"
        assert studio.tool.is_open
        assert not studio.tool.is_finishing
        key(window, Qt.Key.Key_Return)
    wait(lambda: driver.traces(window), "the trace")
    driver.pause(100)
    assert not studio.get_tool(PlaneTool).is_open
