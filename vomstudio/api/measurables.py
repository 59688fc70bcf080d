"""How well a plane could be measured on a model."""

from __future__ import annotations

from typing import Any

from vomstudio.api.checking import attitude_of, warn
from vomstudio.api.comparisons import placed
from vomstudio.api.declared_options import options_from_arguments
from vomstudio.api.reporting import Reported, told
from vomstudio.core.progress import CancelToken
from vomstudio.extraction.measurable_options import MeasurableOptions
from vomstudio.products.surface.measurable_map import MeasurableMap, measurable_map


def measurable(
    model: Any,
    plane: Any,
    *,
    length_m: float | None = None,
    noise_m: float | None = None,
    points: int | None = None,
    resolution_m: float | None = None,
    angle_deg: float = 10.0,
    registration_error_deg: float | None = None,
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
    angle_deg : maximum angle between the plane and a face that exposes it as a patch
    registration_error_deg : 95 % error of the plane caused by the registration; 0 if omitted
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
    options = options_from_arguments(
        MeasurableOptions,
        length_m=length_m,
        noise_m=noise_m,
        points=points,
        resolution_m=resolution_m,
        angle_deg=angle_deg,
        registration_error_deg=registration_error_deg,
    )
    data, _, _ = placed(model, "model")
    found = measurable_map(data, attitude_of(plane, "plane"), options, told(progress, cancel))
    warn(found.warnings)
    return found
