"""Every public object says what it is, with an example that is run."""

from __future__ import annotations

import doctest
import importlib
import inspect
import pkgutil
from types import ModuleType

import matplotlib.pyplot as plt
import pytest

import vomstudio as vs
from vomstudio import api
from vomstudio.core import progress

MODULES = [
    importlib.import_module(f"vomstudio.api.{m.name}") for m in pkgutil.iter_modules(api.__path__)
]
OBJECTS = [name for name in vs.__all__ if callable(getattr(vs, name))]


EXPENSIVE = (
    "comparisons",
    "elevations",
    "extractions",
    "measurables",
    "orthophotos",
    "project_changes",
    "projects",
    "surfaces",
    "surveys",
)


@pytest.mark.parametrize(
    "module",
    [
        pytest.param(
            module,
            marks=[pytest.mark.full] if module.__name__.endswith(EXPENSIVE) else [],
            id=module.__name__,
        )
        for module in (*MODULES, progress)
    ],
)
def test_docstring_examples_pass(module: ModuleType) -> None:
    found = doctest.testmod(module, optionflags=doctest.ELLIPSIS)
    plt.close("all")
    assert found.failed == 0


@pytest.mark.parametrize("name", OBJECTS)
def test_every_object_has_an_example(name: str) -> None:
    assert ">>> " in (inspect.getdoc(getattr(vs, name)) or "")


@pytest.mark.parametrize("name", OBJECTS)
def test_public_members_of_classes_have_docstrings(name: str) -> None:
    thing = getattr(vs, name)
    if inspect.isclass(thing):
        own = [v for k, v in vars(thing).items() if not k.startswith("_")]
        described = [v for v in own if inspect.isfunction(v) or isinstance(v, property)]
        assert all(inspect.getdoc(v) for v in described)


@pytest.mark.parametrize("name", [n for n in OBJECTS if inspect.isfunction(getattr(vs, n))])
def test_function_docstrings_document_parameters_and_errors(name: str) -> None:
    function = getattr(vs, name)
    said = inspect.getdoc(function) or ""
    assert "Raises" in said
    for parameter in inspect.signature(function).parameters:
        assert parameter in said, parameter


@pytest.mark.parametrize("name", [n for n in dir(vs.Project) if not n.startswith("_")])
def test_project_docstrings_document_parameters_and_have_examples(name: str) -> None:
    member = inspect.getattr_static(vs.Project, name)
    said = inspect.getdoc(member) or ""
    assert ">>> " in said
    if isinstance(member, property):
        return
    signature = inspect.signature(getattr(vs.Project, name))
    for parameter in signature.parameters.keys() - {"self"}:
        assert parameter in said, parameter
    if signature.return_annotation != "None" and name != "plot":
        assert "Returns" in said
