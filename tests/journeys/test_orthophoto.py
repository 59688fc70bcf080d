"""An orthophoto from the window: the present view, drawn in a worker, true to scale."""

from __future__ import annotations

import json

import numpy as np
import pytest
import rasterio
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from tests import driver
from tests.messages import shown_codes
from vomstudio.ui.dialogs.orthophoto_dialog import OrthoDialog


def dialog_of(window) -> OrthoDialog:
    shown = [d for d in window.findChildren(OrthoDialog) if d.isVisible()]
    return shown[0] if shown else None


@pytest.mark.parametrize("part", ["whole", pytest.param("seen", marks=pytest.mark.full)])
def test_orthophoto_is_made_along_current_view_direction(window, outcrop, tmp_path, part) -> None:
    model_id = driver.open_outcrop(window, outcrop)
    window.view.look_along(300.0, 20.0)
    driver.wait(lambda: window.viewport.is_still, "the camera's rest")
    window.actions_table.all["orthophoto"].trigger()
    driver.wait(lambda: dialog_of(window) is not None, "the dialog")
    dialog = dialog_of(window)
    driver.wait(dialog._start_button.isEnabled, "a proposed pixel size")
    assert shown_codes(dialog._direction_source) == {"view.direction-unmeasured"}
    assert "5.0°" in dialog._error_effect.text()
    if part == "seen":
        QTest.mouseClick(dialog.visible_area, Qt.MouseButton.LeftButton)
    for field, text in ((dialog.gsd, "0.02"), (dialog.target, str(tmp_path / "o.tif"))):
        field.setFocus()
        field.selectAll()
        QTest.keyClicks(field, text)
    driver.keep_picture(dialog, f"orthophoto-dialog-{part}")
    QTest.mouseClick(dialog._start_button, Qt.MouseButton.LeftButton)
    driver.wait((tmp_path / "o.json").exists, "the orthophoto", 60.0)
    driver.wait(lambda: not window.studio.jobs.visible(), "the end of the job")
    facts = json.loads((tmp_path / "o.json").read_text("utf-8"))
    assert facts["trend_deg"] == pytest.approx(300.0, abs=0.01)
    assert facts["plunge_deg"] == pytest.approx(20.0, abs=0.01)
    assert (tmp_path / "o_sheet.png").exists()
    with rasterio.open(tmp_path / "o.tif") as file:
        alpha = file.read(4)
    assert (alpha > 0).any()
    # Every pixel of the depth raster lies on the model: within its box, in World.
    with rasterio.open(tmp_path / "o_depth.tif") as file:
        depth = file.read(1)
    row, column = np.nonzero(np.isfinite(depth))
    matrix = np.array(facts["pixel_to_world"])
    places = np.column_stack([column + 0.5, row + 0.5, depth[row, column], np.ones(len(row))])
    low, high = window.studio.models[model_id].data.bounds
    world = (places @ matrix.T)[:, :3]
    assert (world > low - 0.05).all()
    assert (world < high + 0.05).all()


@pytest.mark.full
def test_unwritable_orthophoto_target_is_reported(window, outcrop, tmp_path) -> None:
    driver.open_outcrop(window, outcrop)
    window.actions_table.all["orthophoto"].trigger()
    driver.wait(lambda: dialog_of(window) is not None, "the dialog")
    dialog = dialog_of(window)
    driver.wait(dialog._start_button.isEnabled, "a proposed pixel size")
    dialog.target.setText(str(tmp_path / "no such folder" / "o.tif"))
    dialog.accept()
    driver.wait(lambda: "no such folder" in window.message_bar._text.text(), "the sentence")
