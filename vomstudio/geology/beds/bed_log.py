"""Log along a line: bed boundaries and true thicknesses between them, with errors.

The true thickness is the component perpendicular to the bedding of the vector from one boundary
point to the next. A tilt of the bedding converts part of the component along the beds into
thickness, so the error increases with the distance of the points along the beds; the errors of the
points are added (first order; Ragan 2009, Structural Geology, chapter 2).
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
from vomstudio.geology.beds.lithologies import strabospot_fields
from vomstudio.geology.measured_value import CONE95, MeasuredValue
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.rotation_errors import Z95


@dataclass(frozen=True)
class Interval:
    """Interval between two boundaries, numbered upward from the oldest one.

    Attributes
    ----------
    base, top : str
        Names of the lower and upper boundary.
    base_m, top_m : float
        Distances of the boundaries above the lowest one, perpendicular to the bedding, m.
    thickness_m : MeasuredValue
        True thickness with the half-width of its 95 % interval (None if no errors are known).
    lithology : str
        Lithology as written in the input.
    strabospot : dict
        StraboSpot fields for this lithology.
    """

    number: int
    base: str
    top: str
    base_m: float
    top_m: float
    thickness_m: MeasuredValue
    lithology: str
    strabospot: dict[str, str]
    notes: str


@dataclass(frozen=True, repr=False)
class BedLog(PrintableResult):
    """Bed log with true thicknesses.

    Attributes
    ----------
    total_m : MeasuredValue
        True thickness from the lowest to the highest boundary, m.
    reordered : tuple of str
        Names of the boundaries whose input order differs from the order of their heights.
    """

    n: int
    intervals: tuple[Interval, ...]
    total_m: MeasuredValue
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
    """Measure the true thickness of beds between points on their boundaries.

    Parameters
    ----------
    points : (n, 3) array_like
        One point on each boundary, in any order, in the World frame, m.
    bed : Plane
        Attitude of the bedding.
    names, lithologies, notes : sequence of str, optional
        Names of the boundaries; lithologies and notes of the beds above them.
    sigma_m : float
        Standard deviation of each coordinate, m.
    bed_error_deg : float
        Half-angle of the 95 % cone of the bedding normal, degrees.
    overturned : bool
        True if the beds are overturned (younger beds below).

    Returns
    -------
    BedLog

    Raises
    ------
    GeometryError
        If there are fewer than two boundaries, or if a point is not finite.
    """
    positions = np.asarray(points, np.float64)
    if positions.ndim != 2 or positions.shape[1] != 3 or not np.isfinite(positions).all():
        raise GeometryError(Finding("points.invalid"))
    n = len(positions)
    if n < 2:
        raise GeometryError(Finding("feature.too-few-points", count=2 - n, minimum=2))
    labels, blanks = list(names or map(str, range(1, n + 1))), [""] * n
    rocks, note_texts = list(lithologies or blanks), list(notes or blanks)
    younging_direction = (-1.0 if overturned else 1.0) * bed.normal()
    heights = (positions - positions[0]) @ younging_direction
    order = np.argsort(heights, kind="stable")
    # The lithology describes the bed above its boundary, even if the log runs from top to bottom.
    expected_order = np.arange(n)[::-1] if heights[-1] < heights[0] else np.arange(n)
    reordered_labels = [
        labels[int(i)] for i, j in zip(order, expected_order, strict=True) if i != j
    ]
    has_errors = bool(sigma_m or bed_error_deg)

    def true_thickness(low: int, high: int) -> MeasuredValue:
        step = positions[high] - positions[low]
        value = float(step @ younging_direction)
        offset = float(np.linalg.norm(step - value * younging_direction))
        tilt = math.radians(bed_error_deg) / CONE95
        error = Z95 * math.hypot(math.sqrt(2.0) * sigma_m, offset * tilt)
        return MeasuredValue(value, error if has_errors else None)

    base = float(heights[order[0]])
    intervals, warnings = [], []
    for number, (low, high) in enumerate(pairwise(order.tolist()), 1):
        fields = strabospot_fields(rocks[low])
        if fields is None:
            warnings.append(Finding("log.unknown-lithology", word=rocks[low], boundary=labels[low]))
        thickness = true_thickness(low, high)
        if thickness.error95 is not None and thickness.value < thickness.error95:
            warnings.append(Finding("log.thickness-uncertain", base=labels[low], top=labels[high]))
        intervals.append(
            Interval(
                number,
                labels[low],
                labels[high],
                float(heights[low]) - base,
                float(heights[high]) - base,
                thickness,
                rocks[low],
                fields or {},
                note_texts[low],
            )
        )
    if reordered_labels:
        warnings.append(Finding("log.boundaries-moved", boundaries=reordered_labels))
    total_thickness = true_thickness(int(order[0]), int(order[-1]))
    return BedLog(n, tuple(intervals), total_thickness, tuple(reordered_labels), tuple(warnings))
