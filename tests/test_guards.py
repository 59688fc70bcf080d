"""The guards see what they are there for."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest_plugins = ["pytester"]
ROOT = Path(__file__).resolve().parents[1]

LEAKS = """
    import logging, threading
    from PySide6.QtCore import QTimer, qWarning
    from PySide6.QtWidgets import QDialog
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    gate = threading.Event()
    kept = []

    def test_a_thread():
        threading.Thread(target=gate.wait, name="left", daemon=True).start()

    def test_a_log_record():
        logging.getLogger("vomstudio.deep").warning("not %s", "well")

    def test_a_window(qapp):
        kept.append(QDialog(windowTitle="forgotten"))

    def test_a_timer(qapp):
        kept.append(QTimer())
        kept[-1].start(500)

    def test_an_object_of_vtk():
        kept.append(vtkPolyData())

    def test_a_warning_of_qt(qtbot):
        qWarning("not well")
    """
WORDS = (
    "a running thread: left",
    "an unexpected log record: WARNING vomstudio.deep: not well",
    "a window: QDialog forgotten",
    "a running timer of 500 ms of NoneType",
    "1 *PolyData",
    "*Qt messages with level WARNING or above emitted",
)
QUIET = """
    import logging, threading
    import pytest
    from PySide6.QtCore import QTimer
    from PySide6.QtWidgets import QDialog
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    @pytest.mark.expects_log
    def test_it(qapp):
        logging.getLogger("vomstudio").error("as expected")
        threading.Thread(target=int).start()
        data = vtkPolyData()
        data.AddObserver("ModifiedEvent", lambda *_: data)
        dialog = QDialog()
        timer = QTimer(dialog)
        timer.start(500)
        dialog.deleteLater()

    def test_a_failure_is_not_a_leak(qapp):
        dialog = QDialog()
        pytest.xfail("known")
    """


@pytest.fixture
def inner(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> pytest.Pytester:
    """A folder of tests of its own under these guards, as if it opened windows."""
    pytester.makeini(
        "[pytest]\nqt_api = pyside6\nqt_log_level_fail = WARNING\naddopts = -p no:dash\n"
        "markers =\n    expects_log: x\n"
    )
    pytester.makeconftest(
        f"import sys; sys.path.insert(0, {str(ROOT)!r})\n"
        "from tests import guards\n"
        "guards._PATIENCE_S = 0.1\n"
        "guards._MEMORY_PATIENCE_S = 0.2\n"
        f"guards._WINDOWS = ({str(pytester.path)!r},)\n"
        "from tests.guards import *\n"
        "from tests.guards import pytest_runtest_call, pytest_runtest_setup\n"
        "from tests.guards import pytest_runtest_teardown\n"
    )
    monkeypatch.setenv("QT_QPA_PLATFORM", "offscreen")
    return pytester


def test_what_a_test_leaves_behind_fails_it(inner):
    inner.makepyfile(LEAKS)
    result = inner.runpytest_subprocess("-q")
    result.assert_outcomes(passed=5, errors=5, failed=1)
    result.stdout.fnmatch_lines_random([f"*{words}*" for words in WORDS])


def test_what_a_test_clears_away_does_not_fail_it(inner):
    inner.makepyfile(QUIET)
    result = inner.runpytest_subprocess("-q")
    assert result.ret == 0, result.stdout.str()


def test_native_crashes_are_traced_again_after_a_test_of_the_programs_own_tracing(
    request: pytest.FixtureRequest,
) -> None:
    import faulthandler

    from tests.guards import _watch_for_crashes

    faulthandler.disable()
    _watch_for_crashes(request.config)
    assert faulthandler.is_enabled()
