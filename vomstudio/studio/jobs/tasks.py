"""All jobs of a worker, by name."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from vomstudio.studio.jobs.job import Job

TASKS: dict[str, Job[Any, Any]] = {}
"""Those that were asked for, and what stands beside them; others are found by `task_of`."""


def task_of(name: str) -> Job[Any, Any] | None:
    """The job of that name, None where there is none. Only what leads to it is loaded: whoever
    opens a model waits for that and not for what photos need."""
    for jobs in () if name in TASKS else _jobs():
        TASKS.update((job.name, job) for job in jobs)
        if name in TASKS:
            break
    return TASKS.get(name)


def _jobs() -> Iterator[tuple[Job[Any, Any], ...]]:
    """Module by module, what is asked for first and is loaded fastest before the others."""
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
