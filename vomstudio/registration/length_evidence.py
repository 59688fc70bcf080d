"""Lengths measured on a model, and a fixed scale, as observations."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.io.control.observation_tables import Pairs, ScaleBar
from vomstudio.registration.compass_evidence import Segment
from vomstudio.registration.marks.mark_checks import most_similar_name
from vomstudio.registration.observations import FixedScale, Lengths, ObservationKind, Points
from vomstudio.registration.similarity import fit_similarity

_DEFAULT_ERROR = 0.005
"""Default relative one-sigma error of a taped length whose ends are picked on a model."""
_SIGNIFICANCE = 0.001
_MAX_LISTED = 8
# Number of units per metre and name of each unit; relative tolerance of a length in these units.
_UNITS = ((1 / 0.3048, "feet"), (100.0, "centimetres"), (1000.0, "millimetres"), (39.37, "inches"))
_UNIT_TOLERANCE = 0.01
FIXED_SCALE_ERROR = 1e-4
"""Relative one-sigma error of a fixed scale, in addition to its stated error."""
# Relative error used in the fit, which does not change the scale.
_FIT_SCALE_ERROR = 1e-9


def length_observations(
    bars: Sequence[ScaleBar],
    segments: Sequence[Segment],
    pairs: Pairs | None,
    *,
    click_error_m: float = 0.0,
    click_error: float = 0.0,
) -> list[Lengths]:
    """Convert scale bars and measured lengths to observations.

    Scale bars with check points are omitted.

    Parameters
    ----------
    bars : sequence of ScaleBar
    segments : sequence of Segment
    pairs : Pairs or None
    click_error_m, click_error : float
        Errors of each coordinate of a click on the model, in metres and in the unit of the model,
        which are added to stated errors. Default errors already include them.

    Raises
    ------
    UsageError
        If a point of a scale bar is missing, or both ends of a length coincide.
    """
    labels, first_ends, second_ends, length, sigma = [], [], [], [], []
    positions = {} if pairs is None else dict(zip(pairs.labels, pairs.model, strict=True))
    is_clicked = {} if pairs is None else dict(zip(pairs.labels, pairs.is_clicked, strict=True))
    click_counts = list[int]()
    for bar in bars:
        for label in (bar.first, bar.second):
            if label not in positions:
                similar_names = most_similar_name(label, list(positions))
                raise UsageError(
                    Finding(
                        "length.unknown-point",
                        label=label if similar_names is None else f"{label} ({similar_names}?)",
                    ),
                    file=bar.file,
                    line=bar.line,
                    field="--scale-bars",
                )
        if bar.check:
            continue
        labels.append(f"{bar.first} - {bar.second}")
        click_counts.append(int(is_clicked[bar.first]) + int(is_clicked[bar.second]))
        first_ends.append(positions[bar.first])
        second_ends.append(positions[bar.second])
        length.append(bar.length_m)
        sigma.append(np.nan if bar.sigma_m is None else bar.sigma_m)
    for line_number, line in enumerate(segments, 1):
        labels.append(line.label or tr("length {number}", number=line_number))
        first_ends.append(np.asarray(line.first))
        second_ends.append(np.asarray(line.second))
        length.append(line.value)
        click_counts.append(0 if line.sigma is None else 2)
        sigma.append(_DEFAULT_ERROR * line.value if line.sigma is None else line.sigma)
    if not labels:
        return []
    ends = np.array(first_ends, np.float64), np.array(second_ends, np.float64)
    is_short = ~(np.linalg.norm(ends[1] - ends[0], axis=1) > 0)
    if is_short.any():
        line_number = int(np.argmax(is_short))
        used_bars = [bar for bar in bars if not bar.check]
        position = used_bars[line_number] if line_number < len(used_bars) else None
        raise UsageError(
            Finding("line.one-place"),
            file=None if position is None else position.file,
            line=None if position is None else position.line,
            field="--scale" if position is None else "--scale-bars",
        )
    click_factors = np.sqrt(click_counts)
    return [
        Lengths(
            labels,
            *ends,
            np.array(length),
            np.array(sigma),
            click_error_m=click_factors * click_error_m if click_error_m else None,
            click_error=click_factors * click_error if click_error else None,
        )
    ]


def fixed_scale(
    scale: float,
    kinds: Sequence[ObservationKind],
    extent: FloatArray | None,
    scale_error: float | None = None,
) -> list[FixedScale]:
    """Convert a fixed scale to a length across the model.

    The fit does not change it; its error is added to the covariance of the fit.

    Parameters
    ----------
    scale : float
        Metres per unit of the model.
    kinds : sequence of ObservationKind
    extent : (n, 3) array or None
        Points of the model. If None, the points among `kinds` are used.
    scale_error : float, optional
        Relative one-sigma error of the scale.
    """
    positions = [] if extent is None or not len(extent) else [extent]
    positions = positions or [kind.model for kind in kinds if isinstance(kind, Points)]
    centre, size = np.zeros(3), 1.0
    if positions:
        all_positions = np.concatenate(positions)
        centre = all_positions.mean(axis=0)
        size = float(np.linalg.norm(np.ptp(all_positions, axis=0))) or 1.0
    end = centre + [size, 0.0, 0.0]
    # The scale is uniform, so any length can be used.
    length = np.array([scale * size])
    label = tr("the fixed scale")
    error = float(np.hypot(FIXED_SCALE_ERROR, scale_error or 0.0))
    return [
        FixedScale(
            [label], centre[None], end[None], length, _FIT_SCALE_ERROR * length, scale_error=error
        )
    ]


def length_findings(
    bars: Sequence[ScaleBar],
    segments: Sequence[Segment],
    pairs: Pairs | None,
    excluded_labels: Collection[str] = (),
) -> list[Finding]:
    """Return findings about lengths that contradict the control points.

    Parameters
    ----------
    bars : sequence of ScaleBar
    segments : sequence of Segment
        Lengths given by two points.
    pairs : Pairs or None
        Control points.
    excluded_labels : collection of str, optional
        Labels of points and lengths that are excluded or reported elsewhere.

    Returns
    -------
    list of Finding
    """
    if pairs is None or not (bars or segments):
        return []
    is_known = (
        np.array([label not in excluded_labels for label in pairs.labels], bool) & ~pairs.check
    )
    points_fit = _estimate_point_scale(
        pairs.model[is_known], pairs.world[is_known], pairs.sigma[is_known]
    )
    if points_fit is None:
        return []
    scale, scale_error, sigma, error_factor = points_fit
    positions = dict(zip(pairs.labels, pairs.model, strict=True))
    wrong_lengths: list[Finding] = []
    units: dict[str, list[str]] = {}
    lengths = [
        (
            f"{bar.first} - {bar.second}",
            positions[bar.first],
            positions[bar.second],
            bar.length_m,
            bar.sigma_m,
            bar.check,
        )
        for bar in bars
    ]
    for line_number, line in enumerate(segments, 1):
        label = line.label or tr("length {number}", number=line_number)
        ends = np.asarray(line.first), np.asarray(line.second)
        lengths.append((label, *ends, line.value, line.sigma, False))
    for label, first_end, second_end, stated_length, length_sigma, check in lengths:
        length_by_points = scale * float(np.linalg.norm(second_end - first_end))
        length_sigma = _DEFAULT_ERROR * length_by_points if length_sigma is None else length_sigma
        error = error_factor(len(lengths)) * float(
            np.sqrt((scale_error * length_by_points) ** 2 + 2.0 * sigma**2 + length_sigma**2)
        )
        if not abs(stated_length - length_by_points) > error or not length_by_points > 0:
            continue
        unit = _unit(stated_length / length_by_points, error / length_by_points)
        if unit is not None:
            units.setdefault(unit, []).append(label)
        elif not check and label not in excluded_labels:
            wrong_lengths.append(
                Finding(
                    "length.contradicted",
                    label=label,
                    stated_m=stated_length,
                    by_points_m=length_by_points,
                    error_m=error,
                )
            )
    findings = [
        Finding("length.other-unit", labels=labels, unit=tr(unit)) for unit, labels in units.items()
    ]
    return [*findings, *wrong_lengths[:_MAX_LISTED]]


def _estimate_point_scale(
    model: FloatArray, world: FloatArray, stated_sigmas: FloatArray
) -> tuple[float, float, float, Callable[[int], float]] | None:
    """Estimate the scale from the points alone, or return None if they do not determine it.

    Returns
    -------
    scale : float
        Metres per unit of the model.
    error : float
        Relative error of the scale, one sigma.
    sigma : float
        One-sigma error of a coordinate, metres.
    times : callable
        Returns the significance limit, in sigmas, for a number of lengths.
    """
    from scipy.stats import norm, t

    n = len(model)
    try:
        fit = fit_similarity(model, world)
    except GeometryError:
        return None
    dof = 3 * n - 7
    residual_sigma = float(np.sqrt(((fit(model) - world) ** 2).sum() / dof))
    has_stated_errors = bool(n) and bool(np.isfinite(stated_sigmas).all())
    sigma = (
        max(residual_sigma, float(np.sqrt((stated_sigmas**2).mean())))
        if has_stated_errors
        else residual_sigma
    )
    size = float(np.linalg.norm(world - world.mean(axis=0)))

    def significance_limit(count: int) -> float:
        probability = 1.0 - _SIGNIFICANCE / 2.0 / count
        return float(norm.ppf(probability) if has_stated_errors else t.ppf(probability, dof))

    return fit.scale, sigma / size, sigma, significance_limit


def _unit(ratio: float, error: float) -> str | None:
    """Return the unit that explains a length that is too long by the given ratio, or None."""
    for times, unit in _UNITS:
        if abs(ratio / times - 1.0) < max(_UNIT_TOLERANCE, min(error, 0.1)):
            return unit
    return None
