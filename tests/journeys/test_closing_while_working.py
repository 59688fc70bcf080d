"""The window is closed while something is worked out, written or looked for beside it: it closes at
once, nothing goes on, and no half-written file stays."""

from __future__ import annotations

import threading
import time

import pytest
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QPushButton, QWidget

from tests import driver
from tests.driver import LEFT, NONE, wait
from vomstudio.ui.dialogs.orthophoto_dialog import OrthoDialog
from vomstudio.ui.panels.sections.elevation_panel import ElevationPanel
from vomstudio.ui.panels.surface.facets_panel import FacetsPanel
from vomstudio.ui.panels.surface.fields_panel import FieldsPanel
from vomstudio.ui.panels.surface.traces_panel import TracesPanel

pytestmark = pytest.mark.full

BUTTONS: dict[str, tuple[type[QWidget], str]] = {
    "surface_fields": (FieldsPanel, "start"),
    "propose_facets": (FacetsPanel, "start"),
    "propose_traces": (TracesPanel, "start"),
    "elevation_model": (ElevationPanel, "start"),
}
"""What begins each: the command that shows the panel, the panel and its button."""


def press(button: QPushButton) -> None:
    QTest.mouseClick(button, LEFT, NONE, button.rect().center())


def begin(window, name: str, folder) -> None:
    if name == "orthophoto":
        window.actions_table.run(name)
        wait(lambda: window.findChild(OrthoDialog), "the dialog")
        dialog = window.findChild(OrthoDialog)
        wait(dialog._start_button.isEnabled, "a proposed pixel size")
        dialog.gsd.setText("0.004")
        dialog.target.setText(str(folder / "view.tif"))
        press(dialog._start_button)
        return
    window.actions_table.run(name)
    kind, button = BUTTONS[name]
    panel = window.findChild(kind)
    if name == "elevation_model":
        panel.target.setText(str(folder / "heights.tif"))
        panel.target.setModified(True)
    wait(getattr(panel, button).isEnabled, "the model")
    press(getattr(panel, button))


@pytest.mark.parametrize("moment_ms", [0, 150])
@pytest.mark.parametrize("name", ["orthophoto", *BUTTONS])
def test_window_can_be_closed_during_a_computation(
    own_folders, qtbot, outcrop, tmp_path, name, moment_ms
):
    before = set(threading.enumerate())
    window = driver.make_window()
    driver.open_outcrop(window, outcrop)
    out = tmp_path / "out"
    out.mkdir()
    begin(window, name, out)
    driver.pause(moment_ms)
    processes = [w._process for w in window.studio.jobs.workers.values() if w._process]
    started = time.process_time()
    driver.close(window)
    assert time.process_time() - started < 3.0
    wait(lambda: all(p.poll() is not None for p in processes), "the end of the workers", 10.0)
    wait(lambda: set(threading.enumerate()) <= before, "the end of the threads", 20.0)
    left = [path.name for path in out.iterdir()]
    assert not [name for name in left if name.startswith(".") or "tmp" in name or "part" in name]
