"""Compare the numpydoc sections of docstrings with the signatures, per package of the program.

Run ``python -m tests.architecture.docstrings`` to lower the ceilings in ``docstrings.json``;
``--list PACKAGE`` prints the places.
"""

from __future__ import annotations

import argparse
import ast
import json
import re
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CEILINGS = Path(__file__).with_name("docstrings.json")
# Compiled functions have their types in the decorator, overloads their docstring elsewhere.
EXCLUDED_DECORATORS = frozenset(["kernel", "part", "step", "overload"])
MAX_SUMMARY = 88
SECTIONS = (
    "Parameters",
    "Other Parameters",
    "Attributes",
    "Returns",
    "Yields",
    "Raises",
    "Warns",
    "See Also",
    "Notes",
    "References",
    "Examples",
)
HEADER = re.compile(rf"^({'|'.join(SECTIONS)})\n-{{3,}}$", re.MULTILINE)
Function = ast.FunctionDef | ast.AsyncFunctionDef


def sections(docstring: str) -> dict[str, str]:
    """Return the text of each numpydoc section by its title."""
    parts = HEADER.split(docstring)
    return dict(zip(parts[1::2], parts[2::2], strict=True))


def documented_parameters(docstring: str) -> list[str]:
    """Return the names in the sections Parameters and Other Parameters, in order."""
    texts = sections(docstring)
    names: list[str] = []
    for title in ("Parameters", "Other Parameters"):
        for line in texts.get(title, "").splitlines():
            if line and not line[0].isspace():
                head = re.split(r"\s*:\s|\s*:$", line, maxsplit=1)[0]
                names += [name.strip().lstrip("*") for name in head.split(",")]
    return names


def parameters(function: Function) -> list[str]:
    """Return the names of a function's parameters without ``self`` and ``cls``."""
    arguments = function.args
    every = [*arguments.posonlyargs, *arguments.args, arguments.vararg]
    every += [*arguments.kwonlyargs, arguments.kwarg]
    names = [each.arg for each in every if each is not None]
    return names[1:] if names[:1] in (["self"], ["cls"]) else names


def parameter_errors(function: Function) -> list[str]:
    """Return the names that a Parameters section lacks or that the signature lacks."""
    docstring = ast.get_docstring(function) or ""
    if "Parameters" not in sections(docstring):
        return []
    documented, expected = documented_parameters(docstring), parameters(function)
    missing = [f"missing {name}" for name in expected if name not in documented]
    return missing + [f"unknown {name}" for name in documented if name not in expected]


def has_no_section(function: Function) -> bool:
    """Return whether a function has parameters and its docstring has no numpydoc section."""
    return bool(parameters(function)) and not sections(ast.get_docstring(function) or "")


def missing_sections(function: Function) -> list[str]:
    """Return the sections that a function of the Python interface must have and lacks."""
    present = sections(ast.get_docstring(function) or "")
    returns = function.returns is not None and ast.unparse(function.returns) not in (
        "None",
        "NoReturn",
    )
    required = {
        "Parameters": bool(parameters(function)),
        "Returns": returns and "Yields" not in present,
        "Raises": raises_directly(function),
    }
    return [title for title, needed in required.items() if needed and title not in present]


def raises_directly(function: Function) -> bool:
    """Return whether a function has a ``raise`` of its own, not of a nested function."""
    pending: list[ast.AST] = list(function.body)
    while pending:
        node = pending.pop()
        if isinstance(node, ast.Raise):
            return True
        if not isinstance(node, Function | ast.ClassDef | ast.Lambda):
            pending.extend(ast.iter_child_nodes(node))
    return False


def public_functions(tree: ast.Module, *, methods: bool = False) -> Iterator[Function]:
    """Yield the public functions of a module without compiled ones, and methods if requested."""
    for node in tree.body:
        if isinstance(node, Function) and not node.name.startswith("_"):
            if not _is_excluded(node):
                yield node
        elif methods and isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            for each in node.body:
                if isinstance(each, Function) and not each.name.startswith("_"):
                    yield each


def _is_excluded(function: Function) -> bool:
    names = (each.func if isinstance(each, ast.Call) else each for each in function.decorator_list)
    return any(isinstance(name, ast.Name) and name.id in EXCLUDED_DECORATORS for name in names)


def incomplete_parameters(tree: ast.Module) -> Iterator[str]:
    """Yield the public functions and methods whose Parameters section is not the signature."""
    for function in public_functions(tree, methods=True):
        if errors := parameter_errors(function):
            yield f"{function.lineno}: {function.name}: {', '.join(errors)}"


def without_sections(tree: ast.Module) -> Iterator[str]:
    """Yield the public functions that have parameters and no section."""
    for function in public_functions(tree):
        if has_no_section(function):
            yield f"{function.lineno}: {function.name}"


def long_summaries(tree: ast.Module) -> Iterator[str]:
    """Yield the docstrings whose first line is longer than MAX_SUMMARY."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | Function):
            summary = (ast.get_docstring(node) or "").partition("\n")[0]
            if len(summary) > MAX_SUMMARY:
                yield f"{node.body[0].lineno}: {summary}"


CHECKS: dict[str, Callable[[ast.Module], Iterator[str]]] = {
    "incomplete_parameters": incomplete_parameters,
    "long_summaries": long_summaries,
    "without_sections": without_sections,
}


@cache
def places(package: str) -> dict[str, list[str]]:
    """Return the places that each check finds in a package, parsing every module once."""
    found: dict[str, list[str]] = {check: [] for check in CHECKS}
    for path in _modules(package):
        tree = ast.parse(path.read_text("utf-8"))
        for check, hits in found.items():
            hits += [f"{path.relative_to(ROOT)}:{place}" for place in CHECKS[check](tree)]
    return found


def run_functions() -> Iterator[tuple[str, Function]]:
    """Yield the path and the function of each command that runs an operation."""
    for path in _modules("cli"):
        for function in public_functions(ast.parse(path.read_text("utf-8"))):
            if function.name == "run":
                yield path.relative_to(ROOT).as_posix(), function


def _modules(package: str) -> list[Path]:
    return sorted((ROOT / "vomstudio" / package).rglob("*.py"))


def counts(check: str) -> dict[str, int]:
    """Return the number of places of a check, by package."""
    packages = sorted(
        p.name for p in (ROOT / "vomstudio").iterdir() if (p / "__init__.py").is_file()
    )
    return {package: len(places(package)[check]) for package in packages}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--list", metavar="PACKAGE")
    arguments = parser.parse_args()
    if arguments.list:
        for title, listing in places(arguments.list).items():
            print(title, *listing, sep="\n")
    else:
        CEILINGS.write_text(json.dumps({name: counts(name) for name in CHECKS}, indent=1) + "\n")
        print(CEILINGS.read_text())
