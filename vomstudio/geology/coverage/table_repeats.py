"""The repeated picks of a table: what `vomstudio repeats` prints."""

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
    Between,
    HeldErrors,
    Spread,
    Structure,
    apart,
    by_interpreter,
    held_errors,
    spread_of,
    structures,
)
from vomstudio.geology.orientation_rows import OrientationRows
from vomstudio.geology.tilted_planes import axes_without_registration, cells_of
from vomstudio.geometry.rotation_errors import CHI2_TWO

Holds = Literal["yes", "no", "undetermined"]

REPEAT_OF, INTERPRETER = "repeat_of", "interpreter"
"""Columns of the program's own tables: the id of the pick that a row repeats, and by whom."""
_SIGNIFICANT = 0.05
_TOO_FEW = 2.0
"""Errors that are too small by this would not be noticed often enough: nothing is said of them."""


@dataclass(frozen=True)
class RepeatedPick:
    """first, repeat : ids; by : the interpreters of both, empty where not known; angle_deg :
    between the poles or lines, 0 to 90; stated95_deg : the errors of both, as the root of the sum
    of squares; within95 : the angle is no larger than these allow in its direction. None where not
    known"""

    first: str
    repeat: str
    by: tuple[str, str]
    angle_deg: float
    stated95_deg: float | None
    within95: bool | None


@dataclass(frozen=True)
class OwnSpread:
    """Of what one interpreter picked more than once."""

    name: str
    spread: Spread


@dataclass(frozen=True)
class LeftOut:
    id: str
    reason: Finding


@dataclass(frozen=True, repr=False)
class TableRepeats(PrintableResult):
    """n : picks that are no repeats; structures : of them, those that were picked again; repeats :
    how often altogether

    spread : of a pick about its structure, None without repeats
    stated95_deg : what the same picks state (root mean square of both semi-axes), None where one of
        them states nothing
    test : whether the stated errors hold; stated_errors_hold : what it says, with `reasons`
    interpreters : each one's own; between : whether they differ by more than each one's own repeats
    """

    n: int
    structures: int
    repeats: int
    spread: Spread | None
    median_angle_deg: float | None
    stated95_deg: float | None
    test: HeldErrors | None
    stated_errors_hold: Holds
    reasons: tuple[Finding, ...]
    interpreters: tuple[OwnSpread, ...]
    between: Between | None
    pairs: tuple[RepeatedPick, ...]
    left_out: tuple[LeftOut, ...]
    convention: str
    warnings: tuple[Finding, ...]


def table_repeats(
    table: OrientationRows, by: str | None = None, interpreter: str | None = None
) -> TableRepeats:
    """by : column whose word is the same for picks of the same structure; None for the column
    `repeat_of` with the id of the pick that a row repeats. interpreter : column of who picked, None
    for `interpreter` where there is one. Raises UsageError for a column that is not there."""
    left_out: list[LeftOut] = []
    groups = _groups_by(table, by) if by is not None else _groups_of_repeats(table, left_out)
    groups = [own for group in groups for own in _of_one_geometry(table, group, left_out)]
    people = _people(table, interpreter)
    vectors = table.vectors()
    found = structures(vectors, _errors(table, vectors), groups)
    repeated = [s for s in found if len(s.rows) > 1]
    spread, test = spread_of(repeated), held_errors(repeated)
    own, between = by_interpreter(repeated, people)
    several = len(set(people)) > 1
    pairs = tuple(
        _pair(table, vectors, s, k, people) for s in repeated for k in range(1, len(s.rows))
    )
    angles = [pair.angle_deg for pair in pairs]
    holds, reasons = _assess_repeats(spread, test, between)
    return TableRepeats(
        n=len(found),
        structures=len(repeated),
        repeats=sum(len(s.rows) - 1 for s in repeated),
        spread=spread,
        median_angle_deg=float(np.median(angles)) if angles else None,
        stated95_deg=_stated(repeated),
        test=test,
        stated_errors_hold=holds,
        reasons=tuple(reasons),
        interpreters=tuple(OwnSpread(name, s) for name, s in own.items()) if several else (),
        between=between,
        pairs=pairs,
        left_out=tuple(left_out),
        convention=table.convention,
        warnings=tuple(table.warnings),
    )


# --- which rows are the same structure -----------------------------------------------------------
def _groups_by(table: OrientationRows, by: str) -> list[list[int]]:
    groups: dict[str, list[int]] = {}
    for row, word in enumerate(table.column(by)):
        # A row without a word is a structure of its own.
        groups.setdefault(word.strip() or f"\0{row}", []).append(row)
    return list(groups.values())


def _groups_of_repeats(table: OrientationRows, left_out: list[LeftOut]) -> list[list[int]]:
    try:
        named = [word.strip() for word in table.column(REPEAT_OF)]
    except UsageError as error:
        raise UsageError(
            Finding("repeats.no-column"),
            file=table.path,
            field="--by",
        ) from error
    rows = {id_: row for row, id_ in enumerate(table.ids)}
    groups: dict[int, list[int]] = {row: [row] for row, of in enumerate(named) if not of}
    for row, of in enumerate(named):
        if not of:
            continue
        first = _first(row, named, rows)
        if first is None:
            reason = Finding("repeats.first-missing", first=of)
            left_out.append(LeftOut(table.ids[row], reason))
        else:
            groups[first].append(row)
    return list(groups.values())


def _first(row: int, named: Sequence[str], rows: dict[str, int]) -> int | None:
    """The pick at the end of the chain; None where it is missing, or the chain is a ring."""
    seen = set()
    while named[row]:
        if row in seen or named[row] not in rows:
            return None
        seen.add(row)
        row = rows[named[row]]
    return row


def _of_one_geometry(
    table: OrientationRows, rows: list[int], left_out: list[LeftOut]
) -> list[list[int]]:
    """A plane and a line of the same structure have no angle between them that means anything."""
    plane = bool(table.is_plane[rows[0]])
    kept = [row for row in rows if bool(table.is_plane[row]) == plane]
    for row in set(rows) - set(kept):
        reason = Finding("repeats.line-of-plane" if plane else "repeats.plane-of-line")
        left_out.append(LeftOut(table.ids[row], reason))
    return [kept]


def _people(table: OrientationRows, column: str | None) -> list[str]:
    try:
        return [word.strip() for word in table.column(column or INTERPRETER)]
    except UsageError:
        if column is not None:
            raise
        return [""] * len(table)


# --- what they state -----------------------------------------------------------------------------
def _errors(table: OrientationRows, vectors: FloatArray) -> FloatArray:
    """(n, 2, 3) tangent vectors one standard deviation long, radians; of a line its larger error in
    all directions."""
    axes = np.zeros((len(table), 2, 3))
    planes, lines = np.flatnonzero(table.is_plane), np.flatnonzero(~table.is_plane)
    if len(planes):
        axes[planes] = axes_without_registration(table, planes)
    if len(lines):
        largest = cells_of(table, lines, "max_confidence95_deg")
        total = cells_of(table, lines, "total95_deg")
        registration = np.nan_to_num(cells_of(table, lines, "registration_error_deg"))
        own = np.sqrt(np.maximum(total**2 - registration**2, 0.0))
        wide = np.nan_to_num(np.where(np.isfinite(own), own, largest))
        sigma = np.radians(wide) / math.sqrt(CHI2_TWO)
        for row, size, line in zip(lines, sigma, vectors[lines], strict=True):
            axes[row] = size * np.linalg.svd(line[None])[2][1:]
    return axes


def _stated(found: Sequence[Structure]) -> float | None:
    if not found or not all(s.stated for s in found):
        return None
    traces = np.concatenate([np.trace(s.covariances, axis1=1, axis2=2) for s in found])
    return min(float(np.degrees(np.sqrt(CHI2_TWO * traces.mean() / 2.0))), 90.0)


def _pair(
    table: OrientationRows, vectors: FloatArray, one: Structure, k: int, people: Sequence[str]
) -> RepeatedPick:
    first, again = int(one.rows[0]), int(one.rows[k])
    across = float(np.linalg.norm(np.cross(vectors[first], vectors[again])))
    angle = math.degrees(math.atan2(across, abs(float(vectors[first] @ vectors[again]))))
    stated = within = None
    if one.stated:
        largest = np.linalg.eigvalsh(one.covariances)[[0, k], -1]
        stated = min(float(np.degrees(np.sqrt(CHI2_TWO * largest.sum()))), 90.0)
        within = apart(one, 0, k) <= CHI2_TWO
    return RepeatedPick(
        table.ids[first],
        table.ids[again],
        (people[first], people[again]),
        angle,
        stated,
        within,
    )


# --- what follows --------------------------------------------------------------------------------
def _assess_repeats(
    spread: Spread | None, test: HeldErrors | None, between: Between | None
) -> tuple[Holds, list[Finding]]:
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
    holds: Holds = "undetermined"
    if test is None:
        findings.append(Finding("repeats.no-errors"))
    else:
        holds, finding = _check_stated_errors(test)
        findings.append(finding)
    if between is not None:
        differ = between.p < _SIGNIFICANT
        code = "repeats.interpreters-differ" if differ else "repeats.interpreters-alike"
        findings.append(Finding(code, ratio=between.ratio, p=between.p))
    findings.append(Finding("repeats.only-picking"))
    return holds, findings


def _check_stated_errors(test: HeldErrors) -> tuple[Holds, Finding]:
    if test.p < _SIGNIFICANT:
        return "no", Finding(
            "repeats.errors-too-small",
            factor=test.factor,
            low=test.factor_low,
            high=test.factor_high,
        )
    if test.noticeable_factor > _TOO_FEW:
        return "undetermined", Finding("repeats.too-few", count=test.n)
    return "yes", Finding(
        "repeats.errors-hold", factor=test.factor, noticeable=test.noticeable_factor
    )
