"""All jobs of a worker, by name."""

from __future__ import annotations

from typing import Any

from vomstudio.jobs import (
    inspection_tasks,
    model_tasks,
    photo_tasks,
    product_tasks,
    proposal_tasks,
    reconstruction_tasks,
    registration_tasks,
    surface_tasks,
    survey_tasks,
)
from vomstudio.jobs.job import Job

TASKS: dict[str, Job[Any, Any]] = {
    job.name: job
    for module in (
        model_tasks,
        product_tasks,
        photo_tasks,
        reconstruction_tasks,
        registration_tasks,
        surface_tasks,
        proposal_tasks,
        survey_tasks,
        inspection_tasks,
    )
    for job in module.JOBS
}
