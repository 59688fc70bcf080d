"""Reconstruction of a model from photos."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal

from vomstudio.api.checking import (
    join_numbers,
    numbers,
    path_text,
    to_path,
    warn,
)
from vomstudio.api.declared_options import name_arguments_in_errors, options_from_arguments
from vomstudio.api.reporting import ProgressArgument, to_progress
from vomstudio.core.progress import CancelToken
from vomstudio.studio.jobs.reconstruct_options import ReconstructOptions
from vomstudio.studio.jobs.reconstruction_tasks import Reconstruction


def reconstruct(
    photos: str | Path,
    folder: str | Path,
    *,
    quality: Literal["preview", "low", "medium", "high"] = "medium",
    gcp: str | Path | None = None,
    marks: str | Path | None = None,
    crs: str | None = None,
    scheduler: str | None = None,
    threads: int | None = None,
    seed: int = 0,
    device: Literal["auto", "cpu", "cuda"] = "auto",
    region: Sequence[float] | None = None,
    keep_background: bool = False,
    progress: ProgressArgument = None,
    cancel: CancelToken | None = None,
) -> Reconstruction:
    """Reconstruct a dense cloud and a textured mesh from photos, in a separate process.

    Parameters
    ----------
    photos : str or Path
        Folder of photos.
    folder : str or Path
        Folder for the model; a stopped reconstruction continues in the same folder.
    quality : {"preview", "low", "medium", "high"}, optional
        Resolution at which the photos are used.
    gcp, marks : str or Path, optional
        Tables of control points and of their marks in the photos; by default those in or
        next to the folder of the photos. If ``gcp`` is "none", no control points are used.
    crs : str, optional
        CRS of the model, in metres, such as "EPSG:32615".
    scheduler : str, optional
        Address of a Dask cluster; by default this computer is used.
    threads : int, optional
        Number of threads on this computer; by default all are used.
    seed : int, optional
        Seed of random numbers.
    device : {"auto", "cpu", "cuda"}, optional
        Device for the depth maps; "auto" selects the GPU if the installed COLMAP supports
        it.
    region : sequence of float, optional
        Minimum and maximum corners (x0, y0, z0, x1, y1, z1) of the part to reconstruct, in
        the frame of the model.
    keep_background : bool, optional
        Whether to reconstruct the background far behind the rock; ignored if a region is given.
    progress : callable or Progress, optional
        Called with (stage, completed steps, total steps or None).
    cancel : vs.CancelToken, optional
        Token that stops the computation.

    Returns
    -------
    Reconstruction
        ``photos``, ``registered``, ``unregistered``, ``reprojection_error_px``, ``mesh``,
        ``dense``, ``cameras``, ``frame``, ``seconds`` and others.

    Raises
    ------
    vs.errors.Cancelled
        After Ctrl+C, an interrupted kernel, or ``cancel``; completed stages remain.
    vs.errors.InputError, vs.errors.UsageError
        Under the same conditions as for the command.
    vs.errors.WorkerError
        If the process terminated unexpectedly. Closing or killing the kernel also ends the
        process.

    Examples
    --------
    A folder without photos is rejected before the reconstruction starts:

    >>> import tempfile
    >>> import vomstudio as vs
    >>> vs.reconstruct(tempfile.gettempdir() + "/none", "model")
    Traceback (most recent call last):
    vomstudio.core.errors.InputError: ...none: This is not a photo folder. Choose another folder.
    """
    from vomstudio.studio.jobs.reconstruction_requests import reconstruction_request
    from vomstudio.studio.jobs.reconstruction_tasks import RECONSTRUCT
    from vomstudio.studio.jobs.run_job import run_job

    report = to_progress(progress, cancel)
    options = options_from_arguments(
        ReconstructOptions,
        locals(),
        gcp=path_text(gcp, "gcp"),
        marks=path_text(marks, "marks"),
        region=None if region is None else join_numbers(numbers(region, "region")),
    )
    with name_arguments_in_errors(ReconstructOptions):
        order, findings = reconstruction_request(
            to_path(photos, "photos"), to_path(folder, "folder"), options
        )
    result = run_job(RECONSTRUCT, order, report, cancel)
    result = replace(result, warnings=(*findings, *result.warnings))
    warn(result.warnings)
    return result
