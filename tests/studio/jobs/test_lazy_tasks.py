"""A worker loads what its job needs, and no more."""

from __future__ import annotations

import subprocess
import sys

LOADED = """
import sys
from vomstudio.studio.jobs.tasks import find_task
assert find_task({name!r}).name == {name!r}
jobs = [m for m in sys.modules if m.startswith("vomstudio.studio.jobs.")]
print(*sorted(m for m in jobs if m.endswith("_tasks")))
"""


def loaded_for(name: str) -> set[str]:
    done = subprocess.run(
        [sys.executable, "-c", LOADED.format(name=name)], capture_output=True, text=True, check=True
    )
    return {module.rpartition(".")[2] for module in done.stdout.split()}


def test_opening_a_model_waits_for_no_other_jobs() -> None:
    assert loaded_for("load_model") == {"model_tasks"}


def test_checking_photos_waits_for_no_products() -> None:
    assert not loaded_for("check_photos") & {"product_tasks", "registration_tasks", "surface_tasks"}


def test_an_orthophoto_is_found_behind_all_of_them() -> None:
    assert "product_tasks" in loaded_for("orthophoto")


def test_no_job_of_a_user_waits_for_the_compilation_of_kernels() -> None:
    """It takes minutes, and its process has a low priority."""
    from vomstudio.studio.jobs import tasks
    from vomstudio.studio.jobs.model_tasks import COMPILE_KERNELS

    assert tasks.find_task("no such job") is None
    same_lane = [job.name for job in tasks.TASKS.values() if job.lane is COMPILE_KERNELS.lane]
    assert same_lane == [COMPILE_KERNELS.name]
