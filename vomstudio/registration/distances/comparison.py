"""Distances of a model from a benchmark, and their level of detection."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from vomstudio.core.arrays import AnyArray, BoolArray, FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.results import HIDDEN_IN_JSON
from vomstudio.core.words import tr
from vomstudio.geology.orientation import Line
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.registration.distances import m3c2
from vomstudio.registration.distances.cloud_distance import OrientedCloud, has_point_normals
from vomstudio.registration.distances.mesh_distance import OrientedMesh
from vomstudio.registration.overlap import require_overlap
from vomstudio.registration.surface_points import Counterparts, points_of, surface_points

# Percentile of the nearest distances that cylinders cover, and margin for inclined normals.
_DISTANCE_PERCENTILE, _DISTANCE_FACTOR = 99.0, 1.5
# Ratio of the mean normal below which a benchmark has no overall side.
_MIN_MEAN_NORMAL = 0.2
_PARTIAL_SHARE = 0.5
# Spacing of points added on large faces, as a share of the cylinder radius.
_POINT_SPACING = 0.25


@dataclass(frozen=True)
class PositiveDirection:
    """Trend and plunge of the direction of positive distances, in degrees."""

    trend_deg: float
    plunge_deg: float


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(PrintableResult):
    """Signed distances from a benchmark to a model, metres, and their statistics.

    Attributes
    ----------
    n : int
        Number of distances.
    beyond : int
        Number of model points without a counterpart or a distance.
    mean_m, median_m : float
        Mean and median, which show the systematic error (accuracy).
    std_m : float or None
        Standard deviation (divisor n - 1), which shows the precision; None for a single distance.
    mad_m : float
        Median absolute deviation from the median.
    rms_m : float
    lod95_m : float or None
        Median level of detection; None unless M3C2 was used.
    significant_share : float or None
        Share of the distances with a level of detection that exceed it; None unless M3C2 was used.
    method : {"nearest", "m3c2"}
    radius_m, normal_radius_m, reach_m : float or None
        Radii of the cylinders and of the normal estimation of M3C2, and half length of the
        cylinders.
    registration_error_m : float or None
        One-sigma registration error, which is part of the level of detection.
    positive_toward : PositiveDirection or None
        Mean direction of positive distances, or None for a closed body.
    sides_by : str
        How the sides of the benchmark were determined: "winding" of its faces, "normals" from its
        file, "model", or "up".
    distances, lod95 : (k,) array
        Distances and levels of detection of all model points, in their order; NaN if undefined.
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
    positive_toward: PositiveDirection | None
    sides_by: str
    warnings: tuple[Finding, ...]
    distances: FloatArray = field(metadata=HIDDEN_IN_JSON)
    lod95: FloatArray | None = field(metadata=HIDDEN_IN_JSON)

    def as_fields(self) -> dict[str, AnyArray]:
        """Return `distance_m` of the points and, for M3C2, `lod95_m` and `significant` (0, 1)."""
        columns: dict[str, AnyArray] = {"distance_m": self.distances}
        if self.lod95 is not None:
            columns["lod95_m"] = self.lod95
            with np.errstate(invalid="ignore"):
                columns["significant"] = (np.abs(self.distances) > self.lod95).astype(np.uint8)
        return columns


def compare(
    model: Mesh | PointCloud,
    benchmark: Mesh | PointCloud,
    *,
    radius_m: float | None = None,
    registration_error_m: float | None = None,
    progress: Progress | None = None,
) -> Comparison:
    """Compute the distances of the points of a model from a benchmark.

    Parameters
    ----------
    model, benchmark : Mesh or PointCloud
        Data in the World frame.
    radius_m : float, optional
        Radius of the cylinders of M3C2. By default, distances to the nearest triangle of a mesh or
        the nearest local plane of a cloud are computed instead.
    registration_error_m : float, optional
        One-sigma error of the relative position of the two, used for M3C2.
    progress : Progress, optional
        Progress indicator, which may raise Cancelled; each step is one point.

    Returns
    -------
    Comparison

    Raises
    ------
    GeometryError
        If the model or the benchmark has no finite points, or if they do not overlap.
    """
    progress = progress or SilentProgress()
    positions = points_of(model)
    for data, name in ((model, tr("The model")), (benchmark, tr("The benchmark"))):
        if not np.isfinite(points_of(data)).all(axis=1).any():
            raise GeometryError(Finding("comparison.no-points", name=name))
    require_overlap(_bounds(model), _bounds(benchmark), (tr("The model"), tr("the benchmark")))
    progress.stage(tr("Preparing the benchmark"), None)
    oriented_benchmark, method = _orient_benchmark(model, benchmark)
    progress.stage(tr("Computing distances"), len(positions))
    counterparts = oriented_benchmark.find_counterparts(positions, progress)
    tolerance = _spacing(model)
    is_beyond = ~np.isfinite(counterparts.distance) | (
        counterparts.distance_beyond_edge > (tolerance if method == "winding" else 0.0)
    )
    findings: list[Finding] = []
    distances, lod95, max_distance = np.where(is_beyond, np.nan, counterparts.distance), None, None
    if radius_m is not None:
        max_distance = _cylinder_half_length(distances, radius_m)
        error = registration_error_m or 0.0
        distances, lod95 = _m3c2(
            model,
            benchmark,
            counterparts,
            is_beyond,
            radius_m,
            max_distance,
            error,
            progress,
            findings,
        )
        if registration_error_m is None:
            findings.append(Finding("comparison.error-assumed"))
    figures = statistics(distances, lod95)
    if len(positions) - figures["n"] > _PARTIAL_SHARE * len(positions):
        findings.append(
            Finding("comparison.partial", share_percent=100.0 * figures["n"] / len(positions))
        )
    return Comparison(
        **figures,
        method="nearest" if radius_m is None else "m3c2",
        radius_m=radius_m,
        normal_radius_m=None if radius_m is None else m3c2.NORMAL_SCALE * radius_m,
        reach_m=max_distance,
        registration_error_m=None if radius_m is None else (registration_error_m or 0.0),
        positive_toward=_positive_direction(oriented_benchmark),
        sides_by=method,
        warnings=tuple(findings),
        distances=distances,
        lod95=lod95,
    )


def statistics(distances: FloatArray, lod95: FloatArray | None) -> dict[str, Any]:
    """Compute the statistics of a comparison.

    Parameters
    ----------
    distances : (k,) array
        Distances, metres; non-finite for points beyond the benchmark.
    lod95 : (k,) array or None

    Returns
    -------
    dict
        Fields of `Comparison` from `n` to `significant_share`.

    Raises
    ------
    GeometryError
        If no distance is finite.
    """
    is_finite = np.isfinite(distances)
    valid_distances = distances[is_finite]
    if not len(valid_distances):
        raise GeometryError(Finding("comparison.no-overlap"))
    median = float(np.median(valid_distances))
    lod: float | None = None
    share: float | None = None
    if lod95 is not None:
        is_known = is_finite & np.isfinite(lod95)
        if is_known.any():
            lod = float(np.median(lod95[is_known]))
            share = float((np.abs(distances[is_known]) > lod95[is_known]).mean())
    return {
        "n": len(valid_distances),
        "beyond": len(distances) - len(valid_distances),
        "mean_m": float(valid_distances.mean()),
        "median_m": median,
        "std_m": float(valid_distances.std(ddof=1)) if len(valid_distances) > 1 else None,
        "mad_m": float(np.median(np.abs(valid_distances - median))),
        "rms_m": float(np.sqrt((valid_distances**2).mean())),
        "lod95_m": lod,
        "significant_share": share,
    }


def _bounds(data: Mesh | PointCloud) -> FloatArray:
    points = points_of(data)
    finite_points = points[np.isfinite(points).all(axis=1)]
    return np.array([finite_points.min(axis=0), finite_points.max(axis=0)])


def _orient_benchmark(model: Mesh | PointCloud, benchmark: Mesh | PointCloud) -> tuple[Any, str]:
    """Return the benchmark with its sides, and how they were determined."""
    if isinstance(benchmark, Mesh) and len(benchmark.faces):
        return OrientedMesh(benchmark), "winding"
    cloud = benchmark
    if isinstance(cloud, Mesh):
        cloud = PointCloud(cloud.vertices)
    direction = None
    if isinstance(model, Mesh) and len(model.faces):
        corners = model.vertices[model.faces[:: max(1, len(model.faces) // 50_000)]]
        direction = (
            corners.mean(axis=1),
            np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]),
        )
    elif isinstance(model, PointCloud) and has_point_normals(model):
        assert model.normals is not None
        step = max(1, len(model.points) // 50_000)
        direction = (model.points[::step], np.asarray(model.normals[::step], np.float64))
    oriented_cloud = OrientedCloud(cloud, _spacing(cloud), direction)
    return oriented_cloud, {"file": "normals", "model": "model", "up": "up"}[oriented_cloud.source]


def _spacing(data: Mesh | PointCloud) -> float:
    """Return the effective resolution, or a tiny number if it is unknown."""
    from vomstudio.io.models.opening import resolution

    if isinstance(data, PointCloud):
        data = PointCloud(data.points[np.isfinite(data.points).all(axis=1)])
    spacing = resolution(data)
    return spacing if np.isfinite(spacing) and spacing > 0 else 1e-9


def _cylinder_half_length(distances: FloatArray, radius: float) -> float:
    """Return the half length of cylinders that covers nearly all nearest distances."""
    absolute = np.abs(distances[np.isfinite(distances)])
    far_distance = float(np.percentile(absolute, _DISTANCE_PERCENTILE)) if len(absolute) else 0.0
    return max(2.0 * radius, _DISTANCE_FACTOR * far_distance + radius)


def _m3c2(
    model: Mesh | PointCloud,
    benchmark: Mesh | PointCloud,
    counterparts: Counterparts,
    is_beyond: BoolArray,
    radius: float,
    max_distance: float,
    error: float,
    progress: Progress,
    findings: list[Finding],
) -> tuple[FloatArray, FloatArray]:
    positions = points_of(model)
    clouds = []
    for data, name in ((model, tr("the model")), (benchmark, tr("the benchmark"))):
        points, n_added = surface_points(data, _POINT_SPACING * radius)
        clouds.append(points)
        if n_added > len(points) / 2:
            findings.append(Finding("comparison.large-faces", name=name))
    rows = np.flatnonzero(~is_beyond)
    core_points = np.asarray(positions[rows], np.float64)
    progress.stage(tr("Computing normals"), len(core_points))
    normals = m3c2.normals_at(
        clouds[0], core_points, m3c2.NORMAL_SCALE * radius, counterparts.normal[rows], progress
    )
    projection = m3c2.project(
        core_points,
        normals,
        clouds[0],
        clouds[1],
        radius=radius,
        max_distance=max_distance,
        registration_error=error,
        progress=progress,
    )
    has_distance = np.isfinite(projection.distance)
    has_few_points = has_distance & ~np.isfinite(projection.lod95)
    if has_few_points.sum() > 0.1 * max(has_distance.sum(), 1):
        findings.append(
            Finding(
                "comparison.few-points",
                share_percent=100.0 * has_few_points.sum() / has_distance.sum(),
                count=m3c2.MIN_POINTS,
            )
        )
    distances, lod95 = np.full(len(positions), np.nan), np.full(len(positions), np.nan)
    distances[rows], lod95[rows] = (
        projection.distance,
        np.where(has_distance, projection.lod95, np.nan),
    )
    return distances, lod95


def _positive_direction(
    oriented_benchmark: OrientedMesh | OrientedCloud,
) -> PositiveDirection | None:
    mean = oriented_benchmark.mean_normal
    size = float(np.linalg.norm(mean))
    if not size > _MIN_MEAN_NORMAL * oriented_benchmark.total:
        return None
    line = Line.from_vector(mean, is_directed=True)
    return PositiveDirection(line.trend_deg, line.plunge_deg)
