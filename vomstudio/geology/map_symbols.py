"""Map symbols as polylines: strike and dip of planes, trend and plunge of lines.

Symbols are drawn in the horizontal plane through the feature (FGDC-STD-013-2006, sections 6 and 9):
a bar along the strike with a tick in the dip direction, ticks on both sides if vertical, a cross if
horizontal, a hook on the opposite side if overturned, and an arrow along the trend of a line.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.geology.orientation import sin_cos_deg

MAX_FLAT_DEG, MIN_STEEP_DEG = 0.5, 89.5
"""Limits of dips that round to 0 or 90; such planes are drawn as horizontal or vertical."""


TICK_RATIO = 0.4
"""Length of the tick relative to half the length of the bar."""
N_HOOK_SEGMENTS = 8


def strike_and_dip_symbol(
    centre: npt.ArrayLike,
    dip_direction_deg: float,
    dip_deg: float,
    size: float,
    overturned: bool = False,
) -> list[FloatArray]:
    """Return the polylines (k, 3) of a strike-and-dip symbol.

    Parameters
    ----------
    centre : (3,) array_like
        Centre of the symbol in the World frame, m.
    dip_direction_deg, dip_deg : float
    size : float
        Length of the bar, m.
    overturned : bool
        True if the bed is overturned (younger side below); a half circle is then added
        on the up-dip side of the bar.
    """
    position = np.asarray(centre, np.float64)
    sine, cosine = (float(part) for part in sin_cos_deg(dip_direction_deg))
    down = 0.5 * size * np.array([sine, cosine, 0.0])
    half_line = 0.5 * size * np.array([-cosine, sine, 0.0])
    bar = np.array([position - half_line, position + half_line])
    hook = []
    if overturned:
        angles = np.linspace(0.0, np.pi, N_HOOK_SEGMENTS + 1)[:, None]
        hook = [position + 0.5 * TICK_RATIO * (np.cos(angles) * half_line - np.sin(angles) * down)]
    if dip_deg < MAX_FLAT_DEG:
        return [bar, np.array([position - down, position + down]), *hook]
    start = position - TICK_RATIO * down if dip_deg > MIN_STEEP_DEG else position
    return [bar, np.array([start, position + TICK_RATIO * down]), *hook]


def trend_arrow(
    centre: npt.ArrayLike, trend_deg: float, plunge_deg: float, size: float
) -> list[FloatArray]:
    """Return the polylines (k, 3) of an arrow along the trend of a line.

    A horizontal line has an arrow head at both ends.

    Parameters
    ----------
    centre : (3,) array_like
        Start of the arrow in the World frame, m.
    trend_deg, plunge_deg : float
    size : float
        Length of the arrow, m.
    """
    position = np.asarray(centre, np.float64)
    sine, cosine = (float(part) for part in sin_cos_deg(trend_deg))
    forward = size * np.array([sine, cosine, 0.0])
    half_width = size * np.array([cosine, -sine, 0.0])
    tip = position + forward
    parts = [np.array([position, tip]), _arrowhead(tip, forward, half_width)]
    if plunge_deg < MAX_FLAT_DEG:
        parts.append(_arrowhead(position, -forward, half_width))
    return parts


def _arrowhead(tip: FloatArray, forward: FloatArray, half_width: FloatArray) -> FloatArray:
    arrow_base = tip - 0.25 * forward
    return np.array([arrow_base + 0.12 * half_width, tip, arrow_base - 0.12 * half_width])


def symbol_size(positions: npt.ArrayLike) -> float:
    """Return the length of symbols on a map of given positions, m.

    It is a fortieth of the extent of the positions, and at least a fortieth of a metre; 1 m if
    there are no positions.

    Parameters
    ----------
    positions : (n, 3) array_like

    Returns
    -------
    float
    """
    points = np.asarray(positions, np.float64).reshape(-1, 3)
    if not len(points):
        return 1.0
    extent = float(np.hypot(*np.ptp(points[:, :2], axis=0)))
    return max(extent, 1.0) / 40.0
