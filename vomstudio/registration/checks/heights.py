"""Heights that were not measured: all alike, where the model is not flat, or none at all."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.registration.checks.comparison import far_better, left_over
from vomstudio.registration.selection import selected
from vomstudio.registration.similarity import fit_similarity

# Heights of sound points are seldom all alike, so that little is risked.
_BY_CHANCE = 0.01
# Of how far points reach: they miss by less for other reasons.
_FITS, _NEARLY_FITS = 0.003, 0.002
# From so many points on, x and y as they are seen from above leave something over.
_FEWEST_SEEN = 5
# What tables write where nothing was measured.
_NONE = (0.0, -9999.0, 9999.0, -99999.0, -32767.0, -32768.0)
_HARDLY = 1e-4
# Coordinates from above are an affine image of the model.
_UNKNOWNS_SEEN = 8


def constant_height_findings(model: FloatArray, world: FloatArray) -> list[Finding]:
    """Return a finding if all points (n, 3) have one height, which contradicts the model."""
    if len(world) < 3 or np.ptp(world[:, 2]) > 0.0 or not _contradicted(model, world):
        return []
    return [Finding("control.constant-heights", height=float(world[0, 2]))]


def missing_height_findings(
    labels: Sequence[str], model: FloatArray, world: FloatArray
) -> list[Finding]:
    """Return a finding if some points (n, 3) have a placeholder instead of a height."""
    none = np.isin(world[:, 2], _NONE)
    if not none.any() or int((~none).sum()) < 3:
        return []
    given, rest = left_over(model, world), left_over(model[~none], world[~none])
    if not far_better(rest, given, _HARDLY):
        return []
    return [
        Finding(
            "control.missing-heights",
            labels=selected(labels, none),
            height=float(world[none, 2][0]),
        )
    ]


def _contradicted(model: FloatArray, world: FloatArray) -> bool:
    n = len(world)
    local = world - world.mean(axis=0)
    try:
        fit = fit_similarity(model, local)
    except GeometryError:
        return False
    squares = float(((fit(model) - local) ** 2).sum())
    reach = float((local**2).sum())
    if n < _FEWEST_SEEN:
        return squares > _FITS**2 * reach and (n < 4 or _off_a_plane(model, fit.scale, squares))
    if squares <= _NEARLY_FITS**2 * reach:
        return False
    from scipy.stats import f

    # What the points would leave over, had nothing been said of their heights.
    seen = np.column_stack([model - model.mean(axis=0), np.ones(n)])
    fitted = seen @ np.linalg.lstsq(seen, local[:, :2], rcond=None)[0]
    left = float(((fitted - local[:, :2]) ** 2).sum())
    free = 2 * n - _UNKNOWNS_SEEN
    less = 3 * n - 7 - free
    limit = float(f.isf(_BY_CHANCE, less, free))
    return (squares - left) / less > limit * max(left, 1e-18 * reach) / free


def _off_a_plane(model: FloatArray, scale: float, squares: float) -> bool:
    """Whether four points are as far off a plane on the model as they miss."""
    axes = np.linalg.svd(model - model.mean(axis=0), compute_uv=False)
    return bool((scale * axes[2]) ** 2 > 0.1 * squares)
