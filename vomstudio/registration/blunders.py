"""Detection of observations whose residuals are too large to be due to chance.

Each observation is left out in turn, and its residual from the fit of the others is compared with
their error (deletion residual; Baarda 1968; Cook & Weisberg 1982, Residuals and Influence in
Regression, 2.2.2). The worst observation is removed repeatedly as long as it is significant,
because one mistake may hide another.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from difflib import get_close_matches
from typing import Any

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.registration.adjustment import EQUAL_FIT_COST, Adjustment, adjust, weighted_rows
from vomstudio.registration.compass_checks import find_azimuth_correction
from vomstudio.registration.observations import (
    Azimuths,
    Directions,
    FixedScale,
    LevelLines,
    ObservationKind,
    PhotoUpright,
    PlumbLines,
    Points,
    Verticals,
)
from vomstudio.registration.similarity import Similarity, fit_robustly, fit_similarity
from vomstudio.registration.similarity_observation import SimilarityObservation

# Share of the model size, or rad, below which residuals are rounding errors.
_ROUNDING = 1e-9
# Significance of the test of a complete set of observations.
_SIGNIFICANCE = 0.001
# Numbers of points from which a robust fit is tried, and minimum ratio of variances. Four of six
# points agree better than all six by this ratio by chance in less than one of two thousand sets (15
# subsets, redundancy 5).
_MIN_POINTS_ROBUST, _MIN_POINTS_SUBSET, _MIN_VARIANCE_RATIO = 7, 6, 100.0
# Numbers of directions that are left out one by one: fewer directions cannot reveal an error, and
# more directions reveal it in their residuals.
_MIN_DIRECTIONS, _MAX_DIRECTIONS = 4, 12
# Default error of a reading, and its weight in the pooled variance as a number of residuals. Four
# planes alone could not reveal that one of them is wrong.
_DEFAULT_ERROR_RAD, _DEFAULT_ERROR_WEIGHT = np.radians(3.0), 4.0
_AZIMUTH_LIMITS_DEG = (10.0, 20.0)
_DIRECTIONS = Directions | Azimuths | LevelLines | PlumbLines | PhotoUpright | Verticals
# Ratio of residuals to default errors from which directions are tested.
_MIN_MISFIT = 1.5


@dataclass(frozen=True)
class Blunder:
    """Observation that is inconsistent with all others.

    Attributes
    ----------
    label : str
        Label of the point or direction.
    photo : str or None
        Photo of the mark, or None if the observation is not a mark in a photo.
    error_m : float or None
        Distance from the position given by the other observations, metres.
    error_deg : float or None
        Angle to the direction given by the other observations, degrees.
    """

    label: str
    photo: str | None
    error_m: float | None
    error_deg: float | None = None

    def text(self) -> str:
        """Return the label, followed by the error if it is known."""
        if self.error_m is not None:
            return f"{self.label} ({self.error_m:.3g} m)"
        return self.label if self.error_deg is None else f"{self.label} ({self.error_deg:.2g}°)"


ObservationIndex = tuple[int, int]
"""Index of a kind of observations, and row within this kind."""


@dataclass(frozen=True)
class _TestResult:
    """Test of one observation.

    Attributes
    ----------
    p_value : float
        p-value of the residual.
    statistic : float
        F ratio.
    observation_count : int
        Number of tested observations.
    """

    observation_index: ObservationIndex
    p_value: float
    statistic: float
    observation_count: int
    blunder: Blunder


@dataclass(frozen=True)
class LeaveOneOut:
    """Placement without one of a few directions.

    Attributes
    ----------
    error_deg : float
        Angle between the direction and its prediction from the other directions.
    turned_deg : float
        Rotation of the model relative to the placement by all directions.
    others_deg : float
        RMS residual of the other directions.
    weakest_95_deg : float or None
        95 % error about the weakest axis, or None if unknown.
    suspect : bool
        Whether the error is too large to be due to chance.
    azimuth_off_deg : float or None
        Correction that makes a suspect azimuth agree with the others, or None if neither 90 nor 180
        degrees does.
    """

    label: str
    error_deg: float
    turned_deg: float
    others_deg: float
    weakest_95_deg: float | None
    suspect: bool
    azimuth_off_deg: float | None = None


def find_blunders(
    kinds: Sequence[ObservationKind], overall_fit: Adjustment, centre: FloatArray, size: float
) -> list[Blunder]:
    """Find observations that are inconsistent with the others, worst first.

    At most a third of the observations is returned, because with more blunders it is unclear which
    observations are correct. One mistake makes other observations look wrong. Every blunder is
    therefore tested again without the other blunders, and cleared if it fits.

    Parameters
    ----------
    kinds : sequence of ObservationKind
    overall_fit : Adjustment
        Adjustment of `kinds`.
    centre, size
        See `adjust`.

    Returns
    -------
    list of Blunder
    """
    blunders = _find_blunders(kinds, overall_fit, centre, size, use_stated_errors=True)
    if not np.isfinite(overall_fit.rows.sigma).any():
        return blunders or []
    if blunders is None or (
        blunders and not _explains_misfit(kinds, blunders, overall_fit, centre, size)
    ):
        # The stated accuracies are too small; that is not a blunder.
        blunders = _find_blunders(kinds, overall_fit, centre, size, use_stated_errors=False)
    return blunders or []


def _explains_misfit(
    kinds: Sequence[ObservationKind],
    known_blunders: Sequence[Blunder],
    overall_fit: Adjustment,
    centre: FloatArray,
    size: float,
) -> bool:
    """Return whether observations without the blunders agree with their stated accuracies.

    If two or more of the worst observations are removed, the others may agree by chance. Therefore,
    the blunders must be significant as the worst of all subsets of this size, regardless of the
    stated accuracies.
    """
    from scipy.stats import f

    labels = {blunder.label for blunder in known_blunders}
    kinds = [
        select_observations(kind, [label not in labels for label in kind.labels]) for kind in kinds
    ]
    remaining_fit = adjust([kind for kind in kinds if len(kind.labels)], centre, size)
    if remaining_fit.misfit_factor > 1.0 or len(known_blunders) == 1:
        return remaining_fit.misfit_factor <= 1.0
    squares = [
        float(((item.rows.residuals / item.sigma) ** 2).sum())
        for item in (overall_fit, remaining_fit)
    ]
    dof = overall_fit.redundancy - remaining_fit.redundancy, remaining_fit.redundancy
    if min(dof) < 1.0:
        return False
    ratio = (squares[0] - squares[1]) / dof[0] / max(squares[1] / dof[1], 1e-300)
    subsets = math.comb(
        len(known_blunders) + sum(len(kind.labels) for kind in kinds), len(known_blunders)
    )
    return ratio > float(f.isf(_SIGNIFICANCE / subsets, *dof))


def _find_blunders(
    kinds: Sequence[ObservationKind],
    overall_fit: Adjustment,
    centre: FloatArray,
    size: float,
    *,
    use_stated_errors: bool,
) -> list[Blunder] | None:
    """Return the blunders, or None if more than a third of the observations are blunders.

    use_stated_errors : compare residuals with the stated errors, not with each other
    """
    observation_count = sum(len(kind.labels) for kind in kinds)
    excluded_indices: list[ObservationIndex] = []
    blunder_by_index: dict[ObservationIndex, Blunder] = {}
    while len(blunder_by_index) < observation_count // 3:
        worst_test = _worst_test(
            _test_observations(
                kinds, excluded_indices, overall_fit, use_stated_errors=use_stated_errors
            )
        )
        if worst_test is None:
            break
        excluded_indices.append(worst_test.observation_index)
        blunder_by_index[worst_test.observation_index] = worst_test.blunder
        overall_fit = _adjust_remaining(kinds, excluded_indices, centre, size)
    else:
        # More than a third of the observations look wrong, so there must be another cause.
        if (
            observation_count // 3
            and _worst_test(
                _test_observations(
                    kinds, excluded_indices, overall_fit, use_stated_errors=use_stated_errors
                )
            )
            is not None
        ):
            return None
    if not blunder_by_index and (hidden_outliers := _hidden_outliers(kinds)):
        # The mistakes hide each other, so test each of them against the consistent observations.
        excluded_indices = hidden_outliers
        blunder_by_index = {
            item: Blunder(kinds[item[0]].labels[item[1]], None, None) for item in hidden_outliers
        }
        _reinstate_consistent_observations(
            kinds,
            excluded_indices,
            blunder_by_index,
            centre,
            size,
            use_stated_errors=use_stated_errors,
        )
        return list(blunder_by_index.values())
    if len(excluded_indices) > 1:
        _reinstate_consistent_observations(
            kinds,
            excluded_indices,
            blunder_by_index,
            centre,
            size,
            use_stated_errors=use_stated_errors,
        )
    return list(blunder_by_index.values())


def _hidden_outliers(kinds: Sequence[ObservationKind]) -> list[ObservationIndex]:
    """Return the points that a robust fit excludes, or none if they are more than a third."""
    observation_count = sum(len(kind.labels) for kind in kinds)
    outliers: list[ObservationIndex] = []
    for index, kind in enumerate(kinds):
        if isinstance(kind, Points) and len(kind.labels) >= _MIN_POINTS_SUBSET:
            try:
                fit, is_consistent = fit_robustly(kind.model, kind.world)
            except GeometryError:
                continue
            if len(kind.labels) < _MIN_POINTS_ROBUST and not _is_far_better(
                kind, fit, is_consistent
            ):
                continue
            outliers += [(index, int(row)) for row in np.flatnonzero(~is_consistent)]
    return outliers if len(outliers) <= observation_count // 3 else []


def _is_far_better(points: Points, fit: Similarity, is_consistent: BoolArray) -> bool:
    """Return whether the consistent points fit far better than all points."""

    def variance(mask: BoolArray, similarity: Similarity) -> float:
        residuals = similarity(points.model[mask]) - points.world[mask]
        return float((residuals**2).sum()) / (3 * int(mask.sum()) - 7)

    all_points = np.ones(len(is_consistent), np.bool_)
    overall_similarity = fit_similarity(points.model, points.world)
    return variance(all_points, overall_similarity) > _MIN_VARIANCE_RATIO * variance(
        is_consistent, fit
    )


def _reinstate_consistent_observations(
    kinds: Sequence[ObservationKind],
    excluded_indices: list[ObservationIndex],
    blunder_by_index: dict[ObservationIndex, Blunder],
    centre: FloatArray,
    size: float,
    *,
    use_stated_errors: bool,
) -> None:
    """Remove consistent observations from the outliers, and update the other errors."""
    observation_count = sum(len(kind.labels) for kind in kinds)
    for excluded_index in [*excluded_indices]:
        other_indices = [
            other_index for other_index in excluded_indices if other_index != excluded_index
        ]
        remaining_fit = _adjust_remaining(kinds, other_indices, centre, size)
        results = _test_observations(
            kinds, other_indices, remaining_fit, use_stated_errors=use_stated_errors
        )
        result = next((item for item in results if item.observation_index == excluded_index), None)
        if result is None:
            continue
        if result.p_value < _SIGNIFICANCE / observation_count:
            blunder_by_index[excluded_index] = result.blunder
        else:
            excluded_indices.remove(excluded_index)
            del blunder_by_index[excluded_index]


def _adjust_remaining(
    kinds: Sequence[ObservationKind],
    exclusions: Sequence[ObservationIndex],
    centre: FloatArray,
    size: float,
) -> Adjustment:
    return adjust([kind for _, kind, _ in _remaining_observations(kinds, exclusions)], centre, size)


def _remaining_observations(
    kinds: Sequence[ObservationKind], exclusions: Sequence[ObservationIndex]
) -> list[tuple[int, ObservationKind, list[int]]]:
    """Return the index, observations and remaining rows of each kind that is not empty."""
    excluded_indices = set(exclusions)
    remaining_kinds = []
    for index, kind in enumerate(kinds):
        rows = [row for row in range(len(kind.labels)) if (index, row) not in excluded_indices]
        if rows:
            is_remaining = [(index, row) not in excluded_indices for row in range(len(kind.labels))]
            remaining_kinds.append((index, select_observations(kind, is_remaining), rows))
    return remaining_kinds


def select_observations(kind: ObservationKind, is_selected: Sequence[bool]) -> ObservationKind:
    """Return a kind of observation reduced to a subset.

    Parameters
    ----------
    kind : ObservationKind
    is_selected : (n,) sequence of bool
        Mask of the observations to keep.

    Returns
    -------
    ObservationKind
    """
    rows = np.flatnonzero(is_selected)
    n = len(kind.labels)
    changed_fields: dict[str, Any] = {"labels": [kind.labels[int(i)] for i in rows]}
    for field in fields(kind):  # type: ignore[arg-type]
        value = getattr(kind, field.name)
        if isinstance(value, np.ndarray) and len(value) == n:
            changed_fields[field.name] = value[rows]
    selection: ObservationKind = replace(kind, **changed_fields)  # type: ignore[type-var]
    return selection


def _worst_test(tests: Sequence[_TestResult]) -> _TestResult | None:
    """Return the test with the least probable significant residual, or None.

    The p-values of gross mistakes underflow to 0; among these, the one with the largest F ratio is
    returned.
    """
    significant_tests = [
        item for item in tests if item.p_value < _SIGNIFICANCE / item.observation_count
    ]
    return (
        min(significant_tests, key=lambda result: (result.p_value, -result.statistic))
        if significant_tests
        else None
    )


def _test_observations(
    kinds: Sequence[ObservationKind],
    exclusions: Sequence[ObservationIndex],
    overall_fit: Adjustment,
    *,
    use_stated_errors: bool,
) -> list[_TestResult]:
    """Test each observation that the others determine."""
    from scipy.stats import chi2, f

    rows, sigma = overall_fit.rows, overall_fit.sigma
    is_stated = np.isfinite(rows.sigma) & use_stated_errors
    design, covariance = weighted_rows(overall_fit)
    residuals = rows.residuals / sigma
    redundancy = overall_fit.redundancy
    squares = float((residuals**2).sum())
    remaining_observations = _remaining_observations(kinds, exclusions)
    observation_count = sum(len(kind.labels) for _, kind, _ in remaining_observations)
    candidates: list[tuple[ObservationIndex, ObservationKind, int, FloatArray]] = []
    statistics: list[tuple[float, int, bool]] = []
    for position, (index, kind, row_numbers) in enumerate(remaining_observations):
        if isinstance(kind, FixedScale | PhotoUpright):
            continue
        first_row, last_row = overall_fit.starts[position], overall_fit.starts[position + 1]
        width = (last_row - first_row) // len(kind.labels)
        for number, row in enumerate(row_numbers):
            row_slice = slice(first_row + number * width, first_row + (number + 1) * width)
            residual_covariance = (
                np.eye(width) - design[row_slice] @ covariance @ design[row_slice].T
            )
            if np.linalg.eigvalsh(residual_covariance)[0] < 1e-6 or redundancy - width < 1:
                # The other observations do not determine it.
                continue
            deleted_residuals = np.linalg.solve(residual_covariance, residuals[row_slice])
            if np.linalg.norm(deleted_residuals * sigma[row_slice]) < _ROUNDING * max(
                overall_fit.size, 1.0
            ):
                continue
            candidates.append(((index, row), kind, number, deleted_residuals * sigma[row_slice]))
            statistic = float(residuals[row_slice] @ deleted_residuals)
            statistics.append((statistic, width, bool(is_stated[row_slice].all())))
    if not candidates:
        return []
    chi_squares, widths, is_known = (np.array(column) for column in zip(*statistics, strict=True))
    other_variances = np.where(
        is_known, 1.0, np.maximum((squares - chi_squares) / (redundancy - widths), 1e-300)
    )
    f_statistics = chi_squares / widths / other_variances
    # Use one call for all observations: a SciPy call takes as long as the other steps per point.
    p_values = np.where(
        is_known,
        chi2.sf(chi_squares, widths),
        f.sf(f_statistics, widths, np.maximum(redundancy - widths, 1)),
    )
    return [
        _TestResult(
            observation_index,
            float(p),
            float(s),
            observation_count,
            _describe(kind, kind.labels[index], misclosure),
        )
        for (observation_index, kind, index, misclosure), p, s in zip(
            candidates, p_values, f_statistics, strict=True
        )
    ]


def _describe(kind: ObservationKind, label: str, error: FloatArray) -> Blunder:
    if isinstance(kind, SimilarityObservation):
        return Blunder(label, None, *kind.error_sizes(error))
    size = float(np.linalg.norm(error))
    if isinstance(kind, Points) or hasattr(kind, "length"):
        return Blunder(label, None, size)
    return Blunder(label, None, None, float(np.degrees(size)))


def exclude_labels(
    kinds: Sequence[ObservationKind], check: Points | None, labels: Sequence[str]
) -> tuple[list[ObservationKind], Points | None]:
    """Remove the observations and check points with the given labels.

    Returns the remaining observations and check points (None if `check` is None).

    Raises
    ------
    UsageError
        If a label is unknown.
    """
    known_labels = [label for kind in kinds for label in kind.labels]
    known_labels += [] if check is None else list(check.labels)
    for label in labels:
        if label not in known_labels:
            similar_labels = get_close_matches(label, known_labels, 3) or known_labels[:8]
            raise UsageError(
                Finding("registration.unknown-label", label=label, known=", ".join(similar_labels)),
                field="--without",
            )

    def keep_unlisted(kind: ObservationKind) -> ObservationKind:
        return select_observations(kind, [label not in labels for label in kind.labels])

    remaining_kinds = [keep_unlisted(kind) for kind in kinds]
    remaining_check = None if check is None else keep_unlisted(check)
    assert remaining_check is None or isinstance(remaining_check, Points)
    return [kind for kind in remaining_kinds if len(kind.labels)], remaining_check


# --- few directions ---------------------------------------------------------------------------
def leave_one_out(
    kinds: Sequence[ObservationKind], overall_fit: Adjustment, centre: FloatArray, size: float
) -> list[LeaveOneOut]:
    """Leave out each of a few directions in turn, and list the most suspicious first.

    This applies to placements by a few directions alone. A wrong direction attracts the placement
    and is hidden in the residuals; if no accuracies are stated, it also inflates the estimated
    error. Each direction is compared with the scatter of the others, pooled with the default error
    of a compass.

    Returns
    -------
    list of LeaveOneOut
        Results for the directions; empty if they agree, or if there are too many directions.
    """
    direction_count = sum(len(kind.labels) for kind in kinds if isinstance(kind, Directions))
    has_only_directions = all(isinstance(kind, _DIRECTIONS) for kind in kinds)
    if not has_only_directions or not _MIN_DIRECTIONS <= direction_count <= _MAX_DIRECTIONS:
        return []
    typical_errors = np.where(
        np.isfinite(overall_fit.rows.sigma), overall_fit.rows.sigma, _DEFAULT_ERROR_RAD
    )
    total_squares = float(((overall_fit.rows.residuals / typical_errors) ** 2).sum())
    if overall_fit.redundancy < 3.0 or total_squares <= _MIN_MISFIT**2 * overall_fit.redundancy:
        return []
    if overall_fit.is_ambiguous:
        # Among equal fits, the one with the smallest tilt was selected, not the best fit.
        total_squares -= EQUAL_FIT_COST
    return _leave_each_out(kinds, overall_fit, centre, size, total_squares)


def _leave_each_out(
    kinds: Sequence[ObservationKind],
    overall_fit: Adjustment,
    centre: FloatArray,
    size: float,
    total_squares: float,
) -> list[LeaveOneOut]:
    from scipy.spatial.transform import Rotation
    from scipy.stats import chi2, f

    has_stated_errors = bool(np.isfinite(overall_fit.rows.sigma).all())
    results: list[tuple[float, float, LeaveOneOut]] = []
    observation_indices = [
        (index, row)
        for index, kind in enumerate(kinds)
        if isinstance(kind, Directions)
        for row in range(len(kind.labels))
    ]
    for excluded_index in observation_indices:
        kind = kinds[excluded_index[0]]
        assert isinstance(kind, Directions)
        try:
            remaining_fit = _adjust_remaining(kinds, [excluded_index], centre, size)
        except GeometryError:
            continue
        typical_errors = np.where(
            np.isfinite(remaining_fit.rows.sigma), remaining_fit.rows.sigma, _DEFAULT_ERROR_RAD
        )
        squares = float(((remaining_fit.rows.residuals / typical_errors) ** 2).sum())
        redundancy = remaining_fit.redundancy
        squares_reduction = max(total_squares - squares, 0.0)
        if has_stated_errors:
            p_value = float(chi2.sf(squares_reduction, 2))
        else:
            pooled_variance = (squares + _DEFAULT_ERROR_WEIGHT) / (
                redundancy + _DEFAULT_ERROR_WEIGHT
            )
            p_value = float(
                f.sf(
                    squares_reduction / 2.0 / pooled_variance, 2, redundancy + _DEFAULT_ERROR_WEIGHT
                )
            )
        placed_vector = remaining_fit.fit.rotation @ kind.model[excluded_index[1]]
        other_error_deg = float(np.degrees(np.sqrt((remaining_fit.rows.residuals**2).mean())))
        cosine = float(placed_vector @ kind.world[excluded_index[1]])
        rotation_angle = Rotation.from_matrix(
            remaining_fit.fit.rotation @ overall_fit.fit.rotation.T
        ).magnitude()
        worst_error_deg = 1.96 * float(
            np.degrees(np.sqrt(np.linalg.eigvalsh(remaining_fit.rotation)[-1]))
        )
        # The few other directions determine it poorly.
        limit = float(
            np.clip(max(3.0 * other_error_deg, 2.0 * worst_error_deg), *_AZIMUTH_LIMITS_DEG)
        )
        azimuth_offset_deg = find_azimuth_correction(
            placed_vector, kind.world[excluded_index[1]], limit
        )
        results.append(
            (
                squares,
                p_value,
                LeaveOneOut(
                    kind.labels[excluded_index[1]],
                    float(
                        np.degrees(
                            np.arccos(np.clip(abs(cosine) if kind.axial else cosine, -1.0, 1.0))
                        )
                    ),
                    float(np.degrees(rotation_angle)),
                    other_error_deg,
                    None
                    if remaining_fit.null_space[:3].size
                    and np.abs(remaining_fit.null_space[:3]).max() > 1e-6
                    else worst_error_deg,
                    suspect=False,
                    azimuth_off_deg=azimuth_offset_deg,
                ),
            )
        )
    results.sort(key=lambda result: result[0])
    sorted_results = [replace(item, azimuth_off_deg=None) for _, _, item in results]
    if results and results[0][1] < _SIGNIFICANCE / len(results):
        sorted_results[0] = replace(results[0][2], suspect=True)
    return sorted_results
