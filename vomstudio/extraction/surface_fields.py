"""Fields of a model's surface: how it dips and faces, bends, how rough and how planar it is.

All are of the points within a radius, so that they are of the rock on the scale that is looked at,
and not of the model's triangles. Where points lie closely some of each cell stand for all: no place
counts more because it was seen from nearby.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, Float32Array, FloatArray
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, Silent
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.coincident_points import welded
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.nearby.point_grid import LocalPlanes, PointGrid
from vomstudio.geometry.patches import face_areas
from vomstudio.registration.surface_points import points_of, surface_points

_SPACINGS = 6.0
"""Of the radius, the farthest that points of large faces may be apart."""
_CELLS, _IN_CELL = 2.0, 24
"""Of the radius, the side of a cell, and how many of its points count: some 300 in the ball."""
_MOST_POINTS = 3_000_000
_FEWEST = 6
"""Points within the radius, so that their plane is no chance."""
_SPARSE_SHARE = 0.02
_THIN = 1e-10
"""Of the second to the first eigenvalue, under which points are on a line but for rounding."""


@dataclass(frozen=True)
class FieldKind:
    """title : noted for translation; name : of the field, before the radius; unit : of its values;
    says : what it is, noted for translation"""

    title: str
    name: str
    unit: str
    says: str


KINDS: dict[str, FieldKind] = {
    "dip": FieldKind(
        to_translate("Dip"),
        "dip",
        "°",
        to_translate("Dip of the plane through the points within the radius, 0 to 90°."),
    ),
    "dip_direction": FieldKind(
        to_translate("Dip direction"),
        "dip direction",
        "°",
        to_translate("Dip direction of that plane; grey where it is level within 1°."),
    ),
    "steepness": FieldKind(
        to_translate("Steepness, with overhangs"),
        "steepness",
        "°",
        to_translate(
            "Angle between up and the normal that points out of the rock: 0° level, 90° vertical, "
            "more where the face overhangs."
        ),
    ),
    "curvature": FieldKind(
        to_translate("Curvature"),
        "curvature",
        "1/m",
        to_translate(
            "Mean curvature of the quadric through the points within the radius: positive on "
            "edges and noses, negative in notches. One over the radius of a ball that bends alike."
        ),
    ),
    "roughness": FieldKind(
        to_translate("Roughness"),
        "roughness",
        "m",
        to_translate("Standard deviation of the points within the radius from their plane."),
    ),
    "coplanarity": FieldKind(
        to_translate("Coplanarity M"),
        "coplanarity M",
        "",
        to_translate(
            "M = ln(λ1/λ3) of the points within the radius: the larger, the more planar; above 4 "
            "is wanted of a plane (Fernández 2005)."
        ),
    ),
    "collinearity": FieldKind(
        to_translate("Collinearity K"),
        "collinearity K",
        "",
        to_translate(
            "K = ln(λ1/λ2)/ln(λ2/λ3) of the points within the radius: the larger, the more they "
            "lie along a line; below 0.8 is wanted of a plane (Fernández 2005)."
        ),
    ),
}
"""By the name in which a project keeps them, in the order of lists."""

_LEVEL_DEG = 1.0


def field_name(kind: str, radius_m: float, *, metric: bool = True) -> str:
    """The name of a field among those of a model, with radius and unit. metric : its metres are
    known"""
    of, length = KINDS[kind], "m" if metric else "units"
    unit = f" [{of.unit.replace('m', length)}]" if of.unit else ""
    return f"{of.name}, r {radius_m:g} {length}{unit}"


@dataclass(frozen=True, eq=False)
class SurfaceFields:
    """values : (n,) float32 of each point or vertex of the model, by the keys of KINDS; NaN where
    there is none. typical_count : points within the radius (median)"""

    radius_m: float
    values: Mapping[str, Float32Array]
    typical_count: int
    warnings: tuple[Finding, ...]


def surface_fields(
    data: Mesh | PointCloud, radius_m: float, progress: Progress | None = None
) -> SurfaceFields:
    """The fields of a model in World, m.

    Raises UsageError for a radius that is none, GeometryError where the radius holds too few
    points nearly everywhere, Cancelled through `progress`.
    """
    if not 0.0 < radius_m < np.inf:
        raise UsageError(Finding("number.not-a-length", text=str(radius_m)), field="radius")
    progress = progress or Silent()
    progress.stage(tr("Preparing surface points"), None)
    places = np.asarray(points_of(data), np.float64)
    said = _refused_or_told(data, radius_m)
    points = surface_points(data, radius_m / _SPACINGS)[0]
    support = _evenly(points, radius_m / _CELLS)
    grid = PointGrid(support, radius_m)
    progress.stage(tr("Fitting planes within the radius"), len(places))
    planes = grid.planes(places, radius_m, progress)
    enough = planes.count >= _FEWEST
    on_lines = enough & ~(planes.spread[:, 1] > _THIN * planes.spread[:, 2])
    if enough.any() and (on_lines == enough).all():
        raise GeometryError(Finding("fields.points-in-line", radius_m=radius_m))
    enough &= ~on_lines
    if not enough.any():
        raise GeometryError(Finding("fields.too-few-points", radius_m=radius_m))
    normals, warnings = _outward(data, planes.normal)
    warnings = (*said, *warnings)
    normals[~enough] = np.nan
    progress.stage(tr("Computing curvature"), len(places))
    curvature = grid.curvatures(places, normals, radius_m, progress)
    values = {**_attitudes(normals), "curvature": curvature, **_shapes(planes)}
    left = float(1.0 - enough.mean())
    if left > _SPARSE_SHARE:
        warnings = (
            *warnings,
            Finding("fields.few-points", share_percent=100.0 * left, minimum=_FEWEST),
        )
    return SurfaceFields(
        radius_m,
        {key: _kept(values[key], enough) for key in KINDS},
        int(np.median(planes.count[enough])),
        warnings,
    )


def _refused_or_told(data: Mesh | PointCloud, radius_m: float) -> tuple[Finding, ...]:
    """What is to be known of a radius beside the triangles of a mesh. Raises GeometryError where
    their points would be too many."""
    if not isinstance(data, Mesh) or not len(data.faces):
        return ()
    areas = face_areas(data, np.arange(len(data.faces)))
    areas = areas[np.isfinite(areas)]
    most = max(_MOST_POINTS, 3 * len(data.vertices))
    least = _SPACINGS * float(np.sqrt(areas.sum() / most))
    if radius_m < least:
        raise GeometryError(Finding("fields.radius-below-faces", minimum_m=least))
    usual = float(np.sqrt(2.0 * np.median(areas))) if len(areas) else 0.0
    if radius_m < 2.0 * usual:
        return (Finding("fields.single-faces"),)
    return ()


def _kept(values: FloatArray, enough: BoolArray) -> Float32Array:
    return np.where(enough, values, np.nan).astype(np.float32)


def _attitudes(normals: FloatArray) -> dict[str, FloatArray]:
    """Of unit normals (n, 3) that point out of the rock."""
    x, y, z = normals.T
    up = np.where(z < 0.0, -1.0, 1.0)
    dip = np.degrees(np.arccos(np.clip(np.abs(z), 0.0, 1.0)))
    direction = np.degrees(np.arctan2(up * x, up * y)) % 360.0
    return {
        "dip": dip,
        "dip_direction": np.where(dip < _LEVEL_DEG, np.nan, direction),
        "steepness": np.degrees(np.arccos(np.clip(z, -1.0, 1.0))),
    }


def _shapes(planes: LocalPlanes) -> dict[str, FloatArray]:
    third, second, first = planes.spread.T
    # A perfect plane has a third eigenvalue of rounding errors.
    third = np.maximum(third, 1e-12 * first)
    with np.errstate(divide="ignore", invalid="ignore"):
        return {
            "roughness": np.sqrt(np.maximum(planes.spread[:, 0], 0.0)),
            "coplanarity": np.log(first / third),
            "collinearity": np.log(first / second) / np.log(second / third),
        }


def _evenly(points: FloatArray, cell: float) -> FloatArray:
    """At most _IN_CELL points of each cell, chosen at random and unmoved: a mean would be smoother
    than the rock, and one of each of many small cells would count what lies off the surface
    more."""
    if not len(points):
        return points
    places = np.floor((points - points.min(axis=0)) / cell).astype(np.int64)
    size = places.max(axis=0) + 1
    key = (places[:, 0] * size[1] + places[:, 1]) * size[2] + places[:, 2]
    mixed = np.random.default_rng(0).permutation(len(key))
    order = mixed[np.argsort(key[mixed], kind="stable")]
    begins = np.concatenate([[True], np.diff(key[order]) != 0])
    first = np.maximum.accumulate(np.where(begins, np.arange(len(order)), 0))
    return points[np.sort(order[np.arange(len(order)) - first < _IN_CELL])]


def _outward(
    data: Mesh | PointCloud, normals: FloatArray
) -> tuple[FloatArray, tuple[Finding, ...]]:
    """Orient normals out of the rock, by the faces of a mesh or the normals of a cloud.

    Without either they are turned upward, and a warning is returned.
    """
    if isinstance(data, Mesh) and len(data.faces):
        sides: FloatArray | None = _vertex_normals(data)
    elif isinstance(data, PointCloud) and data.normals is not None:
        sides = np.asarray(data.normals, np.float64)
    else:
        sides = None
    if sides is None:
        up = np.broadcast_to([0.0, 0.0, 1.0], normals.shape)
        warning = Finding("fields.outside-unknown")
        return _turned(normals, up), (warning,)
    return _turned(normals, sides), ()


def _turned(normals: FloatArray, sides: FloatArray) -> FloatArray:
    along = np.einsum("ij,ij->i", normals, np.nan_to_num(sides))
    return normals * np.where(along < 0.0, -1.0, 1.0)[:, None]


def _vertex_normals(mesh: Mesh) -> FloatArray:
    """(n, 3) sums of the normals of the faces around each place, by area; those of one place are
    one, whatever the seams of the texture."""
    vertices = np.asarray(mesh.vertices, np.float64)
    corners = [vertices[mesh.faces[:, k]] for k in range(3)]
    cross = np.nan_to_num(np.cross(corners[1] - corners[0], corners[2] - corners[0]))
    number = welded(vertices)
    nodes = number[mesh.faces]
    count = int(number.max(initial=-1)) + 1
    found = np.empty((count, 3))
    for axis in range(3):
        found[:, axis] = sum(np.bincount(nodes[:, k], cross[:, axis], count) for k in range(3))
    return np.asarray(found[number])
