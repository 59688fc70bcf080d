"""Each operation is declared once, and every door follows the declaration."""

from __future__ import annotations

import importlib
import inspect
import sys
import typing
from dataclasses import dataclass
from pathlib import Path

import pytest

import vomstudio as vs
from tests.architecture import operation_tables as tables
from tests.messages import refused
from vomstudio.api.declared_options import options_from_arguments
from vomstudio.cli.common.arguments import Parser
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.cli.common.first_word import COMMANDS
from vomstudio.core.errors import UsageError
from vomstudio.core.operations import INTERFACES, Operation
from vomstudio.core.options import Options, declarations, option, option_texts, option_words
from vomstudio.extraction.facet_options import FacetOptions
from vomstudio.studio.jobs import serialisation
from vomstudio.studio.operations import OPERATIONS
from vomstudio.studio.project_options import ACTION_OPTIONS
from vomstudio.ui.dialogs import figure_style_dialog

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


@each_operation
def test_the_command_has_the_declared_options(operation: Operation) -> None:
    command = _parser_of(operation.command_name)
    for options in (*operation.options, *operation.command_options):
        assert {
            each.flag for each in declarations(options)
        } <= command._option_string_actions.keys()


@each_operation
def test_the_window_generates_the_fields_with_labels(operation: Operation) -> None:
    if operation.window:
        window = inspect.getsourcefile(importlib.import_module(_module_of(operation.window)))
        folders = Path(window or "").parent, Path(figure_style_dialog.__file__).parent
        paths = [path for folder in folders for path in folder.glob("*.py")]
        source = "".join(path.read_text("utf-8") for path in paths)
        forms = [
            options
            for each in OPERATIONS
            for options in (*each.options, *each.command_options)
            if options.__name__ in source
        ]
        for options in (*operation.options, *operation.command_options):
            fields = {each for each in declarations(options) if each.label}
            assert any(fields <= set(declarations(form)) for form in forms) or not fields


@dataclass(frozen=True)
class WithNewOption(FacetOptions):
    """Options of the facets with one more, which is declared here and nowhere else."""

    max_facets: int | None = option(
        None,
        minimum=1,
        label="Maximum",
        help="maximum number of facets",
        tip="Maximum number of facets",
        automatic_text="all facets",
    )


def test_new_option_reaches_every_interface() -> None:
    parser = Parser(prog="facets")
    add_options(parser, WithNewOption)
    assert "--max-facets N" in parser.format_help()
    options = parse_options(parser.parse_args(["--max-facets", "3"]), WithNewOption)
    assert options == WithNewOption(max_facets=3)
    assert option_words(options) == [("--max-facets", "3")]
    assert serialisation.decode(WithNewOption, serialisation.encode(options)) == options
    assert option_texts(options) == ["Maximum 3"]
    assert options_from_arguments(WithNewOption, {"max_facets": 3, "model": None}) == options
    with refused("option.too-small", UsageError, field="max_facets", value=0):
        options_from_arguments(WithNewOption, {"max_facets": 0})
    page = "| option | meaning |\n|---|---|\n"
    row = "| `--max-facets N` | maximum number of facets (default: all facets) |"
    assert row in tables._with_rows(page, declarations(WithNewOption))


def test_all_option_classes_derive_from_options() -> None:
    stated = [each for one in OPERATIONS for each in (*one.options, *one.command_options)]
    for options in (*stated, *ACTION_OPTIONS.values()):
        assert issubclass(options, Options), options


@each_operation
def test_each_interface_exists_or_its_absence_has_a_reason(operation: Operation) -> None:
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
        (tables.MODULES, tables.renewed_modules),
    ):
        page = path.read_text("utf-8")
        assert renewed(page) == page, "run python -m tests.architecture.operation_tables"


def _actions() -> tuple[str, ...]:
    """Return the actions of `vomstudio project`."""
    return tuple(_parser_of("project")._subcommand_names())


def _parser_of(name: str) -> Parser:
    subparsers = Parser().add_subparsers(parser_class=Parser)
    importlib.import_module(f"vomstudio.cli.{name}").add_parser(subparsers)
    (command,) = subparsers.choices.values()
    return command


def _panel(place: str) -> object:
    return getattr(importlib.import_module(_module_of(place)), place.rpartition(".")[2])


def _module_of(place: str) -> str:
    return f"vomstudio.ui.{place.rpartition('.')[0]}"
