"""What `vomstudio trace --propose` and `vs.propose_traces` tell: lines to look at, no result."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.results import HIDDEN
from vomstudio.core.words import tr
from vomstudio.extraction.followed_trace import near_surface, plane_of
from vomstudio.extraction.following import Follower
from vomstudio.extraction.proposals.edge_pictures import DRAWN
from vomstudio.extraction.proposals.lines import SURROGATES as SURROGATES
from vomstudio.extraction.proposals.lines import (
    doubt_of,
    evidence_of,
    find_lines,
    strongest_in_noise,
)
from vomstudio.extraction.proposals.thinning import MOST_POINTS, few_enough
from vomstudio.extraction.surface_graph import SurfaceGraph
from vomstudio.extraction.trace_options import ProposalOptions
from vomstudio.geology.band_figures import BandFigures
from vomstudio.geology.profiles import DEFAULTS, Thresholds
from vomstudio.project.tables.orientation_table import Row

DEFAULT_MIN_RESOLUTIONS = 20.0
"""Default of the minimum length of a line, in resolutions of the model."""


@dataclass(frozen=True, eq=False, repr=False)
class Proposal(PrintableResult):
    """A line that may be a contact.

    line : its name; points : (n, 3) World, m; length_m : along it
    evidence : its mean, in standard deviations of the noise of the surface around it
    doubt : the chance that noise alone makes a line as strong somewhere on the surface
    plane : row of the orientation table, None where there is none; band : of the planes that a
        straight line allows
    """

    line: str
    points: FloatArray = field(repr=False, metadata=HIDDEN)
    length_m: float
    evidence: float
    doubt: float
    plane: Row | None
    band: BandFigures | None


@dataclass(frozen=True, eq=False, repr=False)
class ProposedTraces(PrintableResult):
    """proposals : the least doubtful first; cost : what was looked for; least_length_m : of a line;
    surrogates : surfaces of noise that the doubts are told from; warnings : sentences"""

    proposals: tuple[Proposal, ...]
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
    thresholds: Thresholds = DEFAULTS,
) -> ProposedTraces:
    """Find lines that stand out of the noise of a surface.

    Parameters
    ----------
    surface : SurfaceGraph
        Of a model in World; for the cost "onnx" it wears the edges of the network.
    options : ProposalOptions
    resolution : float
        Of the model, m.

    Raises
    ------
    UsageError
        For a cost that the model does not have.
    Cancelled
    """
    name = options.used_cost
    cost = name if options.onnx_model is None else DRAWN
    Follower(surface, cost)
    least = options.min_length_m or DEFAULT_MIN_RESOLUTIONS * resolution
    progress.stage(tr("Finding lines"), None)
    whole = surface
    warnings: tuple[Finding, ...] = ()
    if (count := len(surface.places)) > MOST_POINTS:
        surface = SurfaceGraph(few_enough(surface.data, MOST_POINTS))
        if options.min_length_m is None:
            least *= float(np.sqrt(count / MOST_POINTS))
        warnings = (Finding("path.reduced", points=count, used=MOST_POINTS),)
    graph = surface.finest
    evidence = evidence_of(graph, cost)
    progress.step(0)
    lines = find_lines(graph, evidence, least, options.max_lines)
    strongest = np.zeros(0)
    if lines:
        progress.stage(tr("Comparing with noise"), SURROGATES)
        strongest = strongest_in_noise(graph, evidence, name, least, progress.step)
    near = near_surface(whole)
    found = []
    for i, line in enumerate(lines):
        progress.step(SURROGATES)
        points = surface.world(graph, line.nodes)
        notes = tr("proposed by {cost}, not looked at", cost=name)
        plane, band, _ = plane_of(
            points, near, model=model, frame=frame, thresholds=thresholds, notes=notes, priors=()
        )
        number = str(i + 1)
        if plane is not None:
            plane = {**plane, "id": number}
        found.append(
            Proposal(
                number,
                points,
                line.length,
                line.evidence,
                doubt_of(line.strength, strongest),
                plane,
                band,
            )
        )
    return ProposedTraces(tuple(found), name, least, SURROGATES, warnings)
