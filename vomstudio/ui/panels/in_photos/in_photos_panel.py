"""In photos panel: list of the photos that show the selection, and one of these photos."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import Qt, QTimer, Signal
from PySide6.QtGui import QAction, QHideEvent, QShowEvent
from PySide6.QtWidgets import (
    QHBoxLayout,
    QSplitter,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.arrays import FloatArray
from vomstudio.core.words import tr, tr_n
from vomstudio.geometry import transform
from vomstudio.project.records import Feature, Model
from vomstudio.rendering.qt.viewport import Viewport
from vomstudio.studio.photos import ModelPhotos, PhotoLinks
from vomstudio.studio.tools.interaction_types import Button, Hit, Pointer, PointerEvent
from vomstudio.ui.base.controls import ElidedLabel
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.number_formatting import extent_points
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.in_photos.feature_photo import FeaturePhoto, world_point
from vomstudio.ui.panels.in_photos.sighting_list import SightingList, sighting_text
from vomstudio.ui.widgets.photo_canvas import PhotoPointer

if TYPE_CHECKING:
    from vomstudio.photogrammetry.inspect.photo_views import Sighting


_MAX_POINTS = 80
"""Maximum number of points per feature used to search for photos that show it."""


class InPhotosPanel(QWidget):
    """Panel with a list of the photos that show the selection, and one of these photos.

    Attributes
    ----------
    feature_photo : FeaturePhoto
        The displayed photo.
    list : SightingList
        Photos in which the selection is visible.
    list_changed : Signal
        Emitted when the list has changed.
    """

    list_changed = Signal()

    def __init__(
        self,
        studio: Studio,
        links: PhotoLinks,
        feature_photo: FeaturePhoto,
        sightings: SightingList,
        actions: dict[str, QAction],
    ) -> None:
        super().__init__()
        set_help_topic(self, "photos.md#the-model-seen-in-its-photos")
        self._studio, self._links, self._actions = studio, links, actions
        self._viewport: Viewport | None = None
        self.feature_photo, self.list, self.canvas = feature_photo, sightings, feature_photo.canvas
        self._target_text = ""
        self._clicked_point: FloatArray | None = None
        self._sightings: list[Sighting] = []
        self._is_following = True
        self._is_user_choice = False
        self._token = 0
        self._list_text = ""
        self.summary = ElidedLabel()
        self.summary.setObjectName("in_photos_words")
        self.list.photo_selected.connect(self._show_selected_photo)
        self.list.list_changed.connect(self.list_changed)
        splitter = QSplitter(Qt.Orientation.Horizontal)
        splitter.addWidget(self.list)
        splitter.addWidget(self.canvas)
        splitter.setStretchFactor(1, 1)
        splitter.setSizes([225, 600])
        splitter.setChildrenCollapsible(False)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(4, 4, 4, 4)
        layout.setSpacing(4)
        layout.addLayout(self._make_header())
        layout.addWidget(splitter, 1)
        self._timer = QTimer(self, singleShot=True, interval=40)
        self._timer.timeout.connect(self.refresh)
        feature_photo.sightings_ready.connect(self._show_sightings)
        feature_photo.clicked.connect(self._navigate)
        links.changed.connect(self._handle_links_change)
        studio.selection_changed.connect(self._follow_selection)
        for signal in (
            studio.edited,
            studio.model_loaded,
            studio.visibility_changed,
            studio.settings_changed,
            studio.tool_changed_signal,
        ):
            signal.connect(self._schedule_refresh)
        studio.project_opened.connect(self._clear)

    def _make_header(self) -> QHBoxLayout:
        header = QHBoxLayout()
        for name in ("previous_photo", "next_photo", "fit_photo"):
            button = QToolButton()
            button.setDefaultAction(self._actions[name])
            header.addWidget(button)
        header.addSpacing(6)
        header.addWidget(self.summary, 1)
        self._help_buttons: dict[str, QToolButton] = {}
        for name in ("choose_photos", "find_photos", "open_cameras"):
            button = QToolButton()
            button.setDefaultAction(self._actions[name])
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
            button.hide()
            self._help_buttons[name] = button
            header.addWidget(button)
        return header

    def watch(self, viewport: Viewport) -> None:
        """Draw the features of this viewport and respond to clicks in it."""
        self._viewport = viewport
        self.feature_photo.watch(viewport)
        viewport.pointer.connect(self._follow_click)

    # --- state -------------------------------------------------------------------------------
    @property
    def photo(self) -> str | None:
        """Name of the displayed photo, or None if no photo is displayed."""
        return self.feature_photo.name

    @property
    def names(self) -> list[str]:
        """Names of the photos in the list."""
        return self.list.names

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802
        super().showEvent(event)
        self._links.request_photos()
        self._schedule_refresh()

    def hideEvent(self, event: QHideEvent) -> None:  # noqa: N802
        self._timer.stop()
        super().hideEvent(event)

    def _schedule_refresh(self, *_: object) -> None:
        if self.isVisible():
            self._timer.start()

    def _clear(self) -> None:
        self.feature_photo.set_photos(None)
        self._clicked_point = None
        self._sightings = []
        self.list.clear()
        self._schedule_refresh()

    def _handle_links_change(self, _: str) -> None:
        photos = self.feature_photo.photos
        if photos is not None and self._links.of(photos.model_id) is None:
            self.feature_photo.set_photos(None)
        self._schedule_refresh()

    def _follow_selection(self, ids: tuple[str, ...]) -> None:
        if ids:
            self._clicked_point = None
        # A selection made in the photo does not change the photo.
        self._is_following = not (self._is_user_choice or self.canvas.hasFocus())
        self._schedule_refresh()

    def show_point(self, point: FloatArray | None) -> None:
        """Show the photos that show a point (3,) in the World frame; None discards the point."""
        self._clicked_point, self._is_following = point, True
        self._schedule_refresh()

    # --- target ------------------------------------------------------------------------------
    def refresh(self) -> None:
        """Repeat the search for photos in which the selection is visible."""
        if not self.isVisible():
            return
        photos = self._choose_model()
        if photos is not self.feature_photo.photos:
            self._set_photos(photos)
        self._update_message()
        if photos is None:
            self.list.clear()
            self.summary.setText("")
            return
        target, self._target_text = self._find_target()
        self._token += 1
        self.feature_photo.request_sightings(self._token, target)
        self._draw()

    def _set_photos(self, photos: ModelPhotos | None) -> None:
        """Show the photos of another model, or the changed photos of the same model."""
        previous_photo = self.photo
        self.feature_photo.set_photos(photos)
        self._sightings = []
        if photos is not None and previous_photo is not None and photos.views.has(previous_photo):
            self._show_photo(photos.views.row(previous_photo), zoom_to_target=False)

    def _choose_model(self) -> ModelPhotos | None:
        """Return the photos of the selected feature's model, or else of the first model.

        Hidden models are skipped. The result is None if no visible model has photos.
        """
        records, ids = self._studio.records, self._links.models()
        tool = self._studio.open_tool
        candidates = [getattr(getattr(tool, "feature", None), "model_id", None)]
        candidates += [
            getattr(records.get(i), "model_id", None) for i in self._studio.selection.ids
        ]
        for model_id in (*candidates, *ids):
            photos = self._links.of(model_id) if model_id and self._is_visible(model_id) else None
            if photos is not None:
                return photos
        return None

    def _is_visible(self, model_id: str) -> bool:
        return self._studio.visible(model_id) and self._studio.visible("models")

    def _find_target(self) -> tuple[FloatArray, str]:
        """Return the World points (n, 3) that should be visible, and their description."""
        tool = self._studio.open_tool
        feature = getattr(tool, "feature", None)
        if feature is not None and (vertices := getattr(tool, "vertices", ())):
            model = self._studio.records.get(feature.model_id)
            if isinstance(model, Model):
                return _subsample(transform.apply(model.to_world, vertices)), tr(
                    "Unfinished feature"
                )
        selected_features = [
            r
            for i in self._studio.selection.ids
            if isinstance(r := self._studio.records.get(i), Feature)
        ]
        if selected_features:
            measurements = self._studio.measured(r.id for r in selected_features).values()
            points = [p for m in measurements if len(p := extent_points(m))]
            if points:
                count_text = tr_n("{count} feature", "{count} features", len(selected_features))
                name = selected_features[0].name if len(selected_features) == 1 else count_text
                return _subsample(np.concatenate(points)), name
        if self._clicked_point is not None:
            return self._clicked_point[None], tr("Clicked position")
        return np.zeros((0, 3)), ""

    # --- results -----------------------------------------------------------------------------
    def _show_sightings(self, token: int, sightings: list[Sighting]) -> None:
        if token == self._token:
            self._list_photos(sightings)

    # --- list --------------------------------------------------------------------------------
    def _list_photos(self, sightings: list[Sighting]) -> None:
        photos = self.feature_photo.photos
        if photos is None:
            return
        self._sightings = sightings
        views = photos.views.views
        if len(self.feature_photo.target):
            rows = [(s.name, sighting_text(s, self._is_metric())) for s in sightings]
            text = tr_n(
                "{what}: visible in {visible} of {count} photo",
                "{what}: visible in {visible} of {count} photos",
                len(views),
                what=self._target_text,
                visible=len(sightings),
            )
        else:
            rows = [(view.name, "") for view in views]
            text = tr_n(
                "{count} photo of {model}. Select a feature or click a point to list the photos"
                " that show it.",
                "{count} photos of {model}. Select a feature or click a point to list the photos"
                " that show it.",
                len(views),
                model=photos.name,
            )
        self._list_text = text
        self.list.show_rows(rows, lambda name: photos.path(photos.views.row(name)))
        self._choose_photo()
        self._update_summary()

    def _choose_photo(self) -> None:
        """Show the best photo for a new target; keep the current photo if it shows the target."""
        is_following, self._is_following = self._is_following, False
        self._is_user_choice = False
        photos, view = self.feature_photo.photos, self.feature_photo.view
        if not self._sightings:
            if view is None and photos is not None and photos.views.views:
                self._show_photo(0)
            return
        current_sightings = [s for s in self._sightings if s.view == view]
        best_sighting = self._sightings[0]
        if not current_sightings or (
            is_following and self._studio.open_tool is None and best_sighting.view != view
        ):
            self._show_photo(best_sighting.view)
        else:
            self.feature_photo.look_at_target(skip_if_visible=True)
        self.list.select_photo(self.photo)

    def _show_selected_photo(self, name: str) -> None:
        photos = self.feature_photo.photos
        if photos is not None:
            self._show_photo(photos.views.row(name))
            self._update_summary()

    def _show_photo(self, view: int, zoom_to_target: bool = True) -> None:
        self.feature_photo.show(view, zoom_to_target)
        self._draw()
        self.list.select_photo(self.photo)

    def _draw(self) -> None:
        # The selection replaces the clicked position.
        self.feature_photo.draw(None if self._studio.selection.ids else self._clicked_point)

    # --- clicks ------------------------------------------------------------------------------
    def _follow_click(self, event: PointerEvent) -> None:
        """Show the photos of a position that was clicked on the outcrop."""
        if not self.isVisible() or self.feature_photo.name is None:
            return
        if (
            event.kind is Pointer.CLICK
            and event.button is Button.LEFT
            and self._studio.tool_name == "navigate"
            and not self._studio.selection.ids
        ):
            self.show_point(None if event.hit is None else world_point(self._studio, event.hit))

    def _navigate(self, pointer: PhotoPointer, hit: Hit | None) -> None:
        """Select the feature at a click without an active tool, or move the viewport's pivot."""
        feature_id = self.canvas.feature_at(pointer.x, pointer.y)
        self._is_user_choice = True
        is_adding = pointer.ctrl or pointer.shift
        if feature_id is not None and is_adding:
            self._studio.selection.toggle(feature_id)
        elif not is_adding:
            self._studio.selection.set([] if feature_id is None else [feature_id])
        world = None if hit is None else world_point(self._studio, hit)
        if feature_id is None and world is not None:
            self._clicked_point, self._is_following = world, False
            self._schedule_refresh()
            if self._viewport is not None:
                self._viewport.moves.set_pivot(world)

    # --- texts -------------------------------------------------------------------------------
    def _is_metric(self) -> bool:
        """Return whether lengths in the model are in metres."""
        photos = self.feature_photo.photos
        model = None if photos is None else self._studio.records.get(photos.model_id)
        return isinstance(model, Model) and model.frame.has_metres

    def _update_summary(self) -> None:
        name = self.photo
        current_sightings = [s for s in self._sightings if s.view == self.feature_photo.view]
        text = self._list_text
        if name is not None:
            photo = name.rpartition("/")[2]
            if current_sightings and len(self.feature_photo.target):
                sighting = sighting_text(current_sightings[0], self._is_metric())
                photo += f": {sighting.replace(chr(10), ', ')}"
            elif len(self.feature_photo.target):
                photo = tr("not visible in {photo}", photo=photo)
            text += f"   ·   {photo}"
        self.summary.setText(text)

    def _update_message(self) -> None:
        """Show why the panel is empty, and the buttons that locate photos or cameras."""
        button_names: set[str] = set()
        message = ""
        models = [m for m in self._studio.session.of(Model) if m.id in self._studio.models]
        photos = self.feature_photo.photos
        if photos is not None:
            if not photos.files:
                button_names = {"find_photos"}
        elif not models:
            message = tr("Open a model to see it in its photos.")
            button_names = {"choose_photos"}
        elif self._links.models() and not any(map(self._is_visible, self._links.models())):
            message = tr("The model is hidden. Show it to see it in its photos.")
        elif self._links.busy():
            message = tr("Searching for the photos of the model…")
        else:
            button_names = {"choose_photos", "open_cameras"}
            problems = [p for m in models if (p := self._links.problem(m.id))]
            message = (
                str(problems[0])
                if problems
                else tr(
                    "No camera file was found next to {model}. Export the cameras from the program "
                    "that made the model, and open them.",
                    model=models[0].name,
                )
            )
        for name, button in self._help_buttons.items():
            button.setVisible(name in button_names)
        if photos is None or message:
            self.feature_photo.show_message(message)


def _subsample(points: FloatArray) -> FloatArray:
    step = max(1, -(-len(points) // _MAX_POINTS))
    return np.asarray(points[::step], np.float64)
