"""Section through a model, as in the command `section`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.matrices import Matrix
from vomstudio.geometry.mesh import Mesh
from vomstudio.products.section.section_options import DOMAINS, SectionFeatures, SectionOptions
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.records import Feature, Record

if TYPE_CHECKING:
    from vomstudio.products.ortho.interpretation import ProjectedItem
    from vomstudio.products.ortho.vector_drawing import Drawing
    from vomstudio.products.section.cutting import Cut
    from vomstudio.products.section.section_lines import Curtain
    from vomstudio.products.section.writing import SectionFigures


@dataclass(frozen=True, eq=False)
class SectionRequest:
    """Input of a section.

    Attributes
    ----------
    data : Mesh or PointCloud
        Model in its own frame.
    path : Path
        File of the model.
    crs : str or None
        CRS of the World frame.
    records : mapping or None
        Records of the project; if None, the section contains no features.
    direction : (3,) float64 or None
        Direction of projection; None projects perpendicular to the section.
    """

    data: Mesh | PointCloud
    to_world: Matrix
    path: Path
    crs: str | None
    is_metric: bool
    is_north_known: bool
    curtain: Curtain
    options: SectionOptions
    features: SectionFeatures
    records: Mapping[str, Record] | None
    direction: FloatArray | None


@dataclass(frozen=True, eq=False)
class SectionResult:
    request: SectionRequest
    cut: Cut
    projected_items: tuple[ProjectedItem, ...]
    figures: SectionFigures
    drawing: Drawing
    warnings: tuple[Finding, ...] = ()


def compute_section(request: SectionRequest) -> SectionResult:
    """Compute a section as in the command `section`. Runs in a worker thread."""
    from vomstudio.geometry.model_transform import transform_model
    from vomstudio.products.ortho.interpretation import items_from_records
    from vomstudio.products.section import writing
    from vomstudio.products.section.cutting import cut_model
    from vomstudio.products.section.directions import ProjectionDirections, assign_domain_axes

    q = request
    data = transform_model(q.data, q.to_world)
    cut = cut_model(data, q.curtain, q.options.slab_m)
    features = q.records is not None and any(
        isinstance(record, Feature) for record in q.records.values()
    )
    items = items_from_records(q.records, Measurements()) if features and q.records else ()
    has_domains = q.features.along == DOMAINS and bool(items)
    directions = (
        assign_domain_axes(items, "domains") if has_domains else ProjectionDirections(q.direction)
    )
    direction_warnings = directions.check(q.curtain)
    projected_features, n_skipped = writing.project_items(
        items, q.curtain, directions, q.features.within_m
    )
    figures = writing.section_figures(cut, q.curtain, projected_features, n_skipped, directions)
    drawing = writing.section_drawing(
        cut,
        q.curtain,
        projected_features,
        is_metric=q.is_metric,
        is_north_known=q.is_north_known,
        model=str(q.path),
        figures=figures,
    )
    return SectionResult(
        request=q,
        cut=cut,
        projected_items=projected_features,
        figures=figures,
        drawing=drawing,
        warnings=direction_warnings if projected_features else (),
    )


def write(result: SectionResult, path: Path) -> None:
    """Write the section in the format of the file extension, replacing an existing file.

    Runs in a worker thread.
    """
    from vomstudio.products.section.writing import write_section

    q = result.request
    write_section(
        path,
        result.cut,
        q.curtain,
        result.figures,
        result.projected_items,
        crs=q.crs,
        model=str(q.path),
        is_metric=q.is_metric,
        is_north_known=q.is_north_known,
        force=True,
    )


def build_curtain(
    plane: object, passing_point: FloatArray | None, line: FloatArray | None
) -> Curtain:
    """Build the section surface from a line or a plane.

    Parameters
    ----------
    plane : Plane
        Plane of the section, used if `line` is not given.
    passing_point : (3,) float64 or None
        Point on the plane.
    line : (n, 2) or (n, 3) float64 or None
        Vertices of the section line.
    """
    from vomstudio.geology.orientation import Plane
    from vomstudio.products.section.section_lines import curtain_from_line, curtain_from_plane

    if line is not None:
        return curtain_from_line(line)
    assert isinstance(plane, Plane)
    assert passing_point is not None
    return curtain_from_plane(plane, passing_point)
