"""Lines drawn in another program on an orthophoto of the window come back as traces."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import rasterio
import rasterio.transform
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractButton, QFileDialog, QMessageBox

from tests import driver
from tests.journeys.conftest import SCREENS
from tests.messages import shown_codes, shown_values
from vomstudio.geology.orientation import planes_to_normals
from vomstudio.ui.dialogs.orthophoto_dialog import OrthoDialog

pytestmark = pytest.mark.full

GSD = 0.01


@pytest.fixture
def picture(window, outcrop, tmp_path) -> Path:
    """The sidecar of an orthophoto that was made in the window, looking north."""
    driver.open_outcrop(window, outcrop)
    window.view.look_along(0.0, 10.0)
    driver.wait(lambda: window.viewport.is_still, "the camera's rest")
    window.actions_table.all["orthophoto"].trigger()
    driver.wait(lambda: window.findChild(OrthoDialog) is not None, "the dialog")
    dialog = window.findChild(OrthoDialog)
    assert window.screen().availableGeometry().contains(dialog.frameGeometry())
    driver.wait(dialog._start_button.isEnabled, "a proposed pixel size")
    folder = tmp_path / "pictures"
    folder.mkdir()
    for field, text in ((dialog.gsd, str(GSD)), (dialog.target, str(folder / "cliff.tif"))):
        field.setFocus()
        field.selectAll()
        QTest.keyClicks(field, text)
    QTest.mouseClick(dialog._start_button, Qt.MouseButton.LeftButton)
    driver.wait((folder / "cliff.json").exists, "the orthophoto", 60.0)
    driver.wait(lambda: not window.studio.jobs.visible(), "the end of the job")
    return folder / "cliff.json"


def draw(
    path: Path, sidecar: Path, lines: dict[str, np.ndarray], ids: dict[str, str] | None = None
) -> Path:
    """As a GIS writes what is digitised on the GeoTIFF. lines : (n, 3) World; both by name"""
    facts = json.loads(sidecar.read_text("utf-8"))
    to_pixel = np.linalg.inv(np.array(facts["pixel_to_world"]))
    with rasterio.open(sidecar.with_suffix(".tif")) as file:
        to_plane = file.transform
    features = []
    for name, points in lines.items():
        pixels = (np.column_stack([points, np.ones(len(points))]) @ to_pixel.T)[:, :2]
        drawn = [rasterio.transform.xy(to_plane, r, c, offset="ul") for c, r in pixels]
        features.append(
            {
                "type": "Feature",
                "properties": {"name": name, "id": (ids or {}).get(name, "")},
                "geometry": {"type": "LineString", "coordinates": drawn},
            }
        )
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}), "utf-8")
    return path


def take_in(window, monkeypatch, *files: Path) -> None:
    """Files in the order in which they are asked for."""
    asked = iter(files)
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_: (str(next(asked)), ""))
    window.actions_table.run("import_drawing")


def buttons(window, text: str) -> list[QAbstractButton]:
    found = window.message_bar.findChildren(QAbstractButton)
    return [each for each in found if each.isVisible() and text in each.text().replace("&", "")]


def said(window) -> str:
    return window.message_bar._text.text()


@pytest.mark.parametrize(
    ("screen", "beside"),
    [pytest.param(*each.values, each is not SCREENS[0], id=each.id) for each in SCREENS],
    indirect=["screen"],
)
def test_gis_lines_become_traces_in_one_undo_step(
    window, screen, picture, picks, truth, tmp_path, monkeypatch, beside
) -> None:
    drawn = {name: picks[name] for name in ("B01", "B02")}
    folder = picture.parent if beside else tmp_path
    path = draw(folder / "lines.geojson", picture, drawn)
    before = dict(window.studio.records)
    take_in(window, monkeypatch, path, picture)
    driver.wait(lambda: len(driver.traces(window)) == 2, "the traces")
    for trace in driver.traces(window):
        points = np.array(trace.vertices)
        # A pixel, and what the surface does between where a pick lies and its pixel.
        assert np.linalg.norm(points - picks[trace.name], axis=1).max() < 3 * GSD
        plane = window.studio.measured([trace.id])[trace.id].plane
        is_, wanted = planes_to_normals(
            [plane.dip_direction_deg, truth[trace.name][0]], [plane.dip_deg, truth[trace.name][1]]
        )
        assert np.degrees(np.arccos(abs(float(is_ @ wanted)))) < 2.0
        assert "cliff" in trace.notes
    driver.keep_picture(window, f"orthophoto-back-{screen}")
    assert set(window.studio.selection.ids) == {t.id for t in driver.traces(window)}
    driver.focus(window)
    driver.key(window, Qt.Key.Key_Z, driver.CTRL)
    assert dict(window.studio.records) == before
    assert window.actions_table.all["import_drawing"].isEnabled()


def test_lines_unusable_as_traces_are_skipped_and_reported(
    window, picture, picks, monkeypatch
) -> None:
    drawn = {"B01": picks["B01"], "short": picks["B02"][:2], "": picks["B03"]}
    path = draw(picture.parent / "lines.geojson", picture, drawn)
    take_in(window, monkeypatch, path)
    driver.wait(lambda: len(driver.traces(window)) == 2, "the traces")
    assert shown_values(said(window), "feature.left-out")["feature"].endswith("short")
    # A line without a name is named as one that was picked.
    assert {t.name for t in driver.traces(window)} == {"B01", "B02"}


def test_drawing_on_another_image_is_rejected(window, picture, picks, monkeypatch) -> None:
    far = {"B01": picks["B01"] + [500.0, 0.0, 0.0]}
    path = draw(picture.parent / "lines.geojson", picture, far)
    take_in(window, monkeypatch, path, picture)
    driver.wait(lambda: "drawing.other-picture" in shown_codes(said(window)), "the refusal")
    assert "--sidecar" not in said(window)
    assert driver.traces(window) == []
    assert window.actions_table.all["import_drawing"].isEnabled()


def test_drawing_import_is_a_job_that_can_be_cancelled(window, picture, picks, monkeypatch) -> None:
    long = {"B01": np.repeat(picks["B01"], 20_000, axis=0)}
    path = draw(picture.parent / "lines.geojson", picture, long)
    before = dict(window.studio.records)
    take_in(window, monkeypatch, path)
    (job,) = window.studio.jobs.visible()
    assert "lines.geojson" in job.title
    window.studio.jobs.cancel(job)
    driver.wait(lambda: not window.studio.jobs.visible(), "the end of the job")
    assert dict(window.studio.records) == before
    assert window.actions_table.all["import_drawing"].isEnabled()


def test_import_asks_which_of_two_images_in_a_folder_was_used(
    window, picture, picks, monkeypatch
) -> None:
    other = picture.with_name("other.json")
    other.write_bytes(picture.read_bytes())
    path = draw(picture.parent / "lines.geojson", picture, {"B01": picks["B01"]})
    take_in(window, monkeypatch, path, other)
    driver.wait(lambda: len(driver.traces(window)) == 1, "the trace")
    assert "other" in driver.traces(window)[0].notes


def test_edited_traces_are_updated_by_the_button_beside_the_message(
    window, picture, picks, monkeypatch
) -> None:
    names = ("B01", "B02")
    path = draw(picture.parent / "lines.geojson", picture, {name: picks[name] for name in names})
    take_in(window, monkeypatch, path)
    driver.wait(lambda: len(driver.traces(window)) == 2, "the traces")
    ids = {trace.name: trace.id for trace in driver.traces(window)}
    before = {trace.id: np.array(trace.vertices) for trace in driver.traces(window)}
    placed = {name: before[ids[name]] for name in names}
    lines = {"B01": placed["B01"], "B02": placed["B02"] + [0.0, 0.0, 0.2]}
    draw(path, picture, lines, ids)
    take_in(window, monkeypatch, path)
    driver.wait(lambda: buttons(window, "Update"), "the offer to update")
    (button,) = buttons(window, "Update")
    assert shown_codes(said(window)) == {"drawing.edited"}
    before_it = window.messages.item(window.messages.count() - 2).text()
    assert "drawing.unchanged" in shown_codes(before_it)
    assert len(driver.traces(window)) == 2
    button.click()
    driver.wait(lambda: window.studio.selection.ids == (ids["B02"],), "the update")
    after = {trace.id: np.array(trace.vertices) for trace in driver.traces(window)}
    assert np.array_equal(after[ids["B01"]], before[ids["B01"]])
    raised = after[ids["B02"]].mean(axis=0) - before[ids["B02"]].mean(axis=0)
    assert raised[2] == pytest.approx(0.2, abs=0.1)
    driver.focus(window)
    driver.key(window, Qt.Key.Key_Z, driver.CTRL)
    assert np.array_equal(np.array(driver.traces(window)[1].vertices), before[ids["B02"]])


def test_edited_traces_of_another_project_are_not_offered(
    window, picture, picks, monkeypatch, tmp_path
) -> None:
    path = draw(picture.parent / "lines.geojson", picture, {"B01": picks["B01"]})
    take_in(window, monkeypatch, path)
    driver.wait(lambda: len(driver.traces(window)) == 1, "the trace")
    (trace,) = driver.traces(window)
    moved = np.array(trace.vertices) + [0.0, 0.0, 0.2]
    draw(path, picture, {"B01": moved}, {"B01": trace.id})
    take_in(window, monkeypatch, path)
    update = window.actions_table.all["update_drawn_traces"]
    driver.wait(update.isEnabled, "the offer to update")
    driver.answer(QMessageBox.StandardButton.Discard, [])
    window.actions_table.run("new")
    driver.wait(lambda: not driver.traces(window), "the new project")
    driver.wait(lambda: not update.isEnabled(), "the end of the offer")
