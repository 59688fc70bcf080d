"""Binned azimuths, dips and plunges for rose diagrams and histograms."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation_rows import OrientationRows
from vomstudio.geology.rose_options import check_bins

ROSE_ANGLES = ("strike", "dip-direction", "trend")
HISTOGRAM_ANGLES = ("dip", "plunge")
LINE_ANGLES = ("trend", "plunge")
"""Angles of lines; all other angles are those of planes."""
MIN_RAYLEIGH_DIRECTIONS = 5
"""Minimum number of rows for Rayleigh's test, which has almost no power for fewer."""
MIN_INCLINATION_DEG = 1e-6
"""Minimum dip of planes, and minimum angle of lines from vertical, for an azimuth."""


@dataclass(frozen=True, eq=False)
class Rose:
    """Rose diagram of n azimuths in bins.

    Attributes
    ----------
    axial : bool
        True if opposite azimuths are equivalent: `shares` is then equal in both halves of the
        circle and sums to 1 in each. The shares of directed azimuths sum to 1 over the circle.
    total : float
        Sum of the weights.
    shares : (360 / bin_deg,) ndarray
        Shares of the bins, clockwise from north; a bin includes its lower edge.
    mean_deg : float or None
        Circular mean in degrees; for axes, it is computed from doubled angles and is in [0, 180).
        None if undefined.
    resultant : float
        Mean resultant length, from 0 (no preferred direction) to 1 (all equal).
    rayleigh_p : float or None
        p-value for the hypothesis of no preferred direction (from doubled angles for axes); None
        for fewer than 5 azimuths.
    left_out : int
        Number of rows without an azimuth or weight.
    """

    bin_deg: float
    axial: bool
    n: int
    total: float
    shares: FloatArray
    mean_deg: float | None
    resultant: float
    rayleigh_p: float | None = None
    left_out: int = 0

    @property
    def has_preferred_direction(self) -> bool:
        """Whether there is a mean direction that is significant at the 5 % level.

        With fewer than 5 rows, significance is not required.
        """
        return self.mean_deg is not None and (self.rayleigh_p is None or self.rayleigh_p < 0.05)


@dataclass(frozen=True, eq=False)
class AngleHistogram:
    """Histogram of n dips or plunges from 0 to 90 degrees.

    The upper edge belongs to the last bin.

    Attributes
    ----------
    total : float
        Sum of the weights.
    shares : (90 / bin_deg,) ndarray
        Shares of the bins, which sum to 1.
    mean_deg, std_deg : float or None
        Weighted mean and standard deviation, degrees; None if undefined.
    left_out : int
        Number of rows without an angle or weight.
    """

    bin_deg: float
    n: int
    total: float
    shares: FloatArray
    mean_deg: float | None
    std_deg: float | None
    left_out: int = 0


def count_histogram(
    angle_deg: npt.ArrayLike, *, bin_deg: float = 10.0, weights: npt.ArrayLike | None = None
) -> AngleHistogram:
    """Count dips or plunges (n,) from 0 to 90 degrees, with weights (n,), in bins.

    Lines that point up are counted by the plunge of their axis.

    Raises
    ------
    UsageError
        If the bins do not divide 90 degrees evenly, or if a weight is negative.
    """
    check_bins(bin_deg, 90.0)
    bins = round(90.0 / bin_deg)
    angles, valid_weights, n_excluded = _valid_rows(
        np.abs(np.asarray(angle_deg, dtype=np.float64).ravel()), weights
    )
    bin_indices = np.minimum(np.floor((angles + 1e-7) / bin_deg).astype(np.intp), bins - 1)
    sums = np.bincount(bin_indices, valid_weights, minlength=bins)
    total_weight = float(valid_weights.sum())
    if total_weight <= 0:
        return AngleHistogram(
            bin_deg, len(angles), total_weight, np.zeros(bins), None, None, n_excluded
        )
    mean = float(valid_weights @ angles) / total_weight
    effective_n = total_weight**2 / float(valid_weights @ valid_weights)
    std = None
    if effective_n > 1.0 + 1e-9:
        std = math.sqrt(
            float(valid_weights @ (angles - mean) ** 2)
            / total_weight
            * effective_n
            / (effective_n - 1.0)
        )
    return AngleHistogram(
        bin_deg, len(angles), total_weight, sums / total_weight, mean, std, n_excluded
    )


def _valid_rows(
    values: FloatArray, weights: npt.ArrayLike | None
) -> tuple[FloatArray, FloatArray, int]:
    """Return the values and weights of rows that have both, and the number of others."""
    all_weights = (
        np.ones_like(values) if weights is None else np.asarray(weights, dtype=np.float64).ravel()
    )
    is_valid = np.isfinite(values) & np.isfinite(all_weights)
    if (all_weights[is_valid] < 0).any():
        raise UsageError(Finding("rose.negative-weight"), field="--weight")
    return values[is_valid], all_weights[is_valid], int(len(values) - is_valid.sum())


def count_rose(
    azimuth_deg: npt.ArrayLike,
    *,
    is_axial: bool,
    bin_deg: float = 10.0,
    weights: npt.ArrayLike | None = None,
) -> Rose:
    """Count azimuths (n,) with weights (n,) in bins that begin at north.

    Rows without an azimuth or weight (NaN) are excluded. The mean is the circular mean (Mardia &
    Jupp 2000, Directional Statistics, 2.2.1), computed from doubled angles for axes (Krumbein 1939,
    Journal of Geology 47, 673-706). Rayleigh's test of weighted rows uses their effective number.

    Raises
    ------
    UsageError
        If the bins do not divide the half circle evenly, or if a weight is negative.
    """
    bins = count_bins(bin_deg)
    azimuths = np.asarray(azimuth_deg, dtype=np.float64).ravel()
    azimuths, valid_weights, n_excluded = _valid_rows(azimuths, weights)
    period = 180.0 if is_axial else 360.0
    # Add a small amount, so that 29.999999 instead of 30 is counted in the right bin.
    bin_indices = np.floor((azimuths % 360.0 + 1e-7) / bin_deg).astype(np.intp) % bins
    n_half_circle = bins // 2
    sums = np.bincount(
        bin_indices % n_half_circle if is_axial else bin_indices,
        valid_weights,
        minlength=n_half_circle if is_axial else bins,
    )
    total_weight = float(valid_weights.sum())
    fractions = sums / total_weight if total_weight > 0 else np.zeros(len(sums))
    angle = np.radians(azimuths * (360.0 / period))
    east, north = float(valid_weights @ np.sin(angle)), float(valid_weights @ np.cos(angle))
    resultant = math.hypot(east, north) / total_weight if total_weight > 0 else 0.0
    mean = None
    if resultant > 1e-9:
        mean = math.degrees(math.atan2(east, north)) % 360.0 * period / 360.0
    full_circle_shares = np.tile(fractions, 2) if is_axial else fractions
    resultant = min(resultant, 1.0)
    n_weighted = int((valid_weights > 0).sum())
    p_value = (
        rayleigh_p(total_weight**2 / float(valid_weights @ valid_weights), resultant)
        if n_weighted >= MIN_RAYLEIGH_DIRECTIONS
        else None
    )
    return Rose(
        bin_deg,
        is_axial,
        len(azimuths),
        total_weight,
        full_circle_shares,
        mean,
        resultant,
        p_value,
        n_excluded,
    )


def rayleigh_p(n: float, resultant: float) -> float:
    """Return the p-value of Rayleigh's test for a preferred direction.

    For n < 50, the series of Fisher (1993), Statistical Analysis of Circular Data, p. 70, is used.

    Parameters
    ----------
    n : float
        Number of angles.
    resultant : float
        Mean resultant length.

    Returns
    -------
    float
    """
    if n < 2.0 - 1e-9:
        return 1.0
    z = n * resultant**2
    series = (
        1.0
        + (2.0 * z - z**2) / (4.0 * n)
        - (24.0 * z - 132.0 * z**2 + 76.0 * z**3 - 9.0 * z**4) / (288.0 * n**2)
    )
    # For large n, its terms are negligible near 5 %, and it does not converge far out in the tail,
    # where z approaches n.
    if n >= 50.0:
        series = 1.0
    return min(max(math.exp(-z) * series, 0.0), 1.0)


def count_bins(bin_deg: float) -> int:
    """Return the number of bins on the circle.

    Parameters
    ----------
    bin_deg : float
        Width of a bin.

    Returns
    -------
    int

    Raises
    ------
    UsageError
        If the bins do not divide the half circle evenly.
    """
    check_bins(bin_deg, 180.0)
    return 2 * round(180.0 / bin_deg)


def table_angles(table: OrientationRows, of: str) -> FloatArray:
    """Return one angle of each row of a table.

    The angle is a strike (right-hand rule), dip direction, trend, dip or plunge.

    Parameters
    ----------
    table : OrientationRows
    of : str
        Name of the angle.

    Returns
    -------
    (n,) ndarray
        Degrees; NaN for rows of the other geometry and for undefined azimuths.
    """
    is_line_angle = of in LINE_ANGLES
    azimuth, angle = (
        (table.trend_deg, table.plunge_deg)
        if is_line_angle
        else (table.dip_direction_deg, table.dip_deg)
    )
    return np.where(table.is_plane != is_line_angle, select_angles(azimuth, angle, of), np.nan)


def select_angles(azimuth_deg: FloatArray, angle_deg: FloatArray, of: str) -> FloatArray:
    """Select an angle of planes (dip direction, dip) or of lines (trend, plunge).

    Parameters
    ----------
    azimuth_deg, angle_deg : (n,) ndarray
    of : str
        Name of the angle.

    Returns
    -------
    (n,) ndarray
        NaN for azimuths of horizontal planes and vertical lines. An unknown dip or plunge (NaN)
        does not exclude an azimuth.

    Raises
    ------
    ValueError
        If the name is unknown.
    """
    if of not in (*ROSE_ANGLES, *HISTOGRAM_ANGLES):
        raise ValueError(f"unknown angle {of!r}; use one of {(*ROSE_ANGLES, *HISTOGRAM_ANGLES)}")
    if of in LINE_ANGLES:
        # A line that points up is equivalent to its opposite, which points down.
        azimuth_deg = np.where(angle_deg < 0.0, (azimuth_deg + 180.0) % 360.0, azimuth_deg)
        angle_deg = np.abs(angle_deg)
    if of in HISTOGRAM_ANGLES:
        return np.asarray(angle_deg, dtype=np.float64)
    has_no_azimuth = (
        np.abs(angle_deg) > 90.0 - MIN_INCLINATION_DEG
        if of == "trend"
        else angle_deg <= MIN_INCLINATION_DEG
    )
    azimuths = np.where(has_no_azimuth, np.nan, azimuth_deg)
    return np.asarray((azimuths - 90.0) % 360.0 if of == "strike" else azimuths)


def column_weights(table: OrientationRows, column: str) -> FloatArray:
    """Return the numbers (n,) in a column, NaN for empty cells.

    Raises
    ------
    UsageError
        If a cell is not a number, or if the column does not exist.
    """
    weights = np.full(len(table), np.nan)
    for i, word in enumerate(table.column(column)):
        if word:
            try:
                weights[i] = float(word)
            except ValueError:
                raise UsageError(
                    Finding("table.not-a-number", cell=word, column=column),
                    file=str(table.path),
                    field="--weight",
                ) from None
    return weights
