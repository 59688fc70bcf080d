"""Registry of all jobs of a worker, keyed by name."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from vomstudio.studio.jobs.job import Job

TASKS: dict[str, Job[Any, Any]] = {}
"""Jobs of the modules that have been imported so far, keyed by name; `find_task` imports others."""


def find_task(name: str) -> Job[Any, Any] | None:
    """Return the job with a name, or None if the name is unknown.

    Modules are imported one by one until the job is found, because opening a model must not wait
    for the modules of photos.
    """
    for jobs in () if name in TASKS else _jobs():
        TASKS.update((job.name, job) for job in jobs)
        if name in TASKS:
            break
    return TASKS.get(name)


def _jobs() -> Iterator[tuple[Job[Any, Any], ...]]:
    """Yield the jobs of each module, starting with the jobs that are needed first."""
    from vomstudio.studio.jobs import model_tasks

    yield model_tasks.JOBS
    from vomstudio.studio.jobs import layer_tasks

    yield layer_tasks.JOBS
    from vomstudio.studio.jobs import inspection_tasks, reconstruction_tasks, survey_tasks

    yield (*reconstruction_tasks.JOBS, *survey_tasks.JOBS, *inspection_tasks.JOBS)
    from vomstudio.studio.jobs import photo_tasks

    yield photo_tasks.JOBS
    from vomstudio.studio.jobs import (
        drawing_tasks,
        product_tasks,
        proposal_tasks,
        registration_tasks,
        surface_tasks,
    )

    yield (
        *drawing_tasks.JOBS,
        *product_tasks.JOBS,
        *registration_tasks.JOBS,
        *surface_tasks.JOBS,
        *proposal_tasks.JOBS,
    )
