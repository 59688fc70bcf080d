"""What is selected: what can be changed, and the figures and reasons to be read."""

from __future__ import annotations

from html import escape

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QPalette
from PySide6.QtWidgets import (
    QCheckBox,
    QFormLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QScrollArea,
    QStackedLayout,
    QVBoxLayout,
    QWidget,
)

from vomstudio.document import edits
from vomstudio.document.records import (
    FEATURES,
    TYPED,
    Dimension,
    Feature,
    Lineation,
    Model,
    Reading,
    Trace,
)
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.streaming.octree import StreamedCloud
from vomstudio.ui.common.fit_view import FitView
from vomstudio.ui.common.plane_box import PlaneBox
from vomstudio.ui.common.studio import Studio
from vomstudio.ui.common.type_box import TypeBox
from vomstudio.ui.common.widgets import ComboBox
from vomstudio.ui.common.wording import length, slip_names
from vomstudio.ui.interpret import relations


class PropertiesPanel(QWidget):
    def __init__(self, studio: Studio, declare: QAction, keep: QAction) -> None:
        super().__init__()
        self._studio = studio
        self._shown: list[str] = []
        self._nothing = QLabel(self.tr("Select a plane in the outcrop, table, tree or net."))
        self._nothing.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._nothing.setWordWrap(True)
        self._nothing.setForegroundRole(QPalette.ColorRole.PlaceholderText)
        self._stack = QStackedLayout(self)
        self._stack.addWidget(self._nothing)
        self._stack.addWidget(_scrolled(self._make_feature(keep)))
        self._stack.addWidget(_scrolled(self._make_model(declare)))
        studio.selection_changed.connect(self.refresh)
        studio.edited.connect(self.refresh)
        studio.project_opened.connect(self.refresh)
        studio.settings_changed.connect(self.refresh)
        studio.model_loaded.connect(self.refresh)

    def _make_feature(self, keep: QAction) -> QWidget:
        page = QWidget()
        self._name = QLineEdit()
        self._name.editingFinished.connect(self._typed)
        self._type = TypeBox(self._studio)
        self._type.activated.connect(lambda _: self._change(type_id=self._type.currentData()))
        self._set = QLineEdit()
        self._set.editingFinished.connect(self._typed)
        self._overturned = QCheckBox(self.tr("overturned"))
        self._overturned.clicked.connect(lambda on: self._change(overturned=bool(on)))
        self._method = ComboBox()
        self._method.addItem(self.tr("moment of inertia (PCA)"), "pca")
        self._method.addItem(self.tr("planar regression of Z"), "regression")
        self._method.activated.connect(lambda _: self._change(method=self._method.currentData()))
        self._notes = QLineEdit()
        self._notes.editingFinished.connect(self._typed)
        self._compass = QLabel()
        self._compass.setWordWrap(True)
        self._compass.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._fields = {"name": self._name, "set_name": self._set, "notes": self._notes}
        self._fit = FitView()
        self._slip = ComboBox()
        for value, text in slip_names().items():
            self._slip.addItem(text, value)
        self._slip.keep_narrow()
        self._slip.activated.connect(lambda _: self._change(slip=self._slip.currentData()))
        self._plane = PlaneBox(self._studio, self.tr("none"), follow=False)
        self._plane.chosen.connect(self._lay_on)
        self._relation = QLabel()
        self._relation.setWordWrap(True)
        self._relation.setTextFormat(Qt.TextFormat.RichText)
        self._relation.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._keep = QPushButton(keep.text().replace("&", ""))
        self._keep.setIcon(keep.icon())
        self._keep.clicked.connect(keep.trigger)
        self._form = form = QFormLayout()
        form.setContentsMargins(0, 0, 0, 0)
        form.setVerticalSpacing(3)
        form.addRow(self.tr("Name"), self._name)
        form.addRow(self.tr("Type"), self._type)
        form.addRow(self.tr("Set"), self._set)
        form.addRow(self.tr("Bed"), self._overturned)
        form.addRow(self.tr("Fit"), self._method)
        form.addRow(self.tr("On plane"), self._plane)
        form.addRow(self.tr("Slip"), self._slip)
        form.addRow(self.tr("Notes"), self._notes)
        layout = QVBoxLayout(page)
        layout.setContentsMargins(6, 4, 6, 4)
        layout.addWidget(self._relation)
        layout.addWidget(self._keep)
        layout.addWidget(self._fit)
        layout.addWidget(self._compass)
        layout.addLayout(form)
        layout.addStretch()
        return page

    def _make_model(self, declare: QAction) -> QWidget:
        page = QWidget()
        self._model = QLabel()
        self._model.setWordWrap(True)
        self._model.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        button = QPushButton(self.tr("Declare frame…"))
        button.clicked.connect(declare.trigger)
        layout = QVBoxLayout(page)
        layout.setContentsMargins(6, 4, 6, 4)
        layout.addWidget(self._model)
        layout.addWidget(button)
        layout.addStretch()
        return page

    def _chosen(self) -> list[str]:
        return [
            i
            for i in self._studio.selection.ids
            if isinstance(self._studio.records.get(i), FEATURES)
        ]

    def _typed(self) -> None:
        """Keep what has been typed, for the planes that were shown while it was typed."""
        for name, field in self._fields.items():
            if field.isModified():
                field.setModified(False)
                self._change(**{name: field.text().strip()})

    def _change(self, **values: object) -> None:
        ids = self._shown[-1:] if "name" in values else self._shown
        ids = [
            i
            for i in ids
            if isinstance(feature := self._studio.records.get(i), FEATURES)
            and any(hasattr(feature, k) and getattr(feature, k) != v for k, v in values.items())
        ]
        if not ids or not self._studio.attempt(edits.set_attributes, ids, **values):
            self.refresh()

    def refresh(self, *_: object) -> None:
        if self._shown != self._chosen():
            # The selection may move before the field loses the keyboard.
            self._typed()
        self._shown = self._chosen()
        current = self._studio.selection.current
        record = self._studio.records.get(current) if current else None
        if isinstance(record, FEATURES):
            self._show_feature(record)
            self._stack.setCurrentIndex(1)
        elif isinstance(record, Model):
            self._show_model(record)
            self._stack.setCurrentIndex(2)
        else:
            self._stack.setCurrentIndex(0)

    def _lay_on(self, plane_id: str) -> None:
        """Lines without a plane have no sense of slip."""
        self._change(plane_id=plane_id, **({} if plane_id else {"slip": ""}))

    def _show_relation(self) -> None:
        """Of two selected planes."""
        relation = relations.of_selected(self._studio)
        self._relation.setVisible(relation is not None)
        self._keep.setVisible(relation is not None)
        if relation is None:
            return
        names = " and ".join(self._studio.records[i].name for i in self._studio.selection.ids)
        measured = self._studio.measure(relation)
        self._relation.setText("<br>".join([f"<b>{escape(names)}</b>", *relations.words(measured)]))
        self._keep.setEnabled(measured.line is not None)

    def _show_feature(self, feature: Feature) -> None:
        self._show_relation()
        measured = self._studio.measured([feature.id])[feature.id]
        self._fit.show_measurement(
            measured, self._studio.settings.notation, local=not self._studio.north_known()
        )
        for name, widget in (
            ("type_id", self._type),
            ("set_name", self._set),
            ("overturned", self._overturned),
            ("method", self._method),
            ("plane_id", self._plane),
            ("slip", self._slip),
        ):
            self._form.setRowVisible(widget, hasattr(feature, name))
        if isinstance(feature, Lineation | Dimension):
            self._plane.show_plane(feature.plane_id)
        label = self._form.labelForField(self._plane)
        if isinstance(label, QLabel):
            across = isinstance(feature, Dimension)
            label.setText(self.tr("Across") if across else self.tr("On plane"))
        if isinstance(feature, Dimension):
            self._form.setRowVisible(self._plane, feature.kind == "thickness")
        if isinstance(feature, Lineation):
            self._form.setRowVisible(self._slip, bool(feature.plane_id))
            self._slip.setCurrentIndex(self._slip.findData(feature.slip))
        self._compass.setVisible(isinstance(feature, Reading))
        if isinstance(feature, Reading):
            self._compass.setText("\n".join(self._of_reading(feature)))
        if isinstance(feature, TYPED):
            self._type.choose(feature.type_id)
        for name, field in self._fields.items():
            field.setText(getattr(feature, name, ""))
        self._overturned.setChecked(getattr(feature, "overturned", False))
        if isinstance(feature, Trace):
            self._method.setCurrentIndex(self._method.findData(feature.method))

    def _of_reading(self, reading: Reading) -> list[str]:
        lines = [f"Compass reading, {self._studio.nearest_text(reading.id)}"]
        if reading.turned_deg:
            lines.append(f"Azimuth as read {reading.turned_deg:+.2f}° (to grid north)")
        if reading.source:
            lines.append(f"From {reading.source}")
        return lines

    def _show_model(self, model: Model) -> None:
        lines = [f"<b>{model.name}</b>", model.path]
        opened = self._studio.models.get(model.id)
        if opened is None:
            lines.append("The file is not open.")
        elif isinstance(opened.data, Mesh):
            textures = sum(m.texture is not None for m in opened.data.materials)
            lines.append(
                f"Mesh: {len(opened.data.faces):,} triangles, {len(opened.data.vertices):,} "
                f"vertices, {textures} texture{'s' if textures != 1 else ''}"
            )
        else:
            lines.append(f"Point cloud: {opened.data.count:,} points")
            if isinstance(opened.data, StreamedCloud):
                lines.append("Read as it is looked at: measured on what is loaded for the view.")
        if opened is not None and opened.resolution:
            spacing = opened.resolution * model.frame.unit_m
            lines.append(f"Resolution: {length(spacing, metric=model.frame.has_metres)}")
        lines.append(f"Frame: {model.frame.name()}")
        if opened is not None:
            lines += list(opened.warnings)
        self._model.setText("<br>".join(lines))


def _scrolled(page: QWidget) -> QScrollArea:
    area = QScrollArea()
    area.setWidget(page)
    area.setWidgetResizable(True)
    area.setFrameShape(QScrollArea.Shape.NoFrame)
    area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    return area
