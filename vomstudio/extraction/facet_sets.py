"""Sets among the facets of a model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.extraction.facet_table import WKT, FacetTable
from vomstudio.extraction.facets import Facet
from vomstudio.geology.orientation import planes_to_poles
from vomstudio.geology.sets.discontinuities import Pieces
from vomstudio.geology.sets.proposals import (
    DescribedSet,
    SetProposal,
    describe_proposal,
    propose_sets_of_poles,
)
from vomstudio.io.text.set_columns import DISCONTINUITY, parse_rings


def with_sets(found: FacetTable, facets: list[Facet]) -> FacetTable:
    """The facets with the sets that `vomstudio sets` proposes among their planes, each facet
    counting once: in the rows by name, with the discontinuity that each is a piece of, in `set_of`
    by place among the sets, -1 for none. facets : of the rows"""
    if not found.rows:
        return found
    return with_proposal(found, facets, propose_sets_of_poles(poles_of(found)))


def with_proposal(found: FacetTable, facets: list[Facet], proposal: SetProposal) -> FacetTable:
    """The same with sets that are already known; `proposal` : for the facets in their order."""
    proposal = describe_proposal(proposal, poles_of(found), pieces_of_facets(found, facets))
    names = [one.name for one in proposal.sets]
    number = np.full(len(found.rows) + 1, -1, np.int32)
    rows = list(found.rows)
    for row, (name, id_) in enumerate(
        zip(proposal.assignment, proposal.discontinuity, strict=True)
    ):
        rows[row] = {**rows[row], "set": name or None, DISCONTINUITY: id_ or None}
        number[row] = names.index(name) if name else -1
    return replace(
        found,
        rows=rows,
        sets=tuple(one for one in proposal.sets if isinstance(one, DescribedSet)),
        discontinuities=proposal.discontinuities,
        set_of=number[found.facet],
        warnings=(*found.warnings, *proposal.warnings),
    )


def poles_of(found: FacetTable) -> FloatArray:
    """(n, 3) of the rows."""
    direction, dip = (
        np.array([row[name] for row in found.rows], np.float64)
        for name in ("dip_direction_deg", "dip_deg")
    )
    return planes_to_poles(direction, dip)


def pieces_of_facets(found: FacetTable, facets: list[Facet]) -> Pieces:
    """What the facets tell of where they are and how far they reach."""
    fits = [facet.fit for facet in facets]
    axes = np.array([fit.axes for fit in fits])
    spread = np.array([fit.eigenvalues * (fit.trace or 0.0) for fit in fits])
    return Pieces(
        np.array([fit.centroid for fit in fits]),
        np.asarray(np.einsum("mki,mk,mkj->mij", axes, spread, axes)),
        np.array([facet.area for facet in facets]),
        parse_rings([row[WKT] for row in found.rows]),
    )
