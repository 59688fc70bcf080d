"""Heights above the ellipsoid and above the sea, which differ by up to 107 m."""

from __future__ import annotations

from math import isfinite

# Heights above EGM2008 and EGM96 on WGS 84.
_GEOIDS = ("EPSG:9518", "EPSG:9707")


def geoid_height_m(longitude_deg: float, latitude_deg: float) -> float | None:
    """By how much the sea (EGM2008, else EGM96) lies above the ellipsoid of WGS 84 at a place; None
    where the grid of neither is installed. pyproj brings none, and none is fetched here."""
    import warnings

    from pyproj.transformer import TransformerGroup

    for code in _GEOIDS:
        with warnings.catch_warnings():
            # Says that grids are missing, which is what is asked.
            warnings.simplefilter("ignore")
            found = TransformerGroup("EPSG:4979", code, always_xy=True)
        if not found.best_available:
            continue
        height = found.transformers[0].transform(longitude_deg, latitude_deg, 0.0)[2]
        if isfinite(height):
            return -float(height)
    return None
