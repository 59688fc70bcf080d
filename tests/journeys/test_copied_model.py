"""A model that is copied into the project brings its photos' cameras, wherever the folder goes."""

from __future__ import annotations

import shutil

import pytest
from PySide6.QtWidgets import QMessageBox

from tests import driver
from tests.driver import wait
from tests.journeys.test_in_photos import TRUE, sample  # noqa: F401
from tests.messages import figures
from vomstudio.io.photos.cameras_file import write_cameras
from vomstudio.project.records import Model

pytestmark = pytest.mark.full

Button = QMessageBox.StandardButton


@pytest.fixture
def saved(window, sample, tmp_path):  # noqa: F811
    """A project with a name whose model lies elsewhere, with its photos in a folder beside it."""
    from dataclasses import replace

    photos = tmp_path / "field" / "photos"
    shutil.copytree(TRUE.photos, photos)
    write_cameras(sample.with_name("cameras.json"), replace(TRUE, photos=photos), force=True)
    window.open_path(sample)
    driver.settled(window)
    window.studio.save_as(tmp_path / "cliff.vom")
    return tmp_path / "cliff.vom"


def copy(window, answer: QMessageBox.StandardButton) -> list[str]:
    seen: list[str] = []
    driver.answer(answer, seen)
    window.actions_table.run("copy_model")
    return seen


def in_the_project(window) -> bool:
    (model,) = window.studio.session.of(Model)
    return model.path.startswith("models/")


def photos_of_the_model(window):
    (model,) = window.studio.session.of(Model)
    window.actions_table.run("show_in_photos")
    wait(lambda: window.photo_links.of(model.id) is not None, "the cameras", 60.0)
    return window.photo_links.of(model.id)


def test_copied_model_is_shown_in_its_photos_without_the_original(window, saved, tmp_path) -> None:
    (model,) = window.studio.session.of(Model)
    question = copy(window, Button.No)[0]
    assert figures(question) == [12]
    assert model.name in question
    wait(lambda: in_the_project(window), "the copy", 60.0)
    shutil.rmtree(tmp_path / "models")
    found = photos_of_the_model(window)
    assert len(found.views.views) == 12
    assert found.path(0).parent == tmp_path / "field" / "photos"
    assert found.path(0).is_file()


def test_project_folder_with_copied_photos_can_be_moved(window, saved, tmp_path) -> None:
    copy(window, Button.Yes)
    wait(lambda: in_the_project(window), "the copy", 60.0)
    window.studio.save()
    window.studio.new_project()
    shutil.rmtree(tmp_path / "models")
    shutil.rmtree(tmp_path / "field")
    saved.rename(tmp_path / "moved.vom")
    window.studio.open_project(tmp_path / "moved.vom")
    driver.settled(window)
    found = photos_of_the_model(window)
    for view in range(12):
        path = found.path(view)
        assert path.is_file()
        assert path.is_relative_to(tmp_path / "moved.vom")
    wait(lambda: window.in_photos.names, "a list of photos", 60.0)
    driver.keep_picture(window, "copied-model")


def test_cancel_copies_nothing(window, saved) -> None:
    copy(window, Button.Cancel)
    driver.pause(300)
    assert not in_the_project(window)
    assert not (saved / "models").exists()


def test_cameras_selected_elsewhere_are_copied_too(window, saved, tmp_path) -> None:
    (model,) = window.studio.session.of(Model)
    elsewhere = tmp_path / "other" / "poses.json"
    elsewhere.parent.mkdir()
    (tmp_path / "models" / "cameras.json").rename(elsewhere)
    window.photo_links.open_cameras(model.id, elsewhere)
    copy(window, Button.No)
    wait(lambda: in_the_project(window), "the copy", 60.0)
    shutil.rmtree(tmp_path / "other")
    (model,) = window.studio.session.of(Model)
    path = window.photo_links.cameras_path(model.id)
    assert path is not None
    assert path.is_relative_to(saved)
    assert len(photos_of_the_model(window).views.views) == 12
