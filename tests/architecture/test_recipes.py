"""The commands of the recipes, whose files belong to other programs, have options that exist."""

from __future__ import annotations

import shlex
from pathlib import Path

from tests.architecture.test_document_commands import CONTINUED, blocks_of
from vomstudio.cli.common.entry import build_parser

PAGE = Path(__file__).resolve().parents[2] / "docs" / "recipes.md"


def test_every_command_in_recipes_is_valid() -> None:
    blocks = blocks_of(PAGE.read_text("utf-8"))
    commands = [
        shlex.split(line)[1:]
        for block in blocks
        for line in CONTINUED.sub(" ", block.code).splitlines()
        if line.startswith("vomstudio ")
    ]
    assert len(commands) > 15
    parser = build_parser(())
    for command in commands:
        # It exits on a word that it does not know.
        assert parser.parse_args(command)
