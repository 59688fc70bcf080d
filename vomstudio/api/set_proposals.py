"""Sets proposed among planes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from vomstudio.api.checking import items_of, joined, numbers, plane_text, warn
from vomstudio.api.declared_options import arguments_named, options_from_arguments
from vomstudio.api.tables import Azimuth, frame_of_table, rows_of
from vomstudio.core.results import HIDDEN
from vomstudio.geology.sets.proposals import SetProposal, propose_sets
from vomstudio.geology.sets.set_options import SetOptions
from vomstudio.io.gate.point_tables import read_places
from vomstudio.io.text.set_columns import DISCONTINUITY, PROBABILITY, SET, pieces_of


@dataclass(frozen=True, repr=False)
class ProposedSets(SetProposal):
    """table : DataFrame of the rows with ``set`` ("" for none) and ``set_probability``"""

    table: Any = field(default=None, metadata=HIDDEN)


def sets(
    table: Any,
    *,
    max_sets: int | None = None,
    exactly: int | None = None,
    seeds: Sequence[tuple[float, float] | str] | None = None,
    scanline: Any = None,
    azimuth: Azimuth | None = None,
) -> ProposedSets:
    """Propose sets among planes, with a class of those that belong to none.

    Parameters
    ----------
    table : DataFrame of orientations, the path of a file, or two arrays (dip direction, dip), (n,)
        each, degrees; lines in it are left out
    max_sets : maximum number of proposed sets; None for 8
    exactly : this number of sets, at most that of the planes; excludes ``max_sets`` and ``seeds``
    seeds : (dip direction, dip) or "DD/D" of one plane of each set, in place of a number
    scanline : (2, 3) ends of a straight line, World, m, along which spacing is reported too
    azimuth : what a column called only ``azimuth`` means: "strike" or "dipdir"

    Returns
    -------
    ProposedSets: ``n``, ``sets`` (each ``name``, ``n``, ``dip_direction_deg``, ``dip_deg``,
    ``kappa``, ``cone95_deg``, ``fit``, and, None without x, y, z in metres, ``discontinuities``,
    ``spacing_m``, ``persistence_dip_m``, ``persistence_strike_m``, ``area_m2``, ``p32_1_per_m``
    with its interval, ``rests_on`` and the others of the command), ``unassigned``,
    ``discontinuities``, and ``table``, a DataFrame with the columns ``set``, ``set_probability``
    and, where borders or lambda1 to lambda3 are known, ``discontinuity``: yours with them, or the
    orientation table of a file.

    Raises
    ------
    vs.errors.GeometryError for tables without planes; vs.errors.UsageError for seeds that are alike
    or more than ``max_sets``, and for ``exactly`` with either; vs.errors.InputError as `stats`.

    A mixture of Bingham distributions and an even scatter, its number by Schwarz's
    criterion with a price on sets that overlap (after Biernacki, Celeux & Govaert 2000); means and
    kappa after Fisher (1953). Discontinuities, spacing and persistence after Riquelme et al. (2014,
    2015, 2018).

    Examples
    --------
    >>> import vomstudio as vs
    >>> steep = [90, 271, 92, 268, 91, 89, 94], [88, 89, 87, 86, 90, 87, 88]
    >>> flat = [20, 25, 18, 30, 22, 24], [31, 34, 32, 35, 33, 34]
    >>> found = vs.sets((steep[0] + flat[0], steep[1] + flat[1]))
    >>> [(s.name, s.n, round(s.dip_deg)) for s in found.sets], found.unassigned
    ([('S1', 7, 89), ('S2', 6, 33)], 0)
    """
    rows = rows_of(table, azimuth)
    given = [] if seeds is None else items_of(seeds, "seeds")
    options = options_from_arguments(
        SetOptions,
        max_sets=max_sets,
        exactly=exactly,
        seeds=",".join(plane_text(seed, "seeds") for seed in given) or None,
        scanline=None if scanline is None else joined(numbers(scanline, "scanline")),
    )
    placed = read_places(rows)
    places = None if placed is None else placed.points
    with arguments_named(SetOptions):
        found = propose_sets(rows, options, pieces=pieces_of(rows, places))
    # A table that was handed over keeps its own columns.
    own_frame = hasattr(table, "columns") and hasattr(table, "itertuples")
    frame = table.copy() if own_frame else frame_of_table(rows, rows.warnings)
    where = np.asarray(found.rows, np.int64)
    where = rows.row_indices[where] if own_frame else where
    names, shares = np.full(len(frame), "", dtype=object), np.full(len(frame), np.nan)
    names[where], shares[where] = found.assignment, found.probability
    frame[SET], frame[PROBABILITY] = names, shares
    if found.discontinuity:
        ids = np.full(len(frame), "", dtype=object)
        ids[where] = found.discontinuity
        frame[DISCONTINUITY] = ids
    findings = () if placed is None else placed.findings
    warn([*findings, *found.warnings[len(rows.warnings) :]])
    own = {f.name: getattr(found, f.name) for f in fields(SetProposal)}
    own["warnings"] = (*findings, *found.warnings)
    return ProposedSets(**own, table=frame)
