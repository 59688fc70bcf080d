"""Every panel and every tool is used once with a model. Both come from the registries, so a new one
is tested without being entered here."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QImage, QKeySequence
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QHeaderView,
    QLabel,
    QWidget,
)

from tests import driver
from tests.driver import click, key, look_at, wait
from vomstudio.project import edits
from vomstudio.project.kinds.trace import Trace
from vomstudio.studio.tools.registry import TOOLS
from vomstudio.ui.shell.work_panels import work_panels


@pytest.fixture
def interpreted(window, outcrop, picks):
    """The outcrop with its traces as beds, seen from the front."""
    model_id = driver.open_outcrop(window, outcrop)
    model = window.studio.records[model_id]
    for name, points in picks.items():
        vertices = tuple(tuple(p) for p in points.tolist())
        trace = Trace(name, name, "bedding", model_id, model.content_hash, vertices)
        assert window.studio.attempt(edits.add_trace, trace)
    look_at(window, picks["B04"], 0.0, 10.0)
    return window


def visible_texts(panel: QWidget) -> list[str]:
    kinds = (QLabel, QAbstractButton)
    texts = [each.text() for kind in kinds for each in panel.findChildren(kind) if each.isVisible()]
    for header in panel.findChildren(QHeaderView):
        if header.isVisible() and (model := header.model()) is not None:
            texts += [
                str(model.headerData(i, header.orientation()) or "") for i in range(header.count())
            ]
    views = panel.findChildren(QAbstractItemView)
    for view in [*views, *([panel] if isinstance(panel, QAbstractItemView) else [])]:
        if view.isVisible() and (model := view.model()) is not None:
            texts.append(str(model.index(0, 0).data() or ""))
    return [text for text in texts if text.strip()]


def is_blank(widget: QWidget) -> bool:
    """Whether a widget is drawn in hardly more than one colour."""
    image = widget.grab().toImage().convertToFormat(QImage.Format.Format_RGB32)
    pixels = np.frombuffer(image.constBits(), np.uint32)
    _, counts = np.unique(pixels, return_counts=True)
    return bool(counts.max() > 0.998 * counts.sum())


def test_every_panel_opens_by_search_and_shows_content(interpreted) -> None:
    window = interpreted
    window.resize(1500, 950)
    assert {name for name, _, _ in work_panels()} <= set(window.docks)
    window.studio.info("A message for the panel of messages.")
    pages = {each.entry.key: each for each in window._search_destinations()}
    for name, dock in window.docks.items():
        window.docks.close_page(name)
        assert not window.docks.is_shown(name), name
        pages[f"page_{name}"].open()
        panel = window.net if name == "stereonet" else dock.widget()
        wait(lambda p=panel: driver.is_seen(p), f"the panel {name}")
        if name not in ("stereonet", "second_view"):
            # The tools of the net appear under the cursor; the second view is a picture.
            wait(lambda p=panel: visible_texts(p), f"the texts of the panel {name}")
        wait(lambda p=panel: not is_blank(p), f"the picture of the panel {name}")
        texts = visible_texts(panel)
        assert not [text for text in texts if "{" in text or "nan" in text.lower().split()], name
        driver.keep_picture(panel, f"panel-{name}")


def test_every_tool_activates_by_its_key_and_responds_to_clicks(interpreted) -> None:
    window = interpreted
    studio = window.studio
    middle = window.viewport.rect().center()
    before, label = dict(studio.records), studio.undo_label
    messages = []
    studio.notice.connect(messages.append)
    studio.selection_changed.connect(messages.append)
    for entry in TOOLS:
        window.viewport.setFocus()
        keys = QKeySequence(entry.key)[0]
        QTest.keyClick(window.viewport, keys.key(), keys.keyboardModifiers())
        assert studio.tool_name == entry.name, messages
        wait(lambda: not window.tool_panel.visibleRegion().isEmpty(), "the panel of the tool")
        assert visible_texts(window.tool_panel.currentWidget()), entry.name
        studio.selection.set(list(before)[-1:])
        messages.clear()
        for dx, dy in ((-80, 10), (-30, -35), (40, 30)):
            click(window.viewport, middle + QPoint(dx, dy))
            driver.pause(10)
        answered = bool(messages) or studio.open_tool is not None or studio.records != before
        assert answered, f"{entry.name} does not answer a click"
        for _ in range(6):
            key(window, Qt.Key.Key_Escape)
        while studio.records != before and studio.undo_label != label:
            studio.undo()
        assert studio.open_tool is None, entry.name
        assert dict(studio.records) == before, entry.name
        key(window, Qt.Key.Key_N)
        assert studio.tool is None
