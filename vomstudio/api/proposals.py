"""Proposals of lines on a model for review."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from vomstudio.api.checking import path_text
from vomstudio.api.comparisons import is_array, load_world_data
from vomstudio.api.declared_options import name_arguments_in_errors, options_from_arguments
from vomstudio.api.models import to_model
from vomstudio.api.reporting import ProgressArgument, to_progress
from vomstudio.core.progress import CancelToken
from vomstudio.extraction.proposals.traces import ProposedTraces
from vomstudio.extraction.trace_options import ProposalOptions

if TYPE_CHECKING:
    from vomstudio.api.argument_types import ModelArgument


def propose_traces(
    model: ModelArgument,
    *,
    cost: str | None = None,
    min_length_m: float | None = None,
    max_lines: int = 50,
    onnx_model: str | Path | None = None,
    progress: ProgressArgument = None,
    cancel: CancelToken | None = None,
) -> ProposedTraces:
    """Propose lines on a model that stand out from its noise, most reliable first.

    The lines are proposals that must be reviewed individually.

    Parameters
    ----------
    model : Mesh, PointCloud, model of a project, path, or (n, 3) array
        Model in the World frame, metres.
    cost : str, optional
        "gradient" (edges of lightness; the default), "dark", "light", "curvature" (edges
        and furrows of the surface), or the name of a field, whose low values are searched
        for; "onnx" for the edges of a network.
    min_length_m : float, optional
        Minimum length of a line, metres; by default twenty resolutions of the model.
    max_lines : int, optional
        Maximum number of lines.
    onnx_model : str or Path, optional
        File of the network for the cost "onnx". Its input is an image (1, 3, h, w) of red,
        green and blue from 0 to 1, and its output the edge probability (1, 1, h, w) of each
        pixel.
    progress : callable or Progress, optional
        Called with (stage, completed steps, total steps or None).
    cancel : vs.CancelToken, optional
        Token that stops the computation.

    Returns
    -------
    ProposedTraces
        Result with the names of the command: ``proposals``, each with ``line`` (its name),
        ``points`` (n, 3) World, m, ``length_m``, ``evidence`` (mean, in standard deviations
        of the surface's noise), ``doubt`` (probability, 0.02 to 1, that noise alone
        produces a line as strong somewhere on the surface), ``plane`` (a dict of the
        orientation table's columns, None if undefined) and ``band``; and ``cost``,
        ``least_length_m``, ``surrogates``.

    Raises
    ------
    vs.errors.UsageError
        If the cost is not available, or the length or number is invalid.
    vs.errors.GeometryError
        If the model has no surface.
    vs.errors.Cancelled
        If the computation was stopped by ``cancel``.

    Notes
    -----
    Source: surrogates as in Theiler et al. (1992), Physica D 58, 77; paths after Dijkstra (1959).

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
    from vomstudio.extraction.proposals.edge_pictures import colour_by_edges
    from vomstudio.extraction.surface_graph import SurfaceGraph
    from vomstudio.io.models.opening import resolution
    from vomstudio.studio.jobs.edge_detection import open_edge_finder

    options = options_from_arguments(
        ProposalOptions, locals(), onnx_model=path_text(onnx_model, "onnx_model")
    )
    report = to_progress(progress, cancel)
    with (
        open_edge_finder(options.onnx_model, report, cancel) as edges,
        name_arguments_in_errors(ProposalOptions),
    ):
        data, crs, _ = load_world_data(model if is_array(model) else to_model(model), "model")
        spacing = resolution(data)
        return proposing.propose_traces(
            SurfaceGraph(data if edges is None else colour_by_edges(data, spacing, *edges)),
            options,
            resolution=spacing,
            model=getattr(getattr(model, "path", None), "name", None) or "",
            frame=crs or "local",
            progress=report,
        )
