"""Total, free and used memory on Linux, read from /proc and the control groups.

A container may have less memory than its machine because its control group has a limit. A process
that exceeds this limit is killed, even if the machine has free memory (Linux, `cgroup-v2.rst` and
`cgroup-v1/memory.rst`).
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import read_whole_file

_CGROUP_ROOT = Path("/sys/fs/cgroup")
_UNLIMITED = 1 << 60
"""Threshold for no limit: control groups version 1 report the largest number of pages."""


def private_bytes() -> int | None:
    """Return the private memory of this process in bytes, used or not, or None if unknown."""
    return _proc_bytes(Path("/proc/self/status"), "VmData")


def machine_bytes() -> int | None:
    """Return the memory of the machine in bytes, or None if unknown."""
    return _proc_bytes(Path("/proc/meminfo"), "MemTotal")


def free_bytes() -> int | None:
    """Return the memory in bytes that this process can still allocate, or None if unknown."""
    available_proc_bytes = _proc_bytes(Path("/proc/meminfo"), "MemAvailable")
    if available_proc_bytes is None:
        return None
    swap_bytes = _proc_bytes(Path("/proc/meminfo"), "SwapFree") or 0
    remaining_group_bytes = group_bytes()
    return (
        available_proc_bytes + swap_bytes
        if remaining_group_bytes is None
        else min(available_proc_bytes + swap_bytes, remaining_group_bytes)
    )


def group_bytes(
    groups: Path = _CGROUP_ROOT, membership_file: Path = Path("/proc/self/cgroup")
) -> int | None:
    """Return the memory left in the control groups of this process; None if not limited.

    Parameters
    ----------
    groups : Path
        Mount point of the control groups.
    membership_file : Path
        File that lists the groups of this process.
    """
    remaining_limits = [
        limit - used_bytes
        for folder, limit_name, used_name, files in _control_groups(groups, membership_file)
        if (limit := _number(folder / limit_name)) is not None
        and limit < _UNLIMITED
        and (used_bytes := _used_bytes(folder, used_name, files)) is not None
    ]
    return max(min(remaining_limits), 0) if remaining_limits else None


def _control_groups(
    groups: Path, membership_file: Path
) -> Iterator[tuple[Path, str, str, tuple[str, str]]]:
    """Yield the control groups of this process, up to the mount point.

    Each item contains the folder, the names of the files with the limit and the usage, and the
    fields of `memory.stat` that contain the page cache, which the system can reclaim.
    """
    try:
        lines = read_whole_file(membership_file).decode("utf-8", "replace").splitlines()
    except (InputError, OSError):
        return
    for line in lines:
        number, _, group = line.partition(":")
        controllers, _, name = group.partition(":")
        if number == "0" and not controllers:
            root, limit_name, used_name = groups, "memory.max", "memory.current"
            files = ("inactive_file", "active_file")
        elif "memory" in controllers.split(","):
            root, limit_name, used_name = (
                groups / "memory",
                "memory.limit_in_bytes",
                "memory.usage_in_bytes",
            )
            files = ("total_inactive_file", "total_active_file")
        else:
            continue
        parts = [part for part in name.split("/") if part not in ("", "..")]
        # In a container, the mounted group is the container's own group, whatever its name is
        # outside.
        for count in range(len(parts) + 1):
            yield root.joinpath(*parts[:count]), limit_name, used_name, files


def _used_bytes(folder: Path, name: str, files: tuple[str, str]) -> int | None:
    usage_bytes = _number(folder / name)
    if usage_bytes is None:
        return None
    cache = dict[str, int]()
    try:
        for line in read_whole_file(folder / "memory.stat").decode("ascii").splitlines():
            word, _, value = line.partition(" ")
            if word in files:
                cache[word] = int(value)
    except (InputError, OSError, ValueError):
        pass
    return max(usage_bytes - sum(cache.values()), 0)


def _number(path: Path) -> int | None:
    """Return the number in a file; None if it cannot be read or is not a number ("max")."""
    try:
        return int(read_whole_file(path))
    except (InputError, OSError, ValueError):
        return None


def _proc_bytes(file: Path, name: str) -> int | None:
    """Return the bytes in the line of a /proc file that starts with `name`, or None."""
    try:
        for line in read_whole_file(file).decode("ascii").splitlines():
            if line.startswith(name):
                return int(line.split()[1]) * 1024
    except (OSError, ValueError, IndexError):
        pass
    return None
