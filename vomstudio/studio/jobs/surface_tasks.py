"""Jobs on the surface of one model, such as its fields and facets."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import to_translate
from vomstudio.extraction.facet_options import FacetOptions
from vomstudio.extraction.measurable_options import MeasurableOptions
from vomstudio.studio.jobs.job import Job, Lane
from vomstudio.studio.jobs.placed_model import PlacedModel, load_in_world

if TYPE_CHECKING:
    from vomstudio.core.arrays import FloatArray, GenericArray
    from vomstudio.extraction.facets import FacetSegmentation
    from vomstudio.extraction.local_parts import ModelPart

    Arrays = dict[str, GenericArray]

MEMORY_ADVICE = to_translate("Use a smaller part of the model, or close other programs.")


@dataclass(frozen=True)
class FieldsRequest:
    """Request to compute the fields of a surface.

    Parameters
    ----------
    key : str
        Identifies the model with its placement, so that existing fields in `out` can be reused.
    out : Path
        Output file for the fields.
    """

    model: PlacedModel
    radius_m: float
    key: str
    out: Path


@dataclass(frozen=True)
class ComputedFields:
    """Fields of a surface.

    `out` contains float32 arrays for all points of the model, named by the keys of
    `extraction.surface_fields.KINDS`. `typical_count` is the typical number of points within the
    radius.
    """

    out: Path
    typical_count: int
    warnings: tuple[Finding, ...]


def _compute(request: FieldsRequest, progress: Progress) -> ComputedFields:
    import numpy as np

    from vomstudio.extraction.surface_fields import KINDS, surface_fields

    mark = f"{request.key} {request.radius_m!r}"
    cached_fields = _read_cached(request.out, mark)
    if cached_fields is not None:
        return cached_fields
    fields = surface_fields(load_in_world(request.model, progress), request.radius_m, progress)
    arrays: dict[str, Any] = {key: fields.values[key] for key in KINDS}
    arrays |= {
        "mark": np.array(mark),
        "count": np.array(fields.typical_count),
        "warnings": np.array(json.dumps([item.to_dict() for item in fields.warnings])),
    }
    request.out.parent.mkdir(parents=True, exist_ok=True)
    part = request.out.with_name(f"{request.out.stem}.part.npz")
    np.savez(part, **arrays)
    os.replace(part, request.out)
    return ComputedFields(request.out, fields.typical_count, fields.warnings)


def _read_cached(out: Path, mark: str) -> ComputedFields | None:
    """Return the fields that an earlier job stored with the same mark, or None."""
    from vomstudio.core.files.arrays import open_arrays
    from vomstudio.extraction.surface_fields import KINDS

    try:
        with open_arrays(out) as arrays:
            if str(arrays["mark"]) != mark or not set(KINDS) <= set(arrays.files):
                return None
            rows = json.loads(str(arrays["warnings"]))
            warnings = tuple(Finding.from_dict(row) for row in rows)
            return ComputedFields(out, int(arrays["count"]), warnings)
    except (OSError, ValueError, KeyError, EOFError):
        return None


COMPUTE_FIELDS = Job(
    "compute_fields", Lane.PRODUCTS, FieldsRequest, ComputedFields, _compute, MEMORY_ADVICE
)


@dataclass(frozen=True)
class MeasurableRequest:
    """Request for a map of where a plane can be measured.

    `normal` is the normal of the plane in the World frame. `out` is the output file for the
    fields, float32 for all points, with the names in `products.surface.measurable_map.FIELDS`.
    """

    model: PlacedModel
    normal: tuple[float, float, float]
    options: MeasurableOptions
    out: Path


@dataclass(frozen=True)
class MappedMeasurable:
    """Fields of a map of measurable planes, and findings about their shares of the surface."""

    out: Path
    findings: tuple[Finding, ...]


def _map_measurable(request: MeasurableRequest, progress: Progress) -> MappedMeasurable:
    import numpy as np

    from vomstudio.geology.orientation import Plane
    from vomstudio.products.surface.measurable_map import measurable_map, share_findings

    fields = measurable_map(
        load_in_world(request.model, progress),
        Plane.from_normal(np.array(request.normal)),
        request.options,
        progress,
    )
    arrays: dict[str, Any] = fields.as_fields()
    request.out.parent.mkdir(parents=True, exist_ok=True)
    part = request.out.with_name(f"{request.out.stem}.part.npz")
    np.savez(part, **arrays)
    os.replace(part, request.out)
    return MappedMeasurable(request.out, (*share_findings(fields), *fields.warnings))


MAP_MEASURABLE = Job(
    "map_measurable",
    Lane.PRODUCTS,
    MeasurableRequest,
    MappedMeasurable,
    _map_measurable,
    MEMORY_ADVICE,
)


@dataclass(frozen=True)
class Viewpoint:
    """User's view in the World frame: eye, target and number of surface points to examine."""

    eye: tuple[float, float, float]
    toward: tuple[float, float, float]
    points: int


@dataclass(frozen=True)
class FacetsRequest:
    """Request for facets of a model, or of the visible `part`; `out` is the output file."""

    model: PlacedModel
    options: FacetOptions
    part: Viewpoint | None
    out: Path


@dataclass(frozen=True)
class FacetsResult:
    """Facets of a model.

    Parameters
    ----------
    element : {"face", "point"}
        Type of the elements of the facets.
    reach_m : float
        Median of the facets' maximum distances from their planes, metres.
    near_planar_share, coverage, exposed_m2, vegetation_share, debris_share : float
        As in `extraction.exposure.Exposure`.
    out : Path
        File with the arrays of `_facet_arrays`.
    """

    count: int
    element: str
    reach_m: float
    min_points: int
    near_planar_share: float | None
    coverage: float | None
    exposed_m2: float
    vegetation_share: float
    debris_share: float
    warnings: tuple[Finding, ...]
    out: Path


def _find_facets(request: FacetsRequest, progress: Progress) -> FacetsResult:
    import numpy as np

    from vomstudio.extraction.facets import find_facets
    from vomstudio.extraction.local_parts import ModelPart, extract_visible_part
    from vomstudio.geometry.mesh import Mesh

    data = load_in_world(request.model, progress)
    mesh = isinstance(data, Mesh)
    count = len(data.vertices) if isinstance(data, Mesh) else len(data.points)
    part = ModelPart(data, np.arange(count), np.arange(len(data.faces) if mesh else 0))  # type: ignore[union-attr]
    if request.part is not None:
        part = extract_visible_part(
            data, request.part.eye, request.part.toward, request.part.points
        )
    facets = find_facets(part.data, request.options, progress=progress)
    request.out.parent.mkdir(parents=True, exist_ok=True)
    arrays: dict[str, Any] = _facet_arrays(facets, part, count, request.model.to_world)
    np.savez(request.out, **arrays)
    exposure = facets.exposure
    return FacetsResult(
        len(facets.facets),
        facets.kind,
        facets.max_distance,
        facets.min_points,
        exposure.near_planar_share,
        exposure.coverage,
        exposure.exposed_m2,
        exposure.vegetation_share,
        exposure.debris_share,
        facets.warnings,
        request.out,
    )


def _facet_arrays(result: FacetSegmentation, part: ModelPart, count: int, to_world: Any) -> Arrays:
    """Return the arrays that describe the facets.

    `label` and `covers` (points,) int32 contain the facet and the cover class (see
    `extraction.exposure.Exposure`) of each point of the model, or -1. The arrays of the f facets
    are `n`, `n_effective`, `mean` (f, 3), `scatter` (f, 3, 3), `area`, `resolution`, `bent`,
    `level_gap` and `bend_deg` (0 if undefined), in the file frame. The faces or points of facet i
    are `rows[row_cuts[i]:row_cuts[i + 1]]`, and its outline is stored in the same way. `exposed_m2`
    is in the World frame.
    """
    import numpy as np

    from vomstudio.geometry import transform
    from vomstudio.geometry.patches import outline

    to_file = transform.invert(transform.matrix(to_world))
    rotation, scale = to_file[:3, :3], transform.scale_factor(to_world)
    element_ids = part.points if result.kind == "point" else part.faces
    label, cover_classes = np.full((2, count), -1, np.int32)
    label[part.points], cover_classes[part.points] = result.labels, result.cover_classes
    facets, rings = result.facets, []
    for facet in facets:
        ring = outline(_element_corners(part, result.kind, facet.rows), facet.fit.normal)
        rings.append(transform.apply(to_file, np.array(ring).reshape(-1, 3)))
    rows = [np.sort(element_ids[facet.rows]) for facet in facets]
    moments = [facet.moments for facet in facets]
    mean = np.array([m.mean for m in moments]).reshape(-1, 3)
    scatter = np.array([m.scatter for m in moments]).reshape(-1, 3, 3)
    return {
        "label": label,
        "covers": cover_classes,
        "n": np.array([m.n for m in moments], np.int64),
        "n_effective": np.array([m.n_effective for m in moments]),
        "mean": transform.apply(to_file, mean),
        "scatter": rotation @ scatter @ rotation.T,
        "area": np.array([facet.area for facet in facets]) / scale**2,
        "resolution": np.array([facet.resolution for facet in facets]) / scale,
        "bent": np.array([facet.is_bent for facet in facets], np.bool_),
        "level_gap": np.array([facet.level_gap or 0.0 for facet in facets]) / scale,
        "bend_deg": np.array([facet.bend_deg or 0.0 for facet in facets]),
        "exposed_m2": result.exposure.exposed_by_facet_m2,
        "rows": np.concatenate([*rows, np.zeros(0, np.int64)]),
        "row_cuts": np.cumsum([0, *map(len, rows)]),
        "outline": np.concatenate([*rings, np.zeros((0, 3))]),
        "outline_cuts": np.cumsum([0, *map(len, rings)]),
    }


def _element_corners(part: ModelPart, element: str, rows: Any) -> FloatArray:
    """Return the distinct vertices (k, 3) of some faces, or the given points."""
    import numpy as np

    from vomstudio.geometry.mesh import Mesh

    data = part.data
    if isinstance(data, Mesh):
        if element == "face":
            rows = np.unique(data.faces[rows])
        return np.asarray(data.vertices[rows], np.float64)
    return np.asarray(data.points[rows], np.float64)


FIND_FACETS = Job(
    "find_facets", Lane.PRODUCTS, FacetsRequest, FacetsResult, _find_facets, MEMORY_ADVICE
)

JOBS = (COMPUTE_FIELDS, MAP_MEASURABLE, FIND_FACETS)
