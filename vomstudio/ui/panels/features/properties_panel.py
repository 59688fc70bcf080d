"""Panel with the attributes, figures and reasons of the selected feature or model."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from html import escape
from itertools import repeat
from typing import Any, Literal

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
from vomstudio.project.kinds import ATTRIBUTES, get_kind
from vomstudio.project.records import (
    Feature,
    FeatureType,
    Model,
    Record,
    TypedFeature,
    get_feature,
)
from vomstudio.ui.base.controls import (
    ComboBox,
    Label,
    PanelScrollArea,
    rich_label,
    rich_lines,
    set_enabled,
)
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.features import plane_relations
from vomstudio.ui.panels.features.parallel_traces import describe_parallel_beds
from vomstudio.ui.panels.features.straight_trace import describe_crossing, describe_trace_band
from vomstudio.ui.widgets.fit_view import FitView
from vomstudio.ui.widgets.notes_field import NotesField
from vomstudio.ui.widgets.plane_box import PlaneBox
from vomstudio.ui.widgets.type_box import TypeBox


class PropertiesPanel(QWidget):
    """Panel that shows the selection and edits its attributes; each change is one edit."""

    def __init__(
        self, studio: Studio, actions: Mapping[str, QAction], keep_action: QAction
    ) -> None:
        super().__init__()
        self._studio = studio
        self._shown_ids: list[str] = []
        self._empty_label = Label(tr("Select a feature in the outcrop, table, tree or stereonet."))
        self._empty_label.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._empty_label.setWordWrap(True)
        self._empty_label.setForegroundRole(QPalette.ColorRole.PlaceholderText)
        self._stack = QStackedLayout(self)
        self._stack.addWidget(self._empty_label)
        self._stack.addWidget(PanelScrollArea(self._create_feature_page(actions, keep_action)))
        self._stack.addWidget(PanelScrollArea(self._create_model_page(actions["declare_frame"])))
        studio.selection_changed.connect(self.refresh)
        studio.edited.connect(self.refresh)
        studio.project_opened.connect(self.refresh)
        studio.settings_changed.connect(self.refresh)
        studio.model_loaded.connect(self.refresh)

    def _create_feature_page(self, actions: Mapping[str, QAction], keep_action: QAction) -> QWidget:
        page = QWidget()
        self._count_label = Label()
        self._count_label.setObjectName("several_selected")
        self._count_label.setWordWrap(True)
        self._fit = FitView(actions)
        self._description_label = Label()
        self._description_label.setWordWrap(True)
        self._description_label.setTextInteractionFlags(
            Qt.TextInteractionFlag.TextSelectableByMouse
        )
        self._relation_label = rich_label()
        self._relation_label.setWordWrap(True)
        self._relation_label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._keep_button = QPushButton(keep_action.text().replace("&", ""))
        self._keep_button.setIcon(keep_action.icon())
        self._keep_button.clicked.connect(keep_action.trigger)
        self._form = form = QFormLayout()
        form.setContentsMargins(0, 0, 0, 0)
        form.setVerticalSpacing(3)
        self.fields = {attribute.field: self._create_field(attribute) for attribute in ATTRIBUTES}
        self.rename = QPushButton()
        self.rename.setObjectName("rename_by_type")
        self.rename.clicked.connect(self._rename)
        for attribute in ATTRIBUTES:
            form.addRow(tr(attribute.title), self.fields[attribute.field])
            if attribute.field == "name":
                form.addRow(self.rename)
        layout = QVBoxLayout(page)
        layout.setContentsMargins(6, 4, 6, 4)
        layout.addWidget(self._count_label)
        layout.addWidget(self._relation_label)
        layout.addWidget(self._keep_button)
        layout.addWidget(self._fit)
        layout.addWidget(self._description_label)
        layout.addLayout(form)
        layout.addStretch()
        return page

    def _create_field(self, attribute: Attribute) -> QWidget:
        """Create the widget that edits an attribute."""
        name = attribute.field
        if attribute.form == "type":
            type_box = TypeBox(self._studio)
            type_box.activated.connect(lambda _: self._change(**{name: type_box.currentData()}))
            return type_box
        if attribute.form == "flag":
            check_box = QCheckBox(tr(attribute.text))
            check_box.clicked.connect(lambda is_checked: self._change(**{name: bool(is_checked)}))
            return check_box
        if attribute.form in ("choice", "word"):
            box = ComboBox()
            for value, text in attribute.choices:
                box.addItem(tr(text), value)
            if len(attribute.choices) > 2:
                box.keep_narrow()
            box.activated.connect(lambda _: self._change(**{name: box.currentData()}))
            return box
        if attribute.form == "plane":
            plane_box = PlaneBox(self._studio, tr("none"), includes_selection=False)
            plane_box.plane_selected.connect(lambda id_: self._set_plane(name, id_))
            return plane_box
        if attribute.form == "lines":
            notes_field = NotesField()
            notes_field.finished.connect(self._apply_typed_text)
            return notes_field
        line_edit = QLineEdit()
        line_edit.editingFinished.connect(self._apply_typed_text)
        return line_edit

    def _create_model_page(self, declare_action: QAction) -> QWidget:
        page = QWidget()
        self._model_label = rich_label()
        self._model_label.setWordWrap(True)
        self._model_label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        button = QPushButton(tr("Declare frame…"))
        button.clicked.connect(declare_action.trigger)
        layout = QVBoxLayout(page)
        layout.setContentsMargins(6, 4, 6, 4)
        layout.addWidget(self._model_label)
        layout.addWidget(button)
        layout.addStretch()
        return page

    def _selected_features(self) -> list[Feature]:
        return self._studio.session.records.select(self._studio.selection.ids, Feature)

    def _apply_typed_text(self) -> bool:
        """Apply typed text to the features that were displayed when it was typed.

        Returns
        -------
        bool
            Whether any field was changed.
        """
        is_changed = False
        for name, field in self.fields.items():
            if isinstance(field, QLineEdit | NotesField) and field.isModified():
                field.setModified(False)
                text = field.text().strip()
                if isinstance(field, NotesField) and not text and field.placeholderText():
                    # An empty line does not delete the different notes of several features.
                    continue
                self._change(**{name: text})
                is_changed = True
        return is_changed

    def _change(self, **values: object) -> None:
        ids = self._shown_ids[-1:] if "name" in values else self._shown_ids
        ids = [
            i
            for i in ids
            if (feature := get_feature(self._studio.records, i)) is not None
            and any(hasattr(feature, k) and getattr(feature, k) != v for k, v in values.items())
        ]
        if not ids or not self._studio.attempt(edits.set_attributes, ids, **values):
            self.refresh()

    def refresh(self, *_: object) -> None:
        """Show the current state of the selected feature or model."""
        features = self._selected_features()
        # The selection may change before the field loses focus.
        if self._shown_ids != [f.id for f in features] and self._apply_typed_text():
            features = self._selected_features()
        self._shown_ids = [f.id for f in features]
        current_id = self._studio.selection.current
        record = self._studio.records.get(current_id) if current_id else None
        feature = get_feature(self._studio.records, current_id)
        if feature is not None:
            self._show_feature(feature, features)
            self._stack.setCurrentIndex(1)
        elif isinstance(record, Model):
            self._show_model(record)
            self._stack.setCurrentIndex(2)
        else:
            self._stack.setCurrentIndex(0)

    def _set_plane(self, field: str, plane_id: str) -> None:
        """Set the plane that contains the selected lines; removing it clears the sense of slip."""
        records = self._studio.records
        has_slip = any(hasattr(records.get(id_), "slip") for id_ in self._shown_ids)
        self._change(**{field: plane_id}, **({"slip": ""} if has_slip and not plane_id else {}))

    def _show_relation(self) -> None:
        """Show the relation of two selected planes and the distances between parallel beds."""
        intersection = plane_relations.selected_intersection(self._studio)
        bed_lines = describe_parallel_beds(self._studio)
        self._relation_label.setVisible(intersection is not None or bool(bed_lines))
        self._keep_button.setVisible(intersection is not None)
        if intersection is None:
            self._relation_label.setText("<br>".join(bed_lines))
            return
        first_name, second_name = (self._studio.records[i].name for i in self._studio.selection.ids)
        names = tr("{first} and {second}", first=first_name, second=second_name)
        measurement = self._studio.measure(intersection)
        lines = [
            *plane_relations.format_relation(measurement),
            *describe_crossing(self._studio),
            *bed_lines,
        ]
        self._relation_label.setText("<br>".join([f"<b>{escape(names)}</b>", *lines]))
        set_enabled(self._keep_button, plane_relations.line_problem(measurement))

    def _show_feature(self, feature: Feature, features: list[Feature]) -> None:
        """Show the current feature, and which attributes differ among the selected features."""
        self._show_relation()
        measurement = self._studio.measured([feature.id])[feature.id]
        feature_kind = get_kind(feature)
        self._show_count(feature)
        attributes = {attribute.field: attribute for attribute in feature_kind.attributes}
        for name, widget in self.fields.items():
            attribute = attributes.get(name)
            self._form.setRowVisible(widget, attribute is not None and attribute.applies(feature))
            label = self._form.labelForField(widget)
            if attribute is not None and isinstance(label, QLabel):
                label.setText(tr(attribute.title))
            if not hasattr(feature, name):
                continue
            if isinstance(widget, TypeBox):
                widget.set_geometry(_common_geometry(features))
            if _has_different_values(features, name):
                _show_mixed_value(widget)
            else:
                _show_value(widget, getattr(feature, name))
        self._show_rename(features)
        lines = [
            *describe_trace_band(self._studio, feature.id, measurement),
            *feature_kind.about(self._studio.subject(feature, measurement)),
        ]
        self._description_label.setVisible(bool(lines))
        self._description_label.setText("\n".join(lines))
        # This call lays out the panel, so it must come last.
        self._fit.show_measurement(
            measurement, self._studio.settings.notation, is_local=not self._studio.is_north_known()
        )

    def _show_rename(self, features: list[Feature]) -> None:
        """Offer to rename features that have the automatic name of another type."""
        records = self._studio.records
        misnamed_features = edits.find_misnamed_features(records, features)
        self._form.setRowVisible(self.rename, bool(misnamed_features))
        if len(misnamed_features) == 1 and isinstance(misnamed_features[0], TypedFeature):
            feature_type = records[misnamed_features[0].type_id]
            assert isinstance(feature_type, FeatureType)
            name = edits.next_name(self._studio.session.records, feature_type)
            self.rename.setText(tr("Rename to {name}", name=name))
        else:
            self.rename.setText(tr("Rename {count} features", count=len(misnamed_features)))

    def _rename(self) -> None:
        self._studio.attempt(edits.rename_by_type, list(self._shown_ids))

    def _show_count(self, current_feature: Feature) -> None:
        count = len(self._shown_ids)
        self._count_label.setVisible(count > 1)
        self._count_label.setText(
            Finding("features.several-selected", n=count, name=current_feature.name).message
        )
        name = self.fields["name"]
        set_enabled(name, Finding("action.several-features") if count > 1 else None)

    def _show_model(self, model: Model) -> None:
        lines, bold_lines = [model.name, model.path], [model.name]
        open_model = self._studio.models.get(model.id)
        if open_model is None:
            lines.append(tr("The file is not open."))
        elif isinstance(open_model.data, Mesh):
            textures = sum(m.texture is not None for m in open_model.data.materials)
            lines.append(
                tr_n(
                    "Mesh: {triangles:,} triangles, {vertices:,} vertices, {count} texture",
                    "Mesh: {triangles:,} triangles, {vertices:,} vertices, {count} textures",
                    textures,
                    triangles=len(open_model.data.faces),
                    vertices=len(open_model.data.vertices),
                )
            )
        else:
            lines.append(tr("Point cloud: {count:,} points", count=open_model.data.count))
            if isinstance(open_model.data, StreamedCloud):
                lines.append(
                    tr("Streamed: measurements use the points that are loaded for the view.")
                )
        from vomstudio.registration.summary import placement_facts, summarize_registration

        lines.append(tr("Frame: {frame}", frame=model.frame.name()))
        facts = placement_facts(model, None if open_model is None else open_model.resolution)
        lines += [f"{name}: {value}" for name, value in facts]
        if model.registration is not None:
            summary = summarize_registration(model.registration)
            lines += [f"{fact.name}: {fact.text}" for fact in summary.facts]
            if summary.rotation is not None:
                lines.append(summary.rotation.message)
                bold_lines.append(summary.rotation.message)
            lines += [f"• {warning}" for warning in summary.warnings]
        if open_model is not None:
            lines += map(str, open_model.warnings)
        self._model_label.setText(rich_lines(lines, bold_lines))


def _common_geometry(records: Iterable[Record | None]) -> Literal["plane", "line"] | None:
    """Return the type geometry that all typed features require, or None if there is none."""
    first_records = {type(record): record for record in records}.values()
    kinds = [get_kind(record) for record in first_records if isinstance(record, TypedFeature)]
    geometries = {kind.type_geometry for kind in kinds}
    return geometries.pop() if len(geometries) == 1 else None


def _has_different_values(records: Iterable[Record | None], name: str) -> bool:
    """Return whether the records that have an attribute differ in its value."""
    # A loop over thousands of records would take longer than everything else.
    return len(set(map(getattr, records, repeat(name), repeat(None))) - {None}) > 1


def _show_mixed_value(widget: QWidget) -> None:
    """Show in a widget that the selected features have different values."""
    text = tr("(several)")
    if isinstance(widget, QCheckBox):
        widget.setTristate(True)
        widget.setCheckState(Qt.CheckState.PartiallyChecked)
    elif isinstance(widget, ComboBox):
        widget.show_text(text)
    elif isinstance(widget, QLineEdit | NotesField):
        widget.setPlaceholderText(text)
        # After clear() the field would be flagged as modified by the user.
        widget.setText("")


def _show_value(widget: QWidget, value: Any) -> None:
    """Show the value of an attribute in its widget."""
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
    elif isinstance(widget, QLineEdit | NotesField):
        widget.setPlaceholderText("")
        widget.setText(value)
