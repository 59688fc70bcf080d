"""The table of the beds of a log, as narrow as a dock can be."""

from __future__ import annotations

import pytest
from PySide6.QtWidgets import QApplication

from tests.tiers import first_in_default_tier
from vomstudio.ui.panels.logs.log_table import NOTES, BedLogTable


@pytest.mark.parametrize("width", first_in_default_tier([180, 260, 420, 900], 1))
def test_header_is_not_truncated_in_a_narrow_table(qtbot, width):
    table = BedLogTable()
    qtbot.addWidget(table)
    table.resize(width, 160)
    table.show()
    QApplication.processEvents()
    header = table.horizontalHeader()
    for column in range(table.columnCount()):
        assert header.sectionSize(column) >= header.sectionSizeHint(column)
    # Where there is room the notes have all of it.
    left = table.viewport().width() - sum(header.sectionSize(i) for i in range(NOTES))
    assert header.sectionSize(NOTES) == max(left, header.sectionSizeHint(NOTES))
