"""Expected quality of planes on a model."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vomstudio.api.checking import to_plane, warn
from vomstudio.api.comparisons import load_world_data
from vomstudio.api.declared_options import options_from_arguments
from vomstudio.api.reporting import ProgressArgument, to_progress
from vomstudio.core.progress import CancelToken
from vomstudio.extraction.measurable_options import MeasurableOptions
from vomstudio.products.surface.measurable_map import MeasurableMap, measurable_map

if TYPE_CHECKING:
    from vomstudio.api.argument_types import ModelArgument, PlaneArgument


def measurable(
    model: ModelArgument,
    plane: PlaneArgument,
    *,
    length_m: float | None = None,
    noise_m: float | None = None,
    points: int | None = None,
    resolution_m: float | None = None,
    angle_deg: float = 10.0,
    registration_error_deg: float | None = None,
    progress: ProgressArgument = None,
    cancel: CancelToken | None = None,
) -> MeasurableMap:
    """Map how accurately a plane of the given attitude could be measured on a model.

    Parameters
    ----------
    model : Mesh, PointCloud, model of a project, path, or (n, 3) array
        Model in the World frame, metres.
    plane : str, (float, float) or PlaneFit
        (dip direction, dip) in degrees, or "DD/D".
    length_m : float, optional
        Length of a trace, metres; by default 100 resolutions of the model.
    noise_m : float, optional
        Standard deviation of the vertices of a trace across their plane, m; by default half
        a pixel of a photo, which is a twentieth of the resolution.
    points : int, optional
        Number of vertices of a trace; by default its length divided by the resolution.
    resolution_m : float, optional
        Resolution of the model, metres; by default measured around each position.
    angle_deg : float, optional
        Maximum angle between the plane and a face that exposes it as a patch.
    registration_error_deg : float, optional
        95 % error of the plane caused by the registration; 0 if omitted.
    progress : callable or Progress, optional
        Called with (stage, completed steps, total steps or None).
    cancel : vs.CancelToken, optional
        Token that stops the computation.

    Returns
    -------
    MeasurableMap
        ``shares`` of the area by class (good, doubtful, poor, none), ``trace_shares``,
        ``exposed_share``, ``patches``, ``best`` (World, metres), ``median_deg``, ``tenth_deg``,
        ``as_fields()``: float32 values of each point or vertex, ``expected_error95_deg``,
        ``trace_error95_deg``, ``patch_error95_deg``, degrees, and ``measurable``, from 0
        (none) to 3 (good).

    Raises
    ------
    vs.errors.UsageError
        If a value is invalid.
    vs.errors.GeometryError
        If the model has no surface, or the length is too short for a trace.
    vs.errors.Cancelled
        If the computation was stopped by ``cancel``.

    Notes
    -----
    Source: covariance of the intersection of plane and surface, judged like a picked trace;
    Tavani et al., sections 4.1.2 and 4.1.3 and exercise 6.

    Examples
    --------
    On two walls that meet in a corner, the trace of a level bed is straight away from the corner:

    >>> import numpy as np
    >>> import vomstudio as vs
    >>> a, b = (v.ravel() for v in np.meshgrid(np.arange(0, 3, 0.03), np.arange(0, 3, 0.03)))
    >>> south, west = np.column_stack([a, 0 * a, b]), np.column_stack([0 * a, a + 0.03, b])
    >>> shares = vs.measurable(np.concatenate([south, west]), (0, 0), length_m=1.0).shares
    >>> 0.1 < shares["good"] < 0.2, shares["none"] + shares["poor"] > 0.6
    (True, True)
    """
    options = options_from_arguments(MeasurableOptions, locals())
    data, _, _ = load_world_data(model, "model")
    result = measurable_map(data, to_plane(plane, "plane"), options, to_progress(progress, cancel))
    warn(result.warnings)
    return result
