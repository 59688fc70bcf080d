"""What stands before the first picture of the window."""

from __future__ import annotations

import subprocess
import sys

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


def packages_after(*modules: str) -> set[str]:
    """Packages that a new process has imported after these modules."""
    names = ", ".join(modules)
    code = f"import sys, {names}; print(*{{name.partition('.')[0] for name in sys.modules}})"
    words = [sys.executable, "-c", code]
    done = subprocess.run(words, capture_output=True, text=True, check=True, timeout=120)
    return set(done.stdout.split())


def test_the_empty_window_is_there_before_any_heavy_library() -> None:
    """It stands on the screen within a second; what fills it is imported behind it."""
    packages = packages_after(
        "vomstudio.ui.shell.main_window", "vomstudio.ui.widgets.failure_notices"
    )
    assert not HEAVY & packages
    assert "PySide6" in packages


def test_a_window_with_its_viewport_leaves_out_the_libraries_of_the_second_view() -> None:
    packages = packages_after(
        "vomstudio.rendering.qt.viewport",
        "vomstudio.rendering.scene.scene",
        "vomstudio.rendering.scene.shared_scene",
        "vomstudio.ui.panels.view.second_view_panel",
    )
    assert "vtkmodules" in packages
    assert not SECOND_VIEW & packages
