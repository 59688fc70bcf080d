"""Kernels that are kept on the disk: loaded without numba, and never when something has changed."""

from __future__ import annotations

import importlib
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.tiers import first_in_default_tier
from vomstudio.geometry.kernels import machine_code
from vomstudio.geometry.kernels.jit import Kernel, kernel, part
from vomstudio.geometry.kernels.sources import KernelPart, KernelSource

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="numba's own cache does it there")

MODULE = """
import numpy as np
from vomstudio.geometry.kernels.jit import kernel, part

TABLE = np.arange(3.0)
FACTOR = 2.0

@part
def scaled(x):
    return x * FACTOR

@kernel("f8(f8)")
def work(x):
    return scaled(x) + TABLE[1]
"""
USE = "import kernel_file, sys; print(kernel_file.work(1.5), 'numba' in sys.modules)"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where machine code is kept."""
    kept = tmp_path / "kept"
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(kept))
    return kept


def used(folder: Path, text: str = MODULE) -> tuple[float, bool]:
    """What the kernel gives in a new process, and whether that imports numba."""
    (folder.parent / "kernel_file.py").write_text(text)
    words = [sys.executable, "-B", "-c", USE]
    done = subprocess.run(
        words, cwd=folder.parent, capture_output=True, text=True, check=True, timeout=120
    )
    number, imported = done.stdout.split()
    return float(number), imported == "True"


@pytest.mark.full
def test_cached_code_runs_without_numba(folder: Path) -> None:
    assert used(folder) == (4.0, True)
    assert used(folder) == (4.0, False)


@pytest.mark.parametrize(
    ("old", "new", "wanted"),
    first_in_default_tier(
        [
            ("FACTOR = 2.0", "FACTOR = 4.0", 7.0),
            ("np.arange(3.0)", "np.arange(3.0) + 1", 5.0),
            ("x * FACTOR", "x - FACTOR", 0.5),
            ("TABLE[1]", "TABLE[2]", 5.0),
        ],
        1,
    ),
)
def test_any_change_triggers_recompilation(folder: Path, old: str, new: str, wanted: float) -> None:
    assert used(folder)[0] == 4.0
    assert used(folder, MODULE.replace(old, new)) == (wanted, True)


@pytest.mark.full
def test_damaged_code_is_never_run(folder: Path) -> None:
    used(folder)
    (file,) = folder.glob("*.code")
    whole = file.read_bytes()
    flipped = whole[:-100] + bytes([whole[-100] ^ 1]) + whole[-99:]
    for damaged in (b"", whole[:-1], flipped):
        file.write_bytes(damaged)
        assert used(folder) == (4.0, True)
        assert file.read_bytes() == whole


def test_kernel_works_if_cache_is_not_writable(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder.write_text("a file where the folder should be")
    assert kernel("f8(f8)")(lambda x: 2.0 * x)(1.5) == 3.0


def test_old_code_does_not_pile_up(folder: Path) -> None:
    def work(x):  # type: ignore[no-untyped-def]
        return x + 1

    folder.mkdir()
    for k in range(20):
        (folder / f"{__name__}.work-{k:032x}.code").write_bytes(b"")
    assert kernel("i8(i8)")(work)(1) == 2
    assert len(list(folder.glob("*.code"))) <= 8


def test_file_name_depends_on_all_called_parts() -> None:
    def get_name(factor: float) -> str:
        inner = part(lambda x: x * factor)
        outer = part(lambda x: inner(x) + 1.0)
        return machine_code._file_name(KernelSource(lambda x: outer(x), "f8(f8)", False))

    assert get_name(2.0) == get_name(2.0) != get_name(3.0)


@pytest.mark.full
def test_kernels_with_the_same_name_stay_separate(folder: Path) -> None:
    """As LLVM names them they may be the same, having been compiled in processes of their own."""
    texts = [MODULE.replace("FACTOR = 2.0", f"FACTOR = {factor}") for factor in (2.0, 6.0)]
    for text in texts:
        used(folder, text)
    made = []
    for text in texts:
        names: dict[str, Any] = {"__name__": "kernel_file"}
        exec(compile(text, "kernel_file.py", "exec"), names)
        made.append(names["work"])
    assert [work(1.5) for work in made] == [4.0, 10.0]


def test_file_name_depends_on_signature_and_options() -> None:
    def half(x):  # type: ignore[no-untyped-def]
        return x / 2

    def get_name(signature: str, fast: bool, piece: KernelPart) -> str:
        return machine_code._file_name(KernelSource(lambda x: piece(x), signature, fast))

    names = set()
    for signature, fast, options in [
        ("f8(f8)", False, {}),
        ("f4(f4)", False, {}),
        ("f8(f8)", True, {}),
        ("f8(f8)", False, {"fastmath": True}),
    ]:
        for _ in range(2):
            names.add(get_name(signature, fast, KernelPart(half, **options)))
    assert len(names) == 4


@pytest.mark.full
@pytest.mark.parametrize("module", ["_obj_kernels", "_ply_kernels", "_polygon_kernels"])
def test_no_reader_needs_numba(module: str) -> None:
    """Else every small command would wait for its import."""
    holder = importlib.import_module(f"vomstudio.io.models.formats.{module}")
    kernels = [v for v in vars(holder).values() if isinstance(v, Kernel)]
    assert kernels
    assert all(
        machine_code.entry(one.source, one.compile_with_numba) is not None for one in kernels
    )


def test_large_arrays_work_in_many_threads(folder: Path) -> None:
    """The entry is the same for all threads, each with its own arguments."""
    from concurrent.futures import ThreadPoolExecutor

    def add(a, out):  # type: ignore[no-untyped-def]
        total = 0.0
        for i in range(a.shape[0]):
            total += a[i]
        out[0] = total

    summed = kernel("void(f8[::1], f8[::1])")(add)
    rng = np.random.default_rng(1)
    arrays = [rng.integers(0, 1000, 200_000).astype(np.float64) for _ in range(8)]
    outs = [np.zeros(1) for _ in arrays]
    with ThreadPoolExecutor(8) as pool:
        list(pool.map(summed, arrays, outs))
    assert [out[0] for out in outs] == [a.sum() for a in arrays]
