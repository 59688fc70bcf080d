"""Presentation of a tool: texts of its button, menu and panel, as plain data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from vomstudio.core.words import tr


@dataclass(frozen=True)
class ToolEntry:
    """Presentation of a tool.

    Parameters
    ----------
    tool : type
        Its class, created with a `ToolContext` alone.
    label, tip : str
        Marked for translation; the label has "&" before its mnemonic.
    icon : str
        Name of a Material Design icon.
    key : str
        Shortcut in the viewport.
    order : int
        Position of its button among the tools.
    takes_keys : bool
        Whether it uses Shift with the left button, which else pans, and the wheel with Ctrl or
        Shift.
    """

    tool: type[Any]
    label: str
    icon: str
    key: str
    tip: str
    order: int
    takes_keys: bool = False

    @property
    def name(self) -> str:
        """Name of the tool, as in drafts."""
        name: str = self.tool.name
        return name

    @property
    def title(self) -> str:
        """Title of its panel, translated."""
        return tr(self.label).replace("&", "")


class NoSteps:
    """Base of tools whose steps are edits of the document, which has the undo."""

    @property
    def undo_label(self) -> str | None:
        return None

    @property
    def redo_label(self) -> str | None:
        return None

    def undo(self) -> bool:
        return False

    def redo(self) -> bool:
        return False


class StatelessTool(NoSteps):
    """Base of tools that change something with a click: no steps, no end and no draft."""

    def finish(self) -> str | None:
        return None

    def cancel(self) -> None:
        """Do nothing: there is never an unfinished feature."""

    def restore(self, state: Mapping[str, Any]) -> bool:
        return False

    def set_type(self, type_id: str, set_name: str) -> None:
        """Do nothing: its edits have neither type nor set."""
