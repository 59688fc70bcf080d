"""Jobs that propose lines on one model."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.extraction.trace_options import ProposalOptions
from vomstudio.studio.jobs.job import Job, Lane
from vomstudio.studio.jobs.placed_model import StandingModel, in_world


@dataclass(frozen=True)
class EdgesOrder:
    """network : an ONNX file; out : the folder for the pictures of edges"""

    network: Path
    pictures: tuple[Path, ...]
    out: Path


@dataclass(frozen=True)
class FoundEdges:
    """pictures : of edges, in the order of the others"""

    pictures: tuple[Path, ...]


def _find_edges(order: EdgesOrder, progress: Progress) -> FoundEdges:
    from vomstudio.extraction.proposals.edge_pictures import write_edges

    return FoundEdges(tuple(write_edges(order.network, order.pictures, order.out, progress)))


FIND_EDGES = Job("find_edges", Lane.PRODUCTS, EdgesOrder, FoundEdges, _find_edges)


@dataclass(frozen=True)
class TracesOrder:
    """Order for proposing lines on a model; out : file for the lines"""

    model: StandingModel
    options: ProposalOptions
    out: Path


@dataclass(frozen=True)
class FoundTraces:
    """count lines, the least doubtful first, in `out`: places (n, 3) in the frame of the model's
    file, those of line i from cuts[i] to cuts[i + 1]; length_m, evidence, doubt, resolution (file
    units, NaN where unknown) and outcrop_normal (3,) (file frame, NaN) of each"""

    count: int
    cost: str
    least_length_m: float
    surrogates: int
    warnings: tuple[Finding, ...]
    out: Path


def _propose(order: TracesOrder, progress: Progress) -> FoundTraces:
    import numpy as np

    from vomstudio.extraction.followed_trace import near_surface
    from vomstudio.extraction.proposals.edge_pictures import wearing_edges, write_edges
    from vomstudio.extraction.proposals.traces import propose_traces
    from vomstudio.extraction.surface_graph import SurfaceGraph
    from vomstudio.geometry import transform
    from vomstudio.io.models.opening import resolution

    data = in_world(order.model, progress)
    spacing, network = resolution(data), order.options.onnx_model
    if network is not None:
        file = Path(network)
        data = wearing_edges(
            data,
            spacing,
            lambda pictures, out: write_edges(file, pictures, out, progress),
            order.out.with_suffix(""),
        )
    surface = SurfaceGraph(data)
    found = propose_traces(
        surface,
        order.options,
        resolution=spacing,
        model=order.model.name,
        frame=order.model.crs or "local",
        progress=progress,
    )
    back = transform.invert(transform.matrix(order.model.to_world))
    scale = transform.scale_of(order.model.to_world)
    near = near_surface(surface) if found.proposals else None
    own = [near.resolution_near(one.points) if near else None for one in found.proposals]
    faces = [near.outcrop_normal(one.points) if near else None for one in found.proposals]
    turn = scale * back[:3, :3]
    unknown = np.full(3, np.nan)
    arrays: dict[str, Any] = {
        "places": transform.apply(
            back, np.concatenate([*(one.points for one in found.proposals), np.zeros((0, 3))])
        ),
        "cuts": np.cumsum([0, *(len(one.points) for one in found.proposals)]),
        "length_m": np.array([one.length_m for one in found.proposals]),
        "evidence": np.array([one.evidence for one in found.proposals]),
        "doubt": np.array([one.doubt for one in found.proposals]),
        "resolution": np.array([np.nan if r is None else r / scale for r in own]),
        "outcrop_normal": np.array(
            [unknown if face is None else turn @ face for face in faces]
        ).reshape(-1, 3),
    }
    order.out.parent.mkdir(parents=True, exist_ok=True)
    part = order.out.with_name(f"{order.out.stem}.part.npz")
    np.savez(part, **arrays)
    os.replace(part, order.out)
    return FoundTraces(
        len(found.proposals),
        found.cost,
        found.least_length_m,
        found.surrogates,
        found.warnings,
        order.out,
    )


PROPOSE_TRACES = Job("propose_traces", Lane.PRODUCTS, TracesOrder, FoundTraces, _propose)

JOBS = (FIND_EDGES, PROPOSE_TRACES)
