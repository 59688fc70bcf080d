"""Numpydoc sections agree with the signatures, and functions without sections become fewer."""

from __future__ import annotations

import ast
import inspect
import json
import textwrap

import pytest

import vomstudio as vs
from tests.architecture.docstrings import (
    CEILINGS,
    CHECKS,
    Function,
    counts,
    documented_parameters,
    has_no_section,
    missing_sections,
    parameter_errors,
    places,
    public_functions,
    raises_directly,
    run_functions,
)

INTERFACE = [name for name in vs.__all__ if inspect.isfunction(getattr(vs, name))]


@pytest.mark.parametrize("name", INTERFACE)
def test_public_functions_have_all_docstring_sections(name: str) -> None:
    function = _parsed(textwrap.dedent(inspect.getsource(inspect.unwrap(getattr(vs, name)))))
    assert missing_sections(function) == []
    assert parameter_errors(function) == []


def test_run_functions_of_the_commands_have_all_sections() -> None:
    functions = dict(run_functions())
    assert len(functions) > 30
    for path, function in functions.items():
        assert missing_sections(function) == [], path
        assert parameter_errors(function) == [], path


@pytest.mark.parametrize("check", CHECKS)
def test_no_package_has_more_incomplete_docstrings_than_before(check: str) -> None:
    ceilings, found = json.loads(CEILINGS.read_text())[check], counts(check)
    assert found.keys() == ceilings.keys(), "run python -m tests.architecture.docstrings"
    above = [package for package in found if found[package] > ceilings[package]]
    listed = [place for package in above for place in places(package)[check][:20]]
    assert not above, "\n".join(listed)


COMPLETE = '''
def f(a, b=1, *args, key, **more):
    """Do it.

    Parameters
    ----------
    a, b : float
        In metres: a length.
    *args
    key : str

    Other Parameters
    ----------------
    **more : object

    Returns
    -------
    c : float
    """
'''


def test_a_complete_docstring_has_no_errors() -> None:
    function = _parsed(COMPLETE)
    assert documented_parameters(ast.get_docstring(function) or "") == [
        "a",
        "b",
        "args",
        "key",
        "more",
    ]
    assert parameter_errors(function) == []
    assert not has_no_section(function)


def test_missing_and_unknown_parameters_are_reported() -> None:
    function = _parsed(COMPLETE.replace("    key : str\n", "    kee : str\n"))
    assert parameter_errors(function) == ["missing key", "unknown kee"]


def test_methods_are_compared_without_self() -> None:
    source = "class A:\n" + textwrap.indent(COMPLETE.replace("f(a,", "f(self, a,"), "    ")
    (method,) = public_functions(ast.parse(source), methods=True)
    assert parameter_errors(method) == []


def test_missing_sections_are_named() -> None:
    source = 'def f(a) -> int:\n    """Do it."""\n    if a:\n        raise ValueError\n'
    assert missing_sections(_parsed(source)) == ["Parameters", "Returns", "Raises"]
    assert missing_sections(_parsed('def f() -> None:\n    """Do it."""\n')) == []
    assert has_no_section(_parsed(source))


def test_errors_of_nested_functions_are_not_raised_directly() -> None:
    nested = "def f():\n    def g():\n        raise ValueError\n    return g\n"
    assert not raises_directly(_parsed(nested))


def test_private_and_compiled_functions_are_not_public() -> None:
    source = "@part\ndef a(x): ...\n@kernel('')\ndef b(x): ...\ndef _c(x): ...\ndef d(x): ...\n"
    assert [each.name for each in public_functions(ast.parse(source))] == ["d"]


def _parsed(source: str) -> Function:
    function = ast.parse(source).body[0]
    assert isinstance(function, Function)
    return function
