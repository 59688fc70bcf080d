"""The page of keys lists every key of the window, under the name of its command."""

from __future__ import annotations

from tests.ui import keyboard_page


def test_the_page_lists_the_keys_of_all_commands(window) -> None:
    """``python -m tests.ui.keyboard_page`` renews the tables."""
    page = keyboard_page.PAGE.read_text("utf-8")
    assert keyboard_page.renewed(page, window.actions_table) == page
    for before, after in (("| Search |", "| Find |"), ("| `Ctrl+K` |", "| `Ctrl+J` |")):
        wrong = page.replace(before, after)
        assert wrong != page
        assert keyboard_page.renewed(wrong, window.actions_table) != wrong
