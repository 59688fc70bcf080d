"""Events of a worker on their way to a busy owner."""

from __future__ import annotations

import subprocess
import sys
import threading

import pytest

from tests.studio.jobs.odd_jobs import COUNT, To
from vomstudio.studio.running_jobs import Jobs


class Owner:
    """Does what is posted when it is told to, as a window does when it comes to it."""

    def __init__(self) -> None:
        self.calls: list = []
        self.came = threading.Condition()

    def post(self, call) -> None:
        with self.came:
            self.calls.append(call)
            self.came.notify_all()

    def work(self) -> int:
        """How many calls there were."""
        with self.came:
            calls, self.calls = self.calls, []
        for call in calls:
            call()
        return len(calls)


@pytest.fixture
def owner(monkeypatch):
    real = subprocess.Popen

    def start(words, **more):
        return real([sys.executable, "-P", "-m", "tests.studio.jobs.odd_jobs"], **more)

    monkeypatch.setattr("vomstudio.studio.jobs.supervisor.subprocess.Popen", start)
    return Owner()


@pytest.fixture
def jobs(owner):
    made = Jobs(owner.post)
    yield made
    made.close()


def begin(jobs: Jobs, to: int) -> tuple[list, list]:
    ended: list = []
    job = jobs.submit(COUNT, To(to), title="", on_done=ended.append, on_failed=ended.append)
    seen: list[tuple[str, int]] = []
    jobs.changed.connect(lambda: seen.append((job.stage, job.done)))
    return ended, seen


def test_busy_owner_receives_only_the_newest_step(owner, jobs):
    ended, seen = begin(jobs, 300)
    jobs.finish(COUNT.lane, 60.0)
    # Stage, newest step, end.
    assert owner.work() <= 3
    assert len(ended) == 1
    assert ("counting", 299) in seen


def test_idle_owner_receives_steps_in_order(owner, jobs):
    ended, seen = begin(jobs, 20)
    while not ended:
        with owner.came:
            assert owner.came.wait_for(lambda: owner.calls, 20.0)
        owner.work()
    steps = [done for _, done in seen]
    assert steps == sorted(steps)
    assert steps[-1] == 19
