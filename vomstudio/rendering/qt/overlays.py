"""Overlays painted over the 3-D view: labels, legends, compass and scale bar."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

from PySide6.QtCore import QRectF
from PySide6.QtGui import QPainter

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.words import tr
from vomstudio.rendering.qt import bar_painting, compass_and_scale
from vomstudio.rendering.qt.annotations import Annotations
from vomstudio.rendering.qt.legend_painting import ColorLegend
from vomstudio.rendering.view.camera import Camera
from vomstudio.rendering.view.drawing import FeatureDrawing
from vomstudio.rendering.view.scalars import Scale

Size = tuple[float, float]


class Overlays:
    """Overlays of the view: labels, colour bars, compass and scale bar.

    Attributes
    ----------
    is_north_known, is_unit_known : bool
        Whether the y axis of the World frame points north, and whether its unit is the metre.
    bars : list of ColorBar
        Colour bars that were last painted.
    legend : ColorLegend
        Legend of the colours of features.
    covered_rect : QRectF
        Rectangle that another widget covers.
    """

    def __init__(self, camera: Camera, captions: Mapping[str, str]) -> None:
        """Create the overlays.

        `captions` maps model ids to the names that are shown if there are several colour bars.
        """
        self._camera = camera
        self._captions = captions
        self.annotations = Annotations()
        self.is_north_known = True
        self.is_unit_known = True
        self.bars: list[bar_painting.ColorBar] = []
        self.legend = ColorLegend()
        self.covered_rect = QRectF()

    def paint(
        self,
        painter: QPainter,
        size: Size,
        features: Mapping[str, FeatureDrawing],
        selected_names: frozenset[str],
        scales: list[tuple[Scale, str]],
        project: Callable[[FloatArray], tuple[FloatArray, BoolArray]],
        *,
        is_moving: bool,
    ) -> None:
        """Paint the overlays.

        Parameters
        ----------
        painter : QPainter
        size : Size
            Width and height of the picture.
        features : mapping
            Drawings by feature id.
        selected_names : frozenset of str
            Ids of the selected features.
        scales : list of (Scale, str)
            Colour scales of the displayed fields, with the ids of their models.
        project : callable
            Function that returns the pixels of points in the World frame, and whether each is
            visible.
        is_moving : bool
            Whether the camera is moving.
        """
        width, height = size
        self.bars = self._lay_out_bars(scales, size)
        self.annotations.paint(
            painter,
            features,
            selected_names,
            self._camera,
            project,
            size,
            reserved_rects=(
                compass_and_scale.compass_box(height),
                compass_and_scale.scale_bar_box(width, height),
                self.covered_rect,
                *(bar.box for bar in self.bars),
                *([self.legend.box()] if self.legend.entries else []),
            ),
            is_moving=is_moving,
        )
        for bar in self.bars:
            bar.paint(painter)
        self.legend.paint(painter)
        compass_and_scale.draw_compass(painter, self._camera.frame, height, self.is_north_known)
        scale_bar_box = compass_and_scale.scale_bar_box(width, height)
        compass_box = compass_and_scale.compass_box(height)
        is_free = not any(map(scale_bar_box.intersects, (self.covered_rect, compass_box)))
        compass_and_scale.draw_scale_bar(
            painter,
            self._camera.metres_per_pixel(height),
            width,
            height,
            note=tr("at the centre of rotation")
            if is_free and not self._camera.orthographic
            else "",
            is_unit_known=self.is_unit_known,
        )

    def _lay_out_bars(
        self, scales: list[tuple[Scale, str]], size: Size
    ) -> list[bar_painting.ColorBar]:
        if not self.is_unit_known:
            scales = [
                (replace(s, unit=tr("units")) if s.unit == "m" else s, id_) for s, id_ in scales
            ]
        has_several_scales = len(scales) > 1
        captioned_scales = [
            (scale, (scale.title, self._captions.get(model_id, "") if has_several_scales else ""))
            for scale, model_id in scales
        ]
        return bar_painting.lay_out_bars(captioned_scales, *size, covered_rect=self.covered_rect)
