"""Facets of a model with what was asked for: thresholds, sets, the sequence of another program."""

from __future__ import annotations

from vomstudio.errors import UsageError
from vomstudio.extraction.facet_sets import with_proposal, with_sets
from vomstudio.extraction.facet_table import FacetTable, facet_table
from vomstudio.extraction.facets import ANGLE_DEG, Limits, find_facets, require_limits
from vomstudio.extraction.set_sequence import CONE_DEG, find_sequence, require_sequence_limits
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.progress import Progress
from vomstudio.words import tr

PRESETS = ("dse",)


def search_limits(
    angle_deg: float | None,
    max_distance: float | None,
    min_points: int | None,
    min_area: float | None,
    preset: str | None,
) -> Limits:
    """With the default angle where none is given. Raises UsageError for limits that are none, and
    for a preset that there is not."""
    if preset is None:
        limits = Limits(
            ANGLE_DEG if angle_deg is None else angle_deg, max_distance, min_points, min_area
        )
        require_limits(limits)
        return limits
    if preset not in PRESETS:
        raise UsageError(
            tr("There is no preset {name!r}. There is: dse.", name=preset), field="--preset"
        )
    limits = Limits(
        CONE_DEG if angle_deg is None else angle_deg, max_distance, min_points, min_area
    )
    require_sequence_limits(limits)
    return limits


def search(
    data: Mesh | PointCloud,
    limits: Limits,
    *,
    preset: str | None,
    sets: bool,
    model: str,
    frame: str,
    progress: Progress,
) -> FacetTable:
    """Facets of a model in World. preset : None, or one of PRESETS, which has sets of its own;
    model : its name; frame : what azimuths count from. Raises GeometryError, Cancelled."""
    if preset is not None:
        sequence = find_sequence(data, limits, progress=progress)
        found = facet_table(sequence.facets, limits, model=model, frame=frame)
        return with_proposal(found, sequence.facets.facets, sequence.sets) if found.rows else found
    facets = find_facets(data, limits, progress=progress)
    found = facet_table(facets, limits, model=model, frame=frame)
    return with_sets(found, facets.facets) if sets else found
