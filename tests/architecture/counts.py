"""Count what "declared once" is to reduce: code lines, thread modules, assertions on wording.

Run ``python -m tests.architecture.counts``; ``--list wording`` prints the places.
"""

from __future__ import annotations

import argparse
import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
THREAD_MAKERS = frozenset(
    {
        "Thread",
        "Timer",
        "ThreadPool",
        "ThreadPoolExecutor",
        "start_new_thread",
        "QThread",
        "QThreadPool",
        "QRunnable",
        "globalInstance",
    }
)
WORDS_OF_A_SENTENCE = 3
_WORD = re.compile(r"(?<![\w.-])[A-Za-z][a-z]+(?![\w.-]*[\w])")
_NOT_CODE = frozenset(
    {
        tokenize.COMMENT,
        tokenize.NL,
        tokenize.NEWLINE,
        tokenize.INDENT,
        tokenize.DEDENT,
        tokenize.ENCODING,
        tokenize.ENDMARKER,
    }
)


def sources(folder: str) -> list[Path]:
    """Return the Python files below a folder of the project, sorted."""
    return sorted((ROOT / folder).rglob("*.py"))


def code_lines(source: str) -> int:
    """Count the lines of a source that are not blank, comments or docstrings."""
    lines: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type not in _NOT_CODE:
            lines.update(range(token.start[0], token.end[0] + 1))
    for node in ast.walk(ast.parse(source)):
        is_constant = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        if is_constant and isinstance(node.value.value, str):
            lines.difference_update(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    return len(lines)


def creates_threads(source: str) -> bool:
    """Whether a module calls a class that starts a thread or a pool of threads."""
    if not any(maker in source for maker in THREAD_MAKERS):
        return False
    return any(
        isinstance(node, ast.Call) and _name(node.func) in THREAD_MAKERS
        for node in ast.walk(ast.parse(source))
    ) or any(
        isinstance(node, ast.ClassDef) and any(_name(base) in THREAD_MAKERS for base in node.bases)
        for node in ast.walk(ast.parse(source))
    )


def assertions_on_wording(source: str) -> Iterator[int]:
    """Yield the lines of assertions that compare with a sentence.

    An assertion counts if it contains a string of at least three words outside of its message, or
    if it is a `pytest.raises` or `pytest.warns` whose ``match`` has two words or more.
    """
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Assert):
            if any(_is_sentence(text, WORDS_OF_A_SENTENCE) for text in _compared(node.test)):
                yield node.lineno
        elif isinstance(node, ast.Call) and _name(node.func) in ("raises", "warns"):
            for keyword in node.keywords:
                if keyword.arg == "match" and any(
                    _is_sentence(text, 2) for text in _strings(keyword.value)
                ):
                    yield node.lineno


def _compared(test: ast.expr) -> Iterator[str]:
    for node in ast.walk(test):
        if isinstance(node, ast.Compare):
            for side in (node.left, *node.comparators):
                yield from _strings(side)
        elif isinstance(node, ast.Call) and _name(node.func) in (
            "startswith",
            "endswith",
            "search",
            "match",
            "count",
        ):
            for argument in node.args:
                yield from _strings(argument)


def _strings(node: ast.AST) -> Iterator[str]:
    for each in ast.walk(node):
        if isinstance(each, ast.Constant) and isinstance(each.value, str):
            yield each.value


def _is_sentence(text: str, words: int) -> bool:
    return "\n" not in text and len(_WORD.findall(text)) >= words


def _name(node: ast.expr) -> str:
    if isinstance(node, ast.Attribute):
        return node.attr
    return node.id if isinstance(node, ast.Name) else ""


def main() -> None:
    """Print the counts."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("--list", choices=("threads", "wording", "packages"))
    listed = parser.parse_args().list
    program = {path: path.read_text(encoding="utf-8") for path in sources("vomstudio")}
    tests = {path: path.read_text(encoding="utf-8") for path in sources("tests")}
    threads = [path for path, source in program.items() if creates_threads(source)]
    wording = [
        (path, line) for path, source in tests.items() for line in assertions_on_wording(source)
    ]
    lines = {path: code_lines(source) for path, source in program.items()}
    print(f"code lines of the program: {sum(lines.values()):,} in {len(lines):,} modules")
    print(f"code lines of the tests: {sum(code_lines(each) for each in tests.values()):,}")
    print(f"modules that create threads: {len(threads)}")
    print(f"assertions on wording: {len(wording)}")
    if listed == "threads":
        print("\n".join(str(path.relative_to(ROOT)) for path in threads))
    if listed == "wording":
        print("\n".join(f"{path.relative_to(ROOT)}:{line}" for path, line in wording))
    if listed == "packages":
        packages: dict[str, int] = {}
        for path, count in lines.items():
            name = "/".join(path.relative_to(ROOT).parts[1:-1][:2])
            packages[name] = packages.get(name, 0) + count
        print("\n".join(f"{count:7,}  {name}" for name, count in sorted(packages.items())))


if __name__ == "__main__":
    main()
