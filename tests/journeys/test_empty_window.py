"""An empty window needs little memory, and what an open model needs is there in time."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import QTimer
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDialog

from tests import driver
from tests.driver import wait
from vomstudio.io.settings import read_settings
from vomstudio.project import edits
from vomstudio.project.kinds.reading import Reading
from vomstudio.ui.shell.main_window import MainWindow

HEAVY = ("vtkmodules", "matplotlib", "scipy", "pandas", "llvmlite", "pyproj", "lazrs")

AT_REST = """
import json, sys
import psutil
from PySide6.QtCore import QTimer
from vomstudio.geometry.kernels import compilation_state
from vomstudio.ui.shell import main_window, window_start

compilation_state.record_compilation()

class Window(main_window.MainWindow):
    def begin(self, paths):
        super().begin(paths)
        self._look = QTimer(self, interval=50)
        self._look.timeout.connect(self.look)
        self._look.start()

    def look(self):
        workers = psutil.Process().children()
        if not workers or self.studio.jobs.jobs:
            return
        self._look.stop()
        libraries = [
            sorted({m.path for m in each.memory_maps()}) for each in (psutil.Process(), *workers)
        ]
        print(json.dumps(libraries))
        self.close()

main_window.MainWindow = Window
sys.exit(window_start.run_window([]))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="libraries in memory are listed on Linux")
def test_an_empty_window_and_its_worker_have_loaded_no_heavy_library(own_folders: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", AT_REST], capture_output=True, text=True, check=True, timeout=120
    )
    processes = json.loads(done.stdout)
    assert len(processes) == 2
    for libraries in processes:
        assert any("/numpy/" in path for path in libraries)
        assert [path for path in libraries if any(f"/{name}/" in path for name in HEAVY)] == []


@pytest.fixture
def empty(own_folders: Path, qtbot) -> Iterator[MainWindow]:
    """A window as a new user sees it, without anything open."""
    window = MainWindow(read_settings()[0])
    window.show()
    QTest.qWaitForWindowExposed(window)
    window.begin([])
    driver.pause(200)
    assert window.viewport.scene is None
    assert not hasattr(window, "net")
    yield window
    driver.dismiss(window)


def test_stereonet_is_created_when_a_model_opens(empty: MainWindow, outcrop: Path) -> None:
    driver.open_outcrop(empty, outcrop)
    wait(lambda: hasattr(empty, "net"), "the net")
    assert empty.net_overlay.isVisible()


def test_scene_and_stereonet_are_created_while_the_file_dialog_is_open(empty: MainWindow) -> None:
    def cancel() -> None:
        wait(lambda: empty.viewport.scene is not None and hasattr(empty, "net"), "scene and net")
        dialog = QApplication.activeModalWidget()
        assert isinstance(dialog, QDialog)
        dialog.reject()

    QTimer.singleShot(0, cancel)
    empty.actions_table.run("open")
    assert hasattr(empty, "net")


@pytest.mark.full
def test_stereonet_is_created_for_readings_without_a_model(empty: MainWindow) -> None:
    reading = Reading("r", "r", "bedding", "plane", 120.0, 30.0)
    assert empty.studio.attempt(edits.add_readings, [reading], [])
    wait(lambda: hasattr(empty, "net"), "the net")


@pytest.mark.full
@pytest.mark.parametrize("place", ["net_in_middle", "dock_net"])
def test_stereonet_is_created_wherever_it_is_shown(empty: MainWindow, place: str) -> None:
    empty.actions_table.run(place)
    wait(lambda: hasattr(empty, "net") and empty.net.isVisible(), "the net", 4.0)
