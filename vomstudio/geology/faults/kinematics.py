"""What faults with known slip say together: P and T axes, kinematic axes, right dihedra.

A fault is given by the upward unit normal n of its plane and the unit vector s along which its
hanging wall moves. It shortens rock most along its P axis, (n - s) / sqrt 2, and extends it most
along its T axis, (n + s) / sqrt 2, both at 45 degrees to the plane in the plane of movement
(Marrett & Allmendinger 1990, Journal of Structural Geology 12, 973-986). Both are axial.

- Kinematic axes: eigenvectors of the mean of T T' - P P' = n s' + s n', the linked Bingham
  statistic of the same authors: each fault weighs the same.
- Right dihedra (Angelier & Mechler 1977, Bulletin de la Societe geologique de France 19,
  1309-1318): planes through n and s divide the sphere into two dihedra in which the greatest
  compression may lie and two for the greatest extension; where all those of one kind overlap, one
  stress can have moved all faults.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.geology.orientation import planes_to_normals, sin_cos_deg
from vomstudio.geology.statistics import orientation_tensor
from vomstudio.geology.stereonet import unproject

SEED = 1
RESAMPLES = 400
FEWEST_FOR_CONFIDENCE = 5
_SIDE = 121
"""Of the grid of directions on the net: they lie 1.3 degrees apart."""
_AT_A_TIME = 500
_BETWEEN = 1e-12


def movements(
    dip_direction_deg: npt.ArrayLike, dip_deg: npt.ArrayLike, slip_rake_deg: npt.ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Upward normals and movements of the hanging wall (n, 3), World, of n faults; rakes as
    `slip_from_rake` counts them."""
    azimuth, dip, rake = (
        np.atleast_1d(np.asarray(given, np.float64))
        for given in (dip_direction_deg, dip_deg, slip_rake_deg)
    )
    strike_deg = np.where(dip >= 90.0, np.mod(azimuth - 90.0, 180.0), azimuth - 90.0)
    sin_s, cos_s = sin_cos_deg(strike_deg)
    sin_d, cos_d = sin_cos_deg(dip)
    strike = np.stack([sin_s, cos_s, np.zeros_like(sin_s)], axis=-1)
    down = np.stack([cos_s * cos_d, -sin_s * cos_d, -sin_d], axis=-1)
    sin_r, cos_r = (part[:, None] for part in sin_cos_deg(rake))
    # On a vertical plane the hanging wall is the side that its strike in [0, 180) dips to.
    normals = planes_to_normals(strike_deg + 90.0, dip)
    return normals, cos_r * strike - sin_r * down


def p_axes(normals: FloatArray, slips: FloatArray) -> FloatArray:
    """(n, 3) unit vectors of greatest shortening."""
    return np.asarray((normals - slips) / np.sqrt(2.0))


def t_axes(normals: FloatArray, slips: FloatArray) -> FloatArray:
    """(n, 3) unit vectors of greatest extension."""
    return np.asarray((normals + slips) / np.sqrt(2.0))


@dataclass(frozen=True, eq=False)
class KinematicAxes:
    """values : (3,) of the tensor, extension first, with sum 0: +1, 0, -1 where all faults are of
    one mechanism. axes : (3, 3) rows, unit vectors of extension, the intermediate axis, and
    shortening. confidence95_deg : (3,) cones that hold 95 % of resamples; None of few faults"""

    values: FloatArray
    axes: FloatArray
    confidence95_deg: FloatArray | None


def kinematic_axes(normals: FloatArray, slips: FloatArray) -> KinematicAxes:
    """Of all faults together, with errors by resampling them (bootstrap, fixed seed)."""
    each = np.einsum("ni,nj->nij", normals, slips)
    each = each + np.swapaxes(each, 1, 2)
    values, axes = _principal(each.mean(axis=0))
    n = len(each)
    if n < FEWEST_FOR_CONFIDENCE:
        return KinematicAxes(values, axes, None)
    generator = np.random.default_rng(SEED)
    flat = each.reshape(n, 9)
    # How often each fault is drawn tells the mean as well, in one product.
    counts = generator.multinomial(n, np.full(n, 1.0 / n), size=RESAMPLES)
    means = (counts @ flat / n).reshape(-1, 3, 3)
    found = np.swapaxes(np.linalg.eigh(means)[1], 1, 2)[:, ::-1]
    cosine = np.abs(np.einsum("kij,ij->ki", found, axes))
    sine = np.linalg.norm(np.cross(found, axes[None]), axis=-1)
    angles = np.degrees(np.arctan2(sine, cosine))
    return KinematicAxes(values, axes, np.percentile(angles, 95.0, axis=0))


def _principal(tensor: FloatArray) -> tuple[FloatArray, FloatArray]:
    values, vectors = np.linalg.eigh(tensor)
    return values[::-1], vectors.T[::-1]


@dataclass(frozen=True, eq=False)
class RightDihedra:
    """directions : (m, 3) of the lower hemisphere, evenly spaced on an equal-area net. share : (m,)
    of the faults in whose dihedra of compression each lies; the rest extends there"""

    directions: FloatArray
    share: FloatArray

    def most_compressed(self) -> tuple[FloatArray, float]:
        """The middle of where most faults are compressed (3,), and that share."""
        return self._middle(self.share)

    def most_extended(self) -> tuple[FloatArray, float]:
        """The middle of where most faults are extended (3,), and that share."""
        return self._middle(1.0 - self.share)

    def _middle(self, share: FloatArray) -> tuple[FloatArray, float]:
        most = float(share.max())
        chosen = self.directions[share >= most - 1e-9]
        return orientation_tensor(chosen)[1][0], most


def right_dihedra(normals: FloatArray, slips: FloatArray) -> RightDihedra:
    """Over the net."""
    side = np.linspace(-1.0, 1.0, _SIDE)
    x, y = np.meshgrid(side, side)
    directions = unproject(np.stack([x.ravel(), y.ravel()], axis=-1))
    directions = directions[np.isfinite(directions).all(axis=1)]
    return RightDihedra(directions, compressed_share(directions, normals, slips))


def compressed_share(directions: FloatArray, normals: FloatArray, slips: FloatArray) -> FloatArray:
    """(m,) share of the faults in whose dihedra of compression each direction (m, 3) lies. On the
    planes between the dihedra, as the strike of a fault that slips down its dip, it lies in
    neither, and counts half."""
    count = np.zeros(len(directions))
    # Products of a few million signs at a time.
    step = max(2_000_000 // min(len(normals), _AT_A_TIME), 1)
    for start in range(0, len(normals), _AT_A_TIME):
        part = slice(start, start + _AT_A_TIME)
        for first in range(0, len(directions), step):
            some = slice(first, first + step)
            to = directions[some].T
            product = (normals[part] @ to) * (slips[part] @ to)
            count[some] += (product < -_BETWEEN).sum(axis=0) + (product <= _BETWEEN).sum(axis=0)
    return count / (2.0 * len(normals))
