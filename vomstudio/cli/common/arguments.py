"""Command-line arguments and errors about them."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from vomstudio.cli.common.command_help import examples_text, group_actions
from vomstudio.cli.common.first_word import nearest_word
from vomstudio.cli.common.reporting import Reporter, SilentReporter
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr

if TYPE_CHECKING:
    from vomstudio.cli.common.output import Output

Subparsers = Any
"""Any, because the class of argparse is private."""
Run = Callable[[argparse.Namespace, "Output"], None]


class HelpRequested(Exception):
    """Exception that contains the text to show for ``--help`` or ``--version``."""


_ERROR_CODES: dict[Any, str] = {float: "number.invalid", int: "number.not-whole"}
"""Codes of the errors for words that are not valid numbers, by the type of the number."""


class Parser(argparse.ArgumentParser):
    """Parser that raises errors instead of printing a message and exiting."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        kwargs.setdefault("allow_abbrev", False)
        super().__init__(*args, **kwargs)
        # Such a word is not an option: -5,3,2 are coordinates.
        self._negative_number_matcher = re.compile(r"^-\.?\d[-+\d.,eE]*$")

    def format_help(self) -> str:
        """Return the help: usage, arguments by group, examples."""
        formatter = self._get_formatter()
        formatter.add_usage(self.usage, self._actions, self._mutually_exclusive_groups)
        formatter.add_text(self.description)
        for title, actions in group_actions(self._actions).items():
            formatter.start_section(tr(title))
            formatter.add_arguments(actions)
            formatter.end_section()
        formatter.add_text(self.epilog)
        examples = examples_text(self.prog)
        return formatter.format_help() + (f"\n{examples}" if examples else "")

    def _get_values(self, action: argparse.Action, arg_strings: list[str]) -> Any:
        # An empty word results from an unset variable in a script. As a path, it would mean the
        # current folder with all its contents.
        rejects_empty = action.dest == "output" or not action.option_strings
        if rejects_empty and action.nargs != argparse.PARSER and "" in arg_strings:
            raise UsageError(Finding("name.empty"), field=_action_name(action))
        # Users who write - mean standard output and not a file with that name.
        if action.dest == "output" and arg_strings == ["-"]:
            raise UsageError(Finding("output.is-stdout"), field=_action_name(action))
        return super()._get_values(action, arg_strings)

    def _get_value(self, action: argparse.Action, arg_string: str) -> Any:
        try:
            value = super()._get_value(action, arg_string)
        except argparse.ArgumentError:
            if action.type not in _ERROR_CODES:
                raise
            finding = Finding(_ERROR_CODES[action.type], text=arg_string)
            raise UsageError(finding, field=_action_name(action)) from None
        # Choices never differ only in case, so PCA is pca.
        if isinstance(action, argparse._SubParsersAction) or action.choices is None:
            return value
        matches = [c for c in action.choices if isinstance(c, str) and c == str(value).casefold()]
        return matches[0] if matches else value

    def parse_known_args(  # type: ignore[override]
        self, args: Sequence[str] | None = None, namespace: Any = None
    ) -> tuple[argparse.Namespace, list[str]]:
        """Parse the words, and raise UsageError if one of them is unknown.

        The parser of each command checks its own words, so that the error can suggest its options.
        Unknown options are reported before missing ones, because they may be the same, misspelt.
        """
        arguments = list(args or ())
        if unknown_option := next(self._unknown_options(arguments), None):
            self._refuse_option(unknown_option)
        parsed_namespace, remaining_words = super().parse_known_args(arguments, namespace)
        if remaining_words:
            raise self._unknown_argument_error(" ".join(remaining_words))
        return parsed_namespace, remaining_words

    def _unknown_options(self, arguments: Sequence[str]) -> Iterator[str]:
        """Yield unknown options among the words before a subcommand; none if help is requested."""
        options = self._option_string_actions
        subcommands = self._subcommand_names()
        if not {"-h", "--help"}.isdisjoint(arguments):
            return
        remaining_positionals = sum(not action.option_strings for action in self._actions) - 1
        for word in arguments:
            if word == "--" or word in subcommands:
                return
            if not word.startswith("-") or " " in word or word == "-":
                remaining_positionals -= 1
                if subcommands and remaining_positionals < 0:
                    # The word is a misspelt subparser, which is reported as such.
                    return
                continue
            if self._negative_number_matcher.match(word):
                continue
            option = word.partition("=")[0]
            if option not in options and (word.startswith("--") or word[:2] not in options):
                yield option

    def _subcommand_names(self) -> frozenset[str]:
        subparser_actions = [a for a in self._actions if isinstance(a, argparse._SubParsersAction)]
        return frozenset(name for action in subparser_actions for name in action.choices)

    def _refuse_option(self, option: str) -> NoReturn:
        # Compare without the leading dashes, which would make all options similar.
        flags_by_name = {name.lstrip("-"): name for name in self._option_string_actions}
        if suggestion := nearest_word(option.lstrip("-").casefold(), [*flags_by_name], 0.7):
            raise self._misspelling_error(option, flags_by_name[suggestion], option)
        raise self._unknown_argument_error(option)

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        try:
            super()._check_value(action, value)
        except argparse.ArgumentError:
            choices = [str(choice) for choice in action.choices or ()]
            if suggestion := nearest_word(str(value).casefold(), choices):
                raise self._misspelling_error(
                    str(value), suggestion, _action_name(action)
                ) from None
            finding = Finding("option.not-a-choice", value=value, choices=choices)
            raise UsageError(finding, field=_action_name(action)) from None

    def error(self, message: str) -> NoReturn:
        if missing_match := re.search(r"arguments are required: (.+)$", message):
            names = [_long_name(name) for name in missing_match[1].split(", ")]
            finding = Finding("command.arguments-missing", names=names, program=self.prog)
            raise UsageError(finding, field=names[0])
        match = re.match(r"argument ([^:]+): (.*)", message, re.DOTALL)
        field, problem = match.groups() if match else (_parse_alternatives(message), message)
        problem = " ".join(problem.split())
        problem = problem[:1].upper() + problem[1:]
        finding = Finding("command.invalid", problem=problem, program=self.prog)
        raise UsageError(finding, field=None if field is None else _long_name(field))

    def _misspelling_error(self, value: str, suggestion: str, field: str | None) -> UsageError:
        finding = Finding("command.misspelt", value=value, nearest=suggestion, program=self.prog)
        return UsageError(finding, field=field)

    def _unknown_argument_error(self, value: str) -> UsageError:
        finding = Finding("command.unknown-argument", value=value, program=self.prog)
        return UsageError(finding, field=value)

    def _print_message(self, message: str, file: object = None) -> None:
        raise HelpRequested(message.rstrip("\n"))


def _action_name(action: argparse.Action) -> str | None:
    name = argparse._get_action_name(action)
    return None if name is None else _long_name(name)


def _parse_alternatives(message: str) -> str | None:
    """Return the required alternatives from a message of argparse; None for other messages."""
    match = re.search(r"^one of the arguments (.+) is", message)
    return None if match is None else match[1]


def _long_name(names: str) -> str:
    """Return ``--output`` for ``-o/--output``."""
    return names.rpartition("/")[2]


def add_command(subparsers: Subparsers, name: str, run: Run, *, help_: str) -> Parser:
    """Add a command with the options that are shared by all commands."""
    parser: Parser = subparsers.add_parser(name, help=help_, description=f"{help_}.")
    add_shared_options(parser)
    parser.set_defaults(run=run, reporter=SilentReporter())
    return parser


def add_shared_options(parser: argparse.ArgumentParser) -> None:
    """Add the options shared by every command and every action of a command."""
    parser.add_argument("--json", action="store_true", help=tr("print one JSON object on stdout"))
    parser.add_argument(
        "--progress", choices=["json"], help=tr("report progress as JSON lines on stderr")
    )
    parser.add_argument(
        "-q", "--quiet", action="store_true", help=tr("show no progress, notes or warnings")
    )
    parser.add_argument(
        "-v",
        "--verbose",
        action="store_true",
        help=tr("show every stage with its time, and the codes of findings"),
    )


def add_output(parser: Parser, description: str, *, is_required: bool = False) -> None:
    """Add ``--output`` and ``--force``."""
    parser.add_argument("-o", "--output", metavar="FILE", required=is_required, help=description)
    parser.add_argument("--force", action="store_true", help=tr("replace an existing FILE"))


def progress_reporter(args: argparse.Namespace) -> Reporter:
    """Return the reporter for the long-running tasks of a command."""
    reporter: Reporter = args.reporter
    return reporter


def report_reading(args: argparse.Namespace, path: str | Path) -> Reporter:
    """Report that a file is being read, and return the reporter for the subsequent work."""
    progress = progress_reporter(args)
    progress.stage(tr("Reading {file}", file=Path(path).name))
    return progress
