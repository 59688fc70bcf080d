"""Workers get ready for what they will be asked, before anybody waits for them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vomstudio.core.words import tr

if TYPE_CHECKING:
    from vomstudio.studio.jobs.job import Job, Nothing
    from vomstudio.ui.base.studio import Studio


def for_models(studio: Studio) -> None:
    """The one that reads models imports its libraries."""
    from vomstudio.studio.jobs.model_tasks import IMPORT_LIBRARIES

    _ask(studio, IMPORT_LIBRARIES)


def all_workers(studio: Studio) -> None:
    """Models first, then photos, whose kernels may have to be compiled."""
    from vomstudio.geometry.kernels import compilation_state
    from vomstudio.studio.jobs.model_tasks import COMPILE_KERNELS

    for_models(studio)
    if not compilation_state.noted():
        # A worker of its own takes two seconds of a processor to find nothing to do.
        _ask(studio, COMPILE_KERNELS)


def _ask(studio: Studio, job: Job[Nothing, Nothing]) -> None:
    from vomstudio.studio.jobs.job import Nothing

    studio.jobs.submit(
        job,
        Nothing(),
        title=tr("Warming up"),
        on_done=lambda _: None,
        on_failed=lambda _: None,
        quiet=True,
    )
