"""A command that is asked to end while a library swallows the interruption says so, and no more."""

from __future__ import annotations

import signal
import subprocess
import sys

import pytest

from tests.tiers import first_in_default_tier

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no process signals itself there")

BEGIN = """
import os, signal, sys

class Lost:
    def __del__(self):
        os.kill(os.getpid(), signal.{name})
        for _ in range(100): pass

class Swallows:
    def find_spec(self, name, path=None, target=None):
        if name == "vomstudio.cli.fit":
            {how}

sys.meta_path.insert(0, Swallows())
from vomstudio.app import main
sys.argv = ["vomstudio", "fit", "none.csv"]
raise SystemExit(main())
"""
WRAPPED = """
            try:
                os.kill(os.getpid(), signal.{name})
                for _ in range(100): pass
            except KeyboardInterrupt:
                raise ImportError("PyCapsule_Import could not import module 'datetime'")
"""


def _hearing() -> None:
    """Whoever runs the tests in the background may have all of them ignored."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for each in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(each, signal.SIG_DFL)


@pytest.mark.parametrize("name", first_in_default_tier(["SIGINT", "SIGTERM", "SIGHUP"], 2))
@pytest.mark.parametrize(
    "how", first_in_default_tier([WRAPPED, "Lost()"], 2), ids=["another error", "lost"]
)
def test_interruption_swallowed_by_a_library_still_cancels(name: str, how: str) -> None:
    script = BEGIN.replace("{how}", how.strip()).replace("{name}", name)
    done = subprocess.run(
        [sys.executable, "-c", script],
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=_hearing,
    )
    assert (done.returncode, done.stderr) == (130, "vomstudio: Cancelled.\n")
