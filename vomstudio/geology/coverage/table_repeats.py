"""Evaluation of the repeated picks of a table, for `vomstudio repeats`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.reprs import PrintableResult
from vomstudio.geology.coverage.spread import (
    InterpreterTest,
    PickSpread,
    RepeatedStructure,
    StatedErrorTest,
    check_stated_errors,
    compare_interpreters,
    group_structures,
    measure_spread,
    squared_difference,
)
from vomstudio.geology.orientation_rows import OrientationRows
from vomstudio.geology.tilted_planes import axes_without_registration, column_numbers
from vomstudio.geometry.rotation_errors import CHI2_TWO

TestOutcome = Literal["yes", "no", "undetermined"]

REPEAT_COLUMN, INTERPRETER_COLUMN = "repeat_of", "interpreter"
"""Columns of VOM Studio tables: id of the pick that a row repeats, and interpreter."""
SIGNIFICANCE = 0.05
MAX_NOTICEABLE_FACTOR = 2.0
"""Factor of underestimation that the test must be able to detect for a verdict."""


@dataclass(frozen=True)
class RepeatedPick:
    """Pair of picks of the same structure.

    Attributes
    ----------
    first, repeat : str
        Ids of the picks.
    by : (str, str)
        Interpreters of the two picks; "" if unknown.
    angle_deg : float
        Angle between the poles or lines, 0 to 90 degrees.
    stated95_deg : float or None
        Square root of the sum of the squared stated errors, degrees; None if not all picks of the
        structure have a stated error.
    within95 : bool or None
        True if the stated errors explain the angle in its direction; None if they are unknown.
    """

    first: str
    repeat: str
    by: tuple[str, str]
    angle_deg: float
    stated95_deg: float | None
    within95: bool | None


@dataclass(frozen=True)
class InterpreterSpread:
    """Scatter of the picks that an interpreter repeated."""

    name: str
    spread: PickSpread


@dataclass(frozen=True)
class ExcludedPick:
    """Pick without usable repeats, and the reason."""

    id: str
    reason: Finding


@dataclass(frozen=True, repr=False)
class TableRepeats(PrintableResult):
    """Evaluation of the repeated picks of a table.

    Attributes
    ----------
    n : int
        Number of picks that are not repeats.
    structures, repeats : int
        Number of picks that were repeated, and number of repeats.
    spread : PickSpread or None
        Scatter of the picks about their structures; None if there are no repeats.
    stated95_deg : float or None
        RMS of both semi-axes of the stated errors, degrees; None if one of them is not stated.
    test : StatedErrorTest or None
    stated_errors_hold : str
        Verdict of the test, as explained by `reasons`.
    interpreters : tuple of InterpreterSpread
        Scatter of the repeats of each interpreter; empty if there is only one interpreter.
    between : InterpreterTest or None
        Test whether interpreters differ by more than their own repeats.
    """

    n: int
    structures: int
    repeats: int
    spread: PickSpread | None
    median_angle_deg: float | None
    stated95_deg: float | None
    test: StatedErrorTest | None
    stated_errors_hold: TestOutcome
    reasons: tuple[Finding, ...]
    interpreters: tuple[InterpreterSpread, ...]
    between: InterpreterTest | None
    pairs: tuple[RepeatedPick, ...]
    left_out: tuple[ExcludedPick, ...]
    convention: str
    warnings: tuple[Finding, ...]


def table_repeats(
    table: OrientationRows, group_column: str | None = None, interpreter: str | None = None
) -> TableRepeats:
    """Evaluate the repeated picks of a table.

    Parameters
    ----------
    table : OrientationRows
    group_column : str, optional
        Column that contains the same text for all picks of a structure; by default, `repeat_of`
        with the id of the pick that a row repeats.
    interpreter : str, optional
        Column that contains the interpreter; by default, `interpreter` if this column exists.

    Returns
    -------
    TableRepeats

    Raises
    ------
    UsageError
        If a given column does not exist, or if neither `group_column` is given nor the column
        `repeat_of` exists.
    """
    excluded_picks: list[ExcludedPick] = []
    groups = (
        _group_rows(table, group_column)
        if group_column is not None
        else _group_repeats(table, excluded_picks)
    )
    groups = [
        spreads
        for group in groups
        for spreads in _exclude_other_geometry(table, group, excluded_picks)
    ]
    interpreters = _interpreter_names(table, interpreter)
    vectors = table.vectors()
    structures = group_structures(vectors, _errors(table, vectors), groups)
    repeated_structures = [structure for structure in structures if len(structure.rows) > 1]
    spread, test = measure_spread(repeated_structures), check_stated_errors(repeated_structures)
    spreads, interpreter_test = compare_interpreters(repeated_structures, interpreters)
    has_several_interpreters = len(set(interpreters)) > 1
    pairs = tuple(
        _pair(table, vectors, repeated_structure, k, interpreters)
        for repeated_structure in repeated_structures
        for k in range(1, len(repeated_structure.rows))
    )
    angles = [pair.angle_deg for pair in pairs]
    verdict, reasons = _assess_repeats(spread, test, interpreter_test)
    return TableRepeats(
        n=len(structures),
        structures=len(repeated_structures),
        repeats=sum(len(repeated_structure.rows) - 1 for repeated_structure in repeated_structures),
        spread=spread,
        median_angle_deg=float(np.median(angles)) if angles else None,
        stated95_deg=_stated_error95(repeated_structures),
        test=test,
        stated_errors_hold=verdict,
        reasons=tuple(reasons),
        interpreters=tuple(
            InterpreterSpread(name, pick_spread) for name, pick_spread in spreads.items()
        )
        if has_several_interpreters
        else (),
        between=interpreter_test,
        pairs=pairs,
        left_out=tuple(excluded_picks),
        convention=table.convention,
        warnings=tuple(table.warnings),
    )


# --- rows of the same structure ------------------------------------------------------------------
def _group_rows(table: OrientationRows, group_column: str) -> list[list[int]]:
    groups: dict[str, list[int]] = {}
    for row, word in enumerate(table.column(group_column)):
        # A row with an empty cell is a separate structure.
        groups.setdefault(word.strip() or f"\0{row}", []).append(row)
    return list(groups.values())


def _group_repeats(table: OrientationRows, excluded_picks: list[ExcludedPick]) -> list[list[int]]:
    try:
        original_ids = [word.strip() for word in table.column(REPEAT_COLUMN)]
    except UsageError as error:
        raise UsageError(
            Finding("repeats.no-column"),
            file=table.path,
            field="--by",
        ) from error
    rows = {id_: row for row, id_ in enumerate(table.ids)}
    groups: dict[int, list[int]] = {
        row: [row] for row, first_id in enumerate(original_ids) if not first_id
    }
    for row, first_id in enumerate(original_ids):
        if not first_id:
            continue
        first_row = _find_first_pick(row, original_ids, rows)
        if first_row is None:
            reason = Finding("repeats.first-missing", first=first_id)
            excluded_picks.append(ExcludedPick(table.ids[row], reason))
        else:
            groups[first_row].append(row)
    return list(groups.values())


def _find_first_pick(row: int, original_ids: Sequence[str], rows: dict[str, int]) -> int | None:
    """Return the first pick of a chain of repeats, or None if the chain is broken or cyclic."""
    visited = set()
    while original_ids[row]:
        if row in visited or original_ids[row] not in rows:
            return None
        visited.add(row)
        row = rows[original_ids[row]]
    return row


def _exclude_other_geometry(
    table: OrientationRows, rows: list[int], excluded_picks: list[ExcludedPick]
) -> list[list[int]]:
    """Exclude lines among the repeats of a plane, and planes among the repeats of a line."""
    is_plane = bool(table.is_plane[rows[0]])
    matching_rows = [row for row in rows if bool(table.is_plane[row]) == is_plane]
    for row in set(rows) - set(matching_rows):
        reason = Finding("repeats.line-of-plane" if is_plane else "repeats.plane-of-line")
        excluded_picks.append(ExcludedPick(table.ids[row], reason))
    return [matching_rows]


def _interpreter_names(table: OrientationRows, column: str | None) -> list[str]:
    try:
        return [word.strip() for word in table.column(column or INTERPRETER_COLUMN)]
    except UsageError:
        if column is not None:
            raise
        return [""] * len(table)


# --- stated errors -------------------------------------------------------------------------------
def _errors(table: OrientationRows, vectors: FloatArray) -> FloatArray:
    """Return tangent vectors (n, 2, 3) with the length of one standard deviation, radians.

    For lines, the larger error is used in all directions.
    """
    axes = np.zeros((len(table), 2, 3))
    planes, lines = np.flatnonzero(table.is_plane), np.flatnonzero(~table.is_plane)
    if len(planes):
        axes[planes] = axes_without_registration(table, planes)
    if len(lines):
        confidence95_deg = column_numbers(table, lines, "max_confidence95_deg")
        total95_deg = column_numbers(table, lines, "total95_deg")
        registration = np.nan_to_num(column_numbers(table, lines, "registration_error_deg"))
        picking_errors_deg = np.sqrt(np.maximum(total95_deg**2 - registration**2, 0.0))
        errors_deg = np.nan_to_num(
            np.where(np.isfinite(picking_errors_deg), picking_errors_deg, confidence95_deg)
        )
        sigma = np.radians(errors_deg) / math.sqrt(CHI2_TWO)
        for row, size, line in zip(lines, sigma, vectors[lines], strict=True):
            axes[row] = size * np.linalg.svd(line[None])[2][1:]
    return axes


def _stated_error95(structures: Sequence[RepeatedStructure]) -> float | None:
    if not structures or not all(structure.has_stated_errors for structure in structures):
        return None
    traces = np.concatenate(
        [np.trace(structure.covariances, axis1=1, axis2=2) for structure in structures]
    )
    return min(float(np.degrees(np.sqrt(CHI2_TWO * traces.mean() / 2.0))), 90.0)


def _pair(
    table: OrientationRows,
    vectors: FloatArray,
    structure: RepeatedStructure,
    k: int,
    interpreters: Sequence[str],
) -> RepeatedPick:
    first_row, second_row = int(structure.rows[0]), int(structure.rows[k])
    sine = float(np.linalg.norm(np.cross(vectors[first_row], vectors[second_row])))
    angle = math.degrees(math.atan2(sine, abs(float(vectors[first_row] @ vectors[second_row]))))
    stated_error = is_within_error = None
    if structure.has_stated_errors:
        largest_variances = np.linalg.eigvalsh(structure.covariances)[[0, k], -1]
        stated_error = min(float(np.degrees(np.sqrt(CHI2_TWO * largest_variances.sum()))), 90.0)
        is_within_error = squared_difference(structure, 0, k) <= CHI2_TWO
    return RepeatedPick(
        table.ids[first_row],
        table.ids[second_row],
        (interpreters[first_row], interpreters[second_row]),
        angle,
        stated_error,
        is_within_error,
    )


# --- verdict -------------------------------------------------------------------------------------
def _assess_repeats(
    spread: PickSpread | None,
    test: StatedErrorTest | None,
    interpreter_test: InterpreterTest | None,
) -> tuple[TestOutcome, list[Finding]]:
    if spread is None:
        return "undetermined", [Finding("repeats.none")]
    findings = [
        Finding(
            "repeats.scatter",
            count=spread.n,
            error_deg=spread.error95_deg,
            low_deg=spread.error95_low_deg,
            high_deg=spread.error95_high_deg,
        )
    ]
    verdict: TestOutcome = "undetermined"
    if test is None:
        findings.append(Finding("repeats.no-errors"))
    else:
        verdict, finding = _check_stated_errors(test)
        findings.append(finding)
    if interpreter_test is not None:
        are_different = interpreter_test.p < SIGNIFICANCE
        code = "repeats.interpreters-differ" if are_different else "repeats.interpreters-alike"
        findings.append(Finding(code, ratio=interpreter_test.ratio, p=interpreter_test.p))
    findings.append(Finding("repeats.only-picking"))
    return verdict, findings


def _check_stated_errors(test: StatedErrorTest) -> tuple[TestOutcome, Finding]:
    if test.p < SIGNIFICANCE:
        return "no", Finding(
            "repeats.errors-too-small",
            factor=test.factor,
            low=test.factor_low,
            high=test.factor_high,
        )
    if test.noticeable_factor > MAX_NOTICEABLE_FACTOR:
        return "undetermined", Finding("repeats.too-few", count=test.n)
    return "yes", Finding(
        "repeats.errors-hold", factor=test.factor, noticeable=test.noticeable_factor
    )
