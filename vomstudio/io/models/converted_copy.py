"""Copy of a model in another coordinate reference system."""

from __future__ import annotations

from pathlib import Path

from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.io.gate.frame_options import FrameOptions
from vomstudio.io.models.frames import stored_registration
from vomstudio.io.models.opening import read_model
from vomstudio.io.models.writing import write_model


def write_converted(
    path: Path, folder: Path, options: FrameOptions, progress: Progress
) -> tuple[Path, tuple[Finding, ...]]:
    """Write a model in another CRS to a folder, in the format of the original file.

    Parameters
    ----------
    path : Path
        Path of the model.
    folder : Path
        Target folder, which is created if it does not exist.
    options : FrameOptions
        Frame options, with `to_crs` set.
    progress : Progress

    Returns
    -------
    path : Path
        Path of the copy, which is named after the model and the CRS.
    findings : tuple of Finding

    Raises
    ------
    InputError, UsageError, TargetError, GeometryError, Cancelled
        As for `read_model` and `write_model`.
    """
    loaded_model = read_model(path, progress, options)
    code = "".join(
        character for character in (loaded_model.crs or "").casefold() if character.isalnum()
    )[:16]
    target = folder / f"{path.stem}_{code}{path.suffix}"
    folder.mkdir(exist_ok=True)
    registration = stored_registration(loaded_model, options)
    findings = write_model(
        loaded_model.data,
        loaded_model.crs,
        target,
        force=True,
        inputs=[path],
        progress=progress,
        registration=registration.registration,
    )
    return target, (*loaded_model.warnings, *registration.findings, *findings)
