"""Forecast of the registration errors of a planned survey, in degrees.

The planned positions of the cameras, or of the control points, are adjusted as in the registration
(`registration.placing`), with the stated accuracy and without residuals: the covariance is that of
the real registration. Positions are in the frame of the outcrop with up as the third axis: along
it, into the rock (for flat ground: to the far side), up.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding, cause_finding


@dataclass(frozen=True)
class Forecast:
    """Expected errors of a registration; None for an undetermined angle.

    Parameters
    ----------
    by : {"receiver", "control"}
        Whether the positions are those of the cameras or of control points.
    points : int
        Number of positions.
    sigma_m : (float, float)
        Standard deviation of a horizontal coordinate and of a height.
    about_up_95_deg, about_along_95_deg, about_view_95_deg : float or None
        95 % errors of the rotation about the vertical, about the outcrop from left to right, and
        about the horizontal direction across it.
    worst_95_deg : float or None
        95 % error about the least certain axis.
    scale_error_95 : float or None
        Relative 95 % error of the scale.
    why_not : Finding or None
        Reason why the positions cannot place a model.
    """

    by: str
    points: int
    sigma_m: tuple[float, float]
    about_up_95_deg: float | None = None
    about_along_95_deg: float | None = None
    about_view_95_deg: float | None = None
    worst_95_deg: float | None = None
    scale_error_95: float | None = None
    why_not: Finding | None = None


def forecast(by: str, positions: FloatArray, sigma: tuple[float, float]) -> Forecast:
    """Forecast the registration by points.

    Parameters
    ----------
    by : {"receiver", "control"}
    positions : (n, 3) array
        East, north, up (here along the outcrop, into it, up).
    sigma : (float, float)
        Errors of a horizontal coordinate and of a height, one sigma, metres.
    """
    from vomstudio.registration.placing import register_points

    n = len(positions)
    try:
        registration = register_points(
            positions, positions, np.full((n, 3), [sigma[0], sigma[0], sigma[1]])
        )
    except GeometryError as error:
        return Forecast(by, n, sigma, why_not=cause_finding(error))
    error95 = registration.rotation_error_95_deg
    return Forecast(
        by,
        n,
        sigma,
        _known_angle(error95.about_up),
        _known_angle(error95.about_east),
        _known_angle(error95.about_north),
        _known_angle(error95.weakest.error_deg),
        registration.scale_error_95,
    )


def _known_angle(error_deg: float | None) -> float | None:
    """Return an angle, or None if it exceeds 90 degrees."""
    return error_deg if error_deg is not None and error_deg < 90.0 else None
