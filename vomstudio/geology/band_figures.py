"""Figures of the band of planes that fit a straight trace, compared with sets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.reprs import PrintableResult
from vomstudio.geology.orientation_rows import OrientationRows
from vomstudio.geology.plane_bands import BandSet, PlaneBand, SetPrior, compare_sets
from vomstudio.geology.statistics import orientation_tensor, unit_vectors

MIN_PLANES = 3
"""Minimum number of planes for a set to serve as a prior."""
# A higher concentration indicates identical planes rather than natural scatter.
MAX_KAPPA = 1e5


@dataclass(frozen=True, repr=False)
class BandFigures(PrintableResult):
    """Band of planes that fit a straight trace, compared with sets.

    Attributes
    ----------
    trend_deg, plunge_deg : float
        Line of the trace, degrees.
    half_width95_deg : float
        Maximum angle between a plane of the band and this line, degrees.
    turn95_deg : float
        Maximum rotation about the line from the best plane, degrees; 90 if unrestricted.
    dip_direction_deg, dip_deg : float or None
        Best plane in degrees; None if all rotations are equally likely.
    lowest_dip_deg, highest_dip_deg : float
        Range of dips within the band, degrees.
    sets : tuple of BandSet
        Comparisons of sets with the band, in order of decreasing probability.
    none_probability : float or None
        Probability that the plane belongs to none of the sets; None if there are no sets.
    """

    trend_deg: float
    plunge_deg: float
    half_width95_deg: float
    turn95_deg: float
    dip_direction_deg: float | None
    dip_deg: float | None
    lowest_dip_deg: float
    highest_dip_deg: float
    sets: tuple[BandSet, ...]
    none_probability: float | None

    @property
    def likely_set(self) -> BandSet | None:
        """Set with a probability above one half, or None if there is none."""
        first_set = self.sets[0] if self.sets else None
        return first_set if first_set is not None and first_set.probability > 0.5 else None


def describe_band(band: PlaneBand, priors: Sequence[SetPrior] = ()) -> BandFigures:
    """Compute the figures of a band and compare it with sets.

    Parameters
    ----------
    band : PlaneBand
    priors : sequence of SetPrior

    Returns
    -------
    BandFigures
    """
    sets, none_probability = compare_sets(band, priors) if priors else ((), None)
    low, high = band.dips_deg()
    best_plane, line = band.best_plane, band.line
    return BandFigures(
        line.trend_deg,
        line.plunge_deg,
        band.half_width95_deg,
        band.turn95_deg,
        None if best_plane is None else best_plane.dip_direction_deg,
        None if best_plane is None else best_plane.dip_deg,
        low,
        high,
        sets,
        none_probability,
    )


def fit_prior(name: str, normals: npt.ArrayLike) -> SetPrior | None:
    """Fit a Fisher distribution to the planes of a set as its prior.

    Parameters
    ----------
    name : str
    normals : (n, 3) array_like
        Poles or normals; they are flipped into the hemisphere of the first axis of the tensor.

    Returns
    -------
    SetPrior or None
        None if there are fewer than `MIN_PLANES` planes, or if they do not form a cluster.
    """
    v = np.asarray(normals, np.float64).reshape(-1, 3)
    v = v[np.isfinite(v).all(axis=1)]
    n = len(v)
    if n < MIN_PLANES:
        return None
    v = unit_vectors(v)
    first_axis = orientation_tensor(v)[1][0]
    aligned_directions = v * np.where(v @ first_axis < 0.0, -1.0, 1.0)[:, None]
    vector_sum = aligned_directions.sum(axis=0)
    resultant = float(np.linalg.norm(vector_sum))
    kappa = (n - 1.0) / max(n - resultant, (n - 1.0) / MAX_KAPPA)
    if kappa <= 1.0:
        return None
    x, y, z = (vector_sum / resultant).tolist()
    return SetPrior(name, (x, y, z), kappa, n)


def fit_priors(groups: Mapping[str, npt.ArrayLike]) -> list[SetPrior]:
    """Fit a Fisher distribution to each set that has enough planes and forms a cluster.

    Parameters
    ----------
    groups : mapping
        Normals (n, 3) of each set by name.

    Returns
    -------
    list of SetPrior
    """
    priors = (fit_prior(name, normals) for name, normals in groups.items())
    return [prior for prior in priors if prior is not None]


def table_priors(table: OrientationRows) -> list[SetPrior]:
    """Fit a prior to each set of an orientation table.

    If the table has no set column, all planes form one set.

    Returns
    -------
    list of SetPrior

    Raises
    ------
    GeometryError
        If no set has at least three planes that form a cluster.
    """
    names = np.array(table.sets if table.sets is not None else ["all"] * len(table), dtype=object)
    poles, planes = table.vectors(), np.asarray(table.is_plane, np.bool_)
    groups = {
        str(name): poles[planes & (names == name)] for name in dict.fromkeys(names.tolist()) if name
    }
    priors = fit_priors(groups)
    if not priors:
        raise GeometryError(Finding("sets.no-scatter"), file=table.path)
    return priors


def band_findings(band: BandFigures, line: str, plane: str | None) -> list[Finding]:
    """Describe the band of a straight trace.

    Parameters
    ----------
    band : BandFigures
    line : str
        Trend and plunge of the trace as text.
    plane : str or None
        Plane according to the most probable set, as text; None if no set is compatible.

    Returns
    -------
    list of Finding
    """
    findings = [
        Finding(
            "trace.straight",
            line=line,
            width_deg=band.half_width95_deg,
            low_deg=band.lowest_dip_deg,
            high_deg=band.highest_dip_deg,
        )
    ]
    compatible_sets = [prior for prior in band.sets if prior.compatible]
    if compatible_sets:
        sets = [
            f"{compatible_set.name} ({100.0 * compatible_set.probability:.0f} %)"
            for compatible_set in compatible_sets
        ]
        findings.append(Finding("trace.compatible-sets", sets=sets))
    elif band.sets:
        findings.append(Finding("trace.no-compatible-set"))
    likely_set = band.likely_set
    if likely_set is not None and plane is not None:
        findings.append(Finding("trace.plane-of-set", set=likely_set.name, plane=plane))
    return findings
