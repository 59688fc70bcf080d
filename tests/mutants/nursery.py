"""Runs the tests of a package against each of its mutants, in a copy of the tree.

One process imports what every test needs and is then forked for each mutant, which saves the
seconds of importing. It has imported nothing of the program and computed nothing, so that a fork
holds neither the text before the change nor a thread. Only tests that run in the changed file are
asked; those of the module's own test file come first, the slow ones last, and the first that fails
ends the run.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import sys
import time
from collections.abc import Generator
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

SLOW_S = 0.5
OPTIONS = (
    "-q", "-x", "-p", "no:cacheprovider", "--hypothesis-seed=0",
    "-W", "ignore::pytest.PytestAssertRewriteWarning",
)  # fmt: skip
PRELOADED = (
    "numpy", "scipy.stats", "scipy.spatial", "scipy.ndimage", "scipy.special", "numba",
    "hypothesis", "matplotlib.figure", "PIL.Image", "pandas",
)  # fmt: skip


class Reach:
    """Which files of the program every test runs in, and how long it takes.

    What a fixture does is counted for all tests of its file, of which only the first may do it.
    """

    def __init__(self) -> None:
        self.root = f"{Path.cwd()}/"
        self.times: dict[str, float] = {}
        self.files: dict[str, list[str]] = {}
        self.failed: str | None = None
        self._running: set[str] = set()

    def _trace(self, frame: FrameType, _event: str, _value: object) -> None:
        self._running.add(frame.f_code.co_filename)

    def _keep(self, name: str) -> None:
        mine = {f.removeprefix(self.root) for f in self._running if f.startswith(self.root)}
        self.files[name] = sorted(mine.union(self.files.get(name, ())))
        self._running = set()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> Generator[None, object, object]:
        sys.settrace(self._trace)
        try:
            return (yield)
        finally:
            self._keep(item.nodeid.partition("::")[0])

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Generator[None, object, object]:
        try:
            return (yield)
        finally:
            self._keep(item.nodeid)
            sys.settrace(None)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self.times[report.nodeid] = self.times.get(report.nodeid, 0.0) + report.duration
        if report.failed and self.failed is None:
            self.failed = report.nodeid


class Order:
    """Runs those tests that can notice a change in a file, the likely and the quick ones first, and
    keeps which one failed."""

    def __init__(
        self, reach: dict[str, Any], module: str, watched: set[str], quick_s: float
    ) -> None:
        self.reach, self.module, self.watched, self.quick_s = reach, module, watched, quick_s
        self.failed: str | None = None

    def _reached(self, item: pytest.Item) -> bool:
        files = self.reach["files"]
        if self.reach["times"].get(item.nodeid, 0.0) > self.quick_s:
            return False
        if item.nodeid not in files or not any(
            self.watched.intersection(reached) for reached in files.values()
        ):
            return True
        mine = (*files.get(item.nodeid, ()), *files.get(item.nodeid.partition("::")[0], ()))
        return bool(self.watched.intersection(mine)) or "subprocess" in item.path.read_text()

    def _nearness(self, path: Path) -> int:
        if path.stem == f"test_{self.module.rpartition('.')[2]}":
            return 0
        return 1 if self.module in path.read_text() else 2

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        near = {path: self._nearness(path) for path in {item.path for item in items}}

        def place(item: pytest.Item) -> tuple[bool, int, str, float]:
            seconds = self.reach["times"].get(item.nodeid, 0.0)
            slow = seconds > SLOW_S
            return slow, near[item.path], "" if slow else str(item.path), seconds

        items[:] = sorted(filter(self._reached, items), key=place)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed and self.failed is None:
            self.failed = report.nodeid

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.failed and self.failed is None:
            self.failed = f"{report.nodeid} could not be read"


class Nursery:
    """The tests in `tests`, a folder of the copy in which this process works."""

    def __init__(self, tests: str, scratch: Path, quick_s: float) -> None:
        self.tests, self.scratch, self.quick_s = tests, scratch, quick_s
        self.reach: dict[str, Any] = {}
        self.texts = {str(path): path.read_text() for path in Path("vomstudio").rglob("*.py")}
        self.compiled = {
            file for file, text in self.texts.items() if re.search(r"jit import|import numba", text)
        }

    def healthy(self, reach: dict[str, Any] | None) -> dict[str, Any]:
        """The tests without any change; everything after is measured against them. `reach` : of an
        earlier run, which spares this one; tests that are not in it are asked about every mutant.
        """
        found: dict[str, Any] = {"state": "survived", "reach": reach}
        if reach is None:
            found = self._forked(Reach(), None, 3600.0)
        self.reach = found.get("reach", {})
        return found

    def with_mutant(self, file: str, text: str, inside: bool, limit_s: float) -> dict[str, Any]:
        """state "killed" (by what), "survived", "timeout"; seconds."""
        path = Path(file)
        stat, whole = path.stat(), path.read_bytes()
        watched, kernels = {file}, None
        if file in self.compiled or not inside:
            # Kernels are not seen running, and constants are taken by name: who imports them is.
            near = self._importers(file)
            watched |= near.union(*(self._importers(each) for each in near & self.compiled))
        if self.compiled & watched:
            kernels = self._numba_folder(watched)
        module = file.removesuffix(".py").replace("/", ".")
        path.write_text(text)
        try:
            return self._forked(Order(self.reach, module, watched, self.quick_s), kernels, limit_s)
        finally:
            path.write_bytes(whole)
            # Compiled kernels are known by the time of their file.
            os.utime(path, ns=(stat.st_atime_ns, stat.st_mtime_ns))

    def _importers(self, file: str) -> set[str]:
        parent, _, name = file.removesuffix(".py").replace("/", ".").rpartition(".")
        room = re.escape(parent)
        line = re.compile(rf"from {room}\.{name} import|from {room} import[^\n(]*\b{name}\b")
        return {other for other, text in self.texts.items() if line.search(text)}

    def _numba_folder(self, watched: set[str]) -> Path:
        """The compiled kernels but those of the watched files: a kernel is kept by the time of its
        own file, and would still hold what another one said before."""
        folder = self.scratch / f"numba-{time.time_ns()}"
        names = [f"{Path(file).stem}.*" for file in watched]
        shutil.copytree(self.scratch / "numba", folder, ignore=shutil.ignore_patterns(*names))
        return folder

    def _forked(self, plugin: Reach | Order, numba: Path | None, limit_s: float) -> dict[str, Any]:
        answer = self.scratch / "answer.json"
        answer.unlink(missing_ok=True)
        begin = time.monotonic()
        child = os.fork()
        if child == 0:
            try:
                self._be_tested(plugin, numba, answer)
            finally:
                os._exit(0)
        while os.waitpid(child, os.WNOHANG)[0] == 0:
            if time.monotonic() - begin > limit_s:
                os.killpg(child, signal.SIGKILL)
                os.waitpid(child, 0)
                return {"state": "timeout", "by": None, "seconds": limit_s}
            time.sleep(0.02)
        seconds = time.monotonic() - begin
        if not answer.exists():
            return {"state": "killed", "by": "the process died", "seconds": seconds}
        return {**json.loads(answer.read_text()), "seconds": seconds}

    def _be_tested(self, plugin: Reach | Order, numba: Path | None, answer: Path) -> None:
        """The child's whole life."""
        os.setsid()
        with (self.scratch / "output.txt").open("w") as output:
            for stream in (1, 2):
                os.dup2(output.fileno(), stream)
            if numba is not None:
                sys.modules["numba"].config.CACHE_DIR = str(numba)
            code = pytest.main([*OPTIONS, self.tests], plugins=[plugin])
        # Where no test at all notices a file, its mutants live.
        lives = code in (pytest.ExitCode.OK, pytest.ExitCode.NO_TESTS_COLLECTED)
        found: dict[str, Any] = {"state": "survived" if lives else "killed", "by": plugin.failed}
        if isinstance(plugin, Reach):
            found["reach"] = {"times": plugin.times, "files": plugin.files}
        answer.with_suffix(".part").write_text(json.dumps(found))
        answer.with_suffix(".part").replace(answer)


def serve(tests: str, scratch: Path, quick_s: float) -> None:
    """Answers requests, lines of JSON, one by one: `reach` for the tests as they are, else file,
    text, inside and limit_s of a mutant."""
    for name in PRELOADED:
        __import__(name)
    sys.dont_write_bytecode = True
    nursery = Nursery(tests, scratch, quick_s)
    replies = os.fdopen(os.dup(1), "w")
    for line in sys.stdin:
        asked = json.loads(line)
        found = nursery.healthy(**asked) if "reach" in asked else nursery.with_mutant(**asked)
        replies.write(json.dumps(found) + "\n")
        replies.flush()


if __name__ == "__main__":
    serve(sys.argv[1], Path(sys.argv[2]), float(sys.argv[3]))
