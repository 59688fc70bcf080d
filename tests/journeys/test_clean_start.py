"""A new project looks like that of a new window, whatever the last one has left on any page."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from PySide6.QtWidgets import (
    QAbstractButton,
    QCheckBox,
    QComboBox,
    QDockWidget,
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
from vomstudio.project import edits
from vomstudio.project.kinds.trace import Trace
from vomstudio.ui.base.controls import PanelScrollArea


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


def contents(window: Any) -> dict[str, list[tuple[str, object]]]:
    """The contents of all pages, in the order of their widgets."""
    pages = {}
    for name in window.docks:
        window.docks.bring_forward(name)
        driver.pause(200)
        inner = panel(window, name)
        pages[name] = [
            (f"{type(w).__name__} {w.objectName()}", content(w))
            for w in [inner, *inner.findChildren(QWidget)]
            if content(w) is not None and not isinstance(w.parent(), QDockWidget)
        ]
    return pages


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


def test_a_new_project_is_as_in_a_new_window(new_window: Any, outcrop: Path) -> None:
    window = new_window
    studio = window.studio
    fresh = contents(window)
    model_id = driver.open_outcrop(window, outcrop)
    model = studio.records[model_id]
    for i in range(6):
        add_bed(studio, model, f"b{i}", dip=0.1 * i)
    assert studio.attempt(edits.set_attributes, ["b1"], name="B0")
    studio.selection.set(["b0", "b1"])
    studio.warn(Finding("action.no-model"))
    for name in window.docks:
        window.docks.bring_forward(name)
        driver.pause(50)
        scribble(panel(window, name))
    driver.pause(300)
    assert contents(window) != fresh
    studio.settings.__init__()
    studio.keep_settings()
    studio.project.session.discard_unsaved()
    studio.new_project()
    after = contents(window)
    assert not window.message_bar.isVisible()
    for name in fresh:
        for a, b in zip(after[name], fresh[name], strict=False):
            if a != b: print(name, a, "FRESH", b)
        if len(after[name]) != len(fresh[name]): print(name, len(after[name]), len(fresh[name]))
