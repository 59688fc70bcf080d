"""A model copied into a project, with everything that belongs to it."""

from __future__ import annotations

import contextlib
import shutil
from dataclasses import replace
from pathlib import Path

from vomstudio.core.errors import InputError, TargetError
from vomstudio.core.files.containment import check_in_project, make_folder, require_inside
from vomstudio.core.files.regular import open_regular, require_regular
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, Silent
from vomstudio.core.words import tr
from vomstudio.geometry.registrations import Registration
from vomstudio.io.models.formats._gltf_document import files_beside
from vomstudio.io.models.mtl import decode, find_beside, read_library
from vomstudio.io.models.registration_file import registration_path, write_registration
from vomstudio.io.photos.cameras_file import (
    FILE_NAME,
    Cameras,
    find_photos,
    read_cameras,
    write_cameras,
)

PHOTOS = Path("photos")
"""Where copied photos lie beside the copy of their model."""


def companions(model: Path) -> list[Path]:
    """The other files that a model needs: a .prj, offset or registration beside it; the material
    files and images of an OBJ, the buffers and images of a glTF, the images of a PLY, the world
    file and mask of a GeoTIFF. Only what lies in the model's folder or below it."""
    found = [
        model.with_suffix(".prj"),
        model.with_suffix(".offset.txt"),
        registration_path(model),
    ]
    if model.suffix.lower() == ".obj":
        for library in _libraries(model):
            found.append(library)
            materials, _ = read_library(library, model.parent)
            found += [m.texture for m in materials.values() if m.texture is not None]
    elif model.suffix.lower() in (".gltf", ".glb"):
        with contextlib.suppress(InputError):
            found += files_beside(model)
    elif model.suffix.lower() == ".ply":
        found += _ply_images(model)
    elif model.suffix.lower() in (".tif", ".tiff"):
        found.append(model.with_suffix(".tfw"))
        found += [model.with_name(model.name + ending) for ending in (".aux.xml", ".msk")]
    inside = model.parent.resolve()
    return [
        path
        for path in dict.fromkeys(found)
        if path.is_file() and path.resolve().is_relative_to(inside)
    ]


def copy_model(
    model: Path,
    folder: Path,
    progress: Progress | None = None,
    *,
    cameras: Path | None = None,
    photos: bool = False,
    registration: Registration | None = None,
) -> Path:
    """Copy a model and its companions to a new folder below `folder`; returns the copy's path.

    cameras : the file of its photos' cameras, by default `cameras.json` beside it, where there is
        one; the copy is `cameras.json` and knows where the photos are
    photos : copy the photos too, to `photos` beside the copy
    registration : by which the model stands, in place of the one beside it

    The whole copy appears at once or not at all. Raises InputError, TargetError or Cancelled.
    """
    progress = progress or Silent()
    base = model.parent.resolve()
    files = [(file, file.resolve().relative_to(base)) for file in (model, *companions(model))]
    seen = _read_cameras(cameras or model.with_name(FILE_NAME))
    if seen is not None and photos and seen.photos.is_dir():
        files += _photo_files(seen)
        seen = replace(seen, photos=PHOTOS)
    check_in_project(folder / model.stem)
    target = folder / model.stem
    number = 1
    while target.exists():
        number += 1
        target = folder / f"{model.stem}-{number}"
    part = target.with_name(target.name + ".part")
    try:
        shutil.rmtree(part, ignore_errors=True)
        progress.stage(tr("Copying files"), len(files))
        for done, (file, name) in enumerate(files, 1):
            place = part / name
            make_folder(require_inside(place, part).parent, part)
            require_regular(file)
            shutil.copyfile(file, place)
            progress.step(done)
        if seen is not None:
            write_cameras(part / FILE_NAME, seen)
        if registration is not None:
            write_registration(registration, [part / model.name], force=True)
        part.rename(target)
    except OSError as error:
        place = Path(error.filename2 or error.filename or target)
        if place.is_relative_to(folder):
            raise TargetError(
                Finding("output.unwritable", reason=error.strerror), file=target
            ) from error
        raise InputError(Finding("file.unreadable", reason=error.strerror), file=place) from error
    finally:
        shutil.rmtree(part, ignore_errors=True)
    return target / model.name


def photos_of(model: Path, cameras: Path | None = None) -> tuple[int, int]:
    """How many photos `copy_model` could copy along with a model, and their bytes."""
    seen = _read_cameras(cameras or model.with_name(FILE_NAME))
    found = [] if seen is None or not seen.photos.is_dir() else _photo_files(seen)
    return len(found), sum(file.stat().st_size for file, _ in found)


def _read_cameras(path: Path) -> Cameras | None:
    """With the folder of the photos as it can be found from anywhere; None where there are none
    that can be read."""
    try:
        cameras = read_cameras(path)
    except InputError:
        return None
    stored = path.parent / cameras.photos
    return replace(cameras, photos=(find_photos(cameras, path) or stored).resolve())


def _photo_files(cameras: Cameras) -> list[tuple[Path, Path]]:
    """The photos that are there, and their names in the copy."""
    found = [(cameras.photos / view.name, PHOTOS / view.name) for view in cameras.views]
    return [
        (file, name)
        for file, name in found
        if ".." not in name.parts
        and file.is_file()
        and file.resolve().is_relative_to(cameras.photos)
    ]


def _libraries(model: Path) -> list[Path]:
    """The material files that an OBJ names, wherever in the file it does."""
    names: dict[str, None] = {}
    with open_regular(model) as lines:
        for line in lines:
            if line.startswith(b"mtllib"):
                names.setdefault(decode(line[len(b"mtllib") :]).strip())
    found = []
    for name in names:
        # One file whose name has blanks, or several files.
        whole, _ = find_beside(model.parent, name)
        found += (
            [whole]
            if whole
            else [p for word in name.split() if (p := find_beside(model.parent, word)[0])]
        )
    return found


def _ply_images(model: Path) -> list[Path]:
    from vomstudio.io.models.formats._ply_header import MAX_HEADER_BYTES, read_header

    with contextlib.suppress(InputError, OSError), open_regular(model) as file:
        header = read_header(file.read(MAX_HEADER_BYTES), model)
        named = [find_beside(model.parent, name)[0] for name in header.textures]
        return [path for path in named if path is not None]
    return []
