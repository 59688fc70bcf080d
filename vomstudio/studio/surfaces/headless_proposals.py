"""Proposed facets and traces of a model in a project without a window."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.extraction.facet_options import FacetOptions
from vomstudio.extraction.trace_options import ProposalOptions
from vomstudio.geology.profiles import DEFAULTS
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import Model, Record
from vomstudio.studio.jobs.placed_model import PlacedModel
from vomstudio.studio.jobs.proposal_tasks import PROPOSE_TRACES, TracesRequest
from vomstudio.studio.jobs.surface_tasks import FIND_FACETS, FacetsRequest
from vomstudio.studio.surfaces.facet_proposals import assess_facets
from vomstudio.studio.surfaces.trace_proposals import assess_lines, known_lines

QUALITIES = {"good": ("good",), "doubtful": ("good", "doubtful")}
"""Verdicts that are at least as good as a quality."""


@dataclass(frozen=True)
class ProposedFeatures:
    """Proposed patches or traces of a quality, and the number of all proposals."""

    features: tuple[Patch | Trace, ...]
    proposed: int
    warnings: tuple[Finding, ...]


def propose_features(
    model: Model,
    placed: PlacedModel,
    options: FacetOptions | ProposalOptions,
    records: Mapping[str, Record],
    progress: Progress,
    *,
    quality: str | None = None,
) -> ProposedFeatures:
    """Search for facets or traces, as the window does.

    Parameters
    ----------
    model : Model
        Record of the model.
    placed : PlacedModel
        File of the model with its placement.
    options : FacetOptions or ProposalOptions
        Options that select what is searched for.
    records : mapping
        Records of the project; lines that are already traces are not proposed.
    progress : Progress
    quality : {"good", "doubtful"}, optional
        Minimum quality of a feature; by default all are returned.

    Returns
    -------
    ProposedFeatures

    Raises
    ------
    InputError, GeometryError, UsageError, Cancelled
    """
    with TemporaryDirectory() as folder:
        out = Path(folder) / "proposals.npz"
        if isinstance(options, FacetOptions):
            for flag, is_given in (
                ("--propose-sets", options.propose_sets),
                ("--preset", options.preset is not None),
            ):
                if is_given:
                    raise UsageError(
                        Finding("option.conflict", option=flag, other="accept"), field=flag
                    )
            facets = FIND_FACETS.do(FacetsRequest(placed, options, None, out), progress)
            proposals = assess_facets(model, options, facets, True, dict(records), DEFAULTS)
            patches = [replace(each, notes=proposals.provenance) for each in proposals.patches]
            return _select(patches, proposals.measured, facets.warnings, quality)
        traced = known_lines(records, model.id)
        request = replace(options, max_lines=options.max_lines + len(traced))
        found = PROPOSE_TRACES.do(TracesRequest(placed, request, out), progress)
        lines = assess_lines(model, options, found, traced, dict(records), DEFAULTS)
        note = lines.provenance("trace.accepted")
        traces = [replace(line.trace, notes=note) for line in lines.lines]
        return _select(traces, [line.measured for line in lines.lines], found.warnings, quality)


def _select(
    features: Sequence[Patch | Trace],
    measured: Sequence[Measurement],
    warnings: Sequence[Finding],
    quality: str | None,
) -> ProposedFeatures:
    selected = [
        feature
        for feature, figures in zip(features, measured, strict=True)
        if quality is None
        or (figures.verdict is not None and figures.verdict.quality in QUALITIES[quality])
    ]
    return ProposedFeatures(tuple(selected), len(features), tuple(warnings))
