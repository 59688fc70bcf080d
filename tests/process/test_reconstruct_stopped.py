"""A reconstruction that is stopped, killed, or runs out of disk goes on where it was."""

from __future__ import annotations

import errno
import os
import signal
from pathlib import Path

import pytest

from tests.process.reconstruction_runs import (
    Run,
    gsd_apart,
    log_of,
    reconstruct,
    refused,
    same_to_the_bit,
    stages,
    whole,
)
from tests.small_disk import small_disk
from vomstudio.studio.jobs.worker_exits import exit_text

pytestmark = pytest.mark.skipif(os.name != "posix", reason="about POSIX signals")
ONE = ("--threads", 1)
# (name of a stage in the progress, how many of its steps are done)
EVERY_STAGE = [
    ("Checking photos", 0),
    ("Detecting features", 3),
    ("Matching photos", 0),
    ("Matching photos", 15),
    ("Computing poses", 0),
    ("Bundle adjustment", 0),
    ("Registering the model", 0),
    ("Undistorting photos", 2),
    ("Computing depth maps", 0),
    ("Computing depth maps", 4),
    ("Fusing depth maps", 3),
    ("Measuring the point spacing", 0),
    ("Computing the Poisson", 0),
    ("Refining the surface", 0),
    ("Decimating", 0),
    ("Checking the surface", 0),
    ("Computing visibility", 3),
    ("Creating texture charts", 0),
    ("Packing texture charts", 0),
    ("Blending", 2),
    ("Rendering the texture", 0),
    ("Writing the model", 0),
]


DEPTH_MAPS = "Computing depth maps"
FULL_DISK = ("disk.full", "disk.failed", "reconstruct.not-written", "output.unwritable")


def stopped(run: Run, how: str) -> None:
    if how == "worker":
        error = refused(run.kill_worker(), 1)
        assert error["code"] == "job.worker-died"
        assert error["ending"] == exit_text(-signal.SIGKILL)
    elif how == "program":
        run.kill()
    else:
        end = run.interrupt()
        assert "error" in end.json, end.err[-1000:]
        assert end.json["error"]["code"] == "cancelled"
        assert end.code == 130
        assert "Traceback" not in end.err
        # Native code that hears nothing is killed after three seconds.
        assert end.seconds < 15


def stop_at(photos: Path, out: Path, how: str, stage: str, step: int, *words: object) -> None:
    """And the stages that were finished before stay as they are."""
    before = stages(out)
    run = Run(photos, out, *words)
    run.until(stage, step)
    stopped(run, how)
    after = stages(out)
    assert {name: after.get(name) for name in before} == before
    assert not (out / "reconstruction.json").exists()


@pytest.mark.full
def test_run_stopped_in_three_ways_ends_with_the_same_model(
    photos: Path, undisturbed: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    stop_at(photos, out, "worker", "Matching photos", 0, *ONE)
    stop_at(photos, out, "program", DEPTH_MAPS, 4, *ONE)
    depths = {p.name: p.stat().st_mtime_ns for p in out.glob("work/depths-*.part/*.npz")}
    assert len(depths) >= 4
    stop_at(photos, out, "interrupt", "Computing the Poisson", 0, *ONE)
    assert "Detecting features" not in log_of(out)
    now = {p.name: p.stat().st_mtime_ns for p in out.glob("work/depths-*/*.npz")}
    assert {name: now[name] for name in depths} == depths, "photos are not done twice"
    end = reconstruct(photos, out, *ONE)
    assert end.code == 0, end.err
    assert DEPTH_MAPS not in log_of(out)
    assert end.json["registered"] == 6
    whole(out)
    same_to_the_bit(out, undisturbed)


@pytest.mark.slow
@pytest.mark.parametrize("how", ["worker", "program", "interrupt"])
def test_run_stopped_in_every_stage_ends_with_the_same_model(
    photos: Path, undisturbed: Path, tmp_path: Path, how: str
) -> None:
    out = tmp_path / "out"
    for stage, step in EVERY_STAGE:
        stop_at(photos, out, how, stage, step, *ONE)
    end = reconstruct(photos, out, *ONE)
    assert end.code == 0, end.err
    whole(out)
    same_to_the_bit(out, undisturbed)


@pytest.mark.slow
@pytest.mark.parametrize("stage", ["Detecting features", "Matching photos", "Computing poses"])
def test_stopped_parallel_alignment_gives_the_same_cameras(
    photos: Path, undisturbed: Path, tmp_path: Path, stage: str
) -> None:
    out = tmp_path / "out"
    stop_at(photos, out, "worker", stage, 2 if stage == "Detecting features" else 0)
    assert reconstruct(photos, out).code == 0
    assert gsd_apart(out, undisturbed) < 1


@pytest.mark.full
def test_full_disk_is_reported_and_the_run_resumes_when_space_is_free(
    photos: Path, undisturbed: Path, tmp_path: Path
) -> None:
    with small_disk(tmp_path / "disk") as disk:
        error = refused(reconstruct(photos, disk / "out", *ONE))
        assert error["code"] in FULL_DISK
        before = stages(disk / "out")
        assert any(name.startswith("alignment") for name in before)
        os.system(f"mount -o remount,size=64m '{disk}'")
        end = reconstruct(photos, disk / "out", *ONE)
        assert end.code == 0, end.err
        after = stages(disk / "out")
        assert {name: after.get(name) for name in before} == before
        whole(disk / "out")
        same_to_the_bit(disk / "out", undisturbed)


@pytest.mark.slow
def test_full_disk_at_any_moment_leaves_no_partial_files(
    photos: Path, undisturbed: Path, tmp_path: Path
) -> None:
    with small_disk(tmp_path / "disk", 200) as disk:
        for kib in (200, 1000, 1500, 2000, 3000, 5000, 8000, 12000, 16000, 18000, 20000, 28000):
            os.system(f"mount -o remount,size={kib}k '{disk}'")
            error = refused(reconstruct(photos, disk / "out", *ONE))
            assert error["code"] in FULL_DISK
            assert error["code"] == "disk.full" or os.strerror(errno.ENOSPC) in error["reason"]
            assert not (disk / "out" / "reconstruction.json").exists()
        os.system(f"mount -o remount,size=64m '{disk}'")
        assert reconstruct(photos, disk / "out", *ONE).code == 0
        whole(disk / "out")
        same_to_the_bit(disk / "out", undisturbed)


@pytest.mark.full
def test_two_runs_cannot_use_the_same_folder(photos: Path, tmp_path: Path) -> None:
    first = Run(photos, tmp_path / "out")
    first.until("Detecting features", 1)
    worker = first.worker()
    worker.suspend()
    try:
        error = refused(reconstruct(photos, tmp_path / "out"))
        assert error["code"] == "output.folder-in-use"
        assert str(worker.pid) in error["holder"]
    finally:
        worker.resume()
    # The first one is none the worse for it.
    first.until("Matching photos")
    stopped(first, "interrupt")
