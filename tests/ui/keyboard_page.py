"""The tables of keys in `docs/keyboard.md`, which ``python -m tests.ui.keyboard_page`` renews."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path

from PySide6.QtWidgets import QApplication

from vomstudio.ui.base.actions import Actions, Command, strip_mnemonic

PAGE = Path(__file__).resolve().parents[2] / "docs" / "keyboard.md"
BEGIN, END = "<!-- commands -->\n", "<!-- end of commands -->"
_ROW = re.compile(r"^\| (`.+`) \| .* \|$")
_TYPE = re.compile(r"type_\d")


def renewed(page: str, actions: Actions) -> str:
    """Return the page with the present names of all commands that have keys.

    A row keeps its place. Rows of removed commands are dropped, and new ones are added at the end.
    """
    start = page.index(BEGIN) + len(BEGIN)
    stop = page.index(END)
    rows = _rows(actions)
    lines = []
    for line in page[start:stop].splitlines():
        match = _ROW.match(line)
        if match is None:
            lines.append(line)
        elif match[1] in rows:
            lines.append(rows.pop(match[1]))
    return page[:start] + "\n".join([*lines, *rows.values()]) + "\n" + page[stop:]


def _rows(actions: Actions) -> dict[str, str]:
    """Return the rows of all commands with keys, by their first cell."""
    rows: dict[str, str] = {}
    types: list[tuple[str, Command]] = []
    for command in actions.commands():
        keys = [key.toString() for key in actions.all[command.name].shortcuts()]
        if keys and _TYPE.fullmatch(command.name):
            types.append((keys[0], command))
        elif keys:
            cell = ", ".join(f"`{key}`" for key in keys)
            assert cell not in rows, f"two commands have the keys {cell}"
            rows[cell] = f"| {cell} | {_title(command)} | {_scope(command)} |"
    (first_key, first), (last_key, last) = types[0], types[-1]
    cell = f"`{first_key}` to `{last_key}`"
    rows[cell] = f"| {cell} | {_title(first)} to {_title(last)} | {_scope(first)} |"
    return rows


def _title(command: Command) -> str:
    return strip_mnemonic(command.text).rstrip("…")


def _scope(command: Command) -> str:
    if command.is_viewport_key:
        return "outcrop"
    return "window and dialogs" if command.is_global else "window"


if __name__ == "__main__":
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    application = QApplication([])
    from vomstudio.io.settings import read_settings
    from vomstudio.ui.shell.main_window import MainWindow

    window = MainWindow(read_settings()[0])
    window._fill()
    PAGE.write_text(renewed(PAGE.read_text("utf-8"), window.actions_table), "utf-8")
    sys.stdout.flush()
    # The window starts worker processes, which need no orderly end here.
    os._exit(0)
