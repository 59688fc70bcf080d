"""The last net under the readers: a process of ours gets no more than a file can be worth."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from vomstudio.core.files.available_memory import (
    free_bytes,
    group_bytes,
    machine_bytes,
    private_bytes,
)
from vomstudio.core.files.memory_limit import is_memory_error

pytestmark = pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="no other system can hold a process to it"
)

_PROGRAM = """
import sys
from pathlib import Path
import numpy as np
from vomstudio.core.files import memory_limit

def fits(mb):
    try:
        return len(np.zeros(mb << 20, np.uint8)) > 0
    except MemoryError:
        return False

path = Path(sys.argv[1])
if sys.argv[2] == "ours":
    memory_limit.enable_limits()
with memory_limit.limit_for_file(path):
    found = [fits(mb) for mb in (500, 1500, 4000)]
    with memory_limit.limit_for_file(path):
        pass
    found.append(fits(4000))
print(*found, fits(4000))
"""


def fits(path: Path, whose: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", _PROGRAM, str(path), whose],
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.strip()


def test_own_process_memory_is_limited_by_file_size(tmp_path: Path) -> None:
    small, larger = tmp_path / "a.las", tmp_path / "b.las"
    small.write_bytes(b"LASF" * 100)
    larger.write_bytes(bytes(8 << 20))
    assert fits(small, "ours").split() == ["True", "False", "False", "False", "True"]
    assert fits(larger, "ours").split() == ["True", "True", "False", "False", "True"]


def test_user_script_memory_is_not_limited(tmp_path: Path) -> None:
    (tmp_path / "a.las").write_bytes(b"LASF" * 100)
    assert fits(tmp_path / "a.las", "a script's").split() == ["True"] * 5


def test_companion_files_of_gltf_raise_the_limit(tmp_path: Path) -> None:
    (tmp_path / "a.gltf").write_text("{}")
    assert fits(tmp_path / "a.gltf", "ours").split() == ["True", "False", "False", "False", "True"]
    (tmp_path / "a.bin").write_bytes(bytes(8 << 20))
    assert fits(tmp_path / "a.gltf", "ours").split() == ["True", "True", "False", "False", "True"]


_JOB = """
import resource, sys
from pathlib import Path
import numpy as np
from vomstudio.core.files import memory_limit
from vomstudio.core.files.available_memory import free_bytes, private_bytes

def limit():
    return resource.getrlimit(resource.RLIMIT_DATA)[0]

if sys.argv[2] == "ours":
    memory_limit.enable_limits()
free = free_bytes() + private_bytes()
with memory_limit.limit_to_free_memory():
    print(limit() < 2 * free + (64 << 30) and limit() != resource.RLIM_INFINITY)
    try:
        # Reserved and never touched: what a wish for too much begins with.
        kept = [np.empty(1 << 30, np.uint8) for _ in range((limit() >> 30) + 1)]
        print("all of it")
    except MemoryError:
        print("no more")
    kept = []
    outer = limit()
    with memory_limit.limit_for_file(Path(sys.argv[1])):
        print(limit() < outer or sys.argv[2] != "ours")
    print(limit() == outer)
print(limit() == resource.RLIM_INFINITY)
"""


def test_job_is_limited_to_free_memory_and_file_reading_to_less(tmp_path: Path) -> None:
    (tmp_path / "a.las").write_bytes(b"LASF" * 100)
    done = subprocess.run(
        [sys.executable, "-c", _JOB, str(tmp_path / "a.las"), "ours"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.split("\n")[:5] == ["True", "no more", "True", "True", "True"]


def test_memory_errors_are_recognised() -> None:
    for error in (
        MemoryError(),
        OSError(12, "Cannot allocate memory"),
        RuntimeError("std::bad_alloc"),
        RuntimeError("can't start new thread"),
        RuntimeError("Resource temporarily unavailable"),
        ImportError("libOpen3D.so.0.20: cannot map zero-fill pages"),
    ):
        assert is_memory_error(error), error
    for other in (OSError(28, "No space left on device"), ValueError("7"), KeyError("memory")):
        assert not is_memory_error(other), other


def test_opencv_memory_error_is_recognised() -> None:
    import cv2
    import numpy as np

    with pytest.raises(cv2.error) as failure:
        cv2.resize(np.zeros((2, 2, 3), np.uint8), (2**21, 2**21))
    assert is_memory_error(failure.value)


def group(folder: Path, values: dict[str, str]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in values.items():
        (folder / name).write_text(text + "\n")


def test_cgroup_v2_uses_the_tightest_limit(tmp_path: Path) -> None:
    said, mounted = tmp_path / "cgroup", tmp_path / "mounted"
    said.write_text("0::/user.slice/shell.scope\n")
    group(mounted, {"cgroup.controllers": "memory"})
    assert group_bytes(mounted, said) is None
    stat = "anon 600\ninactive_file 250\nactive_file 50\nfile 900"
    group(
        mounted / "user.slice",
        {"memory.max": "2000", "memory.current": "1000", "memory.stat": stat},
    )
    group(mounted / "user.slice/shell.scope", {"memory.max": "max", "memory.current": "900"})
    # 1000 used, 300 of which are files that the system takes back.
    assert group_bytes(mounted, said) == 2000 - 700
    group(mounted / "user.slice/shell.scope", {"memory.max": "800", "memory.current": "900"})
    assert group_bytes(mounted, said) == 0


def test_cgroup_v1_limits_in_container_are_read(tmp_path: Path) -> None:
    said, mounted = tmp_path / "cgroup", tmp_path / "mounted"
    said.write_text("9:name=systemd:/\n4:cpu,memory:/docker/5f3\n0::/\n")
    values = {"memory.limit_in_bytes": str(2**63 - 4096), "memory.usage_in_bytes": "5000"}
    group(mounted / "memory", values)
    assert group_bytes(mounted, said) is None
    # The container's own group is mounted as the root, under another name than outside.
    stat = "cache 9\ntotal_inactive_file 100\ntotal_active_file 1"
    group(mounted / "memory", {**values, "memory.limit_in_bytes": "8000", "memory.stat": stat})
    assert group_bytes(mounted, said) == 8000 - 4899


def test_process_and_free_memory_are_plausible() -> None:
    import psutil

    held, free = private_bytes(), free_bytes()
    assert held is not None
    assert free is not None
    assert held < psutil.Process().memory_info().vms
    everything = psutil.virtual_memory().total + psutil.swap_memory().total
    assert machine_bytes() == psutil.virtual_memory().total
    assert 0 < free <= everything
