"""A report opens without a browser, too."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from PySide6.QtGui import QDesktopServices
from PySide6.QtWidgets import QWidget

from tests.tiers import first_in_default_tier
from vomstudio.ui.widgets.html_page import HtmlPage, open_page

PAGE = '<html lang="en"><body><h1>Report</h1><p>27 photos aligned</p></body></html>'


@pytest.mark.parametrize("browser", first_in_default_tier([True, False], 1))
def test_the_page_is_shown_here_only_where_there_is_no_browser(
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
