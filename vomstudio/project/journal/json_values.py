"""The JSON in the rows of a journal."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any


def dump_json(value: Mapping[str, Any] | None) -> str | None:
    return None if value is None else json.dumps(value, allow_nan=False, separators=(",", ":"))


class _Damaged(dict[str, Any]):
    """Stands for JSON that cannot be read: the replay names the row and goes on."""


def _no_number(word: str) -> float:
    # Never written, since they are no JSON.
    raise ValueError(word)


def load_json(text: str | None) -> Any:
    """What `dump_json` was given; of what cannot be read, a record that no replay takes."""
    if text is None:
        return None
    try:
        return json.loads(text, parse_constant=_no_number)
    except (ValueError, TypeError, RecursionError):
        return _Damaged({"?": {"record": "damaged"}})
