"""How much memory there is, and how much this process has: of Linux, which tells it in files.

A container has less than its machine: the limit of its control group. A process that goes beyond it
is killed, however much memory the machine has free (Linux, `cgroup-v2.rst` and
`cgroup-v1/memory.rst`).
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import read_whole

_GROUPS = Path("/sys/fs/cgroup")
_UNLIMITED = 1 << 60
"""Version 1 of control groups writes the largest number of pages for "no limit"."""


def held_bytes() -> int | None:
    """Private memory of this process, touched or not; None where the system does not tell."""
    return _line(Path("/proc/self/status"), "VmData")


def machine_bytes() -> int | None:
    """All memory of the machine; None where the system does not tell."""
    return _line(Path("/proc/meminfo"), "MemTotal")


def free_bytes() -> int | None:
    """What this process can still get, swap included; None where the system does not tell."""
    available = _line(Path("/proc/meminfo"), "MemAvailable")
    if available is None:
        return None
    swap = _line(Path("/proc/meminfo"), "SwapFree") or 0
    left = group_bytes()
    return available + swap if left is None else min(available + swap, left)


def group_bytes(groups: Path = _GROUPS, said: Path = Path("/proc/self/cgroup")) -> int | None:
    """What is left of the limits of this process's control group and those above it; None where
    there is no limit. groups : where they are mounted; said : the file that names this process's"""
    left = [
        most - used
        for folder, most_name, used_name, files in _groups_of(groups, said)
        if (most := _number(folder / most_name)) is not None
        and most < _UNLIMITED
        and (used := _used(folder, used_name, files)) is not None
    ]
    return max(min(left), 0) if left else None


def _groups_of(groups: Path, said: Path) -> Iterator[tuple[Path, str, str, tuple[str, str]]]:
    """Folder of each group that this process is in, up to where they are mounted; the names of its
    limit, of what is used, and of what it holds of files, which the system takes back."""
    try:
        lines = read_whole(said).decode("utf-8", "replace").splitlines()
    except (InputError, OSError):
        return
    for line in lines:
        number, _, rest = line.partition(":")
        controllers, _, name = rest.partition(":")
        if number == "0" and not controllers:
            root, most, used = groups, "memory.max", "memory.current"
            files = ("inactive_file", "active_file")
        elif "memory" in controllers.split(","):
            root, most, used = groups / "memory", "memory.limit_in_bytes", "memory.usage_in_bytes"
            files = ("total_inactive_file", "total_active_file")
        else:
            continue
        parts = [part for part in name.split("/") if part not in ("", "..")]
        # In a container its own group is the mounted one, whatever it is called outside.
        for count in range(len(parts) + 1):
            yield root.joinpath(*parts[:count]), most, used, files


def _used(folder: Path, name: str, files: tuple[str, str]) -> int | None:
    used = _number(folder / name)
    if used is None:
        return None
    held = dict[str, int]()
    try:
        for line in read_whole(folder / "memory.stat").decode("ascii").splitlines():
            word, _, value = line.partition(" ")
            if word in files:
                held[word] = int(value)
    except (InputError, OSError, ValueError):
        pass
    return max(used - sum(held.values()), 0)


def _number(path: Path) -> int | None:
    """The number in a file; None for none, and for "max"."""
    try:
        return int(read_whole(path))
    except (InputError, OSError, ValueError):
        return None


def _line(file: Path, name: str) -> int | None:
    """Bytes of a line of /proc."""
    try:
        for line in read_whole(file).decode("ascii").splitlines():
            if line.startswith(name):
                return int(line.split()[1]) * 1024
    except (OSError, ValueError, IndexError):
        pass
    return None
