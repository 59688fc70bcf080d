"""Lengths that were measured on a model, and a scale that is known beforehand, as observations of
its place."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.io.control.observation_tables import Pairs, ScaleBar
from vomstudio.registration.compass_evidence import Segment
from vomstudio.registration.marks.mark_checks import nearest
from vomstudio.registration.observations import KeptScale, Lengths, Observed, Points
from vomstudio.registration.similarity import fit_similarity

_TAPE = 0.005
"""One sigma of a length by tape whose ends are picked on a model, as a share of it."""
_BY_CHANCE = 0.001
_NAMED = 8
# How many of each make a metre, and how near to that a length must be.
_UNITS = ((1 / 0.3048, "feet"), (100.0, "centimetres"), (1000.0, "millimetres"), (39.37, "inches"))
_SAME_UNIT = 0.01
KEPT = 1e-4
"""One sigma of a scale that is kept, as a share of it, beside what is stated of it."""
# The same in the fit, which does not change the scale.
_FIXED = 1e-9


def lengths_of(
    bars: Sequence[ScaleBar],
    segments: Sequence[Segment],
    pairs: Pairs | None,
    *,
    click_m: float = 0.0,
    click: float = 0.0,
) -> list[Lengths]:
    """Scale bars between points of `pairs` that are no checks, and lengths between two places.

    click_m, click : error of each coordinate of a click on the model, in metres and in its unit,
    which are added to each other. They count beside stated errors: the usual error of a tape
    contains them.
    Raises UsageError for a bar between points that are not there, and for two ends at one place."""
    labels, first, second, length, sigma = [], [], [], [], []
    places = {} if pairs is None else dict(zip(pairs.labels, pairs.model, strict=True))
    is_clicked = {} if pairs is None else dict(zip(pairs.labels, pairs.is_clicked, strict=True))
    clicks = list[int]()
    for bar in bars:
        for label in (bar.first, bar.second):
            if label not in places:
                near = nearest(label, list(places))
                raise UsageError(
                    Finding(
                        "length.unknown-point",
                        label=label if near is None else f"{label} ({near}?)",
                    ),
                    file=bar.file,
                    line=bar.line,
                    field="--scale-bars",
                )
        if bar.check:
            continue
        labels.append(f"{bar.first} - {bar.second}")
        clicks.append(int(is_clicked[bar.first]) + int(is_clicked[bar.second]))
        first.append(places[bar.first])
        second.append(places[bar.second])
        length.append(bar.length_m)
        sigma.append(np.nan if bar.sigma_m is None else bar.sigma_m)
    for number, line in enumerate(segments, 1):
        labels.append(line.label or tr("length {number}", number=number))
        first.append(np.asarray(line.first))
        second.append(np.asarray(line.second))
        length.append(line.value)
        clicks.append(0 if line.sigma is None else 2)
        sigma.append(_TAPE * line.value if line.sigma is None else line.sigma)
    if not labels:
        return []
    ends = np.array(first, np.float64), np.array(second, np.float64)
    short = ~(np.linalg.norm(ends[1] - ends[0], axis=1) > 0)
    if short.any():
        number = int(np.argmax(short))
        used = [bar for bar in bars if not bar.check]
        at = used[number] if number < len(used) else None
        raise UsageError(
            Finding("line.one-place"),
            file=None if at is None else at.file,
            line=None if at is None else at.line,
            field="--scale" if at is None else "--scale-bars",
        )
    both = np.sqrt(clicks)
    return [
        Lengths(
            labels,
            *ends,
            np.array(length),
            np.array(sigma),
            click_m=both * click_m if click_m else None,
            click=both * click if click else None,
        )
    ]


def kept_scale(
    scale: float,
    kinds: Sequence[Observed],
    extent: FloatArray | None,
    scale_error: float | None = None,
) -> list[KeptScale]:
    """Return a known scale, in metres per unit of the model, as a length across the model.

    The fit does not change it; its error is added to the covariance of the fit.

    extent : (n, 3) points of the model, None to take the points among `kinds`
    scale_error : relative error of the scale, one sigma; None if not known
    """
    places = [] if extent is None or not len(extent) else [extent]
    places = places or [kind.model for kind in kinds if isinstance(kind, Points)]
    middle, size = np.zeros(3), 1.0
    if places:
        every = np.concatenate(places)
        middle = every.mean(axis=0)
        size = float(np.linalg.norm(np.ptp(every, axis=0))) or 1.0
    end = middle + [size, 0.0, 0.0]
    # The scale is uniform, so any length does.
    length = np.array([scale * size])
    label = tr("the scale that is kept")
    error = float(np.hypot(KEPT, scale_error or 0.0))
    return [KeptScale([label], middle[None], end[None], length, _FIXED * length, scale_error=error)]


def length_findings(
    bars: Sequence[ScaleBar],
    segments: Sequence[Segment],
    pairs: Pairs | None,
    apart: Collection[str] = (),
) -> list[Finding]:
    """Of lengths that are not those which the control points alone give, beyond the errors of
    both. apart : labels of points and lengths that are left out, or named otherwise"""
    if pairs is None or not (bars or segments):
        return []
    known = np.array([label not in apart for label in pairs.labels], bool) & ~pairs.check
    judged = _points_alone(pairs.model[known], pairs.world[known], pairs.sigma[known])
    if judged is None:
        return []
    scale, scale_error, sigma, times = judged
    places = dict(zip(pairs.labels, pairs.model, strict=True))
    wrong: list[Finding] = []
    units: dict[str, list[str]] = {}
    lengths = [
        (
            f"{b.first} - {b.second}",
            places[b.first],
            places[b.second],
            b.length_m,
            b.sigma_m,
            b.check,
        )
        for b in bars
    ]
    for number, line in enumerate(segments, 1):
        label = line.label or tr("length {number}", number=number)
        ends = np.asarray(line.first), np.asarray(line.second)
        lengths.append((label, *ends, line.value, line.sigma, False))
    for label, first, second, stated, own, check in lengths:
        by_points = scale * float(np.linalg.norm(second - first))
        own = _TAPE * by_points if own is None else own
        error = times(len(lengths)) * float(
            np.sqrt((scale_error * by_points) ** 2 + 2.0 * sigma**2 + own**2)
        )
        if not abs(stated - by_points) > error or not by_points > 0:
            continue
        unit = _unit(stated / by_points, error / by_points)
        if unit is not None:
            units.setdefault(unit, []).append(label)
        elif not check and label not in apart:
            wrong.append(
                Finding(
                    "length.contradicted",
                    label=label,
                    stated_m=stated,
                    by_points_m=by_points,
                    error_m=error,
                )
            )
    findings = [
        Finding("length.other-unit", labels=labels, unit=tr(unit)) for unit, labels in units.items()
    ]
    return [*findings, *wrong[:_NAMED]]


def _points_alone(
    model: FloatArray, world: FloatArray, stated: FloatArray
) -> tuple[float, float, float, Callable[[int], float]] | None:
    """Metres per unit of the model by the points, its error (a share of it), that of a coordinate
    (one sigma each), and how many of them are not exceeded by chance by one of several lengths.
    None where the points do not tell the scale."""
    from scipy.stats import norm, t

    n = len(model)
    try:
        fit = fit_similarity(model, world)
    except GeometryError:
        return None
    free = 3 * n - 7
    left = float(np.sqrt(((fit(model) - world) ** 2).sum() / free))
    known = bool(n) and bool(np.isfinite(stated).all())
    sigma = max(left, float(np.sqrt((stated**2).mean()))) if known else left
    size = float(np.linalg.norm(world - world.mean(axis=0)))

    def times(count: int) -> float:
        chance = 1.0 - _BY_CHANCE / 2.0 / count
        return float(norm.ppf(chance) if known else t.ppf(chance, free))

    return fit.scale, sigma / size, sigma, times


def _unit(ratio: float, error: float) -> str | None:
    """What a length that is so many times too long is counted in."""
    for times, unit in _UNITS:
        if abs(ratio / times - 1.0) < max(_SAME_UNIT, min(error, 0.1)):
            return unit
    return None
