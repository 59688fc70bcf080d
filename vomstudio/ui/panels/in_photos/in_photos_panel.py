"""The In photos panel: the photos in which the selection is visible, and one of them."""

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
from vomstudio.ui.base.help_links import explain
from vomstudio.ui.base.number_formatting import extent_points
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.in_photos.feature_photo import FeaturePhoto, world_of
from vomstudio.ui.panels.in_photos.sighting_list import SightingList, sighting_words
from vomstudio.ui.widgets.photo_canvas import PhotoPointer

if TYPE_CHECKING:
    from vomstudio.photogrammetry.inspect.photo_views import Sighting


_MOST_POINTS = 80  # of a feature, to find the photos that show it


class InPhotosPanel(QWidget):
    """shown : the photo that is drawn; list : the photos in which the selection is visible.
    listed : the list has changed."""

    listed = Signal()

    def __init__(
        self,
        studio: Studio,
        links: PhotoLinks,
        shown: FeaturePhoto,
        sightings: SightingList,
        actions: dict[str, QAction],
    ) -> None:
        super().__init__()
        explain(self, "photos.md#the-model-seen-in-its-photos")
        self._studio, self._links, self._actions = studio, links, actions
        self._viewport: Viewport | None = None
        self.shown, self.list, self.canvas = shown, sightings, shown.canvas
        self._what = ""
        self._place: FloatArray | None = None
        self._sightings: list[Sighting] = []
        self._follow = True
        self._own_choice = False
        self._token = 0
        self._text = ""
        self.words = ElidedLabel()
        self.words.setObjectName("in_photos_words")
        self.list.chosen.connect(self._photo_chosen)
        self.list.listed.connect(self.listed)
        split = QSplitter(Qt.Orientation.Horizontal)
        split.addWidget(self.list)
        split.addWidget(self.canvas)
        split.setStretchFactor(1, 1)
        split.setSizes([225, 600])
        split.setChildrenCollapsible(False)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(4, 4, 4, 4)
        layout.setSpacing(4)
        layout.addLayout(self._make_header())
        layout.addWidget(split, 1)
        self._soon = QTimer(self)
        self._soon.setSingleShot(True)
        self._soon.setInterval(40)
        self._soon.timeout.connect(self.refresh)
        shown.sighted.connect(self._sighted)
        shown.clicked.connect(self._navigate)
        links.changed.connect(self._links_changed)
        studio.selection_changed.connect(self._selected)
        for signal in (
            studio.edited,
            studio.model_loaded,
            studio.visibility_changed,
            studio.settings_changed,
            studio.tool_changed_signal,
        ):
            signal.connect(self._later)
        studio.project_opened.connect(self._forget)

    def _make_header(self) -> QHBoxLayout:
        header = QHBoxLayout()
        for name in ("previous_photo", "next_photo", "fit_photo"):
            button = QToolButton()
            button.setDefaultAction(self._actions[name])
            header.addWidget(button)
        header.addSpacing(6)
        header.addWidget(self.words, 1)
        self._offers: dict[str, QToolButton] = {}
        for name in ("choose_photos", "find_photos", "open_cameras"):
            button = QToolButton()
            button.setDefaultAction(self._actions[name])
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
            button.hide()
            self._offers[name] = button
            header.addWidget(button)
        return header

    def watch(self, viewport: Viewport) -> None:
        """Draw the features of this viewport, and follow clicks in it."""
        self._viewport = viewport
        self.shown.watch(viewport)
        viewport.pointer.connect(self._clicked_outside)

    # --- state -------------------------------------------------------------------------------
    @property
    def photo(self) -> str | None:
        """The name of the photo that is shown."""
        return self.shown.name

    @property
    def names(self) -> list[str]:
        """The photos in the list."""
        return self.list.names

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802
        super().showEvent(event)
        self._links.want()
        self._later()

    def hideEvent(self, event: QHideEvent) -> None:  # noqa: N802
        self._soon.stop()
        super().hideEvent(event)

    def _later(self, *_: object) -> None:
        if self.isVisible():
            self._soon.start()

    def _forget(self) -> None:
        self.shown.set_photos(None)
        self._place = None
        self._sightings = []
        self.list.clear()
        self.shown.show_nothing()
        self._later()

    def _links_changed(self, model_id: str) -> None:
        photos = self.shown.photos
        if photos is not None and photos.model_id == model_id:
            self.shown.photos = None
        self._later()

    def _selected(self, ids: tuple[str, ...]) -> None:
        if ids:
            self._place = None
        # What was selected in the photo is looked at in this photo.
        self._follow = not (self._own_choice or self.canvas.hasFocus())
        self._later()

    def show_place(self, point: FloatArray | None) -> None:
        """Ask for the photos that show a World point (3,)."""
        self._place, self._follow = point, True
        self._later()

    # --- what is looked for ------------------------------------------------------------------
    def refresh(self) -> None:
        """Search again for the photos in which the selection is visible."""
        if not self.isVisible():
            return
        photos = self._choose_model()
        if photos is not self.shown.photos:
            self._take(photos)
        self._offer()
        if photos is None:
            self.list.clear()
            self.shown.show_nothing()
            self.canvas.set_preview(None)
            self.words.setText("")
            return
        target, self._what = self._wanted()
        self._token += 1
        self.shown.look_for(self._token, target)
        self._draw()

    def _take(self, photos: ModelPhotos | None) -> None:
        """The photos of another model, or as they are now."""
        old = self.photo
        self.shown.set_photos(photos)
        self._sightings = []
        self.shown.forget_features()
        if photos is not None and old is not None and photos.views.has(old):
            self._show(photos.views.row(old), look=False)

    def _choose_model(self) -> ModelPhotos | None:
        """Of the selected feature's model, or of the first that has photos."""
        records, ids = self._studio.records, self._links.models()
        tool = self._studio.open_tool
        asked = [getattr(getattr(tool, "feature", None), "model_id", None)]
        asked += [getattr(records.get(i), "model_id", None) for i in self._studio.selection.ids]
        for model_id in (*asked, *ids):
            if model_id and (photos := self._links.of(model_id)) is not None:
                return photos
        return None

    def _wanted(self) -> tuple[FloatArray, str]:
        """World points (n, 3) to be seen, and what they are in words."""
        tool = self._studio.open_tool
        feature = getattr(tool, "feature", None)
        if feature is not None and (vertices := getattr(tool, "vertices", ())):
            model = self._studio.records.get(feature.model_id)
            if isinstance(model, Model):
                return _some(transform.apply(model.to_world, vertices)), tr("Unfinished feature")
        chosen = [
            r
            for i in self._studio.selection.ids
            if isinstance(r := self._studio.records.get(i), Feature)
        ]
        if chosen:
            measured = self._studio.measured(r.id for r in chosen).values()
            points = [p for m in measured if len(p := extent_points(m))]
            if points:
                many = tr_n("{count} feature", "{count} features", len(chosen))
                name = chosen[0].name if len(chosen) == 1 else many
                return _some(np.concatenate(points)), name
        if self._place is not None:
            return self._place[None], tr("Clicked position")
        return np.zeros((0, 3)), ""

    # --- the answers -------------------------------------------------------------------------
    def _sighted(self, token: int, sightings: list[Sighting]) -> None:
        if token == self._token:
            self._list(sightings)

    # --- the list ----------------------------------------------------------------------------
    def _list(self, sightings: list[Sighting]) -> None:
        photos = self.shown.photos
        if photos is None:
            return
        self._sightings = sightings
        views = photos.views.views
        if len(self.shown.target):
            rows = [(s.name, sighting_words(s, self._metric())) for s in sightings]
            text = tr_n(
                "{what}: visible in {visible} of {count} photo",
                "{what}: visible in {visible} of {count} photos",
                len(views),
                what=self._what,
                visible=len(sightings),
            )
        else:
            rows = [(view.name, "") for view in views]
            text = tr_n(
                "{count} photo of {model}. Select a feature or click on the model to see it here.",
                "{count} photos of {model}. Select a feature or click on the model to see it here.",
                len(views),
                model=photos.name,
            )
        self._text = text
        self.list.show_rows(rows, lambda name: photos.path(photos.views.row(name)))
        self._choose_photo()
        self._say()

    def _choose_photo(self) -> None:
        """The best photo for something new; the present one as long as it shows as much."""
        follow, self._follow = self._follow, False
        self._own_choice = False
        photos, view = self.shown.photos, self.shown.view
        if not self._sightings:
            if view is None and photos is not None and photos.views.views:
                self._show(0)
            return
        here = [s for s in self._sightings if s.view == view]
        best = self._sightings[0]
        if not here or (follow and self._studio.open_tool is None and best.view != view):
            self._show(best.view)
        else:
            self.shown.look_at_target(only_if_lost=True)
        self.list.mark(self.photo)

    def _photo_chosen(self, name: str) -> None:
        photos = self.shown.photos
        if photos is not None:
            self._show(photos.views.row(name))
            self._say()

    def _show(self, view: int, look: bool = True) -> None:
        self.shown.show(view, look)
        self._draw()
        self.list.mark(self.photo)

    def _draw(self) -> None:
        # What is selected takes the place of what was clicked.
        self.shown.draw(None if self._studio.selection.ids else self._place)

    # --- clicks ------------------------------------------------------------------------------
    def _clicked_outside(self, event: PointerEvent) -> None:
        """A click on the outcrop asks for a place."""
        if not self.isVisible() or self.shown.name is None:
            return
        if (
            event.kind is Pointer.CLICK
            and event.button is Button.LEFT
            and self._studio.tool_name == "navigate"
            and not self._studio.selection.ids
        ):
            self.show_place(None if event.hit is None else world_of(self._studio, event.hit))

    def _navigate(self, at: PhotoPointer, hit: Hit | None) -> None:
        """A click without a tool selects, or turns the viewport to the place."""
        found = self.canvas.feature_at(at.x, at.y)
        self._own_choice = True
        if found is not None and at.ctrl:
            self._studio.selection.toggle(found)
        elif not at.ctrl:
            self._studio.selection.set([] if found is None else [found])
        world = None if hit is None else world_of(self._studio, hit)
        if found is None and world is not None:
            self._place, self._follow = world, False
            self._later()
            if self._viewport is not None:
                self._viewport.moves.set_pivot(world)

    # --- words -------------------------------------------------------------------------------
    def _metric(self) -> bool:
        """Whether the lengths of the model are metres."""
        photos = self.shown.photos
        model = None if photos is None else self._studio.records.get(photos.model_id)
        return isinstance(model, Model) and model.frame.has_metres

    def _say(self) -> None:
        name = self.photo
        here = [s for s in self._sightings if s.view == self.shown.view]
        words = self._text
        if name is not None:
            photo = name.rpartition("/")[2]
            if here and len(self.shown.target):
                photo += f": {sighting_words(here[0], self._metric()).replace(chr(10), ', ')}"
            elif len(self.shown.target):
                photo = tr("not visible in {photo}", photo=photo)
            words += f"   ·   {photo}"
        self.words.setText(words)

    def _offer(self) -> None:
        """The message of an empty panel, and the buttons that help."""
        offers: set[str] = set()
        message = ""
        models = [m for m in self._studio.session.of(Model) if m.id in self._studio.models]
        photos = self.shown.photos
        if photos is not None:
            if photos.folder is None:
                offers = {"find_photos"}
        elif not models:
            message = tr("Open a model to see it in its photos.")
            offers = {"choose_photos"}
        elif self._links.busy():
            message = tr("Searching for the photos of the model…")
        else:
            offers = {"choose_photos", "open_cameras"}
            problems = [p for m in models if (p := self._links.problem(m.id))]
            message = (
                str(problems[0])
                if problems
                else tr(
                    "There is no cameras.json beside {model}. A model that was reconstructed here "
                    "has one. For another model, open the cameras.json of its reconstruction.",
                    model=models[0].name,
                )
            )
        for name, button in self._offers.items():
            button.setVisible(name in offers)
        if photos is None or message:
            self.shown.say(message)


def _some(points: FloatArray) -> FloatArray:
    step = max(1, -(-len(points) // _MOST_POINTS))
    return np.asarray(points[::step], np.float64)
