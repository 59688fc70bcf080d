"""PySide must not read the sources of what the window imports: that is a tenth of the start."""

from __future__ import annotations

import subprocess
import sys

SCRIPT = """
import linecache
import PySide6.QtCore
from vomstudio.ui.shell import window_start
if {quiet}:
    window_start._disable_source_reading()
before = set(linecache.cache)
import vomstudio.geometry.lines, xml.dom.minidom
assert PySide6.QtCore.QPointF(1.0, 2.0).toTuple() == (1.0, 2.0)
print(len(set(linecache.cache) - before))
"""


def read(*, quiet: bool) -> int:
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT.format(quiet=quiet)],
        capture_output=True,
        text=True,
        check=True,
    )
    return int(done.stdout)


def test_pyside_reads_no_source_files_when_disabled() -> None:
    assert read(quiet=False) > 0, "PySide reads none by itself any more: the telling can go"
    assert read(quiet=True) == 0
