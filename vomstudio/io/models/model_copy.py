"""Copying of a model into a project, with all files that belong to it."""

from __future__ import annotations

import contextlib
import os
import shutil
from dataclasses import replace
from pathlib import Path

from vomstudio.core.errors import InputError, TargetError
from vomstudio.core.files.containment import check_in_project, make_folder, require_inside
from vomstudio.core.files.regular import open_regular_file, require_regular_file
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.words import tr
from vomstudio.geometry.registrations import Registration
from vomstudio.io.models.formats._gltf_document import companion_files
from vomstudio.io.models.mtl import decode, find_companion, read_library
from vomstudio.io.models.registration_file import registration_path, write_registration
from vomstudio.io.photos.cameras_file import (
    FILE_NAME,
    Cameras,
    find_photos,
    read_cameras,
    write_cameras,
)

PHOTOS = Path("photos")
"""Folder of the copied photos next to the copy of their model."""


def companions(model: Path) -> list[Path]:
    """Return the other files that a model needs, in the folder of the model or below it.

    These are the .prj, offset and registration files of the model; the material files and images of
    an OBJ; the buffers and images of a glTF; the images of a PLY; the world file and mask of a
    GeoTIFF.
    """
    paths = [
        model.with_suffix(".prj"),
        model.with_suffix(".offset.txt"),
        registration_path(model),
    ]
    if model.suffix.lower() == ".obj":
        for library in _libraries(model):
            paths.append(library)
            materials, _ = read_library(library, model.parent)
            paths += [
                material.texture for material in materials.values() if material.texture is not None
            ]
    elif model.suffix.lower() in (".gltf", ".glb"):
        with contextlib.suppress(InputError):
            paths += companion_files(model)
    elif model.suffix.lower() == ".ply":
        paths += _ply_images(model)
    elif model.suffix.lower() in (".tif", ".tiff"):
        paths.append(model.with_suffix(".tfw"))
        paths += [model.with_name(model.name + suffix) for suffix in (".aux.xml", ".msk")]
    model_folder = model.parent.resolve()
    return [
        path
        for path in dict.fromkeys(paths)
        if path.is_file() and path.resolve().is_relative_to(model_folder)
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
    """Copy a model and its companion files to a new folder below `folder`.

    Returns the path of the copy.

    Parameters
    ----------
    model : Path
        Path of the model file.
    folder : Path
    progress : Progress, optional
    cameras : Path or None
        Cameras of the photos. If None, `cameras.json` next to the model is used. The copy is named
        `cameras.json` and refers to the photos.
    photos : bool
        Whether to copy the photos as well, to `photos` next to the copy.
    registration : Registration or None
        Registration of the model, which replaces the one next to it.

    Raises
    ------
    InputError, TargetError, Cancelled
        In this case nothing is copied.
    """
    progress = progress or SilentProgress()
    base = model.parent.resolve()
    files = [(file, file.resolve().relative_to(base)) for file in (model, *companions(model))]
    model_cameras = _read_cameras(cameras or model.with_name(FILE_NAME), model)
    if model_cameras is not None and photos and model_cameras.photos.is_dir():
        files += _photo_files(model_cameras)
        model_cameras = replace(model_cameras, photos=PHOTOS)
    check_in_project(folder / model.stem)
    target = folder / model.stem
    suffix = 1
    while target.exists():
        suffix += 1
        target = folder / f"{model.stem}-{suffix}"
    partial_folder = target.with_name(target.name + ".part")
    try:
        shutil.rmtree(partial_folder, ignore_errors=True)
        progress.stage(tr("Copying files"), len(files))
        for count, (file, name) in enumerate(files, 1):
            copy = partial_folder / name
            make_folder(require_inside(copy, partial_folder).parent, partial_folder)
            require_regular_file(file)
            shutil.copyfile(file, copy)
            progress.step(count)
        if model_cameras is not None:
            write_cameras(partial_folder / FILE_NAME, model_cameras)
        if registration is not None:
            write_registration(registration, [partial_folder / model.name], force=True)
        partial_folder.rename(target)
    except OSError as error:
        copy = Path(error.filename2 or error.filename or target)
        if copy.is_relative_to(folder):
            raise TargetError(
                Finding("output.unwritable", reason=error.strerror), file=target
            ) from error
        raise InputError(Finding("file.unreadable", reason=error.strerror), file=copy) from error
    finally:
        shutil.rmtree(partial_folder, ignore_errors=True)
    return target / model.name


def count_photos(model: Path, cameras: Path | None = None) -> tuple[int, int]:
    """Return the number and total size of the photos that `copy_model` could copy.

    Returns
    -------
    count : int
    size : int
        Total size, bytes.
    """
    model_cameras = _read_cameras(cameras or model.with_name(FILE_NAME))
    files = (
        []
        if model_cameras is None or not model_cameras.photos.is_dir()
        else _photo_files(model_cameras)
    )
    return len(files), sum(file.stat().st_size for file, _ in files)


def _read_cameras(path: Path, model: Path | None = None) -> Cameras | None:
    """Return the cameras with the absolute folder of the photos, or None if unreadable.

    Cameras of other programs are in one of several frames, selected by the extent of `model`.
    """
    try:
        cameras = read_cameras(path)
    except InputError:
        return _read_other_cameras(path, model)
    stored_path = path.parent / cameras.photos
    return replace(cameras, photos=(find_photos(cameras, path) or stored_path).resolve())


def _read_other_cameras(path: Path, model: Path | None) -> Cameras | None:
    from vomstudio.io.models.opening import read_model
    from vomstudio.io.photos.own_cameras import photos
    from vomstudio.io.photos.own_cameras.reading import read_camera_file
    from vomstudio.io.photos.own_cameras.result import local_cameras

    try:
        bounds = None if model is None else read_model(model).data.bounds
        cameras = local_cameras(read_camera_file(path, bounds))
    except InputError:
        return None
    files = photos.find_photos(path, [view.name for view in cameras.views])
    if not files:
        return replace(cameras, photos=path.parent.resolve())
    folder = Path(os.path.commonpath([file.resolve().parent for file in files.values()]))
    # Names in other files may have no suffix.
    names = {name: file.resolve().relative_to(folder) for name, file in files.items()}
    views = tuple(
        replace(view, name=names[view.name].as_posix()) if view.name in names else view
        for view in cameras.views
    )
    return replace(cameras, views=views, photos=folder)


def _photo_files(cameras: Cameras) -> list[tuple[Path, Path]]:
    """Return the existing photos with their names in the copy."""
    candidates = [(cameras.photos / view.name, PHOTOS / view.name) for view in cameras.views]
    return [
        (file, name)
        for file, name in candidates
        if ".." not in name.parts
        and file.is_file()
        and file.resolve().is_relative_to(cameras.photos)
    ]


def _libraries(model: Path) -> list[Path]:
    """Return all material files to which an OBJ file refers."""
    names: dict[str, None] = {}
    with open_regular_file(model) as lines:
        for line in lines:
            if line.startswith(b"mtllib"):
                names.setdefault(decode(line[len(b"mtllib") :]).strip())
    paths = []
    for name in names:
        # The name of one file with spaces, or the names of several files.
        single_file, _ = find_companion(model.parent, name)
        paths += (
            [single_file]
            if single_file
            else [path for word in name.split() if (path := find_companion(model.parent, word)[0])]
        )
    return paths


def _ply_images(model: Path) -> list[Path]:
    from vomstudio.io.models.formats._ply_header import MAX_HEADER_BYTES, read_header

    with contextlib.suppress(InputError, OSError), open_regular_file(model) as file:
        header = read_header(file.read(MAX_HEADER_BYTES), model)
        paths = [find_companion(model.parent, name)[0] for name in header.textures]
        return [path for path in paths if path is not None]
    return []
