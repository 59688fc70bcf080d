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


def test_load_model_imports_only_model_tasks() -> None:
    assert loaded_for("load_model") == {"model_tasks"}


def test_check_photos_does_not_import_other_tasks() -> None:
    assert not loaded_for("check_photos") & {"product_tasks", "registration_tasks", "surface_tasks"}


def test_orthophoto_imports_product_tasks() -> None:
    assert "product_tasks" in loaded_for("orthophoto")


def test_kernel_compilation_has_its_own_lane() -> None:
    """It takes minutes, and its process has a low priority."""
    from vomstudio.studio.jobs import tasks
    from vomstudio.studio.jobs.model_tasks import COMPILE_KERNELS

    assert tasks.find_task("no such job") is None
    same_lane = [job.name for job in tasks.TASKS.values() if job.lane is COMPILE_KERNELS.lane]
    assert same_lane == [COMPILE_KERNELS.name]
