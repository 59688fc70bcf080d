"""Proposed lines for review, as from `trace --propose` and `vs.propose_traces`."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.results import HIDDEN_IN_JSON
from vomstudio.core.words import tr
from vomstudio.extraction.followed_trace import fit_trace_plane, index_vertices
from vomstudio.extraction.following import Follower
from vomstudio.extraction.proposals.edge_pictures import EDGE_COST
from vomstudio.extraction.proposals.lines import N_SURROGATES as SURROGATES
from vomstudio.extraction.proposals.lines import (
    compute_evidence,
    find_lines,
    line_p_value,
    simulate_strengths,
)
from vomstudio.extraction.proposals.thinning import MAX_POINTS, sample_points
from vomstudio.extraction.surface_graph import SurfaceGraph
from vomstudio.extraction.trace_options import ProposalOptions
from vomstudio.geology.band_figures import BandFigures
from vomstudio.geology.profiles import DEFAULT_THRESHOLDS, Thresholds
from vomstudio.project.tables.orientation_table import Row

DEFAULT_MIN_LENGTH_RESOLUTIONS = 20.0
"""Default minimum length of a line, in model resolutions."""


@dataclass(frozen=True, eq=False, repr=False)
class TraceProposal(PrintableResult):
    """Proposed line that may be a contact.

    Parameters
    ----------
    line : str
        Name of the line.
    points : (n, 3) array
        Points of the line in the World frame, m.
    length_m : float
        Length along the line, m.
    evidence : float
        Mean evidence along the line, in standard deviations of the noise of the surface around it.
    doubt : float
        Probability that noise contains a line as strong anywhere on the surface.
    plane : dict or None
        Row of the orientation table; None if no plane can be fitted.
    band : BandFigures or None
        Band of planes that are compatible with a straight line; None if the plane is determined or
        cannot be fitted.
    """

    line: str
    points: FloatArray = field(repr=False, metadata=HIDDEN_IN_JSON)
    length_m: float
    evidence: float
    doubt: float
    plane: Row | None
    band: BandFigures | None


@dataclass(frozen=True, eq=False, repr=False)
class ProposedTraces(PrintableResult):
    """Proposed lines that may be contacts.

    Parameters
    ----------
    proposals : tuple of TraceProposal
        Proposals in order of increasing doubt.
    cost : str
        Name of the cost from which the evidence was computed.
    least_length_m : float
        Minimum length of a line, m.
    surrogates : int
        Number of simulated noise surfaces.
    warnings : tuple of Finding
    """

    proposals: tuple[TraceProposal, ...]
    cost: str
    least_length_m: float
    surrogates: int
    warnings: tuple[Finding, ...] = ()


def propose_traces(
    surface: SurfaceGraph,
    options: ProposalOptions,
    *,
    resolution: float,
    model: str,
    frame: str,
    progress: Progress,
    thresholds: Thresholds = DEFAULT_THRESHOLDS,
) -> ProposedTraces:
    """Find lines that stand out from the noise of a surface.

    Parameters
    ----------
    surface : SurfaceGraph
        Surface of a model in the World frame; for the cost "onnx", it is coloured by the edges of
        the network.
    options : ProposalOptions
    resolution : float
        Resolution of the model, m.
    model, frame : str
        Names used in the orientation table.
    progress : Progress
    thresholds : Thresholds

    Returns
    -------
    ProposedTraces

    Raises
    ------
    UsageError
        If the cost is not available for the model.
    Cancelled
        Through `progress`.
    """
    name = options.used_cost
    cost = name if options.onnx_model is None else EDGE_COST
    Follower(surface, cost)
    min_length = options.min_length_m or DEFAULT_MIN_LENGTH_RESOLUTIONS * resolution
    progress.stage(tr("Finding lines"), None)
    whole_surface = surface
    warnings: tuple[Finding, ...] = ()
    if (count := len(surface.places)) > MAX_POINTS:
        surface = SurfaceGraph(sample_points(surface.data, MAX_POINTS))
        if options.min_length_m is None:
            min_length *= float(np.sqrt(count / MAX_POINTS))
        warnings = (Finding("path.reduced", points=count, used=MAX_POINTS),)
    graph = surface.finest
    evidence = compute_evidence(graph, cost)
    progress.step(0)
    lines = find_lines(graph, evidence, min_length, options.max_lines)
    null_strengths = np.zeros(0)
    if lines:
        progress.stage(tr("Comparing with noise"), SURROGATES)
        null_strengths = simulate_strengths(graph, evidence, name, min_length, progress.step)
    vertices = index_vertices(whole_surface)
    proposals = []
    for i, line in enumerate(lines):
        progress.step(SURROGATES)
        points = surface.world(graph, line.nodes)
        notes = tr("proposed using the cost {cost}, not reviewed", cost=name)
        plane, band, _ = fit_trace_plane(
            points,
            vertices,
            model=model,
            frame=frame,
            thresholds=thresholds,
            notes=notes,
            priors=(),
        )
        number = str(i + 1)
        if plane is not None:
            plane = {**plane, "id": number}
        proposals.append(
            TraceProposal(
                number,
                points,
                line.length,
                line.evidence,
                line_p_value(line.strength, null_strengths),
                plane,
                band,
            )
        )
    return ProposedTraces(tuple(proposals), name, min_length, SURROGATES, warnings)
