"""The outcrop in its photos: those that show what is selected, with the features drawn over them; a
click in a photo is a click on the model."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from PySide6.QtCore import Qt, QTimer, Signal
from PySide6.QtGui import QAction, QHideEvent, QShowEvent
from PySide6.QtWidgets import (
    QHBoxLayout,
    QSplitter,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from vomstudio.document.records import Feature, Model
from vomstudio.geometry import transform
from vomstudio.rendering.qt.viewport import Viewport
from vomstudio.tools.types import Button, Hit, Pointer, PointerEvent, Preview
from vomstudio.ui.common.photo_canvas import Drawn, PhotoCanvas, PhotoPointer
from vomstudio.ui.common.photo_images import PhotoImages, Picture
from vomstudio.ui.common.studio import Studio
from vomstudio.ui.common.widgets import ElidedLabel
from vomstudio.ui.common.wording import drawn_points
from vomstudio.ui.sight.photo_links import ModelPhotos, PhotoLinks
from vomstudio.ui.sight.sighting_list import SightingList, sighting_words
from vomstudio.ui.sight.sighting_thread import SightingThread

if TYPE_CHECKING:
    from vomstudio.photogrammetry.inspect.photo_views import Sighting

Array = npt.NDArray[np.float64]

_MOST_POINTS = 80  # of a feature, to find the photos that show it


class InPhotosPanel(QWidget):
    """pointer: a gesture in a photo as the viewport would tell it. listed: the list has changed."""

    pointer = Signal(object)
    listed = Signal()

    def __init__(self, studio: Studio, links: PhotoLinks, actions: dict[str, QAction]) -> None:
        super().__init__()
        self._studio, self._links, self._actions = studio, links, actions
        self._viewport: Viewport | None = None
        self.images = PhotoImages()
        self._photos: ModelPhotos | None = None
        self._view: int | None = None
        self._target: Array = np.zeros((0, 3))
        self._what = ""
        self._place: Array | None = None
        self._sightings: list[Sighting] = []
        self._follow = True
        self._own_choice = False
        self._token, self._slack = 0, 0.0
        self._text = ""
        self._thread = SightingThread()
        self.words = ElidedLabel()
        self.words.setObjectName("in_photos_words")
        self.list = SightingList(self.images)
        self.list.chosen.connect(self._photo_chosen)
        self.list.listed.connect(self.listed)
        self.canvas = PhotoCanvas()
        self.canvas.pointed.connect(self._pointed)
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
        self._thread.sighted.connect(self._sighted, Qt.ConnectionType.QueuedConnection)
        self._thread.drawn.connect(self._drawn, Qt.ConnectionType.QueuedConnection)
        self.images.pictured.connect(self._pictured, Qt.ConnectionType.QueuedConnection)
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
        studio.preview.connect(self._preview)
        studio.project_opened.connect(self._forget)
        studio.active_tool_changed.connect(self._tool_changed)

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
        """Draw what it draws; follow its cursor."""
        self._viewport = viewport
        viewport.pointer.connect(self._follow_cursor)

    # --- state -------------------------------------------------------------------------------
    @property
    def photo(self) -> str | None:
        """The name of the photo that is shown."""
        if self._photos is None or self._view is None:
            return None
        return self._photos.views.views[self._view].name

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

    def close_threads(self) -> None:
        self.images.close()
        self._thread.close()

    def _later(self, *_: object) -> None:
        if self.isVisible():
            self._soon.start()

    def _forget(self) -> None:
        self._photos, self._view, self._place = None, None, None
        self._sightings = []
        self.list.clear()
        self.canvas.set_photo(1, 1)
        self.canvas.look_through = None
        self._later()

    def _links_changed(self, model_id: str) -> None:
        if self._photos is not None and self._photos.model_id == model_id:
            self._photos = None
        self._later()

    def _selected(self, ids: tuple[str, ...]) -> None:
        if ids:
            self._place = None
        # What was selected in the photo is looked at in this photo.
        self._follow = not (self._own_choice or self.canvas.hasFocus())
        self._later()

    def show_place(self, point: Array | None) -> None:
        """Ask for the photos that show a World point (3,)."""
        self._place, self._follow = point, True
        self._later()

    def _tool_changed(self, name: str) -> None:
        self.canvas.left_paints = name == "patch"
        picking = name in self._studio.tools
        cursor = Qt.CursorShape.CrossCursor if picking else Qt.CursorShape.ArrowCursor
        self.canvas.setCursor(cursor)

    # --- what is looked for ------------------------------------------------------------------
    def refresh(self) -> None:
        """Look again: which photos show what is selected, and where."""
        if not self.isVisible():
            return
        photos = self._choose_model()
        if photos is not self._photos:
            old = self.photo
            self._photos, self._view = photos, None
            self._sightings = []
            self.canvas.set_drawn((), frozenset())
            if photos is not None and old is not None and photos.views.has(old):
                self._show(photos.views.row(old), look=False)
        self._offer()
        if self._photos is None:
            self.list.clear()
            self.canvas.set_photo(1, 1)
            self.canvas.look_through = None
            self.canvas.set_preview(None)
            self.words.setText("")
            return
        self._target, self._what = self._wanted()
        self._token += 1
        self._thread.find(self._token, self._photos, self._target)
        self._draw()

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

    def _wanted(self) -> tuple[Array, str]:
        """World points (n, 3) to be seen, and what they are in words."""
        tool = self._studio.open_tool
        feature = getattr(tool, "feature", None)
        if feature is not None and (vertices := getattr(tool, "vertices", ())):
            model = self._studio.records.get(feature.model_id)
            if isinstance(model, Model):
                return _some(transform.apply(model.to_world, vertices)), self.tr("what is picked")
        chosen = [r for i in self._studio.selection.ids
                  if isinstance(r := self._studio.records.get(i), Feature)]  # fmt: skip
        if chosen:
            measured = self._studio.measured(r.id for r in chosen).values()
            points = [p for m in measured if len(p := drawn_points(m))]
            if points:
                name = chosen[0].name if len(chosen) == 1 else f"{len(chosen)} features"
                return _some(np.concatenate(points)), name
        if self._place is not None:
            return self._place[None], self.tr("the place that was clicked")
        return np.zeros((0, 3)), ""

    # --- the answers -------------------------------------------------------------------------
    def _sighted(self, token: int, sightings: list[Sighting]) -> None:
        if token == self._token:
            self._list(sightings)

    def _drawn(self, view: int, drawn: list[Drawn]) -> None:
        if view == self._view:
            self.canvas.set_drawn(drawn, frozenset(self._studio.selection.ids))

    # --- the list ----------------------------------------------------------------------------
    def _list(self, sightings: list[Sighting]) -> None:
        photos = self._photos
        if photos is None:
            return
        self._sightings = sightings
        views = photos.views.views
        if len(self._target):
            rows = [(s.name, sighting_words(s, self._metric())) for s in sightings]
            count = f"{len(sightings)} of {len(views)} photos"
            text = self.tr("{0}: seen in {1}").format(self._what, count)
        else:
            rows = [(view.name, "") for view in views]
            text = self.tr(
                "{0} photos of {1}. Select a feature or click on the outcrop to see it here."
            ).format(len(views), photos.name)
        self._text = text
        self.list.show_rows(rows, lambda name: photos.path(photos.views.row(name)))
        self._choose_photo()
        self._say()

    def _choose_photo(self) -> None:
        """The best photo for something new; the present one as long as it shows as much."""
        follow, self._follow = self._follow, False
        self._own_choice = False
        if not self._sightings:
            if self._view is None and self._photos is not None and self._photos.views.views:
                self._show(0)
            return
        here = [s for s in self._sightings if s.view == self._view]
        best = self._sightings[0]
        if not here or (follow and self._studio.open_tool is None and best.view != self._view):
            self._show(best.view)
        else:
            self._look_at_target(only_if_lost=True)
        self.list.mark(self.photo)

    def _photo_chosen(self, name: str) -> None:
        if self._photos is not None:
            self._show(self._photos.views.row(name))
            self._say()

    # --- the photo ---------------------------------------------------------------------------
    def _show(self, view: int, look: bool = True) -> None:
        photos = self._photos
        assert photos is not None
        self._view = view
        lens = photos.views.views[view].intrinsics
        self.canvas.set_photo(lens.width, lens.height)
        self.canvas.look_through = self._look_through
        self.canvas.direction = photos.views.direction(view)
        self.canvas.message = ""
        path = photos.path(view)
        if path is None:
            self.canvas.message = self.tr("The photos are not there: say where they are.")
        else:
            picture = self.images.picture(path)
            if picture is not None:
                self.canvas.set_picture(picture)
            else:
                self.canvas.message = self.tr("Reading {0}…").format(path.name)
        if look:
            self._look_at_target()
        self._draw()
        self.list.mark(self.photo)

    def _pictured(self, key: str, picture: Picture | str) -> None:
        photos = self._photos
        if photos is None or self._view is None or str(photos.path(self._view)) != key:
            return
        if isinstance(picture, Picture):
            first = self.canvas.message != ""
            self.canvas.message = ""
            self.canvas.set_picture(picture)
            if first and picture.turn.m11() < 0.5:
                self._look_at_target()
        else:
            self.canvas.message = self.tr("{0} cannot be shown: {1}").format(
                Path(key).name, picture
            )
            self.canvas.update()

    def _look_at_target(self, only_if_lost: bool = False) -> None:
        if self._photos is None or self._view is None or not len(self._target):
            return
        pixels = self._photos.views.pixels(self._view, self._target)
        pixels = pixels[self._photos.views.views[self._view].contains(pixels)]
        if len(pixels) and not (only_if_lost and self.canvas.sees(np.median(pixels, axis=0))):
            self.canvas.look_at(pixels)

    def _look_through(self, points: Array) -> tuple[Array, npt.NDArray[np.bool_]]:
        assert self._photos is not None
        assert self._view is not None
        views = self._photos.views
        seen = views.shows(self._view, points) | views.shows(self._view, points, self._slack)
        return views.pixels(self._view, points), seen

    def _draw(self) -> None:
        """Features, tool and cross over the photo."""
        if self._photos is None or self._view is None:
            return
        views = self._photos.views
        spot, place = None, self._place
        asked = place is not None and not self._studio.selection.ids
        if place is not None and asked and views.shows(self._view, place[None])[0]:
            spot = views.pixels(self._view, place[None])[0]
        self.canvas.set_spot(spot)
        selected = self._studio.selection.ids
        features = {} if self._viewport is None else self._viewport.features
        # The selected ones are there first.
        shown = sorted(
            (d for d in features.values() if d.visible), key=lambda d: d.id not in selected
        )
        self._thread.draw(self._view, self._photos, shown)

    def _preview(self, preview: Preview | None) -> None:
        if not self.isVisible() or self.canvas.look_through is None:
            return
        if preview is not None:
            # Between its corners the line runs below the surface.
            lengths = np.linalg.norm(np.diff(preview.line, axis=0), axis=1)
            self._slack = 0.1 * float(lengths.max(initial=0.0))
            # The panels have the rest, and the photo is small.
            preview = replace(preview, reading=preview.reading[:1])
        self.canvas.set_preview(preview)

    def _follow_cursor(self, event: PointerEvent) -> None:
        """Where the cursor over the outcrop is in the photo; a click asks for a place."""
        photos = self._photos
        if not self.isVisible() or photos is None or self._view is None:
            return
        world = None if event.hit is None else self._world(event.hit)
        if event.kind is Pointer.MOVE:
            pixel = None
            if world is not None and photos.views.shows(self._view, world[None])[0]:
                pixel = photos.views.pixels(self._view, world[None])[0]
            self.canvas.set_cross(pixel)
        elif (
            event.kind is Pointer.CLICK
            and event.button is Button.LEFT
            and self._studio.tool_name == "navigate"
            and not self._studio.selection.ids
        ):
            self.show_place(world)

    def _world(self, hit: Hit) -> Array | None:
        model = self._studio.records.get(hit.model_id)
        if not isinstance(model, Model):
            return None
        return np.asarray(transform.apply(model.to_world, [hit.position])[0])

    # --- gestures in the photo ---------------------------------------------------------------
    def _pointed(self, at: PhotoPointer) -> None:
        photos = self._photos
        if photos is None or self._view is None:
            return
        seen = photos.views.pick(self._view, (at.x, at.y))
        hit = None
        if seen is not None:
            x, y, z = seen.position.tolist()
            element = "point" if seen.weights is None else "face"
            hit = Hit(photos.model_id, element, seen.index, (x, y, z), seen.weights)
        event = PointerEvent(
            at.kind, at.x, at.y, at.button, at.shift, at.ctrl, hit, at.handle, at.more
        )
        self.pointer.emit(event)
        if self._studio.tool_name != "navigate":
            self._studio.pointer(event)
        elif at.kind is Pointer.CLICK and at.button is Button.LEFT:
            self._navigate(at, hit)

    def _navigate(self, at: PhotoPointer, hit: Hit | None) -> None:
        """A click without a tool selects, or turns the viewport to the place."""
        found = self.canvas.feature_at(at.x, at.y)
        self._own_choice = True
        if found is not None and at.ctrl:
            self._studio.selection.toggle(found)
        elif not at.ctrl:
            self._studio.selection.set([] if found is None else [found])
        world = None if hit is None else self._world(hit)
        if found is None and world is not None:
            self._place, self._follow = world, False
            self._later()
            if self._viewport is not None:
                self._viewport.set_pivot(world)

    # --- words -------------------------------------------------------------------------------
    def _metric(self) -> bool:
        """Lengths of the model are metres, as far as anybody knows."""
        photos = self._photos
        model = None if photos is None else self._studio.records.get(photos.model_id)
        return isinstance(model, Model) and model.frame.has_metres

    def _say(self) -> None:
        name = self.photo
        here = [s for s in self._sightings if s.view == self._view]
        words = self._text
        if name is not None:
            words += f"   ·   {name.rpartition('/')[2]}"
            if here and len(self._target):
                words += f": {sighting_words(here[0], self._metric()).replace(chr(10), ', ')}"
            elif len(self._target):
                words += self.tr(" does not show it")
        self.words.setText(words)

    def _offer(self) -> None:
        """What an empty panel says, and the button that mends it."""
        offers: set[str] = set()
        message = ""
        models = [m for m in self._studio.session.of(Model) if m.id in self._studio.models]
        if self._photos is not None:
            if self._photos.folder is None:
                offers = {"find_photos"}
        elif not models:
            message = self.tr("Open a model to see it in the photos that it was made of.")
            offers = {"choose_photos"}
        elif self._links.busy():
            message = self.tr("Looking for the photos of the model…")
        else:
            offers = {"choose_photos", "open_cameras"}
            problems = [p for m in models if (p := self._links.problem(m.id))]
            message = problems[0] if problems else self.tr(
                "{0} has no cameras.json beside it. A model that is made here from photos has one; "
                "of another one, open the cameras of its reconstruction."
            ).format(models[0].name)  # fmt: skip
        for name, button in self._offers.items():
            button.setVisible(name in offers)
        if self._photos is None or message:
            self.canvas.message = message
            self.canvas.update()


def _some(points: Array) -> Array:
    step = max(1, -(-len(points) // _MOST_POINTS))
    return np.asarray(points[::step], np.float64)
