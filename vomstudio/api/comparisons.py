"""Comparisons of models with benchmarks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from vomstudio.api.checking import warn
from vomstudio.api.declared_options import options_from_arguments
from vomstudio.api.models import Mesh, PointCloud, to_model
from vomstudio.api.reporting import ProgressArgument, to_progress
from vomstudio.core.findings import Finding
from vomstudio.core.progress import CancelToken
from vomstudio.core.words import tr
from vomstudio.registration.distances import comparison
from vomstudio.registration.distances.compare_options import CompareOptions
from vomstudio.registration.distances.comparison import Comparison
from vomstudio.registration.overlap import crs_findings

if TYPE_CHECKING:
    from vomstudio.api.argument_types import ModelArgument


def compare(
    model: ModelArgument,
    benchmark: ModelArgument,
    *,
    m3c2_m: float | None = None,
    registration_error_m: float | None = None,
    progress: ProgressArgument = None,
    cancel: CancelToken | None = None,
) -> Comparison:
    """Compute signed distances of a model from a benchmark, with statistics.

    Parameters
    ----------
    model, benchmark : Mesh, PointCloud, model of a project, path, or (n, 3) array
        Model in the World frame, metres.
    m3c2_m : float, optional
        Radius of the cylinders of M3C2, metres; by default distances are to the nearest
        point of the benchmark, on the triangles of a mesh or the plane fitted locally to a
        cloud.
    registration_error_m : float, optional
        Standard deviation of the relative placement, metres; by default that of the
        registration of the model, otherwise 0.
    progress : callable or Progress, optional
        Called with (stage, completed steps, total steps or None).
    cancel : vs.CancelToken, optional
        Token that stops the computation.

    Returns
    -------
    Comparison
        ``n``, ``mean_m``, ``median_m`` (accuracy), ``std_m``, ``mad_m`` (precision),
        ``rms_m``, ``lod95_m`` and ``significant_share`` (only with M3C2), ``beyond``
        (points without a counterpart); and ``distances`` and, with M3C2, ``lod95`` of
        all points of the model in their order, NaN if undefined. Distances are positive if the
        model is in front of the benchmark, on the side of its normals (``positive_toward``).

    Raises
    ------
    vs.errors.UsageError
        If the radius or error is invalid, or the coordinate reference systems differ.
    vs.errors.GeometryError
        If the model and the benchmark do not overlap.
    vs.errors.Cancelled
        If the computation was stopped by ``cancel``.

    Notes
    -----
    Source: Lague, Brodu & Leroux (2013), ISPRS J. Photogramm. Remote Sens. 82, 10; sides of a
    mesh after Baerentzen & Aanaes (2005), IEEE TVCG 11, 243.

    Examples
    --------
    Two planes, one of them 5 cm above the other:

    >>> import numpy as np
    >>> import vomstudio as vs
    >>> x, y = np.meshgrid(np.arange(0, 4, 0.1), np.arange(0, 4, 0.1))
    >>> ground = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    >>> comparison = vs.compare(ground + [0.0, 0.0, 0.05], ground)
    >>> comparison.n, round(comparison.mean_m, 6), round(comparison.std_m, 6)
    (1600, 0.05, 0.0)
    """
    options = options_from_arguments(CompareOptions, locals())
    report = to_progress(progress, cancel)
    placed_model, placed_benchmark = (
        load_world_data(model, "model"),
        load_world_data(benchmark, "benchmark"),
    )
    findings: list[Finding] = []
    if not (is_array(model) or is_array(benchmark)):
        findings = crs_findings(
            placed_model[1], placed_benchmark[1], (tr("The model"), tr("the benchmark"))
        )
    error = options.registration_error_m
    if error is None and options.m3c2_m is not None:
        error = placed_model[2]
    result = comparison.compare(
        placed_model[0],
        placed_benchmark[0],
        radius_m=options.m3c2_m,
        registration_error_m=error,
        progress=report,
    )
    warn([*findings, *result.warnings])
    return result


def is_array(value: Any) -> bool:
    """Return whether a value is an array or a DataFrame.

    Parameters
    ----------
    value : object

    Returns
    -------
    bool
    """
    return isinstance(value, np.ndarray) or hasattr(value, "columns")


def load_world_data(value: Any, name: str) -> tuple[Any, str | None, float | None]:
    """Return the data of a model, file or array in the World frame.

    Parameters
    ----------
    value : object
    name : str
        Name of the argument.

    Returns
    -------
    data : Mesh or PointCloud
    crs : str or None
    position_error_m : float or None
        Error of the position of the model; None if unknown.
    """
    from vomstudio.api.point_arguments import points
    from vomstudio.geometry.cloud import PointCloud as Cloud
    from vomstudio.io.gis.crs import world_crs

    if is_array(value):
        return Cloud(points(value, name)), None, None
    data: Mesh | PointCloud = to_model(value, name)
    crs = None if data.crs is None else world_crs(data.crs, data._source.unit_m)
    return data._data, crs, data._source.placing_error_m
