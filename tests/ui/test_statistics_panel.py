"""The statistics dock: of a type, a set, the selection."""

from __future__ import annotations

import pytest
from PySide6.QtGui import QGuiApplication

from tests import driver
from tests.messages import shown_codes, shown_values
from tests.ui.conftest import add_cliff
from vomstudio.project import edits
from vomstudio.project.kinds.reading import Reading
from vomstudio.ui.panels.statistics.statistics_panel import DOMAIN_TITLES, StatisticsPanel


@pytest.fixture
def panel(window, studio):
    """Twelve beds of one dip, twelve of a fold, four joints."""
    add_cliff(studio)
    window.workspaces.switch("results")
    window.docks.bring_forward("statistics")
    fold = [(90 if i % 2 else 270, 10.0 + 6 * (i // 2)) for i in range(12)]
    dips = [("bedding", "fold", *attitude) for attitude in fold]
    dips += [("bedding", "flank", 120.0 + i, 40.0 + i % 3) for i in range(12)]
    dips += [("joint", "", 10.0 + i, 85.0) for i in range(4)]
    readings = [
        Reading(f"r{i}", f"r{i}", kind, "plane", azimuth, dip, set_name=name)
        for i, (kind, name, azimuth, dip) in enumerate(dips)
    ]
    assert studio.attempt(edits.add_readings, readings)
    made = window.findChild(StatisticsPanel)
    driver.wait(lambda: "Planes" in made.figures.toPlainText(), "the figures")
    return made


@pytest.mark.full
def test_open_panel_describes_beds_added_later(window, studio) -> None:
    """The program may start with it; nobody has chosen the selection, which alone was there."""
    window.workspaces.switch("results")
    window.docks.bring_forward("statistics")
    made = window.findChild(StatisticsPanel)
    driver.wait(lambda: made.group_box.count() == 1 and made.isVisible(), "the empty panel")
    add_cliff(studio)
    beds = [
        Reading(f"r{i}", f"r{i}", "bedding", "plane", 90.0 + i, 30.0 + i, set_name="")
        for i in range(3)
    ]
    assert studio.attempt(edits.add_readings, beds)
    driver.wait(lambda: "3 poles" in made.figures.toPlainText(), "the figures")
    assert made.group_box.currentText() == "Bedding"


def choose(panel, text: str) -> str:
    panel.group_box.setCurrentIndex(panel.group_box.findText(text))
    panel.group_box.activated.emit(panel.group_box.currentIndex())
    return panel.figures.toPlainText()


def test_a_type_is_described_first_with_n_and_methods(panel) -> None:
    assert panel.group_box.currentText() == "Bedding"
    text = panel.figures.toPlainText()
    assert "24 poles " in text
    for word in ("Fisher", "Tensor", "Bingham", "Uniformity", "Verdict"):
        assert word in text
    # Its two sets, each with its own axis.
    assert DOMAIN_TITLES["set_name"] in text
    assert "different axes" in text


def test_each_set_has_its_own_verdict(panel) -> None:
    assert "homoclinal" in choose(panel, "Bedding: flank")
    text = choose(panel, "Bedding: fold")
    assert "12 poles " in text
    assert "cylindrical" in text


@pytest.mark.full
def test_statistics_follow_the_selection_and_state_pooled_types(panel, studio) -> None:
    assert shown_codes(choose(panel, "Selection")) == {"selection.unsuitable"}
    studio.selection.set(["r0", "r12", "r24"])
    driver.wait(lambda: "3 poles" in panel.figures.toPlainText(), "the selection")
    pooled = shown_values(panel.figures.toPlainText(), "sets.mixed-types")
    assert pooled["n"] == "2"
    assert "Verdict" not in panel.figures.toPlainText()
    studio.selection.set(["r24", "r25"])
    driver.wait(lambda: "2 poles" in panel.figures.toPlainText(), "the selection")
    assert "pooled" not in panel.figures.toPlainText()


def test_statistics_are_copied_as_text(panel) -> None:
    panel.copy.click()
    assert "Verdict\t" in QGuiApplication.clipboard().text()


@pytest.mark.full
def test_deleted_set_is_removed_from_the_list(panel, studio) -> None:
    studio.selection.set([f"r{i}" for i in range(12, 24)])
    assert studio.attempt(edits.delete, list(studio.selection.ids))
    driver.wait(lambda: panel.group_box.findText("Bedding: flank") < 0, "the list")
    assert "12 poles" in panel.figures.toPlainText()
