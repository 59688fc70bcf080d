"""F1 explains the figure under the cursor, and every figure that is shown is explained."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from PySide6.QtCore import QPoint
from PySide6.QtGui import QCursor
from PySide6.QtWidgets import QApplication, QLabel

from tests.ui import numbers_page
from tests.ui.conftest import add_bed, add_cliff
from vomstudio.core.paths import documentation
from vomstudio.project import catalogue
from vomstudio.project.figures import Figure
from vomstudio.ui.base.help_links import find_help_topic
from vomstudio.ui.dialogs.help.help_pages import anchor, figure_heading, help_address
from vomstudio.ui.dialogs.help.help_window import HelpWindow
from vomstudio.ui.panels.features.table_model import COLUMNS

ROOT = Path(__file__).resolve().parents[2]


def sections(page: str) -> dict[str, str]:
    """The text under each heading of a page, by its anchor."""
    text = (documentation() / page).read_text("utf-8")
    parts = re.split(r"^#+ (.+)$", text, flags=re.MULTILINE)
    return {anchor(h): t.strip() for h, t in zip(parts[1::2], parts[2::2], strict=True)}


@pytest.mark.full
def test_numbers_page_explains_every_figure_of_the_catalogue():
    """``python -m tests.ui.numbers_page`` renews them."""
    page = numbers_page.PAGE.read_text("utf-8")
    assert numbers_page.renewed(page) == page
    written = sections("numbers.md")
    for figure in numbers_page.SHOWN.values():
        assert anchor(figure_heading(figure)) in written, figure_heading(figure)
    assert len(written) == len(
        re.findall(r"^#", (documentation() / "numbers.md").read_text(), re.MULTILINE)
    )


def test_every_help_address_is_a_heading_of_the_documentation():
    found = set()
    for path in (ROOT / "vomstudio" / "ui").rglob("*.py"):
        found |= set(re.findall(r'"([a-z_]+\.md)(?:#([^"\]]*))?"', path.read_text("utf-8")))
    addresses = {(page, place) for page, place in found if place}
    assert len(addresses) >= 15
    for page, _ in found:
        if page != "PAGE.md":
            assert (documentation() / page).is_file(), page
    for page, place in addresses - {("PAGE.md", "HEADING")}:
        assert place in sections(page), (page, place)


def test_links_on_the_numbers_page_have_targets():
    text = (documentation() / "numbers.md").read_text("utf-8")
    links = re.findall(r"\]\(([\w.]*)#([^)]+)\)", text)
    assert len(links) > 10
    for page, place in links:
        assert place in sections(page or "numbers.md"), (page, place)


@pytest.fixture
def selected(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1", "B01")
    studio.selection.set(["t1"])
    window.resize(1400, 900)
    window.docks.bring_forward("properties")
    QApplication.processEvents()
    return window


def explained_at(widget, at: QPoint):
    return find_help_topic(widget, widget.mapToGlobal(at))


def test_each_figure_of_the_properties_has_an_explanation(selected):
    selected.properties._fit.details.setChecked(True)
    QApplication.processEvents()
    names = set()
    for label in selected.properties.findChildren(QLabel):
        if not label.isVisible() or not re.search(r"\d", label.text()):
            continue
        for x in (1, label.width() - 2):
            what = explained_at(label, QPoint(x, 4))
            assert what is not None, label.text()
            names.add(what.name if isinstance(what, Figure) else what)
    assert {"M", "K", "coplanarity", "collinearity", "max_confidence95_deg", "rms_m"} <= names
    assert "min_confidence95_deg" in names


def test_each_table_column_is_explained_in_header_and_cells(selected):
    view = selected.table.view
    for column in range(view.model().columnCount()):
        if view.isColumnHidden(column):
            continue
        x = view.columnViewportPosition(column) + 3
        for widget in (view.horizontalHeader(), view.viewport()):
            what = explained_at(widget, QPoint(x, 5))
            assert what == (COLUMNS[column].figure or "numbers.md#orientation")


def test_f1_opens_the_page_at_the_figure_under_the_cursor(selected):
    selected.docks.bring_forward("table")
    selected.studio.settings.hidden_columns = []
    selected.studio.keep_settings()
    QApplication.processEvents()
    view = selected.table.view
    column = next(i for i, c in enumerate(COLUMNS) if c.figure is catalogue.MAX_CONFIDENCE)
    x = view.columnViewportPosition(column) + 5
    QCursor.setPos(view.viewport().mapToGlobal(QPoint(x, 5)))
    QApplication.processEvents()
    selected.actions_table.run("explain")
    opened = selected._dialogs.find_visible(HelpWindow)
    assert opened is not None
    assert opened.view.page.name == "numbers.md"
    assert opened.view.textCursor().block().text() == figure_heading(catalogue.MAX_CONFIDENCE)
    assert help_address(catalogue.MAX_CONFIDENCE).endswith("#fit-max-max_confidence95_deg")
    opened.close()
    QApplication.processEvents()


def test_explain_shortcut_is_f1_and_works_in_dialogs(selected):
    from PySide6.QtCore import Qt

    action = selected.actions_table.all["explain"]
    assert action.shortcut().toString() == "F1"
    assert action.shortcutContext() == Qt.ShortcutContext.ApplicationShortcut
