"""Checks of whether two models are in the same frame and overlap."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.io.gis.crs import crs_name

_MIN_CONFIDENCE = 70


def crs_findings(first: str | None, second: str | None, names: tuple[str, str]) -> list[Finding]:
    """Compare the coordinate reference systems of two models.

    Parameters
    ----------
    first, second : str or None
    names : (str, str)
        Names of the models, for messages.

    Raises
    ------
    UsageError
        If the systems are certainly different.
    """
    if first is None and second is None:
        return []
    if first is None or second is None:
        other_name, stated_crs = (names[0], second) if first is None else (names[1], first)
        return [Finding("crs.taken-over", bare=other_name, crs=crs_name(stated_crs or ""))]
    if first == second:
        return []
    from pyproj import CRS

    first_crs, second_crs = CRS.from_user_input(first), CRS.from_user_input(second)
    findings = []
    heights = [
        sub for crs in (first_crs, second_crs) for sub in crs.sub_crs_list if sub.is_vertical
    ]
    if len(heights) == 2 and not heights[0].equals(heights[1]):
        findings.append(Finding("crs.other-heights", first=heights[0].name, second=heights[1].name))
    first_crs, second_crs = (
        crs.sub_crs_list[0] if crs.is_compound else crs for crs in (first_crs, second_crs)
    )
    if first_crs.equals(second_crs, ignore_axis_order=True):
        return findings
    codes = (
        first_crs.to_epsg(min_confidence=_MIN_CONFIDENCE),
        second_crs.to_epsg(min_confidence=_MIN_CONFIDENCE),
    )
    if codes[0] is not None and codes[0] == codes[1]:
        return findings
    if None not in codes:
        raise UsageError(
            Finding(
                "crs.different",
                first=names[0],
                crs=first_crs.name,
                second=names[1],
                other=second_crs.name,
            )
        )
    findings.append(
        Finding(
            "crs.unclear",
            first=names[0],
            crs=first_crs.name,
            second=names[1],
            other=second_crs.name,
        )
    )
    return findings


def require_overlap(first: FloatArray, second: FloatArray, names: tuple[str, str]) -> None:
    """Check that two boxes are not farther apart than the size of the larger one.

    Parameters
    ----------
    first, second : (2, 3) ndarray
        Minimum and maximum corners of the boxes.
    names : tuple of str
        Names of the models, for the error.

    Raises
    ------
    GeometryError
        If the boxes are farther apart.
    """
    gap = np.maximum(np.maximum(first[0] - second[1], second[0] - first[1]), 0.0)
    gap_length = float(np.linalg.norm(gap))
    size = max(float(np.linalg.norm(box[1] - box[0])) for box in (first, second))
    if not np.isfinite(gap_length) or gap_length <= size:
        return
    raise GeometryError(
        Finding(
            "reference.no-overlap", first=names[0], second=names[1], apart_m=gap_length, size_m=size
        )
    )
