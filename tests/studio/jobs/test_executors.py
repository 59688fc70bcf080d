"""The same work on threads and on a cluster."""

import subprocess
import sys
import threading
import time
from contextlib import contextmanager

import pytest

from tests.messages import refused
from vomstudio.core.errors import Cancelled, InputError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import CancelToken, InlineExecutor, SilentProgress
from vomstudio.studio.jobs.executors import Cluster, Threads, make_executor


def square(value):
    return value * value


def fail_at_three(value):
    if value == 3:
        raise InputError(Finding("file.empty"), file=f"{value}.jpg")
    return value


def slow(value):
    time.sleep(0.05)
    return value


class Counting:
    def __init__(self):
        self.steps = []

    def stage(self, name, total=None):
        pass

    def step(self, done):
        self.steps.append(done)


@contextmanager
def cluster(workers=2):
    """A scheduler and workers of their own on loopback."""
    import distributed

    made = distributed.LocalCluster(
        n_workers=workers,
        threads_per_worker=1,
        host="127.0.0.1",
        dashboard_address=None,
        silence_logs=50,
    )
    try:
        yield made
    finally:
        made.close()


@pytest.mark.parametrize("make", [InlineExecutor, lambda: Threads(2)])
def test_every_item_is_processed_once_and_counted(make):
    progress = Counting()
    found = dict(make().map(square, range(20), progress))
    assert found == {n: n * n for n in range(20)}
    assert progress.steps == sorted(progress.steps)


def test_items_are_generated_lazily():
    made = []

    def items():
        for n in range(100):
            made.append(n)
            yield n

    results = Threads(2).map(slow, items(), SilentProgress())
    next(results)
    assert len(made) < 8
    results.close()


@pytest.mark.parametrize("make", [InlineExecutor, lambda: Threads(2)])
def test_error_of_an_item_is_raised(make):
    with refused("file.empty", file="3.jpg"):
        list(make().map(fail_at_three, range(6), SilentProgress()))


def test_cancelling_interrupts_the_current_item():
    token = CancelToken()
    threading.Timer(0.3, token.cancel).start()
    begun = time.monotonic()
    with pytest.raises(Cancelled):
        list(Threads(1).map(time.sleep, [3.0, 3.0], SilentProgress(token)))
    assert time.monotonic() - begun < 2.0


def test_one_thread_gives_the_inline_executor():
    assert isinstance(make_executor(1), InlineExecutor)


@pytest.mark.full  # ten seconds until the connection is given up
def test_unreachable_scheduler_is_named():
    with pytest.raises(UsageError, match=r"127\.0\.0\.1:1"):
        make_executor(None, "tcp://127.0.0.1:1")


@pytest.mark.filterwarnings("ignore")
def test_cluster_gives_the_same_results():
    with cluster() as made:
        executor = Cluster(made.scheduler_address)
        try:
            assert executor.workers == 2
            assert dict(executor.map(square, range(9), SilentProgress())) == {
                n: n * n for n in range(9)
            }
            with refused("file.empty", file="3.jpg"):
                list(executor.map(fail_at_three, range(6), SilentProgress()))
        finally:
            executor.close()


def test_missing_dask_error_names_the_extra():
    code = (
        "import sys; sys.modules['distributed'] = None\n"
        "from vomstudio.studio.jobs.executors import make_executor\n"
        "try: make_executor(None, 'tcp://127.0.0.1:8786')\n"
        "except Exception as error: print(error)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "vomstudio[cluster]" in done.stdout
