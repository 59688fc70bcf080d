"""Automatic proposal of sets among the planes of a table, for `vomstudio sets`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.errors import GeometryError, InputError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.results import HIDDEN_IN_JSON
from vomstudio.core.words import tr
from vomstudio.geology.notation import parse_plane
from vomstudio.geology.orientation import Plane, normals_to_planes, planes_to_poles
from vomstudio.geology.orientation_rows import OrientationRows
from vomstudio.geology.populations.set_statistics import set_statistics
from vomstudio.geology.sets.axial_mixture import (
    MIN_MEMBERS,
    Mixture,
    clusters_from_seeds,
    cones95_deg,
    propose_clusters,
)
from vomstudio.geology.sets.discontinuities import (
    Arrangement,
    Discontinuity,
    Pieces,
    ScanlineSpacing,
    arrange_planes,
    describe_faces,
    measure_scanline_spacing,
)
from vomstudio.geology.sets.girdles import find_pairs_without_gap
from vomstudio.geology.sets.scanline import parse_scanline
from vomstudio.geology.sets.set_options import DEFAULT_MAX_SETS, SetOptions
from vomstudio.geology.statistics import fisher

SIGNIFICANCE = 0.05


@dataclass(frozen=True)
class ProposedSet:
    """Proposed set of n planes.

    Attributes
    ----------
    dip_direction_deg, dip_deg : float
        Fisher mean of the planes after flipping them into one hemisphere, degrees.
    kappa : float or None
        Fisher concentration; None for identical planes and for a single plane.
    cone95_deg : float or None
        Half-angle of the 95 % confidence cone of the mean, degrees; None if undefined, as for a
        single plane.
    spacing_m, spacing_cv : float or None
        Mean gap along the mean normal, m, and the standard deviation of the gaps divided by this
        mean; None if too few positions are known.
    """

    name: str
    n: int
    dip_direction_deg: float
    dip_deg: float
    kappa: float | None
    cone95_deg: float | None
    spacing_m: float | None = None
    spacing_cv: float | None = None


@dataclass(frozen=True)
class SetFit:
    """Goodness of fit of two distributions to a set.

    Attributes
    ----------
    better : {"fisher", "kent"} or None
        Distribution that fits better; None if neither could be fitted, as explained by `reason`.
    fisher_p, kent_p : float or None
        p-values of the distributions; None if not fitted or not tested.
    beta_over_kappa, elongated_p : float or None
        Shape parameter of Kent's distribution, and p-value for the hypothesis of a round set; None
        if this distribution was not fitted.
    """

    better: str | None
    fisher_p: float | None
    kent_p: float | None
    beta_over_kappa: float | None
    elongated_p: float | None
    reason: Finding | None


@dataclass(frozen=True)
class DescribedSet(Arrangement, ProposedSet):
    """Set with the arrangement of its planes; the spacing is that of the discontinuities."""

    fit: SetFit | None = None
    scanline: ScanlineSpacing | None = None


@dataclass(frozen=True, repr=False)
class SetProposal(PrintableResult):
    """Sets proposed for n planes.

    Attributes
    ----------
    unassigned : int
        Number of planes that belong to no set.
    criteria : tuple of float
        Criterion for 0, 1, 2, ... sets, where lower is better; empty if seeds were given.
    assignment, probability : (n,) tuple
        Set of each used row ("" if none), and the probability of the assignment.
    rows : (n,) tuple of int
        Indices of the used rows in the table.
    discontinuities : tuple of Discontinuity
        Discontinuities of all sets with known positions.
    discontinuity : (n,) tuple of str
        Id of the discontinuity of each used row ("" if none); empty if only positions are known.
    """

    n: int
    sets: tuple[ProposedSet, ...]
    unassigned: int
    criteria: tuple[float, ...]
    convention: str
    dropped_lines: tuple[int, ...]
    warnings: tuple[Finding, ...]
    assignment: tuple[str, ...] = field(default=(), metadata=HIDDEN_IN_JSON)
    probability: tuple[float, ...] = field(default=(), metadata=HIDDEN_IN_JSON)
    rows: tuple[int, ...] = field(default=(), metadata=HIDDEN_IN_JSON)
    discontinuities: tuple[Discontinuity, ...] = field(default=())
    discontinuity: tuple[str, ...] = field(default=(), metadata=HIDDEN_IN_JSON)


def propose_sets(
    table: OrientationRows,
    options: SetOptions | None = None,
    *,
    pieces: Pieces | None = None,
    progress: Progress | None = None,
) -> SetProposal:
    """Propose sets among the planes of a table; lines are ignored.

    Sets are named S1, S2, ... by decreasing size, or in the order of the seeds.

    Parameters
    ----------
    table : OrientationRows
    options : SetOptions, optional
    pieces : Pieces, optional
        Positions and shapes for all rows of the table.
    progress : Progress, optional

    Returns
    -------
    SetProposal

    Raises
    ------
    GeometryError
        If the table has no planes.
    UsageError
        If there are more sets than planes, if there are too many seeds, if seeds are invalid or
        nearly identical, or if a scanline is invalid or is given without positions.
    """
    options = SetOptions() if options is None else options
    scanline = parse_scanline(options.scanline)
    rows = np.flatnonzero(table.is_plane)
    warnings = list(table.warnings)
    if not len(rows):
        raise GeometryError(Finding("orientation.no-planes"), file=table.path)
    if len(rows) < len(table):
        warnings.append(Finding("sets.lines-left-out", count=len(table) - len(rows)))
    if scanline is not None and pieces is None:
        raise UsageError(Finding("sets.no-places"), field="--scanline")
    poles = table.vectors()[rows]
    progress = progress or SilentProgress()
    progress.stage(tr("Clustering planes"))
    proposal = propose_sets_of_poles(poles, options)
    members = None if pieces is None else pieces.rows(rows)
    proposal = describe_proposal(proposal, poles, members, scanline, progress)
    warnings += proposal.warnings
    if not proposal.sets and options.seeds is None:
        warnings.append(Finding("sets.none", minimum=MIN_MEMBERS))
    return replace(
        proposal,
        convention=table.convention,
        dropped_lines=tuple(table.dropped),
        warnings=tuple(warnings),
        rows=tuple(int(row) for row in rows),
    )


def sets_from_means(
    means: FloatArray, poles: Sequence[FloatArray], group: npt.ArrayLike
) -> SetProposal:
    """Return the sets S1, S2, ... with given means; empty sets are omitted.

    Parameters
    ----------
    means : (k, 3) ndarray
        Poles of the sets.
    poles : sequence of (3,) ndarray
        Poles of the n planes.
    group : (n,) array_like of int
        Set of each plane; -1 if it belongs to none.

    Returns
    -------
    SetProposal
        Kappa and the confidence cone are computed from the planes.
    """
    groups = np.asarray(group, np.int64)
    pole_array = np.asarray(poles, np.float64).reshape(-1, 3)
    sets = []
    for j, mean in enumerate(means):
        members = pole_array[groups == j]
        if not len(members):
            continue
        plane = Plane.from_normal(mean)
        proposed_set = _describe_set(f"S{j + 1}", members, None)
        sets.append(
            replace(proposed_set, dip_direction_deg=plane.dip_direction_deg, dip_deg=plane.dip_deg)
        )
    return SetProposal(
        n=len(pole_array),
        sets=tuple(sets),
        unassigned=int(np.sum(groups < 0)),
        criteria=(),
        convention="",
        dropped_lines=(),
        warnings=(),
        assignment=tuple(f"S{group + 1}" if group >= 0 else "" for group in groups.tolist()),
        probability=(1.0,) * len(pole_array),
        rows=tuple(range(len(pole_array))),
    )


def describe_proposal(
    proposal: SetProposal,
    poles: FloatArray,
    pieces: Pieces | None,
    scanline: FloatArray | None = None,
    progress: Progress | None = None,
) -> SetProposal:
    """Add fitted distributions and the arrangement of the planes to a proposal.

    Parameters
    ----------
    proposal : SetProposal
    poles : (n, 3) ndarray
    pieces : Pieces or None
    scanline : (2, 3) ndarray, optional
        End points in metres; used only if `pieces` is given.
    progress : Progress, optional

    Returns
    -------
    SetProposal
    """
    face = None if pieces is None else describe_faces(pieces)
    assignment = np.array(proposal.assignment)
    sets: list[DescribedSet] = []
    discontinuities: list[Discontinuity] = []
    ids = np.full(len(poles), "", dtype=object)
    progress = progress or SilentProgress()
    progress.stage(tr("Describing the sets"), len(proposal.sets))
    for index, proposed_set in enumerate(proposal.sets):
        progress.step(index)
        rows = np.flatnonzero(assignment == proposed_set.name)
        normal = Plane(proposed_set.dip_direction_deg, proposed_set.dip_deg).normal()
        arrangement, scanline_spacing = Arrangement(), None
        if pieces is not None:
            members = pieces.rows(rows)
            arrangement, planes, labels = arrange_planes(
                proposed_set.name, normal, poles[rows], members, face
            )
            discontinuities += planes
            ids[rows] = ["" if k < 0 else planes[k].id for k in labels.tolist()]
            if scanline is not None:
                scanline_spacing = measure_scanline_spacing(
                    normal, poles[rows], members.places, scanline
                )
        sets.append(
            DescribedSet(
                **{**vars(proposed_set), **vars(arrangement)},
                fit=fit_set(poles[rows]),
                scanline=scanline_spacing,
            )
        )
    warnings, discontinuity_ids = list(proposal.warnings), []
    if pieces is not None and pieces.has_extents:
        discontinuity_ids = ids.tolist()
    elif any(
        proposed_set.p32_1_per_m is not None and proposed_set.p32_low95_1_per_m is None
        for proposed_set in sets
    ):
        warnings.append(Finding("sets.each-pick-counts"))
    return replace(
        proposal,
        sets=tuple(sets),
        discontinuities=tuple(discontinuities),
        discontinuity=tuple(discontinuity_ids),
        warnings=tuple(warnings),
    )


def fit_set(poles: FloatArray) -> SetFit:
    """Fit the distributions of Fisher (1953) and Kent (1982) to a set of poles.

    Parameters
    ----------
    poles : (n, 3) ndarray

    Returns
    -------
    SetFit
    """
    statistics = set_statistics(poles)
    fisher_figures, kent_figures = statistics.fisher, statistics.kent
    better_fit = None
    if fisher_figures is not None and fisher_figures.kappa is not None:
        better_fit = (
            "kent"
            if kent_figures is not None and kent_figures.elongated_p < SIGNIFICANCE
            else "fisher"
        )
    return SetFit(
        better_fit,
        None if fisher_figures is None else fisher_figures.fit_p,
        None if kent_figures is None else kent_figures.fit_p,
        None if kent_figures is None else kent_figures.beta / kent_figures.kappa,
        None if kent_figures is None else kent_figures.elongated_p,
        None if better_fit is not None else statistics.fisher_reason,
    )


def propose_sets_of_poles(
    poles: FloatArray, options: SetOptions | None = None, *, positions: FloatArray | None = None
) -> SetProposal:
    """Propose sets among poles.

    Parameters
    ----------
    poles : ndarray of float, shape (n, 3)
        Unit vectors pointing up or down; n > 0.
    options : SetOptions, optional
        If there are fewer distinct sets than `exactly`, a warning is reported.
    positions : ndarray of float, shape (n, 3), optional
        Points on the planes in the World frame, m.

    Returns
    -------
    SetProposal

    Raises
    ------
    UsageError
        If there are more sets than planes, if there are too many seeds, or if seeds are invalid or
        nearly identical.
    """
    options = SetOptions() if options is None else options
    exactly, seeds = options.exactly, parse_seeds(options.seeds)
    warnings: list[Finding] = []
    mixture, criteria = _fit_mixture(poles, options.max_sets, exactly, seeds)
    group = mixture.most_probable_clusters()
    cones = cones95_deg(poles, mixture)
    order = list(range(mixture.k))
    if not seeds:
        order.sort(key=lambda j: (-int(np.sum(group == j)), j))
    sets: list[ProposedSet] = []
    names = {-1: ""}
    for number, j in enumerate(order, start=1):
        members = np.flatnonzero(group == j)
        names[j] = f"S{number}"
        if not len(members):
            if seeds:
                warnings.append(Finding("sets.empty-seed", number=number))
            continue
        member_positions = None if positions is None else positions[members]
        sets.append(_describe_set(names[j], poles[members], member_positions, float(cones[j])))
    if exactly is not None and not seeds and len(sets) < exactly:
        warnings.append(Finding("sets.fewer", count=len(sets), minimum=MIN_MEMBERS, wanted=exactly))
    if not seeds:
        warnings += _girdle_findings(poles, group, order, names)
    probability = mixture.posterior[np.arange(len(poles)), group]
    return SetProposal(
        n=len(poles),
        sets=tuple(sets),
        unassigned=int(np.sum(group < 0)),
        criteria=tuple(criteria),
        convention="",
        dropped_lines=(),
        warnings=tuple(warnings),
        assignment=tuple(names[int(j)] for j in group),
        probability=tuple(float(value) for value in probability),
        rows=tuple(range(len(poles))),
    )


def _girdle_findings(
    poles: FloatArray, group: IntArray, order: Sequence[int], names: dict[int, str]
) -> list[Finding]:
    nonempty_order = [j for j in order if np.any(group == j)]
    if len(nonempty_order) < 2:
        return []
    means = np.array(
        [fisher(poles[group == j], is_directed=False).mean.vector() for j in nonempty_order]
    )
    groups = np.full(len(poles), -1)
    for index, j in enumerate(nonempty_order):
        groups[group == j] = index
    joined_girdles = {i: i for i in range(len(nonempty_order))}
    for i, j in find_pairs_without_gap(poles, groups, means):
        old_girdle, new_girdle = joined_girdles[j], joined_girdles[i]
        joined_girdles = {
            k: new_girdle if girdle_id == old_girdle else girdle_id
            for k, girdle_id in joined_girdles.items()
        }
    girdles = [
        [k for k in joined_girdles if joined_girdles[k] == girdle_id]
        for girdle_id in dict.fromkeys(joined_girdles.values())
    ]
    return [
        Finding("sets.girdle", sets=[names[nonempty_order[k]] for k in girdle])
        for girdle in girdles
        if len(girdle) > 1
    ]


def parse_seeds(text: str | None) -> tuple[Plane, ...]:
    """Parse a list of planes such as 120/45,300/80.

    Parameters
    ----------
    text : str or None

    Returns
    -------
    tuple of Plane

    Raises
    ------
    UsageError
        If the text is not a valid list of planes.
    """
    planes = []
    for word in [] if text is None else text.split(","):
        try:
            planes.append(parse_plane(word, "dipdir/dip"))
        except InputError as error:
            finding = Finding("sets.seed-not-a-plane", text=word)
            raise UsageError(finding, field="--seeds") from error
    return tuple(planes)


def _fit_mixture(
    poles: FloatArray, max_sets: int | None, exactly: int | None, seeds: Sequence[Plane]
) -> tuple[Mixture, list[float]]:
    if exactly is not None and exactly > len(poles):
        raise UsageError(Finding("sets.too-many", sets=exactly, n=len(poles)), field="--exactly")
    if not seeds:
        if exactly is not None:
            return propose_clusters(poles, exactly, is_exact_count=True)
        return propose_clusters(poles, DEFAULT_MAX_SETS if max_sets is None else max_sets)
    if max_sets is not None and len(seeds) > max_sets:
        raise UsageError(
            Finding("sets.too-many-seeds", seeds=len(seeds), max_sets=max_sets), field="--seeds"
        )
    axes = planes_to_poles(
        [seed.dip_direction_deg for seed in seeds], [seed.dip_deg for seed in seeds]
    )
    is_near = np.abs(axes @ axes.T) > math.cos(math.radians(1.0))
    if (is_near & ~np.eye(len(axes), dtype=bool)).any():
        raise UsageError(Finding("sets.equal-seeds"), field="--seeds")
    return clusters_from_seeds(poles, axes), []


def _describe_set(
    name: str, poles: FloatArray, positions: FloatArray | None, cone95_deg: float = math.nan
) -> ProposedSet:
    fisher_mean = fisher(poles, is_directed=False)
    normal = fisher_mean.mean.vector()
    direction, dip, _ = normals_to_planes(normal)
    gap, cv = spacing_along_normal(normal, positions)
    cone = fisher_mean.alpha95_deg
    if cone is not None and cone95_deg > cone:
        cone = cone95_deg
    return ProposedSet(
        name,
        len(poles),
        float(direction[0]),
        float(dip[0]),
        fisher_mean.kappa,
        cone,
        gap,
        cv,
    )


def spacing_along_normal(
    normal: FloatArray, positions: FloatArray | None
) -> tuple[float | None, float | None]:
    """Return the mean gap and relative deviation of persistent planes along a normal.

    Parameters
    ----------
    normal : (3,) ndarray
    positions : (n, 3) ndarray or None
        One point on each plane; NaN if unknown.

    Returns
    -------
    gap, deviation : float or None
        Mean of the gaps in metres and their relative standard deviation; None if fewer than two
        points are known, or fewer than three for the deviation.
    """
    if positions is None:
        return None, None
    located_positions = positions[np.isfinite(positions).all(axis=1)]
    if len(located_positions) < 2:
        return None, None
    gaps = np.diff(np.sort((located_positions - located_positions.mean(axis=0)) @ normal))
    mean = float(gaps.mean())
    if len(gaps) < 2 or mean <= 0:
        return mean, None
    return mean, float(gaps.std(ddof=1)) / mean
