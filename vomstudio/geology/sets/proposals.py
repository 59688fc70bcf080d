"""Sets proposed among the planes of a table: what `vomstudio sets` prints."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.errors import GeometryError, InputError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, Silent
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.results import HIDDEN
from vomstudio.core.words import tr
from vomstudio.geology.notation import parse_plane
from vomstudio.geology.orientation import Plane, normals_to_planes, planes_to_poles
from vomstudio.geology.orientation_rows import OrientationRows
from vomstudio.geology.populations.set_statistics import set_statistics
from vomstudio.geology.sets.axial_mixture import (
    LEAST_MEMBERS,
    Mixture,
    clusters_from_seeds,
    cones95_deg,
    propose_clusters,
)
from vomstudio.geology.sets.discontinuities import (
    Arrangement,
    Discontinuity,
    OnScanline,
    Pieces,
    arrange,
    on_scanline,
    rests_on,
)
from vomstudio.geology.sets.girdles import without_gap
from vomstudio.geology.sets.scanline import parse_scanline
from vomstudio.geology.sets.set_options import DEFAULT_MAX_SETS, SetOptions
from vomstudio.geology.statistics import fisher

LEVEL = 0.05


@dataclass(frozen=True)
class ProposedSet:
    """n planes; dip_direction_deg, dip_deg : of the mean, Fisher's after flipping into one
    hemisphere; kappa : None where all are alike; cone95_deg : half-angle of the cone that holds
    the true mean with 95 %, None of one plane; spacing_m : mean gap of the places along the mean
    normal, spacing_cv : their standard deviation over it; None without places"""

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
    """How well two models describe a set, and which one does. fisher_p, kent_p : of a misfit as
    large, were it so; None for too few. beta_over_kappa, elongated_p : of Kent's, and the chance of
    a set as long as this, were it as long as wide. better : "fisher" or "kent", None where neither
    could be fitted, with the reason"""

    better: str | None
    fisher_p: float | None
    kent_p: float | None
    beta_over_kappa: float | None
    elongated_p: float | None
    reason: Finding | None


@dataclass(frozen=True)
class DescribedSet(Arrangement, ProposedSet):
    """A set with the arrangement of its planes in space; the spacing is that of its
    discontinuities. scanline : None where none was asked for"""

    fit: SetFit | None = None
    scanline: OnScanline | None = None


@dataclass(frozen=True, repr=False)
class SetProposal(PrintableResult):
    """n planes, of which `unassigned` are in no set; criteria : by which their number is chosen, of
    0, 1, 2... sets, the less the better, empty where seeds were given; assignment : (n,) of the
    rows that were used, the name of the set, "" for none, with its probability; rows : (n,) their
    places in the table; discontinuities : of all sets, where places are known; discontinuity :
    (n,) the id of that of each row, "" for none; empty where nothing but places is known"""

    n: int
    sets: tuple[ProposedSet, ...]
    unassigned: int
    criteria: tuple[float, ...]
    convention: str
    dropped_lines: tuple[int, ...]
    warnings: tuple[Finding, ...]
    assignment: tuple[str, ...] = field(default=(), metadata=HIDDEN)
    probability: tuple[float, ...] = field(default=(), metadata=HIDDEN)
    rows: tuple[int, ...] = field(default=(), metadata=HIDDEN)
    discontinuities: tuple[Discontinuity, ...] = field(default=())
    discontinuity: tuple[str, ...] = field(default=(), metadata=HIDDEN)


def propose_sets(
    table: OrientationRows,
    options: SetOptions | None = None,
    *,
    pieces: Pieces | None = None,
    progress: Progress | None = None,
) -> SetProposal:
    """Propose sets among the planes of a table; lines are left out.

    Sets are named S1, S2... by their size, or in the order of the seeds.

    Parameters
    ----------
    table : OrientationRows
    options : SetOptions, optional
    pieces : Pieces, optional
        Places of all rows of the table.
    progress : Progress, optional

    Returns
    -------
    SetProposal

    Raises
    ------
    GeometryError
        If the table has no planes.
    UsageError
        For more sets than planes, seeds that are not planes or alike, and a scanline without
        places.
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
    progress = progress or Silent()
    progress.stage(tr("Clustering planes"))
    found = sets_among(poles, options)
    members = None if pieces is None else pieces.rows(rows)
    found = described(found, poles, members, scanline, progress)
    warnings += found.warnings
    if not found.sets and options.seeds is None:
        warnings.append(Finding("sets.none", minimum=LEAST_MEMBERS))
    return replace(
        found,
        convention=table.convention,
        dropped_lines=tuple(table.dropped),
        warnings=tuple(warnings),
        rows=tuple(int(row) for row in rows),
    )


def given_sets(means: FloatArray, poles: Sequence[FloatArray], group: npt.ArrayLike) -> SetProposal:
    """Sets whose poles (k, 3) are known, S1, S2... in their order, of planes with poles (n, 3) and
    groups (n,), -1 for none. Sets without a plane are left out. The mean of each is the one given;
    kappa and cone are of its planes."""
    of = np.asarray(group, np.int64)
    all_ = np.asarray(poles, np.float64).reshape(-1, 3)
    sets = []
    for j, mean in enumerate(means):
        own = all_[of == j]
        if not len(own):
            continue
        plane = Plane.from_normal(mean)
        found = _described(f"S{j + 1}", own, None)
        sets.append(
            replace(found, dip_direction_deg=plane.dip_direction_deg, dip_deg=plane.dip_deg)
        )
    return SetProposal(
        n=len(all_),
        sets=tuple(sets),
        unassigned=int(np.sum(of < 0)),
        criteria=(),
        convention="",
        dropped_lines=(),
        warnings=(),
        assignment=tuple(f"S{j + 1}" if j >= 0 else "" for j in of.tolist()),
        probability=(1.0,) * len(all_),
        rows=tuple(range(len(all_))),
    )


def described(
    found: SetProposal,
    poles: FloatArray,
    pieces: Pieces | None,
    scanline: FloatArray | None = None,
    progress: Progress | None = None,
) -> SetProposal:
    """The proposal for poles (n, 3) with how well models fit its sets and how their planes stand in
    space. scanline : (2, 3) ends, m, only with pieces"""
    face = None if pieces is None else rests_on(pieces)
    of = np.array(found.assignment)
    sets: list[DescribedSet] = []
    all_: list[Discontinuity] = []
    ids = np.full(len(poles), "", dtype=object)
    progress = progress or Silent()
    progress.stage(tr("Describing the sets"), len(found.sets))
    for done, one in enumerate(found.sets):
        progress.step(done)
        own = np.flatnonzero(of == one.name)
        normal = Plane(one.dip_direction_deg, one.dip_deg).normal()
        arrangement, line = Arrangement(), None
        if pieces is not None:
            members = pieces.rows(own)
            arrangement, planes, number = arrange(one.name, normal, poles[own], members, face)
            all_ += planes
            ids[own] = ["" if k < 0 else planes[k].id for k in number.tolist()]
            if scanline is not None:
                line = on_scanline(normal, poles[own], members.places, scanline)
        sets.append(
            DescribedSet(
                **{**vars(one), **vars(arrangement)}, fit=fit_of(poles[own]), scanline=line
            )
        )
    warnings, told = list(found.warnings), []
    if pieces is not None and pieces.are_more_than_places:
        told = ids.tolist()
    elif any(one.p32_1_per_m is not None and one.p32_low95_1_per_m is None for one in sets):
        warnings.append(Finding("sets.each-pick-counts"))
    return replace(
        found,
        sets=tuple(sets),
        discontinuities=tuple(all_),
        discontinuity=tuple(told),
        warnings=tuple(warnings),
    )


def fit_of(poles: FloatArray) -> SetFit:
    """Of one set (n, 3): Fisher's (1953) and Kent's (1982) distribution."""
    told = set_statistics(poles)
    one, other = told.fisher, told.kent
    better = None
    if one is not None and one.kappa is not None:
        better = "kent" if other is not None and other.elongated_p < LEVEL else "fisher"
    return SetFit(
        better,
        None if one is None else one.fit_p,
        None if other is None else other.fit_p,
        None if other is None else other.beta / other.kappa,
        None if other is None else other.elongated_p,
        None if better is not None else told.fisher_reason,
    )


def sets_among(
    poles: FloatArray, options: SetOptions | None = None, *, places: FloatArray | None = None
) -> SetProposal:
    """Propose sets among poles.

    Parameters
    ----------
    poles : ndarray of float, shape (n, 3)
        Unit vectors, either end up; n > 0.
    options : SetOptions, optional
        A warning reports fewer distinct sets than `exactly`.
    places : ndarray of float, shape (n, 3), optional
        Places of the planes, World, m.

    Returns
    -------
    SetProposal

    Raises
    ------
    UsageError
        For more sets than planes, and for seeds that are not planes or alike.
    """
    options = SetOptions() if options is None else options
    exactly, seeds = options.exactly, parse_seeds(options.seeds)
    warnings: list[Finding] = []
    mixture, criteria = _mixture(poles, options.max_sets, exactly, seeds)
    group = mixture.assigned()
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
        where = None if places is None else places[members]
        sets.append(_described(names[j], poles[members], where, float(cones[j])))
    if exactly is not None and not seeds and len(sets) < exactly:
        warnings.append(
            Finding("sets.fewer", count=len(sets), minimum=LEAST_MEMBERS, wanted=exactly)
        )
    if not seeds:
        warnings += _girdle_remarks(poles, group, order, names)
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
        probability=tuple(float(p) for p in probability),
        rows=tuple(range(len(poles))),
    )


def _girdle_remarks(
    poles: FloatArray, group: IntArray, order: Sequence[int], names: dict[int, str]
) -> list[Finding]:
    filled = [j for j in order if np.any(group == j)]
    if len(filled) < 2:
        return []
    means = np.array([fisher(poles[group == j], directed=False).mean.vector() for j in filled])
    of = np.full(len(poles), -1)
    for number, j in enumerate(filled):
        of[group == j] = number
    joined = {i: i for i in range(len(filled))}
    for i, j in without_gap(poles, of, means):
        old, new = joined[j], joined[i]
        joined = {k: new if one == old else one for k, one in joined.items()}
    girdles = [[k for k in joined if joined[k] == one] for one in dict.fromkeys(joined.values())]
    return [
        Finding("sets.girdle", sets=[names[filled[k]] for k in girdle])
        for girdle in girdles
        if len(girdle) > 1
    ]


def parse_seeds(text: str | None) -> tuple[Plane, ...]:
    """Planes as typed, 120/45,300/80. Raises UsageError."""
    found = []
    for word in [] if text is None else text.split(","):
        try:
            found.append(parse_plane(word, "dipdir/dip"))
        except InputError as error:
            finding = Finding("sets.seed-not-a-plane", text=word)
            raise UsageError(finding, field="--seeds") from error
    return tuple(found)


def _mixture(
    poles: FloatArray, most: int | None, exactly: int | None, seeds: Sequence[Plane]
) -> tuple[Mixture, list[float]]:
    if exactly is not None and exactly > len(poles):
        raise UsageError(Finding("sets.too-many", sets=exactly, n=len(poles)), field="--exactly")
    if not seeds:
        if exactly is not None:
            return propose_clusters(poles, exactly, exactly=True)
        return propose_clusters(poles, DEFAULT_MAX_SETS if most is None else most)
    if most is not None and len(seeds) > most:
        raise UsageError(
            Finding("sets.too-many-seeds", seeds=len(seeds), max_sets=most), field="--seeds"
        )
    axes = planes_to_poles([s.dip_direction_deg for s in seeds], [s.dip_deg for s in seeds])
    near = np.abs(axes @ axes.T) > math.cos(math.radians(1.0))
    if (near & ~np.eye(len(axes), dtype=bool)).any():
        raise UsageError(Finding("sets.equal-seeds"), field="--seeds")
    return clusters_from_seeds(poles, axes), []


def _described(
    name: str, poles: FloatArray, places: FloatArray | None, cone95_deg: float = math.nan
) -> ProposedSet:
    found = fisher(poles, directed=False)
    normal = found.mean.vector()
    direction, dip, _ = normals_to_planes(normal)
    gap, cv = spacing_along(normal, places)
    cone = found.alpha95_deg
    if cone is not None and cone95_deg > cone:
        cone = cone95_deg
    return ProposedSet(
        name,
        len(poles),
        float(direction[0]),
        float(dip[0]),
        found.kappa,
        cone,
        gap,
        cv,
    )


def spacing_along(
    normal: FloatArray, places: FloatArray | None
) -> tuple[float | None, float | None]:
    """Mean gap of places (n, 3) along a normal, and the standard deviation of the gaps over it, as
    if every plane reached past all others; None where fewer than two have a place."""
    if places is None:
        return None, None
    known = places[np.isfinite(places).all(axis=1)]
    if len(known) < 2:
        return None, None
    gaps = np.diff(np.sort((known - known.mean(axis=0)) @ normal))
    mean = float(gaps.mean())
    if len(gaps) < 2 or mean <= 0:
        return mean, None
    return mean, float(gaps.std(ddof=1)) / mean
