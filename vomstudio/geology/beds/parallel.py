"""Parallel planes fitted together, and whether two traces are of one bed.

Traces of beds that were deposited parallel to each other share one normal, though each has its own
place: the normal is that of the scatter of all points about the middles of their own traces (the
grouped planes of Quinn & Ehlmann 2019, Earth and Space Science 6, doi 10.1029/2018EA000416). Short
traces that each determine no plane determine one together.

Errors are those of least squares with each trace's own noise, whose likeness along the trace is
reckoned as for single planes (`geometry.plane_errors.quantiles`). A trace's distance along the
normal carries the error of its own middle and, over the distance in the plane, that of the tilt; by
it two traces are held against being of one plane (Student's t).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.plane_errors import joint_quantile, quantiles

FEWEST = 3
"""Points of a trace whose scatter counts."""
LEVEL = 0.05
_THIN = 1e-6
"""Relative spread across the traces under which all points lie on one line."""
_SURE = 3.0
"""Degrees of freedom of a trace's noise from which it can be held against others that have more."""
_LEAST = 1e-15
"""The least p that is told where several noises have a part."""
_WIDE = 3.0
"""Times its scatter about the common plane that a trace is wide to have a plane of its own."""
_BENT = 0.05
"""And times its length from which it is not straight."""


@dataclass(frozen=True)
class Bed:
    """One trace among parallel ones. distance_m : along the common upward normal from the middle of
    all traces; error95_m : of that; rms_m : of its points about the common plane through it"""

    id: str
    n: int
    distance_m: float
    error95_m: float | None
    rms_m: float


@dataclass(frozen=True)
class SamePlane:
    """Whether two traces lie in one plane of the common attitude. distance_m : along the normal,
    second less first; error95_m : of that; p : of a distance as large, were they of one bed"""

    first: str
    second: str
    distance_m: float
    error95_m: float
    p: float


@dataclass(frozen=True)
class ParallelBeds:
    """dip_direction_deg, dip_deg, strike_rhr_deg, undefined : of the common plane
    max/min_confidence95_deg : semi-axes of the joint 95 % region of its normal
    p_parallel : of traces turned against each other as much as these, were their planes parallel;
        None where no two of them determine a plane
    beds : upwards along the normal; warnings : in words
    """

    n: int
    dip_direction_deg: float
    dip_deg: float
    strike_rhr_deg: float
    undefined: bool
    normal: tuple[float, float, float]
    rms_m: float
    max_confidence95_deg: float | None
    min_confidence95_deg: float | None
    p_parallel: float | None
    beds: tuple[Bed, ...]
    same: tuple[SamePlane, ...]
    warnings: tuple[Finding, ...]

    @property
    def plane(self) -> Plane:
        """The common plane."""
        return Plane(self.dip_direction_deg, self.dip_deg)

    @property
    def are_parallel(self) -> bool:
        """Whether the traces are turned against each other no more than their scatter explains."""
        return self.p_parallel is None or self.p_parallel >= LEVEL


@dataclass(frozen=True, eq=False)
class _Traces:
    """G traces in the axes of the common plane.

    tilts : (G, 2, 2) what the noise of each gives the covariance of the normal's tilts along them,
        and of_tilts : (2, 2) of their sum; of_middle : (G,) variance of its place along the normal
    axes : (G, 2, 2) of each in the plane, columns; sums, leans, spread : (G, 2) its scatter along
        them, what it says of a tilt of its own, and the variance of that; judged : (G, 2) those
        that say anything of a tilt
    free : (G,) degrees of freedom of the noise of each, whose variances are inflated so that limits
        by as many hold; independent : those that correlation leaves of them; free_tilts : of the
        tilts, where these are known by how much traces are turned against each other
    """

    tilts: FloatArray
    of_middle: FloatArray
    axes: FloatArray
    sums: FloatArray
    leans: FloatArray
    spread: FloatArray
    judged: BoolArray
    free: FloatArray
    independent: FloatArray
    free_tilts: float | None = None

    @property
    def of_tilts(self) -> FloatArray:
        return np.asarray(self.tilts.sum(axis=0))


def parallel_beds(
    ids: Sequence[str],
    points: npt.ArrayLike,
    offsets: npt.ArrayLike,
    *,
    ordered: bool = True,
    pairs: Sequence[tuple[str, str]] = (),
) -> ParallelBeds:
    """Fit parallel planes to traces.

    ids : (G,) of the traces; points : (n, 3) metres; offsets : (G + 1,), trace i is
    points[offsets[i]:offsets[i + 1]]; ordered : along the traces, so that the noise of neighbours
    may be alike
    pairs : ids of traces that are held against being of one plane; none for each with the next one
        upwards
    Raises GeometryError for fewer than two traces, and where all of them together determine no
    plane; `KeyError` for an id in `pairs` that is none of `ids`.
    """
    points = np.asarray(points, np.float64).reshape(-1, 3)
    offsets = np.asarray(offsets, np.int64)
    counts = np.diff(offsets)
    if len(ids) < 2:
        raise GeometryError(Finding("beds.too-few-traces"))
    if (counts < 1).any():
        raise GeometryError(Finding("beds.empty-trace"))
    starts = offsets[:-1]
    middles = np.add.reduceat(points, starts, axis=0) / counts[:, None]
    own = points - np.repeat(middles, counts, axis=0)
    values, axes = np.linalg.eigh(own.T @ own / len(own))
    if not values[1] > _THIN * values[2]:
        raise GeometryError(Finding("beds.one-direction"))
    basis = axes[:, [2, 1, 0]]
    if basis[2, 2] < 0.0:
        basis = -basis
    flat = own @ basis
    traces, p_parallel = _widened(_errors(flat, counts, starts, ordered))
    normal = basis[:, 2]
    along = (middles - points.mean(axis=0)) @ normal
    known = bool(np.isfinite(traces.of_tilts).all())
    error = _errors_of_middles(traces)
    beds = [
        Bed(
            ids[i],
            int(counts[i]),
            float(along[i]),
            float(error[i]) if known else None,
            float(np.sqrt((flat[starts[i] : offsets[i + 1], 2] ** 2).mean())),
        )
        for i in np.argsort(along, kind="stable")
    ]
    largest, smallest = _semi_axes(traces) if known else (None, None)
    place = {id_: i for i, id_ in enumerate(ids)}
    asked = list(pairs) or [(a.id, b.id) for a, b in pairwise(beds)]
    same = [
        _same(traces, (place[a], place[b]), (a, b), (middles[place[b]] - middles[place[a]]) @ basis)
        for a, b in (asked if known else [])
    ]
    plane = Plane.from_normal(normal)
    return ParallelBeds(
        n=len(points),
        dip_direction_deg=plane.dip_direction_deg,
        dip_deg=plane.dip_deg,
        strike_rhr_deg=plane.strike_rhr_deg,
        undefined=plane.undefined,
        normal=(float(normal[0]), float(normal[1]), float(normal[2])),
        rms_m=float(np.sqrt((flat[:, 2] ** 2).mean())),
        max_confidence95_deg=largest,
        min_confidence95_deg=smallest,
        p_parallel=p_parallel,
        beds=tuple(beds),
        same=tuple(same),
        warnings=tuple(_warnings(p_parallel, known)),
    )


def _errors(flat: FloatArray, counts: IntArray, starts: IntArray, ordered: bool) -> _Traces:
    """flat : (n, 3) points about their own middles, in the axes of the common plane"""
    groups = len(counts)
    sums, leans, axes = np.zeros((groups, 2)), np.zeros((groups, 2)), np.zeros((groups, 2, 2))
    turned = np.empty_like(flat)
    for i, (first, n) in enumerate(zip(starts, counts, strict=True)):
        part = flat[first : first + n]
        sums[i], axes[i] = np.linalg.eigh(part[:, :2].T @ part[:, :2])
        turned[first : first + n, :2] = part[:, :2] @ axes[i]
        turned[first : first + n, 2] = part[:, 2]
        leans[i] = turned[first : first + n, :2].T @ part[:, 2]
    judged = _with_width(turned, sums, leans, counts, starts)
    best = np.zeros(groups)
    for i, (first, n) in enumerate(zip(starts, counts, strict=True)):
        # What a plane of its own would leave, or a line where its width says nothing.
        part = turned[first : first + n]
        told = judged[i] & (sums[i] > 0.0)
        part[:, 2] -= part[:, :2][:, told] @ (leans[i] / np.where(told, sums[i], 1.0))[told]
        best[i] = float(part[:, 2] @ part[:, 2])
    free = np.where(counts > FEWEST, counts - 1.0 - judged.sum(axis=1), 0.0)
    counted = free > 0.0
    pooled = float(best[counted].sum() / free[counted].sum()) if counted.any() else np.nan
    noise = np.where(counted, best / np.maximum(free, 1.0), pooled)
    inflation, effective = np.ones((groups, 2)), counts.astype(np.float64)
    if counted.any():
        rows = np.flatnonzero(counted)
        index = np.concatenate([np.arange(starts[i], starts[i] + counts[i]) for i in rows])
        begin = np.concatenate([[0], np.cumsum(counts[rows])[:-1]])
        # The larger of a trace's own axes comes second from eigh.
        u, v, r = turned[index, 1], turned[index, 0], turned[index, 2]
        q1, q2, n_eff, _ = quantiles(u, v, r, begin, counts[rows], free[rows], ordered)
        white = joint_quantile(free[rows])
        inflation[rows] = np.maximum(np.stack([q2, q1], axis=1) / white[:, None], 1.0)
        effective[rows] = n_eff
    # The mean is as slow as anything along a trace.
    of_middle = noise * inflation.max(axis=1) / counts
    spread = noise[:, None] * inflation * sums
    whole = np.linalg.inv(np.einsum("gik,gk,gjk->ij", axes, sums, axes))
    tilts = np.einsum("ij,gjk,gk,glk,lm->gim", whole, axes, spread, axes, whole)
    # The noise of a trace that cannot tell its own is that of all others together.
    left = np.where(counted, free, free.sum())
    independent = np.maximum(effective - (counts - free), 1.0)
    return _Traces(
        tilts, of_middle, axes, sums, leans, spread, judged & counted[:, None], left, independent
    )


def _with_width(
    turned: FloatArray, sums: FloatArray, leans: FloatArray, counts: IntArray, starts: IntArray
) -> BoolArray:
    """(G, 2) which of its own axes tell something of how a trace's plane is turned: of a straight
    one that is no wider than it strays from the common plane, what it strays lies in the face that
    it runs over, and its width would tell the attitude of that face.

    turned : (n, 3) along the narrow and the long axis of each trace, and the normal
    """
    slope = leans[:, 1] / np.where(sums[:, 1] > 0.0, sums[:, 1], 1.0)
    rest = turned[:, 2] - np.repeat(slope, counts) * turned[:, 1]
    stray = np.add.reduceat(rest**2, starts)
    wide = (sums[:, 0] > _WIDE**2 * stray) | (sums[:, 0] > _BENT**2 * sums[:, 1])
    return np.stack([wide, sums[:, 1] > 0.0], axis=1)


def _errors_of_middles(traces: _Traces) -> list[float]:
    """95 %, of the place of each along the normal."""
    one = np.ones(1)
    return [
        _t95(one, np.array([free])) * float(np.sqrt(variance))
        for variance, free in zip(traces.of_middle, traces.free, strict=True)
    ]


def _semi_axes(traces: _Traces) -> tuple[float, float]:
    free = traces.free_tilts or _shared_free(traces)
    # Twice Fisher's F of 2 and so many: joint_quantile is that over the degrees of freedom.
    limit = float(joint_quantile(np.array([free]))[0]) * free
    small, large = np.sqrt(np.maximum(np.linalg.eigvalsh(traces.of_tilts), 0.0) * limit)
    return float(np.degrees(np.arctan(large))), float(np.degrees(np.arctan(small)))


def _shared_free(traces: _Traces) -> float:
    """Degrees of freedom of the tilts' covariance, of which each trace has its part
    (Krishnamoorthy & Yu 2004, Statistics & Probability Letters 66, 161)."""
    whole = traces.of_tilts
    if not np.linalg.det(whole) > 0.0:
        return float(traces.free.sum())
    parts = traces.tilts @ np.linalg.inv(whole)
    squares = np.einsum("gij,gji->g", parts, parts) + np.einsum("gii->g", parts) ** 2
    used = squares > 0.0
    return float(6.0 / (squares[used] / traces.free[used]).sum())


def _same(
    traces: _Traces, which: tuple[int, int], ids: tuple[str, str], apart: FloatArray
) -> SamePlane:
    """apart : (3,) from the middle of the first to that of the second, in the axes"""
    of_tilts = np.einsum("i,gij,j->g", apart[:2], traces.tilts, apart[:2])
    parts, free = of_tilts, traces.free
    if traces.free_tilts is not None:
        parts, free = np.append(0.0 * of_tilts, of_tilts.sum()), np.append(free, traces.free_tilts)
    parts[list(which)] += traces.of_middle[list(which)]
    variance, distance = float(parts.sum()), float(apart[2])
    if not variance > 0.0:
        return SamePlane(*ids, distance, 0.0, 0.0 if distance else 1.0)
    shares, frees = _pooled(parts / variance, free)
    t = abs(distance) / np.sqrt(variance)
    return SamePlane(
        *ids, distance, _t95(shares, frees) * float(np.sqrt(variance)), _tail(t, shares, frees)
    )


def _pooled(shares: FloatArray, free: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Shares of a variance and their degrees of freedom, those whose noise is known well enough as
    one (Satterthwaite 1946, Biometrics Bulletin 2, 110)."""
    used = shares > 0.0
    sure = used & (free >= _SURE)
    few = used & ~sure
    if not sure.any():
        return shares[few], free[few]
    part = float(shares[sure].sum())
    together = part**2 / float((shares[sure] ** 2 / free[sure]).sum())
    return np.append(shares[few], part), np.append(free[few], together)


def _t95(shares: FloatArray, free: FloatArray) -> float:
    """Of a figure whose variance has these shares, each known by so many degrees of freedom: the
    mean of Student's quantiles by the shares (Cochran & Cox 1957, Experimental Designs, section
    4.14). Where one is known by a single degree of freedom and happens to be small, degrees of
    freedom that are averaged by the shares are too many."""
    from scipy.special import stdtrit

    return float(shares @ stdtrit(free, 1.0 - LEVEL / 2.0))


def _tail(t: float, shares: FloatArray, free: FloatArray) -> float:
    """The p at which that mean is t, two sided."""
    from scipy.optimize import brentq
    from scipy.special import stdtr, stdtrit

    if len(free) == 1:
        return 2.0 * float(stdtr(free[0], -t))
    if t <= 0.0:
        return 1.0
    if not float(shares @ -stdtrit(free, _LEAST)) > t:
        return 2.0 * _LEAST
    # By its logarithm: p may be very small.
    low, high = np.log(_LEAST), np.log(0.5)
    return 2.0 * float(np.exp(brentq(lambda x: shares @ -stdtrit(free, np.exp(x)) - t, low, high)))


def _widened(traces: _Traces) -> tuple[_Traces, float | None]:
    """With the error of the tilt that traces show which are not quite parallel, widened by Birge's
    ratio (Birge 1932, Physical Review 40, 207); and the chance that parallel ones are turned
    against each other as far as these.

    Each trace is held against the plane that suits all best, each by its own noise: one that strays
    tilts the common plane, which is no sign that the others are turned. How far what is known of
    the noise lets the weights be off is allowed for (Johansen 1980, Biometrika 67, 85; here with
    one variance to a trace, whose axes share it).
    """
    from scipy.special import fdtrc

    judged = traces.judged & (traces.spread > 0.0)
    # Noise that one or two points more than unknowns tell is too small by chance so often that its
    # trace would outweigh all others.
    sure = judged & (traces.independent >= _SURE)[:, None]
    judged = sure if sure.sum() > 2 else judged
    number = int(judged.sum())
    if number <= 2:
        return traces, None
    weight = np.where(judged, traces.sums**2 / np.where(judged, traces.spread, 1.0), 0.0)
    own = np.where(judged, traces.leans / np.where(judged, traces.sums, 1.0), 0.0)
    weights = np.einsum("gik,gk,gjk->gij", traces.axes, weight, traces.axes)
    whole = weights.sum(axis=0)
    if not np.linalg.det(whole) > (_THIN * np.trace(whole)) ** 2:
        return traces, None
    best = np.linalg.solve(whole, np.einsum("gik,gk,gk->i", traces.axes, weight, own))
    off = own - np.einsum("gik,i->gk", traces.axes, best)
    statistic = float((weight * off**2).sum())
    shares = np.linalg.solve(whole, weights)
    rank = judged.sum(axis=1)
    once = rank - np.einsum("gii->g", shares)
    twice = rank - 2.0 * np.einsum("gii->g", shares) + np.einsum("gij,gji->g", shares, shares)
    left = number - 2.0
    some = rank > 0
    a, b = ((each[some] / traces.independent[some]).sum() for each in (twice, once**2))
    free = left * (left + 2.0) / float(2.0 * a + b)
    expected = left + 2.0 * a - 2.0 * (2.0 * a + b) / (left + 2.0)
    p = float(fdtrc(left, free, statistic / expected))
    if p >= LEVEL:
        return traces, p
    wide = replace(
        traces, tilts=traces.tilts * max(statistic / expected, 1.0), free_tilts=min(left, free)
    )
    return wide, p


def _warnings(p_parallel: float | None, known: bool) -> list[Finding]:
    warnings: list[Finding] = []
    if not known:
        warnings.append(Finding("beds.no-errors"))
    if p_parallel is not None and p_parallel < LEVEL:
        warnings.append(Finding("beds.not-parallel", p=p_parallel))
    return warnings
