"""Proposal of sets among planes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, cast

import numpy as np

from vomstudio.api.checking import join_numbers, numbers, plane_text, to_list, warn
from vomstudio.api.declared_options import name_arguments_in_errors, options_from_arguments
from vomstudio.api.tables import Azimuth, table_to_dataframe, to_orientation_table
from vomstudio.core.results import HIDDEN_IN_JSON
from vomstudio.geology.sets.proposals import SetProposal, propose_sets
from vomstudio.geology.sets.set_options import SetOptions
from vomstudio.io.gate.point_tables import read_row_positions
from vomstudio.io.text.set_columns import DISCONTINUITY, PROBABILITY, SET, extract_pieces

if TYPE_CHECKING:
    import pandas
    from numpy.typing import ArrayLike

    from vomstudio.api.argument_types import OrientationsArgument


@dataclass(frozen=True, repr=False)
class ProposedSets(SetProposal):
    """Proposed sets; ``table`` has the columns ``set`` ("" if none) and ``set_probability``."""

    table: pandas.DataFrame = field(default=None, metadata=HIDDEN_IN_JSON)


def sets(
    table: OrientationsArgument,
    *,
    max_sets: int | None = None,
    exactly: int | None = None,
    seeds: Sequence[tuple[float, float] | str] | None = None,
    scanline: ArrayLike | None = None,
    azimuth: Azimuth | None = None,
) -> ProposedSets:
    """Propose sets among planes, with a class of outliers.

    Parameters
    ----------
    table : DataFrame, path, or (dip direction, dip)
        DataFrame of orientations, path of a file, or two arrays (dip direction, dip), (n,)
        each, degrees. Lines in the table are omitted.
    max_sets : int, optional
        Maximum number of proposed sets; by default 8.
    exactly : int, optional
        Exact number of sets, at most the number of planes; cannot be combined with
        ``max_sets`` or ``seeds``.
    seeds : sequence of (float, float) or str, optional
        (dip direction, dip) or "DD/D" of one plane of each set, instead of a number of sets.
    scanline : (2, 3) array, optional
        End points of a straight line in the World frame, m, along which the spacing
        is also reported.
    azimuth : {"strike", "dipdir"}, optional
        Meaning of a column named only ``azimuth``: "strike" or "dipdir".

    Returns
    -------
    ProposedSets
        ``n``, ``sets`` (each with ``name``, ``n``, ``dip_direction_deg``, ``dip_deg``,
        ``kappa``, ``cone95_deg``, ``fit`` and, if the table contains x, y, z in metres,
        ``discontinuities``, ``spacing_m``, ``persistence_dip_m``, ``persistence_strike_m``,
        ``area_m2``, ``p32_1_per_m`` with its interval, ``rests_on`` and the other figures of
        the command), ``unassigned``, ``discontinuities``, and ``table``: the given DataFrame,
        or the orientation table of a file, with additional columns ``set``,
        ``set_probability`` and, if borders or lambda1 to lambda3 are known,
        ``discontinuity``.

    Raises
    ------
    vs.errors.GeometryError
        If the table contains no planes.
    vs.errors.UsageError
        If seeds are too similar or more than ``max_sets``, or if ``exactly`` is combined
        with either.
    vs.errors.InputError
        Under the conditions of `stats`.

    Notes
    -----
    The model is a mixture of Bingham distributions and a uniform distribution. The number of sets
    follows from Schwarz's criterion with a penalty for overlapping sets (after Biernacki, Celeux
    & Govaert 2000), means and kappa follow Fisher (1953), and discontinuities, spacing and
    persistence follow Riquelme et al. (2014, 2015, 2018).

    Examples
    --------
    >>> import vomstudio as vs
    >>> steep = [90, 271, 92, 268, 91, 89, 94], [88, 89, 87, 86, 90, 87, 88]
    >>> flat = [20, 25, 18, 30, 22, 24], [31, 34, 32, 35, 33, 34]
    >>> proposal = vs.sets((steep[0] + flat[0], steep[1] + flat[1]))
    >>> [(s.name, s.n, round(s.dip_deg)) for s in proposal.sets], proposal.unassigned
    ([('S1', 7, 89), ('S2', 6, 33)], 0)
    """
    rows = to_orientation_table(table, azimuth)
    seed_list = [] if seeds is None else to_list(seeds, "seeds")
    options = options_from_arguments(
        SetOptions,
        locals(),
        seeds=",".join(plane_text(seed, "seeds") for seed in seed_list) or None,
        scanline=None if scanline is None else join_numbers(numbers(scanline, "scanline")),
    )
    places = read_row_positions(rows)
    positions = None if places is None else places.points
    with name_arguments_in_errors(SetOptions):
        proposal = propose_sets(rows, options, pieces=extract_pieces(rows, positions))
    # A DataFrame keeps its columns.
    is_dataframe = hasattr(table, "columns") and hasattr(table, "itertuples")
    frame = (
        cast("pandas.DataFrame", table).copy()
        if is_dataframe
        else table_to_dataframe(rows, rows.warnings)
    )
    row_indices = np.asarray(proposal.rows, np.int64)
    row_indices = rows.row_indices[row_indices] if is_dataframe else row_indices
    names, shares = np.full(len(frame), "", dtype=object), np.full(len(frame), np.nan)
    names[row_indices], shares[row_indices] = proposal.assignment, proposal.probability
    frame[SET], frame[PROBABILITY] = names, shares
    if proposal.discontinuity:
        ids = np.full(len(frame), "", dtype=object)
        ids[row_indices] = proposal.discontinuity
        frame[DISCONTINUITY] = ids
    findings = () if places is None else places.findings
    warn([*findings, *proposal.warnings[len(rows.warnings) :]])
    values = {f.name: getattr(proposal, f.name) for f in fields(SetProposal)}
    values["warnings"] = (*findings, *proposal.warnings)
    return ProposedSets(**values, table=frame)
