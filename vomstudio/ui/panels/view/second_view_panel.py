"""Page with a second 3-D view: other models, or another direction, beside the outcrop."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from PySide6.QtCore import Qt
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import QHBoxLayout, QMenu, QToolButton, QVBoxLayout, QWidget

from vomstudio.core.words import tr, tr_n
from vomstudio.project.records import Model
from vomstudio.rendering.qt.second_view import SecondView, import_plotter
from vomstudio.rendering.qt.viewport import Viewport
from vomstudio.rendering.view.drawing import PREVIEW
from vomstudio.studio.tools.interaction_types import PointerEvent, Preview
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import Label
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.outcrop.outcrop_view import STANDARD_VIEWS, OutcropView


class SecondViewPanel(QWidget):
    """Second view of the outcrop, with a choice of models and a camera that may be linked.

    The view is created when the page is first visible, because its libraries take seconds to
    import.

    Attributes
    ----------
    view : SecondView or None
        The 3-D view, or None until its libraries have been imported.
    """

    def __init__(self, studio: Studio, outcrop: OutcropView) -> None:
        super().__init__()
        set_help_topic(self, "window.md#second-view")
        self._studio, self._outcrop = studio, outcrop
        self.view: SecondView | None = None
        self._selection: set[str] | None = None
        """Ids of the models chosen for this view, or None for those visible in the outcrop."""
        self._is_linking = False
        self._background = QtBackground(self, "second view", threads=1)
        self._has_begun = False
        self._notice_label = Label(tr("Opening the view…"))
        self._notice_label.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self._column.setSpacing(0)
        self._column.addLayout(self._make_header())
        self._column.addWidget(self._notice_label, 1)
        studio.project_opened.connect(self._begin_project)
        for signal in (
            studio.edited,
            studio.model_loaded,
            studio.visibility_changed,
            studio.active_tool_changed,
            studio.settings_changed,
        ):
            signal.connect(self._follow)
        studio.preview.connect(self._show_preview)
        studio.jobs.closed.connect(self.close_view)
        self._name_models()

    def _make_header(self) -> QHBoxLayout:
        self.models = self._menu_button("second_models", "cube-outline", self._fill_models)
        self.models.setToolTip(tr("Choose the models of this view."))
        self.link = QToolButton()
        self.link.setObjectName("second_link")
        self.link.setIcon(theme.icon("link-variant"))
        self.link.setText(tr("Linked"))
        self.link.setToolTip(tr("Move the cameras of both views together."))
        self.link.setCheckable(True)
        self.link.setChecked(True)
        theme.highlight_toggles(self.link)
        self.link.toggled.connect(lambda is_linked: self._copy_outcrop() if is_linked else None)
        self.direction = self._menu_button("second_direction", "compass-outline", None)
        self.direction.setText(tr("Direction"))
        self.direction.setToolTip(tr("Look in a standard direction."))
        menu = self.direction.menu()
        menu.addAction(tr("Whole model"), self._show_whole_model)
        menu.addAction(tr("Same as outcrop"), self._copy_outcrop)
        menu.addSeparator()
        for name, text, _ in STANDARD_VIEWS:
            menu.addAction(tr(text), partial(self._look_along, name))
        header = QHBoxLayout()
        header.setContentsMargins(4, 2, 4, 2)
        for button in (self.models, self.link, self.direction):
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
            button.setAutoRaise(True)
            header.addWidget(button)
        header.addStretch()
        return header

    def _menu_button(
        self, name: str, icon: str, fill: Callable[[QMenu], None] | None
    ) -> QToolButton:
        button = QToolButton()
        button.setObjectName(name)
        button.setIcon(theme.icon(icon))
        button.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        menu = QMenu(button)
        if fill is not None:
            menu.aboutToShow.connect(partial(fill, menu))
        button.setMenu(menu)
        return button

    # --- start and end -----------------------------------------------------------------------
    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802
        super().showEvent(event)
        if not self._has_begun:
            self._has_begun = True
            self._background.run(import_plotter, self._create)

    def _create(self, _: object) -> None:
        viewport = self._outcrop.viewport
        if viewport is None:
            return
        self.view = view = SecondView(viewport, self.is_shown)
        view.pointer.connect(self._handle_pointer)
        view.camera_changed.connect(partial(self._link, view, viewport))
        viewport.camera_changed.connect(partial(self._link, viewport, view))
        self._column.replaceWidget(self._notice_label, view)
        self._notice_label.hide()

    def close_view(self) -> None:
        """Stop the import and release the graphics memory because the window is closing."""
        self._background.stop()
        if self.view is not None:
            self.view.release()

    # --- models ------------------------------------------------------------------------------
    def is_shown(self, model_id: str) -> bool:
        """Return whether a model is shown in this view."""
        studio = self._studio
        if self._selection is not None:
            return model_id in self._selection
        if not studio.visible("models"):
            return False
        return model_id.startswith(PREVIEW) or studio.visible(model_id)

    def show_models(self, ids: set[str] | None) -> None:
        """Show these models, or None for those that are visible in the outcrop."""
        self._selection = ids
        self._follow()

    def _fill_models(self, menu: QMenu) -> None:
        menu.clear()
        follow = menu.addAction(tr("Same as outcrop"), lambda: self.show_models(None))
        follow.setCheckable(True)
        follow.setChecked(self._selection is None)
        menu.addSeparator()
        for model in self._studio.session.of(Model):
            action = menu.addAction(model.name.replace("&", "&&"))
            action.setCheckable(True)
            action.setChecked(self.is_shown(model.id))
            action.triggered.connect(partial(self._toggle_model, model.id))

    def _toggle_model(self, model_id: str, is_shown: bool) -> None:
        models = self._studio.session.of(Model)
        ids = {model.id for model in models if self.is_shown(model.id)}
        self.show_models(ids | {model_id} if is_shown else ids - {model_id})

    def _name_models(self) -> None:
        """Name the models of the view on the button of their menu."""
        studio = self._studio
        models = studio.session.of(Model) if studio.has_project else []
        names = [model.name for model in models if self.is_shown(model.id)]
        text = names[0] if len(names) == 1 else tr_n("{count} model", "{count} models", len(names))
        metrics = self.models.fontMetrics()
        self.models.setText(metrics.elidedText(text, Qt.TextElideMode.ElideMiddle, 160))

    def _begin_project(self) -> None:
        self._selection = None
        self._copy_outcrop()
        self._follow()

    def _follow(self, *_: object) -> None:
        """Update the view after a change of the project or of the settings."""
        self._name_models()
        if self.view is not None:
            self.view.schedule_follow()

    # --- camera ------------------------------------------------------------------------------
    def _link(self, source: Viewport | SecondView, target: Viewport | SecondView) -> None:
        """Move the camera of the other view in the same way if the cameras are linked."""
        if self._is_linking or not self.link.isChecked() or not self.isVisible():
            return
        self._copy_view(source, target)

    def _copy_view(self, source: Viewport | SecondView, target: Viewport | SecondView) -> None:
        self._is_linking = True
        try:
            target.camera.restore(source.camera.to_dict())
            target.moves.redraw()
        finally:
            self._is_linking = False

    def _copy_outcrop(self) -> None:
        """Copy the camera of the outcrop view to this view."""
        viewport = self._outcrop.viewport
        if self.view is not None and viewport is not None:
            self._copy_view(viewport, self.view)

    def _show_whole_model(self) -> None:
        if self.view is not None:
            self.view.frame_all()

    def _look_along(self, name: str) -> None:
        if self.view is not None:
            self.view.moves.set_standard_view(name)

    # --- gestures and previews ---------------------------------------------------------------
    def _handle_pointer(self, event: PointerEvent) -> None:
        """Select features as in the outcrop, or pass the gesture to the active tool."""
        if self.view is None:
            return
        if self._studio.can_select_by_click:
            self._outcrop.select_at(self.view, event)
        else:
            self._studio.pointer(replace(event, is_in_photo=True))

    def _show_preview(self, preview: Preview | None) -> None:
        if self.view is not None:
            self.view.set_preview(preview)
