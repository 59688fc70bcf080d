"""JSON values in the rows of a journal."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any


def dump_json(value: Mapping[str, Any] | None) -> str | None:
    """Encode a value as compact JSON, or return None for None."""
    return None if value is None else json.dumps(value, allow_nan=False, separators=(",", ":"))


class _DamagedValues(dict[str, Any]):
    """Placeholder for unreadable JSON: the replay reports the row and continues."""


def _refuse_constant(word: str) -> float:
    # NaN and infinities are not valid JSON and are never written.
    raise ValueError(word)


def load_json(text: str | None) -> Any:
    """Return the value that was passed to `dump_json`.

    Unreadable text is returned as a record that no replay accepts.
    """
    if text is None:
        return None
    try:
        return json.loads(text, parse_constant=_refuse_constant)
    except (ValueError, TypeError, RecursionError):
        return _DamagedValues({"?": {"record": "damaged"}})
