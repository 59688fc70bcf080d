"""Sets of the facets of a model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.extraction.facet_table import WKT_COLUMN, FacetTable
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


def add_sets(table: FacetTable, facets: list[Facet]) -> FacetTable:
    """Add the sets proposed for the planes of facets, as in `vomstudio sets`.

    Each facet counts once. The rows receive the names of the set and of the discontinuity, and
    `set_of` receives the index of the set, -1 for none.

    Parameters
    ----------
    table : FacetTable
    facets : list of Facet
        Facets that correspond to the rows.

    Returns
    -------
    FacetTable
    """
    if not table.rows:
        return table
    return add_proposal(table, facets, propose_sets_of_poles(facet_poles(table)))


def add_proposal(table: FacetTable, facets: list[Facet], proposal: SetProposal) -> FacetTable:
    """Add the sets of a proposal to a table of facets.

    Parameters
    ----------
    table : FacetTable
    facets : list of Facet
    proposal : SetProposal
        Proposal in the order of the facets.

    Returns
    -------
    FacetTable
    """
    proposal = describe_proposal(proposal, facet_poles(table), facet_pieces(table, facets))
    names = [described_set.name for described_set in proposal.sets]
    number = np.full(len(table.rows) + 1, -1, np.int32)
    rows = list(table.rows)
    for row, (name, id_) in enumerate(
        zip(proposal.assignment, proposal.discontinuity, strict=True)
    ):
        rows[row] = {**rows[row], "set": name or None, DISCONTINUITY: id_ or None}
        number[row] = names.index(name) if name else -1
    return replace(
        table,
        rows=rows,
        sets=tuple(
            described_set
            for described_set in proposal.sets
            if isinstance(described_set, DescribedSet)
        ),
        discontinuities=proposal.discontinuities,
        set_of=number[table.facet],
        warnings=(*table.warnings, *proposal.warnings),
    )


def facet_poles(table: FacetTable) -> FloatArray:
    """Return the poles of the facets in a table.

    Parameters
    ----------
    table : FacetTable

    Returns
    -------
    (n, 3) ndarray
        In the World frame.
    """
    direction, dip = (
        np.array([row[name] for row in table.rows], np.float64)
        for name in ("dip_direction_deg", "dip_deg")
    )
    return planes_to_poles(direction, dip)


def facet_pieces(table: FacetTable, facets: list[Facet]) -> Pieces:
    """Return the positions and extents of facets, for deriving discontinuities.

    Parameters
    ----------
    table : FacetTable
    facets : list of Facet

    Returns
    -------
    Pieces
    """
    fits = [facet.fit for facet in facets]
    axes = np.array([fit.axes for fit in fits])
    spread = np.array([fit.eigenvalues * (fit.trace or 0.0) for fit in fits])
    return Pieces(
        np.array([fit.centroid for fit in fits]),
        np.asarray(np.einsum("mki,mk,mkj->mij", axes, spread, axes)),
        np.array([facet.area for facet in facets]),
        parse_rings([row[WKT_COLUMN] for row in table.rows]),
    )
