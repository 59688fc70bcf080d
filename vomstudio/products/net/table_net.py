"""The orientations of a table as what a net shows."""

from __future__ import annotations

from typing import Any

from vomstudio.geology.common_turns import Turns
from vomstudio.geology.orientation_rows import OrientationRows
from vomstudio.geology.statistics import no_fisher_reason
from vomstudio.products.net.contents import Contouring, NetContents, make_sets, means_of

UNNAMED = "unassigned"


def net_of_table(
    table: OrientationRows,
    by: str | None = None,
    *,
    projection: str = "area",
    contour: str | None = None,
    contouring: Contouring | None = None,
) -> NetContents:
    """by : name or number of the column that tells the sets apart; None for `set`, else `kind`.
    Raises UsageError for a column that is not there."""
    groups: dict[str, tuple[str, Any, Any]] = {}
    turns: dict[str, Turns] = {}
    for name, members in members_of(table, by).items():
        for kind, wanted in (("plane", True), ("line", False)):
            rows = [i for i in members if table.is_plane[i] == wanted]
            if not rows:
                continue
            both = len(rows) < len(members)
            label = f"{name} ({kind}s)" if both else name
            azimuth, angle = (
                (table.dip_direction_deg, table.dip_deg)
                if wanted
                else (table.trend_deg, table.plunge_deg)
            )
            groups[label] = (kind, azimuth[rows], angle[rows])
            if table.turns is not None:
                turns[label] = table.turns.of(rows)
    sets = make_sets(groups, turns=turns)
    # A mean of a girdle, or of a scatter, is a mark that means nothing.
    clustered = [s for s in sets if no_fisher_reason(s.vectors(), False) is None]
    return NetContents(
        sets=sets,
        projection=projection,
        contour=contour,
        contouring=contouring or Contouring(),
        means=means_of(clustered),
    )


def members_of(table: OrientationRows, column: str | None) -> dict[str, list[int]]:
    """Rows by the column asked for, else by set, else by kind, else all together."""
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
