"""A model is fitted to another one: points clicked in both, then the surfaces, as one edit."""

from __future__ import annotations

import json
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QFileDialog
from scipy.spatial.transform import Rotation

from tests import driver
from tests.messages import shown_codes, shown_values
from vomstudio.cli.common.entry import main
from vomstudio.geometry import transform
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.registrations import Registration
from vomstudio.io.models.opening import read_model
from vomstudio.io.models.writing import write_model
from vomstudio.project import edits
from vomstudio.project.records import Model
from vomstudio.ui.dialogs.model_fit.fit_dialog import FitDialog
from vomstudio.ui.dialogs.model_fit.picking_view import PickingView

TURN = Rotation.from_rotvec(np.radians([2.0, -1.0, 25.0])).as_matrix()
SHIFT = np.array([3.0, -2.0, 0.7])
MIDDLE = np.array([372410.0, 4709820.0, 610.0])
"""Of the outcrop."""


def moved_places(places: np.ndarray) -> np.ndarray:
    """(n, 3) of the outcrop in the frame of the other model."""
    return (places - MIDDLE) @ TURN.T + MIDDLE + SHIFT


@pytest.fixture
def moved(outcrop, tmp_path) -> Path:
    """The same outcrop, turned and shifted, as another program may have written it."""
    mesh = read_model(outcrop).data
    there = moved_places(mesh.vertices)
    path = tmp_path / "lidar.ply"
    write_model(replace(mesh, vertices=there), None, path)
    return path


def dialog_of(window, moved: Path) -> FitDialog:
    window.actions_table.run("fit_model")
    driver.wait(lambda: window.findChildren(FitDialog), "the dialog")
    (dialog,) = window.findChildren(FitDialog)
    assert not dialog.fit_button.isEnabled()
    assert shown_codes(dialog.fit_button.toolTip()) == {"action.no-other-model"}
    dialog.other.load_file(moved)
    driver.wait(lambda: dialog.reference is not None, "the reference")
    for view in (dialog.model_view, dialog.reference_view):
        driver.wait(
            lambda v=view: "pickable" in v.models.reached_stages("shown"), "a model to click on"
        )
        driver.wait(lambda v=view: v.is_still, "its picture")
    return dialog


def click(view: PickingView, place: np.ndarray) -> None:
    """Where a place of the model's file is seen."""
    matrix = transform.matrix(view.model.to_world)
    pixels, _ = view.camera.project(transform.apply(matrix, place[None]), view.extent())
    x, y = pixels[0].round().astype(int).tolist()
    driver.click(view, view.rect().topLeft() + type(view.rect().topLeft())(x, y))
    driver.pause(30)


def seen(view: PickingView, places: np.ndarray) -> np.ndarray:
    """Those that can be clicked."""
    matrix = transform.matrix(view.model.to_world)
    pixels, _ = view.camera.project(transform.apply(matrix, places), view.extent())
    hits = [view.pick(x, y) for x, y in pixels.tolist()]
    return np.array(
        [
            h is not None and np.linalg.norm(p - h.position) < 0.1
            for p, h in zip(places, hits, strict=True)
        ]
    )


@pytest.mark.full
def test_model_is_fitted_by_points_and_then_by_surfaces(
    window, outcrop, moved, picks, tmp_path, monkeypatch, capfd
) -> None:
    driver.open_outcrop(window, outcrop)
    studio = window.studio
    dialog = dialog_of(window, moved)
    places = np.concatenate(list(picks.values()))
    there = moved_places(places)
    good = seen(dialog.model_view, places) & seen(dialog.reference_view, there)
    places, there = places[good], there[good]
    chosen = [
        int(places[:, 0].argmin()),
        int(places[:, 0].argmax()),
        int(places[:, 2].argmax()),
        int(places[:, 2].argmin()),
    ]
    for i in chosen[:2]:
        click(dialog.model_view, places[i])
        assert "fit.click-right" in shown_codes(dialog.instruction.text())
        click(dialog.reference_view, there[i])
    assert shown_values(dialog.instruction.text(), "fit.click-pairs") == {"minimum": "3"}
    assert len(dialog.points.pairs) == 2
    # In either order, and a second click on the same side corrects the first.
    click(dialog.reference_view, there[chosen[0]])
    click(dialog.reference_view, there[chosen[2]])
    click(dialog.model_view, places[chosen[2]])
    assert len(dialog.points.pairs) == 3
    assert dialog.placement is not None
    assert dialog.table.item(2, 1).text()
    # What was clicked wrongly is taken back, or out.
    click(dialog.model_view, places[chosen[3]])
    click(dialog.reference_view, there[chosen[0]])
    assert dialog.placement.rms_control_m > 0.1
    driver.keep_picture(dialog, "fit-wrong-point")
    dialog.table.selectRow(3)
    driver.click(dialog.remove_button, dialog.remove_button.rect().center())
    assert len(dialog.points.pairs) == 3
    assert dialog.placement.rms_control_m < 0.1
    dialog.activateWindow()
    driver.wait(dialog.isActiveWindow, "the keyboard", 5.0)
    QTest.keyClick(dialog, Qt.Key.Key_Z, driver.CTRL)
    assert len(dialog.points.pairs) == 4
    driver.click(dialog.redo_button, dialog.redo_button.rect().center())
    assert len(dialog.points.pairs) == 3

    assert not dialog.register_button.isEnabled()
    driver.click(dialog.fit_button, dialog.fit_button.rect().center())
    assert dialog.fit_button.text() == "Stop"
    driver.wait(lambda: dialog.fit_result is not None, "the fit", 60.0)
    driver.keep_picture(dialog, "fit-done")
    pairs = tmp_path / "pairs.csv"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(pairs), ""))
    driver.click(dialog.copy_button, dialog.copy_button.rect().center())
    program, *arguments = shlex.split(QGuiApplication.clipboard().text())
    assert program == "vomstudio"
    capfd.readouterr()
    assert main([*arguments, "--json"]) == 0
    told = np.array(json.loads(capfd.readouterr().out)["matrix"])
    shown = np.array(dialog.fit_result.placed.matrix)
    far = np.abs(transform.apply(told, places) - transform.apply(shown, places)).max()
    # The file states no unit, which was declared in the window: the command finds the scale too.
    assert far < 0.03
    dialog.stable.part_box.setCurrentIndex(1)
    dialog.stable.changed.emit()
    assert shown_codes(dialog.copy_button.toolTip()) == {"action.stable-part-without-file"}
    dialog.stable.part_box.setCurrentIndex(0)
    dialog.stable.changed.emit()
    driver.click(dialog.fit_button, dialog.fit_button.rect().center())
    driver.wait(lambda: dialog.fit_result is not None, "the fit again", 60.0)
    said = dialog.message.text()
    assert "reference.fitted" in shown_codes(said)
    assert "95 %" in said
    before = studio.session.of(Model)[0]
    driver.click(dialog.register_button, dialog.register_button.rect().center())
    (model,) = studio.session.of(Model)
    registration = model.registration
    assert registration is not None
    assert registration.method == "reference"
    assert len(registration.control) == 3
    found = np.array(model.to_world)
    off = Rotation.from_matrix(found[:3, :3] @ TURN.T).magnitude()
    # Three clicks alone are some tenths of a degree off.
    assert np.degrees(off) < 0.05
    middle = places.mean(axis=0)
    placed = transform.apply(found, middle[None])
    assert np.linalg.norm(placed - moved_places(middle[None])) < 0.01
    driver.focus(window)
    driver.key(window, Qt.Key.Key_Z, driver.CTRL)
    assert studio.session.of(Model)[0] == before


@pytest.mark.full
def test_fit_can_be_stopped_and_closing_the_dialog_frees_its_views(window, outcrop, moved) -> None:
    driver.open_outcrop(window, outcrop)
    dialog = dialog_of(window, moved)
    views = (dialog.model_view, dialog.reference_view)
    # Nothing clicked: the two stand 4 m and 25 degrees apart.
    dialog.stable.part_box.setCurrentIndex(1)
    dialog.stable.part_box.activated.emit(1)
    assert "stable.no-points" in shown_codes(dialog.fit_button.toolTip())
    dialog.stable.part_box.setCurrentIndex(0)
    dialog.stable.part_box.activated.emit(0)
    driver.click(dialog.fit_button, dialog.fit_button.rect().center())
    driver.click(dialog.fit_button, dialog.fit_button.rect().center())
    driver.wait(lambda: dialog.fit_button.text() != "Stop", "its end", 60.0)
    assert dialog.fit_result is None
    assert shown_codes(dialog.message.text()) == {"job.stopped"}
    dialog.close()
    assert all(view.scene is None for view in views)
    driver.wait(lambda: not window.findChildren(FitDialog), "the end of the dialog")


@pytest.mark.full
def test_model_without_declared_frame_cannot_be_the_reference(window, outcrop, moved) -> None:
    driver.open_outcrop(window, outcrop)
    studio = window.studio
    own = driver.model(window)
    studio.open_model(moved)
    driver.wait(lambda: len(studio.models) == 2, "the other model")
    (lidar,) = (m for m in studio.session.of(Model) if m.id != own.id)
    assert studio.attempt(edits.declare_frame, lidar.id, Frame())
    studio.selection.set([own.id])
    window.actions_table.run("fit_model")
    driver.wait(lambda: window.findChildren(FitDialog), "the dialog")
    (dialog,) = window.findChildren(FitDialog)
    assert dialog.other.models.currentText() == "lidar"
    assert dialog.reference is None
    undeclared = "registration.reference-undeclared"
    assert shown_values(dialog.message.text(), undeclared) == {"model": "lidar"}
    assert not dialog.fit_button.isEnabled()
    dialog.close()
    driver.wait(lambda: not window.findChildren(FitDialog), "the end of the dialog")
    # The other way round it is placed by the one that is declared.
    studio.selection.set([lidar.id])
    window.actions_table.run("fit_model")
    driver.wait(lambda: window.findChildren(FitDialog), "the dialog")
    (dialog,) = window.findChildren(FitDialog)
    assert dialog.reference is not None
    assert dialog.reference.id == own.id
    assert dialog.fit_button.isEnabled()
    # It may go meanwhile.
    assert studio.attempt(edits.remove_model, own.id)
    assert dialog.reference is None
    assert not dialog.fit_button.isEnabled()
    dialog.close()


@pytest.mark.full
def test_error_of_the_reference_is_propagated(window, outcrop, tmp_path) -> None:
    """A reference that may be tilted by a degree tilts what is fitted to it."""
    driver.open_outcrop(window, outcrop)
    studio, rng = window.studio, np.random.default_rng(2)
    reference = driver.model(window)
    sigma = np.radians([0.5, 0.4, 0.3])
    spread = np.diag([*sigma**2, 1e-8, 1e-4, 1e-4, 1e-4])
    placed = Registration(
        "r1",
        "surveyed",
        "points",
        reference.frame,
        reference.to_world,
        rotation_error_deg=(0.3, 0.5, 0.4),
        scale_error=1e-4,
        covariance=tuple(map(tuple, spread.tolist())),
        centre=tuple(MIDDLE.tolist()),
    )
    assert studio.attempt(edits.set_registration, placed, [reference.id])
    mesh = read_model(outcrop).data
    turn = Rotation.from_rotvec(np.radians([0.3, 0.2, -0.4])).as_matrix()
    near = (mesh.vertices - MIDDLE) @ turn.T + MIDDLE + [0.05, -0.04, 0.03]
    near += rng.normal(0.0, 0.002, near.shape)
    path = tmp_path / "other.ply"
    write_model(replace(mesh, vertices=near), None, path)
    studio.open_model(path, reference_id=reference.id)
    driver.wait(lambda: len(studio.models) == 2, "the other model")
    (other,) = (m for m in studio.session.of(Model) if m.id != reference.id)
    studio.selection.set([other.id])
    window.actions_table.run("fit_model")
    driver.wait(lambda: window.findChildren(FitDialog), "the dialog")
    (dialog,) = window.findChildren(FitDialog)
    assert dialog.fit_button.isEnabled()
    # A smooth wall can slide; points that are seen in both hold it.
    step = len(near) // 5
    for own, there in zip(near[::step], mesh.vertices[::step], strict=True):
        dialog.model_view.picked.emit(own)
        dialog.reference_view.picked.emit(there + rng.normal(0.0, 0.002, 3))
    driver.click(dialog.fit_button, dialog.fit_button.rect().center())
    driver.wait(lambda: dialog.fit_button.text() != "Stop", "its end", 60.0)
    assert dialog.fit_result is not None
    # 1.96 times half a degree, about east.
    said = shown_values(dialog.message.text(), "registration.with-reference")
    assert said == {"rotation95_deg": "0.98"}
    driver.click(dialog.register_button, dialog.register_button.rect().center())
    made = studio.records[other.id].registration
    assert made.method == "reference"
    assert made.rotation_error_deg == pytest.approx((0.3, 0.5, 0.4), abs=0.01)
    # What is measured on it carries that.
    turned = np.array(made.to_world())[:3, :3]
    assert np.degrees(Rotation.from_matrix(turned @ turn).magnitude()) < 0.05


@pytest.mark.full
def test_cloud_of_stable_surface_is_used_as_mask(window, outcrop, tmp_path) -> None:
    """Half of the reference has slid since: near a cloud of the other half the fit is right, by all
    of the reference it is not."""
    driver.open_outcrop(window, outcrop)
    mesh = read_model(outcrop).data
    there = moved_places(mesh.vertices)
    slid = mesh.vertices[:, 0] > np.median(mesh.vertices[:, 0])
    gone = there.copy()
    gone[slid] += [0.25, -0.6, -0.45]
    reference = tmp_path / "after.ply"
    write_model(replace(mesh, vertices=gone), None, reference)
    # Of the stable half, denser than its vertices.
    corners = there[mesh.faces[~slid[mesh.faces].any(axis=1)]]
    shares = np.random.default_rng(1).dirichlet([1.0, 1.0, 1.0], (len(corners), 12))
    cloud = np.einsum("fkc,fcx->fkx", shares, corners).reshape(-1, 3)
    mask = tmp_path / "stable.xyz"
    mask.write_text("\n".join(f"{x:.4f} {y:.4f} {z:.4f}" for x, y, z in cloud.tolist()) + "\n")

    dialog = dialog_of(window, reference)
    rng = np.random.default_rng(2)
    rows = np.flatnonzero(~slid)
    for i in rng.choice(rows, 9, replace=False):
        dialog.model_view.picked.emit(mesh.vertices[i])
        dialog.reference_view.picked.emit(there[i] + rng.normal(0.0, 0.05, 3))

    def turned() -> float:
        driver.click(dialog.fit_button, dialog.fit_button.rect().center())
        driver.wait(lambda: dialog.fit_button.text() != "Stop", "its end", 60.0)
        assert dialog.fit_result is not None, dialog.message.text()
        placed = dialog.fit_result.placed
        return float(
            np.degrees(
                Rotation.from_matrix(placed.matrix[:3, :3] / placed.scale @ TURN.T).magnitude()
            )
        )

    by_all = turned()
    which = dialog.stable.part_box
    which.setCurrentIndex(which.count() - 1)
    which.activated.emit(which.count() - 1)
    assert not dialog.fit_button.isEnabled()
    assert "stable.no-model" in shown_codes(dialog.fit_button.toolTip())
    dialog.stable.stable_model.load_file(mask)
    driver.wait(dialog.fit_button.isEnabled, "the mask")
    driver.keep_picture(dialog, "fit-stable-cloud")
    by_stable = turned()
    driver.keep_picture(dialog, "fit-stable-done")
    assert by_stable < 0.1
    assert by_stable < 0.3 * by_all
    driver.click(dialog.register_button, dialog.register_button.rect().center())
    assert driver.model(window).registration.method == "reference"
