"""A copy of a Python interpreter that runs from any folder."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

from bundling import elf, pruning

_QUESTION = """
import json, os, sys, sysconfig
paths = {key: sysconfig.get_path(key, "posix_prefix") for key in ("stdlib", "platstdlib")}
name = f"python{sys.version_info.major}.{sys.version_info.minor}"
executable = os.path.realpath(os.path.join(sys.base_exec_prefix, "bin", name))
print(json.dumps({"name": name, "executable": executable, "stdlib": os.path.dirname(os.__file__)}))
"""


class Interpreter:
    """Interpreter in a folder of its own, with its standard library and the libraries it needs.

    The folder contains ``python3.X``, the file ``python3.X._pth`` that lists where it imports
    from, and ``lib/``. With that file Python ignores PYTHONHOME, PYTHONPATH and the packages in
    the user's home, so that another Python of the same machine cannot disturb the program, and
    processes that the program starts need no variables.
    """

    def __init__(self, folder: Path, name: str) -> None:
        self.folder = folder
        self.name = name

    @property
    def executable(self) -> Path:
        return self.folder / self.name

    @property
    def site_packages(self) -> Path:
        return self.folder / "lib" / self.name / "site-packages"


def import_paths(name: str) -> str:
    """Return the text of the ``._pth`` file: where the copy named so imports from."""
    library = f"lib/{name}"
    return f"{library}\n{library}/lib-dynload\n{library}/site-packages\n"


def copy_interpreter(source: Path, folder: Path) -> Interpreter:
    """Copy an interpreter, its standard library and the libraries they need.

    Parameters
    ----------
    source
        Python executable, also one of a virtual environment. Its base is copied.
    folder
        New folder of the copy.
    """
    facts = json.loads(
        subprocess.run(
            [str(source), "-I", "-c", _QUESTION], capture_output=True, text=True, check=True
        ).stdout
    )
    copy = Interpreter(folder, facts["name"])
    folder.mkdir(parents=True)
    shutil.copy2(facts["executable"], copy.executable)
    library = folder / "lib" / copy.name
    # Links of Debian's Python lead to /etc and to files beside it: the files are copied. Packages
    # beside the standard library are not a part of it.
    shutil.copytree(
        facts["stdlib"],
        library,
        ignore=shutil.ignore_patterns("__pycache__", "site-packages", "dist-packages"),
        ignore_dangling_symlinks=True,
    )
    pruning.remove(folder, pruning.standard_library(copy.name))
    copy.site_packages.mkdir()
    (folder / f"{copy.name}._pth").write_text(import_paths(copy.name))
    _bundle_libraries(copy)
    return copy


def _bundle_libraries(copy: Interpreter) -> None:
    """Copy the libraries that the interpreter and its extension modules are linked with."""
    own = copy.folder / "lib"
    elf.set_run_path(copy.executable, "$ORIGIN/lib")
    pending = [copy.executable]
    for extension in (own / copy.name / "lib-dynload").glob("*.so"):
        elf.set_run_path(extension, "$ORIGIN/../..")
        pending.append(extension)
    while pending:
        user = pending.pop()
        for name in elf.needed(user):
            if (own / name).exists() or elf.SYSTEM_ONLY.fullmatch(name):
                continue
            pending.append(copy_library(name, own))


def copy_library(name: str, folder: Path) -> Path:
    """Copy a library of this machine; it looks for others in the same folder first."""
    source = elf.system_library(name)
    if source is None:
        raise SystemExit(f"Cannot bundle {name}: it is not installed. Install its package.")
    target = folder / name
    shutil.copyfile(source, target)
    elf.set_run_path(target, "$ORIGIN")
    return target
