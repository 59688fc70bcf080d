"""What photos themselves say of where and how they were taken."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt

from vomstudio.errors import UsageError
from vomstudio.io.control.observation_tables import Positions
from vomstudio.io.photos.reading import read_photo
from vomstudio.words import tr

Array = npt.NDArray[np.float64]


def positions_in(photos: Mapping[str, Path]) -> Positions:
    """GPS positions of photos, by the names of their cameras: longitude, latitude and height, each
    with what it is above. Receivers state a radius for the horizontal; it is left to the residuals
    whether that is true. Raises UsageError where no photo has one."""
    names, places, heights = list[str](), list[tuple[float, float, float]](), list[str]()
    for name, path in photos.items():
        photo = read_photo(path)
        if photo.longitude_deg is None or photo.latitude_deg is None:
            continue
        names.append(name)
        height = float("nan") if photo.altitude_m is None else photo.altitude_m
        places.append((photo.longitude_deg, photo.latitude_deg, height))
        heights.append(photo.altitude_reference or "")
    if not names:
        raise UsageError(
            tr("The photos have no GPS positions. Give a table of camera positions."),
            field="--cameras",
        )
    nowhere = np.full((len(names), 3), np.nan)
    return Positions(tuple(names), np.array(places), True, nowhere, heights=tuple(heights))
