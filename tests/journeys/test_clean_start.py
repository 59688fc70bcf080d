"""A new project looks like that of a new window, whatever the last one has left on any page."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtWidgets import (
    QAbstractButton,
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QLabel,
    QLineEdit,
    QListWidget,
    QPlainTextEdit,
    QRadioButton,
    QSpinBox,
    QTableView,
    QTextEdit,
    QTreeWidget,
    QWidget,
)

from tests import driver
from tests.samples import ZIGZAG
from vomstudio.core.findings import Finding
from vomstudio.io.settings import Settings
from vomstudio.project import edits
from vomstudio.project.kinds.trace import Trace
from vomstudio.ui.base.controls import PanelScrollArea
from vomstudio.ui.shell.work_panels import PERMANENT_PAGES


def content(widget: QWidget) -> object:
    """What a user reads in a widget, or None for one without content."""
    if isinstance(widget, QLineEdit | QLabel):
        return widget.text()
    if isinstance(widget, QSpinBox | QDoubleSpinBox):
        return widget.value()
    if isinstance(widget, QComboBox):
        return [widget.itemText(i) for i in range(widget.count())], widget.currentIndex()
    if isinstance(widget, QPlainTextEdit | QTextEdit):
        return widget.toPlainText()
    if isinstance(widget, QAbstractButton):
        return widget.text(), widget.isChecked(), widget.isEnabledTo(widget.parentWidget())
    if isinstance(widget, QTableView):
        return widget.model().rowCount()
    if isinstance(widget, QListWidget):
        return [widget.item(i).text() for i in range(widget.count())]
    if isinstance(widget, QTreeWidget):
        return [widget.topLevelItem(i).text(0) for i in range(widget.topLevelItemCount())]
    return None


def panel(window: Any, name: str) -> QWidget:
    page = driver.page(window, name)
    return page.widget() if isinstance(page, PanelScrollArea) else page


def contents(window: Any) -> dict[str, list[str]]:
    """The visible contents of all pages; the second view has a test of its own."""
    pages: dict[str, list[str]] = {}
    for name in sorted(window.docks.keys() - set(PERMANENT_PAGES)):
        window.docks.bring_forward(name)
        # A page is filled a moment after it appears, and its answer may come later.
        driver.pause(150)
        while pages.get(name) != (now := visible_content(panel(window, name))):
            pages[name] = now
            driver.pause(150)
    return pages


def visible_content(page: QWidget) -> list[str]:
    return sorted(
        f"{type(widget).__name__} {widget.objectName()}: {content(widget)}"
        for widget in page.findChildren(QWidget)
        if widget.isVisibleTo(page)
        and content(widget) is not None
        # Qt fades the button that clears a line.
        and not isinstance(widget.parent(), QLineEdit)
    )


def add_bed(studio: Any, model: Any, id_: str, dip: float) -> None:
    low = np.asarray(studio.models[model.id].data.bounds).mean(axis=0)
    points = tuple((low[0] + x, low[1] + y, low[2] + dip * x + z) for x, y, z in ZIGZAG)
    trace = Trace(id_, id_.upper(), "bedding", model.id, model.content_hash, points)
    assert studio.attempt(edits.add_trace, trace)


def scribble(page: QWidget) -> None:
    """Change every field of a page as a user may."""
    for field in page.findChildren(QWidget):
        if isinstance(field, QSpinBox | QDoubleSpinBox):
            field.setValue(field.value() + field.singleStep())
        elif isinstance(field, QComboBox) and field.count() > 1:
            field.setCurrentIndex((field.currentIndex() + 1) % field.count())
            field.activated.emit(field.currentIndex())
        elif isinstance(field, QCheckBox | QRadioButton):
            field.click()
        elif isinstance(field, QLineEdit) and not isinstance(
            field.parent(), QSpinBox | QDoubleSpinBox | QComboBox
        ):
            field.setText("7")
            field.setModified(True)
            field.textEdited.emit("7")
            field.editingFinished.emit()


def work(window: Any, outcrop: Path) -> None:
    """Leave something on every page: features, proposals, typed values, messages."""
    studio = window.studio
    model = studio.records[driver.open_outcrop(window, outcrop)]
    for i in range(6):
        add_bed(studio, model, f"b{i}", dip=0.1 * i)
    assert studio.attempt(edits.set_attributes, ["b1"], name="B0")
    studio.selection.set(["b0", "b1"])
    studio.warn(Finding("action.no-model"))
    for name in sorted(window.docks.keys() - set(PERMANENT_PAGES)):
        window.docks.bring_forward(name)
        driver.pause(50)
        scribble(panel(window, name))


@pytest.mark.full
def test_new_project_matches_a_new_window(new_window: Any, outcrop: Path) -> None:
    window, settings = new_window, new_window.studio.settings
    view = window.viewport.moves.camera_state()
    fresh = contents(window)
    work(window, outcrop)
    assert contents(window) != fresh
    for each in fields(settings):
        # Settings are those of the user, not of a project.
        setattr(settings, each.name, getattr(Settings(), each.name))
    window.studio.keep_settings()
    window.studio.project.session.discard_unsaved()
    window.actions_table.run("new")
    assert window.start_page.isVisible()
    assert not window.message_bar.isVisible()
    assert not window.docks.page("drawer")
    window.viewport.moves.set_camera_state(view)
    after = contents(window)
    different = {
        name: sorted(set(after[name]) ^ set(fresh[name]))
        for name in fresh
        if after[name] != fresh[name]
    }
    assert different == {}


@pytest.mark.full
@pytest.mark.parametrize("workspace", ["model", "interpret", "results"])
def test_a_new_project_shows_the_start_page(window: Any, workspace: str) -> None:
    window.workspaces.switch(workspace)
    window.docks.bring_forward("table")
    window.docks.move_to_center("stereonet")
    window.actions_table.run("new")
    driver.pause(50)
    page = window.start_page
    assert page.isVisible()
    bar = page.findChild(PanelScrollArea).verticalScrollBar()
    assert not bar.maximum(), "the start page is not whole"
