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
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from vomstudio.errors import TargetError
from vomstudio.files.disk_troubles import not_written
from vomstudio.files.inside import check_beside, check_in_project
from vomstudio.words import tr

_OF_THE_TARGET = {
    errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EACCES, errno.EPERM, errno.EROFS, errno.EIO,
    errno.ENAMETOOLONG, errno.ENOENT,
}  # fmt: skip


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
        raise TargetError(tr("This does not name a file. Give the output a file name."), file=shown)
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
            tr("{folder} is a file, not a folder. Choose another folder.", folder=parent)
            if parent.exists()
            else tr(
                "The folder {folder} does not exist. Create it, or choose another.", folder=parent
            )
        )
        raise TargetError(said, file=shown)
    if mode is None:
        return target
    if stat.S_ISDIR(mode):
        raise TargetError(tr("This is a folder. Give the output a file name."), file=shown)
    if not stat.S_ISREG(mode):
        raise TargetError(
            tr("This is a device or a pipe. Give the output a file name."), file=shown
        )
    if any(_is_same_file(target, given) for given in inputs):
        raise TargetError(tr("The command reads this file. Choose another output."), file=shown)
    if not force:
        raise TargetError(
            tr("This file exists already. Use --force to replace it, or choose another name."),
            file=shown,
        )
    if not os.access(target, os.W_OK):
        raise TargetError(tr("This file is write-protected. Choose another name."), file=shown)
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
    paths: Sequence[str | Path], force: bool = False, inputs: Iterable[str | Path] = ()
) -> Iterator[list[Path]]:
    """`atomic_write` for files that belong together: all take their names, or none does.

    Yields a temporary path for each of `paths`, which must be different files. A file system has
    no rename of several files at once: where a later one fails, the earlier ones are taken back and
    what was replaced returns. Only a crash between two renames can leave them apart.
    """
    given = list(inputs)
    # The first is the user's; the names of what goes with it are ours.
    for path in paths[1:]:
        check_beside(path)
    targets = [check_target(path, force=force, inputs=given) for path in paths]
    if len(set(targets)) < len(targets):
        raise TargetError(
            tr("Two of the outputs have the same name. Give each its own."), file=paths[0]
        )
    # Short names of their own: the targets' may already be as long as the file system allows.
    key = secrets.token_hex(6)
    temporaries = [t.with_name(f".vom-{key}-{i}.part{t.suffix}") for i, t in enumerate(targets)]
    shown = Path(paths[0])
    try:
        for path, temporary in zip(paths, temporaries, strict=True):
            shown = Path(path)
            try:
                os.close(os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
            except OSError as error:
                raise not_written(shown, error) from error
        shown = Path(paths[0])
        yield temporaries
        for temporary in temporaries:
            _flush_to_disk(temporary)
        _put_in_place(temporaries, targets, key)
    except OSError as error:
        if error.errno in _OF_THE_TARGET and _is_about(error, *temporaries, *targets):
            raise not_written(shown, error) from error
        raise
    finally:
        for temporary in temporaries:
            temporary.unlink(missing_ok=True)
    for folder in dict.fromkeys(target.parent for target in targets):
        _flush_folder(folder)


def _put_in_place(temporaries: list[Path], targets: list[Path], key: str) -> None:
    if len(targets) == 1:
        os.replace(temporaries[0], targets[0])
        return
    older: dict[Path, Path] = {}
    placed: list[Path] = []
    try:
        for i, (temporary, target) in enumerate(zip(temporaries, targets, strict=True)):
            if target.exists():
                aside = target.with_name(f".vom-{key}-{i}.old")
                os.replace(target, aside)
                older[target] = aside
            os.replace(temporary, target)
            placed.append(target)
    except BaseException:
        for target in placed:
            target.unlink(missing_ok=True)
        for target, aside in older.items():
            os.replace(aside, target)
        raise
    for aside in older.values():
        aside.unlink(missing_ok=True)


def write_bytes(path: str | Path, data: bytes, *, force: bool = False) -> None:
    """Write `data` to `path`, whole or not at all. Raises `TargetError`."""
    with atomic_write(path, force) as temporary:
        temporary.write_bytes(data)


def _is_same_file(target: Path, given: str | Path) -> bool:
    try:
        return target.samefile(given)
    except (OSError, ValueError):  # it is missing, which its reader will say
        return False


def _is_about(error: OSError, *paths: Path) -> bool:
    """Whether the failure is the output's: writes to an open file carry no name."""
    return error.filename is None or Path(os.fsdecode(error.filename)) in paths


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
