"""Error of a model's rotation (95 %), and its effect on planes measured on the model."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding

MAX_TURN95_DEG = 15.0
"""Above this 95 % error a plane is poor; so are those that a model may turn by more."""
_Z95 = 1.959963984540054


def worst_turn95_deg(rotation: FloatArray | None) -> float | None:
    """Return the 95 % error about the weakest axis.

    Parameters
    ----------
    rotation : (3, 3) ndarray or None
        Covariance of turns, radians squared.

    Returns
    -------
    float or None
        Degrees; None if it is not known.
    """
    if rotation is None:
        return None
    return float(_Z95 * np.degrees(np.sqrt(max(np.linalg.eigvalsh(rotation)[-1], 0.0))))


def turn_findings(rotation: FloatArray | None) -> tuple[Finding, ...]:
    """Return the finding on a registration that makes planes on the model poor.

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
