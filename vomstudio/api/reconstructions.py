"""Photos to a model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal

from vomstudio.api.checking import (
    joined,
    numbers,
    path_of,
    path_text,
    warn,
    words_of,
)
from vomstudio.api.declared_options import arguments_named, options_from_arguments
from vomstudio.api.reporting import Reported, told
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
    progress: Reported = None,
    cancel: CancelToken | None = None,
) -> Reconstruction:
    """Align photos and make a dense cloud, a mesh and its texture, in a process of its own.

    Parameters
    ----------
    photos : folder of photos
    folder : for the model; with the same one it goes on where it was stopped
    quality : how much of the photos' resolution is used
    gcp, marks : tables of control points and of their marks in the photos; None for those in or
        beside the folder of the photos, "none" for ``gcp`` to do without
    crs : of the model, in metres, such as "EPSG:32615"
    scheduler : address of a Dask cluster; None for this machine
    threads : of this machine, None for all; seed : of what is random
    device : for the depth maps; "auto" takes the GPU where the installed COLMAP can use one
    region : (6,) x0, y0, z0, x1, y1, z1, lowest and highest corner of the box of which a model
        is made and nothing else, in the frame of the model
    progress : called with (stage, steps done, all steps or None), or a Progress
    cancel : a vs.CancelToken whose ``cancel()``, called from another thread, stops the work

    Returns
    -------
    Reconstruction with the names of the command: ``photos``, ``registered``, ``unregistered``,
    ``reprojection_error_px``, ``mesh``, ``dense``, ``cameras``, ``frame``, ``seconds`` ...

    Raises
    ------
    vs.errors.Cancelled after Ctrl+C, an interrupted kernel, or ``cancel``; what is finished is
    kept. vs.errors.InputError, vs.errors.UsageError as the command. vs.errors.WorkerError where
    the process died. A kernel that is closed or killed ends that process.

    Examples
    --------
    A folder without photos is refused before anything is begun:

    >>> import tempfile
    >>> import vomstudio as vs
    >>> vs.reconstruct(tempfile.gettempdir() + "/none", "model")
    Traceback (most recent call last):
    vomstudio.core.errors.InputError: ...none: This is not a folder of photos. Choose another.
    """
    from vomstudio.studio.jobs.reconstruction_requests import reconstruction_request
    from vomstudio.studio.jobs.reconstruction_tasks import RECONSTRUCT
    from vomstudio.studio.jobs.run_job import run_job

    report = told(progress, cancel)
    options = options_from_arguments(
        ReconstructOptions,
        quality=quality,
        gcp=path_text(gcp, "gcp"),
        marks=path_text(marks, "marks"),
        crs=words_of(crs, "crs"),
        scheduler=words_of(scheduler, "scheduler"),
        threads=threads,
        seed=seed,
        device=device,
        region=None if region is None else joined(numbers(region, "region")),
    )
    with arguments_named(ReconstructOptions):
        order, findings = reconstruction_request(
            path_of(photos, "photos"), path_of(folder, "folder"), options
        )
    result = run_job(RECONSTRUCT, order, report, cancel)
    result = replace(result, warnings=(*findings, *result.warnings))
    warn(result.warnings)
    return result
