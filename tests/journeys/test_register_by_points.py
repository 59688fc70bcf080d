"""A model that was made elsewhere is placed by ten control points that come in a table."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QImage
from PySide6.QtWidgets import QFileDialog

from tests import driver
from vomstudio.project.kinds.control_point import ControlPoint
from vomstudio.project.records import Model
from vomstudio.ui.panels.tools.control import ControlPanel

COUNT = 10
SEEN_FROM = (0.0, 5.0)


def spread(points: np.ndarray) -> np.ndarray:
    """As far from each other as they come."""
    chosen = [points[0]]
    while len(chosen) < COUNT:
        far = np.min([np.linalg.norm(points - c, axis=1) for c in chosen], axis=0)
        chosen.append(points[int(far.argmax())])
    return np.array(chosen)


def test_ten_control_points_from_a_table_register_the_model(
    window, outcrop, picks, tmp_path, monkeypatch
) -> None:
    driver.open_outcrop(window, outcrop)
    studio = window.studio
    every = np.concatenate(list(picks.values()))
    driver.look_at(window, every, *SEEN_FROM)
    # Of what is seen from here: what lies behind a nose of the rock cannot be clicked.
    inside = [p for p in every if _seen(window, p)]
    points = spread(np.array(inside))
    turn = np.radians(20.0)
    about_up = np.array(
        [[np.cos(turn), -np.sin(turn), 0.0], [np.sin(turn), np.cos(turn), 0.0], [0.0, 0.0, 1.0]]
    )
    world = (points - points.mean(axis=0)) @ about_up.T + [398_000.0, 4_980_000.0, 320.0]
    table = tmp_path / "gcp.csv"
    lines = [f"GCP{i},{x:.3f},{y:.3f},{z:.3f}" for i, (x, y, z) in enumerate(world.tolist(), 1)]
    table.write_text("\n".join(["label,x,y,z", *lines]))
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_: (str(table), ""))

    # Its name in the menu, and the menu.
    clicks = 2
    window.actions_table.run("register_model")
    panel = driver.tool_panel(window, ControlPanel)
    driver.settled(window)
    driver.click(panel.load, panel.load.rect().center())
    # With the file and Open in the dialog.
    clicks += 3
    driver.settled(window)
    driver.look_at(window, every, *SEEN_FROM)
    before = picture(window)
    for point in points:
        driver.click(window.viewport, driver.pixel(window, point))
        clicks += 1
    # Labels and dots, each drawn into the picture that is kept, and nothing else.
    driver.wait(lambda: window.viewport.is_still, "the picture")
    changed = np.abs(picture(window) - before).max(axis=2) > 40
    assert 0.001 < changed.mean() < 0.1
    found = studio.session.of(ControlPoint)
    assert [p.name for p in found] == [f"GCP{i}" for i in range(1, COUNT + 1)]
    assert all(p.vertices for p in found)
    panel.crs_field.setText("EPSG:32633")
    driver.click(panel.register, panel.register.rect().center())
    clicks += 1
    driver.pause()
    assert clicks < 40
    (model,) = studio.session.of(Model)
    registration = model.registration
    assert registration is not None
    assert model.frame.crs == "EPSG:32633"
    matrix = np.array(model.to_world)[:3, :3]
    scale = np.cbrt(np.linalg.det(matrix))
    assert scale == pytest.approx(1.0, abs=0.02)
    off = matrix @ about_up.T / scale
    turned = np.degrees(np.arccos(np.clip((np.trace(off) - 1.0) / 2.0, -1.0, 1.0)))
    # A pixel is some millimetres of rock.
    assert turned < 0.5
    window.viewport.setFocus()
    driver.key(window, Qt.Key.Key_Z, driver.CTRL)
    assert studio.session.of(Model)[0].registration is None


def picture(window) -> np.ndarray:
    """(height, width, 3) of the outcrop."""
    image = window.viewport.grab().toImage().convertToFormat(QImage.Format.Format_RGB888)
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1)
    return rows[:, : 3 * image.width()].reshape(image.height(), -1, 3).astype(int)


def _seen(window, point: np.ndarray) -> bool:
    try:
        at = driver.pixel(window, point)
    except AssertionError:
        return False
    hit = window.viewport.pick(at.x(), at.y())
    return hit is not None and np.linalg.norm(np.subtract(hit.position, point)) < 0.05
