"""How a tool is offered: the texts of its button, menu and panel, as plain data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from vomstudio.words import tr


@dataclass(frozen=True)
class ToolEntry:
    """tool : its class, made with a `ToolContext` alone; label, tip : noted for translation, label
    with "&" before its mnemonic; icon : of Material Design Icons; key : shortcut in the viewport;
    order : of its button among those of the other tools
    """

    tool: type[Any]
    label: str
    icon: str
    key: str
    tip: str
    order: int

    @property
    def name(self) -> str:
        """Name of the tool, as in drafts."""
        name: str = self.tool.name
        return name

    @property
    def title(self) -> str:
        """Title of its panel, translated."""
        return tr(self.label).replace("&", "")
