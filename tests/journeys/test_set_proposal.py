"""Sets proposed among a field book of joints, another number, accepted, and taken back."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from tests import driver
from tests.geology.test_set_proposals import CASES, cluster, scatter
from tests.messages import shown_codes, shown_values
from vomstudio.geology.orientation import normals_to_planes
from vomstudio.project import edits
from vomstudio.project.kinds.reading import Reading
from vomstudio.ui.panels.sets.sets_panel import SetsPanel

SIZES = {"J1": 300, "J2": 250, "J3": 250}


def joints(cluttered: int = 60) -> list[Reading]:
    """Three sets and a scatter, each at a place."""
    chance = np.random.default_rng(11)
    poles = [cluster(of, chance) for of in CASES["three"][0]]
    direction, dip, _ = normals_to_planes(np.vstack([*poles, scatter(cluttered, chance)]))
    places = chance.uniform(0, 30, (len(dip), 3))
    return [
        Reading(f"r{i}", f"r{i}", "joint", "plane", float(a), float(d), position=tuple(p))
        for i, (a, d, p) in enumerate(zip(direction, dip, places.tolist(), strict=True))
    ]


@pytest.fixture
def panel(window, outcrop) -> SetsPanel:
    driver.open_outcrop(window, outcrop)
    assert window.studio.attempt(edits.add_readings, joints())
    window.actions_table.run("propose_sets")
    made = window.findChild(SetsPanel)
    driver.wait(made.isVisible, "the panel")
    return made


def sets_of(window) -> dict[str, int]:
    names = [r.set_name for r in window.studio.session.of(Reading)]
    return {name: names.count(name) for name in set(names)}


@pytest.mark.full
def test_sets_are_proposed_edited_accepted_and_undone_in_one_step(window, panel) -> None:
    studio = window.studio
    driver.wait(lambda: panel.result is not None, "the proposal", 60.0)
    before = dict(studio.records)
    assert panel.group_box.currentText() == "Joint"
    assert panel.table.rowCount() == 4
    for row in range(3):
        assert int(panel.table.item(row, 1).text()) == pytest.approx(SIZES[f"J{row + 1}"], abs=15)
        assert "±" in panel.table.item(row, 2).text()
        assert panel.table.item(row, 4).text() != "–"
    net = window.net
    driver.wait(
        lambda: net.is_up_to_date and [s.name for s in net.artists.contents.sets][-1] == "no set",
        "the preview",
    )
    assert len({s.color for s in net.artists.contents.sets}) == 4
    driver.settled(window)
    driver.keep_picture(window, "sets-proposed")

    panel.count.setValue(2)
    driver.wait(lambda: panel.table.rowCount() == 3, "two sets", 60.0)
    assert dict(studio.records) == before
    panel.table.item(1, 0).setText("cross joints")
    n = int(panel.table.item(1, 1).text())
    driver.click(panel.accept, panel.accept.rect().center())
    assert sets_of(window)["cross joints"] == n
    assert set(sets_of(window)) == {"J1", "cross joints", ""}
    driver.wait(
        lambda: net.is_up_to_date and "proposed" not in net.artists.contents.sets[0].name,
        "the net as it is",
    )
    studio.undo()
    assert dict(studio.records) == before


@pytest.mark.full
def test_rejecting_changes_nothing_and_seeds_replace_the_number_of_sets(window, panel) -> None:
    driver.wait(lambda: panel.result is not None, "the proposal", 60.0)
    before = dict(window.studio.records)
    panel.seeds.setFocus()
    QTest.keyClicks(panel.seeds, "30/85, 120/88")
    assert not panel.count.isEnabled()
    QTest.keyClick(panel.seeds, Qt.Key.Key_Return)
    driver.wait(lambda: panel.table.rowCount() == 3, "two sets", 60.0)
    azimuth_deg = float(panel.table.item(0, 2).text().split("/")[0])
    assert azimuth_deg == pytest.approx(30.0, abs=3.0)
    driver.click(panel.reject, panel.reject.rect().center())
    assert panel.result is None
    assert not panel.accept.isEnabled()
    assert "sets.no-proposal" in shown_codes(panel.accept.toolTip())
    assert dict(window.studio.records) == before
    QTest.keyClicks(panel.seeds, ", 95")
    QTest.keyClick(panel.seeds, Qt.Key.Key_Return)
    driver.wait(lambda: panel.message.text(), "the reason")
    assert shown_codes(panel.message.text()) == {"sets.seed-not-a-plane"}


@pytest.mark.full
def test_planes_with_a_set_keep_it_unless_requested(window, panel) -> None:
    studio = window.studio
    driver.wait(lambda: panel.result is not None, "the proposal", 60.0)
    mine = [f"r{i}" for i in range(250)]
    assert studio.attempt(edits.set_attributes, mine, set_name="J1")
    assert "sets.planes-changed" in shown_codes(panel.message.text())
    driver.click(panel.start, panel.start.rect().center())
    driver.wait(lambda: panel.result is not None, "the proposal", 60.0)
    assert shown_values(panel.message.text(), "sets.left-out") == {"count": "250"}
    # Their name is not given twice.
    assert panel.table.item(0, 0).text() == "J2"
    driver.click(panel.accept, panel.accept.rect().center())
    assert sets_of(window)["J1"] == 250
    assert sets_of(window)["J2"] > 200
    driver.click(panel.start, panel.start.rect().center())
    driver.click(panel.assigned_box, QPoint(8, panel.assigned_box.height() // 2))
    driver.click(panel.start, panel.start.rect().center())
    driver.wait(lambda: panel.result is not None, "the proposal", 60.0)
    assert len(panel.result.candidates.ids) == len(studio.session.of(Reading))
    driver.click(panel.accept, panel.accept.rect().center())
    assert sets_of(window)["J1"] > 270
