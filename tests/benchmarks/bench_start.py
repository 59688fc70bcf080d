"""How soon the window is on the screen, its first frame, and the outcrop, beside CloudCompare.

    xvfb-run -a -s '-screen 0 1600x1000x24 +extension GLX' \\
        python -m tests.benchmarks.bench_start [ROOT]

ROOT is another checkout, which is measured in turn with this one.

It starts a window manager, because one shows a window some time after the program asks for it: work
that does not wait for this delays the first paint, which is not seen on a bare X server. Each run
is a process of its own with its byte code stored, as in an installed program; times count from
before the process is started, and the processor seconds beside them are those of the process.
CloudCompare's window is looked for with xdotool every 10 ms, because `xdotool --sync` looks only
every half second; its time is until the window is mapped. The first run fills the disk cache and
is not counted. The last lines are of one more run, with the time of every import in it.
"""

from __future__ import annotations

import os
import re
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
    print("lap", name, file=sys.stderr, flush=True)
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


def start(root: Path, model: Path, home: Path, *options: str) -> tuple[dict[str, Lap], str]:
    """Return the laps of one start, by name, and what the process wrote to stderr."""
    home.mkdir(exist_ok=True)
    environment = dict(os.environ, BEGAN=str(time.time()), PYTHONPATH=str(root))
    environment.update(XDG_STATE_HOME=str(home), VOMSTUDIO_SETTINGS=str(home / "s.toml"))
    # The first run compiles the modules, as an installation does.
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    environment["PYTHONPYCACHEPREFIX"] = str(home / "bytecode")
    done = subprocess.run(
        [sys.executable, "-P", *options, "-c", CHILD, str(model)],
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    laps = (line.split() for line in done.stdout.splitlines())
    return {name: Lap(float(t), float(cpu), int(n)) for name, t, cpu, n in laps}, done.stderr


def import_seconds(log: str) -> dict[str, float]:
    """Return the time of all imports until each lap, from the log of `-X importtime`."""
    seconds, total = {}, 0.0
    for line in log.splitlines():
        if line.startswith("lap "):
            seconds[line.removeprefix("lap ")] = total
        elif match := re.match(r"import time:\s+(\d+) \|", line):
            total += int(match[1]) / 1e6
    return seconds


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
    roots = {"this": ROOT}
    if len(sys.argv) > 1:
        roots["other"] = Path(sys.argv[1]).resolve()
    runs: dict[str, list[dict[str, Lap]]] = {name: [] for name in roots}
    peer = []
    with tempfile.TemporaryDirectory() as home, window_manager() as manager:
        print(f"window manager: {manager}")
        for number in range(RUNS + 1):
            # Every second time in reverse order.
            order = (*roots, "peer") if number % 2 == 0 else ("peer", *reversed(roots))
            for who in order:
                if who == "peer":
                    peer.append(cloudcompare())
                else:
                    runs[who].append(start(roots[who], model, Path(home) / who)[0])
        logs = {
            who: start(root, model, Path(home) / who, "-X", "importtime")[1]
            for who, root in roots.items()
        }
    for who in roots:
        print(f"{who}: {roots[who]}")
        _report(runs[who][1:], import_seconds(logs[who]))
    if times := [seconds for seconds in peer[1:] if seconds is not None]:
        print(f"CloudCompare window mapped: median {statistics.median(times):.2f} s")
    else:
        print("CloudCompare or xdotool is not installed: no peer")


def _report(runs: list[dict[str, Lap]], imports: dict[str, float]) -> None:
    for name, wanted in (("window", "0.35 s"), ("frame", "0.95 s"), ("outcrop", "-")):
        times = sorted(run[name].seconds for run in runs)
        low, high = times[0], times[-1]
        busy = statistics.median(run[name].processor_s for run in runs)
        print(
            f"{name:8s} median {statistics.median(times):.2f} s  ({low:.2f}..{high:.2f}),"
            f" processor {busy:.2f} s, {runs[-1][name].modules} modules; wanted {wanted}"
        )
    before_frame = imports["frame"] - imports["window"]
    print(f"imports  {before_frame:.2f} s between window and frame; wanted 0.4 s")


if __name__ == "__main__":
    main()
