"""Polygons whose outline crosses itself, taken apart."""

from __future__ import annotations

from typing import Any

import numpy as np

from vomstudio.words import tr_n

_SAME = 1e-9


def taken_apart(polygons: Any) -> tuple[Any, list[str]]:
    """The area of shapely polygons (n,), or of one, without crossings, and a sentence where there
    were any: what such an outline encloses is not what its corners say."""
    import shapely

    given = np.atleast_1d(np.asarray(polygons, object))
    whole = shapely.make_valid(given)
    before, after = shapely.area(given), shapely.area(whole)
    off = ~shapely.is_valid(given) & (np.abs(after - before) > _SAME * np.maximum(before, after))
    if not off.any():
        return shapely.union_all(whole), []
    return shapely.union_all(whole), [
        tr_n(
            "The outline of the area crosses itself. Its parts were counted as {after:.6g} m²; by "
            "the order of its corners, in which parts cancel, it would be {before:.6g} m². Correct "
            "the outline.",
            "The outlines of {count} areas cross themselves. Their parts were counted as "
            "{after:.6g} m²; by the order of the corners, in which parts cancel, they would be "
            "{before:.6g} m². Correct the outlines.",
            int(off.sum()),
            after=float(after[off].sum()),
            before=float(before[off].sum()),
        )
    ]
