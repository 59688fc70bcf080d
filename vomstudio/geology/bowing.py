"""Whether a model is bowed like a dome, by the residuals of points or cameras across it.

A block of photos with a wrong lens bends: its middle stands out of, or lies behind, its edges, by
c r^2 at a distance r from the middle (James & Robson 2014, Earth Surface Processes and Landforms
39, 1413-1420). Dips then change by 2 c r from the middle outwards, which looks like an open fold.

The residuals along the model's normal are regressed on 1, u, v and u^2 + v^2, u and v being places
in its mean plane. The first three are what a registration absorbs (shift and tilt), so that points
that placed the model and points that only judge it can be taken together: both differ from the
truth by the same shift and tilt. Whether c differs from nothing is told by Student's t.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

FEWEST = 6
"""Points: four unknowns, and two to judge them by."""

LEVEL = 0.05
_THIN = 0.05


@dataclass(frozen=True)
class Bowing:
    """n : points; curvature_per_m : c, along the normal that points up: negative of a dome,
    positive of a dish; error95_per_m : of that; reach_m : from the middle to the edge of the model;
    significant : c differs from nothing, wrongly so said of one model in twenty that is not bowed
    """

    n: int
    curvature_per_m: float
    error95_per_m: float
    reach_m: float
    significant: bool

    @property
    def side_deg(self) -> float:
        """By how much dips at the edge differ from those in the middle."""
        return float(np.degrees(2.0 * abs(self.curvature_per_m) * self.reach_m))

    @property
    def side_error95_deg(self) -> float:
        return float(np.degrees(2.0 * self.error95_per_m * self.reach_m))

    @property
    def across_deg(self) -> float:
        """By how much dips at one edge differ from those at the opposite one."""
        return 2.0 * self.side_deg

    @property
    def rise_m(self) -> float:
        """How far the edge is off the plane that touches the middle."""
        return abs(self.curvature_per_m) * self.reach_m**2


def bowing_of(
    places: Array, residuals: Array, sigma: Array | None = None, extent: Array | None = None
) -> Bowing | None:
    """The bowing that residuals show; None where too few points, or points on a line, or all at one
    distance from the middle, tell nothing of it.

    places, residuals : (n, 3), World, fitted less given
    sigma : (n, 3) stated errors of the coordinates, by which they are weighted; None for none
    extent : (m, 3) points all over the model, whose mean plane, middle and edge count; None to take
        those of the places
    """
    from scipy.special import stdtrit

    n = len(places)
    if n < FEWEST:
        return None
    shape = places if extent is None or len(extent) < FEWEST else extent
    middle = shape.mean(axis=0)
    _, _, axes = np.linalg.svd(shape - middle, full_matrices=False)
    flat = (places - middle) @ axes[:2].T
    normal = axes[2] if axes[2, 2] >= 0.0 else -axes[2]
    size = float(np.sqrt((flat**2).sum(axis=1).mean()))
    if not size > 0.0 or np.linalg.svd(flat - flat.mean(axis=0), compute_uv=False)[-1] < (
        _THIN * size * np.sqrt(n)
    ):
        return None
    u, v = (flat / size).T
    columns = np.stack([np.ones(n), u, v, u**2 + v**2], axis=1)
    weight = np.ones(n)
    if sigma is not None and np.isfinite(sigma).all() and (sigma > 0).all():
        weight = 1.0 / np.sqrt((sigma**2) @ normal**2)
        weight = weight / weight.mean()
    rows = columns * weight[:, None]
    # How much of the last column the others leave: all at one distance say nothing.
    rest = rows[:, 3] - rows[:, :3] @ np.linalg.lstsq(rows[:, :3], rows[:, 3], rcond=None)[0]
    if float(rest @ rest) < _THIN**2 * float(rows[:, 3] @ rows[:, 3]):
        return None
    out = (residuals @ normal) * weight
    found = np.linalg.lstsq(rows, out, rcond=None)[0]
    left = out - rows @ found
    free = n - 4
    variance = float(left @ left) / free / float(rest @ rest)
    error = float(stdtrit(free, 1.0 - LEVEL / 2.0)) * float(np.sqrt(variance))
    # Fitted less given is the model's bend itself.
    curvature = float(found[3]) / size**2
    reach = float(np.linalg.norm((shape - middle) @ axes[:2].T, axis=1).max())
    return Bowing(n, curvature, error / size**2, reach, abs(found[3]) > error)
