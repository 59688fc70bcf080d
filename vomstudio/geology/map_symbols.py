"""Structural symbols of a map as lines: strike and dip of planes, trend and plunge of lines.

Drawn in the horizontal plane through the feature, as usual (FGDC-STD-013-2006, sections 6 and 9): a
bar along the strike with a tick down the dip; on both sides where vertical; a cross where
horizontal; a hook on the other side where the bed is overturned; an arrow along the trend.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.geology.orientation import sin_cos_deg

FLAT_DEG, STEEP_DEG = 0.5, 89.5
"""A dip that is written 0 or 90 is drawn so."""


TICK = 0.4
"""Of half the bar."""
_HOOK_PIECES = 8


def strike_and_dip(
    centre: npt.ArrayLike,
    dip_direction_deg: float,
    dip_deg: float,
    size: float,
    overturned: bool = False,
) -> list[FloatArray]:
    """Polylines (k, 3) of a symbol whose bar is `size` long, at a place (3,), World. overturned :
    the bed's younger side is below: a half circle stands up the dip, whose ends are on the bar"""
    at = np.asarray(centre, np.float64)
    sine, cosine = (float(part) for part in sin_cos_deg(dip_direction_deg))
    down = 0.5 * size * np.array([sine, cosine, 0.0])
    along = 0.5 * size * np.array([-cosine, sine, 0.0])
    bar = np.array([at - along, at + along])
    hook = []
    if overturned:
        turn = np.linspace(0.0, np.pi, _HOOK_PIECES + 1)[:, None]
        hook = [at + 0.5 * TICK * (np.cos(turn) * along - np.sin(turn) * down)]
    if dip_deg < FLAT_DEG:
        return [bar, np.array([at - down, at + down]), *hook]
    start = at - TICK * down if dip_deg > STEEP_DEG else at
    return [bar, np.array([start, at + TICK * down]), *hook]


def trend_arrow(
    centre: npt.ArrayLike, trend_deg: float, plunge_deg: float, size: float
) -> list[FloatArray]:
    """Polylines (k, 3) of an arrow `size` long that begins at a place (3,) and points along the
    trend; a horizontal line has a head at both ends."""
    at = np.asarray(centre, np.float64)
    sine, cosine = (float(part) for part in sin_cos_deg(trend_deg))
    ahead = size * np.array([sine, cosine, 0.0])
    aside = size * np.array([cosine, -sine, 0.0])
    tip = at + ahead
    parts = [np.array([at, tip]), _head(tip, ahead, aside)]
    if plunge_deg < FLAT_DEG:
        parts.append(_head(at, -ahead, aside))
    return parts


def _head(tip: FloatArray, ahead: FloatArray, aside: FloatArray) -> FloatArray:
    back = tip - 0.25 * ahead
    return np.array([back + 0.12 * aside, tip, back - 0.12 * aside])


def symbol_size(places: npt.ArrayLike) -> float:
    """A length at which the symbols of places (n, 3) stand apart: a fortieth of what they cover on
    the map, at least of a metre."""
    points = np.asarray(places, np.float64).reshape(-1, 3)
    if not len(points):
        return 1.0
    extent = float(np.hypot(*np.ptp(points[:, :2], axis=0)))
    return max(extent, 1.0) / 40.0
