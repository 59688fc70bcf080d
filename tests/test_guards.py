"""The guards see what they are there for."""

from __future__ import annotations

import textwrap
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

SHARED_LEAKS = """
    import threading
    from PySide6.QtCore import QTimer
    from PySide6.QtWidgets import QDialog
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    gate = threading.Event()
    kept = []

    def test_a_window(window):
        kept.append(QDialog(windowTitle="forgotten"))

    def test_a_timer(window):
        kept.append(QTimer())
        kept[-1].start(500)

    def test_an_object_of_vtk(window):
        kept.append(vtkPolyData())

    def test_threads(window):
        threading.Thread(target=gate.wait, name="left", daemon=True).start()

    def test_nothing(window):
        assert window.isVisible()
    """
SHARED_WORDS = (
    "earlier tests leave behind:",
    "a running thread: left",
    "a window: QDialog forgotten",
    "a running timer of 500 ms of NoneType",
    "1 *PolyData",
)
PLAIN_SHARED_WINDOW = """
    import pytest
    from PySide6.QtWidgets import QWidget
    from tests import guards

    @pytest.fixture(scope="module")
    def window(qapp):
        guards.begin_sharing()
        made = QWidget()
        made.show()
        yield made
        made.close()
        made.deleteLater()
        left = guards.end_sharing()
        if left:
            pytest.fail("earlier tests leave behind:\\n  " + "\\n  ".join(left))
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


def test_leaked_resources_fail_the_test(inner):
    inner.makepyfile(LEAKS)
    result = inner.runpytest_subprocess("-q")
    result.assert_outcomes(passed=5, errors=5, failed=1)
    result.stdout.fnmatch_lines_random([f"*{words}*" for words in WORDS])


@pytest.mark.full
def test_leaks_in_a_shared_window_fail_its_last_test(inner):
    """Threads are found after each test, windows, timers and VTK objects at the end."""
    inner.makepyfile(test_leaks=PLAIN_SHARED_WINDOW + SHARED_LEAKS)
    result = inner.runpytest_subprocess("-q")
    result.assert_outcomes(passed=5, errors=2)
    result.stdout.fnmatch_lines_random([f"*{words}*" for words in SHARED_WORDS])


@pytest.mark.full
def test_shared_window_leaks_do_not_fail_the_next_module(inner):
    inner.makepyfile(
        test_a=PLAIN_SHARED_WINDOW + SHARED_LEAKS, test_b="def test_of_another_module(qapp): pass"
    )
    result = inner.runpytest_subprocess("-q")
    result.assert_outcomes(passed=6, errors=2)


@pytest.mark.full
def test_leaks_in_the_journeys_window_are_detected(inner, monkeypatch):
    """The same with the real window, as the journeys share it; a dialog that belongs to it is
    closed before the next test."""
    monkeypatch.setenv("QT_QPA_PLATFORM", "xcb")
    folder = inner.mkdir("journeys")
    conftest = inner.path / "conftest.py"
    conftest.write_text(
        conftest.read_text("utf-8").replace("_PATIENCE_S = 0.1", "_PATIENCE_S = 5.0")
        + "\nfrom tests.conftest import own_folders, state_folder\n",
        "utf-8",
    )
    (folder / "conftest.py").write_text("from tests.journeys.conftest import *\n", "utf-8")
    leaks = textwrap.dedent(SHARED_LEAKS) + textwrap.dedent(
        """
        def test_what_goes_with_the_window(window):
            QDialog(window).show()

        def test_the_dialog_was_closed(window):
            assert not [dialog for dialog in window.findChildren(QDialog) if dialog.isVisible()]
        """
    )
    (folder / "test_leaks.py").write_text(leaks, "utf-8")
    result = inner.runpytest_subprocess("-q")
    result.assert_outcomes(passed=7, errors=2)
    result.stdout.fnmatch_lines_random([f"*{words}*" for words in SHARED_WORDS])


@pytest.mark.full
def test_released_resources_do_not_fail_the_test(inner):
    inner.makepyfile(QUIET)
    result = inner.runpytest_subprocess("-q")
    assert result.ret == 0, result.stdout.str()


def test_faulthandler_is_re_enabled_after_a_test_disables_it(
    request: pytest.FixtureRequest,
) -> None:
    import faulthandler

    from tests.guards import _watch_for_crashes

    faulthandler.disable()
    _watch_for_crashes(request.config)
    assert faulthandler.is_enabled()
