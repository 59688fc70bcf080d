"""Comparison of the plane orientations of two models."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vomstudio.api.tables import to_orientation_table
from vomstudio.geology import model_agreement as of_planes
from vomstudio.geology.model_agreement import Agreement
from vomstudio.io.text.oriented_planes import extract_planes

if TYPE_CHECKING:
    from vomstudio.api.argument_types import TableArgument


def agreement(first: TableArgument, second: TableArgument) -> Agreement:
    """Test whether planes of two models of the same rock agree within their errors.

    Parameters
    ----------
    first, second : DataFrame or path
        Tables of planes: DataFrames such as those from ``vs.fit_planes``,
        ``vs.read_orientations`` or ``Project.planes``, or paths of files. The columns ``name``,
        ``kind``, ``x``, ``y``, ``z`` (World, metres), ``extent_m`` and ``total95_deg``
        (otherwise ``max_confidence95_deg``) are all optional.

    Returns
    -------
    Agreement
        ``matched``, one pair per structure, with ``first``, ``second`` (names), ``by``
        ("name" or "nearness"), ``distance_m``, ``angle_deg`` (0 to 90), ``error95_deg``
        (root of the sum of squares of both 95 % half-angles) and ``agree``; ``n``,
        ``by_name``, ``by_nearness``, ``unmatched`` (number of planes in the first and
        in the second table), ``median_angle_deg``, ``rms_angle_deg``, ``agree_share``. Unknown
        values are returned as None.

        Planes are matched by name if it is unique in each table, others by nearness: mutual
        nearest neighbours of the same kind, within half the extent of the larger one.

    Raises
    ------
    vs.errors.InputError
        If a table contains no planes or invalid angles.

    Notes
    -----
    The angle is that between the two poles. The squares of independent errors are added.

    Examples
    --------
    >>> import pandas as pd
    >>> import vomstudio as vs
    >>> head = ["name", "dip_direction_deg", "dip_deg", "total95_deg"]
    >>> one = pd.DataFrame([["B1", 90.0, 30.0, 3.0]], columns=head)
    >>> other = pd.DataFrame([["B1", 90.0, 34.0, 4.0]], columns=head)
    >>> (same,) = vs.agreement(one, other).matched
    >>> round(same.angle_deg, 6), same.error95_deg, same.agree
    (4.0, 5.0, True)
    """
    planes = [
        extract_planes(to_orientation_table(table, name=name))
        for table, name in ((first, "first"), (second, "second"))
    ]
    return of_planes.compare_orientations(*planes)
