"""Extension of a plane through a model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from vomstudio.api.checking import name_argument_in_errors, numbers, warn
from vomstudio.api.comparisons import load_world_data
from vomstudio.api.declared_options import name_arguments_in_errors, options_from_arguments
from vomstudio.api.planes import plane_text
from vomstudio.api.point_arguments import points
from vomstudio.geology.beds.extended import (
    PlaneEstimate,
    plane_estimate_from_attitude,
    plane_estimate_from_fit,
)
from vomstudio.geology.notation import parse_plane_option
from vomstudio.geometry.planes import fit_plane
from vomstudio.products.section.extend_options import ExtendOptions
from vomstudio.products.section.extension import ExtendedPlane
from vomstudio.products.section.extension import extend as _extend
from vomstudio.products.section.section_lines import parse_through_point

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from vomstudio.api.argument_types import ModelArgument, PlaneArgument, VerticesArgument


def extend(
    model: ModelArgument,
    of: VerticesArgument | None = None,
    *,
    plane: PlaneArgument | None = None,
    through: ArrayLike | None = None,
    error_deg: float | None = None,
    through_error_m: float = 0.0,
    thickness_m: float | None = None,
    thickness_error_m: float = 0.0,
) -> ExtendedPlane:
    """Extend a plane through a model, and compute the 95 % error of its position.

    Parameters
    ----------
    model : Mesh, PointCloud, model of a project, path, or (n, 3) array
        Model in the World frame, metres.
    of : (k, 3) array, optional
        Points of the plane in order along the trace, in the World frame, metres.
    plane : str, (float, float) or PlaneFit, optional
        Alternatively, the plane as "DD/D", (dip direction, dip) or a PlaneFit.
    through : (3,) array, optional
        Point on `plane` in the World frame, metres.
    error_deg, through_error_m : float, optional
        95 % errors of `plane`, degrees, and of `through`, metres.
    thickness_m, thickness_error_m : float, optional
        Thickness at which the plane is repeated, and its 95 % error, metres.

    Returns
    -------
    ExtendedPlane
        ``beds`` (each with ``bed``, a number that increases upwards and is 0 for the plane
        itself, ``offset_m``, ``traces``, ``length_m``, ``least_error95_m``,
        ``most_error95_m``), ``traces`` (each with ``bed``, ``points`` (n, 3) in the World
        frame, ``error95_m`` (n,) across the plane), ``bands`` (arrays (n,) for the model's
        points: nearest ``bed``, ``distance_m``, ``error95_m``, ``is_in_band``),
        ``max_error95_deg``.

    Raises
    ------
    vs.errors.GeometryError
        If the plane has no errors, or no plane intersects the model.
    vs.errors.UsageError
        If neither or both of points and a plane are given, a plane has no point or no error, or a
        value is invalid.

    Notes
    -----
    The variance is that of a regression prediction, s2 (1/n + u2/sum u2 + v2/sum v2), where n
    is the number of independent points along the trace. The bands use Student's t. For planes on
    outcrops, see Quinn & Ehlmann 2019, doi 10.1029/2018EA000416.

    Examples
    --------
    >>> import numpy as np
    >>> import vomstudio as vs
    >>> x, y = (a.ravel() for a in np.meshgrid(np.arange(0, 20, 0.2), np.arange(0, 20, 0.2)))
    >>> ground = np.column_stack([x, y, 0.1 * x])
    >>> extended = vs.extend(ground, plane=(90, 45), through=(5, 10, 0.5), error_deg=2)
    >>> extended.beds[0].least_error95_m < 0.05, 0.2 < extended.beds[0].most_error95_m < 0.4
    (True, True)
    """
    point = None if through is None else numbers(through, "through")
    options = options_from_arguments(
        ExtendOptions,
        locals(),
        plane=plane_text(plane),
        through=None if point is None else ",".join(map(repr, point.ravel().tolist())),
    )
    with name_arguments_in_errors(ExtendOptions):
        options.check_points(of, "of")
        data, _, _ = load_world_data(model, "model")
        extension = _extend(data, _plane_estimate(of, options), options)
    warn(extension.warnings)
    return extension


def _plane_estimate(of: Any, options: ExtendOptions) -> PlaneEstimate:
    """Return the plane with the errors of its position and attitude.

    Raises UsageError, InputError, GeometryError.
    """
    if of is not None:
        array = points(of, "of")
        with name_argument_in_errors("of"):
            return plane_estimate_from_fit(fit_plane(array))
    assert options.error_deg is not None
    plane, passing_point = (
        parse_plane_option(str(options.plane)),
        parse_through_point(str(options.through)),
    )
    return plane_estimate_from_attitude(
        plane, passing_point, options.error_deg, options.through_error_m
    )
