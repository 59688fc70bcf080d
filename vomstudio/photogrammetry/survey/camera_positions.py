"""Camera positions of a survey: conversion to metres, accuracy, and registration."""

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
_SEMI_MAJOR_AXIS_M, _ECCENTRICITY_SQUARED = 6378137.0, 0.00669437999014
# 95 % quantile of a normally distributed error (two-sided).
_Z95 = 1.959964
HANDHELD_ACCURACY_M = 5.0
"""Default horizontal standard deviation of the receiver of a phone or camera (textbook 3.1.2 and
3.1.5: "a few metres")."""
DRONE_ACCURACY_M = 3.0


def metres_from_gps(photos: Sequence[Photo]) -> FloatArray:
    """Return east, north, up (n, 3) in metres from the mean position; NaN if no GPS.

    The height is 0 if unknown. The result is accurate to a thousandth over a few kilometres, which
    is sufficient for checks but not for registration.
    """
    coordinates = np.full((len(photos), 3), np.nan)
    for i, photo in enumerate(photos):
        if photo.latitude_deg is not None and photo.longitude_deg is not None:
            coordinates[i] = photo.longitude_deg, photo.latitude_deg, photo.altitude_m or 0.0
    is_known = np.isfinite(coordinates[:, 0])
    if not is_known.any():
        return coordinates
    centre = coordinates[is_known].mean(axis=0)
    phi = math.radians(centre[1])
    w = math.sqrt(1.0 - _ECCENTRICITY_SQUARED * math.sin(phi) ** 2)
    east = math.radians(1.0) * _SEMI_MAJOR_AXIS_M / w * math.cos(phi)
    north = math.radians(1.0) * _SEMI_MAJOR_AXIS_M * (1.0 - _ECCENTRICITY_SQUARED) / w**3
    return np.asarray((coordinates - centre) * [east, north, 1.0])


def median_accuracy(photos: Sequence[Photo]) -> tuple[float, bool]:
    """Return the median standard deviation of the positions (m), and whether it is stated."""
    stated_accuracies = [p.gps_accuracy_m for p in photos if p.gps_accuracy_m is not None]
    if stated_accuracies:
        return float(np.median(stated_accuracies)), True
    is_drone = any(p.pitch_deg is not None or p.relative_altitude_m is not None for p in photos)
    return (DRONE_ACCURACY_M if is_drone else HANDHELD_ACCURACY_M), False


def rotation_error95_deg(positions: FloatArray, sigma_m: float) -> tuple[float, FloatArray]:
    """Return the 95 % rotation error of a registration by positions.

    Returns the error and its weakest axis (3,). The error is 180 if it is undetermined because all
    positions are collinear or coincide.

    positions : (n, 3)
    sigma_m : independent error of each coordinate
    """
    values, axes = np.linalg.eigh(rotation_covariance(positions, sigma_m))
    error_deg = math.degrees(_Z95 * math.sqrt(values[-1]))
    return (180.0 if len(positions) < 3 else min(180.0, error_deg)), axes[:, -1]


def width_to_length_ratio(positions: FloatArray) -> float:
    """Return the ratio of the width of positions to their length (standard deviations).

    It is 0 if the positions are collinear.
    """
    centred_positions = positions - positions.mean(axis=0)
    singular_values = np.linalg.svd(centred_positions, compute_uv=False)
    return (
        float(singular_values[1] / singular_values[0])
        if len(singular_values) > 1 and singular_values[0] > 0
        else 0.0
    )
