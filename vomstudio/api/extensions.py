"""A plane carried on through a model."""

from __future__ import annotations

from typing import Any

import numpy as np

from vomstudio.api.checking import naming, numbers, points, required_number, single_number, warn
from vomstudio.api.comparisons import placed
from vomstudio.api.planes import plane_text
from vomstudio.errors import InputError, UsageError
from vomstudio.geology.beds.extended import PlaneBelief, belief_of_attitude, belief_of_fit
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.planes import fit_plane
from vomstudio.products.section.curtain import parse_section_plane
from vomstudio.products.section.extension import ExtendedPlane
from vomstudio.products.section.extension import extend as _extend
from vomstudio.words import tr


def extend(
    model: Any,
    of: Any = None,
    *,
    plane: Any = None,
    through: Any = None,
    error_deg: float | None = None,
    through_error_m: float = 0.0,
    thickness_m: float | None = None,
    thickness_error_m: float = 0.0,
) -> ExtendedPlane:
    """Carry a plane on through a model, with the 95 % error of its position at every place.

    Parameters
    ----------
    model : Mesh, PointCloud, a model of a project, the path of a file, or an array (n, 3) of points
        in World, metres
    of : (k, 3) points of the plane in their order along the trace, World, m
    plane, through, error_deg, through_error_m : or the plane as "DD/D" or (dip direction, dip), a
        point (3,) on it, and the 95 % errors of both, degrees and metres
    thickness_m, thickness_error_m : repeat it at this thickness; 95 % error of that

    Returns
    -------
    ExtendedPlane: ``beds`` (each ``bed``, its number upwards, 0 the plane itself, ``offset_m``,
    ``traces``, ``length_m``, ``least_error95_m``, ``most_error95_m``), ``traces`` (each ``bed``,
    ``points`` (n, 3) World, ``error95_m`` (n,) across the plane), ``bands`` (of the model's points,
    (n,) each: ``bed`` nearest, ``distance_m``, ``error95_m``, ``inside``), ``max_error95_deg``.

    Raises
    ------
    vs.errors.GeometryError for a plane whose errors are not known, and where none meets the model;
    vs.errors.UsageError for a thickness that is none.

    The variance of a regression's prediction, s2 (1/n + u2/sum u2 + v2/sum v2), with as many points
    as are independent along the trace; bands of Student's t. For planes on outcrops Quinn & Ehlmann
    2019, doi 10.1029/2018EA000416.

    Examples
    --------
    >>> import numpy as np
    >>> import vomstudio as vs
    >>> x, y = (a.ravel() for a in np.meshgrid(np.arange(0, 20, 0.2), np.arange(0, 20, 0.2)))
    >>> ground = np.column_stack([x, y, 0.1 * x])
    >>> found = vs.extend(ground, plane=(90, 45), through=(5, 10, 0.5), error_deg=2)
    >>> found.beds[0].least_error95_m < 0.05, 0.2 < found.beds[0].most_error95_m < 0.4
    (True, True)
    """
    from vomstudio.io.models.opening import point_spacing

    data, _, _ = placed(model, "model")
    spacing = point_spacing(data) if isinstance(data, PointCloud) else 0.0
    found = _extend(
        data,
        _belief(of, plane, through, error_deg, through_error_m),
        thickness_m=single_number(thickness_m, "thickness_m"),
        thickness_error_m=required_number(thickness_error_m, "thickness_error_m"),
        spacing=spacing if np.isfinite(spacing) else 0.0,
    )
    warn(found.warnings)
    return found


def _belief(of: Any, plane: Any, through: Any, error_deg: Any, through_error_m: Any) -> PlaneBelief:
    """Raises UsageError, InputError, GeometryError."""
    if (of is None) == (plane is None):
        raise UsageError(
            tr("Give the points of the plane, or plane= with through= and error_deg=.")
        )
    of_point = required_number(through_error_m, "through_error_m")
    if of is not None:
        alone = {"through": through, "error_deg": error_deg, "through_error_m": of_point or None}
        for name, value in alone.items():
            if value is not None:
                raise UsageError(tr("This belongs to plane=, not to points of it."), field=name)
        array = points(of, "of")
        with naming("of"):
            return belief_of_fit(fit_plane(array))
    error = single_number(error_deg, "error_deg")
    if through is None or error is None:
        raise UsageError(tr("A plane needs through= and error_deg=."), field="through")
    point = numbers(through, "through")
    if point.shape != (3,) or not np.isfinite(point).all():
        raise InputError(tr("A point is three numbers, x, y, z of World."), field="through")
    with naming("plane"):
        attitude = parse_section_plane(str(plane_text(plane)))
    return belief_of_attitude(attitude, point, error, of_point)
