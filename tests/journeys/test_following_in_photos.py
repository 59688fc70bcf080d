"""A contact followed in the pixels of a photo, with mouse and keyboard, in the real window."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from tests import driver
from tests.driver import click, drag, key, move, wait
from tests.journeys.test_in_photos import points_of, sample, shown, spot, traced  # noqa: F401
from tests.messages import shown_codes
from vomstudio.project.kinds.trace import Trace
from vomstudio.studio.tools.trace import TraceTool
from vomstudio.ui.panels.tools.trace import TracePanel

pytestmark = pytest.mark.full

OLD = ("B05", "B14", "F01", "J2-02")


@pytest.fixture
def bed(traced):  # noqa: F811
    """The photo that shows the bed B05 best, and the trace tool that follows dark lines."""
    window, studio, panel = traced, traced.studio, traced.in_photos
    studio.selection.set(["B05"])
    window.actions_table.run("show_in_photos")
    shown(window)
    wait(lambda: "B05: visible in" in panel.summary.text(), "the photos that show it")
    window.viewport.setFocus()
    key(window, Qt.Key.Key_T)
    box = driver.tool_panel(window, TracePanel).follow_box
    box.setCurrentIndex(box.findData("dark"))
    return window


def places(window) -> list[QPoint]:
    """Where the first, the middle and the last seen point of the bed are in the photo."""
    panel = window.in_photos
    views, canvas = panel.feature_photo.photos.views, panel.canvas
    points = points_of(window, "B05")
    on = [
        spot(canvas, panel, p) for p in points[views.shows(panel.feature_photo.view, points, 0.02)]
    ]
    on = [p for p in on if canvas.rect().adjusted(8, 8, -8, -8).contains(p)]
    return [on[0], on[len(on) // 2], on[-1]]


def made(window) -> list[Trace]:
    return [t for t in window.studio.session.of(Trace) if t.id not in OLD]


def test_a_contact_is_followed_in_the_photo_and_is_on_the_outcrop_at_once(bed):
    window, studio, panel = bed, bed.studio, bed.in_photos
    canvas, tool = panel.canvas, studio.get_tool(TraceTool)
    first, middle, last = places(window)
    click(canvas, first)
    move(canvas, middle)
    wait(lambda: window.viewport.preview.ahead is not None, "the way to the cursor")
    assert len(window.viewport.preview.ahead) > 10
    QTest.qWait(450)
    click(canvas, middle)
    QTest.qWait(450)
    click(canvas, last)
    wait(lambda: not tool.is_searching, "the way with its votes")
    assert window.viewport.preview.path is not None
    assert len(window.viewport.preview.path) > 50, "a vertex for each pixel of the photo"
    side = driver.tool_panel(window, TracePanel).photo_follow_box
    assert panel.photo.rpartition("/")[2] in side.votes.text()
    assert not side.votes.isHidden()
    driver.pause(200)
    driver.keep_picture(window, "following-in-photo")

    # A way-point is dragged in the photo, and its pieces come along.
    before = window.viewport.preview.path
    drag(canvas, middle, middle + QPoint(5, 9))
    wait(lambda: not tool.is_searching, "the way to where it was dragged")
    assert len(tool.vertices) == 3
    assert not np.array_equal(before, window.viewport.preview.path)
    key(window, Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    wait(lambda: np.array_equal(before, window.viewport.preview.path), "the way of before")

    canvas.setFocus()
    key(window, Qt.Key.Key_Return)
    wait(lambda: made(window), "the trace")
    (trace,) = made(window)
    assert len(trace.vertices) == len(before)
    assert "3 way-points" in trace.notes
    assert panel.photo.rpartition("/")[2] in trace.notes
    # The dark base of the bed of which B05 is a trace.
    both = window.studio.measured(["B05", trace.id])
    one, other = (both[i].fit.normal for i in ("B05", trace.id))
    assert np.degrees(np.arccos(abs(float(one @ other)))) < 2.0
    studio.undo()
    assert not made(window)


def test_esc_discards_the_followed_trace_as_one_undo_step(bed):
    window, studio, canvas = bed, bed.studio, bed.in_photos.canvas
    tool = studio.get_tool(TraceTool)
    first, _, last = places(window)
    click(canvas, first)
    QTest.qWait(450)
    click(canvas, last)
    wait(lambda: not tool.is_searching, "the way")
    canvas.setFocus()
    key(window, Qt.Key.Key_Escape)
    assert not tool.is_open
    studio.undo()
    assert tool.is_open
    assert tool.votes is not None, "it is still followed in the photo"
    studio.cancel_tool()


def test_check_box_explains_why_photos_cannot_be_followed(bed):
    side = driver.tool_panel(bed, TracePanel)
    assert side.photo_follow_box.check.isEnabled()
    side.follow_box.setCurrentIndex(side.follow_box.findData("curvature"))
    assert not side.photo_follow_box.check.isEnabled()
    assert "follow.not-in-photos" in shown_codes(side.photo_follow_box.check.toolTip())
    side.follow_box.setCurrentIndex(0)
    assert "follow.no-cost" in shown_codes(side.photo_follow_box.check.toolTip())
