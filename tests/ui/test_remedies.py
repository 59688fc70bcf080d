"""Every reason of a verdict has a short form, and a command that exists acts on it."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import vomstudio
from vomstudio.core.finding_texts import TEXTS
from vomstudio.core.findings import Finding
from vomstudio.ui.base.remedies import REMEDIES, remedy_command, short_reason

FOLDER = Path(vomstudio.__file__).parent
JUDGES = (
    "geology/quality.py",
    "geology/doubtful_stretches.py",
    "geometry/heights/levels.py",
)
MAX_WORDS = 10


def codes_of(path: Path) -> set[str]:
    """Codes with the severity of a reason that a module contains as text."""
    tree = ast.parse(path.read_text("utf-8"))
    words = (n.value for n in ast.walk(tree) if isinstance(n, ast.Constant))
    return {w for w in words if isinstance(w, str) and w in TEXTS and TEXTS[w][0] != "info"}


def test_each_reason_of_a_verdict_has_a_short_form() -> None:
    codes = set().union(*(codes_of(FOLDER / module) for module in JUDGES))
    assert len(codes) > 15
    assert codes <= REMEDIES.keys()


@pytest.mark.parametrize("code", sorted(REMEDIES))
def test_short_reasons_do_not_exceed_the_word_limit(code: str) -> None:
    assert code in TEXTS
    assert len(REMEDIES[code].text.split()) <= MAX_WORDS


def test_reason_is_mapped_to_its_remedy_command() -> None:
    assert remedy_command(Finding("plane.too-small", ratio=3.0, minimum=10.0)) == "edit_feature"
    assert remedy_command(Finding("plane.bowed")) == ""


def test_an_unknown_reason_is_shown_in_full() -> None:
    finding = Finding("action.no-model")
    assert short_reason(finding) == finding.message


def test_remedy_commands_exist(window) -> None:
    commands = {remedy.command for remedy in REMEDIES.values()} - {""}
    assert commands <= window.actions_table.all.keys()
