"""How soon the window is on the screen, its first frame, and the outcrop, beside CloudCompare.

    xvfb-run -a -s '-screen 0 1600x1000x24 +extension GLX' python -m tests.benchmarks.bench_start

It starts a window manager, because one shows a window some time after the program asks for it: work
that does not wait for this delays the first paint, which is not seen on a bare X server. Each run
is a process of its own with its byte code stored, as in an installed program; times count from
before the process is started, and the processor seconds beside them are those of the process.
CloudCompare's window is looked for with xdotool every 10 ms, because `xdotool --sync` looks only
every half second; its time is until the window is mapped. The first run fills the disk cache and
is not counted.
"""

from __future__ import annotations

import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
RUNS = 5
WINDOW_MANAGERS = ("openbox", "xfwm4", "icewm", "metacity")


class Lap(NamedTuple):
    """Time since the start, processor time, and number of imported modules."""

    seconds: float
    processor_s: float
    modules: int


CHILD = """
import os, sys, time
began = float(os.environ["BEGAN"])
def lap(name):
    print(name, time.time() - began, time.process_time(), len(sys.modules), flush=True)
from PySide6.QtCore import QTimer
from vomstudio.ui.shell import main_window
try:
    from vomstudio.ui.shell import window_start as start
except ImportError:  # an older program beside which this one is measured
    from vomstudio.ui.shell import start
class Window(main_window.MainWindow):
    def paintEvent(self, event):
        super().paintEvent(event)
        if not hasattr(self, "_painted"):
            self._painted = True
            lap("window")
    def begin(self, paths):
        super().begin(paths)
        self.viewport.first_frame.connect(lambda: lap("frame"))
        self._look = QTimer(self)
        self._look.timeout.connect(self.look)
        self._look.start(5)
    def look(self):
        shown = self.viewport.models
        if any("complete" in shown.reached_stages(model) for model in self.studio.models):
            self._look.stop()
            lap("outcrop")
            QTimer.singleShot(300, self.close)
main_window.MainWindow = Window
sys.exit(start.run_window(sys.argv[1:]))
"""


def ours(model: Path, home: Path) -> dict[str, Lap]:
    """Return the laps of one start, by name."""
    environment = dict(os.environ, BEGAN=str(time.time()), PYTHONPATH=str(ROOT))
    environment.update(XDG_STATE_HOME=str(home), VOMSTUDIO_SETTINGS=str(home / "s.toml"))
    # The first run compiles the modules, as an installation does.
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    environment["PYTHONPYCACHEPREFIX"] = str(home / "bytecode")
    done = subprocess.run(
        [sys.executable, "-c", CHILD, str(model)],
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    laps = (line.split() for line in done.stdout.splitlines())
    return {name: Lap(float(t), float(cpu), int(n)) for name, t, cpu, n in laps}


@contextmanager
def window_manager() -> Iterator[str]:
    """Run the first of the known window managers that is installed, and yield its name."""
    name = next((each for each in WINDOW_MANAGERS if shutil.which(each)), "")
    if not name:
        yield "none"
        return
    child = subprocess.Popen([name], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        time.sleep(1.0)
        yield name if child.poll() is None else "none"
    finally:
        child.kill()
        child.wait()


def cloudcompare() -> float | None:
    """Return the seconds until CloudCompare's window is mapped, or None without it."""
    if not shutil.which("CloudCompare") or not shutil.which("xdotool"):
        return None
    began = time.time()
    child = subprocess.Popen(["CloudCompare"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        while time.time() - began < 60.0:
            found = subprocess.run(
                ["xdotool", "search", "--onlyvisible", "--name", "CloudCompare v"],
                capture_output=True,
            )
            if found.returncode == 0 and found.stdout.strip():
                return time.time() - began
            time.sleep(0.01)
        return None
    finally:
        child.kill()
        child.wait()


def main() -> None:
    model = ROOT / "resources" / "outcrop" / "outcrop.obj"
    runs, peer = [], []
    with tempfile.TemporaryDirectory() as home, window_manager() as manager:
        print(f"window manager: {manager}")
        for number in range(RUNS + 1):
            # Every second time the peer first.
            order = ("ours", "peer") if number % 2 == 0 else ("peer", "ours")
            for who in order:
                if who == "ours":
                    runs.append(ours(model, Path(home)))
                else:
                    peer.append(cloudcompare())
    runs, peer = runs[1:], [t for t in peer[1:] if t is not None]
    for name, wanted in (("window", "0.35 s"), ("frame", "0.95 s"), ("outcrop", "-")):
        times = sorted(run[name].seconds for run in runs)
        low, high = times[0], times[-1]
        busy = statistics.median(run[name].processor_s for run in runs)
        print(
            f"{name:8s} median {statistics.median(times):.2f} s  ({low:.2f}..{high:.2f}),"
            f" processor {busy:.2f} s, {runs[-1][name].modules} modules; wanted {wanted}"
        )
    if peer:
        print(f"CloudCompare window mapped: median {statistics.median(peer):.2f} s")
    else:
        print("CloudCompare or xdotool is not installed: no peer")


if __name__ == "__main__":
    main()
