"""`vomstudio reconstruct` as a process that can be watched, stopped and killed."""

from __future__ import annotations

import json
import os
import queue
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import psutil

from tests.photogrammetry import photo_set

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = [sys.executable, "-m", "vomstudio", "reconstruct"]
# The machine may have other things to do.
PATIENCE_S = 300.0


def _heed_interrupts() -> None:
    signal.signal(signal.SIGINT, signal.SIG_DFL)


class Run:
    """One run. `events` of its progress are read as they come."""

    def __init__(self, photos: Path, out: Path, *words: object, quality: str = "preview") -> None:
        self.out = out
        self.process = subprocess.Popen(
            [
                *PROGRAM,
                str(photos),
                "-o",
                str(out),
                "--quality",
                quality,
                "--json",
                "--progress",
                "json",
                *map(str, words),
            ],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            encoding="utf-8",
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            cwd=ROOT,
            # A shell that runs the tests in the background has Ctrl+C ignored in all its children.
            preexec_fn=_heed_interrupts if os.name == "posix" else None,
        )
        self.lines: list[str] = []
        self._events: queue.SimpleQueue[dict[str, Any] | None] = queue.SimpleQueue()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self.process.stderr is not None
        for line in self.process.stderr:
            self.lines.append(line)
            try:
                self._events.put(json.loads(line))
            except ValueError:
                continue
        self._events.put(None)

    def until(self, stage: str, step: int = 0) -> None:
        """Until a stage whose name begins so is at work, and `step` of its steps are done."""
        end = time.monotonic() + PATIENCE_S
        while True:
            event = self._events.get(timeout=max(0.1, end - time.monotonic()))
            assert event is not None, f"ended before {stage}: {''.join(self.lines[-5:])}"
            name = event.get("stage", "")
            if name.startswith(stage) and (step == 0 or event.get("done", 0) >= step):
                return

    def worker(self) -> psutil.Process:
        """The child that does the work."""
        children = psutil.Process(self.process.pid).children()
        return next(c for c in children if "--worker" in c.cmdline())

    def everyone(self) -> list[psutil.Process]:
        me = psutil.Process(self.process.pid)
        return [me, *me.children(recursive=True)]

    def end(self) -> End:
        out = self.process.stdout
        assert out is not None
        said = out.read()
        code = self.process.wait(PATIENCE_S)
        self._close()
        return End(code, json.loads(said) if said.strip() else {}, "".join(self.lines))

    def kill_worker(self) -> End:
        self.worker().kill()
        return self.end()

    def kill(self) -> None:
        """The program, and nobody tells its worker."""
        others = self.everyone()[1:]
        self.process.kill()
        self.process.wait(10)
        _, alive = psutil.wait_procs(others, timeout=10)
        assert not alive, "a worker outlives its program"
        self._close()

    def _close(self) -> None:
        self._reader.join(10)
        for stream in (self.process.stdout, self.process.stderr):
            assert stream is not None
            stream.close()

    def interrupt(self) -> End:
        """Ctrl+C."""
        others = self.everyone()
        begun = time.monotonic()
        self.process.send_signal(signal.SIGINT)
        end = self.end()
        end.seconds = time.monotonic() - begun
        _, alive = psutil.wait_procs(others, timeout=10)
        assert not alive, "something goes on after Ctrl+C"
        return end


class End:
    def __init__(self, code: int, json_: dict[str, Any], err: str) -> None:
        self.code, self.json, self.err = code, json_, err
        self.seconds = 0.0

    @property
    def message(self) -> str:
        return str(self.json["error"]["message"])


def reconstruct(photos: Path, out: Path, *words: object) -> End:
    return Run(photos, out, *words).end()


def refused(end: End, code: int = 2) -> dict[str, Any]:
    """The error of a run that failed as it should."""
    assert end.code == code, end.err
    assert set(end.json) == {"error"}
    assert "Traceback" not in end.err, end.err
    assert "\n" not in end.message
    error: dict[str, Any] = end.json["error"]
    assert error["code"] != "command.internal-error"
    return error


def stages(out: Path) -> dict[str, int]:
    """Finished stages, and when each was."""
    found = (out / "work").glob("*/stage.json")
    return {p.parent.name: p.stat().st_mtime_ns for p in found if p.parent.suffix != ".part"}


def log_of(out: Path) -> str:
    """The log of the last run."""
    text = (out / "log.txt").read_text(encoding="utf-8")
    return "VOM Studio" + text.split("VOM Studio")[-1]


def centres(out: Path) -> dict[str, np.ndarray]:
    import csv

    with (out / "cameras.csv").open(newline="") as stream:
        return {r["name"]: np.array([float(r[k]) for k in "xyz"]) for r in csv.DictReader(stream)}


def whole(out: Path) -> None:
    """The results are there, can be read, and nothing half is left beside them."""
    from vomstudio.io.models.opening import read_model

    for name in ("model.obj", "model.glb", "model.ply"):
        assert len(read_model(out / name).data.faces) > 1000
    assert len(read_model(out / "dense.laz").data.points) > 1000
    assert (out / "report.html").stat().st_size > 1000
    assert not [p for p in out.rglob("*") if ".part" in p.name or p.name.endswith(".old")]


def same_to_the_bit(one: Path, other: Path) -> None:
    for name in ("cameras.csv", "cameras.json", "model.obj", "model.ply", "model.glb"):
        assert (one / name).read_bytes() == (other / name).read_bytes(), name
    (a,), (b,) = (list(p.glob("work/cloud-*/cloud.npz")) for p in (one, other))
    with np.load(a) as first, np.load(b) as second:
        assert set(first.files) == set(second.files)
        for key in first.files:
            assert np.array_equal(first[key], second[key]), key


def gsd_apart(one: Path, other: Path) -> float:
    """Largest distance of camera centres after a similarity, in pixels on the rock."""
    from vomstudio.registration.similarity import fit_similarity

    a, b = centres(one), centres(other)
    assert set(a) == set(b)
    source, target = (np.array([c[name] for name in sorted(a)]) for c in (a, b))
    apart = np.linalg.norm(fit_similarity(source, target)(source) - target, axis=1).max()
    true = np.array([view.centre for view in photo_set.views(len(a))])
    return float(apart * np.ptp(true, axis=0).max() / np.ptp(target, axis=0).max() / photo_set.GSD)
