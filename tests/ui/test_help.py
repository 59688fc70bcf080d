"""Help > Documentation: the pages are read in the program, from the files that came with it."""

from __future__ import annotations

from pathlib import Path

import pytest
from PySide6.QtCore import Qt, QUrl
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QWidget

from vomstudio.core.paths import documentation
from vomstudio.ui.base.actions import Actions
from vomstudio.ui.base.open_dialogs import OpenDialogs
from vomstudio.ui.commands import help as help_commands
from vomstudio.ui.dialogs.help.help_pages import anchor, list_pages, list_sections
from vomstudio.ui.dialogs.help.help_window import HelpWindow


@pytest.fixture
def parent(qtbot):
    widget = QWidget()
    qtbot.addWidget(widget)
    return widget


@pytest.fixture
def help_window(parent):
    window = HelpWindow(parent, documentation())
    window.show()
    QTest.qWaitForWindowExposed(window)
    yield window
    window.close()
    QApplication.processEvents()


@pytest.fixture
def two_pages(tmp_path: Path) -> Path:
    first = "# Start\n\n## To read\n\nSee [the other](other.md#a-long-way-down).\n"
    (tmp_path / "index.md").write_text(first)
    body = "\n\n".join(f"Line {i}." for i in range(200))
    (tmp_path / "other.md").write_text(f"# Other\n\n{body}\n\n## A long way down\n\nquartzite\n")
    (tmp_path / "more.md").write_text("no heading here\n")
    return tmp_path


def test_pages_are_listed_in_the_order_of_links_on_the_first_page(two_pages: Path):
    assert [page.title for page in list_pages(two_pages)] == ["Start", "Other", "more"]
    assert list(list_sections(two_pages)) == ["", "To read", "More"]


def test_anchors_follow_the_usual_heading_syntax():
    assert anchor("A plane?") == "a-plane"
    assert anchor("Points, marked - 3") == "points-marked-3"


@pytest.mark.full
def test_page_titles_are_not_truncated(help_window):
    pages = help_window.list
    assert pages.viewport().width() >= pages.sizeHintForColumn(0)


@pytest.mark.full
def test_every_page_of_the_documentation_is_shown_with_its_pictures(help_window):
    titles = [page.title for page in list_pages(documentation())]
    shown = [help_window.list.item(row).text() for row in range(help_window.list.count())]
    assert shown == titles
    for row, title in enumerate(titles):
        help_window.list.setCurrentRow(row)
        assert help_window.view.document().firstBlock().text() == title
        for path in pictures_of(help_window.view):
            image = help_window.view.loadResource(2, QUrl(path))
            assert not image.isNull(), path
            assert image.width() <= help_window.view.viewport().width()


def pictures_of(view) -> list[str]:
    found = []
    block = view.document().begin()
    while block.isValid():
        pieces = block.begin()
        while not pieces.atEnd():
            form = pieces.fragment().charFormat()
            if form.isImageFormat():
                found.append(form.toImageFormat().name())
            pieces += 1
        block = block.next()
    return found


def test_link_opens_its_heading_and_back_returns(parent, two_pages: Path):
    window = HelpWindow(parent, two_pages)
    window.show()
    QTest.qWaitForWindowExposed(window)
    window.view.follow_link(QUrl("other.md#a-long-way-down"))
    assert window.list.currentRow() == 1
    assert window.view.verticalScrollBar().value() > 0
    assert window.view.textCursor().block().text() == "A long way down"
    window.view.go_back()
    assert window.list.currentRow() == 0
    window.view.go_forward()
    assert window.list.currentRow() == 1
    window.close()


def test_search_continues_on_other_pages_and_wraps_around(parent, two_pages: Path):
    window = HelpWindow(parent, two_pages)
    window.show()
    window.search.setFocus()
    QTest.keyClicks(window.search, "quartzite")
    QTest.keyClick(window.search, Qt.Key.Key_Return)
    assert window.list.currentRow() == 1
    assert window.view.textCursor().selectedText() == "quartzite"
    window.search.setText("see")
    QTest.keyClick(window.search, Qt.Key.Key_Return)
    assert window.list.currentRow() == 0
    assert window.view.textCursor().selectedText() == "See"
    window.close()


def test_help_command_opens_only_one_window(parent):
    dialogs = OpenDialogs()
    commands = help_commands.commands(Actions(parent), None, dialogs, parent)
    command = next(command for command in commands if command.name == "documentation")
    command.run()
    opened = dialogs.find_visible(HelpWindow)
    assert opened is not None
    assert opened.view.page == documentation().resolve() / "index.md"
    command.run()
    assert dialogs.find_visible(HelpWindow) is opened
    opened.close()
    QApplication.processEvents()
