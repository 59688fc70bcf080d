"""Fold axes: the pi-plane, beta, how well beta is known, and what may be done with it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy.typing as npt

from vomstudio.errors import GeometryError
from vomstudio.geology.orientation import (
    Line,
    Plane,
    planes_to_poles,
    rake_of,
)
from vomstudio.geology.statistics import orientation_tensor

MIN_ARC = 1e-10
"""S2 below this: the planes are parallel (to 1e-5 rad); any line in them would do."""


@dataclass(frozen=True, eq=False)
class FoldAxis:
    """A view direction found from planes, with its uncertainty and its verdict.

    beta: the axis, plunging down. pi_plane: the plane normal to it, the best through the poles.
    max/min_confidence95_deg: semi-axes of the joint 95 % region of beta, None where n < 3.
    confidence_direction_deg: rake in the pi-plane, 0 to 180 from its right-hand-rule strike, of
    the direction in which beta tilts most; `confidence_axis` is the same direction as a line.
    eigenvalues: S1 >= S2 >= S3 of the poles' tensor, sum 1.
    valid: "yes", "conditional" or "no"; verdict: its name; reasons: sentences with numbers.
    """

    n: int
    beta: Line
    pi_plane: Plane
    eigenvalues: tuple[float, float, float]
    max_confidence95_deg: float | None
    min_confidence95_deg: float | None
    confidence_direction_deg: float | None
    confidence_axis: Line | None
    valid: str
    verdict: str
    reasons: tuple[str, ...]


def fold_axis(dip_direction_deg: npt.ArrayLike, dip_deg: npt.ArrayLike) -> FoldAxis:
    """Pi-plane and beta of n >= 2 planes (arrays (n,)): beta is the eigenvector of S3 of the
    poles' orientation tensor (textbook 4.2, fig. 31d). Raises GeometryError for fewer than two
    planes or planes that are all parallel."""
    poles = planes_to_poles(dip_direction_deg, dip_deg).reshape(-1, 3)
    n = len(poles)
    if n < 2:
        raise GeometryError(f"A fold axis needs at least 2 planes; {n} given.")
    values, axes = orientation_tensor(poles)
    if values[1] < MIN_ARC:
        raise GeometryError(
            f"All {n} planes are parallel: they define no fold axis. Any direction in the plane "
            "shows true thickness; choose one."
        )
    beta = Line.from_vector(axes[2])
    pi_plane = beta.normal_plane()
    swing = Line.from_vector(axes[1])
    return FoldAxis(
        n=n,
        beta=beta,
        pi_plane=pi_plane,
        eigenvalues=(float(values[0]), float(values[1]), float(values[2])),
        max_confidence95_deg=None,
        min_confidence95_deg=None,
        confidence_direction_deg=rake_of(swing, pi_plane) if n > 2 else None,
        confidence_axis=swing if n > 2 else None,
        valid="conditional",
        verdict="undetermined",
        reasons=(),
    )
