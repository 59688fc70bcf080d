"""Compiled kernels are cached in the user's folder, never beside the program, and never stale."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

PARTS = """
from vomstudio.geometry.kernels.jit import part

@part
def scaled(x):
    return x * 2.0
"""
KERNELS = """
from kernel_parts import scaled
from vomstudio.geometry.kernels.jit import kernel

@kernel("f8(f8)")
def simple(x):
    return scaled(x) + 1.0

@kernel("f8(f8[::1])")
def allocating(a):
    return scaled((a + a).sum())
"""
# Prints the results and how often numba compiled a kernel instead of loading it.
RUN = """
import numpy as np
from some_kernels import allocating, simple

results = simple(1.5), allocating(np.arange(4.0))
kernels = allocating.compile_with_numba(), simple.compile_with_numba()
compiled = sum(n for each in kernels for n in each.stats.cache_misses.values())
print(*results, compiled)
"""


@pytest.fixture
def site_packages(tmp_path: Path) -> Path:
    """A folder of installed modules, one with kernels and one with a part that they call."""
    folder = tmp_path / "site-packages"
    folder.mkdir()
    (folder / "kernel_parts.py").write_text(PARTS)
    (folder / "some_kernels.py").write_text(KERNELS)
    return folder


def run(site_packages: Path, **environment: str) -> list[float]:
    values = {k: v for k, v in os.environ.items() if k != "NUMBA_CACHE_DIR"}
    values |= {name: str(site_packages.parent / name) for name in ("HOME", "XDG_STATE_HOME")}
    values |= {"XDG_CACHE_HOME": str(site_packages.parent / "cache")}
    values["PYTHONPATH"] = os.pathsep.join([str(site_packages), *filter(None, sys.path)])
    done = subprocess.run(
        [sys.executable, "-B", "-c", RUN],
        env=values | environment,
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    return [float(word) for word in done.stdout.split()]


@pytest.mark.full
@pytest.mark.skipif(sys.platform != "linux", reason="the cache folder is named by XDG_CACHE_HOME")
def test_kernels_are_cached_in_the_users_folder_and_compiled_once(site_packages: Path) -> None:
    before = sorted(site_packages.iterdir())
    assert run(site_packages)[:2] == [4.0, 24.0]
    cache = site_packages.parent / "cache" / "vomstudio" / "kernels"
    cached = sorted(path for path in cache.rglob("*") if path.is_file())
    assert {path.suffix for path in cached} >= {".code", ".nbi", ".nbc"}
    assert run(site_packages) == [4.0, 24.0, 0.0]
    assert sorted(path for path in cache.rglob("*") if path.is_file()) == cached
    assert sorted(site_packages.iterdir()) == before


@pytest.mark.full
def test_changed_part_in_another_file_triggers_recompilation(site_packages: Path) -> None:
    """numba's own cache checks the file of the kernel only, which is the same."""
    assert run(site_packages)[:2] == [4.0, 24.0]
    (site_packages / "kernel_parts.py").write_text(PARTS.replace("2.0", "3.0"))
    assert run(site_packages)[:2] == [5.5, 36.0]
    (site_packages / "kernel_parts.py").write_text(PARTS)
    assert run(site_packages) == [4.0, 24.0, 0.0]


@pytest.mark.full
@pytest.mark.skipif(sys.platform == "win32", reason="needs a path below /dev/null")
def test_kernels_work_without_writable_folder(site_packages: Path) -> None:
    nowhere = dict.fromkeys(
        ("XDG_CACHE_HOME", "XDG_STATE_HOME", "HOME", "TMPDIR"), "/dev/null/nowhere"
    )
    assert run(site_packages, **nowhere)[:2] == [4.0, 24.0]
