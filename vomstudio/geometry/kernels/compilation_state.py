"""Record of whether all kernels are compiled on this machine.

Looking up every kernel takes two seconds in a separate process. Therefore, a note is stored next to
the kernels once all of them have been compiled. Its name identifies the files of the program, the
compiler and the machine. If the note is missing or belongs to another program version, the kernels
are looked up. If it is wrong, a kernel is compiled when it is needed.
"""

from __future__ import annotations

import hashlib
import os
import platform
from pathlib import Path

from vomstudio.geometry.kernels.machine_code import describe_compiler, load_code, store_code

_PACKAGE = Path(__file__).resolve().parents[2]


def is_compilation_recorded() -> bool:
    """Return whether this version of the program has compiled all kernels on this machine."""
    return load_code(_record_name()) is not None


def record_compilation() -> None:
    """Record that all kernels are compiled."""
    store_code(_record_name(), b"")


def _record_name() -> str:
    digest = hashlib.blake2b(digest_size=16)
    for word in (*describe_compiler(), platform.platform(), platform.node()):
        digest.update(f"{word}\n".encode())
    for folder, folder_names, names in os.walk(_PACKAGE):
        folder_names[:] = sorted(name for name in folder_names if name != "__pycache__")
        for name in sorted(names):
            if name.endswith(".py"):
                # As text: a thousand paths as objects take four times as long.
                path = os.path.join(folder, name)
                state = os.stat(path)
                digest.update(f"{path} {state.st_size} {state.st_mtime_ns}\n".encode())
    return f"all_kernels-{digest.hexdigest()}.code"
