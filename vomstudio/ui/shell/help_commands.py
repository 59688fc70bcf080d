"""The documentation, the list of shortcuts, and what this program is."""

from __future__ import annotations

from PySide6.QtWidgets import QMessageBox, QWidget

from vomstudio.paths import documentation
from vomstudio.ui.common.actions import Actions, Command
from vomstudio.ui.common.open_dialogs import OpenDialogs
from vomstudio.ui.shell.failure_notices import Host, save_report
from vomstudio.version import __version__

_MOUSE = (
    "<p><b>Mouse</b>: drag orbits about the point under the cursor, wheel zooms to the cursor, "
    "middle button or Shift+drag pans, double click sets the pivot. While picking: click adds, "
    "drag a vertex moves it, Ctrl+click inserts, Enter or double click finishes. With the "
    "brush of Patch: drag paints, Ctrl+drag takes away, the right button orbits. "
    "On the net: click a pole or a great circle, drag a lasso around poles; Ctrl adds.</p>"
)
_ABOUT = (
    f"<b>VOM Studio {__version__}</b><br>Virtual outcrop models of geological structures: "
    "measurements with their errors.<br>BSD-3-Clause."
)


def commands(actions: Actions, host: Host, dialogs: OpenDialogs, parent: QWidget) -> list[Command]:
    """parent : of the dialogs"""

    def read() -> None:
        from vomstudio.ui.shell.help_window import HelpWindow

        dialogs.show(HelpWindow, lambda: HelpWindow(parent, documentation()))

    return [
        Command("documentation", "&Documentation", read, "book-open-outline", (),
                "First steps, what the numbers mean, commands and file formats"),
        Command("shortcuts", "&Shortcuts", lambda: _shortcuts(parent, actions),
                "keyboard-outline", "F1"),
        Command("save_report", "Save a &report…", lambda: save_report(host, parent),
                "file-alert-outline", (),
                "What went wrong, as a text that you can read before giving it to anybody"),
        Command("about", "&About VOM Studio",
                lambda: QMessageBox.about(parent, "VOM Studio", _ABOUT)),
    ]  # fmt: skip


def _shortcuts(parent: QWidget, actions: Actions) -> None:
    rows = []
    for command in actions.commands():
        keys = ", ".join(k.toString() for k in actions.all[command.name].shortcuts())
        if keys:
            where = " (in the viewport)" if command.in_viewport else ""
            text = command.text.replace("&", "") + where
            rows.append(f"<tr><td><b>{keys}</b>&nbsp;&nbsp;</td><td>{text}</td></tr>")
    QMessageBox.information(parent, "Shortcuts", f"<table>{''.join(rows)}</table>{_MOUSE}")
