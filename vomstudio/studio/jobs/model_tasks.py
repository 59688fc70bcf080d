"""Jobs on models, such as reading, preview, copying and export."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import to_translate
from vomstudio.geometry.registrations import Registration
from vomstudio.geometry.units import WORLD_AXES, Axes
from vomstudio.studio.jobs.job import Job, Lane, NoArguments

MEMORY_ADVICE = to_translate("Divide the model into tiles, or close other programs.")

Matrix = tuple[tuple[float, ...], ...]
"""Rows of a 4 x 4 matrix, as stored in `to_world` of a model."""


def _start(request: NoArguments, progress: Progress) -> NoArguments:
    import vomstudio.io.models.model_cache
    import vomstudio.io.models.opening  # noqa: F401

    return NoArguments()


START_WORKER = Job("start", Lane.MODELS, NoArguments, NoArguments, _start)
"""Import the modules that reading any model requires."""


def _warm(request: NoArguments, progress: Progress) -> NoArguments:
    import lazrs  # noqa: F401
    import pyproj  # noqa: F401
    import scipy.spatial  # noqa: F401

    from vomstudio.io.models.formats.obj import warm_up
    from vomstudio.io.models.las_library import import_laspy

    import_laspy()
    warm_up()
    return NoArguments()


IMPORT_LIBRARIES = Job("warm", Lane.MODELS, NoArguments, NoArguments, _warm)
"""Import the libraries for reading models, so that the first model opens without delay."""


def _compile_kernels(request: NoArguments, progress: Progress) -> NoArguments:
    import os

    from vomstudio.geometry.kernels import compilation_state
    from vomstudio.geometry.kernels.declared_kernels import declared_kernels

    if hasattr(os, "nice"):
        os.nice(10)
    for kernel in declared_kernels():
        progress.step(0)
        kernel.compile_for_this_processor()
    compilation_state.record_compilation()
    return NoArguments()


COMPILE_KERNELS = Job("compile_kernels", Lane.KERNELS, NoArguments, NoArguments, _compile_kernels)
"""Compile all kernels for this processor, which takes several seconds per kernel. Until then, the
kernels that the program contains are used."""


@dataclass(frozen=True)
class ModelFile:
    """Request to read the model `path` and cache it below the folder `cache`."""

    path: Path
    cache: Path


@dataclass(frozen=True)
class CachedModel:
    """Model in the cache.

    Parameters
    ----------
    folder : Path
        Folder of the model in the cache.
    crs : str or None
        CRS of the file, or None if the file states none.
    content_hash : str
        Content hash of the file.
    resolution : float or None
        Typical point spacing in the unit of the file, or None if unknown.
    """

    folder: Path
    kind: Literal["mesh", "cloud"]
    crs: str | None
    content_hash: str
    warnings: tuple[Finding, ...]
    resolution: float | None


def _load_model(request: ModelFile, progress: Progress) -> CachedModel:
    from vomstudio.io.models import model_cache
    from vomstudio.io.models.opening import resolution

    cached_folder = model_cache.cache_folder(request.path, request.cache)
    loaded_model, folder = model_cache.load_for_transfer(request.path, cached_folder, progress)
    spacing = loaded_model.resolution
    if spacing is None:
        spacing = resolution(loaded_model.data)
    return CachedModel(
        folder,
        loaded_model.kind,
        loaded_model.crs,
        loaded_model.content_hash,
        tuple(loaded_model.warnings),
        spacing if spacing == spacing else None,
    )


LOAD_MODEL = Job("load_model", Lane.MODELS, ModelFile, CachedModel, _load_model, MEMORY_ADVICE)
"""Read a model and write it to a cache folder, from which the window reads it."""


@dataclass(frozen=True)
class PreviewRequest:
    """Request to write a sample of the points of a cloud to `out`."""

    path: Path
    out: Path


@dataclass(frozen=True)
class PreviewPoints:
    """Number of points in the preview, or 0 if the file does not support previews."""

    points: int


def _preview_model(request: PreviewRequest, progress: Progress) -> PreviewPoints:
    import numpy as np

    from vomstudio.io.models.preview import preview

    cloud = preview(request.path)
    if cloud is None:
        return PreviewPoints(0)
    arrays: dict[str, Any] = {"points": cloud.points}
    if cloud.colors is not None:
        arrays["colors"] = cloud.colors
    for name, values in cloud.fields.items():
        if "intensity" in name.lower():
            arrays["intensity"] = values
    np.savez(request.out, **arrays)
    return PreviewPoints(len(cloud.points))


PREVIEW_MODEL = Job(
    "preview_model", Lane.MODELS, PreviewRequest, PreviewPoints, _preview_model, MEMORY_ADVICE
)
"""Write a sample of the points of a cloud as arrays."""


@dataclass(frozen=True)
class ModelCopy:
    """Request to copy a model with its companion files.

    `folder` is the parent folder of the copy. `cameras` is the file of the model's cameras; if
    None, the file beside the model is used. `photos` determines whether photos are also copied,
    and `registration` is the registration in the project.
    """

    path: Path
    folder: Path
    cameras: Path | None = None
    photos: bool = False
    registration: Registration | None = None


@dataclass(frozen=True)
class CopiedModel:
    """Result of copying a model; `path` is the path of the copy."""

    path: Path


def _copy_model(request: ModelCopy, progress: Progress) -> CopiedModel:
    from vomstudio.io.models.model_copy import copy_model

    copied_model = copy_model(
        request.path,
        request.folder,
        progress,
        cameras=request.cameras,
        photos=request.photos,
        registration=request.registration,
    )
    return CopiedModel(copied_model)


COPY_MODEL = Job("copy_model", Lane.FILES, ModelCopy, CopiedModel, _copy_model, MEMORY_ADVICE)


@dataclass(frozen=True)
class ModelConversion:
    """Request to write a model in another CRS into a folder."""

    path: Path
    folder: Path
    to_crs: str


@dataclass(frozen=True)
class ConvertedModel:
    """Result of converting a model; `path` is the path of the copy."""

    path: Path
    warnings: tuple[Finding, ...]


def _convert_model(request: ModelConversion, progress: Progress) -> ConvertedModel:
    from vomstudio.io.gate.frame_options import FrameOptions
    from vomstudio.io.models.converted_copy import write_converted

    options = FrameOptions(to_crs=request.to_crs)
    return ConvertedModel(*write_converted(request.path, request.folder, options, progress))


CONVERT_MODEL = Job(
    "convert_model", Lane.FILES, ModelConversion, ConvertedModel, _convert_model, MEMORY_ADVICE
)
"""Write a copy of a model in another CRS."""


@dataclass(frozen=True)
class ModelExport:
    """Request to export the model `path`, cached below `cache`, to `out` in World.

    `to_world` is the matrix from the file frame, `crs` the CRS of the World frame (None for a
    local frame), and `registration` the registration in the project.
    """

    path: Path
    cache: Path
    to_world: Matrix
    crs: str | None
    out: Path
    axes: Axes = WORLD_AXES
    registration: Registration | None = None


@dataclass(frozen=True)
class ExportedModel:
    """Result of exporting a model.

    `warnings` are messages about content that the format cannot store.
    """

    warnings: tuple[Finding, ...]


def _export_model(request: ModelExport, progress: Progress) -> ExportedModel:
    from vomstudio.geometry.model_transform import transform_model
    from vomstudio.geometry.registration_frames import change_file_frame
    from vomstudio.io.models import model_cache
    from vomstudio.io.models.model_copy import companions
    from vomstudio.io.models.writing import choose_writer, write_model

    choose_writer(request.out)
    folder = model_cache.cache_folder(request.path, request.cache)
    data = transform_model(model_cache.load(request.path, folder, progress).data, request.to_world)
    registration = request.registration
    if registration is not None:
        registration = change_file_frame(registration, request.to_world)
    warnings = write_model(
        data,
        request.crs,
        request.out,
        force=True,
        inputs=[request.path, *companions(request.path)],
        progress=progress,
        axes=request.axes,
        registration=registration,
    )
    return ExportedModel(tuple(warnings))


EXPORT_MODEL = Job(
    "export_model", Lane.PRODUCTS, ModelExport, ExportedModel, _export_model, MEMORY_ADVICE
)


@dataclass(frozen=True)
class ModelCut:
    """Request to write selected faces or points of a model as a new model.

    `path` and `cache` are the model file and the cache folder, and `content_hash` is the hash of
    the file to which the selection refers. `bits` is an .npy file with the packed selection
    mask. `folder` and `name` are those of the new model. `crs` is the CRS stated by the file, or
    None, and `registration` is the registration in the project.
    """

    path: Path
    cache: Path
    content_hash: str
    bits: Path
    crs: str | None
    folder: Path
    name: str
    registration: Registration | None = None


@dataclass(frozen=True)
class CutModel:
    """Result of cutting a model.

    Attributes
    ----------
    path
        Path of the new model.
    warnings
        Messages about content that the format cannot store.
    """

    path: Path
    warnings: tuple[Finding, ...]


def _cut_model(request: ModelCut, progress: Progress) -> CutModel:
    import numpy as np

    from vomstudio.core.files.regular import open_regular_file
    from vomstudio.io.models import model_cache
    from vomstudio.io.models.piece_writing import write_piece

    loaded_model = model_cache.load(
        request.path, model_cache.cache_folder(request.path, request.cache), progress
    )
    with open_regular_file(request.bits) as file:
        packed_mask = np.load(file, allow_pickle=False)
    path, warnings = write_piece(
        loaded_model,
        packed_mask,
        request.path,
        request.content_hash,
        request.crs,
        request.folder,
        request.name,
        progress,
        request.registration,
    )
    return CutModel(path, tuple(warnings))


CUT_MODEL = Job("cut_model", Lane.FILES, ModelCut, CutModel, _cut_model, MEMORY_ADVICE)
"""Write part of a model as a new model."""

JOBS = (
    IMPORT_LIBRARIES,
    START_WORKER,
    COMPILE_KERNELS,
    LOAD_MODEL,
    PREVIEW_MODEL,
    COPY_MODEL,
    CONVERT_MODEL,
    EXPORT_MODEL,
    CUT_MODEL,
)
