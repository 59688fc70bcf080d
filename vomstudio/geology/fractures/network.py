"""A map of fracture traces in figures: what `vomstudio fractures` prints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray, ObjectArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.results import OPTIONAL
from vomstudio.geology.fractures.intervals import (
    UNKNOWN,
    Interval,
    area_dispersion,
    density_interval,
    empty_interval,
)
from vomstudio.geology.fractures.length_laws import LEAST_COMPLETE, Fit, Parameter, fit_laws
from vomstudio.geology.fractures.nodes import Mended, NodeCounts, nodes_of
from vomstudio.geology.fractures.pieces import Pieces, pieces_of
from vomstudio.geology.fractures.scanlines import (
    Crossings,
    Spacing,
    axial_mean_deg,
    crossings_of,
    spacing_of,
)
from vomstudio.geology.fractures.trace_plane import TracePlane, trace_azimuths_deg
from vomstudio.geology.fractures.windows import (
    BEYOND,
    CircleEstimates,
    IntensityAtSize,
    circle_estimates,
    directions_of,
    intensity_by_size,
    mean_by_ends,
    share_beyond,
    window_of,
)

UNASSIGNED = "unassigned"


@dataclass(frozen=True)
class Counted:
    """What a map is counted in. area : a shapely polygon, or None; circle : x, y and radius where
    the area is one; scanlines : (k,) shapely lines, or None; warnings : on how the area was drawn
    """

    area: Any = None
    circle: tuple[float, float, float] | None = None
    scanlines: ObjectArray | None = None
    warnings: tuple[Finding, ...] = ()


@dataclass(frozen=True)
class Densities:
    """P20, P20 by nodes and P21 of traces in an area with their 95 % intervals, and the dispersion:
    the variance of P21 over that of traces placed independently. None without an area."""

    P20_1_per_m2: float | None = None
    P20_95_1_per_m2: Interval = UNKNOWN
    P20_nodes_1_per_m2: float | None = None
    P20_nodes_95_1_per_m2: Interval = UNKNOWN
    P21_1_per_m: float | None = None
    P21_95_1_per_m: Interval = UNKNOWN
    dispersion: float | None = None


@dataclass(frozen=True)
class Lengths:
    """mean_m : of whole traces, corrected for the edge of the area (see `windows.mean_by_ends`),
    with its 95 % interval mean_95_m; naive_mean_m : of the pieces as they are; censored_share : of
    the pieces with an end on the edge; kaplan_meier_mean_m, kaplan_meier_median_m : of the pieces
    taken as lengths cut off by chance, the mean up to the longest; distribution, parameters and
    parameters_95 : the law with the least AIC, in an area with the likelihood of a window;
    fits : all laws; uncorrected : the same taken as lengths cut off by chance, which in a window
    makes them too long; reason : why nothing was fitted"""

    n: int
    mean_m: float | None
    mean_95_m: tuple[float | None, float | None]
    naive_mean_m: float | None
    longest_m: float | None
    censored_share: float | None
    kaplan_meier_mean_m: float | None
    kaplan_meier_median_m: float | None
    distribution: str | None
    parameters: Mapping[str, float]
    parameters_95: Mapping[str, tuple[float | None, float | None]]
    fits: tuple[Fit, ...]
    uncorrected: tuple[Fit, ...]
    reason: Finding | None


@dataclass(frozen=True)
class FractureSet:
    """n pieces; strike_deg : mean azimuth by length, 0 to 180, with its resultant; densities with
    their 95 % intervals as in `Densities`, None without an area; spacing None without a scanline"""

    name: str
    n: int
    strike_deg: float | None
    resultant: float
    length_m: float
    P20_1_per_m2: float | None
    P20_95_1_per_m2: Interval
    P21_1_per_m: float | None
    P21_95_1_per_m: Interval
    spacing: Spacing | None


@dataclass(frozen=True, repr=False)
class FractureNetwork(PrintableResult):
    """See docs/cli.md; None is what cannot be stated. P21_unclipped_1_per_m : with all that the
    traces have outside the area, which is too much; names with 95 : the 95 % intervals, lower and
    upper limit; dispersion : as in `Densities`; plane : on which three-dimensional traces were
    analysed, None for a map."""

    traces: int
    pieces: int
    area_m2: float | None
    P10_1_per_m: float | None
    P10_95_1_per_m: Interval
    P20_1_per_m2: float | None
    P20_95_1_per_m2: Interval
    P20_nodes_1_per_m2: float | None
    P20_nodes_95_1_per_m2: Interval
    P21_1_per_m: float | None
    P21_95_1_per_m: Interval
    P21_unclipped_1_per_m: float | None
    dispersion: float | None
    nodes: NodeCounts
    mended: tuple[Mended, ...]
    snap_m: float
    length: Lengths
    sets: tuple[FractureSet, ...]
    P21_by_size: tuple[IntensityAtSize, ...]
    circle: CircleEstimates | None
    scanline: Spacing | None
    scanline_m: float | None
    terzaghi_cap: float | None
    warnings: tuple[Finding, ...]
    notes: tuple[Finding, ...]
    plane: TracePlane | None = field(default=None, metadata=OPTIONAL)


@dataclass(frozen=True, eq=False)
class Mapped:
    """The figures, with the pieces they are of, for pictures. y_axis : what y of a map is; North, y
    of a local frame, or up on a picture of a face"""

    found: FractureNetwork
    counted: Counted
    pieces: Pieces
    sets: tuple[str, ...]
    set_of: IntArray
    y_axis: Literal["N", "y", "up"] = "N"


def fracture_network(
    lines: ObjectArray,
    counted: Counted | None = None,
    *,
    sets: Sequence[str] | None = None,
    snap_m: float = 0.0,
    terzaghi_cap: float | None = None,
    warnings: Sequence[Finding] = (),
    plane: TracePlane | None = None,
) -> Mapped:
    """The figures of traces (n,), shapely lines in metres, x East and y North.

    sets : (n,) the set of each trace, "" for none. plane : of three-dimensional traces, whose x and
    y are coordinates on it. Raises GeometryError where the area has no
    traces near it or no size, and for tolerances that cannot be.
    """
    import shapely

    counted = counted or Counted()
    said = [*warnings, *counted.warnings]
    _check(lines, counted)
    area = counted.area
    pieces = pieces_of(lines, area, snap_m)
    nodes = nodes_of(pieces, snap_m, area)
    said += _noticed(lines, pieces, nodes.overlaps, nodes.counts.other)
    crossings = None
    if counted.scanlines is not None:
        crossings = crossings_of(lines, counted.scanlines, terzaghi_cap)
        if not len(crossings.trace):
            said.append(Finding("fractures.scanline-without-traces"))
        if crossings.capped:
            said.append(
                Finding("fractures.weights-capped", count=crossings.capped, maximum=terzaghi_cap)
            )
    names, set_of = _set_rows(sets, len(lines))
    size = None if area is None else float(shapely.area(area))
    everywhere = np.ones(len(crossings.trace), np.bool_) if crossings is not None else None
    whole = spacing_of(crossings, everywhere, terzaghi_cap) if crossings is not None else None  # type: ignore[arg-type]
    densities = densities_of(pieces, np.ones(len(pieces), np.bool_), area)
    found = FractureNetwork(
        traces=len(lines),
        pieces=len(pieces),
        area_m2=size,
        P10_1_per_m=None if whole is None else whole.P10_1_per_m,
        P10_95_1_per_m=UNKNOWN if whole is None else whole.P10_95_1_per_m,
        P20_1_per_m2=densities.P20_1_per_m2,
        P20_95_1_per_m2=densities.P20_95_1_per_m2,
        P20_nodes_1_per_m2=None if size is None else (nodes.counts.I + nodes.counts.Y) / 2 / size,
        P20_nodes_95_1_per_m2=densities.P20_nodes_95_1_per_m2,
        P21_1_per_m=densities.P21_1_per_m,
        P21_95_1_per_m=densities.P21_95_1_per_m,
        P21_unclipped_1_per_m=None if size is None else float(shapely.length(lines).sum()) / size,
        dispersion=densities.dispersion,
        nodes=nodes.counts,
        mended=nodes.mended,
        snap_m=snap_m,
        length=length_figures(pieces, area),
        sets=_sets(names, set_of, pieces, area, crossings, terzaghi_cap, plane),
        P21_by_size=() if area is None else intensity_by_size(pieces, area),
        circle=None if counted.circle is None else circle_estimates(pieces, counted.circle[2]),
        scanline=whole,
        scanline_m=None if crossings is None else crossings.length_m,
        terzaghi_cap=terzaghi_cap,
        warnings=tuple(said),
        notes=(
            Finding("fractures.one-face"),
            *_beyond(lines, area),
        ),
        plane=plane,
    )
    return Mapped(found, counted, pieces, names, set_of[pieces.trace])


def _beyond(lines: ObjectArray, area: Any) -> list[Finding]:
    """A word where much of the area may not have been mapped."""
    share = 0.0 if area is None else share_beyond(lines, area)
    if share <= BEYOND:
        return []
    return [Finding("fractures.area-beyond-traces", share_percent=100.0 * share)]


def length_figures(pieces: Pieces, area: Any = None) -> Lengths:
    """How long whole traces are, by their pieces in an area (None: nothing is cut off)."""
    lengths, cut = pieces.lengths(), pieces.cut.sum(axis=1)
    n = len(lengths)
    if not n:
        reason_empty = Finding("fractures.no-traces")
        return Lengths(0, None, (None, None), *(None,) * 6, {}, {}, (), (), reason_empty)
    window = None if area is None or not cut.any() else window_of(pieces, area)
    uncorrected = fit_laws(lengths, cut)
    fits = uncorrected if window is None else fit_laws(lengths, cut, window)
    mean = mean_by_ends(lengths, cut.astype(np.float64))
    km_mean, km_median = kaplan_meier(lengths, cut > 0)
    best = fits[0] if fits else None
    reason = None
    if best is None:
        reason = Finding("fractures.few-lengths", minimum=LEAST_COMPLETE)
    return Lengths(
        n=n,
        mean_m=mean.value if mean else None,
        mean_95_m=_ends_of(mean) if mean else (None, None),
        naive_mean_m=float(lengths.mean()),
        longest_m=float(lengths.max()),
        censored_share=float((cut > 0).mean()),
        kaplan_meier_mean_m=km_mean,
        kaplan_meier_median_m=km_median,
        distribution=best.distribution if best else None,
        parameters={k: p.value for k, p in best.parameters.items()} if best else {},
        parameters_95={k: _ends_of(p) for k, p in best.parameters.items()} if best else {},
        fits=tuple(fits),
        uncorrected=tuple(uncorrected) if window is not None else (),
        reason=reason,
    )


def kaplan_meier(lengths: FloatArray, censored: BoolArray) -> tuple[float | None, float | None]:
    """Mean (up to the longest length) and median by Kaplan & Meier (1958); None where more than
    half is cut off before the median, or nothing was seen whole."""
    from scipy.stats import CensoredData, ecdf

    if censored.all():
        return None, None
    found = ecdf(CensoredData.right_censored(lengths, censored)).sf
    steps = np.concatenate([[0.0], found.quantiles])
    held = np.concatenate([[1.0], found.probabilities])
    mean = float(np.sum(np.diff(steps) * held[:-1]))
    below = np.flatnonzero(found.probabilities <= 0.5)
    return mean, float(found.quantiles[below[0]]) if len(below) else None


def _ends_of(parameter: Parameter) -> tuple[float | None, float | None]:
    return parameter.low, parameter.high


def _check(lines: ObjectArray, counted: Counted) -> None:
    import shapely

    if counted.scanlines is not None and not float(shapely.length(counted.scanlines).sum()) > 0:
        raise GeometryError(Finding("fractures.scanline-without-length"), field="--scanline")
    if counted.area is None:
        return
    if not shapely.area(counted.area) > 0:
        raise GeometryError(Finding("fractures.area-without-size"))
    if not shapely.intersects(shapely.box(*shapely.total_bounds(lines)), counted.area):
        raise GeometryError(Finding("fractures.area-elsewhere"))


def _noticed(lines: ObjectArray, pieces: Pieces, overlaps: int, others: int) -> list[Finding]:
    import shapely

    said = []
    if not len(pieces):
        said.append(Finding("fractures.no-traces"))
    selfish = np.flatnonzero(~shapely.is_simple(lines))
    if len(selfish):
        said.append(
            Finding("fractures.self-crossing", count=len(selfish), rows=(selfish + 1).tolist())
        )
    if overlaps:
        said.append(Finding("fractures.overlaps", count=overlaps))
    if others:
        said.append(Finding("fractures.other-nodes", count=others))
    return said


def densities_of(pieces: Pieces, members: BoolArray, area: Any) -> Densities:
    """Return the densities over an area of those pieces (n,) that are members of a set."""
    import shapely

    if area is None:
        return Densities()
    size = float(shapely.area(area))
    lengths = pieces.lengths()[members]
    ends = 2.0 - pieces.cut[members].sum(axis=1)
    if not len(lengths):
        none = empty_interval(size)
        return Densities(0.0, none, 0.0, none, 0.0, (0.0, None), 1.0)
    rows = np.unique(pieces.trace[members], return_inverse=True)[1]
    middles = shapely.get_coordinates(shapely.centroid(pieces.lines[members]))
    # Pieces of one trace belong together; it lies where its mean piece does.
    places = np.stack([np.bincount(rows, xy) for xy in middles.T], axis=-1).astype(np.float64)
    places /= np.bincount(rows)[:, None]

    def density(weights: FloatArray) -> tuple[float, Interval, float]:
        of_traces = np.bincount(rows, weights).astype(np.float64)
        dispersion = area_dispersion(places, of_traces, area)
        interval = density_interval(of_traces, size, dispersion)
        return float(weights.sum()) / size, interval, dispersion

    number, number_95, _ = density(np.ones(len(lengths)))
    by_ends, by_ends_95, _ = density(ends / 2.0)
    intensity, intensity_95, dispersion = density(lengths)
    return Densities(number, number_95, by_ends, by_ends_95, intensity, intensity_95, dispersion)


def _set_rows(sets: Sequence[str] | None, n: int) -> tuple[tuple[str, ...], IntArray]:
    """Names in order of appearance, those without a set last, and the set of each trace."""
    if sets is None:
        return ("all",), np.zeros(n, np.int64)
    named = [name or UNASSIGNED for name in sets]
    names = list(dict.fromkeys(named))
    if UNASSIGNED in names:
        names.remove(UNASSIGNED)
        names.append(UNASSIGNED)
    row = {name: i for i, name in enumerate(names)}
    return tuple(names), np.array([row[name] for name in named], np.int64)


def _sets(
    names: tuple[str, ...],
    set_of: IntArray,
    pieces: Pieces,
    area: Any,
    crossings: Crossings | None,
    cap: float | None,
    plane: TracePlane | None,
) -> tuple[FractureSet, ...]:
    azimuth, lengths = trace_azimuths_deg(directions_of(pieces), plane), pieces.lengths()
    own = set_of[pieces.trace]
    found = []
    for i, name in enumerate(names):
        mine = own == i
        strike, resultant = axial_mean_deg(azimuth[mine], lengths[mine])
        spacing = None
        if crossings is not None:
            spacing = spacing_of(crossings, set_of[crossings.trace] == i, cap)
        densities = densities_of(pieces, mine, area)
        found.append(
            FractureSet(
                name=name,
                n=int(mine.sum()),
                strike_deg=strike,
                resultant=resultant,
                length_m=float(lengths[mine].sum()),
                P20_1_per_m2=densities.P20_1_per_m2,
                P20_95_1_per_m2=densities.P20_95_1_per_m2,
                P21_1_per_m=densities.P21_1_per_m,
                P21_95_1_per_m=densities.P21_95_1_per_m,
                spacing=spacing,
            )
        )
    return tuple(found)
