"""What a user has made is put aside before something else takes its name."""

from __future__ import annotations

import contextlib
import itertools
from pathlib import Path

from vomstudio.core.errors import InputError, TargetError
from vomstudio.core.files.atomic import write_bytes
from vomstudio.core.files.containment import check_beside
from vomstudio.core.files.regular import read_whole
from vomstudio.core.findings import Finding


def set_aside(path: Path) -> Path:
    """Copy a file to NAME.bak beside it, or NAME.bak2 and so on where that is taken; where.

    A copy with the same content is not made twice. Raises TargetError.
    """
    try:
        data = read_whole(path)
    except OSError as error:
        raise TargetError(Finding("output.no-backup", reason=error.strerror), file=path) from error
    for number in itertools.count(1):
        kept = path.with_name(f"{path.name}.bak{'' if number == 1 else number}")
        with contextlib.suppress(OSError, InputError):
            if read_whole(kept) == data:
                return kept
        if not kept.exists():
            check_beside(kept)
            write_bytes(kept, data)
            return kept
    raise AssertionError("numbers do not end")
