"""Commands that show the documentation, the shortcuts and the version."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from PySide6.QtWidgets import QMessageBox, QWidget

from vomstudio.core.paths import documentation
from vomstudio.core.version import __version__
from vomstudio.core.words import to_translate, tr
from vomstudio.ui.base.actions import Actions, Command
from vomstudio.ui.base.help_links import current_help_topic
from vomstudio.ui.base.open_dialogs import OpenDialogs
from vomstudio.ui.base.search import SearchEntry
from vomstudio.ui.base.window_fitting import show_long_text
from vomstudio.ui.dialogs.help.help_pages import help_address
from vomstudio.ui.widgets.failure_notices import Host, save_report

if TYPE_CHECKING:
    from vomstudio.ui.dialogs.command_palette import Destination
    from vomstudio.ui.dialogs.help.help_window import HelpWindow

_MOUSE_TEXT = to_translate(
    "<p><b>Mouse</b>: drag to orbit about the point under the cursor, turn the wheel to zoom to it,"
    " drag with Shift or the middle button to pan, and double-click to set the centre of rotation."
    " While picking: click to add a point, drag a vertex to move it, Ctrl+click to insert one, and"
    " press Enter or double-click to finish. With the plane brush: drag to paint, Ctrl+drag to"
    " erase; the right button orbits. With Select: hold Shift to add or Ctrl to remove; Ctrl+wheel"
    " and Shift+wheel change the tolerance. On the stereonet: click a pole or a great circle, or"
    " drag a lasso around poles; hold Ctrl or Shift to add.</p>"
)
_ABOUT_TEXT = to_translate(
    "<b>VOM Studio {version}</b><br>Measures geological structures on virtual outcrop models,"
    " with the error of each measurement.<br>BSD-3-Clause."
)


def commands(actions: Actions, host: Host, dialogs: OpenDialogs, parent: QWidget) -> list[Command]:
    """Create the help commands."""

    def show_documentation() -> None:
        _show_help(dialogs, parent)

    def show_explanation() -> None:
        topic = current_help_topic()
        if topic is None:
            _show_shortcuts(parent, actions)
            return
        _show_help(dialogs, parent).go_to(topic if isinstance(topic, str) else help_address(topic))

    return [
        Command(
            "documentation",
            tr("&Documentation"),
            show_documentation,
            icon="book-open-outline",
            tip=tr("First steps, meaning of the numbers, commands and file formats."),
        ),
        Command(
            "explain",
            tr("&Explain this"),
            show_explanation,
            icon="help-circle-outline",
            shortcut="F1",
            tip=tr("Explain the control under the cursor, or list the shortcuts."),
            is_global=True,
        ),
        Command(
            "shortcuts",
            tr("&Shortcuts"),
            lambda: _show_shortcuts(parent, actions),
            "keyboard-outline",
        ),
        Command(
            "save_report",
            tr("Save &report…"),
            lambda: save_report(host, parent),
            icon="file-alert-outline",
            tip=tr("Save an error report as text. Read it before sharing it."),
        ),
        Command(
            "about",
            tr("&About VOM Studio"),
            lambda: QMessageBox.about(parent, "VOM Studio", tr(_ABOUT_TEXT, version=__version__)),
        ),
    ]


def _show_help(dialogs: OpenDialogs, parent: QWidget) -> HelpWindow:
    from vomstudio.ui.dialogs.help.help_window import HelpWindow

    return dialogs.show(HelpWindow, lambda: HelpWindow(parent, documentation()), is_general=True)


def document_destinations(dialogs: OpenDialogs, parent: QWidget) -> list[Destination]:
    """Return the documentation pages for the search; empty if they cannot be read."""
    from vomstudio.ui.dialogs.command_palette import Destination
    from vomstudio.ui.dialogs.help.help_pages import list_pages

    def open_page(name: str) -> None:
        _show_help(dialogs, parent).go_to(name)

    try:
        pages = list_pages(documentation())
    except OSError:
        return []
    return [
        Destination(
            SearchEntry(f"document_{page.path.stem}", tr("Help: {title}", title=page.title)),
            partial(open_page, page.path.name),
        )
        for page in pages
    ]


def _show_shortcuts(parent: QWidget, actions: Actions) -> None:
    rows = []
    for command in actions.commands():
        keys = ", ".join(k.toString() for k in actions.all[command.name].shortcuts())
        if keys:
            text = command.text.replace("&", "")
            if command.is_viewport_key:
                text = tr("{command} (in the viewport)", command=text)
            rows.append(f"<tr><td><b>{keys}</b>&nbsp;&nbsp;</td><td>{text}</td></tr>")
    show_long_text(parent, tr("Shortcuts"), f"<table>{''.join(rows)}</table>{tr(_MOUSE_TEXT)}")
