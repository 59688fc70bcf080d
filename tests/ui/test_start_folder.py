"""Dialogs begin beside the user's own files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from vomstudio.project.sample import sample_model
from vomstudio.ui.base.command_targets import start_folder


@pytest.mark.full
def test_dialogs_start_in_the_last_folder_outside_the_program(studio: Any, tmp_path: Path) -> None:
    own = tmp_path / "fieldwork"
    own.mkdir()
    studio.settings.recent = [str(sample_model()), str(tmp_path / "gone" / "x.obj")]
    assert not Path(start_folder(studio)).is_relative_to(sample_model().parent)
    assert Path(start_folder(studio)).is_dir()
    studio.settings.recent.append(str(own / "cliff.vom"))
    assert start_folder(studio) == str(own)
