"""No two visible panels show the same figure, apart from an attitude with its error and mark."""

from __future__ import annotations

import re
from itertools import combinations

import pytest
from PySide6.QtWidgets import QAbstractItemView, QLabel, QTextEdit, QWidget

from tests import driver
from tests.tiers import first_in_default_tier
from vomstudio.project import edits
from vomstudio.project.kinds.lineation import Lineation
from vomstudio.project.kinds.trace import Trace
from vomstudio.ui.shell.layout import REGIONS

ATTITUDE = re.compile(r"\d{3}(\.\d+)?/\d{2}(\.\d+)?(\s*±\s*\d+(\.\d+)?\s*°)?")
UNIT = r"(?:°|%|mm\b|cm\b|m\b|km\b|m²)"
FIGURE = re.compile(rf"(\d+\.\d+|\d+(?=\s?{UNIT}))(?:\s?({UNIT}))?")
Figures = set[tuple[str, str]]
# A confidence level is a name, not a figure of the feature.
LEVEL = re.compile(r"\b(95|99)\s?%")


def get_texts(widget: QWidget) -> list[str]:
    """The texts that a user reads in the visible widgets of a panel."""
    texts = [each.text() for each in widget.findChildren(QLabel) if each.isVisible()]
    texts += [e.toPlainText() for e in widget.findChildren(QTextEdit) if e.isVisible()]
    for view in widget.findChildren(QAbstractItemView):
        model = view.model()
        if not view.isVisible() or model is None:
            continue
        for row in range(min(model.rowCount(), 40)):
            for column in range(model.columnCount()):
                rect = view.visualRect(model.index(row, column))
                if rect.isValid() and rect.intersects(view.viewport().rect()):
                    texts.append(str(model.index(row, column).data() or ""))
    return texts


def figures_of(texts: list[str], errors: set[str]) -> Figures:
    """Figures in the texts of a panel with their units, without attitudes and their errors."""
    texts = [LEVEL.sub("", ATTITUDE.sub("", text)) for text in texts]
    every = {(n, unit) for text in texts for n, unit in FIGURE.findall(text)}
    return {(n, unit) for n, unit in every if n not in errors}


def common_figures(first: Figures, second: Figures) -> Figures:
    """Figures that occur on both pages; a cell of a table has no unit."""
    return {
        (n, unit)
        for n, unit in first
        if any(n == m and (unit == u or not unit or not u) for m, u in second)
    }


def net_texts(window) -> list[str]:
    """The texts that are drawn on the net."""
    driver.wait(lambda: window.net.is_up_to_date and window.net.artists is not None, "the net")
    return [text.get_text() for text in window.net.artists.axes.texts]


@pytest.fixture
def interpreted(window, outcrop, picks):
    model_id = driver.open_outcrop(window, outcrop)
    model = window.studio.records[model_id]
    for name, points in picks.items():
        vertices = tuple(tuple(p) for p in points.tolist())
        trace = Trace(name, name, "bedding", model_id, model.content_hash, vertices)
        assert window.studio.attempt(edits.add_trace, trace)
    ends = tuple(tuple(p) for p in picks["B01"][[0, 5, 9]].tolist())
    line = Lineation("l1", "L01", "lineation", model_id, model.content_hash, ends, plane_id="B01")
    assert window.studio.attempt(edits.add_features, [line])
    window.resize(1600, 1000)
    return window


def figures_of_pages(window, pages: list[str]) -> dict[str, Figures]:
    """The figures of each page; they do not depend on the page beside it."""
    studio = window.studio
    errors: set[str] = set()
    for measured in studio.measured(f.id for f in studio.session.features()).values():
        attitude = ATTITUDE.search(measured.attitude())
        error = FIGURE.search(attitude[0].partition("±")[2]) if attitude else None
        errors |= {error[1]} if error else set()
    figures = {}
    for page in pages:
        window.docks.bring_forward(page)
        panel = window.docks[page].widget()
        driver.wait(lambda p=panel: driver.is_seen(p), page)
        driver.pause(150)
        panel = window.docks[page].widget()
        figures[page] = figures_of(get_texts(panel), errors)
    figures["stereonet"] = figures_of(net_texts(window), errors)
    return figures


def repeats_of(figures: dict[str, Figures]) -> dict[tuple[str, str], Figures]:
    """Figures on two pages that can be visible together."""
    return {
        (first, second): both
        for first, second in combinations(figures, 2)
        if REGIONS[first] != REGIONS[second]
        and (both := common_figures(figures[first], figures[second]))
    }


PAGES = [name for name, region in REGIONS.items() if region not in ("overlay", "beside")]


@pytest.mark.parametrize("feature", first_in_default_tier(["B04", "l1"]))
def test_no_two_panels_show_the_same_figure(interpreted, feature) -> None:
    interpreted.studio.selection.set([feature])
    figures = figures_of_pages(interpreted, PAGES)
    assert sum(map(len, figures.values())) > 10
    assert repeats_of(figures) == {}


@pytest.mark.full
def test_expanded_details_and_all_columns_repeat_figures(interpreted) -> None:
    """The test above finds figures that are shown twice."""
    interpreted.studio.selection.set(["B04"])
    interpreted.studio.settings.hidden_columns = []
    interpreted.studio.keep_settings()
    interpreted.properties._fit.details.setChecked(True)
    figures = figures_of_pages(interpreted, ["properties", "table"])
    assert len(repeats_of(figures)["properties", "table"]) > 3
