"""Light and dark: what is switched on is plain to see, and icons follow."""

from __future__ import annotations

import math
from collections import Counter

import pytest
from PySide6.QtCore import QRect, Qt
from PySide6.QtGui import QImage, QPalette
from PySide6.QtWidgets import (
    QApplication,
    QCheckBox,
    QDialog,
    QDialogButtonBox,
    QStyle,
    QStyleOptionButton,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from tests import driver
from tests.ui.conftest import add_bed, add_cliff
from vomstudio.io.settings import read_settings
from vomstudio.ui.base import theme
from vomstudio.ui.panels.features.table_model import COLUMNS

THEMES = ["light", "dark"]


@pytest.fixture(params=THEMES)
def shown(request, window, studio):
    """The window in a theme, with a model, so that tools can be chosen."""
    add_cliff(studio)
    window.actions_table.run(f"theme_{request.param}")
    driver.pause(50)
    yield request.param
    theme.use("system")


def luminance(color: tuple[int, int, int]) -> float:
    """Relative luminance of sRGB, of WCAG 2.1."""
    parts = [c / 255 for c in color]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
    return sum(w * c for w, c in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def contrast(a: tuple[int, int, int], b: tuple[int, int, int]) -> float:
    """From 1 to 21, of WCAG 2.1."""
    light, dark = sorted((luminance(a), luminance(b)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def colors(button: QToolButton) -> list[list[tuple[int, int, int]]]:
    """The rows of its pixels."""
    image = button.grab().toImage().convertToFormat(QImage.Format.Format_RGB32)
    return [
        [image.pixelColor(x, y).getRgb()[:3] for x in range(image.width())]
        for y in range(image.height())
    ]


def most(pixels: list[tuple[int, int, int]]) -> tuple[int, int, int]:
    return Counter(pixels).most_common(1)[0][0]


def most_of(rows: list[list[tuple[int, int, int]]]) -> tuple[int, int, int]:
    return most([pixel for row in rows for pixel in row])


def buttons(window, *names: str) -> list[QToolButton]:
    actions = [window.actions_table.all[name] for name in names]
    found = [holder for action in actions for holder in action.associatedObjects()]
    return [each for each in found if isinstance(each, QToolButton) and each.isVisible()]


@pytest.mark.full
def test_checked_buttons_are_distinct_and_readable(window, studio, shown):
    on = buttons(window, "navigate", "workspace_interpret")
    off = buttons(window, "workspace_model", "workspace_results")
    assert len(on) == len(off) == 2
    for pressed, plain in zip(on, off, strict=True):
        lit, unlit = colors(pressed), colors(plain)
        ground, around = most_of(lit), most_of(unlit)
        assert math.dist(ground, around) > 30, "the button is filled"
        frame = lit[0][len(lit[0]) // 2]
        # 3 is wanted of parts of controls, 4.5 of words (WCAG 2.1, 1.4.11 and 1.4.3).
        assert contrast(frame, around) >= 3.0
        for pixels, back in ((lit, ground), (unlit, around)):
            assert max(contrast(p, back) for row in pixels for p in row) >= 4.5


def test_text_and_icons_are_readable_on_every_background(window, shown):
    palette = QApplication.palette()
    role = QPalette.ColorRole
    for words, ground in (
        (role.WindowText, role.Window),
        (role.Text, role.Base),
        (role.Text, role.AlternateBase),
        (role.ButtonText, role.Button),
        (role.ToolTipText, role.ToolTipBase),
        (role.Link, role.Base),
    ):
        found = [palette.color(each).getRgb()[:3] for each in (words, ground)]
        assert contrast(*found) >= 4.5, (words, ground)
    pixels = theme.icon("undo").pixmap(24, 24).toImage()
    drawn = [
        pixels.pixelColor(x, y).getRgb()[:3]
        for x in range(24)
        for y in range(24)
        if pixels.pixelColor(x, y).alpha() == 255
    ]
    assert drawn
    assert contrast(most(drawn), palette.color(role.Window).getRgb()[:3]) >= 4.5


def test_theme_is_saved_and_checked_in_its_menu(window, studio, shown):
    assert theme.is_dark() == (shown == "dark")
    assert read_settings()[0].theme == shown
    ticked = [n for n in ("system", *THEMES) if window.actions_table.all[f"theme_{n}"].isChecked()]
    assert ticked == [shown]


@pytest.mark.full
def test_window_icons_follow_a_theme_change(window, studio):
    add_cliff(studio)
    driver.pause(50)
    (button,) = buttons(window, "navigate")
    seen = []
    try:
        for name in THEMES:
            window.actions_table.run(f"theme_{name}")
            driver.pause(50)
            rows = colors(button)
            ground = most_of(rows)
            seen.append(ground)
            strongest = max((p for row in rows for p in row), key=lambda p: contrast(p, ground))
            assert contrast(strongest, ground) >= 3.0
            assert (luminance(strongest) > luminance(ground)) == (name == "dark")
    finally:
        theme.use("system")
    assert seen[0] != seen[1]


def frame_and_ground(widget: QWidget, box: QRect) -> float:
    """Contrast of the frame of a box with what stands around it."""
    image = widget.grab().toImage().convertToFormat(QImage.Format.Format_RGB32)
    ratio = image.width() / widget.width()
    y = round(box.center().y() * ratio)
    left = round(box.left() * ratio)
    row = [image.pixelColor(x, y).getRgb()[:3] for x in range(max(0, left - 4), left + 8)]
    return max(contrast(row[0], each) for each in row)


@pytest.mark.full
def test_unchecked_boxes_are_visible(window, studio, shown):
    add_bed(studio)
    studio.selection.set([])
    studio.set_visible(["t1"], False)
    window.docks.bring_forward("project")
    window.docks.bring_forward("table")
    driver.pause(80)
    check = QCheckBox("Hillshade")
    check.resize(check.sizeHint())
    option = QStyleOptionButton()
    option.initFrom(check)
    at = check.style().subElementRect(QStyle.SubElement.SE_CheckBoxIndicator, option, check)
    assert frame_and_ground(check, at) >= 1.5
    tree, table = window.tree.tree, window.table.view
    (item,) = tree.findItems("B01", Qt.MatchFlag.MatchRecursive | Qt.MatchFlag.MatchExactly)
    column = next(i for i, each in enumerate(COLUMNS) if each.title == "Overturned")
    for view, index in (
        (tree, tree.indexFromItem(item)),
        (table, table.model().index(0, column)),
    ):
        port = view.viewport()
        image = (
            port.grab(view.visualRect(index)).toImage().convertToFormat(QImage.Format.Format_RGB32)
        )
        y = image.height() // 2
        row = [image.pixelColor(x, y).getRgb()[:3] for x in range(min(20, image.width()))]
        assert max(contrast(row[-1], each) for each in row) >= 1.5, view.objectName()


@pytest.mark.usefixtures("qapp")
def test_standard_buttons_have_no_icons() -> None:
    theme.use("dark")
    kinds = QDialogButtonBox.StandardButton
    box = QDialogButtonBox(kinds.Ok | kinds.Cancel | kinds.Close | kinds.Save)
    assert all(button.icon().isNull() and button.text() for button in box.buttons())
    theme.use("system")


@pytest.mark.full
@pytest.mark.parametrize("name", ["light", "dark"])
def test_default_button_has_the_accent_colour(qtbot, name) -> None:
    theme.use(name)
    dialog = QDialog()
    qtbot.addWidget(dialog)
    kinds = QDialogButtonBox.StandardButton
    box = QDialogButtonBox(kinds.Ok | kinds.Cancel)
    QVBoxLayout(dialog).addWidget(box)
    dialog.show()
    driver.pause(50)

    def has_accent(kind: QDialogButtonBox.StandardButton) -> bool:
        button = box.button(kind)
        image = button.grab().toImage()
        accent = button.palette().highlight().color()
        y = image.height() // 2
        return any(image.pixelColor(x, y) == accent for x in range(4))

    assert box.button(kinds.Ok).isDefault()
    assert has_accent(kinds.Ok)
    assert not has_accent(kinds.Cancel)
    theme.use("system")
