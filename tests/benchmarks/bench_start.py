"""How soon the window is on the screen, its first frame, and the outcrop, beside CloudCompare.

    xvfb-run -a -s '-screen 0 1600x1000x24 +extension GLX' python -m tests.benchmarks.bench_start

Each run is a process of its own; times count from before the process is started. CloudCompare's
window is found with xdotool, so its time is until the window is mapped. The first run warms the
disk cache and is not counted.
"""

from __future__ import annotations

import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
RUNS = 5

CHILD = """
import os, sys, time
began = float(os.environ["BEGAN"])
def lap(name):
    print(name, time.time() - began, flush=True)
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
        if any("complete" in shown.reached(model) for model in self.studio.models):
            self._look.stop()
            lap("outcrop")
            QTimer.singleShot(300, self.close)
main_window.MainWindow = Window
sys.exit(start.run_window(sys.argv[1:]))
"""


def ours(model: Path, home: Path) -> dict[str, float]:
    environment = dict(os.environ, BEGAN=str(time.time()), PYTHONPATH=str(ROOT))
    environment.update(XDG_STATE_HOME=str(home), VOMSTUDIO_SETTINGS=str(home / "s.toml"))
    done = subprocess.run(
        [sys.executable, "-c", CHILD, str(model)],
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    return {name: float(t) for name, t in (line.split() for line in done.stdout.splitlines())}


def cloudcompare() -> float | None:
    if not shutil.which("CloudCompare") or not shutil.which("xdotool"):
        return None
    began = time.time()
    child = subprocess.Popen(["CloudCompare"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        subprocess.run(
            ["xdotool", "search", "--sync", "--onlyvisible", "--name", "CloudCompare v"],
            capture_output=True,
            timeout=60,
            check=True,
        )
        return time.time() - began
    except subprocess.SubprocessError:
        return None
    finally:
        child.kill()
        child.wait()


def main() -> None:
    model = ROOT / "resources" / "outcrop" / "outcrop.obj"
    runs, peer = [], []
    with tempfile.TemporaryDirectory() as home:
        for number in range(RUNS + 1):
            # Every second time the peer first.
            order = ("ours", "peer") if number % 2 == 0 else ("peer", "ours")
            for who in order:
                if who == "ours":
                    runs.append(ours(model, Path(home)))
                else:
                    peer.append(cloudcompare())
    runs, peer = runs[1:], [t for t in peer[1:] if t is not None]
    for name, wanted in (("window", "0.2 s"), ("frame", "0.95 s"), ("outcrop", "-")):
        times = sorted(run[name] for run in runs)
        low, high = times[0], times[-1]
        print(
            f"{name:8s} median {statistics.median(times):.2f} s  ({low:.2f}..{high:.2f});"
            f" wanted {wanted}"
        )
    if peer:
        print(f"CloudCompare window mapped: median {statistics.median(peer):.2f} s")
    else:
        print("CloudCompare or xdotool is not installed: no peer")


if __name__ == "__main__":
    main()
