"""A model placed by pairs of points."""

from __future__ import annotations

from typing import Any

import numpy as np

from vomstudio.api.checking import numbers, points, refuse_rows, warn
from vomstudio.errors import InputError
from vomstudio.registration.placing import register_points
from vomstudio.registration.results import Placed
from vomstudio.words import tr


def register(
    model_points: Any,
    world_points: Any,
    *,
    sigma_m: Any = None,
    check: Any = None,
) -> Placed:
    """The similarity (scale, rotation, shift; never a mirror) from a model to World by points that
    are known in both.

    Parameters
    ----------
    model_points : (n, 3) in the model's own frame and unit
    world_points : (n, 3) the same points in World, metres
    sigma_m : (n, 3) one-sigma errors of ``world_points``, metres; None takes them as equal and
        estimates them from the residuals
    check : (n,) True for points that judge the result and take no part in it

    Returns
    -------
    Placed with the names of the command: ``matrix`` (4 x 4, model to World), ``scale``,
    ``control`` and ``check`` (``label``, ``dx``, ``dy``, ``dz``: fitted less given, ``error_m``),
    ``rms_control_m``, ``rms_check_m``, ``rotation_error_deg`` (one sigma ``about_up``,
    ``about_east``, ``about_north``), ``rotation_error_95_deg`` (the same three and the ``weakest``
    axis), ``scale_error_95``, ``worth_adding`` (where one more point would help most), ``known``,
    ``blunders`` (points too far off to be chance) and ``warnings``. Called with (n, 3)
    model points it gives them in World.

    Raises
    ------
    vs.errors.InputError for arrays of other shapes, or points that are no pairs;
    vs.errors.GeometryError for fewer than three control points, or control points on one line.

    Source: Umeyama (1991), IEEE PAMI 13, 376; covariance of linear least squares; variances of
    groups by Rao's MINQUE; wrong points by deletion residuals (Cook & Weisberg 1982).

    Examples
    --------
    A model in centimetres, turned by a quarter about the vertical:

    >>> import numpy as np
    >>> import vomstudio as vs
    >>> model = np.array([[0, 0, 0], [900, 0, 0], [0, 800, 100], [300, 200, 700], [500, 600, 50]])
    >>> world = model[:, [1, 0, 2]] * [-0.01, 0.01, 0.01] + [500, 100, 20]
    >>> found = vs.register(model, world, check=[False, False, False, False, True])
    >>> round(found.scale, 6), round(found.rms_check_m, 6)
    (0.01, 0.0)
    """
    model, world = points(model_points, "model_points"), points(world_points, "world_points")
    if len(model) != len(world):
        raise InputError(
            tr(
                "{count} points of the model and {world} of World do not form pairs.",
                count=len(model),
                world=len(world),
            ),
            field="world_points",
        )
    sigma = None if sigma_m is None else _sigma(sigma_m, len(model))
    judges = None if check is None else _flags(check, len(model))
    found = register_points(model, world, sigma, judges)
    warn(found.warnings)
    return found


def _sigma(given: Any, n: int) -> Any:
    array = numbers(given, "sigma_m")
    if array.shape != (n, 3):
        raise InputError(
            tr(
                "One standard error per coordinate is needed, as an array ({count}, 3). This "
                "one has the shape {shape}.",
                count=n,
                shape=array.shape,
            ),
            field="sigma_m",
        )
    bad = np.asarray(~((array > 0) & np.isfinite(array)).all(axis=1))
    refuse_rows(bad, "no positive errors", "sigma_m")
    return array


def _flags(given: Any, n: int) -> Any:
    array = np.asarray(given)
    if array.shape != (n,) or array.dtype != bool:
        raise InputError(
            tr("True or False for each of the {n} points is needed, an array ({n},) of bool.", n=n),
            field="check",
        )
    return array
