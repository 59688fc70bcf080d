"""Shared libraries: what they need, where the system has it, and how they find it."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterable
from functools import cache
from pathlib import Path

# Parts of the C library and of the compiler. A bundle never carries them: they belong to the
# system's loader and its graphics drivers.
SYSTEM_ONLY = re.compile(
    r"(ld-linux-.*|lib(c|m|dl|pthread|rt|resolv|util|stdc\+\+|gcc_s))\.so(\..*)?"
)


def is_elf(path: Path) -> bool:
    """Report whether a file is a program or a library."""
    if path.is_symlink() or not path.is_file():
        return False
    with path.open("rb") as file:
        return file.read(4) == b"\x7fELF"


def elf_files(folder: Path) -> list[Path]:
    """List the programs and libraries of a folder, without links."""
    return [path for path in sorted(folder.rglob("*")) if is_elf(path)]


def needed(path: Path) -> list[str]:
    """List the names of the libraries that a library is linked with."""
    return _run("patchelf", "--print-needed", str(path)).split()


def set_run_path(path: Path, run_path: str) -> None:
    """Set the folders in which a library looks for others."""
    _run("patchelf", "--set-rpath", run_path, str(path))


def closure(roots: Iterable[Path], folder: Path) -> set[Path]:
    """Find the libraries of a folder that some of its files need, directly or not.

    Parameters
    ----------
    roots
        Files whose needs are followed. They belong to the result.
    folder
        Where needed libraries are looked for; those elsewhere are ignored.
    """
    result = set(roots)
    pending = list(result)
    while pending:
        for name in needed(pending.pop()):
            path = folder / name
            if path.exists() and path not in result:
                result.add(path)
                pending.append(path)
    return result


def system_library(name: str) -> Path | None:
    """Find a library of this machine by its name, None if it is not installed."""
    return _system_libraries().get(name)


@cache
def _system_libraries() -> dict[str, Path]:
    listing = _run("/sbin/ldconfig", "-p")
    found = re.findall(r"^\s(\S+) \(.*x86-64.*\) => (\S+)$", listing, re.MULTILINE)
    # The loader takes the first of a name.
    return {name: Path(path) for name, path in reversed(found)}


def debian_package(library: Path) -> str:
    """Return the Debian package that a library of this machine belongs to."""
    # The database has the name from before /lib became a link to /usr/lib, or the one after.
    for path in (library, library.resolve(), Path("/usr", *library.parts[1:])):
        known = subprocess.run(
            ["dpkg-query", "-S", str(path)], capture_output=True, text=True, check=False
        )
        if known.returncode == 0:
            return known.stdout.split(":")[0]
    short = Path(*library.resolve().parts[2:])
    return _run("dpkg-query", "-S", f"/{short}").split(":")[0]


def newest_symbol_version(files: Iterable[Path], prefix: str) -> tuple[int, ...]:
    """Return the newest version of a library's symbols that files refer to.

    Parameters
    ----------
    files
        Programs and libraries.
    prefix
        Name of the symbol versions, such as ``GLIBC``.
    """
    pattern = re.compile(rb"\0" + prefix.encode() + rb"_([0-9]+(?:\.[0-9]+)+)\0")
    versions = {
        tuple(map(int, match.decode().split(".")))
        for path in files
        for match in pattern.findall(path.read_bytes())
    }
    return max(versions, default=())


def _run(*command: str) -> str:
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout
