"""A command that is asked to end while its own modules are still being read."""

from __future__ import annotations

import os
import signal as signals
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from tests.tiers import first_in_default_tier

STOPPED = """
import os, signal, sys
import vomstudio.app

class Asking:
    def find_spec(self, name, path=None, target=None):
        if name == "{module}":
            os.kill(os.getpid(), signal.{signal})

sys.meta_path.insert(0, Asking())
sys.exit(vomstudio.app.main(["info", "nothing.obj"]))
"""

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such signals")


def _hearing() -> None:
    """Whoever runs the tests in the background hands down an ignored SIGINT."""
    signals.signal(signals.SIGINT, signals.default_int_handler)
    signals.signal(signals.SIGTERM, signals.SIG_DFL)
    signals.signal(signals.SIGHUP, signals.SIG_DFL)


@pytest.mark.parametrize(
    "module",
    first_in_default_tier(["vomstudio.core.languages", "vomstudio.cli", "vomstudio.cli.info"], 3),
)
@pytest.mark.parametrize("signal", first_in_default_tier(["SIGINT", "SIGTERM", "SIGHUP"], 3))
def test_signal_during_imports_exits_with_130_and_one_line(module: str, signal: str) -> None:
    words = [sys.executable, "-P", "-c", STOPPED.format(module=module, signal=signal)]
    done = subprocess.run(
        words, capture_output=True, text=True, check=False, timeout=120, preexec_fn=_hearing
    )
    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr == "vomstudio: Cancelled.\n"


def run_stopped(script: str, *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-P", "-c", script, *words],
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
        preexec_fn=_hearing,
    )


FROM_A_TEXT = """
import os, signal, sys
import vomstudio.app

class Asking:
    def find_spec(self, name, path=None, target=None):
        if name == "vomstudio.cli.info":
            exec("os.kill(os.getpid(), signal.SIGINT)")  # as a dataclass that is being made

sys.meta_path.insert(0, Asking())
sys.argv = ["vomstudio", "info", "nothing.obj"]
sys.exit(vomstudio.app.main())
"""


def test_interruption_of_code_compiled_from_text_exits_with_130(tmp_path: Path) -> None:
    """Python ends a module (-m) by the signal where one left such code, even though it was
    caught."""
    (tmp_path / "asking.py").write_text(FROM_A_TEXT)
    paths = [str(tmp_path), *filter(None, [os.environ.get("PYTHONPATH")])]
    done = subprocess.run(
        [sys.executable, "-m", "asking"],
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
        preexec_fn=_hearing,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
    )
    assert (done.returncode, done.stderr) == (130, "vomstudio: Cancelled.\n")


SWALLOWED = """
import os, signal, sys
import vomstudio.app

class Asking:
    def find_spec(self, name, path=None, target=None):
        if name == "{module}":
            try:
                os.kill(os.getpid(), signal.SIGINT)
                for _ in range(1000):
                    pass
            except BaseException:  # as some libraries do
                pass

sys.meta_path.insert(0, Asking())
sys.argv = ["vomstudio", *sys.argv[1:]]
sys.exit(vomstudio.app.main())
"""


@pytest.mark.parametrize("module", ["vomstudio.cli.fit", "vomstudio.project.tables.fitted_planes"])
def test_swallowed_interruption_still_cancels_the_command(module: str, tmp_path: Path) -> None:
    points, out = tmp_path / "points.txt", tmp_path / "out.csv"
    points.write_text("0 0 0\n1 0 0\n0 1 0\n1 1 0.01\n")
    done = run_stopped(SWALLOWED.format(module=module), "fit", str(points), "-o", str(out))
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "vomstudio: Cancelled.\n")
    assert not out.exists()


AFTERWARDS = """
import atexit, os, signal, sys
import vomstudio.app

atexit.register(os.kill, os.getpid(), signal.SIGINT)
sys.argv = ["vomstudio", "--version"]
sys.exit(vomstudio.app.main())
"""


def test_signal_after_completion_is_ignored() -> None:
    done = run_stopped(AFTERWARDS)
    assert (done.returncode, done.stderr) == (0, "")


AT_ITS_BEGINNING = """
import os, signal, sys

class Asking:
    def find_spec(self, name, path=None, target=None):
        if name == "{module}":
            os.kill(os.getpid(), signal.{signal})
            for _ in range(100): pass

sys.meta_path.insert(0, Asking())
sys.argv = ["vomstudio", *{words}]
{begin}
"""
AS_MODULE = 'import runpy; runpy.run_module("vomstudio", run_name="__main__")'
PYPROJECT = Path(__file__).parents[2] / "pyproject.toml"


def _as_command() -> str:
    """What the script does that an installer makes of the entry point."""
    said = tomllib.loads(PYPROJECT.read_text("utf-8"))["project"]["scripts"]["vomstudio"]
    module, _, name = said.partition(":")
    return f"from {module} import {name}; sys.exit({name}())"


@pytest.mark.parametrize(
    "begin", first_in_default_tier([AS_MODULE, _as_command()], 4), ids=["module", "command"]
)
@pytest.mark.parametrize(
    ("module", "words"),
    first_in_default_tier(
        [
            ("vomstudio.app", ["info", "nothing.obj"]),
            ("vomstudio.core.failures", ["info", "nothing.obj"]),
            ("vomstudio.app", []),
            ("vomstudio.ui.shell.window_start", []),
        ],
        4,
    ),
)
@pytest.mark.parametrize("signal", first_in_default_tier(["SIGINT", "SIGTERM", "SIGHUP"], 4))
def test_signals_are_handled_from_the_first_module_on(
    begin: str, module: str, words: list[str], signal: str
) -> None:
    done = run_stopped(
        AT_ITS_BEGINNING.format(module=module, signal=signal, words=words, begin=begin)
    )
    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr == "vomstudio: Cancelled.\n"


@pytest.mark.parametrize("signal", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_terminal_signals_do_not_end_a_worker(signal: str) -> None:
    script = AT_ITS_BEGINNING.format(
        module="vomstudio.app", signal=signal, words=["--worker"], begin=AS_MODULE
    )
    done = subprocess.run(
        [sys.executable, "-P", "-c", script],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
        preexec_fn=_hearing,
    )
    assert done.returncode == 0, done.stderr
