"""Files that appear whole or not at all.

Everything the program writes for a user goes through `atomic_write`: the work happens under a
temporary name in the target's own folder (a rename is atomic only within one file system), is
flushed to the disk, and only then takes the target's name. A failure leaves what was there before.
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
from vomstudio.core.files.containment import check_beside, check_in_project
from vomstudio.core.files.disk_errors import not_written, number_of_failure
from vomstudio.core.findings import Finding, cause_of

_OF_THE_TARGET = {
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
_OLD = ".old"


def check_target(
    path: str | Path, *, force: bool = False, inputs: Iterable[str | Path] = ()
) -> Path:
    """The file that `path` stands for, if it may be written; called before long work begins.

    inputs: files that the work reads, and which `force` does not replace either: measurements are
    not exchanged for what was made of them. Symbolic links are followed, so that a link stays a
    link. Raises `TargetError` where the folder is missing or not writable, or something is there
    already that may not be replaced.
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
        raise not_written(shown, error) from error
    parent = target.parent
    if not parent.is_dir():
        said = (
            Finding("output.folder-is-file", folder=parent)
            if parent.exists()
            else Finding("output.no-folder", folder=parent)
        )
        raise TargetError(said, file=shown)
    if mode is None:
        return target
    if stat.S_ISDIR(mode):
        raise TargetError(Finding("output.is-folder"), file=shown)
    if not stat.S_ISREG(mode):
        raise TargetError(Finding("output.is-device"), file=shown)
    if any(_is_same_file(target, given) for given in inputs):
        raise TargetError(Finding("output.is-input"), file=shown)
    if not force:
        raise TargetError(Finding("output.exists"), file=shown)
    if not os.access(target, os.W_OK):
        raise TargetError(Finding("output.write-protected"), file=shown)
    return target


@contextlib.contextmanager
def atomic_write(path: str | Path, force: bool = False) -> Iterator[Path]:
    """Yield the temporary path to write to (same ending as the target); rename it at the end.

    The temporary file exists, empty, when the block is entered. If the block raises, or the disk is
    full, the temporary file is removed and an older target stays as it was. Raises `TargetError`.
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
    """`atomic_write` for files that belong together: all take their names, or none does.

    named: those of `paths`, besides the first, that the user has named; the names of the others
    are ours. Yields a temporary path for each of `paths`, which must be different files. A file
    system has no rename of several files at once: where a later one fails, the earlier ones are
    taken back and what was replaced returns. Only a crash or another failure between two renames
    can leave them apart.
    """
    given = list(inputs)
    for path in paths[1:]:
        if path not in named:
            check_beside(path)
    targets = [check_target(path, force=force, inputs=given) for path in paths]
    if len(set(targets)) < len(targets):
        raise TargetError(Finding("output.same-names"), file=paths[0])
    # Short names of their own: the targets' may already be as long as the file system allows.
    key = secrets.token_hex(6)
    temporaries = [t.with_name(f".vom-{key}-{i}.part{t.suffix}") for i, t in enumerate(targets)]
    shown = dict(zip(temporaries, map(Path, paths), strict=True))
    at = temporaries[0]
    try:
        for at in temporaries:
            os.close(os.open(at, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
        at = temporaries[0]
        yield temporaries
        for at in temporaries:
            _flush_to_disk(at)
        at = temporaries[0]
        stop_requests.check()
        _put_in_place(temporaries, targets, key)
    except Exception as error:
        disk_error = _disk_error(error, at, shown)
        if disk_error is None:
            raise
        raise disk_error from error
    finally:
        for folder in dict.fromkeys(target.parent for target in targets):
            # Libraries put files of their own beside what they write.
            for left in folder.glob(f".vom-{key}-*"):
                if left.suffix != _OLD:
                    with contextlib.suppress(OSError):
                        left.unlink()
    for folder in dict.fromkeys(target.parent for target in targets):
        _flush_folder(folder)


def _disk_error(error: Exception, at: Path, shown: Mapping[Path, Path]) -> TargetError | None:
    """Return an error of the disk, or one that names a temporary file, for the target; else None.

    shown: targets by their temporary names; at: the one that was being written. Libraries wrap the
    system's errors, lose their number, or fall over something else after one.
    """
    file = getattr(error, "file", None)
    about = shown.get(Path(file), Path(file)) if file else shown[at]
    if isinstance(error, VomError) and (
        not isinstance(error, TargetError) or about not in shown.values()
    ):
        return None
    for cause in _causes(error):
        if isinstance(cause, OSError) and cause.errno in _OF_THE_TARGET:
            path = None if cause.filename is None else Path(os.fsdecode(cause.filename))
            if path is None or path in shown or path in shown.values():
                return not_written(shown.get(path or at, path or shown[at]), cause)
    # Errors with a number are of another file; errors of the program are told as such.
    if isinstance(error, OSError) and error.errno is not None:
        return None
    if (number := number_of_failure(about.parent)) is not None:
        return not_written(about, OSError(number, os.strerror(number)))
    if isinstance(error, TargetError):
        finding = cause_of(error)
        values = {
            name: _replace_temporary_names(value, shown) for name, value in finding.values.items()
        }
        return TargetError(Finding(finding.code, **values), file=about)
    return None


def _replace_temporary_names(value: object, shown: Mapping[Path, Path]) -> object:
    """Replace the names of temporary files in a text by those of their targets."""
    if isinstance(value, str):
        for temporary, target in shown.items():
            value = value.replace(str(temporary), str(target))
            value = value.replace(temporary.name, target.name)
    return value


def _causes(error: BaseException) -> Iterator[BaseException]:
    """An error, and those that it came of."""
    seen: set[int] = set()
    now: BaseException | None = error
    while now is not None and id(now) not in seen:
        seen.add(id(now))
        yield now
        now = now.__cause__ or now.__context__


def _put_in_place(temporaries: list[Path], targets: list[Path], key: str) -> None:
    if len(targets) == 1:
        os.replace(temporaries[0], targets[0])
        return
    older: dict[Path, Path] = {}
    placed: list[Path] = []
    try:
        for i, target in enumerate(targets):
            if target.exists():
                older[target] = _second_name(target, target.with_name(f".vom-{key}-{i}{_OLD}"))
        for temporary, target in zip(temporaries, targets, strict=True):
            os.replace(temporary, target)
            placed.append(target)
    except BaseException:
        for target in placed:
            if target not in older:
                with contextlib.suppress(OSError):
                    target.unlink()
        for target, aside in older.items():
            # Where even this fails, the older file stays under the name that it has now.
            with contextlib.suppress(OSError):
                if target in placed or not target.exists():
                    os.replace(aside, target)
                else:
                    aside.unlink()
        raise
    for aside in older.values():
        with contextlib.suppress(OSError):
            aside.unlink()


def _second_name(target: Path, aside: Path) -> Path:
    """Keep what is at `target` as `aside` too; where the system has no second names, instead."""
    try:
        os.link(target, aside)
    except OSError:
        os.replace(target, aside)
    return aside


def write_bytes(path: str | Path, data: bytes, *, force: bool = False) -> None:
    """Write `data` to `path`, whole or not at all. Raises `TargetError`."""
    with atomic_write(path, force) as temporary:
        temporary.write_bytes(data)


def _is_same_file(target: Path, given: str | Path) -> bool:
    try:
        return target.samefile(given)
    except (OSError, ValueError):  # it is missing, which its reader will say
        return False


def _flush_to_disk(path: Path) -> None:
    # Windows can flush only a handle that may write.
    with open(path, "r+b") as file:
        os.fsync(file.fileno())


def _flush_folder(folder: Path) -> None:
    """Make the rename itself durable, where the system lets a folder be opened."""
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
