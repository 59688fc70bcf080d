"""Features shown over the outcrop: drawings, selection and picking."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING

from PySide6.QtCore import QRectF
from PySide6.QtGui import QPainter

from vomstudio.rendering.qt.annotations import Annotations
from vomstudio.rendering.qt.feature_picking import feature_at
from vomstudio.rendering.qt.scene_lifetime import SceneLifetime
from vomstudio.rendering.qt.scene_picture import ScenePicture
from vomstudio.rendering.qt.viewport_protocol import Pane
from vomstudio.rendering.view.camera import Camera
from vomstudio.rendering.view.drawing import FeatureDrawing
from vomstudio.studio.tools.interaction_types import Area

if TYPE_CHECKING:
    from vomstudio.rendering.scene.scene import Scene


class ShownFeatures:
    """Features that are shown in the view.

    Attributes
    ----------
    drawings : dict of str to FeatureDrawing
    selected : frozenset of str
        Ids of the emphasised features.
    """

    def __init__(
        self,
        camera: Camera,
        pane: Pane,
        lifetime: SceneLifetime,
        picture: ScenePicture,
        annotations: Annotations,
        is_inside: Callable[[FeatureDrawing], bool],
        has_clip_box: Callable[[], bool],
    ) -> None:
        """Create an empty set of features.

        Parameters
        ----------
        is_inside : callable
            Function that returns whether any part of a feature is inside the clipping box.
        has_clip_box : callable
            Function that returns whether clipping is on.
        """
        self.drawings: dict[str, FeatureDrawing] = {}
        self.selected: frozenset[str] = frozenset()
        self._hovered: tuple[str, float, float] | None = None
        self._camera, self._pane = camera, pane
        self._lifetime, self._picture = lifetime, picture
        self._annotations, self._is_inside, self._has_clip_box = (
            annotations,
            is_inside,
            has_clip_box,
        )

    def attach_to(self, scene: Scene) -> None:
        """Pass the drawings to a new scene."""
        if self.drawings:
            scene.set_features(self.drawings)
        scene.set_selected(self.selected)

    def change(self, changes: Mapping[str, FeatureDrawing | None]) -> None:
        """Add or replace drawings by id, and remove those with the value None."""
        for key, drawing in changes.items():
            if drawing is None:
                self.drawings.pop(key, None)
            else:
                self.drawings[key] = drawing
        if self._has_clip_box():
            # A changed feature may be outside the clipping box.
            self._annotations.clear_state()
        else:
            self._annotations.change(changes)
        if self._lifetime.scene is not None:
            self._lifetime.scene.set_features(changes)
        self._picture.redraw_features()

    def select(self, ids: Iterable[str]) -> None:
        """Emphasise only these features."""
        self.selected = frozenset(ids)
        if self._lifetime.scene is not None:
            self._lifetime.scene.set_selected(self.selected)
        self._picture.redraw_features()

    @property
    def hovered(self) -> str | None:
        """ID of the feature under the cursor, or None."""
        return None if self._hovered is None else self._hovered[0]

    def hover(self, id_: str | None, x: float = 0.0, y: float = 0.0) -> None:
        """Label the feature under the cursor at a pixel; None removes the label."""
        hovered_feature = None if id_ is None else (id_, x, y)
        if hovered_feature != self._hovered:
            self._hovered = hovered_feature
            self._pane.update()

    def paint_hovered(self, painter: QPainter) -> None:
        """Paint the label of the feature under the cursor."""
        if self._hovered is None:
            return
        id_, x, y = self._hovered
        drawing = self.drawings.get(id_)
        if drawing is not None and drawing.visible:
            width, height = self._pane.extent()
            available_rect = QRectF(0.0, 0.0, width, height)
            self._annotations.paint_hovered(painter, drawing, x, y, available_rect)

    def set_preview_areas(self, areas: list[tuple[Area, tuple[float, float, float]]]) -> None:
        """Show the areas of an unfinished feature with their colours."""
        scene = self._lifetime.scene
        if scene is not None:
            scene.features.set_preview_areas(areas)
            self._picture.redraw_features()

    def at(self, x: float, y: float, *, include_discs: bool = True) -> str | None:
        """Return the id of the feature with a label, symbol, line or disc at a pixel, or None."""
        if (feature_id := self._annotations.at(x, y)) is not None:
            return feature_id
        # Clipped features cannot be picked.
        candidates = [d for d in self.drawings.values() if d.visible and self._is_inside(d)]
        return feature_at(
            candidates, x, y, self._camera, self._pane.extent(), include_discs=include_discs
        )

    def unclipped_drawings(self) -> Mapping[str, FeatureDrawing]:
        """Return the drawings that are at least partly inside the clipping box, keyed by id."""
        if not self._has_clip_box():
            return self.drawings
        return {key: drawing for key, drawing in self.drawings.items() if self._is_inside(drawing)}
