"""Opening and description of model files of any format."""

from __future__ import annotations

import hashlib
import itertools
import os
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.memory_limit import limit_for_file
from vomstudio.core.files.regular import open_regular_file
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.threads import run_in_thread
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.model_transform import transform_model
from vomstudio.geometry.resolution import (
    NEIGHBOUR_COUNTS,
    NeighbourTree,
    SmallPointTree,
    effective_resolution,
    resolving_points,
)
from vomstudio.geometry.units import METRES_PER_UNIT
from vomstudio.io.gate.axes import choose_axes, crs_reading_finding, require_crs
from vomstudio.io.gate.frame_options import DEFAULT_FRAME, FrameOptions
from vomstudio.io.gate.reprojection import Reprojection
from vomstudio.io.gis.axis_units import (
    UNKNOWN_UNITS,
    StatedAxes,
    axes_problem,
    unit_findings,
)
from vomstudio.io.gis.crs import sidecar_crs
from vomstudio.io.models.frames import frame_findings
from vomstudio.io.models.reader import LoadedModel
from vomstudio.io.models.registry import choose_reader, read_head
from vomstudio.io.photos.cameras_file import has_known_scale

HASH_BLOCK_BYTES = 4 * 1024 * 1024
MAX_SAMPLED_FACES = 200_000
MAX_SAMPLED_POINTS = 20_000
MAX_SAMPLED_LOCATIONS = 1_000
WINDOW_COUNT = 16
MAX_POINTS_WITHOUT_TREE = 300
MAX_WINDOW_POINTS_WITHOUT_TREE = 40_000
MAX_FIELDS = 300


def read_model(
    path: str | Path, progress: Progress | None = None, options: FrameOptions = DEFAULT_FRAME
) -> LoadedModel:
    """Read a model from a file of any supported format.

    Damaged parts of the file are omitted and reported in `warnings`. If neither the options nor the
    file state a CRS, that in `NAME.prj` next to the file is used. x, y and z have the same unit,
    that of the horizontal axes of the CRS, or metres in a local CRS: heights in another unit are
    converted, which is reported. `content_hash` is the SHA-256 of the file itself; for an OBJ file,
    the MTL and images are not included because measurements depend only on the geometry.

    Parameters
    ----------
    path : str or Path
    progress : Progress, optional
    options : FrameOptions
        Frame options. Their CRS replaces that of the file; with `to_crs`, the coordinates are
        converted.

    Raises
    ------
    InputError
        If the file cannot be read, or if its axes cannot be used for a model (such as degrees)
        and are not converted.
    UsageError
        If an option is not valid or contradicts the file.
    Cancelled
        If the user cancels through `progress`.
    """
    loaded_model, refusal_finding = convert_axes(_read(Path(path), progress), options)
    if refusal_finding is not None:
        raise InputError(refusal_finding, file=path, field="CRS")
    return loaded_model


def _read(path: Path, progress: Progress | None) -> LoadedModel:
    """Return the model as the reader of its format returns it, with the hash of the file.

    Raises InputError if the file cannot be read.
    """
    progress = progress or SilentProgress()
    reader = choose_reader(path, read_head(path))
    stop_event = threading.Event()
    # hashlib releases the GIL, and the file is read only once while it is in memory.
    content_hash = run_in_thread(file_hash, path, lambda: not stop_event.is_set(), name="file hash")
    try:
        # Damaged files contain NaN values of every kind; readers check for them.
        with np.errstate(all="ignore"), limit_for_file(path):
            loaded_model = reader.read(path, progress)
    except MemoryError:
        stop_event.set()
        raise InputError(Finding("file.exceeds-memory"), file=path) from None
    except BaseException:
        stop_event.set()
        raise
    loaded_model = _limit_fields(loaded_model)
    return replace(
        loaded_model, path=path, content_hash=loaded_model.content_hash or content_hash.result()
    )


def _limit_fields(loaded_model: LoadedModel) -> LoadedModel:
    """Limit the number of fields because each becomes a file in the cache of the project."""
    fields = loaded_model.data.fields
    if len(fields) <= MAX_FIELDS:
        return loaded_model
    finding = Finding("model.fields-limited", count=len(fields), limit=MAX_FIELDS)
    remaining_fields = dict(itertools.islice(fields.items(), MAX_FIELDS))
    return replace(
        loaded_model,
        data=replace(loaded_model.data, fields=remaining_fields),
        warnings=(*loaded_model.warnings, finding),
    )


def file_hash(path: Path, is_needed: Callable[[], bool] = lambda: True) -> str:
    """Compute the SHA-256 of a file in hex, stopping early if it is no longer needed.

    Raises InputError if the file cannot be read.
    """
    hasher = hashlib.sha256()
    try:
        with open_regular_file(path) as file:
            while is_needed() and (block := file.read(HASH_BLOCK_BYTES)):
                hasher.update(block)
    except OSError as error:
        raise InputError(Finding("file.unreadable", reason=error.strerror), file=path) from error
    return hasher.hexdigest()


def resolution(data: Mesh | PointCloud) -> float:
    """Return the effective resolution in file units.

    The resolution is the largest of the mean spacing, the noise (see `geometry.resolution`;
    duplicate points count once) and the mean edge length of a mesh; for a subdivided mesh, it is
    that of the original mesh. Large models are sampled: every k-th face, and all points in windows
    around points distributed over the file. The result is NaN for a single point.
    """
    points = resolving_points(data)
    if not isinstance(data, Mesh):
        return _cloud_resolution(points)
    edge = point_spacing(data.undivided)
    point_resolution = (
        _cloud_resolution(points)
        if len(points) <= MAX_POINTS_WITHOUT_TREE
        else _resolution_in_windows(points, edge)
    )
    # A few vertices determine neither density nor noise.
    has_few_vertices = len(data.undivided.vertices) < NEIGHBOUR_COUNTS[0]
    return edge if has_few_vertices or np.isnan(point_resolution) else max(edge, point_resolution)


def point_spacing(data: Mesh | PointCloud) -> float:
    """Return the size at which drawn points touch each other, in file units.

    This is the mean edge length of a mesh or the mean nearest-neighbour distance of a cloud; NaN if
    it is not defined.
    """
    if isinstance(data, Mesh):
        step = max(1, len(data.faces) // MAX_SAMPLED_FACES)
        corners = data.vertices[data.faces[::step]]
        edges = corners - np.roll(corners, 1, axis=1)
        lengths = np.sqrt(np.einsum("ijk,ijk->ij", edges, edges))
        return float(lengths[lengths > 0].mean()) if np.any(lengths > 0) else float("nan")
    return _point_spacing(data.points)


def _point_spacing(points: FloatArray) -> float:
    n = len(points)
    if n < 2:
        return float("nan")
    if n <= MAX_POINTS_WITHOUT_TREE:
        return _mean_nearest_distance(_brute_force_distances(points - points[0]))
    from scipy.spatial import cKDTree

    if n <= 10 * MAX_SAMPLED_POINTS:
        local_points = points - points[0]
        return _mean_spacing(
            cKDTree(local_points), local_points[:: max(1, n // MAX_SAMPLED_POINTS)]
        )
    rough_spacing = _rough_spacing(points)
    if not np.isfinite(rough_spacing) or rough_spacing <= 0:
        return float("nan")
    half_width = 15.0 * rough_spacing
    window_distances: list[FloatArray] = []
    for local_points in _windows(points, half_width):
        inner_points = local_points[(np.abs(local_points) <= 0.6 * half_width).all(axis=1)]
        distance, _ = cKDTree(local_points).query(inner_points, k=min(4, len(local_points)))
        window_distances.append(_first_positive(distance))
    distances = np.concatenate(window_distances) if window_distances else np.empty(0)
    distances = distances[np.isfinite(distances)]
    return float(distances.mean()) if len(distances) else float(rough_spacing)


def _windows(points: FloatArray, half_width: float) -> Iterator[FloatArray]:
    """Yield the points in boxes around some points of the cloud, relative to these points.

    `half_width` is half the side length of a box. Boxes with a single point are skipped.
    """
    # A contiguous copy can be scanned several times faster for every window.
    x = np.ascontiguousarray(points[:, 0])
    for row in np.linspace(0, len(points) - 1, WINDOW_COUNT).astype(np.int64):
        centre = points[row]
        candidates = np.flatnonzero((x >= centre[0] - half_width) & (x <= centre[0] + half_width))
        local_points = points[candidates] - centre
        local_points = local_points[(np.abs(local_points[:, 1:]) <= half_width).all(axis=1)]
        if len(local_points) > 1:
            yield local_points


def _rough_spacing(points: FloatArray) -> float:
    """Estimate the spacing from a thinned cloud.

    The points are on a surface, so the spacing scales with the square root of their number.
    """
    from scipy.spatial import cKDTree

    step = len(points) // MAX_SAMPLED_POINTS
    thinned_points = np.ascontiguousarray(points[::step]) - points[0]
    return float(_mean_spacing(cKDTree(thinned_points), thinned_points) / np.sqrt(step))


def _cloud_resolution(points: FloatArray) -> float:
    n = len(points)
    if n < 2:
        return float("nan")
    if n <= MAX_POINTS_WITHOUT_TREE:
        local_points = points - points[0]
        resolution_of_points = effective_resolution(
            local_points, SmallPointTree(local_points), local_points
        )
        return float("nan") if resolution_of_points is None else resolution_of_points
    from scipy.spatial import cKDTree

    if n <= 10 * MAX_SAMPLED_POINTS:
        local_points = points - points[0]
        resolution_of_points = effective_resolution(
            local_points, cKDTree(local_points), local_points[:: max(1, n // MAX_SAMPLED_LOCATIONS)]
        )
        return float("nan") if resolution_of_points is None else resolution_of_points
    return _resolution_in_windows(points, _rough_spacing(points))


def _resolution_in_windows(points: FloatArray, spacing: float) -> float:
    """Return the median resolution in windows of 60 spacings around some points.

    Returns NaN if the spacing is not valid, and the spacing if no window has a resolution.
    """
    if not np.isfinite(spacing) or spacing <= 0:
        return float("nan")
    # A few thousand points, of which the inner ones have all their neighbours.
    half_width = 30.0 * spacing
    resolutions = []
    for local_points in _windows(points, half_width):
        inner_points = local_points[(np.abs(local_points) <= 0.4 * half_width).all(axis=1)]
        inner_points = inner_points[
            :: max(1, len(inner_points) // (MAX_SAMPLED_LOCATIONS // WINDOW_COUNT))
        ]
        window_resolution = effective_resolution(
            local_points, _window_tree(local_points), inner_points
        )
        if window_resolution is not None:
            resolutions.append(window_resolution)
    return float(np.median(resolutions)) if resolutions else float(spacing)


def _window_tree(local_points: FloatArray) -> NeighbourTree:
    if len(local_points) <= MAX_WINDOW_POINTS_WITHOUT_TREE:
        return SmallPointTree(local_points)
    from scipy.spatial import cKDTree

    tree: NeighbourTree = cKDTree(local_points)
    return tree


def _mean_spacing(tree: object, queries: FloatArray) -> float:
    k = min(4, tree.n)  # type: ignore[attr-defined]
    distance, _ = tree.query(queries, k=k)  # type: ignore[attr-defined]
    return _mean_nearest_distance(distance)


def _brute_force_distances(local_points: FloatArray) -> FloatArray:
    """Compute the four smallest distances from each point, including that to itself.

    They are those that a k-d tree would return, without the slow import of scipy.
    """
    x, y, z = (local_points[:, None, j] - local_points[None, :, j] for j in range(3))
    return np.sort(np.sqrt(x * x + y * y + z * z), axis=1)[:, :4]


def _mean_nearest_distance(distance: FloatArray) -> float:
    nearest_distance = _first_positive(distance)
    nearest_distance = nearest_distance[np.isfinite(nearest_distance)]
    return float(nearest_distance.mean()) if len(nearest_distance) else float("nan")


def _first_positive(distance: FloatArray) -> FloatArray:
    """Return the distance to the nearest distinct neighbour; NaN if all distances are 0."""
    is_positive = distance > 0
    nearest_distance = distance[np.arange(len(distance)), is_positive.argmax(axis=1)]
    return np.where(is_positive.any(axis=1), nearest_distance, np.nan)


def convert_axes(
    loaded_model: LoadedModel, options: FrameOptions = DEFAULT_FRAME
) -> tuple[LoadedModel, Finding | None]:
    """Determine the CRS of a model and convert x, y and z to the same unit.

    With `to_crs` in the options, the coordinates are converted to that CRS.

    Returns
    -------
    loaded : LoadedModel
    refusal_finding : Finding or None
        Reason why the data cannot be used as a model, or None.
    """
    findings: list[Finding] = list(loaded_model.warnings)
    axes = _axes(loaded_model, options, findings)
    if axes.kind == "none" and loaded_model.units != UNKNOWN_UNITS:
        axes = replace(
            axes, units=loaded_model.units, unit_m=METRES_PER_UNIT.get(loaded_model.units[0])
        )
    if options.to_crs is not None and not axes.unusual_directions:
        return _reproject(loaded_model, axes, options, findings), None
    refusal_finding = axes_problem(axes, loaded_model.data.bounds)
    findings += unit_findings(axes) if refusal_finding is None else ()
    has_crs = axes.kind not in ("none", "local") and refusal_finding is None
    if axes.crs is None and has_crs and not axes.unusual_directions:
        findings.append(crs_reading_finding(loaded_model.path, loaded_model.crs or axes.kind))
    data = _scale(loaded_model.data, axes)
    unit_m = 1.0 if axes.kind == "local" and axes.unit_m else axes.unit_m
    converted_model = replace(
        loaded_model,
        data=data,
        crs=axes.crs,
        warnings=tuple(findings),
        units=axes.units,
        unit_m=unit_m,
    )
    return converted_model, refusal_finding


def _axes(loaded_model: LoadedModel, options: FrameOptions, findings: list[Finding]) -> StatedAxes:
    """Return the axes according to the options, or else the file, or else its .prj file."""
    text = loaded_model.crs
    if text is None:
        text, problem = sidecar_crs(
            loaded_model.path, np.asarray(loaded_model.data.bounds, np.float64)
        )
        if problem is not None and options.crs is None:
            findings.append(problem)
    axes, axis_findings = choose_axes(
        text, options, file=loaded_model.path, height_unit=loaded_model.height_unit
    )
    findings += axis_findings
    return axes


def _reproject(
    loaded_model: LoadedModel, axes: StatedAxes, options: FrameOptions, findings: list[Finding]
) -> LoadedModel:
    """Return the model with its coordinates converted to another CRS, in metres."""
    assert options.to_crs is not None
    reprojection = Reprojection.create(
        require_crs(axes, loaded_model.path), options.to_crs, height_factor=axes.metres[2]
    )
    data, turned_about = loaded_model.data, loaded_model.turned_about
    if options.up == "y" and turned_about is None:
        data, turned_about = transform_model(data, Frame(up_axis="y").to_world()), (0.0, 0.0, 0.0)
    if isinstance(data, Mesh):
        data = replace(data, vertices=reprojection.apply(data.vertices))
    else:
        normals = data.normals
        if normals is not None:
            # A normal is perpendicular to the surface, so it is transformed by the inverse
            # transpose.
            centre = np.asarray(data.bounds, np.float64).mean(axis=0)
            normals = normals @ np.linalg.inv(reprojection.jacobian(centre))
            normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
            normals = np.ascontiguousarray(normals, np.float32)
        points = reprojection.apply(data.points)
        data = replace(data, points=points, normals=normals, arrangement=None)
    findings.append(reprojection.finding)
    return replace(
        loaded_model,
        data=data,
        crs=reprojection.target,
        warnings=tuple(findings),
        units=axes.units,
        unit_m=1.0,
        turned_about=turned_about,
    )


def _scale(data: Mesh | PointCloud, axes: StatedAxes) -> Mesh | PointCloud:
    """Scale heights to the unit of x and y, and for a local CRS all axes to metres."""
    horizontal_factor, height_factor = axes.unit_factor, axes.unit_factor * axes.height_factor
    if horizontal_factor == height_factor == 1.0:
        return data
    factors = np.array([horizontal_factor, horizontal_factor, height_factor])
    if isinstance(data, Mesh):
        return replace(data, vertices=data.vertices * factors)
    normals = data.normals
    if normals is not None and horizontal_factor != height_factor:
        # The normal of a plane that is stretched along z is scaled by the inverse factor.
        stretched_normals = normals / factors
        length = np.sqrt(np.einsum("ij,ij->i", stretched_normals, stretched_normals))[:, None]
        normals = np.where(
            length > 0, stretched_normals / np.where(length > 0, length, 1.0), normals
        )
        normals = np.ascontiguousarray(normals, np.float32)
    return replace(data, points=data.points * factors, normals=normals, arrangement=None)


def describe(
    path: str | Path, progress: Progress | None = None, options: FrameOptions = DEFAULT_FRAME
) -> dict[str, object]:
    """Return the values of the `info` command for a model as plain data for JSON.

    `points` is the number of vertices that the surface of a mesh requires (a vertex with two
    texture coordinates counts twice). `bounds` is in metres if the unit of x and y is known (World
    frame), otherwise as in the file; `units` contains the units of the file. Raises InputError.
    """
    loaded_model, refusal_finding = convert_axes(_read(Path(path), progress), options)
    data = loaded_model.data
    spacing = resolution(data)
    mesh = data if isinstance(data, Mesh) else None
    fields = list(data.fields)
    if data.colors is not None:
        fields.insert(0, "rgb")
    if isinstance(data, PointCloud) and data.normals is not None:
        fields.insert(0, "normals")
    frame_warnings = [refusal_finding] if refusal_finding else frame_findings(loaded_model, options)
    units, metres = loaded_model.units, loaded_model.unit_m
    if units == UNKNOWN_UNITS and has_known_scale(loaded_model.path):
        units, metres = ("m", "m", "m"), 1.0
    spacing_or_none = spacing if np.isfinite(spacing) else None
    resolution_values: dict[str, float | None] = {
        "resolution_m": None,
        "resolution": spacing_or_none,
    }
    if metres:
        resolution_values = {
            "resolution_m": None if spacing_or_none is None else spacing_or_none * metres
        }
    return {
        "path": os.fspath(loaded_model.path),
        "kind": loaded_model.kind,
        "points": len(mesh.vertices) if mesh else len(data.points),  # type: ignore[union-attr]
        "faces": len(mesh.faces) if mesh else 0,
        "materials": [material.name for material in mesh.materials] if mesh else [],
        "textures": [
            os.fspath(texture)
            for texture in dict.fromkeys(material.texture for material in mesh.materials)
            if texture is not None
        ]
        if mesh
        else [],
        "bounds": (data.bounds * (metres or 1.0)).tolist(),
        "crs": loaded_model.crs,
        "units": list(units),
        **resolution_values,
        "fields": fields,
        "warnings": [*loaded_model.warnings, *frame_warnings],
        "content_hash": loaded_model.content_hash,
    }
