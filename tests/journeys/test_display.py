"""Fields and the clipping box in the real window, and after opening the project again."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtGui import QImage
from PySide6.QtWidgets import QApplication

from tests import driver
from tests.driver import wait


def choose_field(window, name: str) -> None:
    """Choose a field on the page Display as a user does."""
    window.docks.bring_forward("display")
    box = window.display_panel.field
    index = next(i for i in range(box.count()) if box.itemText(i).startswith(name))
    box.setCurrentIndex(index)
    box.activated.emit(index)


def picture(window) -> np.ndarray:
    image = window.viewport.grab().toImage().convertToFormat(QImage.Format.Format_RGB888)
    raw = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1)
    return raw[:, : 3 * image.width()].reshape(image.height(), image.width(), 3).astype(int)


@pytest.mark.full
@pytest.mark.usefixtures("new_window")
def test_field_and_clipping_box_are_restored_when_the_project_reopens(window, outcrop, tmp_path):
    model_id = driver.open_outcrop(window, outcrop)
    window.docks.bring_forward("display")
    driver.settled(window)
    before = picture(window)
    choose_field(window, "Elevation")
    wait(lambda: window.viewport.display.color_scale(model_id) is not None, "the field")
    wait(lambda: window.viewport.overlays.bars, "the colour bar")
    driver.settled(window)
    assert np.abs(picture(window) - before).max() > 80
    window.actions_table.run("clipping_box")
    box = window.studio.display.box
    assert box is not None
    middle = (box.low[0] + box.high[0]) / 2
    window.display_panel.faces[1].setValue(middle)
    assert abs(window.viewport.clip.box.high[0] - middle) < 0.01
    folder = tmp_path / "kept.vom"
    window.studio.save_as(folder)
    kept = window.studio.display.to_dict()
    window.close()
    QApplication.processEvents()

    again = driver.make_window([folder])
    try:
        wait(lambda: model_id in again.studio.models, "the model")
        wait(lambda: again.viewport.display.color_scale(model_id) is not None, "the field")
        assert again.studio.display.to_dict() == kept
        assert again.viewport.clip.box == window.studio.display.box
        assert again.actions_table.all["clipping_box"].isChecked()
    finally:
        driver.dismiss(again)
