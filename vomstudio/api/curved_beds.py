"""Surfaces of curved beds."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vomstudio.api.checking import warn
from vomstudio.api.planes import to_groups
from vomstudio.geology.beds.curved import CurvedBed, curved_bed

if TYPE_CHECKING:
    from collections.abc import Hashable

    from vomstudio.api.argument_types import GroupsArgument


def fit_curved(groups: GroupsArgument, *, by: Hashable | None = None) -> CurvedBed:
    """Fit a surface to several traces of a curved bed, and compute its local dip.

    Parameters
    ----------
    groups : dict of id to (n, 3) array, or DataFrame
        See `fit_planes`; the points of each trace must be in order along it, in the World
        frame, m.
    by : str, optional
        See `fit_planes`.

    Returns
    -------
    CurvedBed
        ``degree`` of the polynomial (1 for a plane), ``p`` (p-value of the hypothesis that
        the bed is a plane), ``rms_m``, ``n``, ``n_effective``; ``dips`` (for each trace
        ``id``, the position ``x``, ``y``, ``z`` on the surface, ``dip_direction_deg``,
        ``dip_deg``, ``error95_deg``, joint 95 %), ``local_dips`` (n, 3): dip direction, dip
        and error at all points, degrees.

    Raises
    ------
    vs.errors.InputError, vs.errors.UsageError
        Under the conditions of `fit_planes`.
    vs.errors.GeometryError
        If the points do not determine a surface.

    Notes
    -----
    The surface is a trend surface over a mean plane (Krumbein 1959; Davis 2002), whose degree is
    selected by F tests.

    Examples
    --------
    Two traces on a fold of 50 m radius, one on each side of its crest:

    >>> import numpy as np
    >>> import vomstudio as vs
    >>> rng = np.random.default_rng(1)
    >>> def trace(start, y):
    ...     a = np.radians(start + np.linspace(0, 15, 60))
    ...     winding = y + 5 * np.sin(np.linspace(0, 3, 60))
    ...     r = 50 + 0.01 * rng.standard_normal(60)
    ...     return np.column_stack([r * np.sin(a), winding, r * np.cos(a)])
    >>> bed = vs.fit_curved({"west": trace(-17, 0), "east": trace(2, 8)})
    >>> [(dip.id, round(dip.dip_deg)) for dip in bed.dips], bed.degree > 1
    ([('west', 10), ('east', 9)], True)
    """
    point_groups = to_groups(groups, by)
    bed = curved_bed(
        [str(name) for name in point_groups.ids], point_groups.points, point_groups.offsets
    )
    warn(point_groups.messages)
    return bed
