"""The map of how well a plane could be measured on an outcrop: its figures, fields and raster."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.core.findings import Finding, Message
from vomstudio.core.results import HIDDEN
from vomstudio.errors import GeometryError
from vomstudio.extraction.measurable import (
    CLASSES,
    USUAL_RESOLUTIONS,
    Measurable,
    measurable,
    usual_resolution,
)
from vomstudio.extraction.measurable_options import MeasurableOptions
from vomstudio.geology.notation import plain_azimuth
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.progress import Progress
from vomstudio.reprs import Shown
from vomstudio.version import __version__

Array = npt.NDArray[np.float64]

FIELDS = ("expected_error95_deg", "trace_error95_deg", "patch_error95_deg", "measurable")
"""Of the points of the model; the last is the row in CLASSES."""
RASTER_ENDINGS = (".tif", ".tiff")
_MOST_CELLS = 25_000_000
_PATCHES = 10


@dataclass(frozen=True, eq=False, repr=False)
class MeasurableMap(Shown):
    """How well a plane could be measured on a model.

    plane : its dip direction and dip, deg; length_m : of a trace; resolution_m : of the model
        (median over its area); noise_m : of a trace's vertices; registration_error_deg : 95 %
    element : "face" or "point", of which there are `elements`
    area_m2 : of the model; shares : of it, by class: good (5 degrees or less), doubtful, poor (over
        15 degrees), none; trace_shares : by traces alone
    exposed_share : of the area, within angle_deg of the plane; patches : the largest ones of that,
        each with x, y, z, area_m2, error95_deg
    median_deg, tenth_deg : of the expected 95 % errors over the area
    best : place, x, y, z, with the least error of a trace, its error95_deg, extent_m, relief_m
    """

    plane: dict[str, float]
    length_m: float
    resolution_m: float
    noise_m: float
    registration_error_deg: float
    angle_deg: float
    element: str
    elements: int
    area_m2: float
    shares: dict[str, float]
    trace_shares: dict[str, float]
    exposed_share: float
    patches: list[dict[str, float | None]]
    median_deg: float
    tenth_deg: float
    best: dict[str, float] | None
    warnings: tuple[Message, ...]
    found: Measurable = field(repr=False, metadata=HIDDEN)
    values: dict[str, npt.NDArray[np.float32]] = field(repr=False, metadata=HIDDEN)

    def as_fields(self) -> dict[str, npt.NDArray[np.generic]]:
        """Of each point or vertex of the model, by the names of FIELDS; NaN where there is none."""
        return dict(self.values)


def measurable_map(
    data: Mesh | PointCloud,
    plane: Plane,
    options: MeasurableOptions,
    progress: Progress | None = None,
) -> MeasurableMap:
    """Map how well a plane could be measured on a model in World.

    Raises as `extraction.measurable.measurable`.
    """
    warnings: list[Message] = []
    length = options.length_m
    if length is None:
        own = options.resolution_m or usual_resolution(data)
        length = float(f"{USUAL_RESOLUTIONS * own:.2g}")
        warnings.append(Finding("measurable.length-assumed", times=USUAL_RESOLUTIONS))
    found = measurable(data, plane.normal(), replace(options, length_m=length), progress)
    area = found.areas
    total = float(area.sum())
    if not total > 0.0:
        raise GeometryError(Finding("model.no-surface"))

    def shares(classes: npt.NDArray[np.int8]) -> dict[str, float]:
        own = np.bincount(classes, area, len(CLASSES)) / total
        return {name: float(own[i]) for i, name in reversed(list(enumerate(CLASSES)))}

    best = found.best_deg
    order = np.argsort(best)
    passed = np.cumsum(area[order]) / total
    tenth, median = (float(best[order[np.searchsorted(passed, q)]]) for q in (0.1, 0.5))
    return MeasurableMap(
        {"dip_direction_deg": plane.dip_direction_deg, "dip_deg": plane.dip_deg},
        length, found.resolution, found.noise, options.used_registration_error_deg,
        options.angle_deg,
        found.elements.of, len(found.elements), total, shares(found.classes),
        shares(found.trace_classes), float(area[found.patches >= 0].sum()) / total,
        _patches(found), median, tenth, _best(found), (*warnings, *found.warnings), found,
        _on_points(data, found),
    )  # fmt: skip


def share_findings(found: MeasurableMap) -> tuple[Finding, ...]:
    """Return on how much of the surface the plane could be measured."""
    shares = {f"{name}_percent": 100.0 * share for name, share in found.shares.items()}
    return (
        Finding("measurable.shares", **shares),
        Finding(
            "measurable.trace-share",
            good_percent=100.0 * found.trace_shares["good"],
            exposed_percent=100.0 * found.exposed_share,
        ),
    )


def _best(found: Measurable) -> dict[str, float] | None:
    """Where a trace would tell most."""
    error = np.where(np.isfinite(found.trace_deg), found.trace_deg, np.inf)
    row = int(np.argmin(error))
    if not error[row] < 90.0:
        return None
    x, y, z = (found.elements.places[row] + found.elements.origin).tolist()
    return {
        "x": x, "y": y, "z": z, "error95_deg": float(error[row]),
        "extent_m": float(found.extent[row]), "relief_m": float(found.relief[row]),
    }  # fmt: skip


def _patches(found: Measurable) -> list[dict[str, float | None]]:
    inside = found.patches >= 0
    own = found.patches[inside]
    areas = np.bincount(own, found.areas[inside])
    told: list[dict[str, float | None]] = []
    for number in np.argsort(-areas)[:_PATCHES]:
        rows = np.flatnonzero(found.patches == number)
        error = float(found.patch_deg[rows[0]])
        if np.isnan(error):
            continue
        places = found.elements.places[rows] + found.elements.origin
        # A place of it, not its middle, which may lie off a bent one.
        middle = places[np.argmin(np.linalg.norm(places - places.mean(axis=0), axis=1))]
        x, y, z = middle.tolist()
        told.append({"x": x, "y": y, "z": z, "area_m2": float(areas[number]), "error95_deg": error})
    return told


def _on_points(data: Mesh | PointCloud, found: Measurable) -> dict[str, npt.NDArray[np.float32]]:
    """Means of the faces around each vertex of a mesh, by area; of a cloud its own."""
    rows = found.elements.rows
    each = (found.best_deg, found.trace_deg, found.patch_deg)
    values: dict[str, npt.NDArray[np.float32]] = {}
    if found.elements.of == "face" and isinstance(data, Mesh):
        nodes = found.nodes
        corners = np.asarray(data.faces[rows], np.int64).ravel()
        corners = corners if nodes is None else nodes[corners]
        count = len(data.vertices) if nodes is None else int(nodes.max()) + 1
        weights = np.repeat(found.areas, 3)
        for name, error in zip(FIELDS, each, strict=False):
            own = np.repeat(error, 3)
            known = np.isfinite(own)
            total = np.bincount(corners[known], weights[known], count)
            sums = np.bincount(corners[known], (weights * np.nan_to_num(own))[known], count)
            with np.errstate(invalid="ignore", divide="ignore"):
                values[name] = (sums / total).astype(np.float32)
        votes = np.stack(
            [
                np.bincount(corners, weights * (np.repeat(found.classes, 3) == k), count)
                for k in range(len(CLASSES))
            ]
        )
        mark = votes.argmax(axis=0).astype(np.float32)
        mark[votes.sum(axis=0) == 0.0] = np.nan
        values[FIELDS[3]] = mark
        if nodes is not None:
            values = {name: value[nodes] for name, value in values.items()}
        return values
    points = data.vertices if isinstance(data, Mesh) else data.points
    row_of = found.elements.row_of
    known = row_of >= 0
    for name, value in zip(FIELDS, (*each, found.classes), strict=True):
        at_points = np.full(len(points), np.nan, np.float32)
        at_points[known] = np.asarray(value, np.float32)[row_of[known]]
        values[name] = at_points
    return values


def write_raster(
    path: str | Path,
    data: Mesh | PointCloud,
    found: MeasurableMap,
    *,
    crs: str | None,
    cell_m: float | None = None,
    force: bool = False,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """GeoTIFF of the expected 95 % error, degrees, NaN where nothing is seen, over the outcrop's
    best plane, seen against its upward normal; what it is. Raises UsageError, TargetError."""
    from scipy.spatial import cKDTree

    from vomstudio.errors import UsageError
    from vomstudio.files.atomic import atomic_group
    from vomstudio.geometry.planes import fit_plane
    from vomstudio.io.gis.raster import Raster, open_geotiff, view_plane_crs, write_tile
    from vomstudio.products.elevation.heights import draw_heights
    from vomstudio.products.elevation.planning import plan_heights
    from vomstudio.products.ortho.tiles import TILE

    elements = found.found.elements
    places = elements.places + elements.origin
    view = Plane.from_normal(fit_plane(places[:: max(1, len(places) // 20_000)]).normal)
    cell = cell_m or max(found.length_m / 40.0, found.resolution_m)
    plan = plan_heights(data, view, to_world=np.eye(4), gsd=cell)
    if plan.grid.width * plan.grid.height > _MOST_CELLS:
        count = plan.grid.width * plan.grid.height
        raise UsageError(
            Finding("raster.too-many-cells", count=count, maximum=_MOST_CELLS), field="--gsd"
        )
    heights, _ = draw_heights(data, plan, None, progress)
    rows, columns = np.nonzero(np.isfinite(heights))
    cells = np.stack([columns + 0.5, rows + 0.5, heights[rows, columns], np.ones(len(rows))])
    seen = (plan.cell_to_world @ cells)[:3].T - elements.origin
    values = np.full((plan.grid.height, plan.grid.width), np.nan, np.float32)
    values[rows, columns] = found.found.best_deg[cKDTree(elements.places).query(seen)[1]]
    raster = Raster(
        plan.grid.width, plan.grid.height, "float", plan.transform,
        crs if plan.is_map else view_plane_crs(True),
        {
            "VOMSTUDIO_VERSION": __version__,
            "VOMSTUDIO_PLANE": "dip direction "
            f"{plain_azimuth(found.plane['dip_direction_deg'])} dip "
            f"{found.plane['dip_deg']:.4f} deg; expected 95 % error in degrees, 90 for none",
            "VOMSTUDIO_VIEW": f"against the upward normal of the plane with dip direction "
            f"{plain_azimuth(view.dip_direction_deg)} dip {view.dip_deg:.4f} deg",
        },
    )  # fmt: skip
    with atomic_group([Path(path)], force) as parts, open_geotiff(parts[0], raster, path) as out:
        for row in range(0, values.shape[0], TILE):
            for column in range(0, values.shape[1], TILE):
                write_tile(out, column, row, values[row : row + TILE, column : column + TILE])
    return {"width": plan.grid.width, "height": plan.grid.height, "gsd_m": float(cell)}
