"""Comparison of a model with a benchmark."""

from __future__ import annotations

from typing import Any

import numpy as np

from vomstudio.api.checking import warn
from vomstudio.api.declared_options import options_from_arguments
from vomstudio.api.models import Mesh, PointCloud, model_of
from vomstudio.api.reporting import Reported, told
from vomstudio.core.findings import Finding
from vomstudio.core.progress import CancelToken
from vomstudio.core.words import tr
from vomstudio.registration.distances import comparison
from vomstudio.registration.distances.compare_options import CompareOptions
from vomstudio.registration.distances.comparison import Comparison
from vomstudio.registration.overlap import crs_findings


def compare(
    model: Any,
    benchmark: Any,
    *,
    m3c2_m: float | None = None,
    registration_error_m: float | None = None,
    progress: Reported = None,
    cancel: CancelToken | None = None,
) -> Comparison:
    """Signed distances of a model from a benchmark, and their statistics.

    Parameters
    ----------
    model, benchmark : Mesh, PointCloud, a model of a project, the path of a file, or an array
        (n, 3) of points in World, metres
    m3c2_m : radius of the cylinders in metres, for M3C2; None takes the nearest point of the
        benchmark: on the triangles of a mesh, on the plane fitted locally to a cloud
    registration_error_m : one sigma of how the two are placed to each other; None takes what the
        model's registration (in its project, or of its reconstruction) says of it, else 0
    progress : called with (stage, steps done, all steps or None), or a Progress
    cancel : a vs.CancelToken that stops the work

    Returns
    -------
    Comparison with the names of the command: ``n``, ``mean_m``, ``median_m`` (accuracy),
    ``std_m``, ``mad_m`` (precision), ``rms_m``, ``lod95_m`` and ``significant_share`` (None without
    M3C2), ``beyond`` (points without a counterpart); and ``distances``, ``lod95`` of all points of
    the model in their order, NaN where there is none. Distances are positive where the model lies
    before the benchmark: on the side of its normals, ``positive_toward`` on the whole.

    Raises
    ------
    vs.errors.UsageError for a radius or error that is no length, and for two coordinate reference
    systems; vs.errors.GeometryError where the two do not overlap; vs.errors.Cancelled.

    Source: Lague, Brodu & Leroux (2013), ISPRS J. Photogramm. Remote Sens. 82, 10; sides of a mesh
    after Baerentzen & Aanaes (2005), IEEE TVCG 11, 243.

    Examples
    --------
    Two planes, one of them 5 cm above the other:

    >>> import numpy as np
    >>> import vomstudio as vs
    >>> x, y = np.meshgrid(np.arange(0, 4, 0.1), np.arange(0, 4, 0.1))
    >>> ground = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    >>> found = vs.compare(ground + [0.0, 0.0, 0.05], ground)
    >>> found.n, round(found.mean_m, 6), round(found.std_m, 6)
    (1600, 0.05, 0.0)
    """
    options = options_from_arguments(
        CompareOptions, m3c2_m=m3c2_m, registration_error_m=registration_error_m
    )
    report = told(progress, cancel)
    first, second = placed(model, "model"), placed(benchmark, "benchmark")
    findings: list[Finding] = []
    if not (is_array(model) or is_array(benchmark)):
        findings = crs_findings(first[1], second[1], (tr("The model"), tr("the benchmark")))
    error = options.registration_error_m
    if error is None and options.m3c2_m is not None:
        error = first[2]
    found = comparison.compare(
        first[0],
        second[0],
        radius_m=options.m3c2_m,
        registration_error_m=error,
        progress=report,
    )
    warn([*findings, *found.warnings])
    return found


def is_array(given: Any) -> bool:
    return isinstance(given, np.ndarray) or hasattr(given, "columns")


def placed(given: Any, name: str) -> tuple[Any, str | None, float | None]:
    """The data in World of a model, file or array, its CRS, and how far it may be off."""
    from vomstudio.api.checking import points
    from vomstudio.geometry.cloud import PointCloud as Cloud
    from vomstudio.io.gis.crs import world_crs

    if is_array(given):
        return Cloud(points(given, name)), None, None
    made: Mesh | PointCloud = model_of(given, name)
    crs = None if made.crs is None else world_crs(made.crs, made._source.unit_m)
    return made._data, crs, made._source.placing_error_m
