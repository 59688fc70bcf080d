"""One photo of a model with the features drawn over it. A gesture in it acts on the model."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from PySide6.QtCore import QObject, Qt, Signal

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry import transform
from vomstudio.project.records import Model
from vomstudio.rendering.qt.viewport import Viewport
from vomstudio.studio.photos import ModelPhotos
from vomstudio.studio.tools.interaction_types import Button, Hit, Pointer, PointerEvent, Preview
from vomstudio.ui.base.photo_images import PATIENCE_S, PhotoImages, PhotoPyramid
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.in_photos.drawn_features import draw_features
from vomstudio.ui.widgets.photo_canvas import Drawn, PhotoCanvas, PhotoPointer

_PLACE, _FEATURES = "place", "features"


class FeaturePhoto(QObject):
    """`photos` are those of a model, `view` says which of them is shown, `target` holds the World
    points (n, 3) that are to be seen in it.

    pointer : a gesture in the photo as the viewport would tell it. sighted : which photos show the
    target, with the token of the question. clicked : where a click without
    a tool came down, and what of the model is there (a Hit or None).
    """

    pointer = Signal(object)
    sighted = Signal(int, object)
    clicked = Signal(object, object)

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self._viewport: Viewport | None = None
        self.photos: ModelPhotos | None = None
        self.view: int | None = None
        self.target: FloatArray = np.zeros((0, 3))
        self._slack = 0.0
        self.images = PhotoImages()
        self._background = QtBackground(self, "in photos", threads=1)
        self.canvas = PhotoCanvas()
        self.canvas.pointed.connect(self._pointed)
        self.images.pictured.connect(self._pictured)
        studio.preview.connect(self._preview)
        studio.active_tool_changed.connect(self._tool_changed)

    def watch(self, viewport: Viewport) -> None:
        """Draw the features of this viewport, and show its cursor in the photo."""
        self._viewport = viewport
        viewport.pointer.connect(self._follow_cursor)
        viewport.left.connect(lambda: self.canvas.set_cross(None))

    def close(self) -> None:
        """Stop background work; what it still delivers is ignored."""
        self.photos = self.view = None
        self.images.close()
        self._background.stop(wait_s=PATIENCE_S)

    # --- the photo ---------------------------------------------------------------------------
    @property
    def name(self) -> str | None:
        """Of the photo that is shown."""
        if self.photos is None or self.view is None:
            return None
        return self.photos.views.views[self.view].name

    def set_photos(self, photos: ModelPhotos | None) -> None:
        """Of another model, or none; no photo is shown."""
        self.photos, self.view = photos, None

    def look_for(self, token: int, target: FloatArray) -> None:
        """Ask which photos of the model show World points (n, 3); `sighted` answers."""
        self.target = target
        if self.photos is not None:
            views = self.photos.views
            self._background.run_request(
                lambda _: views.sightings(target),
                partial(self.sighted.emit, token),
                key=_PLACE,
                first=True,
            )

    def forget_features(self) -> None:
        """Draw no feature until `draw` is called."""
        self.canvas.set_drawn((), frozenset())

    def show_nothing(self) -> None:
        """Show no photo at all."""
        self.canvas.set_photo(1, 1)
        self.canvas.look_through = None
        self.canvas.set_spot(None)

    def show(self, view: int, look: bool = True) -> None:
        """Show the photo of this number. look : zoom to the target"""
        photos = self.photos
        assert photos is not None
        self.view = view
        lens = photos.views.views[view].intrinsics
        self.canvas.set_photo(lens.width, lens.height)
        self.canvas.look_through = self._look_through
        self.canvas.direction = photos.views.direction(view)
        self.canvas.message = ""
        path = photos.path(view)
        if path is None:
            self.canvas.message = Finding("photo.none-found").message
        else:
            picture = self.images.picture(path)
            if picture is not None:
                self.canvas.set_picture(picture)
            else:
                self.canvas.message = tr("Reading {photo}…", photo=path.name)
        if look:
            self.look_at_target()

    def say(self, message: str) -> None:
        """In place of the photo."""
        self.canvas.message = message
        self.canvas.update()

    def _pictured(self, key: str, picture: PhotoPyramid | str) -> None:
        photos = self.photos
        if photos is None or self.view is None or str(photos.path(self.view)) != key:
            return
        if isinstance(picture, PhotoPyramid):
            first = self.canvas.message != ""
            self.canvas.message = ""
            self.canvas.set_picture(picture)
            if first and picture.turn.m11() < 0.5:
                self.look_at_target()
        else:
            self.say(Finding("photo.not-shown", photo=Path(key).name, reason=picture).message)

    def look_at_target(self, only_if_lost: bool = False) -> None:
        """Zoom to the target; with `only_if_lost` only where it is not in view."""
        if self.photos is None or self.view is None or not len(self.target):
            return
        pixels = self.photos.views.pixels(self.view, self.target)
        pixels = pixels[self.photos.views.views[self.view].contains(pixels)]
        if len(pixels) and not (only_if_lost and self.canvas.sees(np.median(pixels, axis=0))):
            self.canvas.look_at(pixels)

    # --- what is drawn over it ---------------------------------------------------------------
    def _look_through(self, points: FloatArray) -> tuple[FloatArray, BoolArray]:
        assert self.photos is not None
        assert self.view is not None
        views = self.photos.views
        seen = views.shows(self.view, points) | views.shows(self.view, points, self._slack)
        return views.pixels(self.view, points), seen

    def draw(self, place: FloatArray | None) -> None:
        """Features, tool and cross over the photo. place : a World point (3,) that was asked for"""
        if self.photos is None or self.view is None:
            return
        views, spot = self.photos.views, None
        if place is not None and views.shows(self.view, place[None])[0]:
            spot = views.pixels(self.view, place[None])[0]
        self.canvas.set_spot(spot)
        selected = self._studio.selection.ids
        features = {} if self._viewport is None else self._viewport.features.drawings
        # The selected ones are there first.
        shown = sorted(
            (d for d in features.values() if d.visible), key=lambda d: d.id not in selected
        )
        photos, view = self.photos, self.view
        self._background.run_request(
            lambda request: draw_features(request, photos, view, shown),
            partial(self._drawn, view),
            key=_FEATURES,
        )

    def _drawn(self, view: int, drawn: list[Drawn]) -> None:
        if view == self.view:
            self.canvas.set_drawn(drawn, frozenset(self._studio.selection.ids))

    def _preview(self, preview: Preview | None) -> None:
        if not self.canvas.isVisible() or self.canvas.look_through is None:
            return
        if preview is not None:
            # Between its corners the line runs below the surface.
            lengths = np.linalg.norm(np.diff(preview.line, axis=0), axis=1)
            self._slack = 0.1 * float(lengths.max(initial=0.0))
            # The panels have the rest, and the photo is small.
            preview = replace(preview, reading=preview.reading[:1], outline=None)
        self.canvas.set_preview(preview)

    def _follow_cursor(self, event: PointerEvent) -> None:
        """Where the cursor over the outcrop is in the photo."""
        photos = self.photos
        if event.kind is not Pointer.MOVE or not self.canvas.isVisible():
            return
        if photos is None or self.view is None:
            return
        world = None if event.hit is None else world_of(self._studio, event.hit)
        pixel = None
        if world is not None and photos.views.shows(self.view, world[None])[0]:
            pixel = photos.views.pixels(self.view, world[None])[0]
        self.canvas.set_cross(pixel)

    # --- gestures ----------------------------------------------------------------------------
    def _tool_changed(self, name: str) -> None:
        tool = self._studio.tools.get(name)
        self.canvas.left_paints = tool is not None and tool.paints
        arrow, cross = Qt.CursorShape.ArrowCursor, Qt.CursorShape.CrossCursor
        self.canvas.setCursor(arrow if tool is None else cross)

    def _pointed(self, at: PhotoPointer) -> None:
        photos = self.photos
        if photos is None or self.view is None:
            return
        seen = photos.views.pick(self.view, (at.x, at.y))
        hit = None
        if seen is not None:
            x, y, z = seen.position.tolist()
            element = "point" if seen.weights is None else "face"
            hit = Hit(photos.model_id, element, seen.index, (x, y, z), seen.weights)
        event = PointerEvent(
            at.kind,
            at.x,
            at.y,
            at.button,
            at.shift,
            at.ctrl,
            hit,
            at.handle,
            at.more,
            in_photo=True,
            photo=self.name or "",
        )
        self.pointer.emit(event)
        if self._studio.tool_name != "navigate":
            self._studio.pointer(event)
        elif at.kind is Pointer.CLICK and at.button is Button.LEFT:
            self.clicked.emit(at, hit)


def world_of(studio: Studio, hit: Hit) -> FloatArray | None:
    """A place on a model as a World point (3,)."""
    model = studio.records.get(hit.model_id)
    if not isinstance(model, Model):
        return None
    return np.asarray(transform.apply(model.to_world, [hit.position])[0])
