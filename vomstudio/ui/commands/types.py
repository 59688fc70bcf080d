"""Commands that choose the type of the next feature with the keys 1 to 9.

They act while a tool is active.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.ui.base.actions import Command
from vomstudio.ui.widgets.type_box import TypeBox

MAX_KEYS = 9


def commands(find_type_box: Callable[[], TypeBox | None]) -> list[Command]:
    """Return one command for each of the first nine types.

    Parameters
    ----------
    find_type_box : callable
        Returns the type box of the active tool, or None if the tool has none.
    """

    def choose(row: int) -> None:
        if (box := find_type_box()) is not None:
            box.choose(row)

    def disabled_reason(row: int) -> Finding | None:
        box = find_type_box()
        if box is None:
            return Finding("action.no-types")
        return None if row < box.count() else Finding("action.no-such-type", number=row + 1)

    def name(row: int) -> str:
        box = find_type_box()
        if box is None or row >= box.count():
            return tr("Type {number}", number=row + 1)
        return tr("Type {number}: {name}", number=row + 1, name=box.itemText(row))

    return [
        Command(
            f"type_{row + 1}",
            tr("Type {number}", number=row + 1),
            partial(choose, row),
            shortcut=str(row + 1),
            tip=tr("Choose the type of the next feature."),
            disabled_reason=partial(disabled_reason, row),
            is_viewport_key=True,
            current_text=partial(name, row),
        )
        for row in range(MAX_KEYS)
    ]
