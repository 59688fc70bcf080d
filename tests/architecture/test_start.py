"""What stands before the first picture of the window."""

from __future__ import annotations

import subprocess
import sys

HEAVY = {"numpy", "scipy", "numba", "vtkmodules", "matplotlib", "PIL", "pandas", "pyproj", "h5py"}


def test_the_empty_window_is_there_before_any_heavy_library() -> None:
    """It stands on the screen within a second; what fills it is imported behind it."""
    modules = "vomstudio.ui.shell.main_window, vomstudio.ui.widgets.failure_notices"
    code = f"import sys, {modules}; print(*{{name.partition('.')[0] for name in sys.modules}})"
    words = [sys.executable, "-c", code]
    done = subprocess.run(words, capture_output=True, text=True, check=True, timeout=60)
    assert not HEAVY & set(done.stdout.split())
    assert "PySide6" in done.stdout
