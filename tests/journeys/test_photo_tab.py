"""An opened photo in the middle of the window, photo sets in the project tree, and the place of a
model that is asked first: with real mouse and key events."""

from __future__ import annotations

import shutil
import time
from pathlib import Path

import pytest
from PIL import Image
from PySide6.QtCore import QPoint, Qt, QTimer
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QFileDialog, QTabBar

from tests import driver
from tests.driver import CTRL, LEFT, click, key, pick, wait
from tests.messages import shown_codes
from vomstudio.core.identifiers import new_id
from vomstudio.core.paths import resource
from vomstudio.io.photos.drawn_masks import mask_path
from vomstudio.project.photo_edits import add_photo_set
from vomstudio.project.records import PhotoSet
from vomstudio.ui.panels.features.tree_photos import PHOTO_ROLE
from vomstudio.ui.panels.features.tree_view import ID_ROLE, NAME, ORIENTATION

pytestmark = pytest.mark.full

NAMES = ("HL_2041.jpg", "HL_2042.jpg", "HL_2043.jpg", "HL_2044.jpg")


def copy_photos(folder: Path, names=NAMES) -> Path:
    folder.mkdir()
    for name in names:
        shutil.copy(resource("sample", "photos", name), folder)
    return folder


@pytest.fixture
def photos(tmp_path) -> Path:
    return copy_photos(tmp_path / "the face")


def read(window, folder: Path) -> None:
    window.open_path(folder)
    survey = window.survey
    wait(lambda: survey.document.is_imported and not survey.is_reading, "the photos", 120.0)


@pytest.fixture
def both(window, outcrop, photos):
    """An outcrop and photos, in the workspace Interpret."""
    window.resize(1400, 900)
    driver.open_outcrop(window, outcrop)
    read(window, photos)
    key(window, Qt.Key.Key_2, CTRL)
    return window


class Turns(QTimer):
    """The most work of the window's own thread between two of its turns, in seconds. Other
    programs on the machine do not count."""

    def __init__(self) -> None:
        super().__init__()
        self.longest, self._last = 0.0, time.thread_time()
        self.timeout.connect(self._turn)
        self.start(0)

    def _turn(self) -> None:
        now = time.thread_time()
        self.longest, self._last = max(self.longest, now - self._last), now


def branch(window, name: str):
    tree = window.tree.tree
    rows = (tree.topLevelItem(i) for i in range(tree.topLevelItemCount()))
    return next(row for row in rows if row.text(NAME).startswith(name))


def unfold(window, item) -> None:
    """Click the arrow before a row."""
    tree = window.tree.tree
    at = tree.visualItemRect(item)
    QTest.mouseClick(tree.viewport(), LEFT, pos=QPoint(tree.indentation() // 2, at.center().y()))
    assert item.isExpanded()


def double_click(tree, item) -> None:
    tree.scrollToItem(item)
    at = tree.visualItemRect(item).center()
    QTest.mouseClick(tree.viewport(), LEFT, pos=at)
    QTest.mouseDClick(tree.viewport(), LEFT, pos=at)


def opened(window, name: str):
    wait(lambda: window.photo_opening.page is not None, "the photo's page")
    page = window.photo_opening.page
    wait(lambda: page.photo == name, name)
    wait(
        lambda: page.canvas._picture is not None and page.canvas._picture.is_complete, "the picture"
    )
    wait(lambda: page.masks.used(name) is not None, "its mask")
    return page


def open_from_tree(window, name: str):
    item = branch(window, "the face")
    if not item.isExpanded():
        unfold(window, item)
    row = next(item.child(i) for i in range(item.childCount()) if item.child(i).text(NAME) == name)
    double_click(window.tree.tree, row)
    return opened(window, name)


def has_keyboard(page) -> bool:
    return QApplication.focusWidget() is page.canvas


def press(code, modifier=Qt.KeyboardModifier.NoModifier) -> None:
    """A key for whatever has the keyboard."""
    QTest.keyClick(QApplication.focusWidget(), code, modifier)
    driver.pause(20)


def tabs(window) -> QTabBar:
    return window.findChild(QTabBar, "middle_tabs")


# --- the middle ------------------------------------------------------------------------------
def test_photo_from_tree_replaces_outcrop_in_center_until_closed(both):
    window = both
    camera = window.viewport.moves.camera_state()
    assert not tabs(window).isVisible()
    page = open_from_tree(window, NAMES[1])
    assert page.window() is window
    assert page.isVisible()
    assert not window.viewport.isVisible()
    assert has_keyboard(page)
    assert tabs(window).tabText(1) == NAMES[1]
    assert page.canvas.width() > 0.4 * window.width()
    assert page.canvas.height() > 0.4 * window.height()
    driver.keep_picture(window, "photo-tab-1-photo")
    # Another photo takes the same tab.
    press(Qt.Key.Key_PageDown)
    wait(lambda: page.photo == NAMES[2], "the next photo")
    assert tabs(window).tabText(1) == NAMES[2]
    press(Qt.Key.Key_Left, Qt.KeyboardModifier.AltModifier)
    wait(lambda: page.photo == NAMES[1], "the photo before")
    # By a key to the outcrop and back.
    press(Qt.Key.Key_F8)
    assert window.workspaces.current_workspace.name == "interpret"
    wait(window.viewport.isVisible, "the outcrop")
    assert window.viewport.hasFocus()
    assert window.viewport.moves.camera_state() == camera
    assert not page.isVisible()
    driver.keep_picture(window, "photo-tab-2-outcrop")
    press(Qt.Key.Key_F8)
    assert page.isVisible()
    assert has_keyboard(page)
    # By the tabs.
    for tab, seen in ((0, window.viewport), (1, page.canvas)):
        at = tabs(window).tabRect(tab).center()
        QTest.mouseClick(tabs(window), LEFT, pos=at)
        driver.pause(50)
        assert seen.isVisible()
        assert QApplication.focusWidget() is seen
    press(Qt.Key.Key_W, CTRL)
    assert window.photo_opening.page is None
    assert not tabs(window).isVisible()
    assert window.viewport.hasFocus()
    assert window.workspaces.current_workspace.name == "interpret"


def test_keys_act_on_visible_photo_and_not_on_outcrop_behind_it(both, picks):
    window, studio = both, both.studio
    driver.look_at(window, picks["B04"], 10.0, 12.0)
    key(window, Qt.Key.Key_T)
    pick(window, picks["B04"][:3])
    tool = studio.open_tool
    undo = window.actions_table.all["undo"]
    assert "oint" in undo.text(), "of the trace"
    page = open_from_tree(window, NAMES[0])
    assert not window.actions_table.all["trace"].isChecked()
    assert "oint" not in undo.text(), "the trace is not seen"
    # Esc drops the polygon, then nothing; B is the brush, and not the view along the fold axis.
    press(Qt.Key.Key_P)
    assert page.canvas.tool == "polygon"
    middle = page.canvas.rect().center()
    for step in (QPoint(0, 0), QPoint(80, 0), QPoint(80, 60)):
        click(page.canvas, middle + step)
    assert page.tools.corner_count == 3
    assert "vertex" in undo.text()
    press(Qt.Key.Key_Z, CTRL)
    assert page.tools.corner_count == 2, "the vertex, not the step before it"
    press(Qt.Key.Key_Escape)
    assert page.tools.corner_count == 0
    press(Qt.Key.Key_Escape)
    press(Qt.Key.Key_Delete)
    press(Qt.Key.Key_Return)
    assert studio.open_tool is tool
    assert len(tool.vertices) == 3
    press(Qt.Key.Key_B)
    assert page.canvas.tool == "brush"
    # From wherever in the window: a letter in the list of photos, a step back in the table.
    page.list.setFocus()
    press(Qt.Key.Key_M)
    assert has_keyboard(page)
    assert page.canvas.tool == "mark"
    click(page.canvas, middle)
    assert page.marks.marking.labels == ("tie1",)
    assert "tie1" in undo.text()
    window.docks.bring_forward("photos")
    window.photos_panel.table.setFocus()
    press(Qt.Key.Key_Z, CTRL)
    assert page.marks.marking.labels == ()
    assert "Undone" in window.status_line._hint.text()
    press(Qt.Key.Key_Y, CTRL)
    assert page.marks.marking.labels == ("tie1",)
    # A field of the photo hands the keyboard back to the photo.
    page.points.select_point("tie1")
    page.points.name.setFocus()
    page.points.name.selectAll()
    QTest.keyClicks(page.points.name, "nail")
    press(Qt.Key.Key_Return)
    assert has_keyboard(page)
    assert page.marks.marking.labels == ("nail",)
    # A tool of the outcrop brings the outcrop, with the work as it was.
    window.actions_table.all["navigate"].trigger()
    wait(window.viewport.isVisible, "the outcrop")
    window.actions_table.all["trace"].trigger()
    assert studio.open_tool is tool
    key(window, Qt.Key.Key_Return)
    (trace,) = driver.traces(window)
    assert len(trace.vertices) == 3


def test_the_photo_stays_in_front_in_every_workspace(both):
    window = both
    key(window, Qt.Key.Key_1, CTRL)
    window.photo_opening.open(NAMES[0])
    page = opened(window, NAMES[0])
    for code in (Qt.Key.Key_2, Qt.Key.Key_3, Qt.Key.Key_1):
        press(code, CTRL)
        assert page.isVisible()
        assert has_keyboard(page)
    heights = page.canvas.height()
    for _ in range(3):
        press(Qt.Key.Key_F8)
        assert window.viewport.isVisible()
        assert window.workspaces.current_workspace.name == "model"
        press(Qt.Key.Key_F8)
        driver.pause(100)
    assert page.canvas.height() == pytest.approx(heights, abs=4), "nothing grows with each turn"
    # What is opened is seen.
    window.files.opened.emit()
    assert window.viewport.isVisible()
    assert window.workspaces.current_workspace.name == "interpret"


def test_photo_fits_any_window_size_without_a_model(window, photos):
    window.resize(960, 540)
    read(window, photos)
    for size in ((960, 540), (1280, 688), (1920, 1046)):
        window.resize(*size)
        window.photo_opening.open(NAMES[0])
        page = opened(window, NAMES[0])
        has_room(window, page, size)
        window.actions_table.all["close_photo"].trigger()
        assert window.photo_opening.page is None


def has_room(window, page, size: tuple[int, int]) -> None:
    driver.pause(300)
    assert page.canvas.width() > 0.45 * size[0]
    assert page.canvas.height() > 0.4 * size[1]
    press(Qt.Key.Key_F8)
    driver.pause(300)
    assert window.photos_panel.table.height() > 0.4 * size[1]
    press(Qt.Key.Key_F8)
    driver.pause(300)
    assert page.canvas.height() > 0.4 * size[1], "the panel has not kept the room"
    driver.keep_picture(window, f"photo-tab-{size[0]}")


def drawn_in(window, tool: Qt.Key):
    """The first photo, opened and clicked in its middle with a tool."""
    page = open_from_tree(window, NAMES[0])
    press(tool)
    click(page.canvas, page.canvas.rect().center())
    return page


@pytest.mark.usefixtures("new_window")
def test_photo_tab_can_be_detached_to_window_and_docked_again(both):
    window = both
    page = drawn_in(window, Qt.Key.Key_M)
    page.actions_table.run("own_window")
    assert page.isWindow()
    assert page.isVisible()
    wait(window.viewport.isVisible, "the outcrop beside it")
    assert not tabs(window).isVisible()
    assert window.workspaces.current_workspace.name == "interpret"
    page.activateWindow()
    wait(lambda: QApplication.activeWindow() is page, "the photo's window")
    page.canvas.setFocus()
    QTest.keyClick(page.canvas, Qt.Key.Key_Z, CTRL)
    assert page.marks.marking.labels == (), "it has the keys of a window of its own"
    QTest.keyClick(page.canvas, Qt.Key.Key_PageDown)
    wait(lambda: page.photo == NAMES[1], "the next photo")
    QTest.keyClick(page.canvas, Qt.Key.Key_Y, CTRL)
    wait(lambda: page.photo == NAMES[0], "the photo in which the step is seen")
    page.actions_table.run("own_window")
    assert page.window() is window
    driver.focus(window)
    page.canvas.setFocus()
    assert page.isVisible()
    assert tabs(window).isVisible()
    press(Qt.Key.Key_Z, CTRL)
    assert page.marks.marking.labels == ()
    driver.close(window)


def test_photo_with_masks_being_drawn_comes_to_front_and_stays_open(both):
    window = both
    page = drawn_in(window, Qt.Key.Key_B)
    page.actions_table.run("repeat_mask")
    assert page.masks.busy_reason
    key_of_outcrop = window.actions_table.all["outcrop_or_photo"]
    key_of_outcrop.trigger()
    window.actions_table.all["close_photo"].trigger()
    assert window.photo_opening.page is page
    assert page.isVisible()
    assert page.masks.busy_reason.message in page.bar.text
    wait(lambda: not page.masks.busy_reason, "the masks")
    window.actions_table.all["close_photo"].trigger()
    assert window.photo_opening.page is None


def test_opening_another_project_closes_the_photo(both, tmp_path):
    window = both
    open_from_tree(window, NAMES[0])
    window.studio.save_as(tmp_path / "kept.vom")
    window.studio.new_project()
    assert window.photo_opening.page is None
    assert not tabs(window).isVisible()
    assert window.viewport.isVisible()
    assert window.tree.tree.topLevelItemCount() > 0
    assert not window.tree._photos.has_photos


def test_a_mask_just_drawn_is_written_before_another_project_is_opened(window, photos, tmp_path):
    window.resize(1400, 900)
    read(window, photos)
    window.photo_opening.open(NAMES[0])
    page = opened(window, NAMES[0])
    page.actions_table.run("invert_mask")
    survey = window.survey
    wait(lambda: not page.masks.busy_reason and survey.rows[0].mask, "the mask")
    paths = [Path(row.path) for row in survey.rows]
    mask = mask_path(paths[0], paths)
    project = tmp_path / "kept.vom"
    window.studio.save_as(project)
    window.studio.new_project()
    assert mask.is_file()
    assert "photo.files-changed" not in shown_codes(window.message_bar.text)
    window.open_path(project)
    wait(lambda: survey.rows and survey.document.is_imported, "the photos again")
    assert survey.exports.foreign_files == []


# --- the tree --------------------------------------------------------------------------------
def test_tree_shows_marks_and_mask_of_a_photo_and_follows_undo(both):
    window = both
    page = open_from_tree(window, NAMES[0])
    press(Qt.Key.Key_M)
    click(page.canvas, page.canvas.rect().center())
    row = branch(window, "the face").child(0)
    assert row.text(ORIENTATION) == "1 mark"
    page.actions_table.run("invert_mask")
    wait(lambda: row.text(ORIENTATION) == "1 mark · mask", "the mask")
    press(Qt.Key.Key_Z, CTRL)
    press(Qt.Key.Key_Z, CTRL)
    assert row.text(ORIENTATION) == ""


def test_enter_opens_a_tree_photo_and_selecting_one_shows_it_in_panel(both):
    window = both
    tree = window.tree.tree
    item = branch(window, "the face")
    unfold(window, item)
    tree.scrollToItem(item.child(2))
    QTest.mouseClick(tree.viewport(), LEFT, pos=tree.visualItemRect(item.child(2)).center())
    assert window.photos_panel.selected_photo() == NAMES[2]
    assert window.studio.selection.ids == (), "a photo is no record"
    assert [each.data(NAME, PHOTO_ROLE) for each in tree.selectedItems()] == [NAMES[2]]
    press(Qt.Key.Key_Down)
    press(Qt.Key.Key_Return)
    opened(window, NAMES[3])


def test_tree_lists_two_photo_sets_and_opens_photos_of_either(both, tmp_path):
    window = both
    other = copy_photos(tmp_path / "another wall", NAMES[:2])
    read(window, other)
    key(window, Qt.Key.Key_2, CTRL)
    assert branch(window, "another wall").text(NAME) == "another wall (2)"
    # The panel shows the other set: the names of this one are read from its folder.
    item = branch(window, "the face")
    unfold(window, item)
    wait(lambda: item.childCount() == 4, "its photos")
    menu = window.tree.create_item_menu(item)
    assert "Reconstruct" not in " ".join(a.text().replace("&", "") for a in menu.actions())
    double_click(window.tree.tree, item.child(3))
    page = opened(window, NAMES[3])
    assert page.folder == window.survey.folder
    assert window.survey.folder.name == "the face"
    menu = window.tree.create_item_menu(branch(window, "the face"))
    texts = {action.text().replace("&", "") for action in menu.actions()}
    assert {"Reconstruct", "Open its first photo", "Show in Photos"} <= texts
    shutil.rmtree(other)
    gone = window.studio.records[str(branch(window, "another").data(NAME, ID_ROLE))]
    window.photo_opening.open_set_photo(gone)
    notice = window.message_bar.notice
    assert (notice.code, notice.message.values["name"]) == ("photo.folder-missing", other.name)
    assert page.isVisible(), "what was open stays"


def test_expanding_thousands_of_photos_does_not_block_the_window(both, tmp_path):
    window = both
    many = tmp_path / "many"
    many.mkdir()
    small = tmp_path / "small.jpg"
    Image.new("RGB", (60, 40), (120, 110, 100)).save(small)
    for number in range(2000):
        (many / f"DSC_{number:05d}.jpg").hardlink_to(small)
    window.studio.attempt(add_photo_set, PhotoSet(new_id("photos"), "many", str(many)))
    item = branch(window, "many")
    turns = Turns()
    unfold(window, item)
    wait(lambda: item.childCount() == 2000, "all of them")
    driver.pause(100)
    print(f"longest turn {turns.longest * 1e3:.0f} ms")
    assert turns.longest < 0.1
    assert item.child(1999).text(NAME) == "DSC_01999.jpg"
    assert item.text(NAME) == "many (2000)"


# --- the place of a model --------------------------------------------------------------------
def test_untitled_project_asks_for_a_folder_before_making_a_model(
    window, photos, tmp_path, monkeypatch
):
    window.resize(1400, 900)
    read(window, photos)
    asked: list[str] = []
    answers = ["", str(tmp_path / "cliff")]

    def ask(parent, title, proposed, pattern):
        assert window.survey.reconstruction_job is None, "before anything is begun"
        asked.append(proposed)
        return answers[len(asked) - 1], pattern

    monkeypatch.setattr(QFileDialog, "getSaveFileName", ask)
    window.photo_opening.open(NAMES[0])
    page = opened(window, NAMES[0])
    page.actions_table.run("invert_mask")
    wait(lambda: not page.masks.busy_reason and window.survey.rows[0].mask, "the mask")
    folder = window.studio.project.folder
    window.actions_table.run("make_model")
    assert window.survey.reconstruction_job is None
    assert window.studio.project.is_untitled
    assert window.studio.project.folder == folder
    assert not (folder / "reconstruction").exists(), "nothing was begun"
    assert Path(asked[0]).name == "the face.vom"
    assert Path(asked[0]).parent.is_dir()
    assert not Path(asked[0]).is_relative_to(folder.parent), "a folder of the user's"
    window.actions_table.run("make_model")
    place = tmp_path / "cliff.vom"
    assert window.studio.project.folder == place
    assert window.survey.reconstruction_job is not None
    assert window.survey.output_folder().is_relative_to(place)
    # What the photos need has gone along.
    row = window.survey.rows[0]
    assert Path(row.mask).is_relative_to(place)
    assert Path(row.mask).is_file()
    assert Path(row.thumbnail).is_file()
    window.survey.pause()
    wait(lambda: window.survey.reconstruction_job is None, "the pause", 60.0)
    assert len(asked) == 2
    window.actions_table.run("make_model")
    assert len(asked) == 2, "it has a place now"
    window.survey.pause()
    wait(lambda: window.survey.reconstruction_job is None, "the pause", 60.0)
    shutil.rmtree(place / "reconstruction", ignore_errors=True)


def test_unusable_project_folder_starts_no_reconstruction(window, photos, tmp_path, monkeypatch):
    read(window, photos)
    full = tmp_path / "full.vom"
    full.mkdir()
    (full / "notes.txt").write_text("mine")
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(full), ""))
    window.actions_table.run("make_model")
    assert window.survey.reconstruction_job is None
    assert window.studio.project.is_untitled
    assert "folder.not-empty" in shown_codes(window.message_bar.text)
    assert [path.name for path in full.iterdir()] == ["notes.txt"]
