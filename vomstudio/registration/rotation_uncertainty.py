"""95 % error of a model's rotation, and its effect on planes measured on the model."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding

MAX_TURN95_DEG = 15.0
"""95 % error of a plane, or of the rotation of its model, above which the plane is poor."""
_Z95 = 1.959963984540054


def worst_turn95_deg(rotation: FloatArray | None) -> float | None:
    """Return the 95 % error about the weakest axis.

    Parameters
    ----------
    rotation : (3, 3) ndarray or None
        Covariance of the rotation, rad².

    Returns
    -------
    float or None
        Error in degrees, or None if unknown.
    """
    if rotation is None:
        return None
    return float(_Z95 * np.degrees(np.sqrt(max(np.linalg.eigvalsh(rotation)[-1], 0.0))))


def turn_findings(rotation: FloatArray | None) -> tuple[Finding, ...]:
    """Report a rotation error so large that planes on the model are poor.

    Parameters
    ----------
    rotation : ndarray or None
        See `worst_turn95_deg`.

    Returns
    -------
    tuple of Finding
    """
    worst_deg = worst_turn95_deg(rotation)
    if worst_deg is None or worst_deg <= MAX_TURN95_DEG:
        return ()
    return (Finding("registration.poor", rotation95_deg=worst_deg),)
