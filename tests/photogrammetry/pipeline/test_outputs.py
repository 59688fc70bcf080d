"""What a reconstruction says of the disk that it writes to."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.messages import refused
from vomstudio.core.errors import InputError, TargetError
from vomstudio.photogrammetry.pipeline.outputs import report_disk_errors


@pytest.mark.parametrize(
    "said",
    [
        "[sqlite3_utils.h:42] SQLite error: disk I/O error",
        "SQLite error: attempt to write a readonly database",
        "[database.cc:9] unable to open database file",
        "No registered database factory succeeded.",
        '[io.cc:4] Check failed: (file).is_open() Could not open "points3D.bin". Is the path a',
    ],
)
def test_library_disk_errors_are_reported_as_target_errors(tmp_path: Path, said: str) -> None:
    with refused("disk.failed", TargetError, file=tmp_path), report_disk_errors(tmp_path):
        raise RuntimeError(said)


def test_other_errors_are_passed_through_unchanged(tmp_path: Path) -> None:
    for error in (RuntimeError("no more matches"), KeyError("views"), InputError("no photo")):
        with pytest.raises(type(error)) as caught, report_disk_errors(tmp_path):
            raise error
        assert caught.value is error
