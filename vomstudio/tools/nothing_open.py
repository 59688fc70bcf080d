"""What the tools share that change something at a click and leave nothing unfinished."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


class NothingOpen:
    """Has no steps, no end and no draft of its own."""

    def undo(self) -> bool:
        return False

    def finish(self) -> str | None:
        return None

    def cancel(self) -> None:
        """There is nothing unfinished."""

    def restore(self, state: Mapping[str, Any]) -> bool:
        return False

    def set_type(self, type_id: str, set_name: str) -> None:
        """What it changes has neither."""
