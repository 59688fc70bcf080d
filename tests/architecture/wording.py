"""Count names and docstrings that are not idiomatic, per package of the program.

Run ``python -m tests.architecture.wording`` to lower the ceilings in ``wording.json``;
``--list PACKAGE`` prints the places.
"""

from __future__ import annotations

import argparse
import ast
import json
import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CEILINGS = Path(__file__).with_name("wording.json")
PARTICIPLES = frozenset(
    [
        "said",
        "told",
        "found",
        "kept",
        "asked",
        "wanted",
        "given",
        "taken",
        "chosen",
        "made",
        "tried",
        "laid",
        "typed",
        "held",
        "seen",
        "meant",
        "own",
        "rest",
        "odd",
        "bare",
        "there",
        "came",
        "beside",
        "aside",
    ]
)
LEADING_WORDS = frozenset(
    ["of", "as", "in", "by", "without", "with", "at", "on", "beside", "among"]
)
LIBRARY_NAMES = frozenset(
    [
        "dict",
        "json",
        "text",
        "dtype",
        "array",
        "frame",
        "numpy",
        "pandas",
        "pyvista",
        "file",
        "path",
        "arguments",
        "arrays",
    ]
)
VAGUE_LIMITS = frozenset(["MOST", "LEAST", "FEWEST", "HARDLY", "SURE", "SOON", "ENOUGH"])
DOCSTRING_STARTS = ("Of ", "What ", "Where ", "How ", "By ", "Whose ")
SPEECH = re.compile(r"\b(?:is|are|was|were) (?:told|said)\b|\bheld against\b|\btells? (?:of|how)\b")


def unidiomatic(source: str) -> Iterator[tuple[int, str]]:
    """Yield line and text of names and docstrings that STYLE rules out."""
    for node in ast.walk(ast.parse(source)):
        for name in _names(node):
            if is_unidiomatic(name):
                yield getattr(node, "lineno", 0), name
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            text = ast.get_docstring(node) or ""
            if text.startswith(DOCSTRING_STARTS) or SPEECH.search(text):
                yield getattr(node, "lineno", 1), text.splitlines()[0]


def is_unidiomatic(name: str) -> bool:
    """Return whether a name is a participle, begins with a preposition or is a vague limit."""
    first, _, rest = name.lstrip("_").partition("_")
    if name.isupper():
        return not VAGUE_LIMITS.isdisjoint(name.split("_"))
    return name.lstrip("_") in PARTICIPLES or (
        first in LEADING_WORDS and bool(rest) and rest not in LIBRARY_NAMES
    )


def _names(node: ast.AST) -> Iterator[str]:
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
        yield node.name
    elif isinstance(node, ast.arg):
        yield node.arg
    elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
        yield node.id
    elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
        yield node.attr


def places(package: str) -> Iterator[str]:
    """Yield file, line and text of each hit in a package."""
    for path in sorted((ROOT / "vomstudio" / package).rglob("*.py")):
        for line, text in unidiomatic(path.read_text("utf-8")):
            yield f"{path.relative_to(ROOT)}:{line}: {text}"


def counts() -> Counter[str]:
    """Return the number of hits per package."""
    packages = sorted(
        p.name for p in (ROOT / "vomstudio").iterdir() if (p / "__init__.py").is_file()
    )
    return Counter({package: sum(1 for _ in places(package)) for package in packages})


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--list", metavar="PACKAGE")
    arguments = parser.parse_args()
    if arguments.list:
        print("\n".join(places(arguments.list)))
    else:
        CEILINGS.write_text(json.dumps(dict(sorted(counts().items())), indent=1) + "\n")
        print(CEILINGS.read_text())
