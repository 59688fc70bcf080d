"""Detection of two distant groups of points, such as two zones, and of the correct group."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.registration.selection import select_names
from vomstudio.registration.similarity import fit_similarity

# Ratio to the median spacing from which groups are separate.
_SEPARATION_FACTOR = 30.0
# Residual as a share of the extent below which two groups are correct.
_MAX_RESIDUAL_SHARE = 0.05
_MAX_POINTS = 2000
# Minimum size of coordinates that cannot be degrees.
_MIN_COORDINATE_M = 1000.0


def find_larger_group(model: FloatArray, world: FloatArray) -> BoolArray | None:
    """Find the larger of two groups of points that are far apart.

    Parameters
    ----------
    model, world : (n, 3) ndarray

    Returns
    -------
    (n,) ndarray of bool or None
        Mask of the larger group. None if there is only one group, if the groups are also far apart
        on the model, or if there are too few or too many points.
    """
    from scipy.cluster.hierarchy import fcluster, linkage

    if not 4 <= len(world) <= _MAX_POINTS:
        return None
    tree = linkage(world - world.mean(axis=0), "single")
    gaps = tree[:, 2]
    limit = _SEPARATION_FACTOR * max(float(np.median(gaps)), 1e-9)
    if gaps[-1] <= limit or distances_agree(model, world):
        return None
    cluster_ids = fcluster(tree, limit, "distance")
    largest_group = int(np.bincount(cluster_ids).argmax())
    return np.asarray(cluster_ids == largest_group)


def distances_agree(model: FloatArray, world: FloatArray) -> bool:
    """Return whether the distances between points on the model and in the World frame agree.

    Parameters
    ----------
    model, world : (n, 3) ndarray

    Returns
    -------
    bool
    """
    local_points = world - world.mean(axis=0)
    try:
        fit = fit_similarity(model, local_points)
    except GeometryError:
        return False
    squared_misfit = float(((fit(model) - local_points) ** 2).sum())
    return squared_misfit < _MAX_RESIDUAL_SHARE**2 * float((local_points**2).sum())


def find_points_in_degrees(model: FloatArray, world: FloatArray) -> BoolArray:
    """Find the points in degrees if the other points are in metres.

    Parameters
    ----------
    model, world : (n, 3) ndarray

    Returns
    -------
    (n,) ndarray of bool
    """
    horizontal_magnitudes = np.abs(world[:, :2])
    is_small = (
        (horizontal_magnitudes.max(axis=1) <= 180.0)
        & (horizontal_magnitudes.min(axis=1) <= 90.0)
        & (horizontal_magnitudes.max(axis=1) > 0.0)
    )
    is_in_metres = horizontal_magnitudes.max(axis=1) > _MIN_COORDINATE_M
    is_mixed = is_small.any() and int(is_in_metres.sum()) > 1 and (is_small | is_in_metres).all()
    # A site is less than a degree across, and few sites are less than a metre across.
    is_mixed = is_mixed and float(np.ptp(world[is_small, :2], axis=0).max()) < 1.0
    return (
        is_small if is_mixed and not distances_agree(model, world) else np.zeros(len(world), bool)
    )


def select_group_at_model(
    model: FloatArray, world: FloatArray, mask: BoolArray, is_inside: BoolArray
) -> BoolArray | None:
    """Select the correct one of two groups.

    Parameters
    ----------
    model, world : (n, 3) ndarray
    mask : (n,) ndarray of bool
        True for the points of one group.
    is_inside : (n,) ndarray of bool
        Mask of the points in the area of use of the CRS; all False if there is no CRS.

    Returns
    -------
    (n,) ndarray of bool or None
        Mask of the correct group, or None if it is unclear.
    """
    for is_at_model in (is_inside, _is_near_model_coordinates(model, world)):
        first_share, second_share = (
            float(is_at_model[mask].mean()),
            float(is_at_model[~mask].mean()),
        )
        if first_share > 0.5 > second_share or second_share > 0.5 > first_share:
            return mask if first_share > second_share else ~mask
    count = int(mask.sum())
    if 2 * count == len(world):
        return None
    return mask if 2 * count > len(world) else ~mask


def _is_near_model_coordinates(model: FloatArray, world: FloatArray) -> BoolArray:
    """Return a mask of points whose World coordinates are close to those on the model.

    Points near the origin of the model frame are not included.
    """
    diagonal = float(np.linalg.norm(np.ptp(model, axis=0)))
    distances = np.linalg.norm(world[:, :2] - model[:, :2], axis=1)
    is_far = np.linalg.norm(model[:, :2], axis=1) > _SEPARATION_FACTOR * diagonal
    return np.asarray(is_far & (distances < _SEPARATION_FACTOR * diagonal))


def separate_group_findings(
    labels: Sequence[str], world: FloatArray, mask: BoolArray
) -> list[Finding]:
    """Return the finding that it is unclear which of two groups of points is correct.

    Parameters
    ----------
    labels : sequence of str
    world : (n, 3) ndarray
    mask : (n,) ndarray of bool
        True for the points of one group.

    Returns
    -------
    list of Finding
    """
    centres = [np.median(world[rows], axis=0) for rows in (mask, ~mask)]
    names = [select_names(labels, rows) for rows in (mask, ~mask)]
    distance = float(np.linalg.norm(centres[0] - centres[1]))
    if float(np.linalg.norm(centres[0] - centres[1][[1, 0, 2]])) < distance / _SEPARATION_FACTOR:
        return [Finding("control.group-swapped", first=names[0], second=names[1])]
    return [Finding("control.apart", first=names[0], second=names[1], distance_m=distance)]


def mixed_degree_findings(labels: Sequence[str], mask: BoolArray) -> list[Finding]:
    """Return the finding about points in degrees among others in metres.

    Parameters
    ----------
    labels : sequence of str
    mask : (n,) ndarray of bool
        Mask of the points in degrees.

    Returns
    -------
    list of Finding
    """
    names = [labels[int(row)] for row in np.flatnonzero(mask)]
    return [Finding("control.some-in-degrees", labels=names)]
