"""The selected feature or model: its attributes to edit, its figures and reasons to read."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from typing import Any

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QPalette
from PySide6.QtWidgets import (
    QCheckBox,
    QFormLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QStackedLayout,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr, tr_n
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.streaming.octree import StreamedCloud
from vomstudio.project import edits
from vomstudio.project.kind import Attribute
from vomstudio.project.kinds import ATTRIBUTES, kind_of
from vomstudio.project.records import Feature, Model, Record, get_feature
from vomstudio.ui.base.controls import (
    ComboBox,
    Label,
    PanelScrollArea,
    allow,
    rich_label,
    rich_lines,
)
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.features import plane_relations
from vomstudio.ui.panels.features.parallel_traces import parallel_lines
from vomstudio.ui.panels.features.straight_trace import band_lines, crossing_lines
from vomstudio.ui.widgets.fit_view import FitView
from vomstudio.ui.widgets.plane_box import PlaneBox
from vomstudio.ui.widgets.type_box import TypeBox


class PropertiesPanel(QWidget):
    """Follows the selection; every change is an edit of its own."""

    def __init__(self, studio: Studio, declare: QAction, keep: QAction) -> None:
        super().__init__()
        self._studio = studio
        self._shown: list[str] = []
        self._nothing = Label(tr("Select a feature in the outcrop, table, tree or stereonet."))
        self._nothing.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._nothing.setWordWrap(True)
        self._nothing.setForegroundRole(QPalette.ColorRole.PlaceholderText)
        self._stack = QStackedLayout(self)
        self._stack.addWidget(self._nothing)
        self._stack.addWidget(PanelScrollArea(self._make_feature(keep)))
        self._stack.addWidget(PanelScrollArea(self._make_model(declare)))
        studio.selection_changed.connect(self.refresh)
        studio.edited.connect(self.refresh)
        studio.project_opened.connect(self.refresh)
        studio.settings_changed.connect(self.refresh)
        studio.model_loaded.connect(self.refresh)

    def _make_feature(self, keep: QAction) -> QWidget:
        page = QWidget()
        self._several = Label()
        self._several.setObjectName("several_selected")
        self._several.setWordWrap(True)
        self._fit = FitView()
        self._about = Label()
        self._about.setWordWrap(True)
        self._about.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._relation = rich_label()
        self._relation.setWordWrap(True)
        self._relation.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._keep = QPushButton(keep.text().replace("&", ""))
        self._keep.setIcon(keep.icon())
        self._keep.clicked.connect(keep.trigger)
        self._form = form = QFormLayout()
        form.setContentsMargins(0, 0, 0, 0)
        form.setVerticalSpacing(3)
        self.fields = {each.field: self._field(each) for each in ATTRIBUTES}
        for each in ATTRIBUTES:
            form.addRow(tr(each.title), self.fields[each.field])
        layout = QVBoxLayout(page)
        layout.setContentsMargins(6, 4, 6, 4)
        layout.addWidget(self._several)
        layout.addWidget(self._relation)
        layout.addWidget(self._keep)
        layout.addWidget(self._fit)
        layout.addWidget(self._about)
        layout.addLayout(form)
        layout.addStretch()
        return page

    def _field(self, attribute: Attribute) -> QWidget:
        """The widget in which an attribute is changed."""
        name = attribute.field
        if attribute.form == "type":
            types = TypeBox(self._studio)
            types.activated.connect(lambda _: self._change(**{name: types.currentData()}))
            return types
        if attribute.form == "flag":
            flag = QCheckBox(tr(attribute.text))
            flag.clicked.connect(lambda on: self._change(**{name: bool(on)}))
            return flag
        if attribute.form in ("choice", "word"):
            box = ComboBox()
            for value, text in attribute.choices:
                box.addItem(tr(text), value)
            if len(attribute.choices) > 2:
                box.keep_narrow()
            box.activated.connect(lambda _: self._change(**{name: box.currentData()}))
            return box
        if attribute.form == "plane":
            planes = PlaneBox(self._studio, tr("none"), follows_selection=False)
            planes.plane_selected.connect(lambda id_: self._set_plane(name, id_))
            return planes
        line = QLineEdit()
        line.editingFinished.connect(self._typed)
        return line

    def _make_model(self, declare: QAction) -> QWidget:
        page = QWidget()
        self._model = rich_label()
        self._model.setWordWrap(True)
        self._model.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        button = QPushButton(tr("Declare frame…"))
        button.clicked.connect(declare.trigger)
        layout = QVBoxLayout(page)
        layout.setContentsMargins(6, 4, 6, 4)
        layout.addWidget(self._model)
        layout.addWidget(button)
        layout.addStretch()
        return page

    def _chosen(self) -> list[str]:
        records = self._studio.records
        return [i for i in self._studio.selection.ids if get_feature(records, i) is not None]

    def _typed(self) -> bool:
        """Apply what has been typed to the features that were shown while it was typed; False where
        nothing has been."""
        typed = False
        for name, field in self.fields.items():
            if isinstance(field, QLineEdit) and field.isModified():
                field.setModified(False)
                self._change(**{name: field.text().strip()})
                typed = True
        return typed

    def _change(self, **values: object) -> None:
        ids = self._shown[-1:] if "name" in values else self._shown
        ids = [
            i
            for i in ids
            if (feature := get_feature(self._studio.records, i)) is not None
            and any(hasattr(feature, k) and getattr(feature, k) != v for k, v in values.items())
        ]
        if not ids or not self._studio.attempt(edits.set_attributes, ids, **values):
            self.refresh()

    def refresh(self, *_: object) -> None:
        """Show the selected feature or model as it is now."""
        chosen = self._chosen()
        # The selection may move before the field loses the keyboard.
        if self._shown != chosen and self._typed():
            chosen = self._chosen()
        self._shown = chosen
        current = self._studio.selection.current
        record = self._studio.records.get(current) if current else None
        feature = get_feature(self._studio.records, current)
        if feature is not None:
            self._show_feature(feature)
            self._stack.setCurrentIndex(1)
        elif isinstance(record, Model):
            self._show_model(record)
            self._stack.setCurrentIndex(2)
        else:
            self._stack.setCurrentIndex(0)

    def _set_plane(self, field: str, plane_id: str) -> None:
        """Lines without a plane have no sense of slip."""
        records = self._studio.records
        slips = any(hasattr(records.get(id_), "slip") for id_ in self._shown)
        self._change(**{field: plane_id}, **({"slip": ""} if slips and not plane_id else {}))

    def _show_relation(self) -> None:
        """Of two selected planes; of traces of one type as parallel beds."""
        relation = plane_relations.of_selected(self._studio)
        parallel = parallel_lines(self._studio)
        self._relation.setVisible(relation is not None or bool(parallel))
        self._keep.setVisible(relation is not None)
        if relation is None:
            self._relation.setText("<br>".join(parallel))
            return
        first, second = (self._studio.records[i].name for i in self._studio.selection.ids)
        names = tr("{first} and {second}", first=first, second=second)
        measured = self._studio.measure(relation)
        lines = [
            *plane_relations.relation_lines(measured),
            *crossing_lines(self._studio),
            *parallel,
        ]
        self._relation.setText("<br>".join([f"<b>{escape(names)}</b>", *lines]))
        allow(self._keep, plane_relations.why_no_line(measured))

    def _show_feature(self, feature: Feature) -> None:
        self._show_relation()
        measured = self._studio.measured([feature.id])[feature.id]
        kind = kind_of(feature)
        self._show_count(feature)
        own = {attribute.field: attribute for attribute in kind.attributes}
        shown = [self._studio.records.get(id_) for id_ in self._shown]
        for name, widget in self.fields.items():
            attribute = own.get(name)
            self._form.setRowVisible(widget, attribute is not None and attribute.applies(feature))
            label = self._form.labelForField(widget)
            if attribute is not None and isinstance(label, QLabel):
                label.setText(tr(attribute.title))
            if not hasattr(feature, name):
                continue
            if _differ(shown, name):
                _show_several(widget)
            else:
                _show(widget, getattr(feature, name))
        lines = [
            *band_lines(self._studio, feature.id, measured),
            *kind.about(self._studio.subject(feature, measured)),
        ]
        self._about.setVisible(bool(lines))
        self._about.setText("\n".join(lines))
        # Last, since it has the panel laid out.
        self._fit.show_measurement(
            measured, self._studio.settings.notation, local=not self._studio.north_known()
        )

    def _show_count(self, current: Feature) -> None:
        count = len(self._shown)
        self._several.setVisible(count > 1)
        self._several.setText(
            tr(
                "{count} features are selected: a change here changes all of them. The figures are "
                "those of {name}.",
                count=count,
                name=current.name,
            )
        )
        name = self.fields["name"]
        allow(name, Finding("action.several-features") if count > 1 else None)

    def _show_model(self, model: Model) -> None:
        lines, bold = [model.name, model.path], [model.name]
        opened = self._studio.models.get(model.id)
        if opened is None:
            lines.append(tr("The file is not open."))
        elif isinstance(opened.data, Mesh):
            textures = sum(m.texture is not None for m in opened.data.materials)
            lines.append(
                tr_n(
                    "Mesh: {triangles:,} triangles, {vertices:,} vertices, {count} texture",
                    "Mesh: {triangles:,} triangles, {vertices:,} vertices, {count} textures",
                    textures,
                    triangles=len(opened.data.faces),
                    vertices=len(opened.data.vertices),
                )
            )
        else:
            lines.append(tr("Point cloud: {count:,} points", count=opened.data.count))
            if isinstance(opened.data, StreamedCloud):
                lines.append(
                    tr("Streamed: measurements use the points that are loaded for the view.")
                )
        from vomstudio.registration.summary import placement_facts, summary_of

        lines.append(tr("Frame: {frame}", frame=model.frame.name()))
        facts = placement_facts(model, None if opened is None else opened.resolution)
        lines += [f"{name}: {value}" for name, value in facts]
        if model.registration is not None:
            told = summary_of(model.registration)
            lines += [f"{name}: {value}" for name, value in told.facts]
            lines += [told.sentence] if told.sentence else []
            bold.append(told.sentence)
            lines += [f"• {said}" for said in told.warnings]
        if opened is not None:
            lines += map(str, opened.warnings)
        self._model.setText(rich_lines(lines, bold))


def _differ(records: Iterable[Record | None], name: str) -> bool:
    """Whether those that have an attribute have different values of it."""
    return len({getattr(record, name, None) for record in records} - {None}) > 1


def _show_several(widget: QWidget) -> None:
    """That the selected features have different values."""
    several = tr("(several)")
    if isinstance(widget, QCheckBox):
        widget.setTristate(True)
        widget.setCheckState(Qt.CheckState.PartiallyChecked)
    elif isinstance(widget, ComboBox):
        widget.show_text(several)
    elif isinstance(widget, QLineEdit):
        widget.setPlaceholderText(several)
        # Not by clear(), after which the field counts as typed in by the user.
        widget.setText("")


def _show(widget: QWidget, value: Any) -> None:
    """The value of an attribute in its widget."""
    if isinstance(widget, TypeBox):
        widget.select_type(value)
    elif isinstance(widget, PlaneBox):
        widget.show_plane(value)
    elif isinstance(widget, ComboBox):
        widget.setCurrentIndex(widget.findData(value))
        if widget.currentIndex() < 0 and value:
            widget.show_text(str(value))
    elif isinstance(widget, QCheckBox):
        widget.setTristate(False)
        widget.setChecked(value)
    elif isinstance(widget, QLineEdit):
        widget.setPlaceholderText("")
        widget.setText(value)
