"""Files appear whole or not at all."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

import pytest

from tests.messages import refused
from vomstudio.core.errors import TargetError
from vomstudio.core.files import atomic
from vomstudio.core.files.atomic import atomic_group, atomic_write, check_target, write_bytes

as_root = hasattr(os, "geteuid") and os.geteuid() == 0


def left_in(folder: Path) -> list[str]:
    return sorted(p.name for p in folder.iterdir())


def test_finished_file_has_final_name_and_no_temporary_remains(tmp_path: Path) -> None:
    with atomic_write(tmp_path / "out.csv") as temporary:
        assert temporary.suffix == ".csv"
        temporary.write_text("whole")
        assert not (tmp_path / "out.csv").exists()
    assert left_in(tmp_path) == ["out.csv"]
    assert (tmp_path / "out.csv").read_text() == "whole"


def write_half(target: Path, error: BaseException, *, force: bool = False) -> None:
    with atomic_write(target, force) as temporary:
        temporary.write_text("half")
        raise error


def test_a_failure_leaves_nothing_behind(tmp_path: Path) -> None:
    failure = RuntimeError()
    with pytest.raises(RuntimeError) as error:
        write_half(tmp_path / "out.csv", failure)
    assert error.value is failure
    assert left_in(tmp_path) == []


def test_an_interruption_leaves_nothing_behind(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        write_half(tmp_path / "out.csv", KeyboardInterrupt())
    assert left_in(tmp_path) == []


def test_a_failure_keeps_the_older_file(tmp_path: Path) -> None:
    target = tmp_path / "out.csv"
    target.write_text("old")
    with pytest.raises(ValueError, match="bad"):
        write_half(target, ValueError("bad"), force=True)
    assert target.read_text() == "old"
    assert left_in(tmp_path) == ["out.csv"]


def test_an_existing_file_is_replaced_only_by_force(tmp_path: Path) -> None:
    target = tmp_path / "out.csv"
    target.write_text("old")
    with refused("output.exists", TargetError) as caught:
        write_bytes(target, b"new")
    assert caught.value.file == str(target)
    assert target.read_text() == "old"
    write_bytes(target, b"new", force=True)
    assert target.read_text() == "new"


def test_input_file_is_not_replaced_even_with_force(tmp_path: Path) -> None:
    source, link = tmp_path / "in.csv", tmp_path / "link.csv"
    source.write_text("measured")
    link.symlink_to(source)
    for target in (source, link):
        with refused("output.is-input", TargetError):
            check_target(target, force=True, inputs=[source])
    assert check_target(tmp_path / "out.csv", inputs=[source, tmp_path / "gone.csv"])


def test_missing_folder_is_reported(tmp_path: Path) -> None:
    with refused("output.no-folder", TargetError):
        check_target(tmp_path / "missing" / "out.csv")


def test_file_in_place_of_folder_is_reported(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    with refused("output.unwritable", TargetError):
        check_target(tmp_path / "file" / "out.csv")


@pytest.mark.parametrize("force", [False, True])
def test_folder_is_refused_as_target(tmp_path: Path, force: bool) -> None:
    with refused("output.is-folder", TargetError):
        check_target(tmp_path, force=force)


@pytest.mark.skipif(not Path("/dev/null").exists(), reason="no devices here")
def test_a_device_is_never_replaced_by_a_file() -> None:
    with refused("output.is-device", TargetError):
        check_target("/dev/null", force=True)
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)


@pytest.mark.parametrize("path", ["", ".", "/", "\0", "a\0b"])
def test_invalid_file_names_are_refused(path: str) -> None:
    with pytest.raises(TargetError):
        check_target(path, force=True)


def test_a_name_too_long_for_the_file_system_is_refused(tmp_path: Path) -> None:
    with refused("disk.name-too-long", TargetError):
        write_bytes(tmp_path / ("x" * 300), b"")
    assert left_in(tmp_path) == []


def test_longest_allowed_file_name_is_written(tmp_path: Path) -> None:
    write_bytes(tmp_path / ("x" * 251 + ".csv"), b"1")
    assert len(left_in(tmp_path)) == 1


def test_a_link_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "real.csv").write_text("old")
    (tmp_path / "link.csv").symlink_to(tmp_path / "real.csv")
    write_bytes(tmp_path / "link.csv", b"new", force=True)
    assert (tmp_path / "link.csv").is_symlink()
    assert (tmp_path / "real.csv").read_text() == "new"


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT])
def test_full_disk_is_reported_and_leaves_no_files(tmp_path: Path, number: int) -> None:
    with refused("disk.full", TargetError) as caught:
        write_half(tmp_path / "out.csv", OSError(number, os.strerror(number)))
    assert caught.value.file == str(tmp_path / "out.csv")
    assert left_in(tmp_path) == []


def test_disk_full_at_flush_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(descriptor: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(atomic.os, "fsync", full)
    with refused("disk.full", TargetError):
        write_bytes(tmp_path / "out.csv", b"data")
    assert left_in(tmp_path) == []


def test_error_of_another_file_is_not_attributed_to_target(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError), atomic_write(tmp_path / "out.csv"):
        (tmp_path / "input that is not there").read_bytes()
    assert left_in(tmp_path) == []


@pytest.mark.skipif(as_root, reason="root may write anywhere")
def test_folder_without_permission_is_reported(tmp_path: Path) -> None:
    tmp_path.chmod(0o555)
    try:
        with pytest.raises(TargetError, match="permission"):
            write_bytes(tmp_path / "out.csv", b"data")
    finally:
        tmp_path.chmod(0o755)


def test_denied_permission_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(path: Path, flags: int, mode: int) -> int:
        raise PermissionError(errno.EACCES, "Permission denied", str(path))

    monkeypatch.setattr(atomic.os, "open", refuse)
    with refused("disk.no-permission", TargetError):
        write_bytes(tmp_path / "out.csv", b"data")


def test_files_that_belong_together_appear_together(tmp_path: Path) -> None:
    a, b = tmp_path / "a.txt", tmp_path / "b.txt"
    a.write_text("old")
    with atomic_group([a, b], force=True) as (first, second):
        first.write_text("new a")
        second.write_text("new b")
        assert a.read_text() == "old"
    assert (a.read_text(), b.read_text()) == ("new a", "new b")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.txt", "b.txt"]


def test_failed_group_is_rolled_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    paths = [tmp_path / name for name in ("a.txt", "b.txt", "c.txt")]
    paths[0].write_text("old a")
    paths[2].write_text("old c")
    rename = os.replace

    def failing(source: Path, target: Path) -> None:
        if target == paths[2] and ".part" in source.name:
            raise OSError(errno.EIO, "broken", str(target))
        rename(source, target)

    monkeypatch.setattr(os, "replace", failing)

    def write_all() -> None:
        with atomic_group(paths, force=True) as temporaries:
            for temporary in temporaries:
                temporary.write_text("new")

    with pytest.raises(TargetError):
        write_all()
    assert paths[0].read_text() == "old a"
    assert paths[2].read_text() == "old c"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.txt", "c.txt"]


def test_group_with_duplicate_targets_is_refused(tmp_path: Path) -> None:
    with (
        refused("output.same-names", TargetError),
        atomic_group([tmp_path / "a", tmp_path / "a"]),
    ):
        pass
    assert list(tmp_path.iterdir()) == []
