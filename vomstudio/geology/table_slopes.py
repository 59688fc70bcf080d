"""Kinematic analysis of a slope based on the planes of a table, for `vomstudio slope`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.errors import GeometryError, InputError, UsageError
from vomstudio.core.findings import Finding, cause_finding
from vomstudio.core.progress import Progress, ResumedProgress, SilentProgress
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.words import tr
from vomstudio.geology.notation import parse_plane
from vomstudio.geology.orientation import Plane, planes_to_normals
from vomstudio.geology.orientation_rows import OrientationRows
from vomstudio.geology.slope_options import SlopeOptions
from vomstudio.geology.slopes import (
    SlopeFace,
    Zones,
    count_pair_members,
    count_pairs,
    count_pairs_between_sets,
    direct_toppling,
    flexural_toppling,
    planar_sliding,
    to_face_frame,
)
from vomstudio.geology.tilted_planes import TiltedPlanes, tilted_planes

SEED = 1
MAX_DRAWS = 4096
MAX_DRAWN_PLANES = 1_500_000
"""Maximum number of drawn planes, which limits the number of draws."""
MAX_DRAWN_PAIRS = 30_000_000
"""Maximum number of drawn intersections, which limits the number of draws."""
MIN_DRAWS = 4
PLANES_PER_BLOCK = 65_536
"""Number of drawn planes kept in memory at a time."""


@dataclass(frozen=True)
class FailureMode:
    """Figures of a failure mode.

    Attributes
    ----------
    critical, of : int
        Number of planes or intersections in the critical zone, and the total number.
    share : float or None
        critical / of; None if `of` is 0.
    probability : float or None
        Expected share given the errors of the planes; None if no errors are known.
    secondary : int
        Number in the secondary zone. See `Zones`.
    """

    critical: int
    of: int
    share: float | None
    probability: float | None
    secondary: int


@dataclass(frozen=True)
class PlaneFailureMode(FailureMode):
    """Failure mode of individual planes, with the ids of the critical planes."""

    ids: tuple[str, ...]


@dataclass(frozen=True)
class PairFailureMode(FailureMode):
    """Failure mode of the intersections of pairs of planes.

    `of` excludes `parallel` pairs, which do not intersect, and pairs of the `same_set`, whose
    intersection is not a wedge.
    """

    parallel: int
    same_set: int


@dataclass(frozen=True)
class TopplingMode(PairFailureMode):
    """Direct toppling: `bases` are the possible base planes, `secondary` is oblique toppling."""

    bases: PlaneFailureMode


@dataclass(frozen=True)
class SlopeAttitude:
    """Dip direction, dip and right-hand-rule strike of the face, degrees."""

    dip_direction_deg: float
    dip_deg: float
    strike_rhr_deg: float


@dataclass(frozen=True, repr=False)
class TableSlope(PrintableResult):
    """Kinematic analysis of n planes.

    Attributes
    ----------
    left_out : int
        Number of rows of the table that were not used.
    with_error : int
        Number of planes with a known error.
    draws : (int, int) or None
        Number of draws of the planes and of the intersections, given the errors; None if no errors
        are known.
    """

    n: int
    left_out: int
    face: SlopeAttitude
    friction_deg: float
    lateral_deg: float
    limits: str
    planar: PlaneFailureMode
    wedge: PairFailureMode
    flexural_toppling: PlaneFailureMode
    direct_toppling: TopplingMode
    with_error: int
    draws: tuple[int, int] | None
    convention: str
    dropped_lines: tuple[int, ...]
    warnings: tuple[Finding, ...]


def slope_face(face: str | Plane, options: SlopeOptions) -> SlopeFace:
    """Create a slope face from its plane and the options.

    Parameters
    ----------
    face : str or Plane
        Plane, or its text such as "135/70".
    options : SlopeOptions

    Returns
    -------
    SlopeFace

    Raises
    ------
    UsageError
        If the text is not a valid plane, or if the plane is horizontal.
    """
    try:
        plane = parse_plane(face, "dipdir/dip") if isinstance(face, str) else face
    except InputError as error:
        raise UsageError(cause_finding(error), field="--face") from error
    return SlopeFace(plane, options)


def table_slope(
    table: OrientationRows, face: SlopeFace, progress: Progress | None = None
) -> TableSlope:
    """Count the planes and their intersections in the critical zones of a face.

    Raises
    ------
    GeometryError
        If the table has no planes.
    """
    progress = progress or SilentProgress()
    rows = np.flatnonzero(table.is_plane)
    if not len(rows):
        raise GeometryError(
            Finding("orientation.no-planes"),
            file=table.path,
            field="element",
        )
    planes = tilted_planes(table, rows)
    ids = [table.ids[row] for row in rows]
    normals = to_face_frame(face, planes.normals)
    zones = _plane_zones(face, normals)
    sets = set_numbers(table)
    n_pairs = count_pairs_between_sets(len(rows), sets)
    progress.stage(tr("Intersecting pairs of planes"), n_pairs)
    pairs = count_pairs(face, normals[None], progress, sets)
    expected_counts = _estimate_expected_shares(face, planes, sets, progress)
    plane_modes = [
        PlaneFailureMode(
            int(zone.critical.sum()),
            len(rows),
            float(zone.critical.mean()),
            share,
            int(zone.secondary.sum()),
            tuple(ids[i] for i in np.flatnonzero(zone.critical)),
        )
        for zone, share in zip(zones, expected_counts.planes, strict=True)
    ]
    planar, flexural, bases = plane_modes
    of, parallel = int(pairs.of[0]), int(pairs.parallel[0])
    same_set = count_pairs_between_sets(len(rows), None) - n_pairs
    n_known = int(planes.has_known_error.sum())
    wedge, topple = int(pairs.wedge[0]), int(pairs.toppling[0])
    return TableSlope(
        n=len(rows),
        left_out=len(table) - len(rows),
        face=SlopeAttitude(
            face.plane.dip_direction_deg, face.plane.dip_deg, face.plane.strike_rhr_deg
        ),
        friction_deg=float(face.options.friction_deg),
        lateral_deg=float(face.options.lateral_deg),
        limits=face.options.limits,
        planar=planar,
        wedge=PairFailureMode(
            wedge,
            of,
            _critical_share(wedge, of),
            expected_counts.pairs[0],
            int(pairs.wedge_secondary[0]),
            parallel,
            same_set,
        ),
        flexural_toppling=flexural,
        direct_toppling=TopplingMode(
            topple,
            of,
            _critical_share(topple, of),
            expected_counts.pairs[1],
            int(pairs.oblique[0]),
            parallel,
            same_set,
            bases,
        ),
        with_error=n_known,
        draws=expected_counts.draw_counts,
        convention=table.convention,
        dropped_lines=tuple(table.dropped),
        warnings=(
            *table.warnings,
            *_result_findings(face, len(rows), len(table), n_known, of, parallel, same_set),
        ),
    )


def set_numbers(table: OrientationRows) -> IntArray | None:
    """Return the number of the set that each plane belongs to.

    Sets of the same name but different kinds, such as beds and joints, are different sets.

    Parameters
    ----------
    table : OrientationRows

    Returns
    -------
    (n,) ndarray of int or None
        -1 for planes that belong to no set; None if the table has no sets.
    """
    if table.sets is None:
        return None
    rows = np.flatnonzero(table.is_plane)
    sets = [("" if table.kinds is None else table.kinds[row], table.sets[row]) for row in rows]
    number_by_set = {set_: number for number, set_ in enumerate(dict.fromkeys(sets)) if set_[1]}
    return np.array([number_by_set.get(set_, -1) for set_ in sets], np.int64)


@dataclass(frozen=True)
class CriticalPlane:
    """Plane that contributes to a failure mode.

    `intersections` is the number of its critical intersections, or None if the plane itself is
    critical.
    """

    id: str
    intersections: int | None = None


def list_critical_planes(
    table: OrientationRows, face: SlopeFace, slope: TableSlope
) -> dict[str, tuple[CriticalPlane, ...]]:
    """Return the critical planes of each failure mode, and the base planes as "bases".

    They are sorted in table order, or by decreasing number of critical intersections.

    Parameters
    ----------
    table : OrientationRows
    face : SlopeFace
    slope : TableSlope

    Returns
    -------
    dict
    """
    rows = np.flatnonzero(table.is_plane)
    normals = planes_to_normals(table.dip_direction_deg[rows], table.dip_deg[rows])
    members = count_pair_members(face, to_face_frame(face, normals), set_numbers(table))
    planes_by_mode = {
        "planar": slope.planar.ids,
        "flexural_toppling": slope.flexural_toppling.ids,
        "bases": slope.direct_toppling.bases.ids,
    }
    critical_planes = {
        mode: tuple(CriticalPlane(id_) for id_ in ids) for mode, ids in planes_by_mode.items()
    }
    for mode, counts in (("wedge", members.wedge), ("direct_toppling", members.toppling)):
        order = np.argsort(-counts, kind="stable")
        critical_planes[mode] = tuple(
            CriticalPlane(table.ids[rows[i]], int(counts[i])) for i in order if counts[i]
        )
    return critical_planes


def _plane_zones(face: SlopeFace, normals: FloatArray) -> tuple[Zones, Zones, Zones]:
    """Return the zones of planar sliding, flexural toppling and toppling base planes."""
    return (
        planar_sliding(face, normals),
        flexural_toppling(face, normals),
        direct_toppling(face, 0.0 - normals),
    )


def _critical_share(critical_count: int, total_count: int) -> float | None:
    return critical_count / total_count if total_count else None


@dataclass(frozen=True)
class _ExpectedShares:
    """Expected shares of the three zones of planes, and of wedges and direct toppling."""

    planes: tuple[float | None, float | None, float | None] = (None, None, None)
    pairs: tuple[float | None, float | None] = (None, None)
    draw_counts: tuple[int, int] | None = None


def _estimate_expected_shares(
    face: SlopeFace,
    planes: TiltedPlanes,
    sets: IntArray | None,
    progress: Progress,
) -> _ExpectedShares:
    """Estimate probabilities from random draws of the planes within their errors (fixed seed).

    Smaller tables are drawn more often. Planes without a known error do not vary.
    """
    if not planes.has_known_error.any():
        return _ExpectedShares()
    n = len(planes.normals)
    draw_count = _n_draws(MAX_DRAWN_PLANES, n)
    generator = np.random.default_rng(SEED)
    critical_counts = np.zeros(3)
    progress.stage(tr("Estimating probabilities of planes"), draw_count)
    for done_count, block_size in _split_draws(draw_count, n):
        progress.step(done_count)
        normals = to_face_frame(face, planes.draw(block_size, generator))
        critical_counts += [zone.critical.sum() for zone in _plane_zones(face, normals)]
    planar, flexural, base = (critical_counts / (draw_count * n)).tolist()
    if n < 2:
        return _ExpectedShares((planar, flexural, base), draw_counts=(draw_count, 0))
    pairs = count_pairs_between_sets(n, sets)
    if not pairs:
        return _ExpectedShares((planar, flexural, base), draw_counts=(draw_count, 0))
    pair_draws = _n_draws(MAX_DRAWN_PAIRS, pairs)
    n_expected = wedge = topple = 0
    progress.stage(tr("Estimating probabilities of wedges"), pair_draws * pairs)
    for done_count, block_size in _split_draws(pair_draws, n):
        normals = to_face_frame(face, planes.draw(block_size, generator))
        counts = count_pairs(face, normals, ResumedProgress(progress, done_count * pairs), sets)
        n_expected += int(counts.of.sum())
        wedge += int(counts.wedge.sum())
        topple += int(counts.toppling.sum())
    return _ExpectedShares(
        (planar, flexural, base),
        (_critical_share(wedge, n_expected), _critical_share(topple, n_expected)),
        (draw_count, pair_draws),
    )


def _n_draws(max_draws: int, count: int) -> int:
    return int(np.clip(max_draws // count, MIN_DRAWS, MAX_DRAWS))


def _split_draws(draw_count: int, n: int) -> list[tuple[int, int]]:
    """Return the number of draws before each block, and the number within it."""
    max_draws = max(1, PLANES_PER_BLOCK // n)
    return [
        (start, min(max_draws, draw_count - start)) for start in range(0, draw_count, max_draws)
    ]


def _result_findings(
    face: SlopeFace,
    n: int,
    rows: int,
    n_known: int,
    pair_count: int,
    parallel_count: int,
    same_set: int,
) -> list[Finding]:
    """Return the findings about the results."""
    findings: list[Finding] = []
    if same_set:
        findings.append(
            Finding("slope.pairs-of-one-set", pairs=same_set, all_pairs=n * (n - 1) // 2)
        )
    if rows > n:
        findings.append(Finding("sets.lines-left-out", count=rows - n))
    if not face.can_slide:
        findings.append(
            Finding(
                "slope.gentle-face",
                dip_deg=face.plane.dip_deg,
                friction_deg=face.options.friction_deg,
            )
        )
    if parallel_count:
        findings.append(Finding("slope.parallel-pairs", count=parallel_count))
    if not pair_count:
        findings.append(Finding("slope.no-pairs"))
    if 0 < n_known < n:
        findings.append(Finding("slope.errors-unknown", count=n - n_known))
    return findings
