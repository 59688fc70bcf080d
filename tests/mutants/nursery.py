"""Runs the tests of a package against each of its mutants, in a copy of the tree.

One process imports what every test needs and is then forked for each mutant, which saves the
seconds of importing. It has imported nothing of the program and computed nothing, so that a fork
holds neither the text before the change nor a thread. Only tests that import the changed file, if
through others, are asked; those of the module's own test file come first, the slow ones last, and
the first that fails ends the run.
"""

from __future__ import annotations

import ast
import json
import os
import re
import shutil
import signal
import sys
import time
from pathlib import Path
from typing import Any

import pytest

SLOW_S = 0.5
ENDS = (".py", "/__init__.py")
OPTIONS = (
    "-q",
    "-x",
    "-p",
    "no:cacheprovider",
    "--hypothesis-seed=0",
    "-W",
    "ignore::pytest.PytestAssertRewriteWarning",
)
PRELOADED = (
    "numpy",
    "scipy.stats",
    "scipy.spatial",
    "scipy.ndimage",
    "scipy.special",
    "numba",
    "scipy.sparse.csgraph",
    "hypothesis",
    "matplotlib.backends.backend_agg",
    "PIL.Image",
    "pandas",
)


class Imports:
    """Which files of the tree a file imports, itself or through others, wherever the import stands:
    who does not can't notice a change."""

    def __init__(self) -> None:
        self._direct: dict[Path, set[str]] = {}

    def of(self, path: Path) -> set[str]:
        if path not in self._direct:
            found: set[str] = set()
            for node in ast.walk(ast.parse(path.read_text())):
                if isinstance(node, ast.Import):
                    found.update(*(_files_of(alias.name) for alias in node.names))
                elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                    names = [f"{node.module}.{alias.name}" for alias in node.names]
                    found.update(*map(_files_of, names))
            self._direct[path] = found
        return self._direct[path]

    def reach(self, path: Path) -> set[str]:
        seen: set[str] = set()
        waiting = self.of(path)
        while waiting:
            seen |= waiting
            waiting = set().union(*(self.of(Path(file)) for file in waiting)) - seen
        return seen


def _files_of(name: str) -> set[str]:
    """Of a dotted name, which may end in something within a module: the module and the packages
    around it, as far as they are in the tree."""
    parts = name.split(".")
    files = {"/".join(parts[:n]) + end for n in range(1, len(parts) + 1) for end in ENDS}
    return {file for file in files if Path(file).is_file()}


def _starts_processes(path: Path) -> bool:
    return "subprocess" in path.read_text()


class Order:
    """Runs those tests that can notice a change in a file, the likely and the quick ones first, and
    keeps how long each took and which one failed. Without a file all are run as they come."""

    def __init__(
        self, imports: Imports, times: dict[str, float], file: str | None, quick_s: float
    ) -> None:
        self.imports, self.known, self.file, self.quick_s = imports, times, file, quick_s
        self.times: dict[str, float] = {}
        self.failed: str | None = None

    def _place(self, item: pytest.Item) -> tuple[bool, int, str, float]:
        assert self.file is not None
        path = item.path
        near = 2
        if path.stem == f"test_{Path(self.file).stem}":
            near = 0
        elif self.file in self.imports.of(path):
            near = 1
        seconds = self.known.get(item.nodeid, 0.0)
        slow = seconds > SLOW_S
        return slow, near, "" if slow else str(path), seconds

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        if self.file is None:
            return
        chosen = [
            item
            for item in items
            if self.known.get(item.nodeid, 0.0) <= self.quick_s
            and (self.file in self.imports.reach(item.path) or _starts_processes(item.path))
        ]
        items[:] = sorted(chosen, key=self._place)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self.times[report.nodeid] = self.times.get(report.nodeid, 0.0) + report.duration
        if report.failed and self.failed is None:
            self.failed = report.nodeid

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.failed and self.failed is None:
            self.failed = f"{report.nodeid} could not be read"


class Nursery:
    """The tests in `tests`, a folder of the copy in which this process works."""

    def __init__(self, tests: str, scratch: Path, quick_s: float) -> None:
        self.tests, self.scratch, self.quick_s = tests, scratch, quick_s
        self.imports = Imports()
        self.times: dict[str, float] = {}
        texts = {path: path.read_text() for path in Path("vomstudio").rglob("*.py")}
        self.compiled = {
            p for p, text in texts.items() if re.search("jit import|import numba", text)
        }

    def healthy(self, times: dict[str, float] | None) -> dict[str, Any]:
        """The tests without any change; everything after is measured against them. `times` : of an
        earlier run, which spares this one."""
        found: dict[str, Any] = {"state": "survived", "times": times}
        if times is None:
            found = self._forked(Order(self.imports, {}, None, 0.0), None, 3600.0)
        self.times = found["times"]
        return found

    def with_mutant(self, file: str, text: str, limit_s: float) -> dict[str, Any]:
        """state "killed" (by what), "survived", "timeout"; seconds."""
        path = Path(file)
        stat, whole = path.stat(), path.read_bytes()
        kernels = self._numba_folder(file)
        path.write_text(text)
        try:
            order = Order(self.imports, self.times, file, self.quick_s)
            return self._forked(order, kernels, limit_s)
        finally:
            path.write_bytes(whole)
            # Compiled kernels are known by the time of their file.
            os.utime(path, ns=(stat.st_atime_ns, stat.st_mtime_ns))

    def _numba_folder(self, file: str) -> Path | None:
        """The compiled kernels but those of this file and of those that import it: a kernel is kept
        by the time of its own file, and would still hold what another one said before."""
        holders = {p for p in self.compiled if str(p) == file or file in self.imports.of(p)}
        kept = self.scratch / "numba"
        if not holders:
            return None
        folder = self.scratch / f"numba-{time.time_ns()}"
        names = [f"{path.stem}.*" for path in holders]
        if kept.is_dir():
            shutil.copytree(kept, folder, ignore=shutil.ignore_patterns(*names))
        return folder

    def _forked(self, plugin: Order, numba: Path | None, limit_s: float) -> dict[str, Any]:
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
                return {"state": "timeout", "by": None, "times": {}, "seconds": limit_s}
            time.sleep(0.02)
        seconds = time.monotonic() - begin
        if not answer.exists():
            return {"state": "killed", "by": "the process died", "times": {}, "seconds": seconds}
        return {**json.loads(answer.read_text()), "seconds": seconds}

    def _be_tested(self, plugin: Order, numba: Path | None, answer: Path) -> None:
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
        state = "survived" if lives else "killed"
        found = {"state": state, "by": plugin.failed, "times": plugin.times}
        answer.with_suffix(".part").write_text(json.dumps(found))
        answer.with_suffix(".part").replace(answer)


def serve(tests: str, scratch: Path, quick_s: float) -> None:
    """Answers requests, lines of JSON, one by one: `times` for the tests as they are, else file,
    text and limit_s of a mutant."""
    sys.dont_write_bytecode = True
    replies = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    for name in PRELOADED:
        __import__(name)
    # Its plugins are imported too.
    pytest.main(["--version", "-p", "no:cacheprovider"])
    nursery = Nursery(tests, scratch, quick_s)
    for line in sys.stdin:
        asked = json.loads(line)
        found = nursery.healthy(**asked) if "times" in asked else nursery.with_mutant(**asked)
        replies.write(json.dumps(found) + "\n")
        replies.flush()


if __name__ == "__main__":
    serve(sys.argv[1], Path(sys.argv[2]), float(sys.argv[3]))
