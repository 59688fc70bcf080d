"""Jobs on the surface of one model: its fields and its facets."""

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
from vomstudio.studio.jobs.placed_model import StandingModel, in_world

if TYPE_CHECKING:
    from vomstudio.core.arrays import FloatArray, GenericArray
    from vomstudio.extraction.facets import Facets
    from vomstudio.extraction.local_parts import Part

    Arrays = dict[str, GenericArray]

_PART = to_translate("Use a smaller part of the model, or close other programs.")


@dataclass(frozen=True)
class FieldsOrder:
    """key : names the model as it stands, so that what `out` holds already need not be made again;
    out : the file for the fields"""

    model: StandingModel
    radius_m: float
    key: str
    out: Path


@dataclass(frozen=True)
class ComputedFields:
    """out : float32 arrays of all points of the model, by the keys of
    `extraction.surface_fields.KINDS`; typical_count : points within the radius"""

    out: Path
    typical_count: int
    warnings: tuple[Finding, ...]


def _compute(asked: FieldsOrder, progress: Progress) -> ComputedFields:
    import numpy as np

    from vomstudio.extraction.surface_fields import KINDS, surface_fields

    mark = f"{asked.key} {asked.radius_m!r}"
    kept = _kept(asked.out, mark)
    if kept is not None:
        return kept
    found = surface_fields(in_world(asked.model, progress), asked.radius_m, progress)
    arrays: dict[str, Any] = {key: found.values[key] for key in KINDS}
    arrays |= {
        "mark": np.array(mark),
        "count": np.array(found.typical_count),
        "warnings": np.array(json.dumps([each.to_dict() for each in found.warnings])),
    }
    asked.out.parent.mkdir(parents=True, exist_ok=True)
    part = asked.out.with_name(f"{asked.out.stem}.part.npz")
    np.savez(part, **arrays)
    os.replace(part, asked.out)
    return ComputedFields(asked.out, found.typical_count, found.warnings)


def _kept(out: Path, mark: str) -> ComputedFields | None:
    """What was made of this model with this radius before."""
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


COMPUTE_FIELDS = Job("compute_fields", Lane.PRODUCTS, FieldsOrder, ComputedFields, _compute, _PART)


@dataclass(frozen=True)
class MeasurableOrder:
    """Request for a map of where a plane can be measured.

    normal : normal of the plane, World; out : file of the fields, float32 for all points, with the
    names of `products.surface.measurable_map.FIELDS`
    """

    model: StandingModel
    normal: tuple[float, float, float]
    options: MeasurableOptions
    out: Path


@dataclass(frozen=True)
class MappedMeasurable:
    """findings : about the measurable shares of the surface"""

    out: Path
    findings: tuple[Finding, ...]


def _map_measurable(request: MeasurableOrder, progress: Progress) -> MappedMeasurable:
    import numpy as np

    from vomstudio.geology.orientation import Plane
    from vomstudio.products.surface.measurable_map import measurable_map, share_findings

    fields = measurable_map(
        in_world(request.model, progress),
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
    "map_measurable", Lane.PRODUCTS, MeasurableOrder, MappedMeasurable, _map_measurable, _PART
)


@dataclass(frozen=True)
class Sight:
    """From where to where somebody looks, World; `points` of the surface there are looked at."""

    eye: tuple[float, float, float]
    toward: tuple[float, float, float]
    points: int


@dataclass(frozen=True)
class FacetsOrder:
    """part : None for all of the model; out : the file for the facets"""

    model: StandingModel
    options: FacetOptions
    part: Sight | None
    out: Path


@dataclass(frozen=True)
class FoundFacets:
    """out : the arrays of `_facet_arrays`; element : of what facets are made; reach_m : the
    distance that was allowed (median); the shares are those of `extraction.exposure.Exposure`"""

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


def _find(asked: FacetsOrder, progress: Progress) -> FoundFacets:
    import numpy as np

    from vomstudio.extraction.facets import find_facets
    from vomstudio.extraction.local_parts import Part, part_in_view
    from vomstudio.geometry.mesh import Mesh

    data = in_world(asked.model, progress)
    mesh = isinstance(data, Mesh)
    count = len(data.vertices) if isinstance(data, Mesh) else len(data.points)
    part = Part(data, np.arange(count), np.arange(len(data.faces) if mesh else 0))  # type: ignore[union-attr]
    if asked.part is not None:
        part = part_in_view(data, asked.part.eye, asked.part.toward, asked.part.points)
    found = find_facets(part.data, asked.options, progress=progress)
    asked.out.parent.mkdir(parents=True, exist_ok=True)
    arrays: dict[str, Any] = _facet_arrays(found, part, count, asked.model.to_world)
    np.savez(asked.out, **arrays)
    seen = found.exposure
    return FoundFacets(
        len(found.facets),
        found.of,
        found.reach,
        found.min_points,
        seen.near_planar_share,
        seen.coverage,
        seen.exposed_m2,
        seen.vegetation_share,
        seen.debris_share,
        found.warnings,
        asked.out,
    )


def _facet_arrays(found: Facets, part: Part, count: int, to_world: Any) -> Arrays:
    """label, covers : (points,) int32 of all of the model, -1 for none. Of each of f facets, in the
    frame of the file: n, n_effective, mean (f, 3), scatter (f, 3, 3), area, resolution, level_gap
    and bend_deg, 0 for none, bent; its faces or points rows[row_cuts[i]:row_cuts[i + 1]], its
    outline in the same way; exposed_m2 : in World.
    """
    import numpy as np

    from vomstudio.geometry import transform
    from vomstudio.geometry.patches import outline

    back = transform.invert(transform.matrix(to_world))
    turn, scale = back[:3, :3], transform.scale_of(to_world)
    of_elements = part.points if found.of == "point" else part.faces
    label, covers = np.full((2, count), -1, np.int32)
    label[part.points], covers[part.points] = found.labels, found.covers
    facets, rings = found.facets, []
    for facet in facets:
        ring = outline(_corners(part, found.of, facet.rows), facet.fit.normal)
        rings.append(transform.apply(back, np.array(ring).reshape(-1, 3)))
    rows = [np.sort(of_elements[facet.rows]) for facet in facets]
    known = [facet.moments for facet in facets]
    mean = np.array([m.mean for m in known]).reshape(-1, 3)
    scatter = np.array([m.scatter for m in known]).reshape(-1, 3, 3)
    return {
        "label": label,
        "covers": covers,
        "n": np.array([m.n for m in known], np.int64),
        "n_effective": np.array([m.n_effective for m in known]),
        "mean": transform.apply(back, mean),
        "scatter": turn @ scatter @ turn.T,
        "area": np.array([facet.area for facet in facets]) / scale**2,
        "resolution": np.array([facet.resolution for facet in facets]) / scale,
        "bent": np.array([facet.bent for facet in facets], np.bool_),
        "level_gap": np.array([facet.level_gap or 0.0 for facet in facets]) / scale,
        "bend_deg": np.array([facet.bend_deg or 0.0 for facet in facets]),
        "exposed_m2": found.exposure.by_facet_m2,
        "rows": np.concatenate([*rows, np.zeros(0, np.int64)]),
        "row_cuts": np.cumsum([0, *map(len, rows)]),
        "outline": np.concatenate([*rings, np.zeros((0, 3))]),
        "outline_cuts": np.cumsum([0, *map(len, rings)]),
    }


def _corners(part: Part, element: str, rows: Any) -> FloatArray:
    """(k, 3) points of some faces or points, each once."""
    import numpy as np

    from vomstudio.geometry.mesh import Mesh

    data = part.data
    if isinstance(data, Mesh):
        if element == "face":
            rows = np.unique(data.faces[rows])
        return np.asarray(data.vertices[rows], np.float64)
    return np.asarray(data.points[rows], np.float64)


FIND_FACETS = Job("find_facets", Lane.PRODUCTS, FacetsOrder, FoundFacets, _find, _PART)

JOBS = (COMPUTE_FIELDS, MAP_MEASURABLE, FIND_FACETS)
