"""Names in a project of somebody else are words: Qt takes none for HTML, in which it would fetch
pictures from wherever they are said to be."""

from __future__ import annotations

import os
import re
from dataclasses import replace
from pathlib import Path

import pytest
from PySide6.QtCore import QModelIndex, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QLabel, QTableView, QTreeView, QWidget

from tests.driver import close, make_window, wait
from tests.fuzz.projects import specimen
from vomstudio.project import edits
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.records import Feature, FeatureType, Model
from vomstudio.ui.base.controls import Label, escape_markup, rich_label, rich_lines

SOURCES = Path(__file__).parents[2] / "vomstudio" / "ui"
HTML = re.compile(r"<\s*(img|b)\b")


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """With a name that Qt would wait for without end, had it to fetch the picture."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    name = f'<img src="{pipe}">'
    folder = specimen(tmp_path)
    opened = ProjectFolder.open(folder)
    session = opened.session
    for feature in session.of(Feature):
        words = {"name": f"{feature.name} {name}", "notes": name, "set_name": name}
        known = {key: value for key, value in words.items() if hasattr(feature, key)}
        session.apply(edits.set_attributes(session.records, [feature.id], **known))
    for model in session.of(Model):
        named = replace(model, name=name, path=f"/nowhere/{name}")
        session.apply(edits.Edit("names", {model.id: model}, {model.id: named}))
    for kind in session.of(FeatureType):
        named_kind = replace(kind, name=f"{kind.name} {name}")
        session.apply(edits.Edit("names", {kind.id: kind}, {kind.id: named_kind}))
    session.save()
    opened.close()
    return folder


@pytest.mark.full
def test_record_names_are_shown_as_plain_text(project: Path, qtbot) -> None:  # type: ignore[no-untyped-def]
    window = make_window([project])
    try:
        wait(lambda: window.studio.session.of(Feature), "the features")
        studio = window.studio
        shown = 0
        for record in studio.session.of(Feature):
            studio.selection.set((record.id,))
            qtbot.wait(1)
            assert odd_texts(window) == []
            shown += sum("<img" in label.text() for label in window.findChildren(QLabel))
        assert shown, "the names are to be seen"
        assert odd_texts(window) == []
    finally:
        # The specimen has an unfinished trace.
        window.studio.cancel_tool()
        window.studio.session.save()
        close(window)


def odd_texts(window: QWidget) -> list[str]:
    """What Qt would take for HTML, of labels, tooltips and cells."""
    found = []
    for label in window.findChildren(QLabel):
        plain = label.textFormat() == Qt.TextFormat.PlainText
        rich = label.textFormat() == Qt.TextFormat.RichText
        if "<img" in label.text() and (rich or not plain):
            found.append(label.text())
    found += [w.toolTip() for w in window.findChildren(QWidget) if "<img" in w.toolTip()]
    found += [a.toolTip() for a in window.findChildren(QAction) if "<img" in a.toolTip()]
    for view in [*window.findChildren(QTreeView), *window.findChildren(QTableView)]:
        model = view.model()
        for index in [] if model is None else all_of(model, QModelIndex()):
            tip = model.data(index, Qt.ItemDataRole.ToolTipRole)
            found += [tip] if isinstance(tip, str) and "<img" in tip else []
    return found


def all_of(model, parent):  # type: ignore[no-untyped-def]
    for row in range(model.rowCount(parent)):
        for column in range(model.columnCount(parent)):
            yield model.index(row, column, parent)
        yield from all_of(model, model.index(row, 0, parent))


def test_labels_are_made_by_one_class() -> None:
    """`Label`: Qt's own decides by the text whether it is HTML."""
    made = [
        path.relative_to(SOURCES).as_posix()
        for path in SOURCES.rglob("*.py")
        if re.search(r"\bQLabel\(", path.read_text("utf-8"))
    ]
    assert made == []


def test_markup_in_names_is_escaped(qtbot) -> None:  # type: ignore[no-untyped-def]
    name = '<img src="/dev/zero">'
    label = Label(name)
    qtbot.addWidget(label)
    assert label.text() == name
    assert label.textFormat() == Qt.TextFormat.PlainText
    assert escape_markup(name).replace("\N{WORD JOINER}", "") == name
    assert not HTML.search(escape_markup(name))
    bold = rich_label(rich_lines([name, "a < b"], [name]))
    qtbot.addWidget(bold)
    escaped = "&lt;img src=&quot;/dev/zero&quot;&gt;"
    assert bold.text() == f"<b>{escaped}</b><br>a &lt; b"
