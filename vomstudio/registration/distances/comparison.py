"""How far a model lies from a benchmark, and what of that is more than chance."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from vomstudio.core.arrays import AnyArray, BoolArray, FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, Silent
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.results import HIDDEN
from vomstudio.core.words import tr
from vomstudio.geology.orientation import Line
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.registration.distances import m3c2
from vomstudio.registration.distances.cloud_distance import CloudSides, has_sides
from vomstudio.registration.distances.mesh_distance import MeshSides
from vomstudio.registration.overlap import refuse_apart
from vomstudio.registration.surface_points import Opposite, points_of, surface_points

# Nearly all nearest distances, and what a normal of the model's lengthens them by.
_MOST_SHARE, _LONGER = 99.0, 1.5
# A benchmark whose normals cancel out has no side as a whole.
_ONE_SIDED = 0.2
_FEW_SHARE = 0.5
# Of the cylinder's radius: faces larger than the square of it get points.
_POINT_SPACING = 0.25


@dataclass(frozen=True)
class Toward:
    """A direction, degrees."""

    trend_deg: float
    plunge_deg: float


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(PrintableResult):
    """Signed distances from a benchmark to a model, metres, and their statistics.

    n : distances; beyond : points of the model that have no counterpart, and no distance
    mean_m, median_m : accuracy, what is wrong throughout; std_m (n - 1), mad_m (median absolute
        deviation from the median, as it is): precision, what differs from place to place
    rms_m : both together
    lod95_m : median level of detection, significant_share : of the distances that have one, those
        beyond it; None without M3C2
    method : "nearest" or "m3c2"; radius_m, normal_radius_m, reach_m : of its cylinders and balls
    registration_error_m : one sigma, as it entered the level of detection
    positive_toward : where distances are positive, on the whole; None of a closed body
    sides_by : what tells the benchmark's side: the "winding" of its faces, the "normals" of its
        file, the "model", or "up"
    distances, lod95 : (k,) of all points of the model in their order, NaN where there is none
    """

    n: int
    beyond: int
    mean_m: float
    median_m: float
    std_m: float | None
    mad_m: float
    rms_m: float
    lod95_m: float | None
    significant_share: float | None
    method: str
    radius_m: float | None
    normal_radius_m: float | None
    reach_m: float | None
    registration_error_m: float | None
    positive_toward: Toward | None
    sides_by: str
    warnings: tuple[Finding, ...]
    distances: FloatArray = field(metadata=HIDDEN)
    lod95: FloatArray | None = field(metadata=HIDDEN)

    def as_fields(self) -> dict[str, AnyArray]:
        """Fields of the model's points: `distance_m`, and with M3C2 `lod95_m` and `significant`
        (0 or 1)."""
        told: dict[str, AnyArray] = {"distance_m": self.distances}
        if self.lod95 is not None:
            told["lod95_m"] = self.lod95
            with np.errstate(invalid="ignore"):
                told["significant"] = (np.abs(self.distances) > self.lod95).astype(np.uint8)
        return told


def compare(
    model: Mesh | PointCloud,
    benchmark: Mesh | PointCloud,
    *,
    radius_m: float | None = None,
    registration_error_m: float | None = None,
    progress: Progress | None = None,
) -> Comparison:
    """The distances of a model's points from a benchmark, both in World.

    Without `radius_m` to the nearest point of the benchmark: of a mesh, on its triangles; of a
    cloud, on the plane that is fitted to it there. With it M3C2 in cylinders of this radius.
    registration_error_m : one sigma of how they are placed to each other, for M3C2
    Raises GeometryError where they do not overlap, Cancelled through `progress`, whose steps are
    points.
    """
    progress = progress or Silent()
    places = points_of(model)
    for data, name in ((model, tr("The model")), (benchmark, tr("The benchmark"))):
        if not np.isfinite(points_of(data)).all(axis=1).any():
            raise GeometryError(Finding("comparison.no-points", name=name))
    refuse_apart(_bounds(model), _bounds(benchmark), (tr("The model"), tr("the benchmark")))
    progress.stage(tr("Preparing the benchmark"), None)
    sides, by = _sides(model, benchmark)
    progress.stage(tr("Computing distances"), len(places))
    near = sides.opposite(places, progress)
    slack = _spacing(model)
    beyond = ~np.isfinite(near.distance) | (near.beside > (slack if by == "winding" else 0.0))
    findings: list[Finding] = []
    distances, lod95, reach = np.where(beyond, np.nan, near.distance), None, None
    if radius_m is not None:
        reach = _reach(distances, radius_m)
        error = registration_error_m or 0.0
        distances, lod95 = _m3c2(
            model, benchmark, near, beyond, radius_m, reach, error, progress, findings
        )
        if registration_error_m is None:
            findings.append(Finding("comparison.error-assumed"))
    figures = statistics(distances, lod95)
    if len(places) - figures["n"] > _FEW_SHARE * len(places):
        findings.append(
            Finding("comparison.partial", share_percent=100.0 * figures["n"] / len(places))
        )
    return Comparison(
        **figures,
        method="nearest" if radius_m is None else "m3c2",
        radius_m=radius_m,
        normal_radius_m=None if radius_m is None else m3c2.NORMAL_SCALE * radius_m,
        reach_m=reach,
        registration_error_m=None if radius_m is None else (registration_error_m or 0.0),
        positive_toward=_toward(sides),
        sides_by=by,
        warnings=tuple(findings),
        distances=distances,
        lod95=lod95,
    )


def statistics(distances: FloatArray, lod95: FloatArray | None) -> dict[str, Any]:
    """n, beyond, mean_m, median_m, std_m, mad_m, rms_m, lod95_m and significant_share of distances
    (k,), of which those that are not finite are beyond. Raises GeometryError where none is left."""
    there = np.isfinite(distances)
    left = distances[there]
    if not len(left):
        raise GeometryError(Finding("comparison.no-overlap"))
    median = float(np.median(left))
    lod: float | None = None
    share: float | None = None
    if lod95 is not None:
        known = there & np.isfinite(lod95)
        if known.any():
            lod = float(np.median(lod95[known]))
            share = float((np.abs(distances[known]) > lod95[known]).mean())
    return {
        "n": len(left),
        "beyond": len(distances) - len(left),
        "mean_m": float(left.mean()),
        "median_m": median,
        "std_m": float(left.std(ddof=1)) if len(left) > 1 else None,
        "mad_m": float(np.median(np.abs(left - median))),
        "rms_m": float(np.sqrt((left**2).mean())),
        "lod95_m": lod,
        "significant_share": share,
    }


def _bounds(data: Mesh | PointCloud) -> FloatArray:
    points = points_of(data)
    sound = points[np.isfinite(points).all(axis=1)]
    return np.array([sound.min(axis=0), sound.max(axis=0)])


def _sides(model: Mesh | PointCloud, benchmark: Mesh | PointCloud) -> tuple[Any, str]:
    """The benchmark with its sides, and by what these are told."""
    if isinstance(benchmark, Mesh) and len(benchmark.faces):
        return MeshSides(benchmark), "winding"
    cloud = benchmark
    if isinstance(cloud, Mesh):
        cloud = PointCloud(cloud.vertices)
    toward = None
    if isinstance(model, Mesh) and len(model.faces):
        corners = model.vertices[model.faces[:: max(1, len(model.faces) // 50_000)]]
        toward = (
            corners.mean(axis=1),
            np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]),
        )
    elif isinstance(model, PointCloud) and has_sides(model):
        assert model.normals is not None
        step = max(1, len(model.points) // 50_000)
        toward = (model.points[::step], np.asarray(model.normals[::step], np.float64))
    found = CloudSides(cloud, _spacing(cloud), toward)
    return found, {"file": "normals", "model": "model", "up": "up"}[found.told_by]


def _spacing(data: Mesh | PointCloud) -> float:
    """Effective resolution; of points that tell none, nothing."""
    from vomstudio.io.models.opening import resolution

    if isinstance(data, PointCloud):
        data = PointCloud(data.points[np.isfinite(data.points).all(axis=1)])
    found = resolution(data)
    return found if np.isfinite(found) and found > 0 else 1e-9


def _reach(distances: FloatArray, radius: float) -> float:
    """How far a cylinder goes to either side: past nearly all of the nearest distances."""
    found = np.abs(distances[np.isfinite(distances)])
    far = float(np.percentile(found, _MOST_SHARE)) if len(found) else 0.0
    return max(2.0 * radius, _LONGER * far + radius)


def _m3c2(
    model: Mesh | PointCloud,
    benchmark: Mesh | PointCloud,
    near: Opposite,
    beyond: BoolArray,
    radius: float,
    reach: float,
    error: float,
    progress: Progress,
    findings: list[Finding],
) -> tuple[FloatArray, FloatArray]:
    places = points_of(model)
    clouds = []
    for data, name in ((model, tr("the model")), (benchmark, tr("the benchmark"))):
        points, added = surface_points(data, _POINT_SPACING * radius)
        clouds.append(points)
        if added > len(points) / 2:
            findings.append(Finding("comparison.large-faces", name=name))
    rows = np.flatnonzero(~beyond)
    core = np.asarray(places[rows], np.float64)
    progress.stage(tr("Computing normals"), len(core))
    normals = m3c2.normals_at(
        clouds[0], core, m3c2.NORMAL_SCALE * radius, near.normal[rows], progress
    )
    found = m3c2.project(
        core,
        normals,
        clouds[0],
        clouds[1],
        radius=radius,
        reach=reach,
        registration_error=error,
        progress=progress,
    )
    there = np.isfinite(found.distance)
    few = there & ~np.isfinite(found.lod95)
    if few.sum() > 0.1 * max(there.sum(), 1):
        findings.append(
            Finding(
                "comparison.few-points",
                share_percent=100.0 * few.sum() / there.sum(),
                count=m3c2.FEWEST,
            )
        )
    distances, lod95 = np.full(len(places), np.nan), np.full(len(places), np.nan)
    distances[rows], lod95[rows] = found.distance, np.where(there, found.lod95, np.nan)
    return distances, lod95


def _toward(sides: MeshSides | CloudSides) -> Toward | None:
    mean = sides.mean_normal
    size = float(np.linalg.norm(mean))
    if not size > _ONE_SIDED * sides.total:
        return None
    line = Line.from_vector(mean, directed=True)
    return Toward(line.trend_deg, line.plunge_deg)
