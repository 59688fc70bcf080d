"""Deviation of a patch from its plane."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from vomstudio.api.checking import warn, wrong_type_error
from vomstudio.api.comparisons import load_world_data
from vomstudio.api.declared_options import name_arguments_in_errors, options_from_arguments
from vomstudio.api.reporting import ProgressArgument, to_progress
from vomstudio.core.progress import CancelToken
from vomstudio.products.surface.analysis import SurfaceFigures, analyse
from vomstudio.products.surface.patch import extract_within_radius, parse_around
from vomstudio.products.surface.surface_options import SurfaceOptions

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from vomstudio.api.argument_types import ModelArgument


def surface(
    model: ModelArgument,
    *,
    around: tuple[ArrayLike, float] | None = None,
    noise_m: float | None = None,
    gsd_m: float | None = None,
    progress: ProgressArgument = None,
    cancel: CancelToken | None = None,
) -> SurfaceFigures:
    """Measure the deviation of a patch from its plane, and its roughness.

    Parameters
    ----------
    model : Mesh, PointCloud, model of a project, path, or (n, 3) array
        Patch in the World frame, metres; or the whole model if `around` is given.
    around : ((float, float, float), float), optional
        Centre and radius of the patch on the model, in the World frame, metres.
    noise_m : float, optional
        Standard deviation of the noise of the model, metres; by default the scatter of cloud
        points about local planes, or a quarter of the mean edge length of a mesh.
    gsd_m : float, optional
        Side length of the map cells, metres; by default the mean edge length or spacing.
    progress : callable or Progress, optional
        Called with (stage, completed steps, total steps or None).
    cancel : vs.CancelToken, optional
        Token that stops the computation.

    Returns
    -------
    SurfaceFigures
        ``plane`` (dict of the orientation table's columns), ``rms_m``, ``lowest_m``,
        ``highest_m``, ``trim``, ``hurst``, ``smoothest`` (if None, ``hurst_reason`` or
        ``smoothest_reason`` states why), ``deviations`` (rows, columns) in m, NaN if unknown,
        with rows down the dip, ``point_deviations`` (n,), ``profiles``, ``warnings``.

    Raises
    ------
    vs.errors.GeometryError
        If the patch has no plane or too few cells.
    vs.errors.InputError
        If `around` is not a centre with a radius.
    vs.errors.UsageError
        If a length is invalid.
    vs.errors.Cancelled
        If the computation was stopped by ``cancel``.

    Notes
    -----
    The roughness is computed from second differences by direction (Kent & Wood 1997; Chan & Wood
    2000), with jackknife errors. The smoothest direction of faults follows Renard et al. (2006).

    Examples
    --------
    Grooves half a metre apart that run east:

    >>> import numpy as np
    >>> import vomstudio as vs
    >>> x, y = (a.ravel() for a in np.meshgrid(np.arange(0, 4, 0.03), np.arange(0, 4, 0.03)))
    >>> rng = np.random.default_rng(1)
    >>> grooves = 0.02 * np.sin(2 * np.pi * y / 0.5) + 0.0005 * rng.standard_normal(len(x))
    >>> result = vs.surface(np.column_stack([x, y, grooves]), noise_m=0.0005)
    >>> abs(result.smoothest.trend_deg - 90) < 2, round(result.rms_m, 3)
    (True, 0.014)
    """
    options = options_from_arguments(
        SurfaceOptions, locals(), around=None if around is None else _around_text(around)
    )
    data, crs, _ = load_world_data(model, "model")
    with name_arguments_in_errors(SurfaceOptions):
        if options.around is not None:
            data = extract_within_radius(data, *parse_around(options.around))
        result = analyse(
            data,
            noise_m=options.noise_m,
            cell_m=options.gsd_m,
            model=getattr(getattr(model, "path", None), "name", None) or "",
            frame=crs or "local",
            progress=to_progress(progress, cancel),
        )
    warn(result.warnings)
    return result


def _around_text(value: Any) -> str:
    """Format ((x, y, z), radius) as the text of the option `around`. Raises InputError."""
    try:
        centre, radius = value
        return ",".join(map(repr, [*np.asarray(centre, float).tolist(), float(radius)]))
    except (TypeError, ValueError) as error:
        raise wrong_type_error(value, "((x, y, z), radius)", "around") from error
