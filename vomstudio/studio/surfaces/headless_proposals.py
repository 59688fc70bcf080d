"""Proposed facets and traces of a model in a project without a window."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from vomstudio.core.errors import DocumentError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.identifiers import new_id
from vomstudio.core.progress import Progress
from vomstudio.extraction.facet_options import FacetOptions
from vomstudio.extraction.trace_options import ProposalOptions
from vomstudio.geology.profiles import DEFAULT_THRESHOLDS
from vomstudio.project import edits
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import Feature, Model, Record
from vomstudio.studio.headless_project import HeadlessProject
from vomstudio.studio.jobs.placed_model import PlacedModel
from vomstudio.studio.jobs.proposal_tasks import PROPOSE_TRACES, TracesRequest
from vomstudio.studio.jobs.surface_tasks import FIND_FACETS, FacetsRequest
from vomstudio.studio.models import placed_model
from vomstudio.studio.project_options import AcceptOptions
from vomstudio.studio.surfaces.facet_proposals import assess_facets
from vomstudio.studio.surfaces.trace_proposals import assess_lines, known_lines

QUALITIES = {"good": ("good",), "doubtful": ("good", "doubtful")}
"""Verdicts that are at least as good as a quality."""


@dataclass(frozen=True)
class AcceptedProposals:
    """Proposals that were added, and the number of all proposals."""

    features: tuple[Feature, ...]
    proposed: int
    warnings: tuple[Finding, ...]


def accept_proposals(
    project: HeadlessProject,
    search: FacetOptions | ProposalOptions,
    options: AcceptOptions,
    progress: Progress,
) -> AcceptedProposals:
    """Search for facets or traces as the window does, and add them in one edit.

    Parameters
    ----------
    project : HeadlessProject
    search : FacetOptions or ProposalOptions
        Options that select the search. Lines that are already traces are not proposed.
    options : AcceptOptions
    progress : Progress

    Returns
    -------
    AcceptedProposals

    Raises
    ------
    InputError, GeometryError
        If the model cannot be read or has no surface.
    UsageError
        If the model or type is unknown, or an option does not apply.
    DocumentError
        If nothing is found, or no proposal has the quality.
    """
    model, feature_type = project.find_model(options.model), project.find_type(options.type)
    # Reports a file that is missing or has changed.
    project.read_model(model)
    path = project.project.find_model(model) or Path(model.path)
    model_with_placement = placed_model(model, path, project.project.cache)
    records = dict(project.session.records)
    features, measurements, warnings = _propose(
        model, model_with_placement, search, records, progress
    )
    if not features:
        raise DocumentError(Finding("proposals.not-found", model=model.name))
    selected_rows = [
        replace(
            feature,
            id=new_id(feature.id.partition("-")[0]),
            type_id=feature_type.id,
            set_name=options.set or "",
        )
        for feature, figures in zip(features, measurements, strict=True)
        if options.quality is None
        or (figures.verdict is not None and figures.verdict.quality in QUALITIES[options.quality])
    ]
    if not selected_rows:
        raise DocumentError(
            Finding("proposals.none", proposed=len(features), quality=options.quality)
        )
    edit = edits.add_features(records, selected_rows)
    project.session.apply(edit)
    added_features = tuple(item for item in edit.after.values() if isinstance(item, Feature))
    return AcceptedProposals(added_features, len(features), warnings)


def _propose(
    model: Model,
    placed_model: PlacedModel,
    search: FacetOptions | ProposalOptions,
    records: dict[str, Record],
    progress: Progress,
) -> tuple[Sequence[Patch | Trace], Sequence[Measurement], tuple[Finding, ...]]:
    with TemporaryDirectory() as folder:
        out = Path(folder) / "proposals.npz"
        if isinstance(search, FacetOptions):
            flags = {"--propose-sets": search.propose_sets, "--preset": search.preset}
            for flag, value in flags.items():
                if value:
                    conflict = Finding("option.conflict", option=flag, other="accept")
                    raise UsageError(conflict, field=flag)
            facets = FIND_FACETS.function(FacetsRequest(placed_model, search, None, out), progress)
            proposals = assess_facets(model, search, facets, True, records, DEFAULT_THRESHOLDS)
            patches = [replace(item, notes=proposals.provenance) for item in proposals.patches]
            return patches, proposals.measured, facets.warnings
        known_traces = known_lines(records, model.id)
        request = replace(search, max_lines=search.max_lines + len(known_traces))
        result = PROPOSE_TRACES.function(TracesRequest(placed_model, request, out), progress)
        lines = assess_lines(model, search, result, known_traces, records, DEFAULT_THRESHOLDS)
        note = lines.provenance("trace.accepted")
        traces = [replace(line.trace, notes=note) for line in lines.lines]
        return traces, [line.measured for line in lines.lines], result.warnings
