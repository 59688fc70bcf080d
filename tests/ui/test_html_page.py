"""A report opens without a browser, too."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtGui import QDesktopServices, QImage
from PySide6.QtWidgets import QWidget

from tests import appearance
from tests.products.test_reconstruction_report import result
from tests.tiers import first_in_default_tier
from vomstudio.products.report.reconstruction import write_report
from vomstudio.ui.base import theme
from vomstudio.ui.widgets.html_page import HtmlPage, open_page

PAGE = '<html lang="en"><body><h1>Report</h1><p>27 photos aligned</p></body></html>'


@pytest.mark.parametrize("browser", first_in_default_tier([True, False], 1))
def test_page_is_shown_in_the_program_only_without_a_browser(
    qtbot: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, browser: bool
) -> None:
    asked: list[str] = []

    def open_url(url: Any) -> bool:
        asked.append(url.toLocalFile())
        return browser

    monkeypatch.setattr(QDesktopServices, "openUrl", open_url)
    path = tmp_path / "report é.html"
    path.write_text(PAGE, encoding="utf-8")
    parent = QWidget()
    qtbot.addWidget(parent)
    open_page(parent, path)
    assert asked == [str(path)]
    pages = parent.findChildren(HtmlPage)
    assert len(pages) == (0 if browser else 1)
    for page in pages:
        assert page.isVisible()
        assert "27 photos aligned" in page.text.toPlainText()
        page.close()


@pytest.mark.parametrize("name", ["light", "dark"])
def test_a_page_is_dark_on_light_in_every_theme(
    qtbot: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.setattr(QDesktopServices, "openUrl", lambda _: False)
    path = tmp_path / "report.html"
    path.write_text(PAGE, encoding="utf-8")
    theme.use(name)
    parent = QWidget()
    qtbot.addWidget(parent)
    open_page(parent, path)
    (page,) = parent.findChildren(HtmlPage)
    image = page.text.viewport().grab().toImage().convertToFormat(QImage.Format.Format_RGB32)
    pixels = np.frombuffer(image.constBits(), np.uint8).reshape(-1, 4)[:, 2::-1]
    assert np.median(pixels) > 200
    assert appearance.strongest_contrast(pixels) > 7.0
    page.close()
    theme.use("system")


def test_figure_has_a_gap_to_the_warning_above_it(qtbot: Any, tmp_path: Path) -> None:
    path = tmp_path / "report.html"
    write_report(path, result(warnings=["first", "last warning"]))
    parent = QWidget()
    qtbot.addWidget(parent)
    document = HtmlPage(parent, path).text.document()
    document.setTextWidth(800.0)
    block, layout = document.find("last warning").block(), document.documentLayout()
    # Margins are not part of a block's box.
    gap = layout.blockBoundingRect(block.next()).top() - layout.blockBoundingRect(block).bottom()
    assert block.next().text() == "\ufffc"
    assert gap >= 16.0
    assert block.next().blockFormat().leftMargin() == block.blockFormat().leftMargin()
