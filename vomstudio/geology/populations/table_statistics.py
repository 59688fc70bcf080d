"""The statistics of the sets of a table: what `vomstudio stats` prints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import IntArray
from vomstudio.core.findings import Finding
from vomstudio.core.reprs import PrintableResult
from vomstudio.geology.orientation_rows import OrientationRows
from vomstudio.geology.populations.error_weights import Errors, errors_of
from vomstudio.geology.populations.set_statistics import SetStatistics, set_statistics
from vomstudio.geology.populations.statistics_options import StatisticsOptions

UNNAMED = "unassigned"


@dataclass(frozen=True, repr=False)
class TableStatistics(PrintableResult):
    """n : rows; sets : by name, in order of appearance; convention, dropped_lines, warnings : of
    the table as it was read"""

    n: int
    sets: Mapping[str, SetStatistics]
    convention: str
    dropped_lines: tuple[int, ...]
    warnings: tuple[Finding, ...]


def table_statistics(
    table: OrientationRows, options: StatisticsOptions | None = None
) -> TableStatistics:
    """Describe the sets of a table.

    Raises
    ------
    UsageError
        For a column that is missing, and for weights by errors without errors.
    """
    options = StatisticsOptions() if options is None else options
    warnings = list(table.warnings)
    vectors = table.vectors()
    errors = None if options.weights is None else errors_of(table)
    statistics: dict[str, SetStatistics] = {}
    for name, members in _sets(table, options.by, warnings).items():
        of = "poles" if table.is_plane[members[0]] else "lines"
        turns = None if table.turns is None else table.turns.of(members)
        set_errors = None if errors is None else Errors(errors.error95_deg[members], errors.column)
        statistics[name] = set_statistics(vectors[members], of, options.directed, turns, set_errors)
    return TableStatistics(
        len(table), statistics, table.convention, tuple(table.dropped), tuple(warnings)
    )


def _sets(
    table: OrientationRows, column: str | None, warnings: list[Finding]
) -> dict[str, IntArray]:
    """Rows of each set, in order of appearance. Poles and lines are not averaged together: a set
    of both becomes two."""
    names = ["all"] * len(table) if column is None else table.column(column)
    if column is not None and not all(names):
        warnings.append(Finding("stats.unnamed-set", column=column, set=UNNAMED))
        names = [name or UNNAMED for name in names]
    rows: dict[str, list[int]] = {}
    for i, name in enumerate(names):
        rows.setdefault(name, []).append(i)
    result: dict[str, IntArray] = {}
    for name, members in rows.items():
        where = np.asarray(members, dtype=np.int64)
        plane = table.is_plane[where]
        kinds = {} if table.kinds is None else dict.fromkeys(table.kinds[i] for i in members)
        if len(kinds) > 1:
            kind_names = [kind or "no kind" for kind in kinds]
            warnings.append(Finding("stats.several-kinds", set=name, kinds=kind_names))
        if plane.all() or not plane.any():
            result[name] = where
            continue
        warnings.append(Finding("stats.planes-and-lines", set=name))
        result[f"{name} (poles)"] = where[plane]
        result[f"{name} (lines)"] = where[~plane]
    return result
