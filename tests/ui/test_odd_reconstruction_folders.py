"""Folders of reconstructions in a project of somebody else: nobody waits for pipes in them, and
what is no file of ours is not there."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.messages import refused
from vomstudio.core.errors import TargetError
from vomstudio.photogrammetry.pipeline.outputs import claim_folder
from vomstudio.ui.panels.photos import reconstruction_folders as folders
from vomstudio.ui.panels.photos.reconstruction_settings import read_request

NAMES = [folders.REQUEST, folders.RESULT, folders._FAILURE, folders.FILE_NAME]


@pytest.fixture(params=["pipe", "dangling link", "nested"])
def out(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    place = tmp_path / "a.vom" / folders.RECONSTRUCTIONS / "photos-preview"
    place.mkdir(parents=True)
    (place / folders._FAILURE).parent.mkdir(exist_ok=True)
    for name in NAMES:
        if request.param == "pipe":
            os.mkfifo(place / name)
        elif request.param == "nested":
            (place / name).write_text("[" * 100_000)
        else:
            (place / name).symlink_to(tmp_path / "nowhere")
    return place


@pytest.mark.full
def test_nothing_is_read_from_them(out: Path, tmp_path: Path) -> None:
    assert folders.read_survey_report(out) is None
    assert read_request(out / folders.REQUEST) is None
    assert folders.find_newest(tmp_path / "a.vom") is None
    assert folders.read_failure(out).strip("[") == ""
    assert folders.find_alignment(out.parent / "other", tmp_path) is None


def test_a_folder_that_is_a_link_is_not_filled(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    place = tmp_path / "a.vom" / folders.RECONSTRUCTIONS / "photos-preview"
    place.parent.mkdir(parents=True)
    place.symlink_to(tmp_path / "elsewhere")
    with refused("output.link", TargetError):
        claim_folder(place)
    assert not any((tmp_path / "elsewhere").iterdir())
