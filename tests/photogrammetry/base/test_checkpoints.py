"""What is finished stays finished."""

import errno
import json
import os

import pytest

from tests.messages import refused
from vomstudio.core.errors import TargetError
from vomstudio.io.models.reconstruction_file import CURRENT_FILE, WORK
from vomstudio.photogrammetry.base.checkpoints import (
    Checkpoints,
    file_name,
    write_atomically,
)
from vomstudio.photogrammetry.base.stage_folders import FEATURES, stage_folder


def test_stage_is_done_only_after_it_is_finished(tmp_path):
    stage = Checkpoints(tmp_path).stage("depths", "inputs", 1)
    (stage.folder / "a.npz").write_bytes(b"half of the photos")
    assert not stage.is_done
    again = Checkpoints(tmp_path).stage("depths", "inputs", 1)
    assert (again.folder / "a.npz").exists(), "what an earlier run finished is found again"
    again.finish(photos=2)
    assert Checkpoints(tmp_path).stage("depths", "inputs", 1).is_done
    assert Checkpoints(tmp_path).stage("depths", "inputs", 1).facts["photos"] == 2


def test_different_inputs_make_a_separate_stage(tmp_path):
    Checkpoints(tmp_path).stage("depths", "inputs", 1).finish()
    assert not Checkpoints(tmp_path).stage("depths", "inputs", 2).is_done
    assert not Checkpoints(tmp_path).stage("depths", "others", 1).is_done


def test_time_of_an_unfinished_run_is_included(tmp_path):
    first = Checkpoints(tmp_path).stage("depths")
    first._start_time -= 10
    first.pause()
    second = Checkpoints(tmp_path).stage("depths")
    second._start_time -= 5
    second.finish()
    assert Checkpoints(tmp_path).stage("depths").seconds == pytest.approx(15, abs=0.5)


def test_folders_in_use_are_recorded_and_others_kept(tmp_path):
    other = Checkpoints(tmp_path).stage("depths", 1)
    other.finish()
    now = Checkpoints(tmp_path)
    stage = now.stage("depths", 2)
    assert now.other_folders(stage) == [other.folder]
    stage.finish()
    now.record_current()
    recorded = json.loads((tmp_path / CURRENT_FILE).read_text())
    assert recorded["folders"] == [stage.folder.name, FEATURES]
    assert other.folder.is_dir()


def test_folder_of_a_stage_that_is_used_again_becomes_the_newest(tmp_path):
    work = tmp_path / WORK
    old, new = (Checkpoints(work).stage("depths", k) for k in (1, 2))
    for seconds, stage in ((100, old), (200, new)):
        stage.finish()
        os.utime(stage.folder, (seconds, seconds))
    assert stage_folder(tmp_path, "depths") == new.folder
    assert Checkpoints(work).stage("depths", 1).is_done
    assert stage_folder(tmp_path, "depths") == old.folder


def test_partial_files_of_a_killed_run_are_removed(tmp_path):
    old = Checkpoints(tmp_path).stage("depths", "other settings")
    stage = Checkpoints(tmp_path).stage("depths")
    (stage.folder / ".a.npz.part").write_bytes(b"half")
    (stage.folder / "b.npz").write_bytes(b"whole")
    now = Checkpoints(tmp_path)
    now.remove_partial_files()
    assert [p.name for p in stage.folder.iterdir()] == ["b.npz"]
    assert old.folder.exists(), "other settings may be gone on with"
    now.stage("depths").finish()
    assert now.size() == sum(p.stat().st_size for p in tmp_path.glob("*/*"))


def test_file_that_cannot_be_written_completely_is_removed(tmp_path):
    def full(path):
        path.write_bytes(b"half")
        raise OSError(errno.ENOSPC, "No space left on device")

    with refused("reconstruct.not-written", TargetError):
        write_atomically(tmp_path / "a.npz", full)
    assert list(tmp_path.iterdir()) == []


def test_photos_with_the_same_name_in_two_folders_get_different_files():
    assert file_name("a/1.jpg") != file_name("b/1.jpg")
    assert file_name("a/1.jpg") == file_name("a/1.jpg")
    assert "/" not in file_name("ä b/../ü?.jpg")
