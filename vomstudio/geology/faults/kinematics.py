"""Kinematics of faults with known slip: P and T axes, kinematic axes and right dihedra.

A fault is defined by the upward unit normal n of its plane and the unit vector s of the movement of
its hanging wall. The axis of greatest shortening is P = (n - s) / sqrt 2, and the axis of greatest
extension is T = (n + s) / sqrt 2; both are at 45 degrees to the fault in the movement plane
(Marrett & Allmendinger 1990, Journal of Structural Geology 12, 973-986) and are axial.

- Kinematic axes: eigenvectors of the mean of T T' - P P' = n s' + s n', the linked Bingham
  statistic of the same authors, with equal weights for all faults.
- Right dihedra (Angelier & Mechler 1977, Bulletin de la Societe geologique de France 19,
  1309-1318): the planes perpendicular to n and s divide the sphere into two dihedra that contain
  the greatest compression and two that contain the greatest extension. If all dihedra of one kind
  overlap, all faults may have moved in a single stress state.
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
N_RESAMPLES = 400
MIN_FAULTS_FOR_CONFIDENCE = 5
GRID_SIZE = 121
"""Number of directions per side of the net, at intervals of 1.3 degrees."""
FAULTS_PER_BLOCK = 500
MIN_PRODUCT = 1e-12


def fault_movements(
    dip_direction_deg: npt.ArrayLike, dip_deg: npt.ArrayLike, slip_rake_deg: npt.ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Compute the upward normals and hanging-wall movements of n faults.

    Parameters
    ----------
    dip_direction_deg, dip_deg : (n,) array_like
    slip_rake_deg : (n,) array_like
        Directed rakes, degrees. See `slip_from_rake`.

    Returns
    -------
    normals, slips : (n, 3) ndarray
        Unit vectors in the World frame.
    """
    azimuth, dip, rake = (
        np.atleast_1d(np.asarray(values, np.float64))
        for values in (dip_direction_deg, dip_deg, slip_rake_deg)
    )
    strike_deg = np.where(dip >= 90.0, np.mod(azimuth - 90.0, 180.0), azimuth - 90.0)
    sin_s, cos_s = sin_cos_deg(strike_deg)
    sin_d, cos_d = sin_cos_deg(dip)
    strike = np.stack([sin_s, cos_s, np.zeros_like(sin_s)], axis=-1)
    down = np.stack([cos_s * cos_d, -sin_s * cos_d, -sin_d], axis=-1)
    sin_r, cos_r = (part[:, None] for part in sin_cos_deg(rake))
    # The hanging wall of a vertical plane is on the side to which its strike in [0, 180) dips.
    normals = planes_to_normals(strike_deg + 90.0, dip)
    return normals, cos_r * strike - sin_r * down


def p_axes(normals: FloatArray, slips: FloatArray) -> FloatArray:
    """Return the P axes of faults, the directions of greatest shortening.

    Parameters
    ----------
    normals, slips : (n, 3) ndarray
        Unit vectors.

    Returns
    -------
    (n, 3) ndarray
    """
    return np.asarray((normals - slips) / np.sqrt(2.0))


def t_axes(normals: FloatArray, slips: FloatArray) -> FloatArray:
    """Return the T axes of faults, the directions of greatest extension.

    Parameters
    ----------
    normals, slips : (n, 3) ndarray
        Unit vectors.

    Returns
    -------
    (n, 3) ndarray
    """
    return np.asarray((normals + slips) / np.sqrt(2.0))


@dataclass(frozen=True, eq=False)
class KinematicAxes:
    """Principal axes of the mean kinematic tensor.

    Attributes
    ----------
    values : (3,) ndarray
        Eigenvalues in descending order (extension first), whose sum is 0: +1, 0, -1 if all faults
        have the same mechanism.
    axes : (3, 3) ndarray
        Unit vectors of extension, intermediate axis and shortening, as rows.
    confidence95_deg : (3,) ndarray or None
        Half-angles of cones that contain 95 % of the bootstrap resamples, degrees; None for fewer
        than five faults.
    """

    values: FloatArray
    axes: FloatArray
    confidence95_deg: FloatArray | None


def kinematic_axes(normals: FloatArray, slips: FloatArray) -> KinematicAxes:
    """Compute the kinematic axes of faults, with bootstrap errors (fixed seed).

    Parameters
    ----------
    normals, slips : (n, 3) ndarray
        Unit vectors.

    Returns
    -------
    KinematicAxes
    """
    tensors = np.einsum("ni,nj->nij", normals, slips)
    tensors = tensors + np.swapaxes(tensors, 1, 2)
    values, axes = _principal_axes(tensors.mean(axis=0))
    n = len(tensors)
    if n < MIN_FAULTS_FOR_CONFIDENCE:
        return KinematicAxes(values, axes, None)
    generator = np.random.default_rng(SEED)
    flat_tensors = tensors.reshape(n, 9)
    # The number of times each fault is drawn gives all means in one matrix product.
    counts = generator.multinomial(n, np.full(n, 1.0 / n), size=N_RESAMPLES)
    means = (counts @ flat_tensors / n).reshape(-1, 3, 3)
    resampled_axes = np.swapaxes(np.linalg.eigh(means)[1], 1, 2)[:, ::-1]
    cosine = np.abs(np.einsum("kij,ij->ki", resampled_axes, axes))
    sine = np.linalg.norm(np.cross(resampled_axes, axes[None]), axis=-1)
    angles = np.degrees(np.arctan2(sine, cosine))
    return KinematicAxes(values, axes, np.percentile(angles, 95.0, axis=0))


def _principal_axes(tensor: FloatArray) -> tuple[FloatArray, FloatArray]:
    values, vectors = np.linalg.eigh(tensor)
    return values[::-1], vectors.T[::-1]


@dataclass(frozen=True, eq=False)
class RightDihedra:
    """Right dihedra of faults, evaluated on a net.

    Attributes
    ----------
    directions : (m, 3) ndarray
        Directions on the lower hemisphere, evenly spaced on an equal-area net.
    share : (m,) ndarray
        Share of the faults in whose compressional dihedra each direction lies; for the other
        faults, the direction is extensional.
    """

    directions: FloatArray
    share: FloatArray

    def compression_maximum(self) -> tuple[FloatArray, float]:
        """Return the centre (3,) of the maximum of compression, and its share."""
        return self._maximum_of_share(self.share)

    def extension_maximum(self) -> tuple[FloatArray, float]:
        """Return the centre (3,) of the maximum of extension, and its share."""
        return self._maximum_of_share(1.0 - self.share)

    def _maximum_of_share(self, fraction: FloatArray) -> tuple[FloatArray, float]:
        max_share = float(fraction.max())
        directions = self.directions[fraction >= max_share - 1e-9]
        return orientation_tensor(directions)[1][0], max_share


def right_dihedra(normals: FloatArray, slips: FloatArray) -> RightDihedra:
    """Compute the right dihedra of faults on the net.

    Parameters
    ----------
    normals, slips : (n, 3) ndarray
        Unit vectors.

    Returns
    -------
    RightDihedra
    """
    grid_coordinates = np.linspace(-1.0, 1.0, GRID_SIZE)
    x, y = np.meshgrid(grid_coordinates, grid_coordinates)
    directions = unproject(np.stack([x.ravel(), y.ravel()], axis=-1))
    directions = directions[np.isfinite(directions).all(axis=1)]
    return RightDihedra(directions, compressed_share(directions, normals, slips))


def compressed_share(directions: FloatArray, normals: FloatArray, slips: FloatArray) -> FloatArray:
    """Return the share of faults in whose compressional dihedra each direction lies.

    Directions on the planes between the dihedra, such as the strike of a dip-slip fault, count as
    one half.

    Parameters
    ----------
    directions : (m, 3) ndarray
    normals, slips : (n, 3) ndarray
        Unit vectors.

    Returns
    -------
    (m,) ndarray
    """
    count = np.zeros(len(directions))
    # Limit a block to a few million products.
    step = max(2_000_000 // min(len(normals), FAULTS_PER_BLOCK), 1)
    for start in range(0, len(normals), FAULTS_PER_BLOCK):
        fault_block = slice(start, start + FAULTS_PER_BLOCK)
        for first in range(0, len(directions), step):
            block = slice(first, first + step)
            block_directions = directions[block].T
            product = (normals[fault_block] @ block_directions) * (
                slips[fault_block] @ block_directions
            )
            count[block] += (product < -MIN_PRODUCT).sum(axis=0) + (product <= MIN_PRODUCT).sum(
                axis=0
            )
    return count / (2.0 * len(normals))
