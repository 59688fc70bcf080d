"""Fault slip arrows at striae: movement of the hanging wall, seen from above.

Outward arrows are normal and inward arrows reverse, as in Angelier (1979, Tectonophysics 56,
T17-T26).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.products.net.net_axes import plane_transform, unit_positions

_HEAD_LENGTH, _HEAD_HALF_WIDTH = 0.05, 0.022
_MIN_HORIZONTAL_LENGTH = 1e-6


def draw_slip_arrows(
    ax: Any,
    striae: FloatArray,
    slips: FloatArray,
    *,
    color: str,
    width_pt: float,
    zorder: float,
    half_length: float = 0.07,
) -> BoolArray:
    """Draw slip arrows at striae.

    Parameters
    ----------
    ax : StereonetAxes
    striae : (n, 3) array
        Directions of the striae.
    slips : (n, 3) array
        Slip vectors of the hanging wall; NaN if unknown.
    color, width_pt, zorder
    half_length : float
        Half the length of an arrow, in radii of the net.

    Returns
    -------
    (n,) bool array
        Whether each slip has an arrow; vertical slip has no direction on the net.
    """
    from matplotlib.collections import LineCollection, PolyCollection

    position = unit_positions(ax, striae)
    forward = np.asarray(slips, np.float64)[:, :2]
    length = np.linalg.norm(forward, axis=1)
    is_moving = length > _MIN_HORIZONTAL_LENGTH
    step = forward[is_moving] / length[is_moving, None]
    normals = np.stack([-step[:, 1], step[:, 0]], axis=1)
    tip = position[is_moving] + half_length * step
    head_base = tip - _HEAD_LENGTH * step
    shafts = np.stack([position[is_moving] - half_length * step, head_base], axis=1)
    heads = np.stack(
        [tip, head_base + _HEAD_HALF_WIDTH * normals, head_base - _HEAD_HALF_WIDTH * normals],
        axis=1,
    )
    arrow_style: dict[str, Any] = {
        "transform": plane_transform(ax),
        "clip_on": False,
        "zorder": zorder,
    }
    ax.add_collection(
        LineCollection(list(shafts), colors=color, linewidths=width_pt, **arrow_style),
        autolim=False,
    )
    ax.add_collection(
        PolyCollection(list(heads), facecolors=color, edgecolors="none", **arrow_style),
        autolim=False,
    )
    return np.asarray(is_moving)
