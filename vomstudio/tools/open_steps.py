"""The steps of an unfinished feature, and what of it was discarded and can come back."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, eq=False)
class Discarded:
    """What a tool has let go unfinished.

    tool : the name of the tool; label : in words, like the label of an edit
    bring_back : open it again as it was; False, with the reason shown, where that cannot be
    untouched : whether it is open now, as it was when it was brought back
    """

    tool: str
    label: str
    bring_back: Callable[[], bool]
    untouched: Callable[[], bool]


def step_label(before: Sequence[Any], after: Sequence[Any]) -> str:
    """The step from one state of the vertices to the next, like the label of an edit."""
    if len(after) > len(before):
        return f"Add point {len(after)}"
    return "Delete a point" if len(after) < len(before) else "Move a point"
