"""Reconstructions begun from a script: refused, stopped, and ended with their kernel."""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import psutil
import pytest

import vomstudio as vs
from tests.messages import refused

PHOTOS = vs.sample("photos")


@pytest.mark.parametrize(
    ("photos", "more", "code", "values"),
    [
        ("none", {}, "folder.not-of-photos", {}),
        (
            PHOTOS,
            {"quality": "best"},
            "option.not-a-choice",
            {"choices": ("preview", "low", "medium", "high")},
        ),
        (PHOTOS, {"threads": 0}, "option.out-of-range", {"minimum": 1}),
        (PHOTOS, {"device": "gpu"}, "option.not-a-choice", {"choices": ("auto", "cpu", "cuda")}),
        (PHOTOS, {"crs": "EPSG:4326"}, "frame.not-projected", {}),
        (PHOTOS, {"gcp": "gone.csv"}, "file.missing", {"file": Path("gone.csv").absolute()}),
        (PHOTOS, {"progress": "loud"}, "argument.wrong-type", {"field": "progress"}),
        (PHOTOS, {"cancel": True}, "argument.wrong-type", {"expected": "vs.CancelToken"}),
    ],
)
def test_invalid_reconstruction_arguments_are_refused(
    tmp_path: Path, photos: Any, more: Any, code: str, values: dict[str, Any]
) -> None:
    with refused(code, **values):
        vs.reconstruct(photos, tmp_path / "model", **more)


def test_output_to_photo_folder_is_refused() -> None:
    with refused("folder.of-photos", vs.errors.UsageError):
        vs.reconstruct(PHOTOS, PHOTOS)


def test_token_from_another_thread_cancels_reconstruction(tmp_path: Path) -> None:
    token, begun = vs.CancelToken(), threading.Event()

    def stop() -> None:
        begun.wait(60)
        token.cancel()

    thread = threading.Thread(target=stop)
    thread.start()
    start = time.monotonic()
    with pytest.raises(vs.errors.Cancelled):
        vs.reconstruct(
            PHOTOS,
            tmp_path / "model",
            quality="preview",
            gcp="none",
            progress=lambda *_: begun.set(),
            cancel=token,
        )
    thread.join()
    assert begun.is_set()
    assert time.monotonic() - start < 60


def test_exception_in_progress_callback_stops_reconstruction(tmp_path: Path) -> None:
    def fails(stage: str, done: int, total: int | None) -> None:
        raise KeyError(stage)

    before = set(psutil.Process().children())
    with pytest.raises(KeyError):
        vs.reconstruct(PHOTOS, tmp_path / "model", quality="preview", gcp="none", progress=fails)
    after = set(psutil.Process().children()) - before
    assert not [p for p in after if p.status() != psutil.STATUS_ZOMBIE]


def test_workers_end_when_kernel_is_killed(tmp_path: Path) -> None:
    """A kernel that is killed in the middle leaves no process behind."""
    code = (
        "import vomstudio as vs\n"
        f"vs.reconstruct({str(PHOTOS)!r}, {str(tmp_path / 'model')!r}, quality='preview',\n"
        "               gcp='none', progress=lambda *a: print(a[0], flush=True))\n"
    )
    kernel = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert kernel.stdout is not None
    assert kernel.stdout.readline().strip()
    workers = psutil.Process(kernel.pid).children(recursive=True)
    assert workers
    kernel.kill()
    kernel.wait()
    kernel.stdout.close()
    _, alive = psutil.wait_procs(workers, timeout=20)
    assert not alive


@pytest.mark.slow
def test_photos_are_reconstructed_to_a_model(tmp_path: Path) -> None:
    stages: list[str] = []
    with pytest.warns(vs.errors.VomWarning) as caught:
        found = vs.reconstruct(
            PHOTOS,
            tmp_path / "model",
            quality="preview",
            threads=1,
            progress=lambda stage, done, total: stages.append(stage),
        )
    assert {each.message.code for each in caught} <= {each.code for each in found.warnings}
    assert found.registered == found.photos == 12
    assert found.frame == "EPSG:32633"
    assert stages
    model = vs.read(found.mesh)
    assert isinstance(model, vs.Mesh)
    assert len(model.faces) == found.faces
