"""Shapes that stand in tables as well-known text (OGC 06-103r4, 7)."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import accumulate
from typing import Any

_DEEPEST = 16
"""Brackets inside each other; a multipolygon in a collection has five."""
_BRACKET = re.compile(r"[()]")


def shapes_of(texts: Sequence[str | None]) -> list[Any]:
    """shapely's geometry of each text, None where there is none. Raises shapely's GEOSException for
    what is no geometry, or is nested without end: GEOS goes down with every bracket, and from some
    thousands on the process ends with its stack."""
    import shapely

    for text in texts:
        if text is not None and text.count("(") > _DEEPEST and _depth(text) > _DEEPEST:
            raise shapely.errors.GEOSException("it is nested without end")
    return list(shapely.from_wkt(list(texts)))


def _depth(text: str) -> int:
    steps = (1 if bracket == "(" else -1 for bracket in _BRACKET.findall(text))
    return max(accumulate(steps), default=0)
