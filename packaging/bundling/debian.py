"""The bundle as a Debian package."""

from __future__ import annotations

import fnmatch
import gzip
import hashlib
import shutil
import subprocess
from collections.abc import Iterable, Iterator
from pathlib import Path

from bundling import elf

NAME = "vomstudio"
# Below the root of the file system.
PLACE = Path("opt", NAME)

# Plugins that are tried and done without if their libraries are missing. Whoever has such a desktop
# or printer has the libraries for Qt's; numba has other ways to start threads.
OPTIONAL = (
    "*/numba/np/ufunc/omppool.*.so",
    "*/platformthemes/libqgtk3.so",
    "*/printsupport/libcupsprintersupport.so",
    "*/plugins/wayland-*/*.so",
    "*/platforms/libqwayland.so",
    "*/libQt6Wayland*.so.*",
    "*/libQt6WlShellIntegration.so.*",
)

# First Debian version of the compiler's library that has the symbols.
_LIBSTDCXX = {28: "10", 29: "11", 30: "12", 31: "13", 32: "13", 33: "14", 34: "15"}

_CONTROL = """\
Package: {name}
Version: {version}
Architecture: amd64
Maintainer: {maintainer}
Installed-Size: {size}
Depends: {depends}
Section: science
Priority: optional
Description: virtual outcrop models of geological structures
 VOM Studio turns photographs of a rock face into a model, and the model into measured planes
 with their errors. This package brings its own Python and all libraries of Python.
"""


def external_libraries(tree: Path) -> set[str]:
    """List the libraries that a bundle needs from the system, by name.

    Raises SystemExit if one of them is not installed on this machine either, which means that
    pruning removed it.
    """
    files = elf.elf_files(tree)
    own = {path.name for path in files}
    missing = []
    result = set()
    for path in files:
        optional = any(fnmatch.fnmatch(str(path), pattern) for pattern in OPTIONAL)
        for name in elf.needed(path):
            if name in own or optional:
                continue
            result.add(name)
            if not elf.SYSTEM_ONLY.fullmatch(name) and elf.system_library(name) is None:
                missing.append(f"{name} (for {path.relative_to(tree)})")
    if missing:
        raise SystemExit("These libraries are missing from the bundle: " + ", ".join(missing))
    return result


def run_packages(system_packages: Path) -> Iterator[str]:
    """Read the packages that the program needs from `system_packages.txt`."""
    for line in system_packages.read_text(encoding="utf-8").splitlines():
        words = line.split()
        if words and not line.startswith("#") and words[2] == "run":
            yield words[0]


def dependencies(tree: Path, system_packages: Path) -> list[str]:
    """List the packages that a bundle needs, as in the field `Depends`."""
    files = elf.elf_files(tree)
    libc = elf.newest_symbol_version(files, "GLIBC")
    libstdcxx = elf.newest_symbol_version(files, "GLIBCXX")[-1]
    packages = set(run_packages(system_packages))
    for name in external_libraries(tree):
        library = elf.system_library(name)
        if library and not elf.SYSTEM_ONLY.fullmatch(name):
            packages.add(elf.debian_package(library))
    return [
        f"libc6 (>= {'.'.join(map(str, libc))})",
        f"libstdc++6 (>= {_LIBSTDCXX[max(libstdcxx, min(_LIBSTDCXX))]})",
        "libgcc-s1",
        *sorted(packages),
    ]


def write_package(
    tree: Path,
    target: Path,
    *,
    version: str,
    maintainer: str,
    depends: Iterable[str],
    desktop_files: dict[Path, str],
    copyright_text: str,
    work: Path,
) -> None:
    """Write a Debian package.

    Parameters
    ----------
    tree
        Folder of the bundle. It is moved while the package is built, and moved back.
    target
        The new file.
    version, maintainer, depends
        Fields of the package.
    desktop_files
        Text of the files for the menu of the desktop, by their paths below ``share``.
    copyright_text
        Text of the file ``copyright``.
    work
        Folder for the package's files while it is built, on the same file system as `tree`.
    """
    root = work / "deb"
    share = root / "usr" / "share"
    documents = share / "doc" / NAME
    for folder in (root / "DEBIAN", root / "usr" / "bin", documents, (root / PLACE).parent):
        folder.mkdir(parents=True)
    (root / "usr" / "bin" / NAME).symlink_to(Path("/") / PLACE / NAME)
    for path, text in desktop_files.items():
        (share / path).parent.mkdir(parents=True, exist_ok=True)
        (share / path).write_text(text, encoding="utf-8")
    (documents / "copyright").write_text(copyright_text, encoding="utf-8")
    with gzip.GzipFile(documents / "changelog.gz", "wb", mtime=0) as file:
        file.write(f"{NAME} ({version}) stable; urgency=low\n".encode())
    tree.rename(root / PLACE)
    try:
        size = sum(path.lstat().st_size for path in root.rglob("*")) // 1024
        control = _CONTROL.format(
            name=NAME,
            version=version,
            maintainer=maintainer,
            size=size,
            depends=", ".join(depends),
        )
        (root / "DEBIAN" / "control").write_text(control, encoding="utf-8")
        (root / "DEBIAN" / "md5sums").write_text("".join(_md5sums(root)), encoding="utf-8")
        subprocess.run(
            [
                "dpkg-deb",
                "--build",
                "--root-owner-group",
                "-Zzstd",
                "-z12",
                "--threads-max=1",
                str(root),
                str(target),
            ],
            check=True,
        )
    finally:
        (root / PLACE).rename(tree)
        shutil.rmtree(root)


def _md5sums(root: Path) -> Iterator[str]:
    """Return the lines by which `dpkg --verify` finds damaged files."""
    for path in sorted(root.rglob("*")):
        if path.is_file() and not path.is_symlink() and root / "DEBIAN" not in path.parents:
            with path.open("rb") as file:
                digest = hashlib.file_digest(file, "md5").hexdigest()
            yield f"{digest}  {path.relative_to(root)}\n"
