"""Shapes in tables as well-known text (OGC 06-103r4, 7)."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import accumulate
from typing import Any

_MAX_DEPTH = 16
"""Maximum nesting depth of brackets; a multipolygon in a collection has five levels."""
_BRACKET = re.compile(r"[()]")


def parse_wkt(texts: Sequence[str | None]) -> list[Any]:
    """Parse the geometry of each text, with None for a missing text.

    Raises
    ------
    shapely.errors.GEOSException
        If a text is not WKT or is nested too deeply: GEOS parses recursively, and a few thousand
        brackets exhaust the stack of the process.
    """
    import shapely

    for text in texts:
        if text is not None and text.count("(") > _MAX_DEPTH and _depth(text) > _MAX_DEPTH:
            raise shapely.errors.GEOSException("it is nested too deeply")
    return list(shapely.from_wkt(list(texts)))


def _depth(text: str) -> int:
    steps = (1 if bracket == "(" else -1 for bracket in _BRACKET.findall(text))
    return max(accumulate(steps), default=0)
