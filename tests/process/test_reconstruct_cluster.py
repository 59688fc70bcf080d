"""The same reconstruction on a Dask cluster: a scheduler and two workers on loopback."""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.process.reconstruction_runs import (
    ROOT,
    Run,
    reconstruct,
    refused,
    same_to_the_bit,
    stages,
    whole,
)

pytestmark = [pytest.mark.slow, pytest.mark.skipif(os.name != "posix", reason="about signals")]


class Cluster:
    """Workers that see nothing at `hidden`, where the system lets them be blinded."""

    def __init__(self, folder: Path, hidden: list[Path]) -> None:
        self.folder, self.hidden = folder, hidden
        folder.mkdir()
        self._log = (folder / "log.txt").open("w")
        self.everyone: list[subprocess.Popen[bytes]] = []
        file = folder / "scheduler.json"
        self._start(
            "scheduler",
            "--host",
            "127.0.0.1",
            "--port",
            "0",
            "--no-dashboard",
            "--scheduler-file",
            str(file),
        )
        end = time.monotonic() + 60
        while not file.exists() or not file.read_text().strip():
            assert time.monotonic() < end
            time.sleep(0.1)
        import json

        self.address = json.loads(file.read_text())["address"]

    def _start(self, what: str, *words: str, before: tuple[str, ...] = ()) -> None:
        process = subprocess.Popen(
            [*before, sys.executable, "-m", f"distributed.cli.dask_{what}", *words],
            stdout=self._log,
            stderr=self._log,
            cwd=self.folder,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
        )
        self.everyone.append(process)

    def add_worker(self) -> subprocess.Popen[bytes]:
        self._start(
            "worker",
            self.address,
            "--nthreads",
            "1",
            "--no-nanny",
            "--no-dashboard",
            "--host",
            "127.0.0.1",
            "--local-directory",
            str(self.folder),
            before=blindfold(self.hidden),
        )
        return self.everyone[-1]

    def close(self) -> None:
        for process in self.everyone[::-1]:
            process.kill()
            process.wait(30)
        self._log.close()


def blindfold(hidden: list[Path]) -> tuple[str, ...]:
    """Words that start a program for which these folders are empty."""
    if not blindfolds():
        return ()
    mounts = "".join(f"mount -t tmpfs none '{folder}' && " for folder in hidden)
    return ("unshare", "-m", "--propagation", "private", "sh", "-c", f'{mounts}exec "$@"', "sh")


def blindfolds() -> bool:
    if shutil.which("unshare") is None or os.geteuid() != 0:
        return False
    return subprocess.run(["unshare", "-m", "true"], check=False).returncode == 0


@pytest.fixture
def hidden(photos: Path, tmp_path: Path) -> list[Path]:
    (tmp_path / "results").mkdir()
    return [photos, tmp_path / "results"]


@pytest.fixture
def cluster(tmp_path: Path, hidden: list[Path]) -> Iterator[Cluster]:
    with contextlib.closing(Cluster(tmp_path / "cluster", hidden)) as made:
        yield made


def test_cluster_without_shared_files_gives_the_same_model_after_losing_a_worker(
    photos: Path, undisturbed: Path, tmp_path: Path, cluster: Cluster
) -> None:
    out = tmp_path / "results" / "out"
    doomed, _ = cluster.add_worker(), cluster.add_worker()
    run = Run(photos, out, "--threads", 1, "--scheduler", cluster.address)
    run.until("Computing depth maps", 1)
    doomed.kill()
    end = run.end()
    assert end.code == 0, end.err
    assert end.json["registered"] == 6
    whole(out)
    same_to_the_bit(out, undisturbed)


def test_missing_workers_are_reported_and_the_run_continues_with_new_ones(
    photos: Path, undisturbed: Path, tmp_path: Path, cluster: Cluster
) -> None:
    out = tmp_path / "results" / "out"
    words = ("--threads", 1, "--scheduler", cluster.address)
    assert refused(reconstruct(photos, out, *words))["code"] == "cluster.no-workers"
    doomed = cluster.add_worker()
    run = Run(photos, out, *words)
    run.until("Computing depth maps", 1)
    doomed.kill()
    assert refused(run.end(), 1)["code"] == "cluster.workers-lost"
    before = stages(out)
    cluster.add_worker()
    again = Run(photos, out, *words)
    again.until("Looking at the surface from", 1)
    # The scheduler itself.
    cluster.everyone[0].kill()
    assert refused(again.end(), 1)["code"] == "cluster.workers-lost"
    end = reconstruct(photos, out, "--threads", 1)
    assert end.code == 0, end.err
    after = stages(out)
    assert {name: after.get(name) for name in before} == before
    same_to_the_bit(out, undisturbed)


def test_a_run_on_a_cluster_can_be_stopped(
    photos: Path, undisturbed: Path, tmp_path: Path, cluster: Cluster
) -> None:
    out = tmp_path / "results" / "out"
    cluster.add_worker()
    run = Run(photos, out, "--scheduler", cluster.address)
    run.until("Computing depth maps", 1)
    end = run.interrupt()
    assert (end.code, end.json["error"]["code"]) == (130, "cancelled")
    assert end.seconds < 15
