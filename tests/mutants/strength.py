"""Measure how many of the mutants that any test kills are killed by the default tier alone.

    python -m tests.mutants.strength record FOLDER --sample 100 --seed 37
    python -m tests.mutants.strength kill FOLDER

`record` draws mutants over all packages, runs the default and the full tier once in a copy of the
tree, and stores in FOLDER which tests reach each mutated line. `kill` then runs, for each mutant,
only the tests that reach its line: those of the default tier first, those of the full tier if it
survives. Both may be interrupted; `kill` continues where it stopped.

Coverage is recorded by probes, one call inserted before each mutated statement, rather than by a
tracer: probes cost nothing, and they also report from processes that a test starts or kills. A
mutant outside a Python function (in a compiled kernel, a constant, a default value) has its probes
in the functions that use its name.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.mutants.__main__ import ROOT, copied, drawn, equivalent
from tests.mutants.draw import Mutant, mutant_of, places_of

PROBE_MODULE = "vomstudio_probe"
PROBE = """\
import os

_reported = set()


def hit(number):
    test = os.environ.get("PYTEST_CURRENT_TEST", "").rpartition(" ")[0]
    if test and (number, test) not in _reported:
        _reported.add((number, test))
        path = os.path.join({folder!r}, f"{{os.getpid()}}.tsv")
        with open(path, "a", encoding="utf-8") as file:
            file.write(f"{{number}}\\t{{test}}\\n")
"""
TIERS = {"default": "not slow and not full", "full": "full and not slow"}
MAX_SECONDS = 600
"""A mutant that no test has killed within this time counts as survived."""
TIMED_OUT = -1
SURVIVED = (pytest.ExitCode.OK, pytest.ExitCode.NO_TESTS_COLLECTED, TIMED_OUT)
MAX_TESTS = 400
"""Tests of a tier that are run for one mutant, those that reach the fewest mutants first."""

Function = ast.FunctionDef | ast.AsyncFunctionDef
Place = tuple[str, int, int]
"""File, line and column before which a probe is inserted."""


# --- record ------------------------------------------------------------------------------------
def record(folder: Path, sample: int, seed: int, pytest_arguments: list[str]) -> None:
    """Run all tests once with probes and store which tests reach which mutant."""
    mutants = drawn("", sample, seed)
    hits = folder / "hits"
    hits.mkdir(parents=True)
    (folder / "mutants.json").write_text(json.dumps([as_row(m) for m in mutants], indent=1))
    with tempfile.TemporaryDirectory(prefix="strength-") as scratch:
        tree = copied(Path(scratch))
        (tree / f"{PROBE_MODULE}.py").write_text(PROBE.format(folder=str(hits)))
        insert_probes(tree, mutants)
        arguments = pytest_arguments or ["--numprocesses", "2", "--dist", "loadfile"]
        run_pytest(tree, ["-m", "not slow", *arguments], timeout_s=None)


def as_row(mutant: Mutant) -> dict[str, Any]:
    """Return what identifies a mutant."""
    return {key: getattr(mutant, key) for key in ("file", "line", "kind", "before", "after")}


def insert_probes(tree: Path, mutants: list[Mutant]) -> None:
    """Insert a call before the statement of each mutant in a copy of the tree."""
    probes: dict[str, set[tuple[int, int, int]]] = defaultdict(set)
    for number, mutant in enumerate(mutants):
        for file, line, column in probe_places(tree, mutant):
            probes[file].add((line, column, number))
    for file, places in probes.items():
        path = tree / file
        lines = path.read_text().splitlines(keepends=True)
        for line, column, number in sorted(places, reverse=True):
            call = f"__import__({PROBE_MODULE!r}).hit({number})"
            lines.insert(line - 1, f"{' ' * column}{call}\n")
        path.write_text("".join(lines))


def probe_places(tree: Path, mutant: Mutant) -> list[Place]:
    """Return where probes see that a mutant is reached."""
    module = ast.parse((tree / mutant.file).read_text())
    function, statement = innermost(module, mutant.line)
    if function is not None and not is_compiled(function):
        first = statement or function.body[0]
        return [(mutant.file, first_line(first), first.col_offset)]
    names = [function.name] if function is not None else defined_names(module, mutant.line)
    return users(tree, set(names))


def innermost(module: ast.Module, line: int) -> tuple[Function | None, ast.stmt | None]:
    """Return the innermost function around a line, and the statement of its body at the line."""
    function: Function | None = None
    statement: ast.stmt | None = None
    nodes: list[ast.stmt] = list(module.body)
    while nodes:
        node = nodes.pop()
        if not first_line(node) <= line <= (node.end_lineno or node.lineno):
            continue
        if isinstance(node, Function) and line >= first_line(node.body[0]):
            function, statement = node, None
        elif function is not None and not is_elif(node, statement):
            statement = node
        nodes = list(direct_statements(node))
    return function, statement


def direct_statements(node: ast.stmt) -> Iterator[ast.stmt]:
    """Yield the statements directly inside another one."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.stmt):
            yield child
        elif isinstance(child, ast.ExceptHandler | ast.match_case):
            yield from child.body


def is_elif(node: ast.stmt, parent: ast.stmt | None) -> bool:
    """Return whether a statement is the `elif` of another: nothing can stand before it."""
    return (
        isinstance(node, ast.If)
        and isinstance(parent, ast.If)
        and parent.orelse == [node]
        and node.col_offset == parent.col_offset
    )


def first_line(node: ast.stmt) -> int:
    """Return the first line of a statement, decorators included."""
    decorators = getattr(node, "decorator_list", [])
    return min([node.lineno, *(decorator.lineno for decorator in decorators)])


def is_compiled(function: Function) -> bool:
    """Return whether numba compiles a function, so that it cannot contain a probe."""
    words = " ".join(ast.unparse(decorator) for decorator in function.decorator_list)
    return any(word in words for word in ("jit", "kernel", "vectorize"))


def defined_names(module: ast.Module, line: int) -> list[str]:
    """Return the names that the top-level statement at a line defines."""
    for node in module.body:
        if first_line(node) <= line <= (node.end_lineno or node.lineno):
            if isinstance(node, Function | ast.ClassDef):
                return [node.name]
            return [
                name.id
                for name in ast.walk(node)
                if isinstance(name, ast.Name) and isinstance(name.ctx, ast.Store)
            ]
    return []


def users(tree: Path, names: set[str]) -> list[Place]:
    """Return the beginnings of all Python functions that use one of some names, or a compiled
    function that does."""
    functions = [
        (path.relative_to(tree).as_posix(), node)
        for path in sorted((tree / "vomstudio").rglob("*.py"))
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, Function)
    ]
    used = {id(node): words_of(node) for _, node in functions}
    names = set(names)
    while more := {
        node.name
        for _, node in functions
        if is_compiled(node) and node.name not in names and used[id(node)] & names
    }:
        names |= more
    return [
        (file, first_line(node.body[0]), node.body[0].col_offset)
        for file, node in functions
        if not is_compiled(node) and used[id(node)] & names
    ]


def words_of(function: Function) -> set[str]:
    """Return all names and attributes in the body of a function."""
    nodes = [node for statement in function.body for node in ast.walk(statement)]
    names = {node.id for node in nodes if isinstance(node, ast.Name)}
    return names | {node.attr for node in nodes if isinstance(node, ast.Attribute)}


# --- kill --------------------------------------------------------------------------------------
def kill(folder: Path) -> list[dict[str, Any]]:
    """Run the tests that reach each mutant; return a row with the result for each."""
    results = folder / "results.json"
    rows: list[dict[str, Any]] = json.loads(results.read_text()) if results.exists() else []
    finished = {key_of(row) for row in rows}
    waiting = [m for m in stored_mutants(folder) if key_of(as_row(m[1])) not in finished]
    lock = threading.Lock()

    def work() -> None:
        with tempfile.TemporaryDirectory(prefix="strength-") as scratch:
            tree = copied(Path(scratch))
            while True:
                with lock:
                    if not waiting:
                        return
                    number, mutant = waiting.pop(0)
                began = time.monotonic()
                row = as_row(mutant) | outcome(tree, mutant, tests[number], tiers)
                row["seconds"] = round(time.monotonic() - began, 1)
                with lock:
                    rows.append(row)
                    results.write_text(json.dumps(rows, indent=1))
                    print(
                        f"{len(rows)}: {row['state']} by {row['by']}: {mutant.file}:"
                        f"{mutant.line}\n    - {mutant.before}\n    + {mutant.after}",
                        flush=True,
                    )

    tests = recorded_tests(folder)
    tiers = {tier: collected(marks) for tier, marks in TIERS.items()}
    workers = [threading.Thread(target=work) for _ in range(os.cpu_count() or 1)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    return rows


def key_of(row: dict[str, Any]) -> tuple[str, str, str]:
    """Return what identifies a mutant while lines of its file move."""
    return row["file"], row["before"], row["after"]


def stored_mutants(folder: Path) -> list[tuple[int, Mutant]]:
    """Return the recorded mutants in today's tree; those whose line has changed are left out."""
    found = []
    for number, row in enumerate(json.loads((folder / "mutants.json").read_text())):
        path = ROOT / row["file"]
        text = path.read_text() if path.exists() else ""
        same = [
            mutant
            for changes in places_of(text)
            for change in changes
            if change.kind == row["kind"]
            and change.new in row["after"]
            and (mutant := mutant_of(row["file"], text, change)) is not None
            and key_of(as_row(mutant)) == key_of(row)
        ]
        if same:
            found.append((number, min(same, key=lambda m: abs(m.line - row["line"]))))
        else:
            print(f"left out, its line has changed: {row['file']}:{row['line']} {row['before']}")
    return found


def recorded_tests(folder: Path) -> dict[int, list[str]]:
    """Return the tests that reach each mutant, those that reach the fewest mutants first."""
    pairs = {
        (int(number), test)
        for path in (folder / "hits").glob("*.tsv")
        for number, _, test in (line.partition("\t") for line in path.read_text().splitlines())
    }
    reach = Counter(test for _, test in pairs)
    tests: dict[int, list[str]] = defaultdict(list)
    for number, test in sorted(pairs, key=lambda pair: (reach[pair[1]], pair)):
        tests[number].append(test)
    return tests


def outcome(
    tree: Path, mutant: Mutant, tests: list[str], tiers: dict[str, set[str]]
) -> dict[str, Any]:
    """Return the state of a mutant ("killed", "survived", "equivalent") and the tier it died in.

    tiers : functions of the tests of each tier
    """
    if (reason := equivalent().get(key_of(as_row(mutant)))) is not None:
        return {"state": "equivalent", "by": reason, "tests": len(tests)}
    present = existing(tree, tests)
    if not present:
        return {"state": "not reached", "by": None, "tests": 0}
    path = tree / mutant.file
    whole = path.read_text()
    with tempfile.TemporaryDirectory(prefix="numba-") as kernels:
        # A compiled kernel is cached by the date of its own file, not of those that it calls.
        more = {"NUMBA_CACHE_DIR": kernels} if "jit" in whole or "kernel" in whole else {}
        path.write_text(mutant.text)
        try:
            for tier, marks in TIERS.items():
                chosen = [each for each in present if function_of(each) in tiers[tier]][:MAX_TESTS]
                words = ["-x", "-m", marks, "-p", "no:cacheprovider"]
                code: int = pytest.ExitCode.USAGE_ERROR
                for names in (chosen, list(dict.fromkeys(map(function_of, chosen)))):
                    # Parameters of a test may have other names by now.
                    if chosen and code == pytest.ExitCode.USAGE_ERROR:
                        code = run_pytest(
                            tree, [*words, *names], timeout_s=MAX_SECONDS, environment=more
                        )
                if chosen and code not in SURVIVED:
                    return {"state": "killed", "by": tier, "tests": len(tests)}
        finally:
            path.write_text(whole)
    return {"state": "survived", "by": None, "tests": len(tests)}


def function_of(test: str) -> str:
    """Return the id of a test without its parameters."""
    return test.partition("[")[0]


def collected(marks: str) -> set[str]:
    """Return the functions of the tests that an expression of marks selects."""
    words = ["-m", "pytest", "--collect-only", "-q", "-m", marks, "-p", "no:cacheprovider"]
    listed = subprocess.run(
        [sys.executable, *words], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return {function_of(line) for line in listed.stdout.splitlines() if "::" in line}


def existing(tree: Path, tests: list[str]) -> list[str]:
    """Return the tests whose function is still in its file."""
    texts: dict[str, str] = {}
    names = []
    for test in tests:
        file, _, name = test.partition("::")
        path = tree / file
        text = texts.setdefault(file, path.read_text() if path.exists() else "")
        if f"def {name.rpartition('::')[2].partition('[')[0]}(" in text:
            names.append(test)
    return names


def run_pytest(
    tree: Path,
    arguments: list[str],
    *,
    timeout_s: float | None,
    environment: dict[str, str] | None = None,
) -> int:
    """Run pytest in a tree; return its exit code, or `TIMED_OUT`."""
    data = os.environ.get("VOMSTUDIO_DATA", str(ROOT.parent / "shared" / "data"))
    own = {"PYTHONPATH": str(tree), "VOMSTUDIO_DATA": data, "QT_QPA_PLATFORM": "xcb"}
    command = [sys.executable, "-m", "pytest", "-q", *arguments]
    process = subprocess.Popen(
        command,
        cwd=tree,
        env=os.environ | own | (environment or {}),
        stdout=subprocess.DEVNULL if timeout_s else None,
        stderr=subprocess.DEVNULL if timeout_s else None,
        start_new_session=True,
    )
    try:
        return process.wait(timeout_s)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, 9)
        process.wait()
        return TIMED_OUT


def summary(rows: list[dict[str, Any]]) -> str:
    """Return the counts and the share that the default tier kills."""
    by = Counter(row["by"] for row in rows if row["state"] == "killed")
    states = Counter(row["state"] for row in rows)
    killed = by["default"] + by["full"]
    share = by["default"] / killed if killed else 0.0
    return (
        f"{len(rows)} mutants: {by['default']} killed by the default tier, {by['full']} more by the"
        f" full tier, {states['survived']} survived, {states['not reached']} not reached,"
        f" {states['equivalent']} equivalent; the default tier kills {share:.2f} of what all tests"
        " kill"
    )


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.mutants.strength")
    parser.add_argument("action", choices=["record", "kill"])
    parser.add_argument("folder", type=Path, help="where results are stored")
    parser.add_argument("--sample", type=int, default=100)
    parser.add_argument("--seed", type=int, default=37)
    options, pytest_arguments = parser.parse_known_args()
    if options.action == "record":
        record(options.folder, options.sample, options.seed, pytest_arguments)
    else:
        print(summary(kill(options.folder)))


if __name__ == "__main__":
    main()
