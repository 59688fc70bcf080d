"""Heights above the ellipsoid and above sea level, which differ by up to 107 m."""

from __future__ import annotations

from math import isfinite

# Heights above EGM2008 and EGM96 in WGS 84.
_GEOIDS = ("EPSG:9518", "EPSG:9707")


def geoid_height_m(longitude_deg: float, latitude_deg: float) -> float | None:
    """Return the height of the geoid (EGM2008 or else EGM96) above the WGS 84 ellipsoid.

    Parameters
    ----------
    longitude_deg, latitude_deg : float

    Returns
    -------
    float or None
        Height in metres; None if no grid is installed. pyproj does not include any grid, and none
        is downloaded.
    """
    import warnings

    from pyproj.transformer import TransformerGroup

    for code in _GEOIDS:
        with warnings.catch_warnings():
            # A warning about missing grids is expected.
            warnings.simplefilter("ignore")
            group = TransformerGroup("EPSG:4979", code, always_xy=True)
        if not group.best_available:
            continue
        height = group.transformers[0].transform(longitude_deg, latitude_deg, 0.0)[2]
        if isfinite(height):
            return -float(height)
    return None
