"""Folders of reconstructions in a project of somebody else: nobody waits for pipes in them, and
what is no file of ours is not there."""

from __future__ import annotations

import json
import os
from dataclasses import fields
from pathlib import Path

import pytest

from tests.messages import refused
from vomstudio.core.errors import TargetError
from vomstudio.photogrammetry.pipeline.outputs import claim_folder
from vomstudio.studio.jobs.reconstruct_options import ReconstructOptions
from vomstudio.ui.panels.photos import reconstruction_folders as folders
from vomstudio.ui.panels.photos.reconstruction_settings import (
    ReconstructionSettings,
    read_request,
)

NAMES = [folders.REQUEST, folders.RESULT, folders._FAILURE_FILE, folders.FILE_NAME]


@pytest.fixture(params=["pipe", "dangling link", "nested"])
def out(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    place = tmp_path / "a.vom" / folders.RECONSTRUCTIONS / "photos-preview"
    place.mkdir(parents=True)
    (place / folders._FAILURE_FILE).parent.mkdir(exist_ok=True)
    for name in NAMES:
        if request.param == "pipe":
            os.mkfifo(place / name)
        elif request.param == "nested":
            (place / name).write_text("[" * 100_000)
        else:
            (place / name).symlink_to(tmp_path / "nowhere")
    return place


@pytest.mark.full
def test_invalid_reconstruction_folders_are_ignored(out: Path, tmp_path: Path) -> None:
    assert folders.read_survey_report(out) is None
    assert read_request(out / folders.REQUEST) is None
    assert folders.find_newest(tmp_path / "a.vom") is None
    assert folders.read_failure(out).strip("[") == ""
    assert folders.find_alignment(out.parent / "other", tmp_path) is None


def test_linked_output_folder_is_rejected(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    place = tmp_path / "a.vom" / folders.RECONSTRUCTIONS / "photos-preview"
    place.parent.mkdir(parents=True)
    place.symlink_to(tmp_path / "elsewhere")
    with refused("output.link", TargetError):
        claim_folder(place)
    assert not any((tmp_path / "elsewhere").iterdir())


def test_settings_of_an_earlier_run_are_restored(tmp_path: Path) -> None:
    control = tmp_path / "control.csv"
    control.write_text("label,x,y,z\n")
    options = ReconstructOptions(
        quality="low",
        crs="EPSG:32633",
        threads=3,
        seed=7,
        device="cpu",
        region="0,1,2,10,20,400000.125",
    )
    settings = ReconstructionSettings(options).replace_control(control, None, is_sidecar=False)
    request = settings.build_request(tmp_path / "photos", tmp_path / "out")
    stored = {item.name: getattr(request, item.name) for item in fields(request)}
    (tmp_path / folders.REQUEST).write_text(json.dumps(stored, default=str))
    assert read_request(tmp_path / folders.REQUEST) == (tmp_path / "photos", settings)
    for name, wrong in (("quality", "finest"), ("threads", "many"), ("region", [0, 1, 2])):
        (tmp_path / folders.REQUEST).write_text(json.dumps(stored | {name: wrong}, default=str))
        assert read_request(tmp_path / folders.REQUEST) is None
