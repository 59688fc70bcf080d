"""Photo of a model with features drawn over it; gestures in the photo act on the model."""

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
from vomstudio.ui.base.photo_images import MAX_WAIT_S, PhotoImages, PhotoPyramid
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.in_photos.drawn_features import draw_features
from vomstudio.ui.widgets.photo_canvas import Drawn, PhotoCanvas, PhotoPointer

_SIGHTINGS_KEY, _FEATURES_KEY = "place", "features"


class FeaturePhoto(QObject):
    """Photo of a model with features drawn over it.

    Attributes
    ----------
    photos : ModelPhotos or None
        Photos of the model, or None if there are none.
    view : int or None
        Number of the displayed photo, or None if no photo is displayed.
    target : (n, 3) array
        Points in the World frame that should be visible.
    pointer : Signal
        Emitted with each gesture as a PointerEvent of the viewport.
    sightings_ready : Signal
        Emitted with the token of a request and the photos that show the target.
    clicked : Signal
        Emitted when the user clicks while no tool is active, with the click and the Hit on the
        model or None.
    """

    pointer = Signal(object)
    sightings_ready = Signal(int, object)
    clicked = Signal(object, object)

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self._viewport: Viewport | None = None
        self.photos: ModelPhotos | None = None
        self.view: int | None = None
        self.target: FloatArray = np.zeros((0, 3))
        self._tolerance = 0.0
        self.images = PhotoImages()
        self._background = QtBackground(self, "in photos", threads=1)
        self.canvas = PhotoCanvas()
        self.canvas.pointed.connect(self._handle_pointer)
        self.images.picture_loaded.connect(self._show_picture)
        studio.preview.connect(self._show_preview)
        studio.active_tool_changed.connect(self._handle_tool_change)

    def watch(self, viewport: Viewport) -> None:
        """Draw the features of this viewport, and show its cursor position in the photo."""
        self._viewport = viewport
        viewport.pointer.connect(self._follow_cursor)
        viewport.left.connect(lambda: self.canvas.set_cross(None))

    def close(self) -> None:
        """Stop background work and ignore its results."""
        self.set_photos(None)
        self.images.close()
        self._background.stop(wait_s=MAX_WAIT_S)

    # --- photo -------------------------------------------------------------------------------
    @property
    def name(self) -> str | None:
        """Name of the displayed photo, or None if no photo is displayed."""
        if self.photos is None or self.view is None:
            return None
        return self.photos.views.views[self.view].name

    def set_photos(self, photos: ModelPhotos | None) -> None:
        """Set the photos of a model, and remove the displayed photo with all drawings."""
        self.photos, self.view = photos, None
        self.canvas.set_photo(1, 1)
        self.canvas.projection = None
        self.canvas.set_marker(None)
        self.canvas.set_preview(None)

    def request_sightings(self, token: int, target: FloatArray) -> None:
        """Search for the photos that show points (n, 3) in the World frame.

        Emits `sightings_ready`.
        """
        self.target = target
        if self.photos is not None:
            views = self.photos.views
            self._background.run_request(
                lambda _: views.sightings(target),
                partial(self.sightings_ready.emit, token),
                key=_SIGHTINGS_KEY,
                is_first=True,
            )

    def show(self, view: int, zoom_to_target: bool = True) -> None:
        """Show the photo with this number, and zoom to the target if `zoom_to_target` is True."""
        photos = self.photos
        if photos is None:
            return
        self.view = view
        lens = photos.views.views[view].intrinsics
        self.canvas.set_photo(lens.width, lens.height)
        self.canvas.projection = partial(self._project_points, photos, view)
        self.canvas.direction = photos.views.direction(view)
        self.canvas.message = ""
        path = photos.path(view)
        if path is None:
            name = photos.views.views[view].name
            missing_message = tr("{photo} was not found. Locate the photos.", photo=name)
            self.canvas.message = (
                missing_message if photos.files else Finding("photo.none-found").message
            )
        else:
            picture = self.images.picture(path)
            if picture is not None:
                self.canvas.set_picture(picture)
            else:
                self.canvas.message = tr("Reading {photo}…", photo=path.name)
        if zoom_to_target:
            self.look_at_target()

    def show_message(self, message: str) -> None:
        """Show a message in place of the photo."""
        self.canvas.message = message
        self.canvas.update()

    def _show_picture(self, key: str, picture: PhotoPyramid | str) -> None:
        photos = self.photos
        if photos is None or self.view is None or str(photos.path(self.view)) != key:
            return
        if isinstance(picture, PhotoPyramid):
            is_first = self.canvas.message != ""
            self.canvas.message = ""
            self.canvas.set_picture(picture)
            if is_first and picture.to_upright.m11() < 0.5:
                self.look_at_target()
        else:
            self.show_message(
                Finding("photo.not-shown", photo=Path(key).name, reason=picture).message
            )

    def look_at_target(self, skip_if_visible: bool = False) -> None:
        """Zoom to the target; with `skip_if_visible`, only if the target is not in view."""
        if self.photos is None or self.view is None or not len(self.target):
            return
        pixels = self.photos.views.pixels(self.view, self.target)
        pixels = pixels[self.photos.views.views[self.view].contains(pixels)]
        if len(pixels) and not (
            skip_if_visible and self.canvas.contains_pixels(np.median(pixels, axis=0))
        ):
            self.canvas.look_at(pixels)

    # --- drawing -----------------------------------------------------------------------------
    def _project_points(
        self, photos: ModelPhotos, view: int, points: FloatArray
    ) -> tuple[FloatArray, BoolArray]:
        views = photos.views
        is_visible = views.shows(view, points) | views.shows(view, points, self._tolerance)
        return views.pixels(view, points), is_visible

    def draw(self, position: FloatArray | None) -> None:
        """Draw the features and a marker at a `position` (3,) in the World frame."""
        if self.photos is None or self.view is None:
            return
        views, cursor_pixel = self.photos.views, None
        if position is not None and views.shows(self.view, position[None])[0]:
            cursor_pixel = views.pixels(self.view, position[None])[0]
        self.canvas.set_marker(cursor_pixel)
        selected_ids = self._studio.selection.ids
        features = {} if self._viewport is None else self._viewport.features.drawings
        # Selected features are drawn before all others, since drawing takes time.
        drawings = sorted(
            (d for d in features.values() if d.visible), key=lambda d: d.id not in selected_ids
        )
        photos, view = self.photos, self.view
        self._background.run_request(
            lambda request: draw_features(request, photos, view, drawings),
            partial(self._show_overlays, view),
            key=_FEATURES_KEY,
        )

    def _show_overlays(self, view: int, overlays: list[Drawn]) -> None:
        if view == self.view:
            self.canvas.set_features(overlays, frozenset(self._studio.selection.ids))

    def _show_preview(self, preview: Preview | None) -> None:
        if not self.canvas.isVisible() or self.canvas.projection is None:
            return
        if preview is not None:
            # Between its vertices the line may be below the surface.
            lengths = np.linalg.norm(np.diff(preview.line, axis=0), axis=1)
            self._tolerance = 0.1 * float(lengths.max(initial=0.0))
            # The panels show the other readings, and the photo is small.
            preview = replace(preview, reading=preview.reading[:1], outline=None)
        self.canvas.set_preview(preview)

    def _follow_cursor(self, event: PointerEvent) -> None:
        """Show the position of the viewport's cursor in the photo."""
        photos = self.photos
        if event.kind is not Pointer.MOVE or not self.canvas.isVisible():
            return
        if photos is None or self.view is None:
            return
        world = None if event.hit is None else world_point(self._studio, event.hit)
        pixel = None
        if world is not None and photos.views.shows(self.view, world[None])[0]:
            pixel = photos.views.pixels(self.view, world[None])[0]
        self.canvas.set_cross(pixel)

    # --- gestures ----------------------------------------------------------------------------
    def _handle_tool_change(self, name: str) -> None:
        tool = self._studio.tools.get(name)
        self.canvas.is_left_button_painting = tool is not None and tool.can_paint
        arrow_cursor, cross_cursor = Qt.CursorShape.ArrowCursor, Qt.CursorShape.CrossCursor
        self.canvas.setCursor(arrow_cursor if tool is None else cross_cursor)

    def _handle_pointer(self, pointer: PhotoPointer) -> None:
        photos = self.photos
        if photos is None or self.view is None:
            return
        pick = photos.views.pick(self.view, (pointer.x, pointer.y))
        hit = None
        if pick is not None:
            x, y, z = pick.position.tolist()
            element = "point" if pick.weights is None else "face"
            hit = Hit(photos.model_id, element, pick.index, (x, y, z), pick.weights)
        event = PointerEvent(
            kind=pointer.kind,
            x=pointer.x,
            y=pointer.y,
            button=pointer.button,
            shift=pointer.shift,
            ctrl=pointer.ctrl,
            hit=hit,
            handle=pointer.handle,
            has_more_steps=pointer.is_continued,
            is_in_photo=True,
            photo=self.name or "",
            alt=pointer.alt,
        )
        self.pointer.emit(event)
        if self._studio.tool_name != "navigate":
            self._studio.pointer(event)
        elif pointer.kind is Pointer.CLICK and pointer.button is Button.LEFT:
            self.clicked.emit(pointer, hit)


def world_point(studio: Studio, hit: Hit) -> FloatArray | None:
    """Return a hit on a model as a point (3,) in the World frame, or None for unknown models."""
    model = studio.records.get(hit.model_id)
    if not isinstance(model, Model):
        return None
    return np.asarray(transform.apply(model.to_world, [hit.position])[0])
