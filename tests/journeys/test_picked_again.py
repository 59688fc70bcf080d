"""Picks offered for a second time in the real window: the first ones unseen, the repeats linked,
counted nowhere, and their spread beside the stated errors."""

from __future__ import annotations

import json

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from tests import driver
from tests.driver import LEFT, NONE, wait
from tests.messages import shown_codes, shown_values
from vomstudio.cli.common.entry import main
from vomstudio.project.kinds.trace import Trace
from vomstudio.ui.panels.repeatability_panel import RepeatsPanel
from vomstudio.ui.panels.statistics.statistics_panel import StatisticsPanel
from vomstudio.ui.shell.main_window import MainWindow

pytestmark = pytest.mark.full


def press(button) -> None:
    QTest.mouseClick(button, LEFT, NONE, button.rect().center())


def settle(panel) -> None:
    driver.pause(200)
    wait(lambda: not panel._requests.is_waiting and not panel._timer.isActive(), "the figures")


def pick(window: MainWindow, points: np.ndarray) -> Trace:
    """A trace picked by clicks, with the tool that is active."""
    count = len(driver.traces(window))
    driver.focus(window)
    driver.pick(window, points)
    driver.key(window, Qt.Key.Key_Return)
    wait(lambda: len(driver.traces(window)) == count + 1, "the trace")
    return driver.traces(window)[-1]


@pytest.fixture
def three(window, outcrop, picks):
    """Three beds picked by AB."""
    driver.open_outcrop(window, outcrop)
    studio = window.studio
    for name in list(picks)[:3]:
        studio.activate("trace")
        pick(window, picks[name])
    studio.activate("navigate")
    window.actions_table.run("repeats")
    panel = window.findChild(RepeatsPanel)
    assert not panel.visibleRegion().isEmpty()
    settle(panel)
    assert "repeats.not-begun" in shown_codes(panel.figures.placeholder)
    assert not panel.figures.toPlainText()
    panel.interpreter.setFocus()
    QTest.keyClicks(panel.interpreter, "AB")
    studio.selection.set([t.id for t in driver.traces(window)])
    press(panel.name)
    assert {t.interpreter for t in driver.traces(window)} == {"AB"}
    return panel


def test_blind_repeats_are_picked_and_linked_to_their_originals(
    window, three, picks, capfd
) -> None:
    panel, studio = three, window.studio
    points = dict(zip([t.id for t in driver.traces(window)], list(picks.values()), strict=False))
    names = {t.id: t.name for t in driver.traces(window)}
    panel.share.setFocus()
    panel.share.selectAll()
    QTest.keyClicks(panel.share, "60")
    press(panel.begin)
    session, again = studio.session, studio.workspace.repeats
    assert len(again.selected_ids) == 2
    first = again.current
    # Nothing that was picked is to be seen, on the outcrop, on the net or beside the ring.
    wait(lambda: window.viewport.is_still, "the picture")
    drawn = window.viewport.features.drawings
    assert not any(drawn[id_].visible for id_ in names if id_ in drawn)
    assert any("again" in key for key in drawn)
    assert names[first] not in panel.prompt.text()
    assert "1 of 2" in panel.prompt.text()
    assert studio.tool_name == "trace"
    wait(lambda: window.net.is_up_to_date, "the net")
    assert not window.net._source.sets()
    driver.keep_picture(window, "picked_again_offered")
    made = pick(window, points[first][::-1])
    wait(lambda: session.records[made.id].repeat_of == first, "the link")
    linked = session.records[made.id]
    assert (linked.interpreter, linked.type_id) == ("AB", session.records[first].type_id)
    assert linked.name == f"{names[first]} again"
    assert not studio.visible(made.id)
    second = again.current
    assert second not in (None, first)
    # The pick and its link are one step; taken back, the place is offered once more.
    studio.undo()
    wait(lambda: made.id not in session.records and again.current == first, "the place again")
    studio.redo()
    wait(lambda: again.current == second, "the second one")
    press(panel.skip)
    wait(lambda: again.current is None, "the end")
    assert all(studio.visible(id_) for id_ in names)
    assert studio.tool_name == "navigate"
    settle(panel)
    found = panel.result
    assert (found.structures, found.repeats, found.stated_errors_hold) == (1, 1, "undetermined")
    # The same places, clicked from elsewhere the other way round.
    assert found.pairs[0].angle_deg < found.pairs[0].stated95_deg
    assert found.pairs[0].by == ("AB", "AB")
    assert names[first] in panel.figures.toPlainText()
    driver.keep_picture(window, "picked_again")
    # Counted nowhere else.
    window.docks.bring_forward("statistics")
    statistics = window.findChild(StatisticsPanel)
    assert len(statistics.group_box.features()) <= 3
    assert made.id not in {f.id for f in statistics.group_box.features()}
    net = window.net._source.sets()
    assert len(window.studio.fold.planes()) == 3
    assert made.id not in {id_ for one in net for id_ in one.ids}
    for contents in (window.net.contents(), window.net.printable_contents()):
        (note,) = (n for n in contents.notes if "table.repeats-left-out" in shown_codes(str(n)))
        assert shown_values(str(note), "table.repeats-left-out") == {"count": "1"}
    # What is hidden anyway is not counted.
    window.studio.set_visible([made.id], False)
    assert window.net._source.repeat_notes() == ()
    window.studio.set_visible([made.id], True)
    wait(lambda: window.net.is_up_to_date, "the net")
    driver.keep_picture(window.net, "net_without_repeats")
    studio.save()
    capfd.readouterr()
    assert main(["repeats", str(studio.project.folder), "--json"]) == 0
    told = json.loads(capfd.readouterr().out)
    assert told["pairs"][0]["angle_deg"] == pytest.approx(found.pairs[0].angle_deg)
    assert (told["n"], told["repeats"]) == (3, 1)
