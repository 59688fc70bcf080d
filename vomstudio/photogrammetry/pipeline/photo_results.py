"""Results of individual photos on the disk, written atomically and read on access."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar, overload

import numpy as np

from vomstudio.core.errors import InputError
from vomstudio.core.files.arrays import open_arrays
from vomstudio.core.files.disk_errors import damage_reason
from vomstudio.core.findings import Finding
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Material, Mesh
from vomstudio.io.photos.cameras_file import view_from_dict, view_to_dict
from vomstudio.photogrammetry.base.checkpoints import file_name, write_atomically

if TYPE_CHECKING:
    from vomstudio.photogrammetry.dense.undistortion import UndistortedPhoto

Result = TypeVar("Result")


class PhotoResults(Sequence[Result], Generic[Result]):
    """Results of a stage: one file per photo in `folder`, read on access."""

    def __init__(
        self,
        folder: Path,
        names: Sequence[str],
        save: Callable[[Path, Result], None],
        load: Callable[[Path], Result],
    ) -> None:
        self._folder, self.names = folder, list(names)
        self._save, self._load = save, load

    def at(self, folder: Path) -> PhotoResults[Result]:
        """Return the same results in their final folder."""
        return PhotoResults(folder, self.names, self._save, self._load)

    def select(self, numbers: Sequence[int]) -> PhotoResults[Result]:
        """Return the results of the photos `numbers`, in this order."""
        return PhotoResults(self._folder, [self.names[n] for n in numbers], self._save, self._load)

    def path(self, number: int) -> Path:
        """Return the file of a photo, by its row."""
        return self._folder / f"{file_name(self.names[number])}.npz"

    def has(self, number: int) -> bool:
        """Return whether the result of a photo, by its row, exists."""
        return self.path(number).exists()

    def put(self, number: int, result: Result) -> None:
        """Write a result. Raises TargetError if it cannot be written."""
        write_atomically(self.path(number), lambda path: self._save(path, result))

    def __len__(self) -> int:
        return len(self.names)

    @overload
    def __getitem__(self, number: int) -> Result: ...
    @overload
    def __getitem__(self, number: slice) -> list[Result]: ...
    def __getitem__(self, number: int | slice) -> Result | list[Result]:
        if isinstance(number, slice):
            return [self[item] for item in range(*number.indices(len(self)))]
        if not -len(self) <= number < len(self):
            raise IndexError(number)
        path = self.path(number % len(self))
        return load_result(self._load, path)


def load_result(load: Callable[[Path], Result], path: Path) -> Result:
    """Load a file. Raises InputError if it is damaged."""
    try:
        return load(path)
    except (OSError, ValueError, KeyError, TypeError, EOFError) as error:
        raise InputError(
            Finding("reconstruct.damaged", reason=damage_reason(error)),
            file=path,
        ) from error


def save_undistorted(path: Path, photo: UndistortedPhoto) -> None:
    """Write an undistorted photo with its mask and view as npz."""
    arrays = {
        "photo": np.frombuffer(photo.photo, np.uint8),
        "view": _encode_view(photo.view),
    }
    if photo.mask is not None:
        arrays["mask"] = np.frombuffer(photo.mask, np.uint8)
    _save(path, arrays)


def load_undistorted(path: Path) -> UndistortedPhoto:
    """Load an undistorted photo that was written by `save_undistorted`."""
    from vomstudio.photogrammetry.dense.undistortion import UndistortedPhoto

    with open_arrays(path) as arrays:
        mask = arrays["mask"].tobytes() if "mask" in arrays.files else None
        view = view_from_dict(json.loads(str(arrays["view"])))
        return UndistortedPhoto(arrays["photo"].tobytes(), mask, view)


def _encode_view(view: Any) -> np.ndarray[Any, Any]:
    return np.array(json.dumps(view_to_dict(view)))


def save_cloud(path: Path, cloud: PointCloud) -> None:
    """Write a cloud to an npz file."""
    arrays: dict[str, Any] = {"points": cloud.points}
    if cloud.colors is not None:
        arrays["colors"] = cloud.colors
    if cloud.normals is not None:
        arrays["normals"] = cloud.normals
    arrays |= {f"field:{name}": values for name, values in cloud.fields.items()}
    _save(path, arrays)


def load_cloud(path: Path) -> PointCloud:
    """Load a cloud that was written by `save_cloud`."""
    with open_arrays(path) as arrays:
        return PointCloud(
            arrays["points"], arrays.get("colors"), arrays.get("normals"), _fields(arrays)
        )


def save_mesh(path: Path, mesh: Mesh) -> None:
    """Write a mesh with the names of its materials; see `load_mesh` for their pictures."""
    arrays: dict[str, Any] = {
        "vertices": mesh.vertices,
        "faces": mesh.faces,
        "materials": np.array([material.name for material in mesh.materials], np.str_),
        "material_offsets": mesh.material_offsets,
    }
    for name in ("uv", "colors"):
        if (values := getattr(mesh, name)) is not None:
            arrays[name] = values
    arrays |= {f"field:{name}": values for name, values in mesh.fields.items()}
    _save(path, arrays)


def load_mesh(path: Path) -> Mesh:
    """Load a mesh; the picture of a material NAME is NAME.jpg in the same folder."""
    with open_arrays(path) as arrays:
        return Mesh(
            arrays["vertices"],
            arrays["faces"],
            tuple(
                Material(str(name), path.with_name(f"{name}.jpg")) for name in arrays["materials"]
            ),
            arrays["material_offsets"],
            arrays.get("uv"),
            arrays.get("colors"),
            _fields(arrays),
        )


def _fields(arrays: Any) -> dict[str, Any]:
    return {
        name.partition(":")[2]: arrays[name] for name in arrays.files if name.startswith("field:")
    }


def _save(path: Path, arrays: dict[str, Any]) -> None:
    # Use a stream, since NumPy adds an extension to names.
    with path.open("wb") as stream:
        np.savez(stream, **arrays)
