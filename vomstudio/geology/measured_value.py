"""Measured length or angle with the half-width of its 95 % interval."""

from __future__ import annotations

import math
from dataclasses import dataclass

CONE95 = math.sqrt(-2.0 * math.log(0.05))
"""Half-angle of the cone that contains 95 % of the directions, in standard deviations per axis."""


@dataclass(frozen=True)
class MeasuredValue:
    """Measured value with the half-width of its 95 % interval; None if the error is unknown."""

    value: float
    error95: float | None
