"""Polygons whose outline crosses itself, taken apart."""

from __future__ import annotations

from typing import Any

import numpy as np

from vomstudio.core.findings import Finding

_SAME = 1e-9


def taken_apart(polygons: Any) -> tuple[Any, list[Finding]]:
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
        Finding(
            "area.self-crossing",
            count=int(off.sum()),
            area_m2=float(after[off].sum()),
            signed_area_m2=float(before[off].sum()),
        )
    ]
