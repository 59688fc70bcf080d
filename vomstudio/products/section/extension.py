"""Extension of a plane through a model: traces on the surface, and their errors."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import Float32Array, FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.files.atomic import atomic_group, write_bytes
from vomstudio.core.files.extensions import check_extension
from vomstudio.core.files.spreadsheet_cells import comment_line
from vomstudio.core.findings import Finding
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.results import HIDDEN_IN_JSON
from vomstudio.core.version import __version__
from vomstudio.geology.beds.extended import (
    PlaneDistances,
    PlaneEstimate,
    PlaneSeries,
    bands,
    repeat_planes,
)
from vomstudio.geology.notation import format_plain_azimuth
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.units import WORLD_AXES, Axes, table_columns
from vomstudio.io.models.opening import point_spacing
from vomstudio.products.section.cutting import SLAB_SPACINGS, Cut, crossed_edges, cut_model
from vomstudio.products.section.extend_options import ExtendOptions
from vomstudio.products.section.section_lines import Curtain, curtain_from_plane

SUFFIXES = (".csv", ".gpkg")
COLUMNS = ("bed", "line", "x", "y", "z", "error95_m")
LAYER_NAME = "extended_planes"
_N_NEIGHBOURS = 6
DEFAULT_OPTIONS = ExtendOptions()


@dataclass(frozen=True, eq=False)
class ExtensionTrace:
    """Trace of an extended plane on the surface.

    Parameters
    ----------
    bed : int
        Number of the plane; 0 is the original one.
    points : (n, 3) array
        Points of the trace in the World frame, m.
    error95_m : (n,) array
        95 % error of the position of each point, perpendicular to the plane.
    """

    bed: int
    points: FloatArray
    error95_m: FloatArray


@dataclass(frozen=True)
class RepeatedPlane:
    """Repeated plane with its traces, their length, and the range of their 95 % errors."""

    bed: int
    offset_m: float
    traces: int
    length_m: float
    least_error95_m: float
    most_error95_m: float


@dataclass(frozen=True, eq=False, repr=False)
class ExtendedPlane(PrintableResult):
    """Plane extended through a model.

    Parameters
    ----------
    dip_direction_deg, dip_deg : float
    middle : (3,) tuple
        Point at which the plane is best known, in the World frame, m.
    max_error95_deg, min_error95_deg : float
        Half-angles of the joint 95 % region of the plane's normal.
    thickness_m : float or None
        Thickness of the beds; None for a single plane.
    beds : tuple of RepeatedPlane
        Planes that intersect the model, from bottom to top.
    length_m : float
        Total length of the traces.
    within_share : float
        Share of the model's points that lie in the error band of a plane.
    warnings : tuple of Finding
    traces : tuple of ExtensionTrace
    bands : PlaneDistances
        Distances of the model's points from the planes.
    """

    dip_direction_deg: float
    dip_deg: float
    middle: tuple[float, float, float]
    max_error95_deg: float
    min_error95_deg: float
    thickness_m: float | None
    beds: tuple[RepeatedPlane, ...]
    length_m: float
    within_share: float
    warnings: tuple[Finding, ...]
    traces: tuple[ExtensionTrace, ...] = field(default=(), metadata=HIDDEN_IN_JSON)
    bands: PlaneDistances | None = field(default=None, metadata=HIDDEN_IN_JSON)

    def as_fields(self) -> dict[str, Float32Array]:
        """Return point fields with the distance, error and number of the nearest plane.

        The number is NaN for points outside the error band.
        """
        assert self.bands is not None
        bands = self.bands
        return {
            "plane_distance_m": bands.distance_m.astype(np.float32),
            "plane_error95_m": bands.error95_m.astype(np.float32),
            "bed": np.where(bands.is_in_band, bands.bed, np.nan).astype(np.float32),
        }


def extend(
    data: Mesh | PointCloud,
    estimate: PlaneEstimate,
    options: ExtendOptions = DEFAULT_OPTIONS,
    spacing: float | None = None,
) -> ExtendedPlane:
    """Extend a plane through a model.

    Parameters
    ----------
    data : Mesh or PointCloud
        Model in the World frame, m.
    estimate : PlaneEstimate
        The plane and its errors.
    options : ExtendOptions
        Options, including the thickness at which the plane is repeated.
    spacing : float, optional
        Mean distance between neighbouring points of a cloud, m. If omitted, it is estimated.

    Returns
    -------
    ExtendedPlane

    Raises
    ------
    GeometryError
        If no plane intersects the model.
    """
    thickness_m, thickness_error_m = options.thickness_m, options.thickness_error_m
    if spacing is None:
        spacing_estimate = 0.0 if isinstance(data, Mesh) else point_spacing(data)
        spacing = spacing_estimate if np.isfinite(spacing_estimate) else 0.0
    points = data.vertices if isinstance(data, Mesh) else data.points
    finite_points = points[np.isfinite(points).all(axis=1)]
    if not len(finite_points):
        raise GeometryError(Finding("model.no-points"))
    repeats = repeat_planes(estimate, finite_points, thickness_m, thickness_error_m)
    point_bands = bands(estimate, repeats, points)
    beds, traces = [], []
    for number in repeats.numbers.tolist():
        cut = _cut_near_plane(data, estimate, repeats, number, spacing)
        bed_traces = [
            _create_trace(line, estimate, repeats, number) for line in cut.world if len(line) > 1
        ]
        if not bed_traces:
            continue
        traces += bed_traces
        errors = np.concatenate([trace.error95_m for trace in bed_traces])
        beds.append(
            RepeatedPlane(
                number,
                repeats.offset(number),
                len(bed_traces),
                cut.length_m,
                float(errors.min()),
                float(errors.max()),
            )
        )
    if not beds:
        raise GeometryError(Finding("extension.misses-model"))
    minor_deg, major_deg = _half_angles(estimate)
    plane = estimate.plane
    return ExtendedPlane(
        plane.dip_direction_deg,
        plane.dip_deg,
        (float(estimate.centroid[0]), float(estimate.centroid[1]), float(estimate.centroid[2])),
        major_deg,
        minor_deg,
        thickness_m,
        tuple(beds),
        float(sum(bed.length_m for bed in beds)),
        float(np.mean(point_bands.is_in_band)),
        _warnings(beds, thickness_m),
        tuple(traces),
        point_bands,
    )


_SINGLE_PLANE = PlaneSeries(np.zeros(1, np.int64), None)


def band_edges(
    mesh: Mesh, estimate: PlaneEstimate, repeats: PlaneSeries = _SINGLE_PLANE, number: int = 0
) -> tuple[FloatArray, FloatArray]:
    """Return the lines on a mesh that bound the error band of a plane.

    Parameters
    ----------
    mesh : Mesh
        Mesh in the World frame, m.
    estimate : PlaneEstimate
    repeats : PlaneSeries
    number : int
        Number of the repeated plane.

    Returns
    -------
    upper, lower : (k, 2, 3) arrays
        Upper and lower bounding lines, one segment per intersected triangle.
    """
    distances = estimate.distances(mesh.vertices) - repeats.offset(number)
    half_width = _error95(mesh.vertices, estimate, repeats, number)
    return _zero_level_segments(mesh, distances - half_width), _zero_level_segments(
        mesh, distances + half_width
    )


def _zero_level_segments(mesh: Mesh, values: FloatArray) -> FloatArray:
    """Return the segments (k, 2, 3) along which the vertex values are 0."""
    tip, *others = crossed_edges(mesh, values >= 0.0)
    ends = []
    for other in others:
        fraction = values[tip] / (values[tip] - values[other])
        a, b = mesh.vertices[tip], mesh.vertices[other]
        ends.append(a + fraction[:, None] * (b - a))
    return np.stack(ends, axis=1)


def _cut_near_plane(
    data: Mesh | PointCloud,
    estimate: PlaneEstimate,
    repeats: PlaneSeries,
    index: int,
    spacing: float,
) -> Cut:
    """Cut only the part of the model near the plane, which is fast even for many planes."""
    offset = repeats.offset(index)
    origin = estimate.centroid + offset * estimate.axes[2]
    curtain: Curtain = curtain_from_plane(estimate.plane, origin)
    if isinstance(data, Mesh):
        distances = estimate.distances(data.vertices) - offset
        is_above = (distances >= 0.0)[data.faces]
        faces = data.faces[is_above.any(axis=1) & ~is_above.all(axis=1)]
        if not len(faces):
            return Cut((), ())
        ids, node_ids = np.unique(faces, return_inverse=True)
        part = Mesh(data.vertices[ids], node_ids.reshape(-1, 3).astype(np.int32))
        return cut_model(part, curtain)
    crossings = _crossings(data.points, estimate.distances(data.points) - offset, spacing)
    return cut_model(PointCloud(crossings), curtain, spacing, spacing)


def _crossings(points: FloatArray, distances: FloatArray, spacing: float) -> FloatArray:
    """Return the points (k, 3) where links between neighbours of a cloud cross the plane.

    Unlike these, a slab of points would become wider as the plane becomes more oblique to the
    surface.
    """
    from scipy.spatial import cKDTree

    rows = np.flatnonzero(np.abs(distances) <= SLAB_SPACINGS * spacing)
    if len(rows) < 2:
        return np.zeros((0, 3))
    near_points, offsets = points[rows] - points[rows[0]], distances[rows]
    _, neighbours = cKDTree(near_points).query(
        near_points,
        k=min(_N_NEIGHBOURS + 1, len(near_points)),
        distance_upper_bound=SLAB_SPACINGS * spacing,
    )
    first_rows = np.repeat(np.arange(len(near_points)), neighbours.shape[1])
    second = neighbours.ravel()
    is_linked = second < len(near_points)
    first_rows, second = first_rows[is_linked], second[is_linked]
    is_crossed = (offsets[first_rows] >= 0.0) & (offsets[second] < 0.0)
    first_rows, second = first_rows[is_crossed], second[is_crossed]
    fraction = offsets[first_rows] / (offsets[first_rows] - offsets[second])
    return np.asarray(
        points[rows[0]]
        + near_points[first_rows]
        + fraction[:, None] * (near_points[second] - near_points[first_rows])
    )


def _create_trace(
    line: FloatArray, estimate: PlaneEstimate, repeats: PlaneSeries, index: int
) -> ExtensionTrace:
    return ExtensionTrace(index, line, _error95(line, estimate, repeats, index))


def _error95(
    points: FloatArray, estimate: PlaneEstimate, repeats: PlaneSeries, index: int
) -> FloatArray:
    variance = estimate.position_sd(points) ** 2 + index**2 * repeats.thickness_variance
    return np.asarray(estimate.t95 * np.sqrt(variance))


def _half_angles(estimate: PlaneEstimate) -> tuple[float, float]:
    """Return the half-angles of the joint 95 % region of a plane in degrees."""
    from vomstudio.geometry.plane_errors import joint_quantile
    from vomstudio.geometry.rotation_errors import CHI2_TWO

    dof = estimate.degrees_of_freedom
    limit = CHI2_TWO
    if np.isfinite(dof):
        limit = float(joint_quantile(np.array([dof]))[0]) * dof
    minor_deg, major_deg = np.degrees(np.arctan(np.sqrt(np.sort(estimate.tilt_variances) * limit)))
    return float(minor_deg), float(major_deg)


def _warnings(beds: list[RepeatedPlane], thickness: float | None) -> tuple[Finding, ...]:
    if thickness is None or max(bed.most_error95_m for bed in beds) < 0.5 * thickness:
        return ()
    return (Finding("extension.beds-indistinct"),)


def format_from_path(path: str | Path) -> str:
    """Return the extension of a trace file.

    Raises
    ------
    UsageError
        If the extension is not supported.
    """
    return check_extension(path, SUFFIXES)


def write_traces(
    path: str | Path,
    extended_plane: ExtendedPlane,
    *,
    crs: str | None,
    model: str,
    force: bool,
    axes: Axes = WORLD_AXES,
) -> None:
    """Write traces as rows of vertices, or as a line layer with their maximum errors.

    The file is written completely or not at all.

    Parameters
    ----------
    path : str or Path
    extended_plane : ExtendedPlane
    crs : str or None
        CRS of the World frame.
    model : str
        Name of the model.
    force : bool
    axes : Axes
        Units and axes of the model.

    Raises
    ------
    UsageError, TargetError
    """
    _, error95 = table_columns(("bed", "error95_m"), is_metric=axes.metric)
    if format_from_path(path) == ".csv":
        write_bytes(path, _table(extended_plane, crs, model, axes).encode("utf-8"), force=force)
        return
    import shapely

    from vomstudio.io.gis.layer_writing import write_layer

    with atomic_group([Path(path)], force) as temporary_paths:
        write_layer(
            temporary_paths[0],
            LAYER_NAME,
            "LineString Z",
            np.array([shapely.LineString(trace.points) for trace in extended_plane.traces]),
            {
                "bed": np.array([trace.bed for trace in extended_plane.traces], np.int32),
                error95: np.array(
                    [float(trace.error95_m.max()) for trace in extended_plane.traces]
                ),
            },
            crs,
        )


def _table(extended_plane: ExtendedPlane, crs: str | None, model: str, axes: Axes) -> str:
    names = table_columns(COLUMNS, is_metric=axes.metric)
    file = io.StringIO()
    file.write(comment_line(f"VOM Studio {__version__}, a plane carried on over {model}"))
    file.write(comment_line(f"CRS: {crs or 'local'}; {axes.description}"))
    file.write(
        f"# plane {format_plain_azimuth(extended_plane.dip_direction_deg)}"
        f"/{extended_plane.dip_deg:.4f} "
        f"(dip direction/dip, deg); {names[-1]}: 95 % of its position, across it\n"
    )
    out = csv.writer(file, lineterminator="\n")
    out.writerow(names)
    for line, trace in enumerate(extended_plane.traces, 1):
        out.writerows(
            [trace.bed, line, f"{x:.6f}", f"{y:.6f}", f"{z:.6f}", f"{error:.6g}"]
            for (x, y, z), error in zip(trace.points.tolist(), trace.error95_m, strict=True)
        )
    return file.getvalue()
