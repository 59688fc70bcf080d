"""Sets among the facets of a model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vomstudio.extraction.facet_table import FacetTable
from vomstudio.geology.sets.proposals import propose_sets
from vomstudio.io.text.orientation_reading import orientations_of
from vomstudio.io.text.tables import table_of_cells

_ANGLES = ("dip_direction_deg", "dip_deg")


def with_sets(found: FacetTable) -> FacetTable:
    """The facets with the sets that `vomstudio sets` proposes among their planes, each facet
    counting once: in the rows by name, in `set_of` by place among the sets, -1 for none."""
    if not found.rows:
        return found
    cells = [[repr(float(row[name])) for name in _ANGLES] for row in found.rows]
    table = orientations_of(table_of_cells(_ANGLES, cells, "facets"), None)
    places = np.array([[row[axis] for axis in "xyz"] for row in found.rows], np.float64)
    proposal = propose_sets(table, places=places)
    names = [one.name for one in proposal.sets]
    number = np.full(len(found.rows) + 1, -1, np.int32)
    rows = list(found.rows)
    for row, name in zip(proposal.rows, proposal.assignment, strict=True):
        rows[row] = {**rows[row], "set": name or None}
        number[row] = names.index(name) if name else -1
    return replace(
        found,
        rows=rows,
        sets=[vars(one).copy() for one in proposal.sets],
        set_of=number[found.facet],
        warnings=(*found.warnings, *proposal.warnings),
    )
