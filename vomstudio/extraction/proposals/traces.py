"""What `vomstudio trace --propose` and `vs.propose_traces` tell: lines to look at, no result."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.core.findings import Message
from vomstudio.errors import UsageError
from vomstudio.extraction.followed_trace import near_surface, plane_of
from vomstudio.extraction.following import Follower
from vomstudio.extraction.proposals.lines import SURROGATES as SURROGATES
from vomstudio.extraction.proposals.lines import (
    doubt_of,
    evidence_of,
    find_lines,
    strongest_in_noise,
)
from vomstudio.extraction.proposals.thinning import MOST_POINTS, few_enough
from vomstudio.extraction.surface_graph import SurfaceGraph
from vomstudio.geology.band_figures import BandFigures
from vomstudio.geology.profiles import DEFAULTS, Thresholds
from vomstudio.progress import Progress
from vomstudio.reprs import Shown
from vomstudio.tables.orientation_table import Row
from vomstudio.words import tr

LEAST_LENGTH = 20.0
"""A line is proposed from so many resolutions on, where no length is asked for."""
MOST = 50


@dataclass(frozen=True, eq=False, repr=False)
class Proposal(Shown):
    """A line that may be a contact.

    line : its name; points : (n, 3) World, m; length_m : along it
    evidence : its mean, in standard deviations of the noise of the surface around it
    doubt : the chance that noise alone makes a line as strong somewhere on the surface
    plane : row of the orientation table, None where there is none; band : of the planes that a
        straight line allows
    """

    line: str
    points: npt.NDArray[np.float64] = field(repr=False)
    length_m: float
    evidence: float
    doubt: float
    plane: Row | None
    band: BandFigures | None

    def as_dict(self) -> dict[str, Any]:
        """Ready for JSON, with the names of the command."""
        told = {name: value for name, value in vars(self).items() if name != "points"}
        return {**told, "band": None if self.band is None else self.band.as_dict()}


@dataclass(frozen=True, eq=False, repr=False)
class ProposedTraces(Shown):
    """proposals : the least doubtful first; cost : what was looked for; least_length_m : of a line;
    surrogates : surfaces of noise that the doubts are told from; warnings : sentences"""

    proposals: tuple[Proposal, ...]
    cost: str
    least_length_m: float
    surrogates: int
    warnings: tuple[Message, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Ready for JSON, with the names of the command."""
        told = {**vars(self), "warnings": list(self.warnings)}
        return {**told, "proposals": [one.as_dict() for one in self.proposals]}


def propose_traces(
    surface: SurfaceGraph,
    *,
    cost: str,
    resolution: float,
    least_length: float | None,
    most: int,
    model: str,
    frame: str,
    progress: Progress,
    thresholds: Thresholds = DEFAULTS,
    called: str = "",
) -> ProposedTraces:
    """surface : of a model in World; cost : "gradient", "curvature", "dark", "light" or a field;
    resolution : of the model, m; least_length : m, None for twenty resolutions
    called : "onnx" where what is dark are the edges of a network

    Raises UsageError for a cost that the model does not have, and for lengths and numbers that are
    none; Cancelled.
    """
    if cost in ("colour", "auto"):
        raise UsageError(
            tr(
                "Without way-points there is no colour to look for. Propose by gradient, "
                "curvature, dark, light or a field."
            ),
            field="--cost",
        )
    if least_length is not None and not 0.0 < least_length < np.inf:
        raise UsageError(tr("A length is a number of metres above 0."), field="--least-length")
    if most < 1:
        raise UsageError(tr("At least one line is proposed."), field="--most")
    Follower(surface, cost)
    least = LEAST_LENGTH * resolution if least_length is None else least_length
    progress.stage(tr("Finding lines"), None)
    whole = surface
    warnings: tuple[Message, ...] = ()
    if (count := len(surface.places)) > MOST_POINTS:
        surface = SurfaceGraph(few_enough(surface.data, MOST_POINTS))
        if least_length is None:
            least *= float(np.sqrt(count / MOST_POINTS))
        warnings = (
            tr(
                "The model has {count:,} points; lines were looked for among {some:,} of them, so "
                "the finest were not seen.",
                count=count,
                some=MOST_POINTS,
            ),
        )
    graph = surface.finest
    evidence = evidence_of(graph, cost)
    progress.step(0)
    lines = find_lines(graph, evidence, least, most)
    strongest = np.zeros(0)
    if lines:
        progress.stage(tr("Comparing with noise"), SURROGATES)
        strongest = strongest_in_noise(graph, evidence, called or cost, least, progress.step)
    near = near_surface(whole)
    found = []
    for i, line in enumerate(lines):
        progress.step(SURROGATES)
        points = surface.world(graph, line.nodes)
        notes = tr("proposed by {cost}, not looked at", cost=called or cost)
        plane, band, _ = plane_of(
            points, near, model=model, frame=frame, thresholds=thresholds, notes=notes, priors=()
        )
        name = str(i + 1)
        if plane is not None:
            plane = {**plane, "id": name}
        found.append(
            Proposal(
                name, points, line.length, line.evidence, doubt_of(line.strength, strongest),
                plane, band,
            )
        )  # fmt: skip
    return ProposedTraces(tuple(found), called or cost, least, SURROGATES, warnings)
