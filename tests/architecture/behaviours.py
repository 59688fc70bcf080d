"""Find the code of a behaviour by the names of its tests, which state behaviours.

Run ``python -m tests.architecture.behaviours WORD ...``. Printed are the tests whose names contain
all words, each with the functions and classes of the program that it uses, or else those that its
file imports.
"""

from __future__ import annotations

import argparse
import ast
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = "vomstudio"
_TEST_NAME = re.compile(r"^\s*def (test_\w+)", re.MULTILINE)


def find_behaviours(words: Sequence[str], tests: Path = ROOT / "tests") -> list[str]:
    """Return a text for each test whose name contains all words: file, name, tested code."""
    lowered = [word.lower() for word in words]

    def has_words(name: str) -> bool:
        return all(word in name for word in lowered)

    return [
        "\n    ".join([f"{path.relative_to(tests.parent).as_posix()}::{name}", *used])
        for path in sorted(tests.rglob("test_*.py"))
        # Only files with such a test are parsed, which takes far longer than to search them.
        if any(map(has_words, _TEST_NAME.findall(path.read_text("utf-8"))))
        for name, used in _tests_of(path)
        if has_words(name)
    ]


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
            yield name, sorted(used) or sorted(set(imported.values()))


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
