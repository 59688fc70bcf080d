"""A command that is asked to end while its own modules are still being read."""

from __future__ import annotations

import signal as signals
import subprocess
import sys

import pytest

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


@pytest.mark.parametrize("module", ["vomstudio.languages", "vomstudio.cli", "vomstudio.cli.info"])
@pytest.mark.parametrize("signal", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_it_ends_in_a_sentence(module: str, signal: str) -> None:
    words = [sys.executable, "-P", "-c", STOPPED.format(module=module, signal=signal)]
    done = subprocess.run(
        words, capture_output=True, text=True, check=False, timeout=120, preexec_fn=_hearing
    )
    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr == "vomstudio: Cancelled.\n"
