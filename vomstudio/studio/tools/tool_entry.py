"""How a tool is offered: the texts of its button, menu and panel, as plain data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from vomstudio.core.words import tr


@dataclass(frozen=True)
class ToolEntry:
    """tool : its class, made with a `ToolContext` alone; label, tip : noted for translation, label
    with "&" before its mnemonic; icon : of Material Design Icons; key : shortcut in the viewport;
    order : of its button among those of the other tools; takes_keys : it has a use for Shift with
    the left button, which else pans, and for the wheel with Ctrl or Shift;
    in_bar : its button stands in the tool bar too
    """

    tool: type[Any]
    label: str
    icon: str
    key: str
    tip: str
    order: int
    takes_keys: bool = False
    in_bar: bool = True

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
    """What tools share whose steps are edits of the document, which takes them back itself."""

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


class NothingOpen(NoSteps):
    """What tools share that change something at a click: no steps, no end and no draft."""

    def finish(self) -> str | None:
        return None

    def cancel(self) -> None:
        """There is nothing unfinished."""

    def restore(self, state: Mapping[str, Any]) -> bool:
        return False

    def set_type(self, type_id: str, set_name: str) -> None:
        """What it changes has neither."""
