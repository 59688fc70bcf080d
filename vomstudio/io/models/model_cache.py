"""Models stored as folders of .npy files, to transfer arrays from a worker to the window.

A folder is written under a temporary name and renamed, so it is either complete or absent. It may
be deleted at any time and is never trusted: data that are inconsistent or do not match their source
are read again from the source. The folder is in the project, possibly on a removable drive. Files
that shrink or vanish while mapped end the process, so they are read into memory and not mapped.
"""

from __future__ import annotations

import contextlib
import io
import json
import math
import os
import shutil
import tempfile
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import AnyArray
from vomstudio.core.errors import InputError, TargetError
from vomstudio.core.files.containment import make_folder
from vomstudio.core.files.disk_errors import failure_reason
from vomstudio.core.files.regular import open_unbuffered, read_json
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.threads import thread_pool
from vomstudio.core.words import tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Material, Mesh
from vomstudio.geometry.progressive_order import ProgressiveOrder, arrange
from vomstudio.io.gis.axis_units import Units
from vomstudio.io.gis.crs import sidecar_path
from vomstudio.io.models import image_store
from vomstudio.io.models.offset_file import offset_path, parse_origin
from vomstudio.io.models.opening import file_hash, read_model, resolution
from vomstudio.io.models.reader import LoadedModel

VERSION = 5
META_FILE = "meta.json"
TRANSFER_PREFIX = "vomstudio-model-"
"""Prefix of temporary folders that contain a model in transfer between processes."""
_SIDECARS = {"offset_mtime_ns": offset_path, "prj_mtime_ns": sidecar_path}
"""Files next to a model that shift or scale its coordinates."""
BLOCK_BYTES = 64 << 20
_ORDER_FIELDS = ("rows", "starts", "bounds", "spacing", "parents")


def save(loaded_model: LoadedModel, folder: Path) -> LoadedModel:
    """Write a loaded model to `folder`, replacing an existing folder.

    Returns the model that `open_cache_folder` would return.

    Raises TargetError.
    """
    folder = Path(folder)
    data = loaded_model.data
    arrays: dict[str, AnyArray] = {}
    materials: list[dict[str, object]] = []
    if isinstance(data, Mesh):
        arrays = {
            "vertices": data.vertices,
            "faces": data.faces,
            "material_offsets": data.material_offsets,
        }
        if data.uv is not None:
            arrays["uv"] = data.uv
        materials = [_material_values(material) for material in data.materials]
    else:
        arrays = {"points": data.points}
        if data.normals is not None:
            arrays["normals"] = data.normals
    if data.colors is not None:
        arrays["colors"] = data.colors
    fields = list(data.fields)
    for i, name in enumerate(fields):
        arrays[f"field_{i}"] = data.fields[name]
    meta: dict[str, object] = {
        "version": VERSION,
        "kind": loaded_model.kind,
        "crs": loaded_model.crs,
        "warnings": [warning.to_dict() for warning in loaded_model.warnings],
        "path": os.fspath(Path(loaded_model.path).absolute()),
        "content_hash": loaded_model.content_hash,
        "materials": materials,
        "fields": fields,
        "turned_about": loaded_model.turned_about,
        "units": list(loaded_model.units),
        "unit_m": loaded_model.unit_m,
        **_file_stamp(loaded_model.path),
    }
    try:
        make_folder(folder.parent)
        draft = Path(tempfile.mkdtemp(prefix=f".{folder.name}.", dir=folder.parent))
    except OSError as error:
        raise _writing_error(folder, error) from error
    try:
        # The computation takes as long as the writing and runs in parallel with it.
        with thread_pool(2) as pool:
            spacing_future = pool.submit(resolution, data)
            order_future = pool.submit(_point_order, data)
            _write(draft, arrays)
            arrangement = order_future.result()
            order_arrays = {} if arrangement is None else _get_order_arrays(arrangement)
            _write(draft, order_arrays)
            spacing_value = spacing_future.result()
        arrays |= order_arrays
        meta["arrays"] = {
            n: {"shape": list(array.shape), "dtype": array.dtype.str} for n, array in arrays.items()
        }
        spacing_or_none = spacing_value if spacing_value == spacing_value else None
        meta["resolution"] = spacing_or_none
        (draft / META_FILE).write_text(json.dumps(meta), encoding="utf-8")
        _replace_folder(draft, folder)
    except OSError as error:
        raise _writing_error(folder, error) from error
    finally:
        shutil.rmtree(draft, ignore_errors=True)
    if isinstance(data, PointCloud):
        data = replace(data, arrangement=arrangement)
    source = Path(loaded_model.path).absolute()
    return replace(
        loaded_model, data=data, path=source, resolution=spacing_or_none, height_unit=None
    )


def _writing_error(folder: Path, error: OSError) -> TargetError:
    return TargetError(
        Finding("model.cache-unwritable", reason=failure_reason(folder.parent, error)), file=folder
    )


def _material_values(material: Material) -> dict[str, object]:
    texture = None if material.texture is None else os.fspath(material.texture)
    return {"name": material.name, "texture": texture, "diffuse": material.diffuse}


def _point_order(data: Mesh | PointCloud) -> ProgressiveOrder | None:
    return None if isinstance(data, Mesh) else data.arrangement or arrange(data.points)


def _get_order_arrays(order: ProgressiveOrder) -> dict[str, AnyArray]:
    return {f"order_{name}": getattr(order, name) for name in _ORDER_FIELDS}


def _write(folder: Path, arrays: dict[str, AnyArray]) -> None:
    for name, array in arrays.items():
        with open(folder / f"{name}.npy", "wb") as file:
            np.save(file, np.ascontiguousarray(array), allow_pickle=False)


def _replace_folder(draft: Path, folder: Path) -> None:
    """Replace an old folder by renaming; on POSIX, readers of the old one keep its files."""
    if folder.exists():
        old_folder = Path(tempfile.mkdtemp(prefix=f".{folder.name}.old.", dir=folder.parent))
        os.rename(folder, old_folder / "old")
        try:
            os.rename(draft, folder)
        finally:
            shutil.rmtree(old_folder, ignore_errors=True)
    else:
        os.rename(draft, folder)


def _file_stamp(path: Path) -> dict[str, object]:
    """Return the size and times with which changes of a file and its sidecars are detected."""
    file_stamp: dict[str, object] = dict.fromkeys(("size", "mtime_ns", *_SIDECARS))
    with contextlib.suppress(OSError):
        status = os.stat(path)
        file_stamp |= {"size": status.st_size, "mtime_ns": status.st_mtime_ns}
    for name, get_path in _SIDECARS.items():
        with contextlib.suppress(OSError):
            file_stamp[name] = os.stat(get_path(path)).st_mtime_ns
    return file_stamp


def _has_missing_image(meta: dict[str, Any]) -> bool:
    """Return whether an image extracted from the model file is missing from the cache."""
    store = os.fspath(image_store.folder())
    textures = [material.get("texture") for material in meta["materials"]]
    return any(
        texture and texture.startswith(store) and not os.path.isfile(texture)
        for texture in textures
    )


def open_cache_folder(folder: Path) -> LoadedModel:
    """Return the model in a cache folder, with its arrays in memory and read-only.

    Shapes, types, file sizes and face indices are checked; missing images are dropped with a
    warning. Raises InputError if the folder cannot be used, in which case the model file itself has
    to be read.
    """
    folder = Path(folder)
    meta = _read_meta(folder)
    try:
        return _open_folder(folder, meta)
    except InputError:
        raise
    except (OSError, EOFError, ValueError, TypeError, LookupError, AttributeError) as error:
        raise _damage_error(folder, str(error)) from error


def cache_folder(path: Path, cache: Path) -> Path:
    """Return the cache folder of the model at `path`."""
    return cache / f"model-{sha256(str(path).encode()).hexdigest()[:16]}"


def load(path: Path, folder: Path, progress: Progress | None = None) -> LoadedModel:
    """Return the model at `path` from the cache in `folder`, which is updated if outdated.

    The cache is valid if the sidecar files are unchanged and the file has the same size and time,
    or otherwise the same SHA-256. Raises the errors of `read_model`.
    """
    if (cache := _valid_cache(Path(path), folder)) is not None:
        return cache
    loaded_model = read_model(path, progress)
    try:
        return save(loaded_model, folder)
    except TargetError:
        return loaded_model


def load_for_transfer(
    path: Path, folder: Path, progress: Progress | None = None
) -> tuple[LoadedModel, Path]:
    """Load a model and return it with a folder from which another process can read it.

    If the cache cannot be written, this is a temporary folder, which the other process deletes.
    Raises the errors of `read_model`, and TargetError if neither can be written.
    """
    if (cache := _valid_cache(Path(path), folder)) is not None:
        return cache, folder
    loaded_model = read_model(path, progress)
    try:
        return save(loaded_model, folder), folder
    except TargetError as error:
        try:
            transfer_folder = Path(tempfile.mkdtemp(prefix=TRANSFER_PREFIX))
        except OSError:
            raise error from None
        try:
            return save(loaded_model, transfer_folder / folder.name), transfer_folder / folder.name
        except TargetError:
            shutil.rmtree(transfer_folder, ignore_errors=True)
            raise


def read_transfer_folder(folder: Path) -> LoadedModel:
    """Read the folder from `load_for_transfer`, and delete it if it is temporary.

    Raises the errors of `open_cache_folder`.
    """
    try:
        return open_cache_folder(folder)
    finally:
        if folder.parent.name.startswith(TRANSFER_PREFIX):
            shutil.rmtree(folder.parent, ignore_errors=True)


def _valid_cache(path: Path, folder: Path) -> LoadedModel | None:
    try:
        meta = _read_meta(folder)
        file_stamp = _file_stamp(path)
        is_valid = meta.get("path") == os.fspath(path.absolute())
        is_valid = is_valid and all(meta.get(key) == value for key, value in file_stamp.items())
        if not is_valid:
            is_valid = (
                path.is_file()
                and all(meta.get(name) == file_stamp[name] for name in _SIDECARS)
                and meta.get("content_hash") == file_hash(path)
            )
        if is_valid and not _has_missing_image(meta):
            cache = open_cache_folder(folder)
            if os.fspath(cache.path) == os.fspath(path.absolute()):
                return cache
    except (InputError, LookupError, TypeError, AttributeError):
        pass
    return None


def _damage_error(folder: Path, reason: str) -> InputError:
    return InputError(Finding("model.cache-damaged", reason=reason), file=folder)


def _read_meta(folder: Path) -> dict[str, Any]:
    try:
        meta = read_json(Path(folder) / META_FILE)
    except OSError as error:
        raise _damage_error(folder, f"{META_FILE}: {error.strerror}") from error
    except (ValueError, RecursionError) as error:
        raise _damage_error(folder, tr("{file} is not JSON", file=META_FILE)) from error
    if not isinstance(meta, dict) or meta.get("version") != VERSION:
        raise _damage_error(folder, tr("it was written by another version"))
    return meta


def _open_folder(folder: Path, meta: dict[str, Any]) -> LoadedModel:
    arrays: dict[str, AnyArray] = {}
    for name, stored_array in meta["arrays"].items():
        if not name.replace("_", "").isalnum():
            raise _damage_error(folder, tr("the names of the arrays are not valid"))
        file = folder / f"{name}.npy"
        shape, kind = tuple(stored_array["shape"]), np.dtype(stored_array["dtype"])
        if kind.hasobject:
            raise _damage_error(folder, tr("{file} contains Python objects", file=file.name))
        arrays[name] = _read_array(folder, file, shape, kind)
    warnings = [Finding.from_dict(row) for row in meta["warnings"]]
    fields = {str(name): arrays[f"field_{i}"] for i, name in enumerate(meta["fields"])}
    data: Mesh | PointCloud
    if meta["kind"] == "mesh":
        data = _mesh(folder, meta, arrays, fields, warnings)
        n = len(data.vertices)
    elif meta["kind"] == "cloud":
        points = _checked_array(folder, arrays, "points", np.float64, 3)
        n = len(points)
        normals = (
            _checked_array(folder, arrays, "normals", np.float32, 3)
            if "normals" in arrays
            else None
        )
        colors = (
            _checked_array(folder, arrays, "colors", np.uint8, 3) if "colors" in arrays else None
        )
        order = ProgressiveOrder(*(arrays[f"order_{k}"] for k in _ORDER_FIELDS))
        if not order.is_valid(n):
            raise _damage_error(folder, tr("the stored order does not match the points"))
        data = PointCloud(points, colors, normals, fields, order)
    else:
        raise _damage_error(folder, tr("it is neither a mesh nor a point cloud"))
    row_arrays = [
        array
        for k, array in arrays.items()
        if k in ("colors", "uv", "normals") or k[:6] == "field_"
    ]
    if n == 0 or any(len(array) != n for array in row_arrays):
        raise _damage_error(folder, tr("the arrays have different lengths"))
    crs = meta["crs"]
    if crs is not None and not isinstance(crs, str):
        raise _damage_error(folder, tr("the coordinate reference system is not valid"))
    return LoadedModel(
        data,
        meta["kind"],
        crs,
        tuple(warnings),
        Path(meta["path"]),
        str(meta["content_hash"]),
        parse_origin(meta["turned_about"]),
        None if meta["resolution"] is None else float(meta["resolution"]),
        units=_units(meta["units"]),
        unit_m=None if meta["unit_m"] is None else float(meta["unit_m"]),
    )


def _read_array(folder: Path, path: Path, shape: tuple[int, ...], kind: np.dtype[Any]) -> AnyArray:
    size_reason = tr("{file} has the wrong size", file=path.name)
    header = _npy_header(shape, kind)
    with open_unbuffered(path) as file:
        size = math.prod(shape) * kind.itemsize
        # Checked before memory is allocated.
        if os.fstat(file.fileno()).st_size != len(header) + size:
            raise _damage_error(folder, size_reason)
        if file.read(len(header)) != header:
            raise _damage_error(
                folder, tr("{file} does not match {index}", file=path.name, index=META_FILE)
            )
        array = np.empty(shape, kind)
        view, position = array.reshape(-1).view(np.uint8).data, 0
        # Fewer bytes are read if the file has been truncated since it was checked.
        while position < size and (n := file.readinto(view[position : position + BLOCK_BYTES])):
            position += n
    if position < size:
        raise _damage_error(folder, size_reason)
    array.flags.writeable = False
    return array


def _npy_header(shape: tuple[int, ...], kind: np.dtype[Any]) -> bytes:
    """Return the header of an array file.

    numpy would evaluate a damaged header as Python code.
    """
    stream = io.BytesIO()
    descr = np.lib.format.dtype_to_descr(kind)
    header = {"descr": descr, "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(stream, header)
    return stream.getvalue()


def _units(stored_value: Any) -> Units:
    x, y, z = (str(unit) for unit in stored_value)
    return x, y, z


def _checked_array(
    folder: Path, arrays: dict[str, AnyArray], name: str, kind: type, width: int
) -> AnyArray:
    array = arrays[name]
    if array.ndim != 2 or array.shape[1] != width or array.dtype != kind:
        raise _damage_error(folder, tr("{name}.npy has the wrong shape or type", name=name))
    return array


def _mesh(
    folder: Path,
    meta: dict[str, Any],
    arrays: dict[str, AnyArray],
    fields: dict[str, AnyArray],
    warnings: list[Finding],
) -> Mesh:
    vertices = _checked_array(folder, arrays, "vertices", np.float64, 3)
    faces = _checked_array(folder, arrays, "faces", np.int32, 3)
    if len(faces) and (int(faces.min()) < 0 or int(faces.max()) >= len(vertices)):
        raise _damage_error(folder, tr("faces refer to vertices that do not exist"))
    offsets = arrays["material_offsets"]
    materials = []
    for record in meta["materials"]:
        texture = None if record["texture"] is None else Path(record["texture"])
        if texture is not None and not texture.is_file():
            warnings.append(
                Finding(
                    "texture.unusable",
                    material=record["name"],
                    reason=tr("'{file}' was not found", file=texture.name),
                )
            )
            texture = None
        diffuse = record["diffuse"]
        if diffuse is not None:
            r, g, b = (float(x) for x in diffuse)
            diffuse = (r, g, b)
        materials.append(Material(str(record["name"]), texture, diffuse))
    if (
        offsets.dtype != np.int64
        or offsets.shape != (len(materials) + 1,)
        or offsets[0] != 0
        or (materials and offsets[-1] != len(faces))
        or np.any(np.diff(offsets) < 0)
    ):
        raise _damage_error(folder, tr("the materials do not match the faces"))
    uv = _checked_array(folder, arrays, "uv", np.float32, 2) if "uv" in arrays else None
    colors = _checked_array(folder, arrays, "colors", np.uint8, 3) if "colors" in arrays else None
    return Mesh(vertices, faces, tuple(materials), offsets, uv, colors, fields)
