"""The help of every command has groups, and two examples that its parser accepts."""

from __future__ import annotations

import argparse
import itertools
import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest

from vomstudio.cli.common.command_help import (
    EXAMPLES,
    GENERAL,
    SOURCES,
    USER_FILES,
    command_examples,
    group_actions,
    help_group,
)
from vomstudio.cli.common.entry import build_parser

ROOT = Path(__file__).resolve().parents[2]


def parsers() -> Iterator[argparse.ArgumentParser]:
    pending: list[argparse.ArgumentParser] = [build_parser(())]
    while pending:
        parser = pending.pop()
        for action in parser._actions:
            if isinstance(action, argparse._SubParsersAction):
                pending += action.choices.values()
                yield from action.choices.values()


PARSERS = {parser.prog: parser for parser in parsers()}


def test_every_command_and_action_has_two_examples() -> None:
    assert all(len(set(command_examples(program))) == 2 for program in PARSERS)
    assert len(EXAMPLES) == len(PARSERS)


@pytest.mark.parametrize("program", PARSERS)
def test_the_parser_of_a_command_accepts_its_examples(program: str) -> None:
    for example in command_examples(program):
        name, *words = shlex.split(example)
        assert name == "vomstudio"
        if program != "vomstudio project":
            command = program.replace("vomstudio ", "").replace("PROJECT ", "")
            action = [word for word in words if not word.endswith(".vom")]
            assert action[: len(command.split())] == command.split()
        build_parser(words).parse_args(words)


@pytest.mark.parametrize("program", PARSERS)
def test_the_help_shows_the_examples_and_where_their_files_come_from(program: str) -> None:
    shown = PARSERS[program].format_help()
    for example in command_examples(program):
        assert example in shown
        for word in shlex.split(example):
            written = f" -o {word}" in example
            if word.startswith("resources/"):
                assert (ROOT / word).exists()
            elif (word in SOURCES or word in USER_FILES) and not written:
                assert f"{word}: " in shown or any(
                    f" -o {word}" in e for e in command_examples(program)
                )


@pytest.mark.parametrize("program", PARSERS)
def test_examples_of_a_command_write_different_files(program: str) -> None:
    first, second = command_examples(program)
    written = [re.search(r" -o (\S+)| (\S+) create", each) for each in (first, second)]
    assert written[0] is None or written[1] is None or written[0][0] != written[1][0]


def test_every_example_table_is_written_by_a_documented_command() -> None:
    examples = [shlex.split(each) for program in PARSERS for each in command_examples(program)]
    tables = {
        word
        for words in examples
        for before, word in itertools.pairwise(words)
        if word.endswith(".csv") and "/" not in word and before not in ("-o", "--profiles")
    }
    assert tables
    for table in tables:
        assert SOURCES[table].endswith((f">{table}", f"-o {table}"))


@pytest.mark.parametrize("program", PARSERS)
def test_every_argument_is_in_one_group_and_general_options_come_last(program: str) -> None:
    actions = PARSERS[program]._actions
    groups = group_actions(actions)
    assert sum(map(len, groups.values())) == len(actions)
    assert [*groups][-1] == GENERAL
    assert {help_group(a) for a in actions if "--json" in a.option_strings} <= {GENERAL}
