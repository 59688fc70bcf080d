"""Every file that can be read is seen in the dialog that asks for it."""

from __future__ import annotations

from fnmatch import fnmatchcase
from pathlib import Path

import pytest
from PySide6.QtWidgets import QFileDialog, QWidget

from tests.tiers import first_in_default_tier
from tests.ui.conftest import add_cliff
from vomstudio.io.control.registry import find_formats
from vomstudio.io.models.registry import find_readers
from vomstudio.io.photos.mask_files import MASK_SUFFIXES
from vomstudio.ui.base import file_filters


def patterns(text: str) -> list[str]:
    """Of the first entry, as Qt takes them out of its brackets."""
    return text.split(";;")[0].rsplit("(", 1)[1].rstrip(")").split()


def shows(text: str, name: str) -> bool:
    return any(fnmatchcase(name, pattern) for pattern in patterns(text))


def test_model_filter_includes_every_reader_in_lower_and_upper_case():
    readers = find_readers().all
    assert len(readers) >= 8
    for reader in readers:
        for ending in reader.extensions:
            assert shows(file_filters.models(), f"outcrop{ending}"), ending
            assert shows(file_filters.models(), f"OUTCROP{ending.upper()}"), ending


def test_ground_control_filter_includes_every_format():
    for format_ in find_formats().all:
        assert format_.extensions, format_.name
        for ending in format_.extensions:
            assert shows(file_filters.ground_control(), f"points{ending}")
        for name in format_.default_names:
            assert shows(file_filters.ground_control(), name)


def test_photo_video_and_table_filters_include_common_files():
    assert all(shows(file_filters.photos(), f"IMG_1{e}") for e in MASK_SUFFIXES)
    for name in ("DJI_0001.MP4", "GOPR1.mp4", "clip.MTS", "scan.mov", "IMG_2.MOV", "VID.3gp"):
        assert shows(file_filters.videos(), name)
    for name in ("readings.csv", "READINGS.CSV", "book.txt", "a.tsv", "a.dat"):
        assert shows(file_filters.tables(), name)


@pytest.mark.parametrize(
    ("action", "offered"),
    first_in_default_tier(
        [
            ("open", file_filters.models),
            ("locate", file_filters.models),
            ("import_readings", file_filters.tables),
        ]
    ),
)
def test_window_dialogs_use_these_filters(window, studio, monkeypatch, action, offered):
    """Qt's own dialog is not opened: what it is given is looked at."""
    add_cliff(studio)
    given: list[str] = []

    def asked(parent: QWidget, title: str, folder: str, filters: str = "") -> tuple[object, str]:
        assert Path(folder).is_dir() or not folder
        given.append(filters)
        return ([] if action == "open" else ""), ""

    monkeypatch.setattr(QFileDialog, "getOpenFileName", asked)
    monkeypatch.setattr(QFileDialog, "getOpenFileNames", asked)
    if action == "locate":
        window.files.locate_model()
    else:
        window.actions_table.run(action)
    assert given == [offered()]
