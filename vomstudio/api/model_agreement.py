"""The orientations of two models held against each other."""

from __future__ import annotations

from typing import Any

from vomstudio.api.tables import rows_of
from vomstudio.geology import model_agreement as of_planes
from vomstudio.geology.model_agreement import Agreement
from vomstudio.io.text.oriented_planes import extract_planes


def agreement(first: Any, second: Any) -> Agreement:
    """Whether the planes that two models of the same rock give agree within their errors.

    Parameters
    ----------
    first, second : tables of planes: DataFrames as of ``vs.fit_planes``, ``vs.read_orientations``
        or ``Project.planes``, or paths of files. Of their columns ``name``, ``kind``, ``x``, ``y``,
        ``z`` (World, metres), ``extent_m`` and ``total95_deg`` (else ``max_confidence95_deg``)
        each may be missing

    Returns
    -------
    Agreement: ``matched``, one for each two planes that are the same structure, with ``first``,
    ``second`` (names), ``by`` ("name" or "nearness"), ``distance_m``, ``angle_deg`` (0 to 90),
    ``error95_deg`` (the root of the sum of squares of both 95 % half-angles) and ``agree``; ``n``,
    ``by_name``, ``by_nearness``, ``unmatched`` (of the first, of the second),
    ``median_angle_deg``, ``rms_angle_deg``, ``agree_share``. None where not known.

    By name where each table has one plane of that name; of the others by nearness: of the same
    kind, each the nearest to the other, no farther apart than half of the longer one's extent.

    Raises
    ------
    vs.errors.InputError for a table without planes, or with angles that cannot be.

    Source: the angle between two poles; independent errors add as squares.

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
        extract_planes(rows_of(table, name=name))
        for table, name in ((first, "first"), (second, "second"))
    ]
    return of_planes.agreement(*planes)
