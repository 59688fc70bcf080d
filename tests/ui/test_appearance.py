"""Laws of appearance: texts are whole, readable and large enough, and the focus is seen."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QRect, Qt
from PySide6.QtGui import QImage
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QWidget

from tests import appearance, driver
from tests.tiers import first_in_default_tier
from tests.ui.conftest import add_bed, add_cliff
from vomstudio.ui.base import theme
from vomstudio.ui.shell.layout import REGIONS, WORKSPACES

THEMES = ["light", pytest.param("dark", marks=pytest.mark.full)]
MIN_FRAME_CONTRAST = 3.0
"""Of parts of a control that are needed to use it (WCAG 2.1, 1.4.11)."""


@pytest.fixture(params=THEMES)
def shown(request, window, studio) -> Iterator[str]:
    """The window in a theme, with a model and two beds."""
    add_cliff(studio)
    add_bed(studio)
    add_bed(studio, "t2", dip=0.2)
    window.actions_table.run(f"theme_{request.param}")
    driver.pause(50)
    yield request.param
    theme.use("system")


@pytest.mark.parametrize("region", first_in_default_tier(["inspector", "drawer"]))
def test_texts_of_all_pages_are_complete_and_readable(window, shown, region) -> None:
    """In every workspace. The net is a figure, which has tests of its own."""
    window.resize(1280, 720)
    found = {}
    if region == "inspector":
        for workspace in WORKSPACES:
            window.workspaces.switch(workspace.name)
            driver.pause(0)
            found[f"workspace {workspace.name}"] = appearance.violations(window)
    for name in (each for each, place in REGIONS.items() if place == region):
        window.docks.bring_forward(name)
        driver.pause(0)
        found[f"page {name}"] = appearance.violations(driver.page(window, name))
    assert {page: each for page, each in found.items() if each} == {}


def picture(widget: QWidget) -> np.ndarray:
    """The pixels (h, w, 3) of a widget."""
    image = widget.grab().toImage().convertToFormat(QImage.Format.Format_RGB32)
    pixels = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1, 4)
    return pixels[:, : image.width(), 2::-1].astype(int)


def test_tab_moves_a_visible_focus_in_reading_order(window, shown) -> None:
    window.resize(1280, 720)
    driver.pause(30)
    seen: dict[str, float] = {}
    places: list[QRect] = []
    window.tree.tree.setFocus()
    for _ in range(40):
        QTest.keyClick(QApplication.focusWidget() or window, Qt.Key.Key_Tab)
        focused = QApplication.focusWidget()
        if focused is None or focused is window.viewport:
            continue
        name = f"{type(focused).__name__} {focused.objectName()}"
        if name in seen:
            continue
        places.append(QRect(focused.mapTo(window, QPoint(0, 0)), focused.size()))
        driver.pause(10)
        with_focus = picture(focused)
        focused.clearFocus()
        without = picture(focused)
        focused.setFocus(Qt.FocusReason.TabFocusReason)
        changed = np.abs(with_focus - without).max(axis=2) > 8
        pairs = np.stack([with_focus[changed], without[changed]], axis=1).reshape(-1, 2, 3)
        ratios = [appearance.strongest_contrast(pair) for pair in np.unique(pairs, axis=0)]
        seen[name] = max(ratios, default=1.0)
    assert len(seen) >= 8
    # In a column, the next one is below; only the change to another region goes up.
    upwards = [
        (a, b)
        for a, b in pairwise(places)
        if b.bottom() < a.top() and b.left() < a.right() and a.left() < b.right()
    ]
    assert len(upwards) <= 2, upwards
    assert {name: ratio for name, ratio in seen.items() if ratio < MIN_FRAME_CONTRAST} == {}
