"""Search for the photos from which a model was reconstructed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.io.photos.own_cameras.result import OwnCameras
from vomstudio.io.photos.photo_names import photo_finder
from vomstudio.io.photos.reading import photo_names

_FOLDERS = ("photos", "images", ".", "../photos", "../images", "../../photos", "../../images")


def find_camera_photos(cameras: OwnCameras, folder: Path | None = None) -> dict[str, Path]:
    """Return the existing photos of cameras by camera name.

    `folder` is the folder of the photos. If None, the folder stated in the camera file and
    neighbouring folders are searched. Raises InputError if it is not a folder.
    """
    if folder is not None:
        return _photos_in_folder(folder, list(cameras.centres))
    folders = [cameras.photos] if cameras.photos is not None else []
    folders += [cameras.path.parent / name for name in _FOLDERS]
    for candidate in folders:
        try:
            photos = _photos_in_folder(candidate, list(cameras.centres))
        except InputError:
            continue
        if photos:
            return photos
    return {}


def _photos_in_folder(folder: Path, cameras: Sequence[str]) -> dict[str, Path]:
    names = photo_names(folder)
    find = photo_finder(names)
    numbers = {camera: find(camera) for camera in cameras}
    return {
        camera: folder / names[number] for camera, number in numbers.items() if number is not None
    }
