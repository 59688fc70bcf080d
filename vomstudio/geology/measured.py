"""A length or an angle with half of its 95 % interval."""

from __future__ import annotations

import math
from dataclasses import dataclass

CONE95 = math.sqrt(-2.0 * math.log(0.05))
"""Half-angle of the cone that holds 95 % of a direction, in standard deviations along one axis."""


@dataclass(frozen=True)
class Measured:
    """Value with half of its 95 % interval, which is None if its errors are unknown."""

    value: float
    error95: float | None
