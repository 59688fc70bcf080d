"""Presentation of a tool as plain data: texts of its button, menu and panel."""

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
        Class of the tool, which is created with a `ToolContext` as its only argument.
    label, tip : str
        Texts that are marked for translation; the label contains "&" before its mnemonic.
    icon : str
        Name of a Material Design icon.
    key : str
        Shortcut in the viewport.
    order : int
        Position of the button among those of the tools.
    uses_modifiers : bool
        Whether the tool uses Shift with the left button, which otherwise pans, and the wheel
        with Ctrl or Shift.
    """

    tool: type[Any]
    label: str
    icon: str
    key: str
    tip: str
    order: int
    uses_modifiers: bool = False

    @property
    def name(self) -> str:
        """Name of the tool, as used in drafts."""
        name: str = self.tool.name
        return name

    @property
    def title(self) -> str:
        """Translated title of the panel."""
        return tr(self.label).replace("&", "")


class NoSteps:
    """Base class of tools whose steps are edits, which are undone in the document."""

    @property
    def is_finishing(self) -> bool:
        return False

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
    """Base class of tools that act on single clicks, without steps or drafts."""

    def finish(self) -> str | None:
        return None

    def cancel(self) -> None:
        """Do nothing, because there is never an unfinished feature."""

    def restore(self, state: Mapping[str, Any]) -> bool:
        return False

    def set_type(self, type_id: str, set_name: str) -> None:
        """Do nothing, because the edits of the tool have neither type nor set."""
