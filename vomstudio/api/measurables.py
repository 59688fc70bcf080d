"""How well a plane could be measured on a model."""

from __future__ import annotations

from typing import Any

from vomstudio.api.checking import attitude_of, required_number, single_number, warn, whole_number
from vomstudio.api.comparisons import placed
from vomstudio.api.reporting import Reported, told
from vomstudio.products.surface.measurable_map import MeasurableMap, measurable_map
from vomstudio.progress import CancelToken


def measurable(
    model: Any,
    plane: Any,
    *,
    length_m: float | None = None,
    noise_m: float | None = None,
    points: int | None = None,
    resolution_m: float | None = None,
    angle_deg: float | None = None,
    registration_error_deg: float = 0.0,
    progress: Reported = None,
    cancel: CancelToken | None = None,
) -> MeasurableMap:
    """How well a plane of this attitude could be measured at each place of a model.

    Parameters
    ----------
    model : a Mesh, PointCloud, a model of a project, the path of a file, or an array (n, 3) of
        points in World, metres
    plane : (dip direction, dip) in degrees, or "DD/D"
    length_m : of a trace, m; None takes 100 resolutions of the model
    noise_m : standard deviation of a trace's vertices across their plane, m; None takes half a
        photo's pixel, which is a twentieth of the resolution
    points : vertices of a trace; None takes one for each resolution of its length
    resolution_m : of the model, m; None takes what is found around each place
    angle_deg : within which a face is the plane's own; None takes 10
    registration_error_deg : 95 % by which the registration can tilt the plane
    progress : called with (stage, steps done, all steps or None), or a Progress
    cancel : a vs.CancelToken that stops the work

    Returns
    -------
    MeasurableMap: ``shares`` of the area by class (good, doubtful, poor, none), ``trace_shares``,
    ``exposed_share``, ``patches``, ``best`` (World, m), ``median_deg``, ``tenth_deg``,
    ``as_fields()``: float32 of each point or vertex, ``expected_error95_deg``,
    ``trace_error95_deg``, ``patch_error95_deg``, degrees, and ``measurable``, 0 none to 3 good.

    Raises
    ------
    vs.errors.UsageError for figures that are none; vs.errors.GeometryError for a model without a
    surface, or a length that is no trace on it; vs.errors.Cancelled.

    Source: the covariance of the line in which the plane cuts the surface, judged as a picked trace
    is; Tavani et al., sections 4.1.2 and 4.1.3 and exercise 6.

    Examples
    --------
    Two walls that meet in a corner: away from it a level bed's trace is straight.

    >>> import numpy as np
    >>> import vomstudio as vs
    >>> a, b = (v.ravel() for v in np.meshgrid(np.arange(0, 3, 0.03), np.arange(0, 3, 0.03)))
    >>> south, west = np.column_stack([a, 0 * a, b]), np.column_stack([0 * a, a + 0.03, b])
    >>> found = vs.measurable(np.concatenate([south, west]), (0, 0), length_m=1.0)
    >>> 0.1 < found.shares["good"] < 0.2, found.shares["none"] + found.shares["poor"] > 0.6
    (True, True)
    """
    data, _, _ = placed(model, "model")
    found = measurable_map(
        data,
        attitude_of(plane, "plane"),
        length_m=single_number(length_m, "length_m"),
        resolution_m=single_number(resolution_m, "resolution_m"),
        noise_m=single_number(noise_m, "noise_m"),
        points=whole_number(points, "points"),
        angle_deg=single_number(angle_deg, "angle_deg"),
        registration_deg=required_number(registration_error_deg, "registration_error_deg"),
        progress=told(progress, cancel),
    )
    warn(found.warnings)
    return found
