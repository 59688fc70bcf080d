"""Fault slip arrows at striae: movement of the hanging wall, seen from above.

Outward arrows are normal and inward arrows reverse, as in Angelier (1979, Tectonophysics 56,
T17-T26).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_HEAD, _WING = 0.05, 0.022
_UPRIGHT = 1e-6


def draw_slip_arrows(
    ax: Axes,
    at: FloatArray,
    slips: FloatArray,
    *,
    color: str,
    width_pt: float,
    zorder: float,
    half: float = 0.07,
) -> BoolArray:
    """Draw slip arrows at net positions.

    Parameters
    ----------
    ax : Axes
    at : (n, 2) array
    slips : (n, 3) array
        Slip vectors of the hanging wall; NaN if unknown.
    color, width_pt, zorder
    half : float
        Half the length of an arrow, in radii of the net.

    Returns
    -------
    (n,) bool array
        Whether each slip has an arrow; vertical slip has no direction on the net.
    """
    from matplotlib.collections import LineCollection, PolyCollection

    ahead = np.asarray(slips, np.float64)[:, :2]
    length = np.linalg.norm(ahead, axis=1)
    moving = length > _UPRIGHT
    step = ahead[moving] / length[moving, None]
    side = np.stack([-step[:, 1], step[:, 0]], axis=1)
    tip = at[moving] + half * step
    neck = tip - _HEAD * step
    shafts = np.stack([at[moving] - half * step, neck], axis=1)
    heads = np.stack([tip, neck + _WING * side, neck - _WING * side], axis=1)
    ax.add_collection(
        LineCollection(list(shafts), colors=color, linewidths=width_pt, zorder=zorder),
        autolim=False,
    )
    ax.add_collection(
        PolyCollection(list(heads), facecolors=color, edgecolors="none", zorder=zorder),
        autolim=False,
    )
    return np.asarray(moving)
