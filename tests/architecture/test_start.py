"""What stands before the first picture of the window."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

SECOND_VIEW = {"pyvista", "pyvistaqt", "qtpy"}
HEAVY = SECOND_VIEW | {
    "numpy",
    "scipy",
    "numba",
    "vtkmodules",
    "matplotlib",
    "PIL",
    "pandas",
    "pyproj",
    "h5py",
}


AFTER_PAINT = (
    "email",
    "vomstudio.geometry",
    "vomstudio.project.records",
    "vomstudio.studio.workspace",
    "vomstudio.ui.panels",
)
"""What the first paint of the empty frame does not need."""
LATER = (
    "scipy",
    "numba",
    "llvmlite",
    "vtkmodules",
    "matplotlib",
    "pandas",
    "pyproj",
    "lxml",
    "vomstudio.geology.folds",
    "vomstudio.io.photos.own_cameras",
    "vomstudio.project.exports.export",
)
"""What a filled, empty window does not need."""
MAX_MODULES = 980
"""Modules of a filled, empty window; this number may only fall."""
FILL = """
import os, sys
from PySide6.QtWidgets import QApplication
application = QApplication([])
from vomstudio.io.settings import read_settings
from vomstudio.ui.shell.main_window import MainWindow
window = MainWindow(read_settings()[0])
window.begin([])
print(*sys.modules, flush=True)
os._exit(0)
"""


def packages_after(*modules: str) -> set[str]:
    """Packages and modules that a new process has imported after these modules."""
    names = ", ".join(modules)
    words = [sys.executable, "-c", f"import sys, {names}; print(*sys.modules)"]
    done = subprocess.run(words, capture_output=True, text=True, check=True, timeout=120)
    return set(done.stdout.split())


def test_empty_window_imports_no_heavy_library() -> None:
    """It stands on the screen within a second; what fills it is imported behind it."""
    packages = packages_after(
        "vomstudio.ui.shell.main_window", "vomstudio.ui.widgets.failure_notices"
    )
    assert not HEAVY & packages
    assert [name for name in AFTER_PAINT if name in packages] == []
    assert "PySide6" in packages


def test_viewport_does_not_import_libraries_of_second_view() -> None:
    packages = packages_after(
        "vomstudio.rendering.qt.viewport",
        "vomstudio.rendering.scene.scene",
        "vomstudio.rendering.scene.shared_scene",
        "vomstudio.ui.panels.view.second_view_panel",
    )
    assert "vtkmodules" in packages
    assert not SECOND_VIEW & packages


def test_filling_window_does_not_import_modules_needed_only_for_models(own_folders: Path) -> None:
    """Its first complete picture waits for all that is imported here."""
    done = subprocess.run(
        [sys.executable, "-c", FILL],
        env=os.environ | {"QT_QPA_PLATFORM": "offscreen"},
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    modules = done.stdout.split()
    assert "vomstudio.ui.panels.photos.photos_panel" in modules
    assert [name for name in LATER if name in modules] == []
    assert len(modules) <= MAX_MODULES
