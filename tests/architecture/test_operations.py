"""Each operation is declared once, and every door follows the declaration."""

from __future__ import annotations

import importlib
import inspect
import sys
import typing

import pytest

import vomstudio as vs
from tests.architecture import operation_tables as tables
from vomstudio.cli import project
from vomstudio.cli.common.arguments import Parser
from vomstudio.cli.common.first_word import COMMANDS
from vomstudio.core.operations import INTERFACES, Operation
from vomstudio.core.options import Options, declarations
from vomstudio.studio.operations import OPERATIONS
from vomstudio.studio.project_options import ACTION_OPTIONS

each_operation = pytest.mark.parametrize("operation", OPERATIONS, ids=lambda each: each.name)


@each_operation
def test_the_python_function_has_the_declared_parameters(operation: Operation) -> None:
    if not operation.function:
        return
    function = getattr(vs, operation.function)
    parameters = inspect.signature(function).parameters
    for options in operation.options:
        hints = typing.get_type_hints(options)
        for each in declarations(options):
            assert each.name in parameters, each.name
            parameter = parameters[each.name]
            assert parameter.kind is parameter.KEYWORD_ONLY
            assert parameter.default == (parameter.empty if each.is_required else each.default)
            if each.kind is str and each.choices is None:
                continue  # Python also takes planes, points and files in other forms.
            # Other parameters have types of libraries that are imported for checks only.
            written = eval(
                function.__annotations__[each.name], vars(sys.modules[function.__module__])
            )
            assert written == hints[each.name]


def test_all_options_check_their_values_as_their_base_does() -> None:
    stated = [each for one in OPERATIONS for each in (*one.options, *one.command_options)]
    for options in (*stated, *ACTION_OPTIONS.values()):
        assert issubclass(options, Options), options


@each_operation
def test_each_door_exists_or_its_absence_has_a_reason(operation: Operation) -> None:
    doors = {
        "command": operation.command_name in COMMANDS,
        "function": bool(operation.function) and operation.function in vs.__all__,
        "window": bool(operation.window) and _panel(operation.window) is not None,
        "project method": hasattr(vs.Project, operation.method) if operation.method else False,
        "project command": operation.action in _actions() if operation.action else False,
    }
    for door in INTERFACES:
        assert doors[door] != (door in operation.missing), (door, doors[door])


def test_the_documents_have_the_declared_tables() -> None:
    for path, renewed in (
        (tables.COMMANDS, tables.renewed_commands),
        (tables.ARCHITECTURE, tables.renewed_architecture),
    ):
        page = path.read_text("utf-8")
        assert renewed(page) == page, "run python -m tests.architecture.operation_tables"


def _actions() -> tuple[str, ...]:
    """Return the actions of `vomstudio project`."""
    subparsers = Parser().add_subparsers(parser_class=Parser)
    project.add_parser(subparsers)
    (command,) = subparsers.choices.values()
    return tuple(command._subparsers_choices())


def _panel(place: str) -> object:
    module, _, name = place.rpartition(".")
    return getattr(importlib.import_module(f"vomstudio.ui.{module}"), name)
