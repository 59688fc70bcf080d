"""Observations from compass readings."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.io.control.observation_tables import CompassTable
from vomstudio.registration.compass_checks import azimuth_findings, radian_findings
from vomstudio.registration.observations import (
    Attitudes,
    Azimuths,
    Directions,
    ObservationKind,
    Points,
)
from vomstudio.registration.similarity_observation import SimilarityObservation

_READING_SIGMA_DEG = 3.0


class Segment(NamedTuple):
    """Two points on the model, with the azimuth from first to second or their distance.

    Attributes
    ----------
    value : float
        Azimuth, degrees, or distance, metres.
    sigma : float or None
        One-sigma error of the value. If None, the default is used.
    label : str
        Label of the segment. If "", the segment is identified by its number.
    """

    first: tuple[float, float, float]
    second: tuple[float, float, float]
    value: float
    sigma: float | None = None
    label: str = ""


def compass_findings(table: CompassTable, kinds: Sequence[ObservationKind]) -> list[Finding]:
    """Return findings about readings that look wrong.

    These are angles in radians, duplicate labels, and strikes misread as dip directions.

    Parameters
    ----------
    table : CompassTable
    kinds : sequence of ObservationKind
        Observations of the table, without the excluded observations.

    Returns
    -------
    list of Finding
    """
    findings = radian_findings(table.azimuth_deg, table.inclination_deg)
    repeated_names = [name for name, count in Counter(table.labels).items() if count > 1]
    if repeated_names:
        findings.append(Finding("compass.repeated-names", labels=repeated_names))
    planes = next((kind for kind in kinds if isinstance(kind, Directions)), None)
    if planes is not None and table.is_plane.any():
        findings += azimuth_findings(planes.labels, planes.model, planes.world)
    return findings


def has_only_compass_evidence(kinds: Sequence[ObservationKind]) -> bool:
    """Return whether only azimuths and compass readings determine north.

    Parameters
    ----------
    kinds : sequence of ObservationKind

    Returns
    -------
    bool
    """
    has_readings = any(isinstance(kind, Azimuths | Directions) for kind in kinds)
    has_other_evidence = any(
        isinstance(kind, Attitudes | SimilarityObservation)
        # A single point does not determine a direction.
        or (isinstance(kind, Points) and len(kind.labels) > 1)
        for kind in kinds
    )
    return has_readings and not has_other_evidence


def compass_directions(
    table: CompassTable, turn_deg: float, north_sigma_deg: float = 0.0
) -> list[Directions]:
    """Convert the planes and lines of a table to observations.

    Parameters
    ----------
    table : CompassTable
    turn_deg : float
        Angle added to all azimuths.
    north_sigma_deg : float
        One-sigma error common to all azimuths.
    """
    c, s = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
    # Azimuths increase clockwise.
    world = table.vectors() @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    kinds: list[Directions] = []
    for is_plane in (True, False):
        rows = np.flatnonzero(table.is_plane == is_plane)
        if len(rows):
            sigma = np.repeat(np.radians(table.sigma[rows])[:, None], 2, axis=1)
            labels = [table.labels[i] for i in rows]
            north_sigma = float(np.radians(north_sigma_deg))
            kinds.append(
                Directions(labels, table.model[rows], world[rows], sigma, north_sigma=north_sigma)
            )
    return kinds


def azimuth_lines(segments: Sequence[Segment], north_sigma_deg: float = 0.0) -> Azimuths:
    """Convert lines with known azimuths to observations.

    Parameters
    ----------
    segments : sequence of Segment
        Lines with their azimuths, degrees.
    north_sigma_deg : float
        See `compass_directions`.

    Returns
    -------
    Azimuths

    Raises
    ------
    UsageError
        If one point is vertically above the other.
    """
    vectors = np.array([np.subtract(b, a) for a, b, *_ in segments], np.float64)
    length = np.linalg.norm(vectors, axis=1)
    if not (np.hypot(vectors[:, 0], vectors[:, 1]) > 1e-6 * np.maximum(length, 1e-300)).all():
        raise UsageError(
            Finding("line.no-azimuth"),
            field="--bearing",
        )
    labels = [
        line.label or tr("azimuth {number}", number=line_number)
        for line_number, line in enumerate(segments, 1)
    ]
    angles = np.radians([line.value for line in segments])
    sigma = [_READING_SIGMA_DEG if line.sigma is None else line.sigma for line in segments]
    north_sigma = float(np.radians(north_sigma_deg))
    return Azimuths(labels, vectors / length[:, None], angles, np.radians(sigma), north_sigma)
