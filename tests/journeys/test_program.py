"""`vomstudio` as a process of its own, as people start it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest

from tests import driver
from tests.journeys.test_kills import ROOT, alive, descendants
from vomstudio.core.paths import resource
from vomstudio.project.folder import untitled_folder

pytestmark = pytest.mark.full

# Where Python ends itself at the end of the program, the process ends by SIGABRT.
NEVER_ENDED = """
import ctypes, sys

ctypes.pythonapi.Py_AtExit(ctypes.CDLL(None).abort)
sys.argv[0] = "vomstudio"
from vomstudio.app import main
sys.exit(main())
"""


def start(*words: str, program: tuple[str, ...] = ("-m", "vomstudio")) -> subprocess.Popen[str]:
    environment = {**os.environ, "PYTHONWARNINGS": "error::ResourceWarning"}
    return subprocess.Popen(
        [sys.executable, *program, *words],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment,
    )


def until_there(process: subprocess.Popen[str], seconds: float = 30.0) -> None:
    """The window has its project, and its workers have begun."""
    end = time.monotonic() + seconds
    while not (list(untitled_folder().glob("*.vom/lock")) and descendants(process.pid)):
        assert process.poll() is None, process.stderr.read()
        assert time.monotonic() < end, "the window does not come"
        time.sleep(0.05)


@pytest.mark.parametrize(
    "words",
    [pytest.param((), marks=pytest.mark.slow), (str(resource("outcrop", "outcrop.obj")),)],
    ids=["empty", "with a model"],
)
def test_ctrl_c_closes_the_window_cleanly(own_folders, qapp, words):
    with start(*words) as process:
        until_there(process)
        time.sleep(1.0)
        workers = descendants(process.pid)
        os.kill(process.pid, signal.SIGINT)
        code = process.wait(20)
        out, err = process.stdout.read(), process.stderr.read()
    assert code == 0, err
    assert out == ""
    assert "Traceback" not in err
    assert "Warning" not in err, err
    assert not any(alive(pid) for pid in workers)
    assert list(untitled_folder().glob("*.vom")) == [], "a window without work leaves nothing"


@pytest.mark.skipif(os.name == "nt", reason="there is no libc to take abort from")
def test_window_exits_without_python_finalization(own_folders, qapp):
    """It would end with SIGSEGV or SIGABRT whenever a thread is inside of a library then."""
    with start(program=("-c", NEVER_ENDED)) as process:
        until_there(process)
        os.kill(process.pid, signal.SIGINT)
        code = process.wait(20)
        err = process.stderr.read()
    assert (code, err) == (0, "")
    assert list(untitled_folder().glob("*.vom")) == []


@pytest.mark.slow
def test_missing_path_is_reported_and_window_stays_open(own_folders, qapp):
    with start("/nowhere/cliff.obj") as process:
        until_there(process)
        time.sleep(0.5)
        assert process.poll() is None
        os.kill(process.pid, signal.SIGINT)
        assert process.wait(20) == 0


@pytest.mark.full
def test_photos_on_the_command_line_open_in_the_center(own_folders, tmp_path, qtbot) -> None:
    (tmp_path / "photos").mkdir()
    window = driver.make_window([tmp_path / "photos"])
    driver.pause(300)
    assert window.docks.center_page == "photos"
    driver.dismiss(window)
