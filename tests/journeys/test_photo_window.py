"""Masks drawn and points marked in photos, with real mouse and key events."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtTest import QTest

from tests import driver
from tests.driver import click, drag, move, wait
from tests.messages import figures, shown_codes, shown_values
from vomstudio.core.findings import Finding
from vomstudio.core.paths import resource
from vomstudio.geometry.pixel_areas import stroke_area
from vomstudio.io.control.control_files import read_control, read_marks
from vomstudio.io.photos.cameras_file import Cameras, write_cameras
from vomstudio.io.photos.reading import read_photos
from vomstudio.project.sample import read_true_cameras
from vomstudio.studio.jobs.reconstruction_tasks import ReconstructionRequest

TRUE = read_true_cameras()
NAMES = ("HL_2041.jpg", "HL_2042.jpg", "HL_2043.jpg", "HL_2044.jpg")


@pytest.fixture
def photos(tmp_path) -> Path:
    folder = tmp_path / "the face"
    folder.mkdir()
    for name in NAMES:
        shutil.copy(resource("sample", "photos", name), folder)
    return folder


@pytest.fixture
def looked_at(window, photos):
    """The window with the photos in their panel, read and not yet judged."""
    window.resize(1400, 900)
    window.open_path(photos)
    wait(lambda: window.survey.document.is_imported, "the photos", 120.0)
    return window


def aligned(window, views=TRUE.views) -> None:
    """As if a reconstruction had found the cameras where they truly were."""
    out = window.survey.output_folder()
    (out / "work").mkdir(parents=True)
    mine = tuple(view for view in views if view.name in NAMES)
    write_cameras(out / "cameras.json", Cameras(mine, window.survey.folder, TRUE.origin, TRUE.crs))


def open_by_double_click(window, row: int):
    table = window.photos_panel.table
    table.scrollToItem(table.item(row, 0))
    at = table.visualItemRect(table.item(row, 0)).center()
    QTest.mouseClick(table.viewport(), Qt.MouseButton.LeftButton, pos=at)
    QTest.mouseDClick(table.viewport(), Qt.MouseButton.LeftButton, pos=at)
    wait(lambda: window.photo_opening.page is not None, "the photo's window")
    photo = window.photo_opening.page
    ready(photo)
    return photo


def ready(photo) -> None:
    wait(
        lambda: photo.canvas._picture is not None and photo.canvas._picture.is_complete,
        "the picture",
    )
    wait(lambda: photo.masks.used(photo.photo) is not None, "its mask")


def on(photo, x: float, y: float) -> QPoint:
    """Where a pixel of the stored photo is on the canvas."""
    (at,) = photo.canvas.to_widget([x, y])
    return QPoint(round(float(at[0])), round(float(at[1])))


def press(photo, code, modifier=Qt.KeyboardModifier.NoModifier) -> None:
    photo.canvas.setFocus()
    QTest.keyClick(photo.canvas, code, modifier)
    driver.pause(5)


def saved(photo) -> None:
    wait(lambda: not photo.masks.busy_reason, "the masks in the project")
    wait(lambda: not photo.survey.exports.is_busy, "the masks beside the photos")


def mask_of(photos: Path, name: str) -> np.ndarray:
    with Image.open(photos / f"{Path(name).stem}_mask.png") as image:
        assert image.mode == "L"
        return np.asarray(image)


@pytest.mark.full
def test_mask_is_drawn_erased_repeated_and_undone(looked_at, photos):
    photo = open_by_double_click(looked_at, 0)
    row = looked_at.survey.rows[0]
    assert photo.photo == NAMES[0]
    press(photo, Qt.Key.Key_P)
    sky = [(20, 20), (row.width - 20, 20), (row.width - 20, 300), (20, 200)]
    for x, y in sky:
        click(photo.canvas, on(photo, x, y))
    move(photo.canvas, on(photo, 500, 500))
    driver.keep_picture(photo, "photo-window-1-polygon")
    press(photo, Qt.Key.Key_Return)
    saved(photo)
    mask = mask_of(photos, NAMES[0])
    assert mask.shape == (row.height, row.width)
    assert set(np.unique(mask)) == {0, 255}
    assert mask[100, 600] == 0
    assert mask[400, 600] == 255
    assert read_photos(photos).photos[0].mask == photos / "HL_2041_mask.png"
    assert looked_at.photos_panel.table.item(0, 3).text() == "yes"
    driver.keep_picture(looked_at, "photo-window-0-panel")

    # The eraser: the brush, turned over.
    press(photo, Qt.Key.Key_B)
    press(photo, Qt.Key.Key_X)
    assert not photo.canvas.is_masking
    drag(photo.canvas, on(photo, 300, 100), on(photo, 700, 100))
    saved(photo)
    kept = mask_of(photos, NAMES[0])
    assert kept[100, 500] == 255
    assert kept[100, 900] == 0
    driver.keep_picture(photo, "photo-window-2-brush")
    press(photo, Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    saved(photo)
    assert (mask_of(photos, NAMES[0]) == mask).all()

    # A thing that stands fixed in view.
    press(photo, Qt.Key.Key_X)
    drag(photo.canvas, on(photo, 100, 900), on(photo, 200, 900))
    photo.actions_table.run("repeat_mask")
    saved(photo)
    for name in NAMES[1:]:
        assert mask_of(photos, name)[900, 150] == 0
        assert mask_of(photos, name)[100, 600] == 255
    assert sum(row.mask is not None for row in looked_at.survey.rows) == 4
    press(photo, Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    saved(photo)
    assert not (photos / "HL_2042_mask.png").exists(), "nothing is masked there any more"
    assert mask_of(photos, NAMES[0])[900, 150] == 0, "only the repetition was taken back"
    photo.close()


@pytest.mark.full
def test_user_mask_is_shown_and_backed_up_before_it_is_changed(looked_at, photos):
    row = looked_at.survey.rows[1]
    own = np.full((row.height, row.width), 255, np.uint8)
    own[:200] = 0
    Image.fromarray(own).save(photos / "HL_2042_mask.png")
    before = (photos / "HL_2042_mask.png").read_bytes()
    looked_at.survey.open(photos)
    wait(lambda: looked_at.survey.exports.foreign_files == ["HL_2042_mask.png"], "the photos")
    wait(lambda: not looked_at.survey.is_reading, "the check")
    notice = looked_at.message_bar.notice
    assert notice.message == Finding("photo.files-changed", files="HL_2042_mask.png")
    looked_at.actions_table.run("take_in_photos")
    wait(lambda: looked_at.survey.rows[1].mask, "the mask")
    assert not looked_at.survey.exports.foreign_files
    photo = open_by_double_click(looked_at, 1)
    assert not photo.masks.used(NAMES[1])[:200].any()
    driver.keep_picture(photo, "photo-window-3-own-mask")
    press(photo, Qt.Key.Key_B)
    click(photo.canvas, on(photo, 600, 600))
    saved(photo)
    assert mask_of(photos, NAMES[1])[600, 600] == 0
    assert not mask_of(photos, NAMES[1])[:200].any()
    assert (photos / "HL_2042_mask.png.bak").read_bytes() == before
    photo.close()


@pytest.mark.full
def test_mask_that_cannot_be_written_beside_photos_is_kept_in_project(
    looked_at, photos, monkeypatch
):
    from vomstudio.core.errors import TargetError
    from vomstudio.ui.panels.photos import photo_exports

    keep = photo_exports.store_mask

    def refused(place, used, found):
        raise TargetError(Finding("disk.no-permission"), file=place)

    monkeypatch.setattr(photo_exports, "store_mask", refused)
    photo = open_by_double_click(looked_at, 0)
    press(photo, Qt.Key.Key_B)
    click(photo.canvas, on(photo, 600, 600))
    wait(lambda: photo.survey.exports.problem, "the problem")
    assert photo.bar.notice.code == "mask.files-outdated"
    assert "disk.no-permission" in shown_codes(photo.bar.notice.text)
    assert photo.close()
    assert not (photos / "HL_2041_mask.png").exists()
    again = open_by_double_click(looked_at, 0)
    assert not again.masks.used(NAMES[0])[600, 600], "it is still there"
    monkeypatch.setattr(photo_exports, "store_mask", keep)
    press(again, Qt.Key.Key_B)
    click(again.canvas, on(again, 300, 300))
    saved(again)
    assert not again.survey.exports.problem
    assert again.close()
    assert mask_of(photos, NAMES[0])[600, 600] == 0


@pytest.mark.full
def test_mask_that_cannot_be_stored_stays_in_memory_with_its_step(looked_at, monkeypatch):
    from vomstudio.core.errors import TargetError
    from vomstudio.project import assets

    def refused(path, data, *, force=False):
        raise TargetError(Finding("disk.full"), file=path)

    photo = open_by_double_click(looked_at, 0)
    with monkeypatch.context() as full:
        full.setattr(assets, "write_bytes", refused)
        press(photo, Qt.Key.Key_B)
        click(photo.canvas, on(photo, 600, 600))
        assert not photo.masks.used(NAMES[0])[600, 600]
        assert looked_at.message_bar.notice.code == "project.steps-in-memory"
        assert looked_at.studio.project.journal.has_pending_rows
    click(photo.canvas, on(photo, 300, 300))
    assert not looked_at.studio.project.journal.has_pending_rows
    assert photo.close()
    again = open_by_double_click(looked_at, 0)
    assert not again.masks.used(NAMES[0])[600, 600]
    assert not again.masks.used(NAMES[0])[300, 300]
    assert again.close()


@pytest.mark.full
def test_markers_join_components_and_double_click_closes_a_polygon(looked_at, photos):
    """Two photos that nothing joins to the others are a part of their own."""
    window = looked_at
    aligned(window, [v for v in TRUE.views if v.name in NAMES[:2]])
    part = window.survey.output_folder() / "part2"
    part.mkdir()
    others = tuple(v for v in TRUE.views if v.name in NAMES[2:])
    write_cameras(part / "cameras.json", Cameras(others, photos))
    photo = open_by_double_click(window, 2)
    wait(lambda: photo.marks.cameras is not None, "the cameras")
    press(photo, Qt.Key.Key_M)
    click(photo.canvas, on(photo, 500, 400))
    assert photo.marks.marking.labels == ("tie1",)
    said = photo.points.missing_label.text()
    assert {"join.few-markers", "join.begun-markers"} <= shown_codes(said)
    markers = shown_values(said, "join.begun-markers")["markers"]
    assert markers.startswith("tie1 ")
    assert figures(markers) == [0, 1, 2]
    rows = [photo.list.item(i).text() for i in range(4)]
    assert sum("component 2" in text for text in rows) == 2
    # One mark leaves a line in the other photo of its part.
    press(photo, Qt.Key.Key_PageDown)
    wait(lambda: photo.photo == NAMES[3], "the next photo")
    ready(photo)
    assert len(photo.canvas._epipolar_line) > 10
    driver.keep_picture(photo, "photo-window-7-part")
    press(photo, Qt.Key.Key_P)
    corners = [(100, 100), (400, 100), (400, 400)]
    for corner in corners[:-1]:
        click(photo.canvas, on(photo, *corner))
    click(photo.canvas, on(photo, *corners[-1]))
    QTest.mouseDClick(photo.canvas, Qt.MouseButton.LeftButton, pos=on(photo, *corners[-1]))
    saved(photo)
    mask = mask_of(photos, NAMES[3])
    assert mask[200, 350] == 0
    assert (mask == 0).sum() == pytest.approx(300 * 300 / 2, rel=0.02)
    photo.close()


@pytest.mark.full
def test_points_are_marked_predicted_nudged_and_kept(looked_at, photos):
    window = looked_at
    aligned(window)
    photo = open_by_double_click(window, 0)
    wait(lambda: photo.marks.cameras is not None, "the cameras")
    views = {view.name: view for view in TRUE.views}
    places = [
        np.array(p.position) - TRUE.origin for p in read_control(resource("sample", "control.csv"))
    ]
    place = max(places, key=lambda p: sum(views[n].contains(views[n].project(p))[0] for n in NAMES))
    press(photo, Qt.Key.Key_N)
    assert photo.points.label == "tie1"
    seen = [n for n in NAMES if views[n].contains(views[n].project(place))[0]]
    assert len(seen) >= 3
    for name in seen[:2]:
        photo.show_photo(name)
        ready(photo)
        truth = views[name].project(place)[0]
        photo.canvas.zoom_to_pixel((float(truth[0]), float(truth[1])))
        at = on(photo, *truth)
        move(photo.canvas, at + QPoint(2, 1))
        click(photo.canvas, at + QPoint(2, 1))
        marked = photo.marks.marking.of("tie1")[name]
        assert np.hypot(*(np.array(marked) - truth)) < 4.0
        # By hand to a tenth of a pixel.
        for axis, codes in (
            (0, (Qt.Key.Key_Right, Qt.Key.Key_Left)),
            (1, (Qt.Key.Key_Down, Qt.Key.Key_Up)),
        ):
            off = truth[axis] - photo.marks.marking.of("tie1")[name][axis]
            for _ in range(round(abs(off) / 0.1)):
                press(photo, codes[0] if off > 0 else codes[1])
        marked = np.array(photo.marks.marking.of("tie1")[name])
        assert np.abs(marked - truth).max() < 0.06
    sight = photo.marks.prediction("tie1")
    third = seen[2]
    assert np.hypot(*(np.array(sight.expected[third]) - views[third].project(place)[0])) < 2.0
    assert sight.worst_mark[1] < 0.2
    assert photo.list.names[:3] == [*sorted(seen[:2]), sight.unmarked_photos[0]], "by their use"
    photo.show_photo(third)
    ready(photo)
    driver.pause(50)
    middle = QPointF(photo.canvas.rect().center())
    (at,) = photo.canvas.to_widget(sight.expected[third])
    assert np.hypot(at[0] - middle.x(), at[1] - middle.y()) < 2.0, "it is brought into sight"
    move(photo.canvas, middle.toPoint() + QPoint(30, 20))
    driver.keep_picture(photo, "photo-window-4-expected")

    # A mark that is wrong shows itself, and is dragged to its place.
    click(photo.canvas, middle.toPoint() + QPoint(40, 0))
    worst_mark = photo.marks.prediction("tie1").worst_mark
    assert worst_mark[1] > 2.0
    driver.keep_picture(photo, "photo-window-5-wrong")
    (now,) = photo.canvas.to_widget(photo.marks.marking.of("tie1")[third])
    start = QPoint(round(now[0]), round(now[1]))
    drag(photo.canvas, start, start - QPoint(40, 0))
    assert photo.marks.prediction("tie1").worst_mark[1] < 1.5
    table = read_marks(photos / "marks.csv")
    assert {(m.label, m.photo) for m in table} == {("tie1", name) for name in seen[:3]}
    assert {m.photo: (m.x, m.y) for m in table} == photo.marks.marking.of("tie1")

    # Taken back, step by step, on the disk as well.
    press(photo, Qt.Key.Key_Delete)
    assert len(read_marks(photos / "marks.csv")) == 2
    press(photo, Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert read_marks(photos / "marks.csv") == table
    photo.close()
    again = open_by_double_click(window, 0)
    assert again.marks.marking.of("tie1") == {m.photo: (m.x, m.y) for m in table}
    again.close()


@pytest.mark.full
def test_control_points_are_imported_and_missing_marks_are_reported(looked_at, photos, monkeypatch):
    from PySide6.QtWidgets import QFileDialog

    window = looked_at
    aligned(window)
    photo = open_by_double_click(window, 1)
    chosen = [str(resource("sample", "control.csv"))]
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *a, **k: (chosen[0], ""))
    photo.actions_table.run("import_points")
    known = read_control(photos / "control.csv")
    assert known == read_control(resource("sample", "control.csv"))
    assert "control.too-few" in shown_codes(photo.points.missing_label.text())
    assert window.survey.tables() == (None, None), "they cannot place a model yet"
    chosen[0] = str(resource("sample", "marks.csv"))
    photo.actions_table.run("import_marks")
    assert "control.too-few" not in shown_codes(photo.points.missing_label.text())
    assert "marks.imported" in shown_codes(photo._status.text())
    assert photo.bar.notice.code == "marks.other-photos"
    assert window.survey.tables() == (photos / "control.csv", photos / "marks.csv")
    photo.points.select_point(known[0].label)
    driver.pause(100)
    driver.keep_picture(photo, "photo-window-6-control")
    # Coordinates are typed; without them it is a tie point.
    photo.points.coordinate_fields[2].setFocus()
    photo.points.coordinate_fields[2].selectAll()
    QTest.keyClicks(photo.points.coordinate_fields[2], "12,5")
    QTest.keyClick(photo.points.coordinate_fields[2], Qt.Key.Key_Return)
    assert read_control(photos / "control.csv")[0].position[2] == 12.5
    photo.points.role.setCurrentIndex(photo.points.role.findData("check"))
    assert read_control(photos / "control.csv")[0].check
    photo.actions_table.run("undo")
    photo.actions_table.run("undo")
    assert read_control(photos / "control.csv") == known
    survey = window.survey
    wait(lambda: survey.settings.control == photos / "control.csv", "the tables in the settings")
    wait(lambda: not survey.is_forecasting and survey.control_facts, "what they can do")
    assert survey.settings.has_sidecar_control
    asked: list[ReconstructionRequest] = []
    monkeypatch.setattr(
        window.studio.jobs, "submit", lambda job, order, **more: asked.append(order)
    )
    monkeypatch.setattr(type(window.survey), "reconstruction_problem", lambda self: None)
    window.survey.reconstruct()
    assert asked[0].control == photos / "control.csv"
    assert asked[0].marks == photos / "marks.csv"
    window.survey._reconstruction_job = None
    photo.close()


@pytest.mark.full
def test_undo_while_painting_ends_the_stroke(looked_at, photos):
    photo = open_by_double_click(looked_at, 0)
    press(photo, Qt.Key.Key_B)
    click(photo.canvas, on(photo, 300, 300))
    canvas, left = photo.canvas, Qt.MouseButton.LeftButton
    QTest.mousePress(canvas, left, pos=on(photo, 600, 600))
    for x in (640, 700, 760):
        QTest.mouseMove(canvas, on(photo, x, 600))
        driver.pause(20)
    assert photo.masks.is_drawing
    press(photo, Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert not photo.masks.is_drawing
    for x in (800, 900):
        QTest.mouseMove(canvas, on(photo, x, 600))
        driver.pause(20)
    QTest.mouseRelease(canvas, left, pos=on(photo, 900, 600))
    used = photo.masks.used(NAMES[0])
    assert used[600, 500:1000].all(), "the stroke was the last step"
    assert not used[300, 300]
    saved(photo)
    photo.close()


@pytest.mark.full
def test_undo_and_close_are_blocked_while_masks_are_drawn_in_many_photos(looked_at, photos):
    photo = open_by_double_click(looked_at, 0)
    press(photo, Qt.Key.Key_B)
    click(photo.canvas, on(photo, 300, 300))
    photo.actions_table.run("repeat_mask")
    assert photo.masks.busy_reason
    assert not photo.actions_table.all["undo"].isEnabled()
    assert not photo.close()
    assert photo.isVisible()
    assert photo.masks.busy_reason.message in photo.bar._text.text()
    # Another photo is opened, and drawn on, before the run is at its end.
    last = NAMES[-1]
    photo.masks.open(last)
    wait(lambda: photo.masks.used(last) is not None, "the mask of the last photo")
    assert photo.masks.busy_reason
    height, width = photo.masks.used(last).shape
    photo.masks.draw_single_shape(
        last, stroke_area([(900.0, 900.0)], 5.0, width, height), is_masking=True
    )
    saved(photo)
    assert not photo.masks.used(last)[900, 900]
    assert not photo.masks.used(last)[300, 300]
    assert shown_values(photo._status.text(), "mask.repeated") == {"count": "3"}
    driver.pause(100)
    assert shown_values(photo._status.text(), "mask.repeated") == {"count": "3"}, "it stays"
    press(photo, Qt.Key.Key_V)
    assert "mask.repeated" not in shown_codes(photo._status.text())
    assert photo._status.text().endswith(photo._current_hint())
    assert photo.close()


@pytest.mark.full
def test_an_older_copy_of_a_mask_never_replaces_the_newest(looked_at, photos, monkeypatch):
    import time

    from vomstudio.ui.panels.photos import photo_exports

    keep = photo_exports.store_mask
    begun: list[Path] = []

    def slow(place, used, found):
        begun.append(place)
        if len(begun) == 1:
            time.sleep(0.4)
        return keep(place, used, found)

    monkeypatch.setattr(photo_exports, "store_mask", slow)
    photo = open_by_double_click(looked_at, 0)
    press(photo, Qt.Key.Key_B)
    click(photo.canvas, on(photo, 300, 300))
    wait(lambda: begun, "the first export")
    click(photo.canvas, on(photo, 600, 600))
    assert photo.survey.exports.is_busy
    assert photo.close()
    driver.pause(600)
    assert mask_of(photos, NAMES[0])[600, 600] == 0
    assert len(begun) == 2


@pytest.mark.full
def test_full_picture_keeps_the_view_and_closed_window_is_freed(looked_at, photos):
    import gc
    import weakref

    photo = open_by_double_click(looked_at, 0)
    press(photo, Qt.Key.Key_M)
    click(photo.canvas, on(photo, 500, 400))
    photo.canvas.fit()
    before = photo.canvas._scale
    photo.opened_photo._show_picture(photo.opened_photo.row.path, photo.canvas._picture)
    assert photo.canvas._scale == before
    tools = weakref.ref(photo.tools)
    assert photo.close()
    del photo
    driver.pause(100)
    gc.collect()
    assert tools() is None
