"""Search for the photos from which a model was reconstructed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import is_regular_file
from vomstudio.io.photos.own_cameras.result import ModelCameras
from vomstudio.io.photos.photo_names import photo_finder
from vomstudio.io.photos.reading import photo_names

_MAX_TRIED_NAMES = 3
_FOLDERS = ("photos", "images", ".", "../photos", "../images", "../../photos", "../../images")


def find_camera_photos(cameras: ModelCameras, folder: Path | None = None) -> dict[str, Path]:
    """Return the existing photos of cameras by camera name.

    `folder` is the folder of the photos. If None, the folder stated in the camera file and
    neighbouring folders are searched. Raises InputError if it is not a folder.
    """
    names = list(cameras.centres)
    if folder is not None:
        return _photos_in_folder(folder, names)
    return find_photos(cameras.path, names, () if cameras.photos is None else (cameras.photos,))


def find_photos(path: Path, names: Sequence[str], folders: Sequence[Path] = ()) -> dict[str, Path]:
    """Return the existing photos by camera name, from one of the folders near a camera file.

    Parameters
    ----------
    path : Path
        Camera file.
    names : sequence of str
        Names of the photos as in the file, perhaps without suffix.
    folders : sequence of Path
        Folders that are searched first.
    """
    candidates = [*folders, *(path.parent / name for name in _FOLDERS)]
    # Listing a folder with its subfolders takes long, so files of these names are tried first.
    for folder in candidates:
        if any(is_regular_file(folder / name) for name in names[:_MAX_TRIED_NAMES]):
            return {name: file for name in names if is_regular_file(file := folder / name)}
    for folder in candidates:
        try:
            photos = _photos_in_folder(folder, names)
        except InputError:
            continue
        if photos:
            return photos
    return {}


def _photos_in_folder(folder: Path, cameras: Sequence[str]) -> dict[str, Path]:
    names = photo_names(folder)
    find = photo_finder(names)
    index_by_camera = {camera: find(camera) for camera in cameras}
    return {
        camera: folder / names[index]
        for camera, index in index_by_camera.items()
        if index is not None
    }
