"""Backups of the user's files before they are replaced."""

from __future__ import annotations

import contextlib
import itertools
from pathlib import Path

from vomstudio.core.errors import InputError, TargetError
from vomstudio.core.files.atomic import write_bytes
from vomstudio.core.files.containment import check_generated_path
from vomstudio.core.files.regular import read_whole_file
from vomstudio.core.findings import Finding


def back_up(path: Path) -> Path:
    """Copy a file to NAME.bak, NAME.bak2 and so on, unless an identical copy exists.

    Returns
    -------
    Path
        Path of the copy.

    Raises
    ------
    TargetError
        If the copy cannot be written.
    """
    try:
        data = read_whole_file(path)
    except OSError as error:
        raise TargetError(Finding("output.no-backup", reason=error.strerror), file=path) from error
    for number in itertools.count(1):
        backup = path.with_name(f"{path.name}.bak{'' if number == 1 else number}")
        with contextlib.suppress(OSError, InputError):
            if read_whole_file(backup) == data:
                return backup
        if not backup.exists():
            check_generated_path(backup)
            write_bytes(backup, data)
            return backup
    raise AssertionError("unreachable")
