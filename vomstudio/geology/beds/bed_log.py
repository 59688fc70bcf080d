"""A log along a line: boundaries of beds and the true thickness between them, with errors.

The thickness between two points on the boundaries is the part of the way from one to the other that
runs across the bedding. A tilt of the bedding turns what runs along it into thickness, so that its
error grows with how far the points lie apart along the beds; the points' own errors add to it
(first order; Ragan 2009, Structural Geology, chapter 2).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.reprs import PrintableResult
from vomstudio.geology.beds.lithologies import in_strabospot
from vomstudio.geology.measured import CONE95, Measured
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.rotation_errors import Z95


@dataclass(frozen=True)
class Interval:
    """What lies between two boundaries, from the oldest up. base, top : their names; base_m,
    top_m : above the lowest boundary, across the bedding; thickness_m with half of its 95 %
    interval, None where nothing is known of errors; lithology as it was written, strabospot : its
    fields there"""

    number: int
    base: str
    top: str
    base_m: float
    top_m: float
    thickness_m: Measured
    lithology: str
    strabospot: dict[str, str]
    notes: str


@dataclass(frozen=True, repr=False)
class BedLog(PrintableResult):
    """total_m : from the lowest to the highest boundary. reordered : names of boundaries that were
    not in the order of their heights"""

    n: int
    intervals: tuple[Interval, ...]
    total_m: Measured
    reordered: tuple[str, ...]
    warnings: tuple[Finding, ...]


def bed_log(
    points: npt.ArrayLike,
    bed: Plane,
    *,
    names: Sequence[str] | None = None,
    lithologies: Sequence[str] | None = None,
    notes: Sequence[str] | None = None,
    sigma_m: float = 0.0,
    bed_error_deg: float = 0.0,
    overturned: bool = False,
) -> BedLog:
    """points : (n, 3) World, metres, one on each boundary, in any order; names, lithologies,
    notes : (n,) of the boundaries, and of the beds that begin there, up to the next boundary.
    sigma_m : standard deviation of each coordinate; bed_error_deg : half-angle of the 95 % cone of
    the bedding's normal; overturned : younger beds lie below.

    Raises GeometryError for fewer than two boundaries and points that are not finite.
    """
    p = np.asarray(points, np.float64)
    if p.ndim != 2 or p.shape[1] != 3 or not np.isfinite(p).all():
        raise GeometryError(Finding("points.invalid"))
    n = len(p)
    if n < 2:
        raise GeometryError(Finding("feature.too-few-points", count=2 - n, minimum=2))
    called, none = list(names or map(str, range(1, n + 1))), [""] * n
    rocks, said = list(lithologies or none), list(notes or none)
    younging = (-1.0 if overturned else 1.0) * bed.normal()
    height = (p - p[0]) @ younging
    order = np.argsort(height, kind="stable")
    # Walked from the top down, the words still say what begins above a boundary.
    expected = np.arange(n)[::-1] if height[-1] < height[0] else np.arange(n)
    moved = [called[int(i)] for i, j in zip(order, expected, strict=True) if i != j]
    known = bool(sigma_m or bed_error_deg)

    def across(low: int, high: int) -> Measured:
        step = p[high] - p[low]
        value = float(step @ younging)
        aside = float(np.linalg.norm(step - value * younging))
        tilt = math.radians(bed_error_deg) / CONE95
        error = Z95 * math.hypot(math.sqrt(2.0) * sigma_m, aside * tilt)
        return Measured(value, error if known else None)

    base = float(height[order[0]])
    intervals, warnings = [], []
    for number, (low, high) in enumerate(pairwise(order.tolist()), 1):
        fields = in_strabospot(rocks[low])
        if fields is None:
            warnings.append(Finding("log.unknown-lithology", word=rocks[low], boundary=called[low]))
        thick = across(low, high)
        if thick.error95 is not None and thick.value < thick.error95:
            warnings.append(Finding("log.thickness-uncertain", base=called[low], top=called[high]))
        intervals.append(
            Interval(
                number,
                called[low],
                called[high],
                float(height[low]) - base,
                float(height[high]) - base,
                thick,
                rocks[low],
                fields or {},
                said[low],
            )
        )
    if moved:
        warnings.append(Finding("log.boundaries-moved", boundaries=moved))
    total = across(int(order[0]), int(order[-1]))
    return BedLog(n, tuple(intervals), total, tuple(moved), tuple(warnings))
