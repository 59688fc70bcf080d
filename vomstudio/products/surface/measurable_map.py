"""Map that shows how well a plane can be measured on an outcrop: figures, fields, raster."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import Float32Array, GenericArray, Int8Array
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.results import HIDDEN_IN_JSON
from vomstudio.core.version import __version__
from vomstudio.extraction.measurable import (
    DEFAULT_LENGTH_RESOLUTIONS,
    QUALITY_CLASSES,
    Measurable,
    map_measurability,
    typical_resolution,
)
from vomstudio.extraction.measurable_options import MeasurableOptions
from vomstudio.geology.notation import format_plain_azimuth
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh

FIELDS = ("expected_error95_deg", "trace_error95_deg", "patch_error95_deg", "measurable")
"""Names of the point fields; the last one is an index into `QUALITY_CLASSES`."""
RASTER_SUFFIXES = (".tif", ".tiff")
_MAX_CELLS = 25_000_000
_MAX_PATCHES = 10


@dataclass(frozen=True, eq=False, repr=False)
class MeasurableMap(PrintableResult):
    """Expected errors of a plane measured on a model.

    Parameters
    ----------
    plane : dict
        Dip direction and dip, degrees.
    length_m : float
        Length of a trace.
    resolution_m : float
        Median resolution of the model over its area.
    noise_m : float
        Noise of the vertices of a trace.
    registration_error_deg : float
        95 % error of the registration.
    angle_deg : float
        Maximum angle between the plane and surface parts that count as exposures of it.
    element : {"face", "point"}
    elements : int
        Number of faces or points.
    area_m2 : float
        Area of the model.
    shares, trace_shares : dict
        Shares of the area by class, for the better of patch and trace, and for traces alone. The
        classes are good (up to 5 degrees), doubtful, poor (over 15 degrees) and none.
    exposed_share : float
        Share of the area whose orientation is within `angle_deg` of the plane.
    patches : list of dict
        Largest exposed parts, with x, y, z, area_m2 and error95_deg.
    median_deg, tenth_deg : float
        Median and tenth percentile of the expected 95 % errors over the area.
    best : dict or None
        Position at which a trace has the smallest error, with x, y, z, error95_deg, extent_m and
        relief_m.
    warnings : tuple of Finding
    measurable : Measurable
        Errors of the elements.
    values : dict
        Fields at the points or vertices of the model.
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
    warnings: tuple[Finding, ...]
    measurable: Measurable = field(repr=False, metadata=HIDDEN_IN_JSON)
    values: dict[str, Float32Array] = field(repr=False, metadata=HIDDEN_IN_JSON)

    def as_fields(self) -> dict[str, GenericArray]:
        """Return the values at each point or vertex, keyed by FIELDS; NaN if unknown."""
        return dict(self.values)


def measurable_map(
    data: Mesh | PointCloud,
    plane: Plane,
    options: MeasurableOptions,
    progress: Progress | None = None,
) -> MeasurableMap:
    """Map how well a plane could be measured on a model in the World frame.

    Parameters
    ----------
    data : Mesh or PointCloud
        Model in the World frame, m.
    plane : Plane
    options : MeasurableOptions
    progress : Progress, optional

    Returns
    -------
    MeasurableMap

    Raises
    ------
    GeometryError, Cancelled
        As in `extraction.measurable.map_measurability`.
    """
    warnings: list[Finding] = []
    length = options.length_m
    if length is None:
        resolution = options.resolution_m or typical_resolution(data)
        length = float(f"{DEFAULT_LENGTH_RESOLUTIONS * resolution:.2g}")
        warnings.append(Finding("measurable.length-assumed", times=DEFAULT_LENGTH_RESOLUTIONS))
    measurability = map_measurability(
        data, plane.normal(), replace(options, length_m=length), progress
    )
    area = measurability.areas
    total_area = float(area.sum())
    if not total_area > 0.0:
        raise GeometryError(Finding("model.no-surface"))

    def shares(classes: Int8Array) -> dict[str, float]:
        sums = np.bincount(classes, area, len(QUALITY_CLASSES)) / total_area
        return {name: float(sums[i]) for i, name in reversed(list(enumerate(QUALITY_CLASSES)))}

    best_error = measurability.best_deg
    order = np.argsort(best_error)
    cumulative_share = np.cumsum(area[order]) / total_area
    first_decile, median = (
        float(best_error[order[np.searchsorted(cumulative_share, q)]]) for q in (0.1, 0.5)
    )
    return MeasurableMap(
        plane={"dip_direction_deg": plane.dip_direction_deg, "dip_deg": plane.dip_deg},
        length_m=length,
        resolution_m=measurability.resolution,
        noise_m=measurability.noise,
        registration_error_deg=options.used_registration_error_deg,
        angle_deg=options.angle_deg,
        element=measurability.elements.kind,
        elements=len(measurability.elements),
        area_m2=total_area,
        shares=shares(measurability.classes),
        trace_shares=shares(measurability.trace_classes),
        exposed_share=float(area[measurability.patches >= 0].sum()) / total_area,
        patches=_patches(measurability),
        median_deg=median,
        tenth_deg=first_decile,
        best=_find_best_position(measurability),
        warnings=(*warnings, *measurability.warnings),
        measurable=measurability,
        values=_point_values(data, measurability),
    )


def share_findings(measurability: MeasurableMap) -> tuple[Finding, ...]:
    """Report the shares of the surface on which the plane could be measured."""
    fractions = {f"{name}_percent": 100.0 * share for name, share in measurability.shares.items()}
    return (
        Finding("measurable.shares", **fractions),
        Finding(
            "measurable.trace-share",
            good_percent=100.0 * measurability.trace_shares["good"],
            exposed_percent=100.0 * measurability.exposed_share,
        ),
    )


def _find_best_position(measurability: Measurable) -> dict[str, float] | None:
    """Return the position at which a trace would have the smallest error, or None."""
    error = np.where(np.isfinite(measurability.trace_deg), measurability.trace_deg, np.inf)
    row = int(np.argmin(error))
    if not error[row] < 90.0:
        return None
    x, y, z = (measurability.elements.places[row] + measurability.elements.origin).tolist()
    return {
        "x": x,
        "y": y,
        "z": z,
        "error95_deg": float(error[row]),
        "extent_m": float(measurability.extent[row]),
        "relief_m": float(measurability.relief[row]),
    }


def _patches(measurability: Measurable) -> list[dict[str, float | None]]:
    is_inside = measurability.patches >= 0
    patch_numbers = measurability.patches[is_inside]
    areas = np.bincount(patch_numbers, measurability.areas[is_inside])
    patches: list[dict[str, float | None]] = []
    for patch_index in np.argsort(-areas)[:_MAX_PATCHES]:
        rows = np.flatnonzero(measurability.patches == patch_index)
        error = float(measurability.patch_deg[rows[0]])
        if np.isnan(error):
            continue
        positions = measurability.elements.places[rows] + measurability.elements.origin
        # Use a point of the patch, since the mean of a curved patch may lie off its surface.
        centre = positions[np.argmin(np.linalg.norm(positions - positions.mean(axis=0), axis=1))]
        x, y, z = centre.tolist()
        patches.append(
            {"x": x, "y": y, "z": z, "area_m2": float(areas[patch_index]), "error95_deg": error}
        )
    return patches


def _point_values(data: Mesh | PointCloud, measurability: Measurable) -> dict[str, Float32Array]:
    """Return the values at cloud points, or area-weighted means at mesh vertices."""
    rows = measurability.elements.rows
    errors = (measurability.best_deg, measurability.trace_deg, measurability.patch_deg)
    values: dict[str, Float32Array] = {}
    if measurability.elements.kind == "face" and isinstance(data, Mesh):
        nodes = measurability.nodes
        corners = np.asarray(data.faces[rows], np.int64).ravel()
        corners = corners if nodes is None else nodes[corners]
        count = len(data.vertices) if nodes is None else int(nodes.max()) + 1
        weights = np.repeat(measurability.areas, 3)
        for name, error in zip(FIELDS, errors, strict=False):
            corner_errors = np.repeat(error, 3)
            is_known = np.isfinite(corner_errors)
            weight_sums = np.bincount(corners[is_known], weights[is_known], count)
            sums = np.bincount(
                corners[is_known], (weights * np.nan_to_num(corner_errors))[is_known], count
            )
            with np.errstate(invalid="ignore", divide="ignore"):
                values[name] = (sums / weight_sums).astype(np.float32)
        votes = np.stack(
            [
                np.bincount(corners, weights * (np.repeat(measurability.classes, 3) == k), count)
                for k in range(len(QUALITY_CLASSES))
            ]
        )
        class_index = votes.argmax(axis=0).astype(np.float32)
        class_index[votes.sum(axis=0) == 0.0] = np.nan
        values[FIELDS[3]] = class_index
        if nodes is not None:
            values = {name: value[nodes] for name, value in values.items()}
        return values
    points = data.vertices if isinstance(data, Mesh) else data.points
    inverse_rows = measurability.elements.inverse_rows
    is_known = inverse_rows >= 0
    for name, value in zip(FIELDS, (*errors, measurability.classes), strict=True):
        values_by_point = np.full(len(points), np.nan, np.float32)
        values_by_point[is_known] = np.asarray(value, np.float32)[inverse_rows[is_known]]
        values[name] = values_by_point
    return values


def write_raster(
    path: str | Path,
    data: Mesh | PointCloud,
    measurable: MeasurableMap,
    *,
    crs: str | None,
    cell_m: float | None = None,
    force: bool = False,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Write a GeoTIFF of the expected 95 % error in degrees, over the best-fit plane.

    The raster is viewed against the upward normal of this plane. Cells without a surface are NaN.

    Returns
    -------
    dict
        Properties width, height and gsd_m of the raster.

    Raises
    ------
    UsageError, TargetError
    """
    from scipy.spatial import cKDTree

    from vomstudio.core.errors import UsageError
    from vomstudio.core.files.atomic import atomic_group
    from vomstudio.geometry.planes import fit_plane
    from vomstudio.io.gis.raster import Raster, open_geotiff, view_plane_crs, write_tile
    from vomstudio.products.elevation.heights import compute_heights
    from vomstudio.products.elevation.planning import plan_heights
    from vomstudio.products.ortho.tiles import TILE

    elements = measurable.measurable.elements
    positions = elements.places + elements.origin
    view = Plane.from_normal(fit_plane(positions[:: max(1, len(positions) // 20_000)]).normal)
    cell = cell_m or max(measurable.length_m / 40.0, measurable.resolution_m)
    plan = plan_heights(data, view, to_world=np.eye(4), gsd=cell)
    if plan.grid.width * plan.grid.height > _MAX_CELLS:
        count = plan.grid.width * plan.grid.height
        raise UsageError(
            Finding("raster.too-many-cells", count=count, maximum=_MAX_CELLS), field="--gsd"
        )
    heights, _ = compute_heights(data, plan, None, progress)
    rows, columns = np.nonzero(np.isfinite(heights))
    cells = np.stack([columns + 0.5, rows + 0.5, heights[rows, columns], np.ones(len(rows))])
    cell_points = (plan.cell_to_world @ cells)[:3].T - elements.origin
    values = np.full((plan.grid.height, plan.grid.width), np.nan, np.float32)
    values[rows, columns] = measurable.measurable.best_deg[
        cKDTree(elements.places).query(cell_points)[1]
    ]
    raster = Raster(
        plan.grid.width,
        plan.grid.height,
        "float",
        plan.transform,
        crs if plan.is_map else view_plane_crs(True),
        {
            "VOMSTUDIO_VERSION": __version__,
            "VOMSTUDIO_PLANE": "dip direction "
            f"{format_plain_azimuth(measurable.plane['dip_direction_deg'])} dip "
            f"{measurable.plane['dip_deg']:.4f} deg; expected 95 % error in degrees, 90 for none",
            "VOMSTUDIO_VIEW": f"against the upward normal of the plane with dip direction "
            f"{format_plain_azimuth(view.dip_direction_deg)} dip {view.dip_deg:.4f} deg",
        },
    )
    with (
        atomic_group([Path(path)], force) as temporary_paths,
        open_geotiff(temporary_paths[0], raster, path) as out,
    ):
        for row in range(0, values.shape[0], TILE):
            for column in range(0, values.shape[1], TILE):
                write_tile(out, column, row, values[row : row + TILE, column : column + TILE])
    return {"width": plan.grid.width, "height": plan.grid.height, "gsd_m": float(cell)}
