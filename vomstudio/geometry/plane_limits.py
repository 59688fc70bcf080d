"""Limits for the points of plane and line fits, and findings about unsuitable points."""

from __future__ import annotations

from vomstudio.core.findings import Finding

MIN_POINTS = 3
# Maximum coordinate, whose square does not overflow.
MAX_COORDINATE = 1e150
# Distances below this many roundings of the largest coordinate are rounding, not shape.
MIN_EXTENT_ROUNDINGS = 4.0
# Maximum number of points of a trace that is searched for repeated points, which matter there.
MAX_POINTS_COUNTING_REPEATS = 16


def too_few_points_finding(n: int) -> Finding:
    """Report that a plane has fewer than three points.

    Parameters
    ----------
    n : int
        Number of points.

    Returns
    -------
    Finding
    """
    return Finding("feature.too-few-points", count=MIN_POINTS - n, minimum=MIN_POINTS)


def degenerate_points_finding(n: int, *, is_coincident: bool) -> Finding:
    """Report that all points coincide or are collinear.

    Parameters
    ----------
    n : int
        Number of points.
    is_coincident : bool
        Whether the points coincide; otherwise they are collinear.

    Returns
    -------
    Finding
    """
    return Finding("points.coincident" if is_coincident else "points.collinear", n=n)
