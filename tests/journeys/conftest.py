"""A user's folders of their own, and the small outcrop with its known picks."""

from __future__ import annotations

import csv
import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from tests import driver
from tests.conftest import use_home
from tests.guards import has_failed
from tests.shared_window import SharedWindow
from vomstudio.core.paths import resource
from vomstudio.ui.base import theme
from vomstudio.ui.shell.main_window import MainWindow

SCREENS = [
    pytest.param((width, height, name), id=f"{width}x{height}-{name}")
    for width, height in ((1600, 1000), (1280, 720), (960, 540))
    for name in ("light", "dark")
]
"""Logical pixels and themes of windows; the last size is that of 1920 x 1080 at 200 %."""


def bare_outcrop(folder: Path) -> Path:
    """The small outcrop as it often comes: without a word on its frame."""
    folder.mkdir(parents=True, exist_ok=True)
    for file in resource("outcrop").iterdir():
        if file.suffix != ".prj":
            shutil.copy(file, folder)
    return folder / "outcrop.obj"


@pytest.fixture
def outcrop(tmp_path) -> Path:
    return bare_outcrop(tmp_path / "models")


def read_picks() -> dict[str, np.ndarray]:
    with resource("outcrop", "picks.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    return {
        name: np.array([[float(r[c]) for c in "xyz"] for r in rows if r["trace"] == name])
        for name in dict.fromkeys(r["trace"] for r in rows)
    }


@pytest.fixture(scope="session")
def picks() -> dict[str, np.ndarray]:
    """Points on the outcrop in World, by trace."""
    return read_picks()


@pytest.fixture(scope="session")
def truth() -> dict[str, tuple[float, float]]:
    """Dip direction and dip of each trace's plane."""
    with resource("outcrop", "truth.csv").open(newline="") as stream:
        rows = csv.DictReader(line for line in stream if not line.startswith("#"))
        return {r["trace"]: (float(r["dip_direction_deg"]), float(r["dip_deg"])) for r in rows}


@pytest.fixture
def photos(data_dir, tmp_path) -> Path:
    """Four photos of a wall, of a third of their size."""
    from PIL import Image

    folder = tmp_path / "the wall"
    folder.mkdir()
    for path in sorted((data_dir / "saint_martin").glob("*.JPG")):
        with Image.open(path) as image:
            small = image.resize((image.width * 2 // 5, image.height * 2 // 5))
            small.save(folder / path.name, quality=92, exif=image.getexif())
    return folder


# --- windows ---------------------------------------------------------------------------------
@pytest.fixture(scope="module")
def shared_window(tmp_path_factory: pytest.TempPathFactory, qapp) -> Iterator[SharedWindow]:
    """The window of this module, made for the first test that asks for `window`."""
    # In the folders of a new user it would first look for all fonts of the machine.
    import matplotlib.font_manager  # noqa: F401

    with pytest.MonkeyPatch.context() as patch:
        shared = SharedWindow(use_home(tmp_path_factory.mktemp("shared") / "user", patch))
        try:
            yield shared
        finally:
            left = shared.close()
    if left:
        pytest.fail("earlier tests leave behind:\n  " + "\n  ".join(left), pytrace=False)


@pytest.fixture
def window(request: pytest.FixtureRequest) -> Iterator[MainWindow]:
    """The window of this module, with an empty project and as a new user finds it; a window of its
    own for a test that uses `new_window` or `own_folders`."""
    if {"new_window", "own_folders"} & set(request.fixturenames):
        yield request.getfixturevalue("new_window")
        return
    shared = request.getfixturevalue("shared_window")
    yield shared.lend(request.node.nodeid)
    if has_failed(request.node):
        # The next test gets another one: who knows what state this one is in.
        shared.close(check=False)


@pytest.fixture
def screen(window: MainWindow, request: pytest.FixtureRequest) -> Iterator[str]:
    """A size and theme of `SCREENS` that the window takes; their name, for pictures."""
    width, height, name = request.param
    window.actions_table.run(f"theme_{name}")
    window.resize(width, height)
    driver.pause(100)
    assert (window.width(), window.height()) == (width, height)
    yield f"{width}-{name}"
    theme.use("system")


@pytest.fixture
def own_folders(own_folders: Path, shared_window: SharedWindow) -> Path:
    """The home folder of a user who has just come, without any window."""
    if left := shared_window.close():
        pytest.fail("earlier tests leave behind:\n  " + "\n  ".join(left), pytrace=False)
    return own_folders


@pytest.fixture
def new_window(own_folders: Path, qtbot) -> Iterator[MainWindow]:
    """A window of its own, for tests whose subject is start, end, settings or recovery."""
    made = driver.make_window()
    yield made
    driver.dismiss(made)
