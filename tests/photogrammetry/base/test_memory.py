"""Sizes and numbers are lowered rather than the machine brought down."""

import threading
import time

import pytest

from vomstudio.core.progress import SilentProgress
from vomstudio.photogrammetry.base import checkpoints, memory
from vomstudio.photogrammetry.base.checkpoints import Checkpoints
from vomstudio.photogrammetry.dense import depthmaps, fusion, memory_estimate, undistortion
from vomstudio.photogrammetry.surface import meshing
from vomstudio.studio.jobs.executors import Threads

GB = 10**9


@pytest.fixture
def free(monkeypatch):
    def of(gigabytes):
        monkeypatch.setattr(memory, "available_bytes", lambda: round(gigabytes * GB))

    return of


def test_number_of_parallel_photos_is_limited_by_memory(free):
    free(4)
    running, most = 0, 0
    lock = threading.Lock()

    def work(item):
        nonlocal running, most
        with lock:
            running += 1
            most = max(most, running)
        time.sleep(0.02)
        with lock:
            running -= 1
        return item

    assert len(list(Threads(8).map(work, range(16), SilentProgress(), GB))) == 16
    assert most == 2


def test_at_least_one_photo_is_processed(free):
    free(0.1)
    assert memory.worker_count(GB, 8) == 1
    free(1000)
    assert memory.worker_count(GB, 8) == 8


def test_fitting_photos_are_processed_at_the_requested_size(free):
    free(16)
    assert memory_estimate.fitting_size(3200, [(6000, 4000)] * 12) == 3200


def test_little_memory_or_many_photos_reduce_the_photo_size(free):
    free(3)
    small = memory_estimate.fitting_size(3200, [(6000, 4000)] * 12)
    assert small < 3200
    pixels = round(small * small / 1.5)
    assert depthmaps.peak_memory_bytes(small, round(small / 1.5)) < 0.7 * 3 * GB
    assert fusion.peak_memory_bytes(12 * pixels, pixels) < 1.01 * 0.7 * 3 * GB
    free(16)
    assert memory_estimate.fitting_size(3200, [(6000, 4000)] * 1000) < 1600


def test_little_memory_reduces_the_points_of_the_surface(free):
    free(2)
    assert meshing.max_points_in_memory() * meshing._BYTES_PER_POINT <= 0.7 * 2 * GB
    free(100)
    assert meshing.max_points_in_memory() == meshing.MeshingOptions.max_points


def test_undistorting_100_megapixels_takes_the_measured_memory():
    """`tests/benchmarks/bench_memory`: 648 MB to 3200 pixels, 2110 MB to its own size."""
    assert 648e6 < undistortion.peak_memory_bytes(12000, 9000, 3200) < 1300e6
    assert 2110e6 < undistortion.peak_memory_bytes(12000, 9000, None) < 4200e6


def test_memory_peak_of_a_stopped_run_is_included(tmp_path, monkeypatch):
    monkeypatch.setattr(checkpoints, "peak_bytes", lambda: 5 * GB)
    Checkpoints(tmp_path).stage("straight").finish()
    Checkpoints(tmp_path).stage("depths").pause()
    monkeypatch.setattr(checkpoints, "peak_bytes", lambda: GB)
    now = Checkpoints(tmp_path)
    assert now.stage("straight").peak_bytes == 5 * GB
    now.stage("depths").finish()
    assert Checkpoints(tmp_path).stage("depths").peak_bytes == 5 * GB
    assert Checkpoints(tmp_path).stage("cloud").peak_bytes == GB
