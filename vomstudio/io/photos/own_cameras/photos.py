"""Where the photos are that a model was made of."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.io.photos.own_cameras.result import OwnCameras
from vomstudio.io.photos.photo_names import photo_finder
from vomstudio.io.photos.reading import photo_names

_FOLDERS = ("photos", "images", ".", "../photos", "../images", "../../photos", "../../images")


def find_photos_of(own: OwnCameras, folder: Path | None = None) -> dict[str, Path]:
    """The photos of the cameras by the names of these, where they are found.

    folder : of the photos; None looks where the file of the cameras says, and beside it
    Raises InputError for a folder that is none.
    """
    if folder is not None:
        return _inside(folder, list(own.centres))
    places = [own.photos] if own.photos is not None else []
    places += [own.path.parent / name for name in _FOLDERS]
    for place in places:
        try:
            found = _inside(place, list(own.centres))
        except InputError:
            continue
        if found:
            return found
    return {}


def _inside(folder: Path, cameras: Sequence[str]) -> dict[str, Path]:
    names = photo_names(folder)
    find = photo_finder(names)
    there = {camera: find(camera) for camera in cameras}
    return {
        camera: folder / names[number] for camera, number in there.items() if number is not None
    }
