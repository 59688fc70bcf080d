"""Jobs that propose traces on a model."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.extraction.trace_options import ProposalOptions
from vomstudio.studio.jobs.job import Job, Lane
from vomstudio.studio.jobs.placed_model import PlacedModel, load_in_world


@dataclass(frozen=True)
class EdgesRequest:
    """Request for edge detection with the ONNX file `network`; `out` is the output folder."""

    network: Path
    pictures: tuple[Path, ...]
    out: Path


@dataclass(frozen=True)
class EdgesResult:
    """Detected edges as pictures, in the order of the input pictures."""

    pictures: tuple[Path, ...]


def _find_edges(request: EdgesRequest, progress: Progress) -> EdgesResult:
    from vomstudio.extraction.proposals.edge_pictures import write_edges

    return EdgesResult(tuple(write_edges(request.network, request.pictures, request.out, progress)))


FIND_EDGES = Job("find_edges", Lane.PRODUCTS, EdgesRequest, EdgesResult, _find_edges)


@dataclass(frozen=True)
class TracesRequest:
    """Request for trace proposals on a model; `out` is the output file for the traces."""

    model: PlacedModel
    options: ProposalOptions
    out: Path


@dataclass(frozen=True)
class TracesResult:
    """Proposed traces in order of decreasing reliability.

    The file `out` contains the points `places` (n, 3) in the file frame of the model; trace i
    consists of `places[cuts[i]:cuts[i + 1]]`. For each trace, it contains `length_m`,
    `evidence`, `doubt`, `resolution` (file units, NaN if unknown) and `outcrop_normal` (3,)
    (file frame, NaN if unknown).
    """

    count: int
    cost: str
    least_length_m: float
    surrogates: int
    warnings: tuple[Finding, ...]
    out: Path


def _propose_traces(request: TracesRequest, progress: Progress) -> TracesResult:
    import numpy as np

    from vomstudio.extraction.followed_trace import index_vertices
    from vomstudio.extraction.proposals.edge_pictures import colour_by_edges, write_edges
    from vomstudio.extraction.proposals.traces import propose_traces
    from vomstudio.extraction.surface_graph import SurfaceGraph
    from vomstudio.geometry import transform
    from vomstudio.io.models.opening import resolution

    data = load_in_world(request.model, progress)
    spacing, network = resolution(data), request.options.onnx_model
    if network is not None:
        file = Path(network)
        data = colour_by_edges(
            data,
            spacing,
            lambda pictures, out: write_edges(file, pictures, out, progress),
            request.out.with_suffix(""),
        )
    surface = SurfaceGraph(data)
    result = propose_traces(
        surface,
        request.options,
        resolution=spacing,
        model=request.model.name,
        frame=request.model.crs or "local",
        progress=progress,
    )
    to_file = transform.invert(transform.matrix(request.model.to_world))
    scale = transform.scale_factor(request.model.to_world)
    surface_measures = index_vertices(surface) if result.proposals else None
    resolutions = [
        surface_measures.local_resolution(proposal.points) if surface_measures else None
        for proposal in result.proposals
    ]
    faces = [
        surface_measures.outcrop_normal(proposal.points) if surface_measures else None
        for proposal in result.proposals
    ]
    rotation = scale * to_file[:3, :3]
    unknown_values = np.full(3, np.nan)
    arrays: dict[str, Any] = {
        "places": transform.apply(
            to_file,
            np.concatenate([*(proposal.points for proposal in result.proposals), np.zeros((0, 3))]),
        ),
        "cuts": np.cumsum([0, *(len(proposal.points) for proposal in result.proposals)]),
        "length_m": np.array([proposal.length_m for proposal in result.proposals]),
        "evidence": np.array([proposal.evidence for proposal in result.proposals]),
        "doubt": np.array([proposal.doubt for proposal in result.proposals]),
        "resolution": np.array([np.nan if r is None else r / scale for r in resolutions]),
        "outcrop_normal": np.array(
            [unknown_values if face is None else rotation @ face for face in faces]
        ).reshape(-1, 3),
    }
    request.out.parent.mkdir(parents=True, exist_ok=True)
    part = request.out.with_name(f"{request.out.stem}.part.npz")
    np.savez(part, **arrays)
    os.replace(part, request.out)
    return TracesResult(
        len(result.proposals),
        result.cost,
        result.least_length_m,
        result.surrogates,
        result.warnings,
        request.out,
    )


PROPOSE_TRACES = Job("propose_traces", Lane.PRODUCTS, TracesRequest, TracesResult, _propose_traces)

JOBS = (FIND_EDGES, PROPOSE_TRACES)
