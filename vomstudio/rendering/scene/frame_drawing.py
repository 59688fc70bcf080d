"""Drawing of the scene, immediately during camera moves and incrementally at rest.

While the camera moves, a model that is slow to draw is represented by its proxy. At rest its
chunks are added in batches to the same buffers; the owner of the scene calls `refine` between
the events of its loop until the frame is complete. With a software renderer, thousands of
features are drawn in bands between events: `draw_band`.
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable, Iterable

from vomstudio.geometry.cloud import PointCloud
from vomstudio.rendering.scene import proxies
from vomstudio.rendering.scene.camera_visibility import SceneVisibility
from vomstudio.rendering.scene.canvas import Canvas
from vomstudio.rendering.scene.contents import Contents
from vomstudio.rendering.scene.dirty_region import PixelRegion, find_dirty_region, visible_in_region
from vomstudio.rendering.scene.eyedome import BAND_COUNT, EyeDome
from vomstudio.rendering.scene.feature_layer import (
    HALO_EXTRA,
    LINE_WIDTH,
    SELECTED_HALO_EXTRA,
    SELECTED_WIDTH,
)
from vomstudio.rendering.scene.frame_progress import Entry, FrameProgress
from vomstudio.rendering.scene.model_scene import Part
from vomstudio.rendering.scene.texture_levels import TextureLevels
from vomstudio.rendering.scene.visible_nodes import VisibleNodes
from vomstudio.rendering.view.camera import Eye
from vomstudio.rendering.view.frame_timing import BATCH_S, SLOW_FRAME_S, Pace

BAND_POINTS = 25_000
"""Number of feature points that a software renderer draws in about 50 ms, including halos and
hidden lines."""
MAX_BANDS = 12
MAX_EMPHASISED_AT_ONCE = 500
"""Number of selected features above which a software renderer draws them in bands, over a picture
with simplified lines."""
MAX_ZOOM = 1.5
"""Factor by which the view may zoom before the simplified lines are adapted to it."""


class FramePicture:
    """Picture of a scene, and its drawing.

    Attributes
    ----------
    eye_dome : bool
        Whether clouds at rest have eye-dome lighting.
    is_proxy_shown : bool
        Whether the last picture contains proxies.
    has_more_nodes : bool
        Whether the next picture will show coarse cloud nodes that the last one lacks.
    """

    def __init__(
        self,
        canvas: Canvas,
        scene_contents: Contents,
        visibility: SceneVisibility,
        nodes: VisibleNodes,
        frame: FrameProgress,
    ) -> None:
        self.eye_dome = False
        self.is_proxy_shown = False
        self.has_more_nodes = False
        self.pace = Pace()
        self._canvas, self._contents = canvas, scene_contents
        self._visibility, self._nodes, self._frame = visibility, nodes, frame
        self._levels = TextureLevels(canvas, scene_contents, visibility)
        self._dome = EyeDome()
        self._was_moving = False
        self._bands: list[tuple[int, int]] = []
        self._emphasis_bands: list[tuple[int, int]] = []
        self._line_scale = 1.0

    @property
    def is_complete(self) -> bool:
        """Whether the last picture is complete."""
        is_simplified = self._contents.features.is_simplified
        return self._frame.is_complete and not self.is_layering and not is_simplified

    @property
    def is_layering(self) -> bool:
        """Whether features are being drawn band by band."""
        return bool(self._bands or self._emphasis_bands)

    @property
    def shows_simple_emphasis(self) -> bool:
        """Whether the picture shows simplified lines of selected features, until all are drawn."""
        return bool(self._emphasis_bands) and not self._bands

    @property
    def refining(self) -> bool:
        """Whether a frame is being refined."""
        return self._frame.pending_parts is not None

    def abandon(self) -> None:
        """Discard the frame that is being refined, and mark the last picture as incomplete."""
        self._forget_bands()
        self._frame.abandon()

    def release(self) -> None:
        """Release the graphics resources."""
        self._dome.release(self._canvas.window)

    # -- at once

    @property
    def is_slow(self) -> bool:
        """Whether drawing everything takes too long for every step of a drag."""
        if any(m.proxies and not m.has_all_chunks for m in self._contents.visible()):
            return True
        parts = [part for _, part in self._visibility.parts()]
        return (
            not all(p.is_uploaded for p in parts)
            or self.pace.estimate_seconds(parts) > SLOW_FRAME_S
        )

    def draw(self, *, is_moving: bool) -> None:
        """Draw a picture now, using proxies if drawing the models takes too long."""
        if is_moving and not self._was_moving:
            self.pace.begin_moving()
        if is_moving:
            self._adapt_lines(is_first=not self._was_moving)
        self._was_moving = is_moving
        self.abandon()
        self._visibility.apply()
        self._nodes.update_nodes(fetches_nodes=not is_moving)
        # Set first, because the point size affects the drawing time.
        self._visibility.set_point_sizes()
        proxy = self.is_slow
        self.has_more_nodes = False
        if proxy:
            shown_parts = self._proxies()
        else:
            self._levels.choose()
            shown_parts = self._tint_parts(self._visibility.parts())
        has_new_parts = any(not p.is_uploaded for p in shown_parts)
        start_time = time.perf_counter()
        self._show_parts(shown_parts)
        self._canvas.is_surface_saved = False
        features = self._contents.features
        features.is_thin = is_moving
        uses_bands = not is_moving and self._needs_bands
        self._render(
            clears_canvas=True,
            draws_surface=True,
            draws_layer=not uses_bands,
            keep_picture=not is_moving,
        )
        features.is_thin = False
        self._canvas.wait()
        elapsed_s = time.perf_counter() - start_time
        for part in shown_parts:
            part.is_uploaded = True
        self.is_proxy_shown = proxy
        if not proxy:
            self.pace.record_frame(shown_parts, elapsed_s)
            self._frame.is_complete = not self._levels.is_upload_due and not self.is_shaded
        else:
            if not has_new_parts:
                self.pace.record_moving_frame(elapsed_s, proxies.MAX_MOVING_SETS)
            if not any(m.parts for m in self._contents.visible()):
                self._frame.is_complete = True
        if uses_bands:
            self._begin_bands()

    def _adapt_lines(self, *, is_first: bool) -> None:
        """Adapt the simplified lines to the view when it begins to move or has zoomed."""
        scale = self._visibility.camera.metres_per_pixel(self._canvas.size[1])
        if is_first or not 1.0 / MAX_ZOOM < scale / self._line_scale < MAX_ZOOM:
            self._line_scale = scale
            self._contents.features.begin_moving(self._visibility.pixel_sizes)

    def _proxies(self) -> list[Part]:
        """Return the proxies that are drawn if drawing the models takes too long."""
        visible = self._contents.visible()
        entries = self._visibility.parts(include_all_nodes=True)
        nodes, self.has_more_nodes = proxies.coarse_nodes(entries, self.pace.moving_sets)
        parts = [part for model in visible for part in model.proxies]
        return parts + self._tint_parts(nodes) + proxies.mesh_proxies(visible)

    def _tint_parts(self, entries: Iterable[Entry]) -> list[Part]:
        parts = []
        for model, part in entries:
            self._contents.look.tint_node(model, part)
            parts.append(part)
        return parts

    def draw_features(self) -> None:
        """Redraw the features over the last picture of the models.

        Afterwards call `draw_band` while `is_layering` is true, or else `refine`.
        """
        previous_bands = self._bands
        self._forget_bands()
        canvas, frame, eye = self._canvas, self._frame, self._visibility.eye
        if not canvas.is_surface_saved or eye is None:
            if not self.refining:
                self.draw(is_moving=False)
            # Otherwise the features will appear in the frame that is being refined.
            return
        depth = eye.depth(self._contents.overlay_corners())
        if len(depth) and (depth.min() < eye.near or depth.max() > eye.far):
            # The saved depth has another range, so that these features would be clipped.
            self.draw(is_moving=False)
            return
        if self.refining and previous_bands:
            self._begin_bands()
            return
        is_refining = self.refining and not frame.is_first
        if is_refining:
            canvas.buffers.save("frame")
        changed_features = self._contents.features.changed() if canvas.are_features_saved else None
        if changed_features is None or self._contents.cameras.is_stale:
            self._render_layer(keep_picture=not is_refining)
        elif not len(changed_features):
            uses_bands = self._is_emphasis_large and not is_refining
            self._render_emphasis(is_simple=uses_bands)
            if uses_bands:
                self._begin_emphasis_bands()
        elif (region := find_dirty_region(changed_features, eye, canvas.size)) is not None:
            self._render_region(region, eye)
        else:
            self._render_layer(keep_picture=not is_refining)
        if is_refining:
            canvas.pixels()
            canvas.buffers.restore("frame")

    # -- piece by piece

    def begin_rest(self) -> None:
        """Start the complete frame for a camera at rest."""
        if self._visibility.eye is not None:
            # The last complete picture determines hidden points until the next one is complete.
            self._canvas.depth()
        self._was_moving = False
        self._visibility.apply()
        self._nodes.update_nodes()
        self._levels.choose()
        self._visibility.set_point_sizes()
        self._forget_bands()
        self._frame.begin(self._visibility.parts())

    def refine(self) -> bool:
        """Draw a small part of the frame at rest. Return whether the frame is complete."""
        frame, canvas = self._frame, self._canvas
        if frame.pending_parts is None:
            return True
        if self.is_layering and frame.pending_parts:
            # More parts of the models have arrived, which must be drawn below the features.
            self._forget_bands()
            canvas.restore_surface()
        if self.is_layering:
            return self.draw_band() and self._end_rest()
        if self._levels.upload_next_piece():
            return False
        if not frame.pending_parts and not frame.is_first and self._shade_band():
            return False
        start_time = time.perf_counter()
        is_last = not frame.pending_parts
        count = self.pace.next_batch([part for _, part in frame.pending_parts])
        tint = self._contents.look.tint_node
        if any([tint(*entry) for entry in frame.pending_parts[:count]]):
            # The parts must be uploaded to the graphics card again.
            count = self.pace.next_batch([part for _, part in frame.pending_parts])
        batch = [part for _, part in frame.pending_parts[:count]]
        frame.pending_parts = frame.pending_parts[count:]
        if frame.is_first and not frame.pending_parts and not self.is_shaded:
            # The features, including copying the surface below them, are a separate step unless
            # the whole frame is drawn quickly.
            is_last = is_last or self.pace.estimate_seconds(batch) <= BATCH_S
        self._show_parts(batch)
        uses_bands = is_last and self._needs_bands
        self._render(
            clears_canvas=frame.is_first,
            draws_surface=True,
            draws_layer=is_last and not uses_bands,
            keep_picture=is_last,
        )
        canvas.wait()
        frame.is_first = False
        self.pace.record_frame(batch, time.perf_counter() - start_time)
        for part in batch:
            part.is_uploaded = True
        if uses_bands:
            self._begin_bands()
            return False
        return is_last and self._end_rest()

    def _end_rest(self) -> bool:
        self._frame.end()
        self.is_proxy_shown = False
        return True

    @property
    def is_shaded(self) -> bool:
        """Whether eye-dome lighting is applied to the picture at rest."""
        visible = self._contents.visible()
        return self.eye_dome and any(isinstance(m.data, PointCloud) for m in visible)

    def _shade_band(self) -> bool:
        """Shade the next part of the finished surface. Return False if all of it is shaded."""
        if not self.is_shaded:
            return False
        canvas, frame, eye = self._canvas, self._frame, self._visibility.eye
        assert eye is not None
        if frame.bands is None:
            canvas.buffers.save("flat")
            frame.bands = bands(canvas.size[1], BAND_COUNT if canvas.is_software else 1)
        if not frame.bands:
            return False
        self._dome.shade(
            canvas.window,
            canvas.buffers["flat"],
            canvas.size,
            frame.bands.pop(0),
            near=eye.near,
            far=eye.far,
            distance=self._visibility.camera.distance,
            is_orthographic=eye.orthographic,
            scale=self._contents.look.point_scale,
        )
        canvas.wait()
        return True

    # -- common

    def _show_parts(self, parts: list[Part]) -> None:
        shown_ids = {id(p) for p in parts}
        for model in self._contents.models.values():
            for part in model.parts + model.proxies:
                part.actor.SetVisibility(id(part) in shown_ids)

    def _render(
        self,
        *,
        clears_canvas: bool,
        draws_surface: bool,
        draws_layer: bool,
        keep_picture: bool,
    ) -> None:
        """Draw the models, or the features over their saved picture; `keep_picture` saves it."""
        canvas = self._canvas
        if draws_layer:
            canvas.are_features_saved = False
            self._contents.features.refresh(self._visibility.pixel_at)
            self._contents.cameras.refresh()
        callback: Callable[[], None] | None = canvas.restore_surface
        if draws_surface:
            callback = canvas.save_surface if keep_picture else None
        canvas.render(
            clears_canvas=clears_canvas,
            draws_surface=draws_surface,
            draws_layer=draws_layer,
            draws_emphasis=draws_layer,
            layer_callback=callback,
            emphasis_callback=canvas.save_features if keep_picture else None,
        )
        if draws_surface and keep_picture and not draws_layer:
            canvas.save_surface()

    def _render_layer(self, *, keep_picture: bool) -> None:
        """Draw the features over the saved picture of the models, or start to draw in bands."""
        if keep_picture and self._needs_bands:
            self._canvas.restore_surface()
            self._begin_bands()
        else:
            self._render(
                clears_canvas=False,
                draws_surface=False,
                draws_layer=True,
                keep_picture=keep_picture,
            )

    @property
    def _needs_bands(self) -> bool:
        points = self._contents.features.points
        return (
            self._canvas.is_software and points > BAND_POINTS and self._visibility.eye is not None
        )

    def _begin_bands(self) -> None:
        """Save the picture, which contains only the models, as the background of the bands."""
        canvas = self._canvas
        self._contents.cameras.refresh()
        canvas.save_features()
        count = math.ceil(self._contents.features.points / BAND_POINTS)
        self._bands = bands(canvas.size[1], min(count, MAX_BANDS))
        canvas.are_features_saved = False

    def draw_band(self) -> bool:
        """Draw the features in the next band. Return whether it was the last band."""
        canvas, eye = self._canvas, self._visibility.eye
        if not self.is_layering or eye is None:
            self._forget_bands()
            return True
        pending_bands = self._bands or self._emphasis_bands
        first_row, end_row = pending_bands.pop(0)
        band = PixelRegion(0, first_row, canvas.size[0] - 1, end_row - 1)
        if pending_bands is self._bands:
            # The selection is drawn over all bands.
            is_last, is_large = not self._bands, self._is_emphasis_large
            self._render_region(band, eye, draws_emphasis=is_last and not is_large)
            canvas.are_features_saved = is_last
            if is_last and is_large:
                self._begin_emphasis_bands()
        else:
            self._render_emphasis_band(band, eye)
        canvas.wait()
        return not self.is_layering

    def _forget_bands(self) -> None:
        self._bands, self._emphasis_bands = [], []

    @property
    def _is_emphasis_large(self) -> bool:
        """Whether the selection is drawn in bands."""
        count = len(self._contents.features.selected)
        return self._canvas.is_software and count > MAX_EMPHASISED_AT_ONCE

    def _begin_emphasis_bands(self) -> None:
        count = math.ceil(self._contents.features.points / BAND_POINTS)
        self._emphasis_bands = bands(self._canvas.size[1], min(count, MAX_BANDS))

    def _render_emphasis_band(self, region: PixelRegion, eye: Eye) -> None:
        """Draw the selected features in a part of the picture, over the saved features."""
        canvas, features = self._canvas, self._contents.features
        width = math.ceil((SELECTED_WIDTH + SELECTED_HALO_EXTRA) * features.scale)
        wider_region = region.enlarged(width)
        features.refresh_emphasis(
            self._visibility.pixel_at,
            lambda boxes: visible_in_region(wider_region, boxes, eye, canvas.size),
        )

        def emphasis_callback() -> None:
            canvas.restore_features(region)
            canvas.confine(region)

        canvas.render(
            clears_canvas=False,
            draws_surface=False,
            draws_layer=False,
            draws_emphasis=True,
            emphasis_callback=emphasis_callback,
        )

    def _render_emphasis(self, *, is_simple: bool = False) -> None:
        """Draw the selected and live features over the saved picture of everything else."""
        features = self._contents.features
        features.is_thin = is_simple
        if is_simple:
            features.begin_moving(self._visibility.pixel_sizes)
        features.refresh_emphasis(self._visibility.pixel_at)
        features.is_thin = False
        self._canvas.render(
            clears_canvas=False,
            draws_surface=False,
            draws_layer=False,
            draws_emphasis=True,
            emphasis_callback=self._canvas.restore_features,
        )

    def _render_region(self, region: PixelRegion, eye: Eye, *, draws_emphasis: bool = True) -> None:
        """Redraw a part of the picture with changed features, by default with the selection."""
        canvas, features = self._canvas, self._contents.features
        width = math.ceil((LINE_WIDTH + HALO_EXTRA) * features.scale)
        region = region.enlarged(width).clip_to(canvas.size)
        wider_region = region.enlarged(width)
        features.refresh(
            self._visibility.pixel_at,
            lambda boxes: visible_in_region(wider_region, boxes, eye, canvas.size),
        )

        def layer_callback() -> None:
            canvas.restore_features()
            canvas.restore_surface(region)
            canvas.confine(region)

        def emphasis_callback() -> None:
            canvas.confine(None)
            canvas.save_features(region)

        canvas.render(
            clears_canvas=False,
            draws_surface=False,
            draws_layer=True,
            draws_emphasis=draws_emphasis,
            layer_callback=layer_callback,
            emphasis_callback=emphasis_callback,
        )
        if not draws_emphasis:
            emphasis_callback()


def bands(height: int, count: int) -> list[tuple[int, int]]:
    """Divide the rows of a picture, from the bottom, into `count` bands (first, end)."""
    ends = [round(k * height / count) for k in range(count + 1)]
    return list(itertools.pairwise(ends))
