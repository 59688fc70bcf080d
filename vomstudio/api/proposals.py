"""Lines that the program proposes on a model, for somebody to look at."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from vomstudio.api.checking import path_text
from vomstudio.api.comparisons import is_array, placed
from vomstudio.api.declared_options import arguments_named, options_from_arguments
from vomstudio.api.models import model_of
from vomstudio.api.reporting import Reported, told
from vomstudio.core.progress import CancelToken
from vomstudio.extraction.proposals.traces import ProposedTraces
from vomstudio.extraction.trace_options import ProposalOptions


def propose_traces(
    model: Any,
    *,
    cost: str | None = None,
    min_length_m: float | None = None,
    max_lines: int = 50,
    onnx_model: str | Path | None = None,
    progress: Reported = None,
    cancel: CancelToken | None = None,
) -> ProposedTraces:
    """Propose lines on a model that stand out of its noise, the least doubtful first. They are
    proposals: check each of them.

    Parameters
    ----------
    model : Mesh, PointCloud, a model of a project, the path of a file, or an array (n, 3) of points
        in World, metres
    cost : "gradient" (edges of lightness; the default), "dark", "light", "curvature" (edges and
        furrows of the surface), or the name of a field, whose low values are searched for;
        "onnx" for the edges of a network
    min_length_m : minimum length of a line, m; None for twenty resolutions of the model
    max_lines : maximum number of lines
    onnx_model : for the cost "onnx": the file of a network that takes a picture, (1, 3, h, w) red,
        green and blue from 0 to 1, and gives the probability of an edge at each pixel, (1, 1, h, w)
    progress : called with (stage, steps done, all steps or None), or a Progress
    cancel : a vs.CancelToken that stops the work

    Returns
    -------
    An object with the names of the command: ``proposals``, each with ``line`` (its name),
    ``points`` (n, 3) World, m, ``length_m``, ``evidence`` (its mean, in standard deviations of the
    surface's own noise), ``doubt`` (the chance, 0.02 to 1, that noise alone makes a line as strong
    somewhere on the surface), ``plane`` (a dict of the orientation table's columns, None where
    there is none) and ``band``; and ``cost``, ``least_length_m``, ``surrogates``.

    Raises
    ------
    vs.errors.UsageError for a cost that the model does not have, a length or number that is none;
    vs.errors.GeometryError where there is no surface; vs.errors.Cancelled.

    Source: surrogates as in Theiler et al. (1992), Physica D 58, 77; paths of Dijkstra (1959).

    Examples
    --------
    A dark bed on a slope:

    >>> import numpy as np
    >>> import vomstudio as vs
    >>> import tempfile, pathlib
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "slope.csv"
    >>> x, y = (a.ravel() for a in np.meshgrid(np.arange(0, 3, 0.05), np.arange(0, 3, 0.05)))
    >>> z = 0.5 * y + 0.2 * np.sin(3 * x)
    >>> grey = np.where(np.abs(z - 0.7) < 0.04, 90.0, 200.0)
    >>> grey += np.random.default_rng(1).normal(0.0, 10.0, len(x))
    >>> rows = np.column_stack([x, y, z, grey])
    >>> np.savetxt(path, rows, delimiter=",", header="x,y,z,grey", comments="")
    >>> slope = vs.read(path, up="z", unit="m")
    >>> proposed = vs.propose_traces(slope, cost="grey", min_length_m=2.0)
    >>> first = proposed.proposals[0]
    >>> bool(np.abs(first.points[:, 2] - 0.7).max() < 0.08), first.doubt
    (True, 0.02)
    """
    from vomstudio.extraction.proposals import traces as proposing
    from vomstudio.extraction.proposals.edge_pictures import wearing_edges
    from vomstudio.extraction.surface_graph import SurfaceGraph
    from vomstudio.io.models.opening import resolution
    from vomstudio.studio.jobs.edge_detection import open_edge_finder

    options = options_from_arguments(
        ProposalOptions,
        cost=cost,
        min_length_m=min_length_m,
        max_lines=max_lines,
        onnx_model=path_text(onnx_model, "onnx_model"),
    )
    report = told(progress, cancel)
    with (
        open_edge_finder(options.onnx_model, report, cancel) as edges,
        arguments_named(ProposalOptions),
    ):
        data, crs, _ = placed(model if is_array(model) else model_of(model), "model")
        spacing = resolution(data)
        return proposing.propose_traces(
            SurfaceGraph(data if edges is None else wearing_edges(data, spacing, *edges)),
            options,
            resolution=spacing,
            model=getattr(getattr(model, "path", None), "name", None) or "",
            frame=crs or "local",
            progress=report,
        )
