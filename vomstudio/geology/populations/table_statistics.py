"""Statistics of the sets of a table, for `vomstudio stats`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import IntArray
from vomstudio.core.findings import Finding
from vomstudio.core.reprs import PrintableResult
from vomstudio.geology.orientation_rows import OrientationRows
from vomstudio.geology.populations.error_weights import OrientationErrors, read_errors
from vomstudio.geology.populations.set_statistics import SetStatistics, set_statistics
from vomstudio.geology.populations.statistics_options import StatisticsOptions

UNASSIGNED_NAME = "unassigned"


@dataclass(frozen=True, repr=False)
class TableStatistics(PrintableResult):
    """Statistics of the sets by name, in order of appearance, with properties of the table."""

    n: int
    sets: Mapping[str, SetStatistics]
    convention: str
    dropped_lines: tuple[int, ...]
    warnings: tuple[Finding, ...]


def table_statistics(
    table: OrientationRows, options: StatisticsOptions | None = None
) -> TableStatistics:
    """Compute the statistics of the sets of a table.

    Raises
    ------
    UsageError
        If a column is missing, or if the table has no errors from which to compute weights.
    """
    options = StatisticsOptions() if options is None else options
    warnings = list(table.warnings)
    vectors = table.vectors()
    errors = None if options.weights is None else read_errors(table)
    statistics: dict[str, SetStatistics] = {}
    for name, members in _sets(table, options.by, warnings).items():
        kind = "poles" if table.is_plane[members[0]] else "lines"
        rotation_errors = (
            None if table.rotation_errors is None else table.rotation_errors.of(members)
        )
        set_errors = (
            None
            if errors is None
            else OrientationErrors(errors.error95_deg[members], errors.column)
        )
        statistics[name] = set_statistics(
            vectors[members], kind, options.directed, rotation_errors, set_errors
        )
    return TableStatistics(
        len(table), statistics, table.convention, tuple(table.dropped), tuple(warnings)
    )


def _sets(
    table: OrientationRows, column: str | None, warnings: list[Finding]
) -> dict[str, IntArray]:
    """Return the rows of each set, in order of appearance of the sets.

    A set that contains both planes and lines is split, because poles and lines cannot be averaged
    together.
    """
    names = ["all"] * len(table) if column is None else table.column(column)
    if column is not None and not all(names):
        warnings.append(Finding("stats.unnamed-set", column=column, set=UNASSIGNED_NAME))
        names = [name or UNASSIGNED_NAME for name in names]
    rows: dict[str, list[int]] = {}
    for i, name in enumerate(names):
        rows.setdefault(name, []).append(i)
    result: dict[str, IntArray] = {}
    for name, members in rows.items():
        set_rows = np.asarray(members, dtype=np.int64)
        is_plane = table.is_plane[set_rows]
        kinds = {} if table.kinds is None else dict.fromkeys(table.kinds[i] for i in members)
        if len(kinds) > 1:
            kind_names = [kind or "no kind" for kind in kinds]
            warnings.append(Finding("stats.several-kinds", set=name, kinds=kind_names))
        if is_plane.all() or not is_plane.any():
            result[name] = set_rows
            continue
        warnings.append(Finding("stats.planes-and-lines", set=name))
        result[f"{name} (poles)"] = set_rows[is_plane]
        result[f"{name} (lines)"] = set_rows[~is_plane]
    return result
