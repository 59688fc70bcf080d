"""Limits of points for fits of planes and lines, and findings on unsuitable points."""

from __future__ import annotations

from vomstudio.core.findings import Finding

MIN_POINTS = 3
# Squares of these stay in range.
LARGEST = 1e150
# Distances below this many roundings of the largest coordinate are rounding, not shape.
ROUNDINGS = 4.0
# Points repeated exactly are looked for in short traces only, where one of them matters.
COUNT_REPEATS_UP_TO = 16


def too_few_points(n: int) -> Finding:
    """Report that a plane has less than three points.

    Parameters
    ----------
    n : int
        Number of points.

    Returns
    -------
    Finding
    """
    return Finding("feature.too-few-points", count=MIN_POINTS - n, minimum=MIN_POINTS)


def degenerate_points(n: int, *, coincident: bool) -> Finding:
    """Report that all points are at one place, or else on one line.

    Parameters
    ----------
    n : int
        Number of points.
    coincident : bool
        Whether they are at one place.

    Returns
    -------
    Finding
    """
    return Finding("points.coincident" if coincident else "points.collinear", n=n)
