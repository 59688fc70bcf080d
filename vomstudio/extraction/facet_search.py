"""Search for the facets of a model and, on request, their sets."""

from __future__ import annotations

from vomstudio.core.progress import Progress
from vomstudio.extraction.facet_options import FacetOptions
from vomstudio.extraction.facet_sets import add_proposal, add_sets
from vomstudio.extraction.facet_table import FacetTable, tabulate_facets
from vomstudio.extraction.facets import find_facets
from vomstudio.extraction.set_sequence import find_sequence
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh


def search_facets(
    data: Mesh | PointCloud,
    options: FacetOptions,
    *,
    model: str,
    frame: str,
    progress: Progress,
) -> FacetTable:
    """Find the facets of a model and, on request, their sets.

    Parameters
    ----------
    data : Mesh or PointCloud
        Model in the World frame, m.
    options : FacetOptions
    model : str
        Name of the model.
    frame : str
        Reference direction of azimuths.
    progress : Progress

    Returns
    -------
    FacetTable

    Raises
    ------
    GeometryError
        If the model has no surface.
    Cancelled
        Through `progress`.
    """
    if options.preset is not None:
        sequence = find_sequence(data, options, progress=progress)
        table = tabulate_facets(sequence.facets, options, model=model, frame=frame)
        if not table.rows:
            return table
        return add_proposal(table, sequence.facets.facets, sequence.sets)
    facets = find_facets(data, options, progress=progress)
    table = tabulate_facets(facets, options, model=model, frame=frame)
    return add_sets(table, facets.facets) if options.propose_sets else table
