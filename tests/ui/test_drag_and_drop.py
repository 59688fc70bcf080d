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
def test_photos_are_opened_once_by_their_folder() -> None:
    assert dropped("file:///wall/a.JPG", "file:///wall/b.jpeg", "file:///wall/c.png") == [
        Path("/wall")
    ]


@pytest.mark.usefixtures("qapp")
def test_textures_and_materials_come_with_their_model() -> None:
    files = [f"file:///cliff/cliff{suffix}" for suffix in (".mtl", ".obj", ".jpg", ".prj")]
    assert dropped(*files) == [Path("/cliff/cliff.obj")]
    assert dropped(*files, "file:///wall/a.jpg") == [Path("/cliff/cliff.obj"), Path("/wall")]


@pytest.mark.usefixtures("qapp")
def test_other_files_are_opened_as_they_are_and_pages_of_the_web_are_not() -> None:
    files = ["file:///a/heights.tif", "file:///a/notes.pdf", "file:///a/cliff.vom"]
    assert [str(path) for path in dropped(*files, "https://example.org/a.obj")] == [
        url.removeprefix("file://") for url in files
    ]
