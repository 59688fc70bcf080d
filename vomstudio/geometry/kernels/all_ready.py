"""Whether all kernels of this program have been compiled on this machine, told without loading one.

To look each one up takes a process of its own two seconds. So whoever has made all of them ready
leaves a note that names the program's files, Python and the machine. Where the note is gone or
another program's, they are looked up; where it is wrong, a kernel is compiled when it is needed.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import platform
import sys
from importlib.util import find_spec
from pathlib import Path

from vomstudio.geometry.kernels.machine_code import folders

_PACKAGE = Path(__file__).resolve().parents[2]
_NAME = "all-kernels.ready"


def noted() -> bool:
    """They were made ready, by this very program on this machine."""
    told = _program()
    for folder in folders():
        with contextlib.suppress(OSError):
            if (folder / _NAME).read_text() == told:
                return True
    return False


def note() -> None:
    """All of them are ready now."""
    for folder in folders():
        with contextlib.suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)
            draft = folder / f"{_NAME}.{os.getpid()}.part"
            draft.write_text(_program())
            draft.replace(folder / _NAME)
            return


def _program() -> str:
    """Of all that a kernel may be made of: the program's files, what compiles them, the machine."""
    digest = hashlib.blake2b(digest_size=16)
    settings = [f"{k}={v}" for k, v in sorted(os.environ.items()) if k.startswith("NUMBA_")]
    for word in (sys.version, _numba(), platform.platform(), platform.node(), *settings):
        digest.update(f"{word}\n".encode())
    for folder, inside, names in os.walk(_PACKAGE):
        inside[:] = sorted(name for name in inside if name != "__pycache__")
        for name in sorted(names):
            if name.endswith(".py"):
                path = Path(folder, name)
                state = path.stat()
                digest.update(f"{path} {state.st_size} {state.st_mtime_ns}\n".encode())
    return digest.hexdigest()


def _numba() -> str:
    """Its version, without importing it."""
    spec = find_spec("numba")
    if spec is None or spec.origin is None:
        return ""
    return Path(spec.origin).with_name("_version.py").read_text()
