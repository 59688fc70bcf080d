"""Warm-up of workers before the first requests."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from vomstudio.core.words import tr

if TYPE_CHECKING:
    from vomstudio.studio.jobs.job import Job, NoArguments
    from vomstudio.ui.base.studio import Studio


def start_worker(studio: Studio) -> None:
    """Start the worker that reads models, without the libraries of the file formats."""
    from vomstudio.studio.jobs.model_tasks import START_WORKER

    _submit_job(studio, START_WORKER)


def import_libraries(studio: Studio) -> None:
    """Import the libraries of the file formats in the worker that reads models."""
    from vomstudio.studio.jobs.model_tasks import IMPORT_LIBRARIES

    _submit_job(studio, IMPORT_LIBRARIES)


def compile_kernels(studio: Studio) -> None:
    """Compile all kernels for this processor, unless this has been done."""
    from vomstudio.geometry.kernels import compilation_state
    from vomstudio.studio.jobs.model_tasks import COMPILE_KERNELS

    if not compilation_state.is_compilation_recorded():
        # Otherwise a new worker would use two seconds of processor time without any effect.
        # No other job runs in this worker, so its memory would be wasted.
        _submit_job(studio, COMPILE_KERNELS, lambda: studio.jobs.release(COMPILE_KERNELS.lane))


def _submit_job(
    studio: Studio,
    job: Job[NoArguments, NoArguments],
    completion_callback: Callable[[], object] = lambda: None,
) -> None:
    from vomstudio.studio.jobs.job import NoArguments

    def finish(_: NoArguments) -> None:
        completion_callback()

    studio.jobs.submit(
        job,
        NoArguments(),
        title=tr("Warming up"),
        on_done=finish,
        on_failed=lambda _: None,
        is_quiet=True,
    )
