"""No two public classes of the program share a name."""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Iterable, Mapping
from pathlib import Path

PROGRAM = Path(__file__).resolve().parents[2] / "vomstudio"
SHARED_NAMES = {
    "ControlPoint": (
        {"io/control/points.py", "project/kinds/control_point.py"},
        "Formats of other packages create the first; error messages name the kind of the second.",
    ),
    "Mesh": (
        {"api/models.py", "geometry/mesh.py"},
        "The first is a name of `vs`; readers of other packages create the second.",
    ),
    "PointCloud": (
        {"api/models.py", "geometry/cloud.py"},
        "The first is a name of `vs`; readers of other packages create the second.",
    ),
}
"""Names that several classes have: their modules, and the reason."""


def test_no_two_public_classes_share_a_name() -> None:
    files = sorted(PROGRAM.rglob("*.py"))
    sources = {file.relative_to(PROGRAM).as_posix(): file.read_text("utf-8") for file in files}
    repeated = repeated_class_names(sources)
    assert repeated == {name: modules for name, (modules, _) in SHARED_NAMES.items()}


def test_a_repeated_name_is_reported_with_its_modules() -> None:
    sources = {
        "a.py": "class Plan: pass\nclass _Row: pass\ndef f():\n    class Local: pass\n",
        "b.py": "if True:\n    class Plan: pass\nclass _Row: pass\nclass Local: pass\n",
        "c.py": "class Other:\n    class Plan: pass\nPlan = Other\n",
    }
    assert repeated_class_names(sources) == {"Plan": {"a.py", "b.py"}}


def repeated_class_names(sources: Mapping[str, str]) -> dict[str, set[str]]:
    """Return the modules of each public class name that several modules define."""
    modules = defaultdict(set)
    for path, source in sources.items():
        for name in _class_names(ast.parse(source).body):
            modules[name].add(path)
    return {name: paths for name, paths in modules.items() if len(paths) > 1}


def _class_names(statements: Iterable[ast.stmt]) -> Iterable[str]:
    for statement in statements:
        if isinstance(statement, ast.ClassDef):
            if not statement.name.startswith("_"):
                yield statement.name
        elif isinstance(statement, ast.If | ast.Try):
            yield from _class_names(statement.body)
            yield from _class_names(statement.orelse)
