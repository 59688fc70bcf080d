"""Camera positions of a survey: in metres, their accuracy, and how well they register a model."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.registration.similarity import rotation_covariance

if TYPE_CHECKING:
    from vomstudio.io.photos.photo import Photo


# WGS 84.
_A, _E2 = 6378137.0, 0.00669437999014
# 95 % of one normal error.
_Z95 = 1.959964
HANDHELD_ACCURACY_M = 5.0
"""Horizontal standard deviation of a telephone's or camera's receiver where the file states none
(textbook 3.1.2 and 3.1.5: "a few metres")."""
DRONE_ACCURACY_M = 3.0


def metres_from_gps(photos: Sequence[Photo]) -> FloatArray:
    """(n, 3) east, north, up in metres from their mean, NaN without GPS; height 0 where none is
    known. Good to a part in a thousand over some kilometres: for checks, not for registration."""
    found = np.full((len(photos), 3), np.nan)
    for i, photo in enumerate(photos):
        if photo.latitude_deg is not None and photo.longitude_deg is not None:
            found[i] = photo.longitude_deg, photo.latitude_deg, photo.altitude_m or 0.0
    known = np.isfinite(found[:, 0])
    if not known.any():
        return found
    middle = found[known].mean(axis=0)
    phi = math.radians(middle[1])
    w = math.sqrt(1.0 - _E2 * math.sin(phi) ** 2)
    east = math.radians(1.0) * _A / w * math.cos(phi)
    north = math.radians(1.0) * _A * (1.0 - _E2) / w**3
    return np.asarray((found - middle) * [east, north, 1.0])


def accuracy_of(photos: Sequence[Photo]) -> tuple[float, bool]:
    """Median standard deviation of the positions in metres, and whether the files state it."""
    stated = [p.gps_accuracy_m for p in photos if p.gps_accuracy_m is not None]
    if stated:
        return float(np.median(stated)), True
    drone = any(p.pitch_deg is not None or p.relative_altitude_m is not None for p in photos)
    return (DRONE_ACCURACY_M if drone else HANDHELD_ACCURACY_M), False


def rotation_error95_deg(positions: FloatArray, sigma_m: float) -> tuple[float, FloatArray]:
    """95 % error of the orientation of a model registered by positions (n, 3) of independent error
    sigma, about the axis that they determine worst, and that axis (3,).

    180 where it is undetermined: all positions in one line, or at one place.
    """
    values, axes = np.linalg.eigh(rotation_covariance(positions, sigma_m))
    worst = math.degrees(_Z95 * math.sqrt(values[-1]))
    return (180.0 if len(positions) < 3 else min(180.0, worst)), axes[:, -1]


def straightness(positions: FloatArray) -> float:
    """Width of the positions across their longest direction, over their length (standard
    deviations): 0 in one line."""
    centred = positions - positions.mean(axis=0)
    s = np.linalg.svd(centred, compute_uv=False)
    return float(s[1] / s[0]) if len(s) > 1 and s[0] > 0 else 0.0
