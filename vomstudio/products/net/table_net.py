"""Stereonet of the orientations in a table."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.geology.common_rotation_errors import RotationErrors
from vomstudio.geology.orientation import Plane
from vomstudio.geology.orientation_rows import OrientationRows
from vomstudio.geology.statistics import no_fisher_reason
from vomstudio.io.text.repeated_rows import repeats_note
from vomstudio.products.net.contents import (
    Contouring,
    NetContents,
    NetEllipse,
    compute_means,
    make_sets,
)

UNNAMED = "unassigned"


def net_from_table(
    table: OrientationRows,
    by: str | None = None,
    *,
    projection: str = "area",
    contour: str | None = None,
    contouring: Contouring | None = None,
) -> NetContents:
    """Build the net of a table.

    Parameters
    ----------
    table : OrientationRows
    by : str or None
        Name or number of the column that contains the sets. By default, `set` or, if missing,
        `kind`.
    projection, contour, contouring
        As in `NetContents`.

    Raises
    ------
    UsageError
        If the column is missing, or if the table does not contain the set to contour.
    """
    groups: dict[str, tuple[str, Any, Any]] = {}
    rotation_errors_by_name: dict[str, RotationErrors] = {}
    rows_by_name = group_rows(table, by)
    contoured_name = None if contouring is None else contouring.set_name
    if contoured_name is not None and contoured_name not in rows_by_name:
        finding = Finding("option.not-a-choice", value=contoured_name, choices=tuple(rows_by_name))
        raise UsageError(finding, file=table.path, field="--contour-set")
    names: dict[str, str] = {}
    for name, members in rows_by_name.items():
        for kind, is_plane in (("plane", True), ("line", False)):
            rows = [i for i in members if table.is_plane[i] == is_plane]
            if not rows:
                continue
            has_both_kinds = len(rows) < len(members)
            label = f"{name} ({kind}s)" if has_both_kinds else name
            azimuth, angle = (
                (table.dip_direction_deg, table.dip_deg)
                if is_plane
                else (table.trend_deg, table.plunge_deg)
            )
            groups[label] = (kind, azimuth[rows], angle[rows])
            names[label] = name
            if table.rotation_errors is not None:
                rotation_errors_by_name[label] = table.rotation_errors.of(rows)
    sets = tuple(
        replace(net_set, group=names[net_set.name])
        for net_set in make_sets(groups, rotation_errors=rotation_errors_by_name)
    )
    # The mean of a girdle or a scattered set is meaningless and therefore not marked.
    clustered_sets = [set_ for set_ in sets if no_fisher_reason(set_.vectors(), False) is None]
    return NetContents(
        sets=sets,
        projection=projection,
        contour=contour,
        contouring=contouring or Contouring(),
        means=compute_means(clustered_sets),
        notes=repeats_note(table.repeats),
    )


def replace_colors(net: NetContents, colors: Mapping[str, str]) -> NetContents:
    """Replace the colours (#rrggbb) of named sets and of their means."""
    if not colors:
        return net
    sets = tuple(replace(set_, color=colors.get(set_.name, set_.color)) for set_ in net.sets)
    # If there are more sets than colours, two sets may share a colour. Means follow their sets.
    new_colors = {
        (set_.color, set_.marker): new_set.color
        for set_, new_set in zip(net.sets, sets, strict=True)
    }
    means = tuple(
        replace(mean, color=new_colors.get((mean.color, mean.marker), mean.color))
        for mean in net.means
    )
    return replace(net, sets=sets, means=means)


_ERROR_COLUMNS = ("max_confidence95_deg", "min_confidence95_deg", "error_rake_deg")


def error_ellipses(table: OrientationRows) -> tuple[NetEllipse, ...]:
    """Return the 95 % ellipse of each plane that has an error in the table.

    Raises
    ------
    UsageError
        If the table contains no errors.
    """
    try:
        cells = [table.column(name) for name in _ERROR_COLUMNS]
    except UsageError:
        cells = [[], [], []]
    try:
        totals = list(table.column("total95_deg"))
    except UsageError:
        totals = [""] * len(cells[0])
    ellipses = []
    for row, (*cell_texts, total_deg) in enumerate(zip(*cells, totals, strict=True)):
        major_deg, minor_deg, rake = (_number(word) for word in cell_texts)
        if table.is_plane[row] and math.isfinite(major_deg + minor_deg + rake):
            plane = Plane(float(table.dip_direction_deg[row]), float(table.dip_deg[row]))
            total_error_deg = _number(total_deg)
            total_error_deg = total_error_deg if math.isfinite(total_error_deg) else major_deg
            ellipses.append(
                NetEllipse.enlarge_to_total(plane, major_deg, minor_deg, rake, total_error_deg)
            )
    if not ellipses:
        raise UsageError(
            Finding("net.no-errors", columns=_ERROR_COLUMNS),
            file=table.path,
            field="--errors",
        )
    return tuple(ellipses)


def _number(word: str) -> float:
    try:
        return float(word)
    except ValueError:
        return math.nan


def group_rows(table: OrientationRows, column: str | None) -> dict[str, list[int]]:
    """Group rows by a column; by default by set, else by kind, else into planes and lines."""
    if column is not None:
        names = table.column(column)
    elif table.sets is not None and any(table.sets):
        names = list(table.sets)
    elif table.kinds is not None and any(table.kinds):
        names = list(table.kinds)
    else:
        names = ["planes" if plane else "lines" for plane in table.is_plane]
    rows: dict[str, list[int]] = {}
    for i, name in enumerate(names):
        rows.setdefault(name or UNNAMED, []).append(i)
    return rows
