"""Box in which views are saved, restored and deleted by name."""

from __future__ import annotations

from PySide6.QtWidgets import QComboBox, QHBoxLayout, QLineEdit, QPushButton, QWidget

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.studio.saved_views import SavedView, SavedViews
from vomstudio.ui.base.controls import ComboBox, set_enabled
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.outcrop.outcrop_view import OutcropView


class SavedViewsBox(QWidget):
    """Box in which views are saved, restored and deleted by name."""

    def __init__(self, studio: Studio, view: OutcropView) -> None:
        super().__init__()
        self._studio, self._view = studio, view
        self._views = SavedViews(
            lambda key: studio.project.journal.view(key),
            lambda key, value: studio.project.journal.set_view(key, value),
        )
        self.names = ComboBox()
        self.names.setObjectName("saved_views")
        self.names.setEditable(True)
        self.names.setInsertPolicy(QComboBox.InsertPolicy.NoInsert)
        line = QLineEdit()
        self.names.setLineEdit(line)
        line.setPlaceholderText(tr("Name of a view"))
        line.returnPressed.connect(self._apply_name)
        line.textChanged.connect(self._update_buttons)
        self.names.activated.connect(self._restore_view)
        self.save = QPushButton(tr("Save view"))
        self.save.setToolTip(tr("Save the camera and clipping box under this name."))
        self.save.clicked.connect(self._save)
        self.delete = QPushButton(tr("Delete"))
        self.delete.setToolTip(tr("Delete the view with this name."))
        self.delete.clicked.connect(self._delete)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.addWidget(self.names, 1)
        row.addWidget(self.save)
        row.addWidget(self.delete)
        studio.project_opened.connect(self.fill)
        studio.model_loaded.connect(self._update_buttons)
        self.fill()

    def fill(self, *_: object) -> None:
        """Show the saved views of the project."""
        self.names.clear()
        self.names.addItems([view.name for view in self._views.all()])
        self.names.setCurrentIndex(-1)
        self.names.clearEditText()
        self._update_buttons()

    def _find_view(self) -> SavedView | None:
        name = " ".join(self.names.currentText().split())
        return next((view for view in self._views.all() if view.name == name), None)

    def _apply_name(self) -> None:
        """Restore the view with this name, or save the current view under it."""
        if self._find_view() is not None:
            self._restore_view()
        elif self.save.isEnabled():
            self._save()

    def _restore_view(self, *_: object) -> None:
        view = self._find_view()
        if view is None:
            return
        try:
            self._view.restore_view(view.camera, view.box)
        except ValueError:
            self._studio.warn(Finding("view.damaged", name=view.name))

    def _save(self) -> None:
        view = self._view.view_state()
        if view is None:
            return
        name = self.names.currentText()
        try:
            self._views.save(SavedView(name, *view))
        except VomError as error:
            self._studio.warn(error)
            return
        self.fill()
        self.names.setCurrentText(" ".join(name.split()))

    def _delete(self) -> None:
        view = self._find_view()
        if view is not None:
            self._views.delete(view.name)
            self.fill()

    def _update_buttons(self, *_: object) -> None:
        has_name = bool(self.names.currentText().strip())
        set_enabled(
            self.save,
            self._view.disabled_reason() or (None if has_name else Finding("action.no-name")),
        )
        set_enabled(
            self.delete, Finding("action.no-saved-view") if self._find_view() is None else None
        )
