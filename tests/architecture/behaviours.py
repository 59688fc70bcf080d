"""Find the code of a behaviour by the names of its tests, which state behaviours.

Run ``python -m tests.architecture.behaviours WORD ...``. Printed are the tests whose names, or the
names of their files, contain all words. Each is followed by the functions and classes of the
program that it uses, or else those that its file imports.
"""

from __future__ import annotations

import argparse
import ast
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = "vomstudio"
_WHOLE_PROGRAM = "(runs the program as a whole; read the test, or search docs/modules.md)"
_TEST_NAME = re.compile(r"^\s*def (test_\w+)", re.MULTILINE)


def find_behaviours(words: Sequence[str], tests: Path = ROOT / "tests") -> list[str]:
    """Return a text for each test whose name contains all words: file, name, tested code.

    The words may also occur in the name of the file. If no test has all words, those with the most
    words are returned, after a line that states this.
    """
    matches: list[tuple[int, Path, str]] = []
    for path in sorted(tests.rglob("test_*.py")):
        for name in _TEST_NAME.findall(path.read_text("utf-8")):
            text = f"{path.stem} {name}"
            matches.append((sum(word.lower() in text for word in words), path, name))
    best = max((count for count, _, _ in matches), default=0)
    if not best:
        return ["No test name contains any of these words. Search docs/modules.md."]
    names_by_file: dict[Path, list[str]] = {}
    for count, path, name in matches:
        if count == best:
            names_by_file.setdefault(path, []).append(name)
    found = []
    if best < len(words):
        found.append("No test name contains all words. Tests with most of them:")
    for path, names in names_by_file.items():
        used_by_test = dict(_tests_of(path))
        for name in names:
            used = used_by_test.get(name) or [_WHOLE_PROGRAM]
            found.append(
                "\n    ".join([f"{path.relative_to(tests.parent).as_posix()}::{name}", *used])
            )
    return found


def _tests_of(path: Path) -> Iterator[tuple[str, list[str]]]:
    """Yield the name of each test of a file, with the imported names that it uses."""
    tree = ast.parse(path.read_text("utf-8"))
    imported = {
        alias.asname or alias.name: f"{node.module}.{alias.name}"
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith(PROGRAM)
        for alias in node.names
    }
    functions = {n.name: n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef)}
    for name, function in functions.items():
        if name.startswith("test_"):
            used = {imported[each] for each in _used_names(function, functions) if each in imported}
            used = used or set(imported.values())
            yield name, sorted(used - {f"{PROGRAM}.cli.main", f"{PROGRAM}.core.errors.InputError"})


def _used_names(
    function: ast.FunctionDef, functions: dict[str, ast.FunctionDef], depth: int = 2
) -> set[str]:
    """Return the names used in a function, and in helpers and fixtures of the same file."""
    names = {node.id for node in ast.walk(function) if isinstance(node, ast.Name)}
    names |= {argument.arg for argument in function.args.args}
    if depth:
        for name in names & functions.keys() - {function.name}:
            names |= _used_names(functions[name], functions, depth - 1)
    return names


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("words", nargs="+")
    print("\n".join(find_behaviours(parser.parse_args().words)))
