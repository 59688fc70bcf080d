"""The tools that are found, and what each says of itself."""

from __future__ import annotations

from collections import Counter

from tests.project.conftest import MemoryJournal
from tests.studio.tools.fakes import Context
from vomstudio.project.session import Session
from vomstudio.studio.tools.registry import TOOLS


def test_each_tool_has_a_unique_name_key_and_position() -> None:
    for value in ("name", "key", "order", "label", "icon", "tip"):
        shared = [v for v, n in Counter(getattr(e, value) for e in TOOLS).items() if n > 1]
        assert not shared, (value, shared)
    for entry in TOOLS:
        letter = entry.label.partition("&")[2][:1]
        words = "the letter in the menu is the key over the outcrop"
        assert letter.upper() == entry.key.removeprefix("Shift+"), words


def test_each_new_tool_is_idle_and_has_a_hint() -> None:
    journal = MemoryJournal()
    for entry in TOOLS:
        tool = entry.tool(Context(Session(journal), journal))
        assert not tool.is_open
        assert tool.hint().endswith("."), "a sentence for the status line"
        assert tool.cancel_problem()
        assert tool.finish_problem()
