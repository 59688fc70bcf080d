"""What is opened of the files that are dragged onto the window."""

from __future__ import annotations

from pathlib import Path

import pytest
from PySide6.QtCore import QMimeData, QPointF, Qt, QUrl
from PySide6.QtGui import QDropEvent

from tests import driver
from vomstudio.ui.shell.drag_and_drop import dragged_files


def dropped(*urls: str) -> list[Path]:
    data = QMimeData()
    data.setUrls([QUrl(url) for url in urls])
    copy = Qt.DropAction.CopyAction
    return dragged_files(QDropEvent(QPointF(), copy, data, driver.LEFT, driver.NONE))


@pytest.mark.usefixtures("qapp")
def test_dropped_photos_open_their_folder_once() -> None:
    assert dropped("file:///wall/a.JPG", "file:///wall/b.jpeg", "file:///wall/c.png") == [
        Path("/wall")
    ]


@pytest.mark.usefixtures("qapp")
def test_dropped_textures_and_materials_open_only_their_model() -> None:
    files = [f"file:///cliff/cliff{suffix}" for suffix in (".mtl", ".obj", ".jpg", ".prj")]
    assert dropped(*files) == [Path("/cliff/cliff.obj")]
    assert dropped(*files, "file:///wall/a.jpg") == [Path("/cliff/cliff.obj"), Path("/wall")]


@pytest.mark.usefixtures("qapp")
def test_other_dropped_files_are_opened_and_web_links_are_ignored() -> None:
    files = ["file:///a/heights.tif", "file:///a/notes.pdf", "file:///a/cliff.vom"]
    assert [str(path) for path in dropped(*files, "https://example.org/a.obj")] == [
        url.removeprefix("file://") for url in files
    ]
