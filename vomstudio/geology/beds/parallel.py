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

from vomstudio.errors import GeometryError
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.plane_errors import joint_quantile, quantiles
from vomstudio.words import tr

Floats = npt.NDArray[np.float64]

FEWEST = 3
"""Points of a trace whose scatter counts."""
LEVEL = 0.05
_THIN = 1e-6
"""Relative spread across the traces under which all points lie on one line."""


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
    warnings: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class _Traces:
    """G traces in the axes of the common plane. tilt : (2, 2) covariance of the normal's tilts
    along them; of_middle : (G,) variance of its place along the normal;
    leans, spread : (G, 2) and (G, 2, 2) what each says of a tilt of its own and the covariance of
    that; sums : (G, 2, 2) scatter in the plane; free : degrees of freedom of all, each"""

    tilt: Floats
    of_middle: Floats
    leans: Floats
    spread: Floats
    sums: Floats
    free: Floats


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
        raise GeometryError(tr("Parallel planes need at least two traces."))
    if (counts < 1).any():
        raise GeometryError(tr("A trace without points cannot be fitted."))
    starts = offsets[:-1]
    middles = np.add.reduceat(points, starts, axis=0) / counts[:, None]
    own = points - np.repeat(middles, counts, axis=0)
    values, axes = np.linalg.eigh(own.T @ own / len(own))
    if not values[1] > _THIN * values[2]:
        raise GeometryError(
            tr(
                "The traces are straight and run the same way: together they determine no plane. "
                "Add one that runs another way."
            )
        )
    basis = axes[:, [2, 1, 0]]
    if basis[2, 2] < 0.0:
        basis = -basis
    flat = own @ basis
    traces, p_parallel = _widened(_errors(flat, counts, starts, ordered), counts)
    normal = basis[:, 2]
    along = (middles - points.mean(axis=0)) @ normal
    error = _t95(float(traces.free.sum())) * np.sqrt(traces.of_middle)
    known = bool(np.isfinite(traces.tilt).all())
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


def _errors(flat: Floats, counts: npt.NDArray[np.int64], starts: Floats, ordered: bool) -> _Traces:
    """flat : (n, 3) points about their own middles, in the axes of the common plane"""
    groups = len(counts)
    sums, leans = np.zeros((groups, 2, 2)), np.zeros((groups, 2))
    own_axes, own_values = np.zeros((groups, 2, 2)), np.zeros((groups, 2))
    turned = np.empty_like(flat)
    squares, best = np.zeros(groups), np.zeros(groups)
    for i, (first, n) in enumerate(zip(starts, counts, strict=True)):
        part = flat[first : first + n]
        sums[i] = part[:, :2].T @ part[:, :2]
        leans[i] = part[:, :2].T @ part[:, 2]
        own_values[i], own_axes[i] = np.linalg.eigh(sums[i])
        turned[first : first + n, :2] = part[:, :2] @ own_axes[i]
        squares[i] = float(part[:, 2] @ part[:, 2])
        # What a plane of its own would leave.
        tilt = np.linalg.lstsq(part[:, :2], part[:, 2], rcond=1e-9)[0]
        rest = part[:, 2] - part[:, :2] @ tilt
        turned[first : first + n, 2] = rest
        best[i] = float(rest @ rest)
    free = np.maximum(counts - 3.0, 0.0)
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
    weight = own_axes * (inflation * own_values)[:, None, :]
    spread = noise[:, None, None] * (weight @ np.swapaxes(own_axes, 1, 2))
    whole = np.linalg.inv(sums.sum(axis=0))
    tilt = whole @ spread.sum(axis=0) @ whole
    left = np.where(counted, np.maximum(effective - 3.0, 0.5), 0.0)
    return _Traces(tilt, of_middle, leans, spread, sums, left)


def _semi_axes(traces: _Traces) -> tuple[float, float]:
    free = float(traces.free.sum())
    # Twice Fisher's F of 2 and so many: joint_quantile is that over the degrees of freedom.
    limit = float(joint_quantile(np.array([free]))[0]) * free
    small, large = np.sqrt(np.maximum(np.linalg.eigvalsh(traces.tilt), 0.0) * limit)
    return float(np.degrees(np.arctan(large))), float(np.degrees(np.arctan(small)))


def _same(
    traces: _Traces, which: tuple[int, int], ids: tuple[str, str], apart: Floats
) -> SamePlane:
    """apart : (3,) from the middle of the first to that of the second, in the axes"""
    from scipy.special import stdtr

    variance = float(traces.of_middle[list(which)].sum() + apart[:2] @ traces.tilt @ apart[:2])
    free = float(traces.free.sum())
    distance = float(apart[2])
    t = abs(distance) / np.sqrt(variance) if variance > 0.0 else np.inf
    p = 2.0 * float(stdtr(free, -t))
    return SamePlane(*ids, distance, _t95(free) * float(np.sqrt(variance)), p)


def _widened(traces: _Traces, counts: npt.NDArray[np.int64]) -> tuple[_Traces, float | None]:
    """With the error of the tilt that traces show which are not quite parallel, widened by Birge's
    ratio (Birge 1932, Physical Review 40, 207); and the chance that parallel ones lean out of the
    common plane as far as these."""
    from scipy.special import fdtrc

    judged = counts > FEWEST
    if judged.sum() < 2:
        return traces, None
    number, statistic = 0, 0.0
    for lean, spread in zip(traces.leans[judged], traces.spread[judged], strict=True):
        values, axes = np.linalg.eigh(spread)
        sure = values > 1e-12 * max(float(values[1]), 1e-300)
        statistic += float((((lean @ axes)[sure]) ** 2 / values[sure]).sum())
        number += int(sure.sum())
    if number <= 2:
        return traces, None
    left, free = number - 2.0, float(traces.free.sum())
    ratio = statistic / left
    p = float(fdtrc(left, free, ratio))
    if p >= LEVEL:
        return traces, p
    kept = traces.free * min(1.0, left / free)
    return replace(traces, tilt=traces.tilt * ratio, free=kept), p


def _t95(free: float) -> float:
    from scipy.special import stdtrit

    return float(stdtrit(free, 1.0 - LEVEL / 2.0))


def _warnings(p_parallel: float | None, known: bool) -> list[str]:
    said = []
    if not known:
        said.append(
            tr("No trace has more than three points, so that the errors are unknown. Add points.")
        )
    if p_parallel is not None and p_parallel < LEVEL:
        said.append(
            tr(
                "The traces are turned against each other more than their noise allows (p = "
                "{p:.2g}): the beds wave, or are not parallel. Their common plane is a mean, and "
                "its error was widened by as much as they differ.",
                p=p_parallel,
            )
        )
    return said
