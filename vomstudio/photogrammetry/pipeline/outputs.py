"""Folder of a reconstruction: its files, a lock against parallel runs, and disk errors."""

from __future__ import annotations

import contextlib
import errno
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from vomstudio.core.errors import TargetError, VomError
from vomstudio.core.files.containment import check_in_project, refuse_links
from vomstudio.core.files.disk_errors import (
    failure_reason,
    folder_write_error,
    is_disk_message,
    is_full,
    probe_write_errno,
)
from vomstudio.core.files.lock import FolderLock
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.io.models.reconstruction_file import RESULT, WORK
from vomstudio.io.photos.cameras_file import FILE_NAME

# Time to wait for the worker of a killed window, which may be executing native code.
_LOCK_TIMEOUT_S = 5.0
# If there is less free space, a failed write in a library is attributed to a full disk.
_MIN_FREE_BYTES = 1_000_000


@dataclass(frozen=True)
class Outputs:
    """Files of a reconstruction in `folder`."""

    folder: Path

    @property
    def result(self) -> Path:
        return self.folder / RESULT

    @property
    def request(self) -> Path:
        return self.folder / "request.json"

    @property
    def log(self) -> Path:
        return self.folder / "log.txt"

    @property
    def cameras(self) -> Path:
        return self.folder / "cameras.csv"

    @property
    def poses(self) -> Path:
        return self.folder / FILE_NAME

    @property
    def sparse_cloud(self) -> Path:
        return self.folder / "sparse.ply"

    @property
    def dense(self) -> Path:
        return self.folder / "dense.laz"

    @property
    def mesh(self) -> Path:
        return self.folder / "model.obj"

    @property
    def other_models(self) -> tuple[Path, ...]:
        return (self.folder / "model.glb", self.folder / "model.ply")

    @property
    def report(self) -> Path:
        return self.folder / "report.html"


def claim_folder(out: Path) -> Outputs:
    """Prepare a folder for a reconstruction.

    The folder must be new, empty or from an earlier run. Raises TargetError if it has other
    content or cannot be created.
    """
    check_in_project(out)
    try:
        out.mkdir(parents=True, exist_ok=True)
        other_files = [p for p in out.iterdir() if not p.name.startswith(".")]
    except (OSError, ValueError) as error:
        if isinstance(error, FileExistsError | NotADirectoryError):
            raise TargetError(Finding("folder.is-file"), file=out) from error
        reason = failure_reason(out.parent, error)
        raise TargetError(Finding("folder.not-created", reason=reason), file=out) from error
    if other_files and not (out / RESULT).exists() and not (out / WORK).is_dir():
        raise TargetError(
            Finding("folder.not-empty"),
            file=out,
        )
    refuse_links(out)
    try:
        (out / WORK).mkdir(exist_ok=True)
    except OSError as error:
        raise TargetError(
            Finding("output.unwritable", reason=failure_reason(out, error)), file=out
        ) from error
    return Outputs(out)


@contextlib.contextmanager
def lock_folder(outputs: Outputs) -> Iterator[None]:
    """Lock the folder for this run, and remove the partial files of a killed run.

    Raises TargetError if another run uses the folder or the lock cannot be written.
    """
    lock = FolderLock(
        outputs.folder / WORK / "lock",
        busy_code="output.folder-in-use",
        unwritable_code="output.unwritable",
        timeout_s=_LOCK_TIMEOUT_S,
    )
    try:
        for path in outputs.folder.glob(".vom-*.part*"):
            path.unlink(missing_ok=True)
        yield
    finally:
        lock.release()


@contextlib.contextmanager
def report_disk_errors(folder: Path) -> Iterator[None]:
    """Raise TargetError for disk errors that libraries hide or report differently."""
    try:
        yield
    except (VomError, MemoryError):
        raise
    except Exception as error:
        is_disk_full = isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT)
        if is_disk_full or _free_bytes(folder) <= _MIN_FREE_BYTES or is_full(folder, error):
            finding = Finding("reconstruct.not-written", reason=tr("the disk is full"))
            raise TargetError(finding, file=folder) from error
        # The messages of libraries about disk errors are unreliable, so try to write to the disk.
        if not is_disk_message(error) and probe_write_errno(folder) is None:
            raise
        raise folder_write_error(folder, error) from error


def _free_bytes(folder: Path) -> float:
    """Return the number of free bytes, or infinity if unknown."""
    try:
        return shutil.disk_usage(folder).free
    except OSError:
        return float("inf")
