"""Detection of misread azimuths among outlying compass planes.

The azimuth may be that of the strike or of the opposite direction. The rotation of most
planes is estimated by least median of squares over pairs of planes (Rousseeuw 1984). The
other planes are compared with it, both as stated and with alternative azimuths.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, product

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding

MIN_PLANES = 5
"""Minimum number of planes whose agreement is meaningful."""
_MIN_READINGS = 3
_MAX_PAIRS = 100
_OUTLIER_DEG = 15.0
_OUTLIER_FACTOR = 5.0
# Minimum sine between two normals that determine a rotation.
_MIN_SINE = np.sin(np.radians(15.0))
_MISREADINGS_DEG = (90.0, -90.0, 180.0)


def azimuth_findings(labels: Sequence[str], model: FloatArray, world: FloatArray) -> list[Finding]:
    """Find planes that agree with the others if their azimuth is reinterpreted.

    Parameters
    ----------
    labels : sequence of str
    model, world : (n, 3) ndarray
        Unit normals; a normal and its opposite are equivalent.

    Returns
    -------
    list of Finding
    """
    if len(labels) < MIN_PLANES:
        return []
    rotation = _majority_rotation(model, world)
    if rotation is None:
        return []
    placed_directions = model @ rotation.T
    offset = _angles_between(placed_directions, world)
    median = float(np.median(offset))
    limit = max(_OUTLIER_DEG, _OUTLIER_FACTOR * median)
    if median > _OUTLIER_DEG / 3:
        # Too few planes agree to assess the others.
        return []
    readings_by_turn: dict[float, list[str]] = {}
    for row in map(int, np.flatnonzero(offset > limit)):
        fits = [
            (
                float(
                    _angles_between(
                        placed_directions[row : row + 1], _turn_azimuth(world[row], offset_deg)
                    )[0]
                ),
                offset_deg,
            )
            for offset_deg in _MISREADINGS_DEG
        ]
        min_angle, offset_deg = min(fits)
        if min_angle < limit / 2:
            readings_by_turn.setdefault(offset_deg, []).append(labels[row])
    return [
        Finding("compass.other-azimuth", labels=names, turn_deg=offset_deg)
        for offset_deg, names in readings_by_turn.items()
    ]


def radian_findings(azimuth_deg: FloatArray, inclination_deg: FloatArray) -> list[Finding]:
    """Return a finding if all angles are small enough to be radians.

    Parameters
    ----------
    azimuth_deg, inclination_deg : (n,) ndarray

    Returns
    -------
    list of Finding
    """
    if len(azimuth_deg) < _MIN_READINGS:
        return []
    if azimuth_deg.max() > 2.0 * np.pi + 0.01 or inclination_deg.max() > np.pi / 2.0 + 0.01:
        return []
    return [Finding("compass.radians")]


def find_azimuth_correction(
    placed_directions: FloatArray, world: FloatArray, limit_deg: float
) -> float | None:
    """Return the azimuth correction that makes a measured direction match the predicted one.

    Parameters
    ----------
    placed_directions : (3,) ndarray
        Direction predicted by the registration.
    world : (3,) ndarray
        Measured direction.
    limit_deg : float
        Maximum difference after the correction.

    Returns
    -------
    float or None
        Correction, degrees. None if the difference is not explained by a strike that was read
        as a dip direction, nor by the opposite direction.
    """
    fits = [
        (
            float(_angles_between(placed_directions[None], _turn_azimuth(world, offset_deg))[0]),
            offset_deg,
        )
        for offset_deg in _MISREADINGS_DEG
    ]
    min_angle, offset_deg = min(fits)
    return offset_deg if min_angle < limit_deg else None


def _turn_azimuth(normal: FloatArray, azimuth_deg: float) -> FloatArray:
    """Return a normal (1, 3) rotated clockwise about the vertical by an angle in degrees."""
    c, s = np.cos(np.radians(azimuth_deg)), np.sin(np.radians(azimuth_deg))
    # Azimuths increase clockwise.
    return np.array([[c * normal[0] + s * normal[1], c * normal[1] - s * normal[0], normal[2]]])


def _angles_between(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the angles (n,) between axes (n, 3), in degrees."""
    return np.asarray(np.degrees(np.arccos(np.clip(np.abs((a * b).sum(axis=1)), 0.0, 1.0))))


def _majority_rotation(model: FloatArray, world: FloatArray) -> FloatArray | None:
    """Return the rotation (3, 3) with the smallest median angle between planes, or None."""
    best_rotation: tuple[float, FloatArray] | None = None
    for rotation in rotations_from_pairs(model, world):
        median = float(np.median(_angles_between(model @ rotation.T, world)))
        if best_rotation is None or median < best_rotation[0]:
            best_rotation = median, rotation
    return None if best_rotation is None else best_rotation[1]


def rotations_from_pairs(
    model: FloatArray, world: FloatArray, *, is_axial: bool = True
) -> list[FloatArray]:
    """Return the rotations (3, 3) that pairs of directions determine.

    Random pairs are used if there are many.

    Parameters
    ----------
    model, world : (n, 3) array
        Unit vectors.
    is_axial : bool
        Whether a direction and its opposite are the same.
    """
    pairs = list(combinations(range(len(model)), 2))
    if len(pairs) > _MAX_PAIRS:
        selection = np.random.default_rng(0).choice(len(pairs), _MAX_PAIRS, replace=False)
        pairs = [pairs[int(i)] for i in selection]
    signs = (1.0, -1.0) if is_axial else (1.0,)
    rotations = []
    for i, k in pairs:
        model_frame = _frame(model[i], model[k])
        if model_frame is None:
            continue
        for first_sign, second_sign in product(signs, repeat=2):
            world_frame = _frame(first_sign * world[i], second_sign * world[k])
            if world_frame is not None:
                rotations.append(world_frame @ model_frame.T)
    return rotations


def _frame(a: FloatArray, b: FloatArray) -> FloatArray | None:
    """Return orthogonal axes (3, 3): the bisector and normal of two directions, and a third.

    Returns None if the directions are nearly parallel.
    """
    cross_axis = np.cross(a, b)
    length = float(np.linalg.norm(cross_axis))
    if length < _MIN_SINE:
        return None
    bisector = a + b
    bisector = bisector / np.linalg.norm(bisector)
    normal = cross_axis / length
    return np.column_stack([bisector, normal, np.cross(bisector, normal)])
