"""Where a followed path may have left its contact for a parallel one.

A path that leaves its contact crosses rock on which nothing is to be seen, which costs much, and
goes on along something else. The pieces between such crossings are told apart by two witnesses: the
way-points, which were clicked on the contact, and the plane of the other pieces. A gap in the
contact is crossed in the same manner; the piece behind it lies in the same plane.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.errors import GeometryError
from vomstudio.geology.quality import total_error_deg
from vomstudio.geometry.planes import PlaneFit, fit_plane

Array = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

# A crossing is at least this long, in resolutions of the model, and so is a piece of contact.
MIN_CROSSING = 1.5
MIN_PIECE = 3.0
# Of the lowest costs of a path: the level of its contact. Where this is nearly that of the rock
# around it, the contact cannot be told from the rock.
CONTACT_QUANTILE = 0.25
MAX_CONTACT = 0.5


@dataclass(frozen=True)
class DoubtfulStretch:
    """start, end : first and last vertex; offset_m : from the plane of the other pieces"""

    start: int
    end: int
    offset_m: float

    def as_dict(self):
        return asdict(self)


def contact_pieces(points: Array, costs: Array, resolution: float) -> list[tuple[int, int]]:
    """First and last vertex of each piece of a path between crossings of unmarked rock."""
    from scipy.ndimage import median_filter

    n = len(points)
    level = float(np.quantile(costs, CONTACT_QUANTILE))
    if level > MAX_CONTACT:
        return [(0, n - 1)]
    off = median_filter(costs, size=3, mode="nearest") > 0.5 * (level + 1.0)
    along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    runs = np.flatnonzero(np.diff(off, prepend=not off[0], append=not off[-1]))
    crossing = np.zeros(n, bool)
    for start, stop in zip(runs[:-1], runs[1:], strict=True):
        far = along[min(stop, n - 1)] - along[max(start - 1, 0)]
        if off[start] and far >= MIN_CROSSING * resolution:
            crossing[start:stop] = True
    runs = np.flatnonzero(np.diff(crossing, prepend=not crossing[0], append=not crossing[-1]))
    return [
        (int(start), int(stop) - 1)
        for start, stop in zip(runs[:-1], runs[1:], strict=True)
        if not crossing[start] and along[stop - 1] - along[start] >= MIN_PIECE * resolution
    ]


def diagnose(points: Array, costs: Array, at: Ints, resolution: float) -> dict:
    pieces = contact_pieces(points, costs, resolution)
    own = [any(a - 2 <= row <= b + 2 for row in at) for a, b in pairs(pieces)]
    full = fit_plane(points)
    out = {"pieces": pieces, "own": own, "full": full}
    rows = np.concatenate([np.arange(a, b + 1) for (a, b), c in zip(pieces, own) if c] or [np.zeros(0, int)])
    try:
        trusted = fit_plane(points[rows])
        out["trusted"] = trusted
        out["ttotal"] = total_error_deg(trusted, resolution)
        out["angle"] = float(np.degrees(np.arccos(min(1, abs(trusted.normal @ full.normal)))))
    except GeometryError:
        out["trusted"] = None
    return out


def pairs(x):
    return list(x)
