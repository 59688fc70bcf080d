"""Azimuths, and dips or plunges, counted in bins: what rose diagrams and histograms show."""

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

ROSE_OF = ("strike", "dip-direction", "trend")
HISTOGRAM_OF = ("dip", "plunge")
LINES_HAVE = ("trend", "plunge")
"""The others are of planes."""
_LEAST = 5
"""Of fewer Rayleigh's test says next to nothing."""
_LEVEL_DEG = 1e-6
"""Planes as flat, and lines as steep as this, have no azimuth."""


@dataclass(frozen=True, eq=False)
class Rose:
    """n azimuths in bins.

    axial: both ends count alike, so that `shares` of one half of the circle are those of the
    other, and each half sums to 1; directed azimuths sum to 1 over the circle. shares:
    (360 / bin_deg,) from north clockwise, each bin with its lower edge. total: sum of the weights.
    mean_deg: circular mean, of axes by doubled angles and from 0 to 180, None where there is none;
    resultant: its mean resultant length, 0 (no direction) to 1 (all alike). rayleigh_p: chance of
    so long a resultant where no direction is preferred, of axes by doubled angles; None of fewer
    than 5. left_out: rows without azimuth or weight.
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
    def preferred(self) -> bool:
        """There is a mean, and at the level of 5 % nothing speaks for its being one of chance.
        Fewer than 5 rows are not tested."""
        return self.mean_deg is not None and (self.rayleigh_p is None or self.rayleigh_p < 0.05)


@dataclass(frozen=True, eq=False)
class Histogram:
    """n dips or plunges in bins from 0 to 90 degrees; the upper edge belongs to the last bin.

    shares: (90 / bin_deg,), sum 1. total: sum of the weights. mean_deg, std_deg: weighted mean and
    standard deviation, None where there is none. left_out: rows without angle or weight.
    """

    bin_deg: float
    n: int
    total: float
    shares: FloatArray
    mean_deg: float | None
    std_deg: float | None
    left_out: int = 0


def histogram_of(
    angle_deg: npt.ArrayLike, *, bin_deg: float = 10.0, weights: npt.ArrayLike | None = None
) -> Histogram:
    """Counts dips or plunges (n,), 0 to 90, each with its weight (n,). A plunge of a line that
    points up counts as that of its axis. Raises UsageError for bins that do not divide 90 degrees
    evenly, and for negative weights."""
    check_bins(bin_deg, 90.0)
    bins = round(90.0 / bin_deg)
    a, w, left_out = _counted(np.abs(np.asarray(angle_deg, dtype=np.float64).ravel()), weights)
    place = np.minimum(np.floor((a + 1e-7) / bin_deg).astype(np.intp), bins - 1)
    counted = np.bincount(place, w, minlength=bins)
    total = float(w.sum())
    if total <= 0:
        return Histogram(bin_deg, len(a), total, np.zeros(bins), None, None, left_out)
    mean = float(w @ a) / total
    effective = total**2 / float(w @ w)
    std = None
    if effective > 1.0 + 1e-9:
        std = math.sqrt(float(w @ (a - mean) ** 2) / total * effective / (effective - 1.0))
    return Histogram(bin_deg, len(a), total, counted / total, mean, std, left_out)


def _counted(
    values: FloatArray, weights: npt.ArrayLike | None
) -> tuple[FloatArray, FloatArray, int]:
    """Values and weights of the rows that have both, and how many have not. Raises UsageError."""
    w = np.ones_like(values) if weights is None else np.asarray(weights, dtype=np.float64).ravel()
    sound = np.isfinite(values) & np.isfinite(w)
    if (w[sound] < 0).any():
        raise UsageError(Finding("rose.negative-weight"), field="--weight")
    return values[sound], w[sound], int(len(values) - sound.sum())


def rose_of(
    azimuth_deg: npt.ArrayLike,
    *,
    axial: bool,
    bin_deg: float = 10.0,
    weights: npt.ArrayLike | None = None,
) -> Rose:
    """Counts azimuths (n,), each with its weight (n,), in bins that begin at north.

    Rows without azimuth or weight (NaN) are left out. The mean is the circular one (Mardia & Jupp
    2000, Directional Statistics, 2.2.1), of axes by doubled angles (Krumbein 1939, Journal of
    Geology 47, 673-706); of weighted rows the test of Rayleigh has as many as would be as sure
    without weights. Raises UsageError for bins that do not divide the half
    circle evenly, and for negative weights.
    """
    bins = bins_of(bin_deg)
    a = np.asarray(azimuth_deg, dtype=np.float64).ravel()
    a, w, left_out = _counted(a, weights)
    period = 180.0 if axial else 360.0
    # A hair more, so that 30.000000 that came out as 29.999999 is in the bin it begins.
    place = np.floor((a % 360.0 + 1e-7) / bin_deg).astype(np.intp) % bins
    half = bins // 2
    counted = np.bincount(place % half if axial else place, w, minlength=half if axial else bins)
    total = float(w.sum())
    shares = counted / total if total > 0 else np.zeros(len(counted))
    turn = np.radians(a * (360.0 / period))
    east, north = float(w @ np.sin(turn)), float(w @ np.cos(turn))
    resultant = math.hypot(east, north) / total if total > 0 else 0.0
    mean = None
    if resultant > 1e-9:
        mean = math.degrees(math.atan2(east, north)) % 360.0 * period / 360.0
    both = np.tile(shares, 2) if axial else shares
    resultant = min(resultant, 1.0)
    counts = int((w > 0).sum())
    p = rayleigh_p(total**2 / float(w @ w), resultant) if counts >= _LEAST else None
    return Rose(bin_deg, axial, len(a), total, both, mean, resultant, p, left_out)


def rayleigh_p(n: float, resultant: float) -> float:
    """Chance that n angles without preferred direction have a mean resultant length as great as
    this. Rayleigh's test with the series that Fisher (1993), Statistical Analysis of Circular
    Data, p. 70, gives for fewer than 50. A single angle prefers nothing."""
    if n < 2.0 - 1e-9:
        return 1.0
    z = n * resultant**2
    series = (
        1.0
        + (2.0 * z - z**2) / (4.0 * n)
        - (24.0 * z - 132.0 * z**2 + 76.0 * z**3 - 9.0 * z**4) / (288.0 * n**2)
    )
    # Of many its terms change nothing near 5 %, and far out in the tail, where z is like n, it
    # does not converge.
    if n >= 50.0:
        series = 1.0
    return min(max(math.exp(-z) * series, 0.0), 1.0)


def bins_of(bin_deg: float) -> int:
    """How many bins of that width make the circle. Raises UsageError."""
    check_bins(bin_deg, 180.0)
    return 2 * round(180.0 / bin_deg)


def azimuths_of(table: OrientationRows, of: str) -> FloatArray:
    """(n,) strikes (right-hand rule), dip directions, trends, dips or plunges; NaN in rows of the
    other geometry, and azimuths of horizontal planes and of vertical lines."""
    lines = of in LINES_HAVE
    azimuth, angle = (
        (table.trend_deg, table.plunge_deg) if lines else (table.dip_direction_deg, table.dip_deg)
    )
    return np.where(table.is_plane != lines, angles_of(azimuth, angle, of), np.nan)


def angles_of(azimuth_deg: FloatArray, angle_deg: FloatArray, of: str) -> FloatArray:
    """(n,) what is counted, of dip directions and dips of planes, or trends and plunges of lines;
    NaN for azimuths of horizontal planes and of vertical lines."""
    if of not in (*ROSE_OF, *HISTOGRAM_OF):
        raise ValueError(f"unknown angle {of!r}; use one of {(*ROSE_OF, *HISTOGRAM_OF)}")
    if of in LINES_HAVE:
        # A line that is written upward is the one that goes down on the other side.
        azimuth_deg = np.where(angle_deg < 0.0, (azimuth_deg + 180.0) % 360.0, azimuth_deg)
        angle_deg = np.abs(angle_deg)
    if of in HISTOGRAM_OF:
        return np.asarray(angle_deg, dtype=np.float64)
    none = np.abs(angle_deg) > 90.0 - _LEVEL_DEG if of == "trend" else ~(angle_deg > _LEVEL_DEG)
    found = np.where(none, np.nan, azimuth_deg)
    return np.asarray((found - 90.0) % 360.0 if of == "strike" else found)


def weights_of(table: OrientationRows, column: str) -> FloatArray:
    """(n,) the numbers of a column, NaN where it is empty. Raises UsageError for words that are no
    numbers, and for a column that is not there."""
    found = np.full(len(table), np.nan)
    for i, word in enumerate(table.column(column)):
        if word:
            try:
                found[i] = float(word)
            except ValueError:
                raise UsageError(
                    Finding("table.not-a-number", cell=word, column=column),
                    file=str(table.path),
                    field="--weight",
                ) from None
    return found
