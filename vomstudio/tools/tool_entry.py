"""How a tool is offered: what its button, menu and panel say, as plain data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class ToolEntry:
    """tool : its class, made with a `ToolContext` alone; label : with "&" before the letter that
    opens it in a menu; icon : of Material Design Icons; key : that takes it up over the outcrop;
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
        name: str = self.tool.name
        return name

    @property
    def title(self) -> str:
        """Of its panel."""
        return self.label.replace("&", "")
