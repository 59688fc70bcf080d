"""A model made elsewhere, tilted and in a unit of its own, is levelled, turned and scaled by lines
on it, with the mouse, as far as these tell."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tests import driver
from vomstudio.core.options import given_options
from vomstudio.geometry.transform import apply
from vomstudio.project.kinds.known_line import KnownLine
from vomstudio.project.records import Model
from vomstudio.registration.register_options import RegisterOptions
from vomstudio.ui.panels.tools.control import ControlPanel

SCALE = 0.5
SEEN_FROM = (0.0, 5.0)


def turned(vector, degrees: float) -> np.ndarray:
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec(np.radians(degrees) * np.asarray(vector, float)).as_matrix()


TURN = turned([0.8, 0.6, 0.0], 9.0) @ turned([0.0, 0.0, 1.0], 25.0)
"""From World to the file, which holds World's metres two times."""


@pytest.fixture
def tilted(outcrop) -> Path:
    """The same outcrop tilted by 9 degrees, turned by 25, in units of half a metre."""
    lines = outcrop.read_text().splitlines()
    rows = [i for i, line in enumerate(lines) if line.startswith("v ")]
    world = np.array([[float(v) for v in lines[i].split()[1:4]] for i in rows])
    for i, (x, y, z) in zip(rows, to_file(world, world.mean(axis=0)).tolist(), strict=True):
        lines[i] = f"v {x:.6f} {y:.6f} {z:.6f}"
    path = outcrop.with_name("tilted.obj")
    path.write_text("\n".join([*lines, ""]))
    np.save(outcrop.with_name("world.npy"), world)
    return path


def to_file(world: np.ndarray, middle: np.ndarray) -> np.ndarray:
    return (world - middle) @ TURN.T / SCALE


def seen(window, points: np.ndarray) -> np.ndarray:
    """Those that a click finds, not at an edge, as the model stands: (n,) of bool."""
    model = driver.model(window)
    pixels, _ = window.viewport.project(apply(model.to_world, points))
    found = []
    for point, pixel in zip(points, pixels, strict=True):
        around = [] if not np.isfinite(pixel).all() else [(0, 0), (9, 0), (-9, 0), (0, 9), (0, -9)]
        hits = [window.viewport.pick(*np.round(pixel) + step) for step in around]
        there = bool(hits) and all(hit is not None for hit in hits)
        found.append(there and np.linalg.norm(hits[0].position - point) < 0.06)
    return np.array(found)


def click(window, points: np.ndarray) -> None:
    model = driver.model(window)
    for point in points:
        at = driver.pixel(window, apply(model.to_world, point[None])[0])
        driver.click(window.viewport, at)
    driver.pause()


def choose(panel: ControlPanel, kind: str) -> None:
    panel.click_box.setCurrentIndex(panel.click_box.findData(kind))
    panel.click_box.activated.emit(panel.click_box.currentIndex())


def type_value(panel: ControlPanel, text: str) -> None:
    """Into the field that is open after the second click."""
    editor = QApplication.focusWidget()
    assert editor is not None
    assert panel.lines.isAncestorOf(editor)
    QTest.keyClicks(editor, text)
    QTest.keyClick(editor, Qt.Key.Key_Return)
    driver.pause()


def level_pair(world: np.ndarray, usable: np.ndarray, toward: np.ndarray) -> tuple[int, int]:
    """Two points at one height, as far apart along a horizontal direction as there are."""
    rows = np.flatnonzero(usable)
    places = world[rows]
    steps = places[:, None] - places[None]
    apart = np.abs(steps @ toward)
    apart[np.linalg.norm(steps, axis=2) > 1.3 * apart] = 0.0
    apart[np.abs(places[:, None, 2] - places[None, :, 2]) > 0.004] = 0.0
    i, k = np.unravel_index(int(apart.argmax()), apart.shape)
    return int(rows[i]), int(rows[k])


@pytest.mark.full
def test_known_lines_register_a_model_as_far_as_they_determine_it(window, tilted) -> None:
    world = np.load(tilted.with_name("world.npy"))
    middle = world.mean(axis=0)
    file = to_file(world, middle)
    window.open_path(tilted)
    driver.wait(lambda: driver.dialog_of(window) is not None, "the frame dialog")
    driver.dialog_of(window).reject()
    driver.settled(window)
    studio = window.studio
    assert studio.session.of(Model)[0].frame.kind == "undeclared"
    window.actions_table.run("register_model")
    panel = driver.tool_panel(window, ControlPanel)
    driver.settled(window)
    driver.look_at(window, file, 25.0, 5.0)
    usable = seen(window, file)
    assert usable.sum() > 50

    # Two level lines, in different directions, level it.
    choose(panel, "level")
    assert studio.tool_name == "known_line"
    east = level_pair(world, usable, np.array([1.0, 0.0, 0.0]))
    north = level_pair(world, usable, np.array([0.0, 1.0, 0.0]))
    click(window, file[list(east)])
    assert not panel.placed.known.vertical, "one line leaves the tilt about itself"
    click(window, file[list(north)])
    # What judges takes no part: what is left over at it stands beside it.
    cross = level_pair(world, usable, np.array([0.6, 0.8, 0.0]))
    click(window, file[list(cross)])
    panel.lines.item(2, 0).setCheckState(Qt.CheckState.Unchecked)
    driver.pause()
    assert panel.lines.item(2, 5).text().endswith("°")
    assert abs(float(panel.lines.item(2, 5).text()[:-1])) < 2.0
    driver.key(window, Qt.Key.Key_Z, driver.CTRL)
    driver.key(window, Qt.Key.Key_Z, driver.CTRL)
    assert [line.kind for line in studio.session.of(KnownLine)] == ["level", "level"]
    assert panel.placed.known.vertical
    known = panel.placed.known
    assert (known.north, known.scale, known.position) == (False, False, False)
    driver.click(panel.register, panel.register.rect().center())
    driver.pause()
    model = studio.session.of(Model)[0]
    assert model.registration.method == "lines"
    assert model.frame.level
    assert not model.frame.has_north
    up = np.array(model.to_world)[:3, :3] @ TURN @ [0.0, 0.0, 1.0]
    tilt = np.degrees(np.arccos(up[2] / np.linalg.norm(up)))
    assert tilt < 1.5
    badge = window.findChild(type(window.statusBar()))
    assert badge is not None
    assert "level" in studio.frame_name()
    driver.keep_picture(window, "known_lines_level")

    # An azimuth and a length, whose values are typed where the cursor waits for them.
    driver.look_at(window, apply(model.to_world, file), 0.0, 5.0)
    usable = seen(window, file)
    choose(panel, "azimuth")
    first, second = level_pair(world, usable, np.array([1.0, 0.0, 0.0]))
    along = world[second] - world[first]
    azimuth = np.degrees(np.arctan2(along[0], along[1])) % 360.0
    click(window, file[[first, second]])
    assert panel.placed.known == panel.placed.known.__class__(False, True, False, False)
    type_value(panel, f"{azimuth:.2f}")
    assert panel.placed.known.north
    choose(panel, "length")
    click(window, file[[first, second]])
    type_value(panel, f"{np.linalg.norm(along):.3f}".replace(".", ","))
    assert panel.placed.known.scale
    driver.keep_picture(window, "known_lines_all")
    driver.click(panel.register, panel.register.rect().center())
    driver.pause()
    model = studio.session.of(Model)[0]
    assert model.frame.kind == "local"
    assert (model.frame.has_north, model.frame.has_metres) == (True, True)
    matrix = np.array(model.to_world)[:3, :3]
    scale = np.cbrt(np.linalg.det(matrix))
    assert scale == pytest.approx(SCALE, rel=0.01)
    left = matrix / scale @ TURN
    off = np.degrees(np.arccos(np.clip((np.trace(left) - 1.0) / 2.0, -1.0, 1.0)))
    assert off < 1.5
    driver.keep_picture(window, "known_lines_placed")

    # Every click and every value is a step.
    window.viewport.setFocus()
    driver.key(window, Qt.Key.Key_Z, driver.CTRL)
    assert studio.session.of(Model)[0].frame.level
    for _ in range(4):
        driver.key(window, Qt.Key.Key_Z, driver.CTRL)
    assert len(studio.session.of(KnownLine)) == 2
    driver.key(window, Qt.Key.Key_Z, driver.CTRL)
    assert studio.session.of(Model)[0].registration is None


@pytest.mark.full
def test_one_plumb_line_levels_a_model(window, tilted) -> None:
    from vomstudio.ui.panels.tools.control_command import add_known_lines

    world = np.load(tilted.with_name("world.npy"))
    file = to_file(world, world.mean(axis=0))
    window.open_path(tilted)
    driver.wait(lambda: driver.dialog_of(window) is not None, "the frame dialog")
    driver.dialog_of(window).reject()
    driver.settled(window)
    window.actions_table.run("register_model")
    panel = driver.tool_panel(window, ControlPanel)
    driver.settled(window)
    driver.look_at(window, file, 25.0, 5.0)
    rows = np.flatnonzero(seen(window, file))
    steps = world[rows][:, None] - world[rows][None]
    aside = np.linalg.norm(steps[..., :2], axis=2)
    # The longest pair of points one above the other, within a degree.
    height = np.where(aside <= 0.02 * np.abs(steps[..., 2]), steps[..., 2], 0.0)
    ends = rows[list(np.unravel_index(int(height.argmax()), height.shape))]
    choose(panel, "plumb")
    click(window, file[ends])
    (line,) = window.studio.session.of(KnownLine)
    assert (line.kind, line.value, line.is_complete) == ("plumb", None, True)
    assert panel.placed.known == panel.placed.known.__class__(False, True, False, False)
    assert float(panel.lines.item(0, 5).text().rstrip("°")) == pytest.approx(0.0, abs=0.01)
    assert given_options(add_known_lines(RegisterOptions(), [line])).keys() == {"plumb"}
    driver.click(panel.register, panel.register.rect().center())
    driver.pause()
    model = window.studio.session.of(Model)[0]
    assert model.frame.level
    up = np.array(model.to_world)[:3, :3] @ TURN @ [0.0, 0.0, 1.0]
    assert np.degrees(np.arccos(up[2] / np.linalg.norm(up))) < 3.0
    assert [group.kind for group in model.registration.observations] == ["plumb_lines"]


@pytest.mark.full
def test_first_click_can_be_undone_and_one_line_is_not_enough(window, tilted) -> None:
    world = np.load(tilted.with_name("world.npy"))
    file = to_file(world, world.mean(axis=0))
    window.open_path(tilted)
    driver.wait(lambda: driver.dialog_of(window) is not None, "the frame dialog")
    driver.dialog_of(window).reject()
    driver.settled(window)
    window.actions_table.run("known_line")
    panel = driver.tool_panel(window, ControlPanel)
    driver.look_at(window, file, 25.0, 5.0)
    point = file[np.flatnonzero(seen(window, file))[0]]
    click(window, point[None])
    assert window.studio.open_tool is not None
    driver.key(window, Qt.Key.Key_Escape)
    assert window.studio.open_tool is None
    assert not window.studio.session.of(KnownLine)
    assert not panel.register.isEnabled()
    assert panel.register.toolTip()
