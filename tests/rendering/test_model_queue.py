"""Models on their way to the scene."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from tests.tiers import first_in_default_tier
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.rendering.prepare.model_queue import ModelQueue


def _mesh() -> Mesh:
    return Mesh(np.eye(3), np.array([[0, 1, 2]], np.int32))


def _cloud() -> PointCloud:
    return PointCloud(np.random.default_rng(1).random((100, 3)))


@pytest.mark.parametrize(
    "data", first_in_default_tier([_mesh(), _cloud()], 1), ids=["mesh", "cloud"]
)
def test_closing_the_queue_during_a_submission_reports_no_error(
    data: Mesh | PointCloud, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A thread that has told the size of its model has the next piece of work to submit, and its
    pool is shut by then. The log guard sees what it reports."""
    arrived, shut = threading.Event(), threading.Event()
    real = ThreadPoolExecutor.shutdown

    def shutdown(
        pool: ThreadPoolExecutor, wait: bool = True, *, cancel_futures: bool = False
    ) -> None:
        real(pool, wait=False, cancel_futures=cancel_futures)
        shut.set()
        real(pool, wait=wait)

    def hold() -> None:
        arrived.set()
        shut.wait(10.0)

    monkeypatch.setattr(ThreadPoolExecutor, "shutdown", shutdown)
    work = ModelQueue(hold)
    work.expect("m1")
    work.prepare("m1", data, texture_limit=1024, max_whole_side=None, budget=1000)
    assert arrived.wait(10.0)
    work.close()
    assert work.next_event() is None
