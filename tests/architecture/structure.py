"""The numbers of the program's structure: how large its parts are, and whether they go in circles.

Print them with `python -m tests.architecture.structure`.
"""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = "vomstudio"

MODULE_LINES, CLASS_LINES, FUNCTION_LINES = 500, 400, 80
MODULES_IN_A_FOLDER = 30
LONG_MODULES = 3
"""So many may be longer, each with the reason in its docstring after the words below."""
REASON = "Longer than other modules, since "


@dataclass(frozen=True)
class Part:
    """A module, folder, class or function, and its size: lines, or modules of a folder."""

    name: str
    size: int

    def __str__(self) -> str:
        return f"{self.size:>6}  {self.name}"


@dataclass(frozen=True)
class Structure:
    """All parts, the largest of each kind first."""

    modules: tuple[Part, ...]
    folders: tuple[Part, ...]
    classes: tuple[Part, ...]
    functions: tuple[Part, ...]


def over(parts: tuple[Part, ...], limit: int) -> list[Part]:
    return [part for part in parts if part.size > limit]


def measure(root: Path = ROOT) -> Structure:
    """The structure of the package under a folder; blank lines and comments count."""
    modules: list[Part] = []
    classes: list[Part] = []
    functions: list[Part] = []
    folders: Counter[str] = Counter()
    for path in sorted((root / PACKAGE).rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        name = path.relative_to(root).as_posix()
        modules.append(Part(name, len(text.splitlines())))
        if path.name != "__init__.py":
            folders[path.parent.relative_to(root).as_posix()] += 1
        for node, dotted in _definitions(ast.parse(text), ""):
            # Without decorators: a kernel's signature is no part of what must be understood.
            assert node.end_lineno is not None
            part = Part(f"{name}: {dotted}", node.end_lineno - node.lineno + 1)
            (classes if isinstance(node, ast.ClassDef) else functions).append(part)
    return Structure(
        _largest_first(modules),
        _largest_first([Part(name, count) for name, count in folders.items()]),
        _largest_first(classes),
        _largest_first(functions),
    )


def reason_of(module: Part, root: Path = ROOT) -> str | None:
    """Why it may be long, in the words of its docstring."""
    said = ast.get_docstring(ast.parse((root / module.name).read_text(encoding="utf-8"))) or ""
    _, _, reason = " ".join(said.split()).partition(REASON)
    return reason or None


Definition = ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef


def _definitions(node: ast.AST, above: str) -> Iterator[tuple[Definition, str]]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, Definition):
            dotted = f"{above}{child.name}"
            yield child, dotted
            yield from _definitions(child, f"{dotted}.")
        else:
            yield from _definitions(child, above)


def _largest_first(parts: list[Part]) -> tuple[Part, ...]:
    return tuple(sorted(parts, key=lambda part: (-part.size, part.name)))


def circles() -> list[str]:
    """The imports, "importer -> imported", that would have to go for no siblings to stand on each
    other; as few as will do. Imports inside functions count."""
    import grimp

    graph = grimp.build_graph(PACKAGE, cache_dir=None)
    packages = sorted(module for module in graph.modules if graph.find_children(module))
    return [
        f"{importer} -> {imported}"
        for package in packages
        for importer, imported in sorted(graph.nominate_cycle_breakers(package))
    ]


def report(found: Structure, going_round: list[str]) -> str:
    """What is over its limit, and the largest of each kind, for people."""
    lines = []
    for title, parts, limit in (
        ("lines of a module", found.modules, MODULE_LINES),
        ("modules of a folder", found.folders, MODULES_IN_A_FOLDER),
        ("lines of a class", found.classes, CLASS_LINES),
        ("lines of a function", found.functions, FUNCTION_LINES),
    ):
        many = over(parts, limit)
        lines.append(f"{title}: {len(parts)}, {len(many)} over {limit}; the largest")
        lines += [str(part) for part in parts[: max(3, len(many))]]
    lines.append(f"circles of siblings: {len(going_round)}")
    lines += [f"        {circle}" for circle in going_round]
    return "\n".join(lines)


if __name__ == "__main__":
    print(report(measure(), circles()))
