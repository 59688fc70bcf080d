"""Figures of the band of planes that a straight trace allows, held against sets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.words import tr
from vomstudio.geology.orientation_rows import OrientationRows
from vomstudio.geology.plane_bands import BandSet, PlaneBand, SetPrior, sets_in_band
from vomstudio.geology.statistics import orientation_tensor, unit_vectors

FEWEST = 3
"""Planes of a set that says what others are like."""
# A concentration beyond this is no scatter of rock: planes alike to the digit.
_SHARPEST = 1e5


@dataclass(frozen=True, repr=False)
class BandFigures(PrintableResult):
    """trend_deg, plunge_deg : of the trace's line, which lies in every plane of the band
    half_width95_deg : by how much a plane may miss it; turn95_deg : how far planes may be turned
        about it from the best one, 90 is any
    dip_direction_deg, dip_deg : the best one; None where all turns are alike
    lowest_dip_deg, highest_dip_deg : of the planes in the band
    sets : the sets that it was held against, the most probable first; none_probability : that it is
        of none of them, None where there were none
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
    def likely(self) -> BandSet | None:
        """The set that it is of with more than even odds."""
        first = self.sets[0] if self.sets else None
        return first if first is not None and first.probability > 0.5 else None


def band_figures(band: PlaneBand, priors: Sequence[SetPrior] = ()) -> BandFigures:
    """What a band says, held against sets."""
    found, none = sets_in_band(band, priors) if priors else ((), None)
    low, high = band.dips_deg()
    best, line = band.best, band.line
    return BandFigures(
        line.trend_deg,
        line.plunge_deg,
        band.half_width95_deg,
        band.turn95_deg,
        None if best is None else best.dip_direction_deg,
        None if best is None else best.dip_deg,
        low,
        high,
        found,
        none,
    )


def prior_of(name: str, normals: npt.ArrayLike) -> SetPrior | None:
    """A set by the poles or normals (n, 3) of its planes, flipped into the hemisphere of the
    tensor's first axis; None of fewer than three, or where they are no cluster."""
    v = np.asarray(normals, np.float64).reshape(-1, 3)
    v = v[np.isfinite(v).all(axis=1)]
    n = len(v)
    if n < FEWEST:
        return None
    v = unit_vectors(v)
    first = orientation_tensor(v)[1][0]
    flipped = v * np.where(v @ first < 0.0, -1.0, 1.0)[:, None]
    total = flipped.sum(axis=0)
    resultant = float(np.linalg.norm(total))
    kappa = (n - 1.0) / max(n - resultant, (n - 1.0) / _SHARPEST)
    if kappa <= 1.0:
        return None
    x, y, z = (total / resultant).tolist()
    return SetPrior(name, (x, y, z), kappa, n)


def priors_of(groups: Mapping[str, npt.ArrayLike]) -> list[SetPrior]:
    """The sets among these that say what others are like."""
    found = (prior_of(name, normals) for name, normals in groups.items())
    return [each for each in found if each is not None]


def table_priors(table: OrientationRows) -> list[SetPrior]:
    """The sets of an orientation table with a column of sets; without one all planes are one set.
    Raises GeometryError where no set has three planes."""
    names = np.array(table.sets if table.sets is not None else ["all"] * len(table), dtype=object)
    poles, planes = table.vectors(), np.asarray(table.is_plane, np.bool_)
    groups = {
        str(name): poles[planes & (names == name)] for name in dict.fromkeys(names.tolist()) if name
    }
    found = priors_of(groups)
    if not found:
        raise GeometryError(Finding("sets.no-scatter"), file=table.path)
    return found


def band_lines(band: BandFigures, line: str, plane: str | None) -> list[str]:
    """Describe the band of a straight trace, one sentence per line.

    Parameters
    ----------
    band : BandFigures
    line : str
        Trend and plunge of the trace as text.
    plane : str or None
        Plane by the most probable set as text; None if no set is compatible.
    """
    lines = [
        tr(
            "The trace is straight: its plane contains the line {line}, within {width:.1f}°, "
            "and dips between {low:.0f} and {high:.0f}°.",
            line=line,
            width=band.half_width95_deg,
            low=band.lowest_dip_deg,
            high=band.highest_dip_deg,
        )
    ]
    compatible = [each for each in band.sets if each.compatible]
    if band.sets and not compatible:
        lines.append(tr("No set is compatible with it."))
    elif compatible:
        lines.append(
            tr(
                "Compatible sets: {sets}.",
                sets=", ".join(f"{s.name} ({100.0 * s.probability:.0f} %)" for s in compatible),
            )
        )
    likely = band.likely
    if likely is not None and plane is not None:
        lines.append(
            tr(
                "As a plane of {name} it is {plane} (95 %).",
                name=likely.name,
                plane=plane,
            )
        )
    return lines
