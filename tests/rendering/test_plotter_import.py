"""The thread that imports the libraries of the second view creates no Qt classes."""

from __future__ import annotations

import subprocess
import sys


def test_plotter_import_in_a_thread_loads_no_qt_modules() -> None:
    program = (
        "import sys\n"
        "from vomstudio.rendering.qt.second_view import import_plotter\n"
        "before = set(sys.modules)\n"
        "import_plotter()\n"
        "new = set(sys.modules) - before\n"
        "print('pyvista.plotting' in sys.modules,"
        " sorted(m for m in new if m.split('.')[0] in ('qtpy', 'PySide6', 'pyvistaqt')))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout.split("\n")[0] == "True []", done.stdout + done.stderr
