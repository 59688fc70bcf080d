"""Bands of planes that contain straight traces."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from vomstudio.api.checking import name_argument_in_errors, require_positive
from vomstudio.api.point_arguments import points as convert_points
from vomstudio.api.tables import to_orientation_table
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geology.band_figures import BandFigures, describe_band, table_priors
from vomstudio.geology.plane_bands import CrossingPlane, PlaneBand, crossing_plane, find_plane_band
from vomstudio.geometry.planes import fit_plane

if TYPE_CHECKING:
    from vomstudio.api.argument_types import OrientationsArgument, VerticesArgument


def plane_band(
    points: VerticesArgument,
    *,
    sets: OrientationsArgument | None = None,
    resolution_m: float | None = None,
) -> BandFigures | None:
    """Compute the planes compatible with a straight trace, and the sets it may belong to.

    Parameters
    ----------
    points : (n, 3) array or DataFrame
        Points of a trace in order, in the World frame, metres, or a DataFrame with x, y, z.
    sets : DataFrame or path, optional
        Table of planes as for `vs.stats`, with a column ``set``; if None, the trace is not
        compared with sets.
    resolution_m : float, optional
        Resolution of the model, metres; it adds to the error of the line of the trace.

    Returns
    -------
    BandFigures or None
        None if the points determine a plane (95 % error within 15 degrees) or not even a
        line. Otherwise ``trend_deg``, ``plunge_deg`` of the line of the trace;
        ``half_width95_deg``, the maximum angle between a plane and this line; ``turn95_deg``,
        the maximum rotation about it (90 if unrestricted); ``lowest_dip_deg``,
        ``highest_dip_deg``; ``sets``, the most probable first, each with ``p``,
        ``compatible``, ``probability`` and the plane if the trace belongs to the set
        (``dip_direction_deg``, ``dip_deg``, ``max_confidence95_deg``,
        ``min_confidence95_deg``); ``none_probability``.

    Raises
    ------
    vs.errors.InputError
        If the points or the table are invalid.
    vs.errors.GeometryError
        If no plane can be fitted, or no set has three planes that form a cluster.

    Notes
    -----
    The band is the joint 95 % region of the normal (F test). Each set is weighted by its share of
    the planes and follows Fisher's distribution; the plane is the posterior mean (Bayes).

    Examples
    --------
    >>> import numpy as np
    >>> import vomstudio as vs
    >>> t = np.linspace(0, 5, 60)
    >>> noise = np.random.default_rng(1).normal(0, 0.01, (60, 3))
    >>> along = np.array([0.0, np.cos(np.radians(20)), -np.sin(np.radians(20))])
    >>> band = vs.plane_band(np.outer(t, along) + noise)
    >>> round(band.plunge_deg), round(band.lowest_dip_deg), round(band.highest_dip_deg)
    (20, 20, 90)
    """
    band = _band(points, resolution_m, "points")
    priors = [] if sets is None else table_priors(to_orientation_table(sets, name="sets"))
    return None if band is None else describe_band(band, priors)


def plane_of_crossing(
    first: VerticesArgument, second: VerticesArgument, *, resolution_m: float | None = None
) -> CrossingPlane:
    """Fit the plane of two crossing straight traces, which are assumed to be coplanar.

    Parameters
    ----------
    first, second : (n, 3) array
        Points of each trace in order, in the World frame, metres.
    resolution_m : float, optional
        Resolution of the model, metres; it adds to the errors of the lines of the traces.

    Returns
    -------
    CrossingPlane
        ``dip_direction_deg``, ``dip_deg``, ``max_confidence95_deg``,
        ``min_confidence95_deg`` (semi-axes of the joint region of the normal),
        ``crossing_deg``, the angle between the traces. `vs.fit_parallel` tests whether they
        belong to one plane.

    Raises
    ------
    vs.errors.GeometryError
        If a trace is not straight, or the traces are within 10 degrees of each other.
    vs.errors.InputError
        If the points are invalid.

    Notes
    -----
    The normal is the cross product of the lines; its covariance is propagated from theirs.

    Examples
    --------
    >>> import numpy as np
    >>> import vomstudio as vs
    >>> t, noise = np.linspace(0, 5, 60), np.random.default_rng(2).normal(0, 0.01, (2, 60, 3))
    >>> level = np.outer(t, [0, 1, 0]) + noise[0]
    >>> down = np.outer(t, [np.cos(np.radians(40)), 0, -np.sin(np.radians(40))]) + noise[1]
    >>> plane = vs.plane_of_crossing(level, down)
    >>> round(plane.dip_direction_deg), round(plane.dip_deg)
    (90, 40)
    """
    bands = [
        _band(value, resolution_m, name) for value, name in ((first, "first"), (second, "second"))
    ]
    for name, band in zip(("first", "second"), bands, strict=True):
        if band is None:
            raise GeometryError(Finding("trace.not-straight", trace=name), field=name)
    first_band, second_band = bands
    assert first_band is not None
    assert second_band is not None
    return crossing_plane(first_band, second_band)


def _band(points: Any, resolution_m: float | None, name: str) -> PlaneBand | None:
    resolution_m = require_positive(resolution_m, "resolution_m")
    array = convert_points(points, name)
    with name_argument_in_errors(name):
        return find_plane_band(fit_plane(array), resolution_m=resolution_m)
