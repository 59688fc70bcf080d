"""Models (meshes and point clouds) in the World frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from vomstudio.api.checking import array_points as to_points
from vomstudio.api.checking import (
    check_flag,
    is_path,
    numbers,
    optional_path,
    optional_text,
    require_valid_rows,
    to_path,
    warn,
    wrong_shape_error,
    wrong_type_error,
)
from vomstudio.api.frame_arguments import frame_options, name_frame_arguments_in_errors
from vomstudio.api.reporting import ProgressArgument, to_progress
from vomstudio.core.arrays import ByteArray, Float32Array, FloatArray, GenericArray, Int32Array
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.reprs import html_table, text_table
from vomstudio.geometry import cloud as clouds
from vomstudio.geometry import mesh as meshes
from vomstudio.geometry import transform
from vomstudio.geometry.units import Axes
from vomstudio.io.gate.frame_options import DEFAULT_FRAME, FrameOptions

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from vomstudio.api.argument_types import DataSetLike, VerticesArgument
    from vomstudio.geometry.registrations import Registration
    from vomstudio.io.models.reader import LoadedModel
    from vomstudio.project.records import Model
    from vomstudio.registration.results import RotationError
    from vomstudio.rendering.plots.datasets import MultiBlock, PolyData
    from vomstudio.rendering.plots.plotting import Plotter


@dataclass(frozen=True, eq=False)
class Source:
    """Source and placement of a model.

    Parameters
    ----------
    path : Path
    crs : str or None
        "EPSG:n" or WKT, or None for a local frame.
    unit_m : float
        Length of the unit of the CRS, metres.
    is_placed, is_metric : bool
        Whether the north direction and the unit of the model are known or declared.
    placing_error_m : float or None
        Position error of the whole model (one standard deviation along any direction),
        metres.
    to_world : (4, 4) float64
        Transformation matrix from the file frame to the World frame.
    registration : Registration or None
        Registration of the model, or None if its frame is stated.
    """

    path: Path
    crs: str | None
    warnings: tuple[Finding, ...] = ()
    unit_m: float = 1.0
    is_placed: bool = True
    is_metric: bool = True
    content_hash: str = ""
    placing_error_m: float | None = None
    to_world: FloatArray | None = None
    registration: Registration | None = None

    @property
    def world_crs(self) -> str | None:
        """CRS of the World frame, always in metres; None for a local frame."""
        from vomstudio.io.gis.crs import world_crs

        return world_crs(self.crs, self.unit_m)


@dataclass(frozen=True, eq=False, repr=False)
class _Model:
    """Common base class of meshes and clouds."""

    _data: Any
    _source: Source = field(repr=False)

    @property
    def path(self) -> Path:
        """Path of the file from which the model was read; "in memory" if there is no file."""
        return self._source.path

    @property
    def crs(self) -> str | None:
        """EPSG code (``"EPSG:n"``) or WKT of x and y, or None for a local frame."""
        return self._source.crs

    @property
    def warnings(self) -> tuple[Finding, ...]:
        """Messages issued while the model was read."""
        return self._source.warnings

    @property
    def bounds(self) -> FloatArray:
        """Minimum and maximum corners (2, 3) of the bounding box in the World frame, metres."""
        return np.array(self._data.bounds)

    @property
    def fields(self) -> Mapping[str, GenericArray]:
        """Additional fields (n,) of the points (such as intensity), by name."""
        return self._data.fields  # type: ignore[no-any-return]

    @property
    def colours(self) -> ByteArray | None:
        """Red, green and blue (n, 3) uint8 values of the points; None if missing."""
        return self._data.colors  # type: ignore[no-any-return]

    @property
    def rotation_error_deg(self) -> RotationError | None:
        """Standard deviations of the registered rotation about the up, east and north axes.

        The attributes ``about_up``, ``about_east`` and ``about_north`` are in degrees. None if
        the model was not registered or its errors are unknown.
        """
        from vomstudio.registration.results import RotationError

        registration = self._source.registration
        rotation = None if registration is None else registration.rotation_covariance()
        if rotation is None:
            return None
        east, north, up = np.degrees(np.sqrt(np.diag(rotation))).tolist()
        return RotationError(up, east, north)

    @property
    def scale_error_95(self) -> float | None:
        """Relative error (95 %) of the registered scale, or None if unknown."""
        registration = self._source.registration
        if registration is None or registration.scale_error is None:
            return None
        return 1.959963984540054 * registration.scale_error

    @cached_property
    def resolution_m(self) -> float | None:
        """Mean edge length of a mesh or mean spacing of a cloud, metres, or None if undefined."""
        from vomstudio.io.models.opening import resolution

        spacing = resolution(self._data)
        return spacing if np.isfinite(spacing) else None

    def save(self, path: str | Path, *, force: bool = False) -> Path:
        """Write the model with its textures, fields and CRS in the format of the suffix.

        Content that the format cannot store is reported in a Python warning. The registration is
        written next to the file as ``NAME.registration.json``.

        Parameters
        ----------
        path : str or Path
        force : bool
            Whether to replace an existing file.

        Returns
        -------
        Path
            Path of the written file.

        Raises
        ------
        vs.errors.UsageError
            If the suffix is unknown.
        vs.errors.GeometryError
            If coordinates are not finite.
        vs.errors.TargetError
            If the file exists or cannot be written.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> import vomstudio as vs
        >>> cliff = vs.read(vs.sample("sample.obj"))
        >>> copy = cliff.save(pathlib.Path(tempfile.mkdtemp()) / "cliff.glb")
        >>> vs.read(copy).faces.shape == cliff.faces.shape
        True
        """
        from vomstudio.geometry.registration_frames import change_file_frame
        from vomstudio.io.models.model_copy import companions
        from vomstudio.io.models.writing import write_model

        path = to_path(path, "path")
        force = check_flag(force, "force")
        data, registration = self._data, self._source.registration
        if registration is not None and self._source.to_world is not None:
            registration = change_file_frame(registration, self._source.to_world)
        if self._source.unit_m != 1.0 and self.crs is not None:
            data = transform_data(data, np.diag([*[1.0 / self._source.unit_m] * 3, 1.0]))
        inputs = [self.path, *companions(self.path)] if self.path.is_file() else []
        axes = Axes(self._source.is_metric, self._source.is_placed)
        warn(
            write_model(
                data,
                self.crs,
                path,
                force=force,
                inputs=inputs,
                axes=axes,
                registration=registration,
            )
        )
        return path

    def plot(self) -> Plotter:
        """Return a PyVista plotter that shows the model.

        In a program that runs Qt, the plotter is a pyvistaqt window. Otherwise it is an
        off-screen plotter, whose `show` returns a static image in a notebook and whose
        `screenshot` returns the pixels. Coordinates are World coordinates minus
        ``field_data["origin"]``.
        """
        from vomstudio.api.plots import create_plotter

        return create_plotter([self._data])

    def _repr_values(self) -> dict[str, Any]:
        low, high = self.bounds.tolist()
        return {
            "path": str(self.path),
            "from": ", ".join(f"{v:.3f}" for v in low),
            "to": ", ".join(f"{v:.3f}" for v in high),
            "crs": self.crs or "local",
            "warnings": self.warnings or None,
        }

    def __repr__(self) -> str:
        return text_table(type(self).__name__, self._repr_values())

    def _repr_html_(self) -> str:
        return html_table(type(self).__name__, self._repr_values())


@dataclass(frozen=True, eq=False, repr=False)
class Mesh(_Model):
    """Triangle mesh in the World frame (x East, y North, z Up, metres); see `vs.read`.

    Attributes
    ----------
    points
        (n, 3) float64; a vertex with two texture coordinates occurs twice.
    faces
        (m, 3) int32 row indices into `points`, grouped by material.
    materials
        Names of the materials.
    textures
        Texture files of the materials.
    uv
        (n, 2) float32 texture coordinates, origin at the lower left; None if missing.

    Examples
    --------
    >>> import vomstudio as vs
    >>> cliff = vs.read(vs.sample("sample.obj"))
    >>> low, high = cliff.bounds
    >>> (high - low).round().tolist()
    [30.0, 17.0, 15.0]
    >>> round(cliff.resolution_m, 2)
    0.12
    """

    @classmethod
    def from_arrays(
        cls, points: VerticesArgument, faces: ArrayLike, *, crs: str | None = None
    ) -> Mesh:
        """Create a mesh from arrays of its vertices and triangles.

        Parameters
        ----------
        points : (n, 3) array_like or DataFrame
            Vertices in the World frame, metres.
        faces : (m, 3) array_like of int
            Row indices into `points`, counter-clockwise seen from outside.
        crs : str, optional
            Projected CRS of x and y in metres, such as "EPSG:32633" (default: local).

        Returns
        -------
        Mesh

        Raises
        ------
        vs.errors.InputError
            If an array has another shape, or a face refers to a point that does not exist.
        vs.errors.UsageError
            If the CRS is not in metres.

        Examples
        --------
        >>> import vomstudio as vs
        >>> face = vs.Mesh.from_arrays([[0, 0, 0], [4, 0, 0], [0, 0, 3]], [[0, 1, 2]])
        >>> face.bounds.tolist()
        [[0.0, 0.0, 0.0], [4.0, 0.0, 3.0]]
        """
        vertices, rows = to_points(points), numbers(faces, "faces")
        if rows.ndim != 2 or rows.shape[1] != 3:
            raise wrong_shape_error(rows, "(m, 3)", "faces")
        is_invalid = (rows < 0) | (rows >= len(vertices)) | (rows != np.floor(rows))
        require_valid_rows(np.asarray(is_invalid.any(axis=1)), "faces", "array.no-such-point")
        return cls(meshes.Mesh(vertices, rows.astype(np.int32)), _create_memory_source(crs))

    @classmethod
    def from_pyvista(cls, mesh: DataSetLike, *, crs: str | None = None) -> Mesh:
        """Create a mesh from a PyVista data set or its blocks, without textures.

        Parameters
        ----------
        mesh : pyvista.DataSet or pyvista.MultiBlock
            Faces are divided into triangles. ``field_data["origin"]``, as `to_pyvista` writes it,
            is added to the points.
        crs : str, optional
            Projected CRS of x and y in metres, such as "EPSG:32633" (default: local).

        Returns
        -------
        Mesh

        Raises
        ------
        vs.errors.InputError
            If the data set has no faces.

        Examples
        --------
        >>> import pyvista
        >>> import vomstudio as vs
        >>> len(vs.Mesh.from_pyvista(pyvista.Plane(i_resolution=2, j_resolution=2)).faces)
        8
        """
        from vomstudio.rendering.plots.datasets import dataset_triangles

        if not hasattr(mesh, "field_data"):
            raise wrong_type_error(mesh, "pyvista.PolyData", "mesh")
        points, faces = dataset_triangles(mesh)
        if not len(faces):
            raise wrong_type_error(mesh, "pyvista.PolyData", "mesh")
        return cls.from_arrays(points, faces, crs=crs)

    @property
    def points(self) -> FloatArray:
        """Vertices (n, 3) float64 in the World frame, metres."""
        return self._data.vertices  # type: ignore[no-any-return]

    @property
    def faces(self) -> Int32Array:
        """Faces (m, 3) int32 as row indices into `points`."""
        return self._data.faces  # type: ignore[no-any-return]

    @property
    def materials(self) -> tuple[str, ...]:
        """Names of the materials, in the order of the faces."""
        return tuple(material.name for material in self._data.materials)

    @property
    def textures(self) -> tuple[Path, ...]:
        """Texture files, without duplicates."""
        files = (material.texture for material in self._data.materials)
        return tuple(dict.fromkeys(file for file in files if file is not None))

    @property
    def uv(self) -> Float32Array | None:
        """Texture coordinates (n, 2) float32; None if missing."""
        return self._data.uv  # type: ignore[no-any-return]

    def to_pyvista(self) -> PolyData | MultiBlock:
        """Convert to a pyvista.PolyData, or to a pyvista.MultiBlock with one block per material.

        Points are World coordinates minus an integer origin, which is stored in
        ``field_data["origin"]`` (3,). ``field_data["texture"]`` of a block contains the name of
        its image, and the texture coordinates of the block are active.

        >>> import vomstudio as vs
        >>> cliff = vs.read(vs.sample("sample.obj"))
        >>> blocks = cliff.to_pyvista()
        >>> len(blocks) == len(cliff.materials), blocks[0].field_data["origin"].shape
        (True, (3,))
        """
        from vomstudio.rendering.plots.datasets import local_origin, mesh_dataset

        return mesh_dataset(self._data, local_origin(self.bounds))

    def _repr_values(self) -> dict[str, Any]:
        figures = super()._repr_values()
        return {
            "path": figures.pop("path"),
            "points": len(self.points),
            "faces": len(self.faces),
            "materials": self.materials or None,
            **figures,
        }


@dataclass(frozen=True, eq=False, repr=False)
class PointCloud(_Model):
    """Point cloud in the World frame (x East, y North, z Up, metres); see `vs.read`.

    Attributes
    ----------
    points
        (n, 3) float64.
    colours
        (n, 3) uint8 RGB values; None if missing.
    normals
        (n, 3) float32 unit vectors; None if missing.
    fields
        Additional fields (n,) by name.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> import numpy as np
    >>> import vomstudio as vs
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "points.xyz"
    >>> np.savetxt(path, [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])
    >>> vs.read(path, up="z", unit="cm").bounds.tolist()
    [[0.0, 0.0, 0.0], [0.01, 0.01, 0.0]]
    """

    @property
    def points(self) -> FloatArray:
        """Points (n, 3) float64 in the World frame, metres."""
        return self._data.points  # type: ignore[no-any-return]

    @property
    def normals(self) -> Float32Array | None:
        """Unit normals (n, 3) float32; None if missing."""
        return self._data.normals  # type: ignore[no-any-return]

    def to_pyvista(self) -> PolyData:
        """Convert to a pyvista.PolyData with colours, normals and fields.

        Points are World coordinates minus an integer origin, which is stored in
        ``field_data["origin"]`` (3,).
        """
        from vomstudio.rendering.plots.datasets import cloud_dataset, local_origin

        return cloud_dataset(self._data, local_origin(self.bounds))

    def _repr_values(self) -> dict[str, Any]:
        figures = super()._repr_values()
        return {
            "path": figures.pop("path"),
            "points": len(self.points),
            "fields": tuple(self.fields) or None,
            **figures,
        }


def read(
    path: str | Path,
    *,
    crs: str | None = None,
    up: Literal["y", "z"] | None = None,
    unit: str | None = None,
    to_crs: str | None = None,
    project: str | Path | None = None,
    progress: ProgressArgument = None,
) -> Mesh | PointCloud:
    """Read a model from OBJ, GLB/glTF, PLY, STL, LAS/LAZ, GeoTIFF or text (x, y, z).

    Parameters
    ----------
    path : str or Path
        File of the model.
    crs : str, optional
        Projected CRS of x and y, such as "EPSG:32633". By default, the CRS stated in the
        file is used.
    up : {"y", "z"}, optional
        Axis of the file that points up. If None, the default of the format is used.
    unit : str, optional
        Unit of the coordinates: m, cm, mm, km, ft or us-ft.
    to_crs : str, optional
        Projected CRS in metres to which the coordinates are converted.
    project : str or Path, optional
        Folder of a project that contains this file. The registration or declared frame from
        the project is used instead of `crs`, `up` and `unit`. The project may be open in a
        window.
    progress : callable or Progress, optional
        Called with (stage, completed steps, total steps or None).

    Returns
    -------
    Mesh or PointCloud
        Mesh or PointCloud in the World frame. If the file does not state its frame, a local
        frame in metres with z up and y to the north is assumed; this is reported in a Python
        warning and in ``.warnings``. A registration next to the file
        (``NAME.registration.json``, or ``reconstruction.json`` of a reconstruction) places
        the model and provides ``rotation_error_deg`` and ``scale_error_95``.

    Raises
    ------
    vs.errors.InputError
        If the file is missing or damaged, or its format is unknown.
    vs.errors.UsageError
        If the CRS, axis or unit is invalid, or the project does not contain the model.

    Examples
    --------
    >>> import vomstudio as vs
    >>> cliff = vs.read(vs.sample("sample.obj"))
    >>> cliff.points.shape[1], cliff.faces.shape[1], cliff.crs
    (3, 3, 'EPSG:32633')
    """
    from vomstudio.studio.world_models import check_frame_source

    file, folder = to_path(path, "path"), optional_path(project, "project")
    options = frame_options(crs, up, unit, to_crs)
    report = to_progress(progress)
    if folder is None:
        with name_frame_arguments_in_errors():
            model = _read(file, options, report)
    else:
        check_frame_source(options, folder)
        model = _read_project_model(file, folder, report)
    warn(model.warnings, notes=True)
    return model


def to_model(value: Any, name: str = "model") -> Mesh | PointCloud:
    """Return a model, reading or converting it if necessary.

    Parameters
    ----------
    value : object
        Model, model of a project, path, (n, 3) array, DataFrame or data set of PyVista.
    name : str, optional
        Name of the argument.

    Returns
    -------
    Mesh or PointCloud

    Raises
    ------
    InputError
        If the value is of another type, or the file cannot be read.
    """
    if isinstance(value, Mesh | PointCloud):
        return value
    if isinstance(value, np.ndarray) or hasattr(value, "columns"):
        return PointCloud(clouds.PointCloud(to_points(value, name)), _create_memory_source(None))
    if hasattr(value, "field_data"):
        from vomstudio.rendering.plots.datasets import dataset_triangles

        points, faces = dataset_triangles(value)
        return Mesh.from_arrays(points, faces) if len(faces) else to_model(points, name)
    if hasattr(value, "read") and hasattr(value, "id"):
        model: Mesh | PointCloud = value.read()
        return model
    if not is_path(value):
        raise wrong_type_error(
            value, "Mesh, PointCloud, numpy.ndarray, pyvista.PolyData, str, pathlib.Path", name
        )
    model = _read(to_path(value, name), DEFAULT_FRAME, None)
    warn(model.warnings, 4, notes=True)
    return model


def _create_memory_source(crs: str | None) -> Source:
    """Return the source of a model that was not read from a file."""
    name = optional_text(crs, "crs")
    if name is not None:
        from vomstudio.io.gis.crs import metric_crs

        name = metric_crs(name, "crs")
    return Source(Path("in memory"), name)


def _read(path: Path, options: FrameOptions, progress: Progress | None) -> Mesh | PointCloud:
    from vomstudio.io.models.frames import establish_frame
    from vomstudio.io.models.opening import read_model
    from vomstudio.io.models.reconstruction_file import placing_error_m
    from vomstudio.io.photos.cameras_file import has_known_scale

    loaded_model = read_model(path, progress, options)
    frame_result = establish_frame(loaded_model, options)
    frame = frame_result.frame
    registration = frame_result.registration
    is_unknown = frame.crs is None and has_known_scale(loaded_model.path) is False
    source = Source(
        loaded_model.path,
        frame.crs,
        (*loaded_model.warnings, *frame_result.findings),
        frame.unit_m if frame.crs is not None else 1.0,
        not is_unknown if registration is None else frame.has_north,
        options.unit is not None if registration is None else frame.has_metres,
        loaded_model.content_hash,
        placing_error_m(loaded_model.path),
    )
    model = to_public_model(loaded_model.data, frame_result.to_world(), source)
    return model if registration is None else set_registration(model, registration)


def set_registration(model: Mesh | PointCloud, registration: Registration) -> Mesh | PointCloud:
    """Return a copy of a model with the given registration.

    Parameters
    ----------
    model : Mesh or PointCloud
    registration : Registration

    Returns
    -------
    Mesh or PointCloud
    """
    error = registration.placing_error_m(model.bounds)
    source = replace(model._source, placing_error_m=error, registration=registration)
    return replace(model, _source=source)


def _read_project_model(path: Path, project: Path, progress: Progress | None) -> Mesh | PointCloud:
    from vomstudio.io.models.opening import read_model
    from vomstudio.studio.world_models import find_project_model

    loaded_model = read_model(path, progress)
    return apply_recorded_placement(loaded_model, find_project_model(project, loaded_model))


def apply_recorded_placement(loaded_model: LoadedModel, record: Model) -> Mesh | PointCloud:
    """Return a model with the placement stored in its record.

    Parameters
    ----------
    loaded_model : LoadedModel
    record : Model

    Returns
    -------
    Mesh or PointCloud
    """
    frame = record.frame
    scale = frame.unit_m if frame.crs is not None and record.registration is None else 1.0
    source = Source(
        loaded_model.path,
        frame.crs,
        loaded_model.warnings,
        scale,
        frame.has_north,
        frame.has_metres,
        loaded_model.content_hash,
    )
    model = to_public_model(loaded_model.data, np.array(record.to_world), source)
    return model if record.registration is None else set_registration(model, record.registration)


def to_public_model(
    data: meshes.Mesh | clouds.PointCloud, to_world: Any, source: Source
) -> Mesh | PointCloud:
    """Convert the data of a file to a public model in the World frame.

    Parameters
    ----------
    data : Mesh or PointCloud
    to_world : (4, 4) array_like
        Similarity from the file frame to the World frame.
    source : Source

    Returns
    -------
    Mesh or PointCloud
    """
    model_class = Mesh if isinstance(data, meshes.Mesh) else PointCloud
    matrix = np.asarray(to_world, np.float64)
    return model_class(transform_data(data, matrix), replace(source, to_world=matrix))


def transform_data(
    data: meshes.Mesh | clouds.PointCloud, matrix: FloatArray
) -> meshes.Mesh | clouds.PointCloud:
    """Transform a mesh or cloud by a similarity.

    Parameters
    ----------
    data : Mesh or PointCloud
    matrix : (4, 4) ndarray

    Returns
    -------
    Mesh or PointCloud
    """
    if np.array_equal(matrix, np.eye(4)):
        return data
    if isinstance(data, meshes.Mesh):
        return replace(data, vertices=transform.apply(matrix, data.vertices))
    normals = data.normals
    if normals is not None:
        normals = transform.rotate(matrix, normals).astype(np.float32)
    return replace(
        data, points=transform.apply(matrix, data.points), normals=normals, arrangement=None
    )
