"""`import vomstudio` costs nothing, and what it offers is found by editors."""

from __future__ import annotations

import ast
import importlib
import inspect
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import vomstudio as vs

ROOT = Path(__file__).resolve().parents[2]
HEAVY = {"PySide6", "vtkmodules", "vtk", "pyvista", "open3d", "pycolmap", "matplotlib"}
MOST_S = 0.25


def said_by(code: str) -> str:
    words = [sys.executable, "-c", code]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, timeout=120, check=True)
    return done.stdout


def test_the_import_is_quick_and_loads_nothing_heavy() -> None:
    code = (
        "import time, numpy\nstart = time.perf_counter()\nimport vomstudio as vs, sys\n"
        "print(time.perf_counter() - start, *{m.partition('.')[0] for m in sys.modules})"
    )
    seconds, *loaded = said_by(code).split()
    assert float(seconds) < MOST_S
    assert not HEAVY & set(loaded)


def test_accessing_all_public_names_loads_neither_qt_nor_drawing_library() -> None:
    code = (
        "import vomstudio as vs, sys\n[getattr(vs, name) for name in vs.__all__]\n"
        "print(*{m.partition('.')[0] for m in sys.modules})"
    )
    assert not HEAVY & set(said_by(code).split())


def test_fitting_a_plane_needs_no_drawing_library() -> None:
    code = (
        "import vomstudio as vs, sys\nvs.fit_plane([[0, 0, 0], [1, 0, 0], [0, 1, 0]])\n"
        "print(*{m.partition('.')[0] for m in sys.modules})"
    )
    assert not HEAVY & set(said_by(code).split())


def test_all_public_names_exist_and_appear_in_dir() -> None:
    assert set(vs.__all__) <= set(dir(vs))
    for name in vs.__all__:
        assert getattr(vs, name) is not None
    assert vs.errors is importlib.import_module("vomstudio.core.errors")
    with pytest.raises(AttributeError, match="reed"):
        vs.reed  # noqa: B018 - asking for it is the test


def test_stub_declares_the_same_names_from_the_same_modules() -> None:
    stub = ast.parse((ROOT / "vomstudio" / "__init__.pyi").read_text())
    told = {
        alias.name: node.module
        for node in stub.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert set(told) == set(vs.__all__)
    for name, module in told.items():
        assert getattr(importlib.import_module(str(module)), name) is getattr(vs, name)


def public_functions() -> Iterator[tuple[str, dict[str, object]]]:
    """Yield the annotations of the public functions, methods and properties."""
    for name in vs.__all__:
        value = getattr(vs, name)
        if inspect.isfunction(value):
            yield name, value.__annotations__
        elif inspect.isclass(value):
            for method_name, member in inspect.getmembers_static(value):
                function = getattr(member, "fget", getattr(member, "__func__", member))
                if inspect.isfunction(function) and not method_name.startswith("_"):
                    yield f"{name}.{method_name}", function.__annotations__
            yield name, value.__init__.__annotations__


def test_public_signatures_declare_their_types() -> None:
    # The object that ``--json`` prints has values of many types.
    undeclared = [
        (name, parameter)
        for name, annotations in public_functions()
        for parameter, annotation in annotations.items()
        if re.search(r"\bAny\b", str(annotation))
        and not parameter.startswith("_")
        and not name.endswith(".to_dict")
    ]
    assert undeclared == []


@pytest.mark.parametrize(
    ("name", "result"),
    [
        ("read_orientations", "pandas.DataFrame"),
        ("fit_planes", "pandas.DataFrame"),
        ("stereonet", "StereonetAxes"),
        ("rose", "Axes"),
    ],
)
def test_tables_and_axes_are_declared_as_return_types(name: str, result: str) -> None:
    assert getattr(vs, name).__annotations__["return"] == result


def test_no_module_of_program_imports_the_root_package() -> None:
    """But for what lies beside it, which it does not name."""
    for path in (ROOT / "vomstudio").rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        if not re.search(r"import vomstudio|from vomstudio import", text):
            continue
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Import):
                assert all(alias.name != "vomstudio" for alias in node.names), path
            elif isinstance(node, ast.ImportFrom) and node.module == "vomstudio":
                names = {alias.name for alias in node.names}
                assert all((ROOT / "vomstudio" / name).is_dir() for name in names), path
