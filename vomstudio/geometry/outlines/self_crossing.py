"""Polygons with self-crossing outlines."""

from __future__ import annotations

from typing import Any

import numpy as np

from vomstudio.core.findings import Finding

MAX_RELATIVE_CHANGE = 1e-9


def resolve_crossings(polygons: Any) -> tuple[Any, list[Finding]]:
    """Resolve the self-crossings of shapely polygons (n,), or of one.

    Changed areas are reported.

    Returns
    -------
    area : shapely geometry
        Union without crossings.
    findings : list of Finding
    """
    import shapely

    polygons_array = np.atleast_1d(np.asarray(polygons, object))
    valid_polygons = shapely.make_valid(polygons_array)
    signed_areas, areas = shapely.area(polygons_array), shapely.area(valid_polygons)
    has_changed = ~shapely.is_valid(polygons_array) & (
        np.abs(areas - signed_areas) > MAX_RELATIVE_CHANGE * np.maximum(signed_areas, areas)
    )
    if not has_changed.any():
        return shapely.union_all(valid_polygons), []
    return shapely.union_all(valid_polygons), [
        Finding(
            "area.self-crossing",
            count=int(has_changed.sum()),
            area_m2=float(areas[has_changed].sum()),
            signed_area_m2=float(signed_areas[has_changed].sum()),
        )
    ]
