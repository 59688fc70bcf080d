"""Fields on the surface of a model: attitude, curvature, roughness and planarity.

All fields are computed from the points within a radius, so that they describe the rock at the
selected scale rather than the triangles of the model. Dense points are thinned to a maximum number
per cell, so that an area does not have more weight because it was scanned from nearby.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, Float32Array, FloatArray
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.coincident_points import weld_points
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.nearby.point_grid import LocalPlanes, PointGrid
from vomstudio.geometry.patches import face_areas
from vomstudio.registration.surface_points import points_of, surface_points

_MIN_RADIUS_SPACINGS = 6.0
"""Minimum radius relative to the maximum spacing of points on large faces."""
_RADIUS_CELLS, _MAX_CELL_POINTS = 2.0, 24
"""Radius in cell sizes, and maximum number of points per cell: about 300 points per sphere."""
_MAX_POINTS = 3_000_000
_MIN_POINTS = 6
"""Minimum number of points within the radius for fitting a plane."""
_MAX_SPARSE_SHARE = 0.02
_MAX_LINE_RATIO = 1e-10
"""Maximum ratio of the second to the first eigenvalue for points on a line, due to rounding."""


@dataclass(frozen=True)
class FieldKind:
    """Kind of surface field.

    Parameters
    ----------
    title : str
        Title, marked for translation.
    name : str
        Name of the field, without the radius.
    unit : str
        Unit of the values.
    description : str
        Description, marked for translation.
    """

    title: str
    name: str
    unit: str
    description: str


KINDS: dict[str, FieldKind] = {
    "dip": FieldKind(
        to_translate("Dip"),
        "dip",
        "°",
        to_translate("Dip of the plane fitted within the radius, 0 to 90°."),
    ),
    "dip_direction": FieldKind(
        to_translate("Dip direction"),
        "dip direction",
        "°",
        to_translate("Dip direction of the fitted plane; grey if horizontal within 1°."),
    ),
    "steepness": FieldKind(
        to_translate("Steepness, with overhangs"),
        "steepness",
        "°",
        to_translate("Angle between up and the outward normal; over 90° on overhangs."),
    ),
    "curvature": FieldKind(
        to_translate("Curvature"),
        "curvature",
        "1/m",
        to_translate("Mean curvature within the radius: positive on edges, negative in notches."),
    ),
    "roughness": FieldKind(
        to_translate("Roughness"),
        "roughness",
        "m",
        to_translate("Standard deviation of distances from the plane fitted within the radius."),
    ),
    "coplanarity": FieldKind(
        to_translate("Coplanarity M"),
        "coplanarity M",
        "",
        to_translate("M = ln(λ1/λ3): larger is more planar, above 4 recommended."),
    ),
    "collinearity": FieldKind(
        to_translate("Collinearity K"),
        "collinearity K",
        "",
        to_translate("K = ln(λ1/λ2)/ln(λ2/λ3): larger is more linear, below 0.8 recommended."),
    ),
}
"""Kinds of fields by the name stored in projects, in display order."""

_MAX_LEVEL_DIP_DEG = 1.0


def field_name(kind: str, radius_m: float, *, is_metric: bool = True) -> str:
    """Return the name of a field including its radius and unit.

    Parameters
    ----------
    kind : str
    radius_m : float
    is_metric : bool, optional
        Whether the scale of the model in metres is known.

    Returns
    -------
    str
    """
    field_kind, length = KINDS[kind], "m" if is_metric else "units"
    unit = f" [{field_kind.unit.replace('m', length)}]" if field_kind.unit else ""
    return f"{field_kind.name}, r {radius_m:g} {length}{unit}"


@dataclass(frozen=True, eq=False)
class SurfaceFields:
    """Fields computed for a model.

    Parameters
    ----------
    radius_m : float
    values : mapping of str to (n,) float32 array
        Values by key of `KINDS` for each point or vertex of the model; NaN if unknown.
    typical_count : int
        Median number of points within the radius.
    warnings : tuple of Finding
    """

    radius_m: float
    values: Mapping[str, Float32Array]
    typical_count: int
    warnings: tuple[Finding, ...]


def surface_fields(
    data: Mesh | PointCloud, radius_m: float, progress: Progress | None = None
) -> SurfaceFields:
    """Compute the surface fields of a model.

    Parameters
    ----------
    data : Mesh or PointCloud
        Model in the World frame, m.
    radius_m : float
    progress : Progress, optional

    Returns
    -------
    SurfaceFields

    Raises
    ------
    UsageError
        If the radius is not a positive length.
    GeometryError
        If no point has enough neighbours within the radius for a plane, or if the radius is too
        small for the faces of a mesh.
    Cancelled
        Through `progress`.
    """
    if not 0.0 < radius_m < np.inf:
        raise UsageError(Finding("number.not-a-length", text=str(radius_m)), field="radius")
    progress = progress or SilentProgress()
    progress.stage(tr("Preparing surface points"), None)
    positions = np.asarray(points_of(data), np.float64)
    radius_warnings = _check_radius(data, radius_m)
    points = surface_points(data, radius_m / _MIN_RADIUS_SPACINGS)[0]
    support_points = _thin_points(points, radius_m / _RADIUS_CELLS)
    grid = PointGrid(support_points, radius_m)
    progress.stage(tr("Fitting planes within the radius"), len(positions))
    planes = grid.planes(positions, radius_m, progress)
    has_plane = planes.count >= _MIN_POINTS
    is_line = has_plane & ~(planes.spread[:, 1] > _MAX_LINE_RATIO * planes.spread[:, 2])
    if has_plane.any() and (is_line == has_plane).all():
        raise GeometryError(Finding("fields.points-in-line", radius_m=radius_m))
    has_plane &= ~is_line
    if not has_plane.any():
        raise GeometryError(Finding("fields.too-few-points", radius_m=radius_m))
    normals, warnings = _orient_outward(data, planes.normal)
    warnings = (*radius_warnings, *warnings)
    normals[~has_plane] = np.nan
    progress.stage(tr("Computing curvature"), len(positions))
    curvature = grid.curvatures(positions, normals, radius_m, progress)
    values = {**_compute_attitudes(normals), "curvature": curvature, **_compute_shapes(planes)}
    sparse_share = float(1.0 - has_plane.mean())
    if sparse_share > _MAX_SPARSE_SHARE:
        warnings = (
            *warnings,
            Finding("fields.few-points", share_percent=100.0 * sparse_share, minimum=_MIN_POINTS),
        )
    return SurfaceFields(
        radius_m,
        {key: _mask_values(values[key], has_plane) for key in KINDS},
        int(np.median(planes.count[has_plane])),
        warnings,
    )


def _check_radius(data: Mesh | PointCloud, radius_m: float) -> tuple[Finding, ...]:
    """Compare the radius with the face size of a mesh and return warnings.

    Raises
    ------
    GeometryError
        If the faces would require too many points.
    """
    if not isinstance(data, Mesh) or not len(data.faces):
        return ()
    areas = face_areas(data, np.arange(len(data.faces)))
    areas = areas[np.isfinite(areas)]
    max_points = max(_MAX_POINTS, 3 * len(data.vertices))
    min_radius_m = _MIN_RADIUS_SPACINGS * float(np.sqrt(areas.sum() / max_points))
    if radius_m < min_radius_m:
        raise GeometryError(Finding("fields.radius-below-faces", minimum_m=min_radius_m))
    typical_edge = float(np.sqrt(2.0 * np.median(areas))) if len(areas) else 0.0
    if radius_m < 2.0 * typical_edge:
        return (Finding("fields.single-faces"),)
    return ()


def _mask_values(values: FloatArray, has_plane: BoolArray) -> Float32Array:
    return np.where(has_plane, values, np.nan).astype(np.float32)


def _compute_attitudes(normals: FloatArray) -> dict[str, FloatArray]:
    """Compute attitudes from unit normals (n, 3) that point out of the rock."""
    x, y, z = normals.T
    up = np.where(z < 0.0, -1.0, 1.0)
    dip = np.degrees(np.arccos(np.clip(np.abs(z), 0.0, 1.0)))
    direction = np.degrees(np.arctan2(up * x, up * y)) % 360.0
    return {
        "dip": dip,
        "dip_direction": np.where(dip < _MAX_LEVEL_DIP_DEG, np.nan, direction),
        "steepness": np.degrees(np.arccos(np.clip(z, -1.0, 1.0))),
    }


def _compute_shapes(planes: LocalPlanes) -> dict[str, FloatArray]:
    smallest_eigenvalue, middle_eigenvalue, largest_eigenvalue = planes.spread.T
    # The third eigenvalue of a perfect plane consists of rounding errors.
    smallest_eigenvalue = np.maximum(smallest_eigenvalue, 1e-12 * largest_eigenvalue)
    with np.errstate(divide="ignore", invalid="ignore"):
        return {
            "roughness": np.sqrt(np.maximum(planes.spread[:, 0], 0.0)),
            "coplanarity": np.log(largest_eigenvalue / smallest_eigenvalue),
            "collinearity": np.log(largest_eigenvalue / middle_eigenvalue)
            / np.log(middle_eigenvalue / smallest_eigenvalue),
        }


def _thin_points(points: FloatArray, cell_size: float) -> FloatArray:
    """Randomly thin points to at most `_MAX_CELL_POINTS` per cell.

    Points are not averaged, because means would be smoother than the rock. Selecting one point in
    each of many small cells would give outliers more weight.
    """
    if not len(points):
        return points
    positions = np.floor((points - points.min(axis=0)) / cell_size).astype(np.int64)
    size = positions.max(axis=0) + 1
    key = (positions[:, 0] * size[1] + positions[:, 1]) * size[2] + positions[:, 2]
    random_order = np.random.default_rng(0).permutation(len(key))
    order = random_order[np.argsort(key[random_order], kind="stable")]
    is_first = np.concatenate([[True], np.diff(key[order]) != 0])
    first = np.maximum.accumulate(np.where(is_first, np.arange(len(order)), 0))
    return points[np.sort(order[np.arange(len(order)) - first < _MAX_CELL_POINTS])]


def _orient_outward(
    data: Mesh | PointCloud, normals: FloatArray
) -> tuple[FloatArray, tuple[Finding, ...]]:
    """Orient normals out of the rock, using the faces of a mesh or the normals of a cloud.

    If neither is available, the normals are oriented upward, and a warning is returned.
    """
    if isinstance(data, Mesh) and len(data.faces):
        reference_normals: FloatArray | None = _vertex_normals(data)
    elif isinstance(data, PointCloud) and data.normals is not None:
        reference_normals = np.asarray(data.normals, np.float64)
    else:
        reference_normals = None
    if reference_normals is None:
        up = np.broadcast_to([0.0, 0.0, 1.0], normals.shape)
        warning = Finding("fields.outside-unknown")
        return _orient_normals(normals, up), (warning,)
    return _orient_normals(normals, reference_normals), ()


def _orient_normals(normals: FloatArray, reference_normals: FloatArray) -> FloatArray:
    cosine = np.einsum("ij,ij->i", normals, np.nan_to_num(reference_normals))
    return normals * np.where(cosine < 0.0, -1.0, 1.0)[:, None]


def _vertex_normals(mesh: Mesh) -> FloatArray:
    """Sum the area-weighted normals of the faces around each vertex (n, 3).

    Vertices at the same position are treated as one, so that texture seams have no effect.
    """
    vertices = np.asarray(mesh.vertices, np.float64)
    corners = [vertices[mesh.faces[:, k]] for k in range(3)]
    cross_products = np.nan_to_num(np.cross(corners[1] - corners[0], corners[2] - corners[0]))
    node_indices = weld_points(vertices)
    nodes = node_indices[mesh.faces]
    count = int(node_indices.max(initial=-1)) + 1
    normals = np.empty((count, 3))
    for axis in range(3):
        normals[:, axis] = sum(
            np.bincount(nodes[:, k], cross_products[:, axis], count) for k in range(3)
        )
    return np.asarray(normals[node_indices])
