"""Files that are written completely or not at all.

All output goes through `atomic_write`: it is written under a temporary name in the target's folder
(a rename is atomic only within one file system), flushed to the disk, and then renamed. After a
failure the previous file is unchanged.
"""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
import stat
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from vomstudio.core.errors import TargetError, VomError
from vomstudio.core.failures import stop_requests
from vomstudio.core.files.containment import check_generated_path, check_in_project
from vomstudio.core.files.disk_errors import probe_write_errno, write_error
from vomstudio.core.findings import Finding, cause_of

_TARGET_ERRNOS = {
    errno.ENOSPC,
    errno.EDQUOT,
    errno.EFBIG,
    errno.EACCES,
    errno.EPERM,
    errno.EROFS,
    errno.EIO,
    errno.ENAMETOOLONG,
    errno.ENOENT,
}
_BACKUP_SUFFIX = ".old"


def check_target(
    path: str | Path, *, force: bool = False, inputs: Iterable[str | Path] = ()
) -> Path:
    """Resolve the path of an output and check that it may be written, before long work begins.

    Symbolic links are followed, so that a link stays a link.

    Parameters
    ----------
    path : str or Path
    force : bool
        Whether an existing file may be replaced.
    inputs : iterable of str or Path
        Files that the work reads; not replaced even with `force`, because they are measurements.

    Returns
    -------
    Path
        The resolved path.

    Raises
    ------
    TargetError
        If the folder is missing or not writable, or an existing file may not be replaced.
    """
    shown = Path(path)
    check_in_project(shown)
    if not shown.name:
        raise TargetError(Finding("output.no-name"), file=shown)
    try:
        target = shown.resolve()
        mode = target.stat().st_mode
    except FileNotFoundError:
        mode = None
    except (OSError, RuntimeError, ValueError) as error:
        raise write_error(shown, error) from error
    parent = target.parent
    if not parent.is_dir():
        finding = (
            Finding("output.folder-is-file", folder=parent)
            if parent.exists()
            else Finding("output.no-folder", folder=parent)
        )
        raise TargetError(finding, file=shown)
    if mode is None:
        return target
    if stat.S_ISDIR(mode):
        raise TargetError(Finding("output.is-folder"), file=shown)
    if not stat.S_ISREG(mode):
        raise TargetError(Finding("output.is-device"), file=shown)
    if any(_is_same_file(target, input_file) for input_file in inputs):
        raise TargetError(Finding("output.is-input"), file=shown)
    if not force:
        raise TargetError(Finding("output.exists"), file=shown)
    if not os.access(target, os.W_OK):
        raise TargetError(Finding("output.write-protected"), file=shown)
    return target


@contextlib.contextmanager
def atomic_write(path: str | Path, force: bool = False) -> Iterator[Path]:
    """Yield a temporary path with the suffix of the target, and rename it at the end.

    The temporary file is created empty before the block. If the block raises or the disk is full,
    the temporary file is removed and an older target is unchanged. Raises `TargetError`.
    """
    with atomic_group([path], force) as (temporary,):
        yield temporary


@contextlib.contextmanager
def atomic_group(
    paths: Sequence[str | Path],
    force: bool = False,
    inputs: Iterable[str | Path] = (),
    named: Collection[str | Path] = (),
) -> Iterator[list[Path]]:
    """Yield temporary paths for files that belong together; rename all of them or none.

    A file system cannot rename several files at once: if a later rename fails, the earlier ones are
    undone and the replaced files are restored. Only a crash, or another failure between two
    renames, can leave a part of them.

    Parameters
    ----------
    paths : sequence of str or Path
        Different files.
    force, inputs
        As in `check_target`.
    named : collection of str or Path
        Paths that the user has named besides the first; the program has named the others.

    Raises
    ------
    TargetError
        As `check_target`, or if a file cannot be written.
    """
    input_files = list(inputs)
    for path in paths[1:]:
        if path not in named:
            check_generated_path(path)
    targets = [check_target(path, force=force, inputs=input_files) for path in paths]
    if len(set(targets)) < len(targets):
        raise TargetError(Finding("output.same-names"), file=paths[0])
    # Short names: those of the targets may have the maximum length of the file system.
    key = secrets.token_hex(6)
    temporaries = [t.with_name(f".vom-{key}-{i}.part{t.suffix}") for i, t in enumerate(targets)]
    shown = dict(zip(temporaries, map(Path, paths), strict=True))
    current = temporaries[0]
    try:
        for current in temporaries:
            os.close(os.open(current, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
        current = temporaries[0]
        yield temporaries
        for current in temporaries:
            _flush_to_disk(current)
        current = temporaries[0]
        stop_requests.check()
        _rename_all(temporaries, targets, key)
    except Exception as error:
        disk_error = _disk_error(error, current, shown)
        if disk_error is None:
            raise
        raise disk_error from error
    finally:
        for folder in dict.fromkeys(target.parent for target in targets):
            # Libraries may write additional files beside an output.
            for leftover in folder.glob(f".vom-{key}-*"):
                if leftover.suffix != _BACKUP_SUFFIX:
                    with contextlib.suppress(OSError):
                        leftover.unlink()
    for folder in dict.fromkeys(target.parent for target in targets):
        _flush_folder(folder)


def _disk_error(error: Exception, current: Path, shown: Mapping[Path, Path]) -> TargetError | None:
    """Convert an error of the disk, or one about a temporary file, to one about the target.

    Libraries wrap errors of the system, lose their number, or fail later because of one.

    Parameters
    ----------
    error : Exception
    current : Path
        Temporary file that was being written.
    shown : mapping of Path to Path
        Targets by their temporary names.

    Returns
    -------
    TargetError or None
        None for other errors.
    """
    file = getattr(error, "file", None)
    target = shown.get(Path(file), Path(file)) if file else shown[current]
    if isinstance(error, VomError) and (
        not isinstance(error, TargetError) or target not in shown.values()
    ):
        return None
    for cause in _causes(error):
        if isinstance(cause, OSError) and cause.errno in _TARGET_ERRNOS:
            path = None if cause.filename is None else Path(os.fsdecode(cause.filename))
            if path is None or path in shown or path in shown.values():
                return write_error(shown.get(path or current, path or shown[current]), cause)
    # An error with a number is about another file; errors of the program are not changed.
    if isinstance(error, OSError) and error.errno is not None:
        return None
    if (number := probe_write_errno(target.parent)) is not None:
        return write_error(target, OSError(number, os.strerror(number)))
    if isinstance(error, TargetError):
        finding = cause_of(error)
        values = {
            name: _replace_temporary_names(value, shown) for name, value in finding.values.items()
        }
        return TargetError(Finding(finding.code, **values), file=target)
    return None


def _replace_temporary_names(value: object, shown: Mapping[Path, Path]) -> object:
    """Replace the names of temporary files in a text by those of their targets."""
    if isinstance(value, str):
        for temporary, target in shown.items():
            value = value.replace(str(temporary), str(target))
            value = value.replace(temporary.name, target.name)
    return value


def _causes(error: BaseException) -> Iterator[BaseException]:
    """Yield an error and the errors that caused it."""
    visited: set[int] = set()
    current: BaseException | None = error
    while current is not None and id(current) not in visited:
        visited.add(id(current))
        yield current
        current = current.__cause__ or current.__context__


def _rename_all(temporaries: list[Path], targets: list[Path], key: str) -> None:
    if len(targets) == 1:
        os.replace(temporaries[0], targets[0])
        return
    backups: dict[Path, Path] = {}
    renamed: list[Path] = []
    try:
        for i, target in enumerate(targets):
            if target.exists():
                backups[target] = _link_or_rename(
                    target, target.with_name(f".vom-{key}-{i}{_BACKUP_SUFFIX}")
                )
        for temporary, target in zip(temporaries, targets, strict=True):
            os.replace(temporary, target)
            renamed.append(target)
    except BaseException:
        for target in renamed:
            if target not in backups:
                with contextlib.suppress(OSError):
                    target.unlink()
        for target, backup in backups.items():
            # If this fails too, the older file stays under its backup name.
            with contextlib.suppress(OSError):
                if target in renamed or not target.exists():
                    os.replace(backup, target)
                else:
                    backup.unlink()
        raise
    for backup in backups.values():
        with contextlib.suppress(OSError):
            backup.unlink()


def _link_or_rename(target: Path, second_name: Path) -> Path:
    """Link a file to a second name, or rename it if the file system has no hard links."""
    try:
        os.link(target, second_name)
    except OSError:
        os.replace(target, second_name)
    return second_name


def write_bytes(path: str | Path, data: bytes, *, force: bool = False) -> None:
    """Write `data` to `path`, whole or not at all. Raises `TargetError`."""
    with atomic_write(path, force) as temporary:
        temporary.write_bytes(data)


def _is_same_file(target: Path, other: str | Path) -> bool:
    try:
        return target.samefile(other)
    except (OSError, ValueError):  # a missing input is reported by its reader
        return False


def _flush_to_disk(path: Path) -> None:
    # Windows can flush only a handle that may write.
    with open(path, "r+b") as file:
        os.fsync(file.fileno())


def _flush_folder(folder: Path) -> None:
    """Make a rename durable, if the system supports opening a folder."""
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
