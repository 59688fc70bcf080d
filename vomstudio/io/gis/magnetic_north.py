"""Magnetic declination: by how much magnetic north lies east of true north.

From the International Geomagnetic Reference Field, 14th generation (IAGA, doi
10.5281/zenodo.14012302), by IAGA's own `ppigrf`. Rocks and steel nearby are not in it, the field of
the crust makes it wrong by some tenths of a degree.
"""

from __future__ import annotations

from datetime import date, datetime, time

import numpy as np

from vomstudio.core.findings import Finding
from vomstudio.errors import InputError

FIRST_YEAR, LAST_YEAR = 1900, 2029
"""The years of the model."""
_HIGHEST_LATITUDE = 89.9
# Where less is horizontal, a compass does not point anywhere (WMM2025 report, "blackout zone").
_LEAST_NT = 2000.0


def declination_deg(
    longitude_deg: float, latitude_deg: float, when: date, height_m: float = 0.0
) -> float:
    """Degrees, east positive, at a place (WGS 84) and on a day.

    Raises InputError for a day outside 1900 to 2029, and so near to a magnetic pole that a compass
    does not point north.
    """
    from ppigrf import igrf

    if not FIRST_YEAR <= when.year <= LAST_YEAR:
        raise InputError(
            Finding("north.unknown-year", first=FIRST_YEAR, last=LAST_YEAR, year=when.year)
        )
    latitude = float(np.clip(latitude_deg, -_HIGHEST_LATITUDE, _HIGHEST_LATITUDE))
    noon = datetime.combine(when, time(12))
    east, north, _ = igrf(longitude_deg, latitude, height_m / 1000.0, noon)
    x, y = float(np.ravel(north)[0]), float(np.ravel(east)[0])
    if np.hypot(x, y) < _LEAST_NT:
        raise InputError(Finding("north.near-pole"))
    return float(np.degrees(np.arctan2(y, x)))
