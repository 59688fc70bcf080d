"""A window without its viewport: panels, actions and dialogs need no OpenGL and no worker."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest
from PySide6.QtWidgets import QApplication

from tests import driver
from tests.samples import ZIGZAG
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.streaming.surfaces import create_surface
from vomstudio.io.settings import read_settings
from vomstudio.project import edits
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.records import Model
from vomstudio.ui.shell.main_window import MainWindow


@pytest.fixture
def window(own_folders, qtbot) -> Iterator[MainWindow]:
    made = MainWindow(read_settings()[0])
    made.show()
    made._fill()
    made.studio.jobs.close()
    made.activateWindow()
    qtbot.waitUntil(lambda: QApplication.activeWindow() is made)
    yield made
    driver.dismiss(made)


@pytest.fixture
def studio(window):
    return window.studio


def cliff(frame: Frame | None = None) -> Model:
    frame = frame or Frame("local")
    return Model("m1", "cliff", "cliff.obj", "mesh", "0" * 64, frame)


def add_cliff(studio, frame: Frame | None = None) -> None:
    assert studio.attempt(edits.add_model, cliff(frame))
    studio.notices = []
    studio.notice.connect(studio.notices.append)


def add_open_cliff(studio, mesh) -> None:
    """A model with a surface to paint and click on, and all that is said."""
    add_cliff(studio)
    studio.models["m1"] = SimpleNamespace(surface=create_surface(mesh), data=mesh, resolution=None)
    studio.models["m1"].surface.build()


def add_bed(studio, id_="t1", name="", dip=0.5, vertices=None, **more) -> Trace:
    """A bed that dips to the west, the steeper the larger `dip`."""
    points = vertices or tuple((x, y, dip * x + (z - 0.5 * x)) for x, y, z in ZIGZAG)
    trace = Trace(id_, name, more.pop("type_id", "bedding"), "m1", "0" * 64, points, **more)
    assert studio.attempt(edits.add_trace, trace)
    return studio.records[id_]


def save_beds(studio, path: Path, count: int) -> Path:
    """A project with so many beds on a cliff is saved there, and a new one is open."""
    add_cliff(studio)
    for i in range(count):
        add_bed(studio, f"b{i}", dip=0.1 * i)
    studio.save_as(path)
    studio.workspace.projects.new()
    return path
