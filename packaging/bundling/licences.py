"""Licences of a bundle and of its parts."""

from __future__ import annotations

import shutil
from importlib.metadata import distributions
from pathlib import Path

from bundling import elf

# Beside every installed distribution, in its folder *.dist-info; these are also listed by name.
_GPL_PARTS = ("pycolmap", "pyceres")

_NOTICE = """\
VOM Studio is published under the BSD 3-Clause licence (LICENSE). This bundle contains other
programs beside it. The wheels of {gpl} contain parts of SuiteSparse
under the GNU General Public License, so the bundle as a whole is distributed under that licence,
version 3 (GPL-3). Whoever passes it on also offers the sources of its parts, under the terms
of that licence.

The licence of each Python package is in its *.dist-info folder, those of the standard library and
of libraries from Debian are beside this file. The packages are:

{packages}
"""


def write_licences(root: Path, folder: Path, site_packages: Path, libraries: Path) -> str:
    """Collect the licences of a bundle's parts; return the notice for the bundle as a whole.

    Parameters
    ----------
    root
        Folder of the project.
    folder
        New folder for the licences.
    site_packages
        Folder of installed packages.
    libraries
        Folder of the libraries that were copied from this machine.
    """
    folder.mkdir()
    for name in ("LICENSE", "THIRD_PARTY.md"):
        if (root / name).exists():
            shutil.copyfile(root / name, folder / name)
    shutil.copyfile(site_packages.parent / "LICENSE.txt", folder / "python.txt")
    shutil.copyfile("/usr/share/common-licenses/GPL-3", folder / "GPL-3")
    for library in sorted(libraries.glob("*.so*")):
        source = elf.system_library(library.name)
        assert source is not None
        package = elf.debian_package(source)
        shutil.copyfile(f"/usr/share/doc/{package}/copyright", folder / f"{package}.txt")
    lines = []
    named = []
    for part in sorted(distributions(path=[str(site_packages)]), key=lambda d: d.name.lower()):
        licence = part.metadata["License-Expression"] or _short(part.metadata["License"])
        licence = licence or _classifier(part.metadata.get_all("Classifier") or [])
        lines.append(f"  {part.name} {part.version}: {licence}")
        if part.name.startswith(_GPL_PARTS):
            named.append(f"{part.name} {part.version}")
    notice = _NOTICE.format(gpl=" and ".join(named), packages="\n".join(lines))
    (folder / "README").write_text(notice, encoding="utf-8")
    return notice


def debian_copyright(notice: str) -> str:
    """Return the text of a Debian package's file `copyright`."""
    text = "\n".join(f" {line or '.'}" for line in notice.splitlines())
    return (
        "Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\n"
        "Upstream-Name: VOM Studio\n"
        "\n"
        "Files: *\n"
        "Copyright: the authors of VOM Studio and of the parts that are named below\n"
        "License: GPL-3\n"
        f"{text}\n"
        " .\n"
        " The text of the licence is in the file GPL-3 of the folder common-licenses.\n"
    )


def _short(licence: str | None) -> str:
    """Return a licence's name; some packages have its whole text in that place."""
    return licence.strip() if licence and len(licence) < 80 and "\n" not in licence else ""


def _classifier(classifiers: list[str]) -> str:
    names = [c.rpartition(" :: ")[2] for c in classifiers if c.startswith("License ::")]
    return ", ".join(names) or "see its *.dist-info folder"
