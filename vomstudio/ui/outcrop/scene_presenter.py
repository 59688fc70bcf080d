"""Presentation of records in the viewport, and selection of features by clicks."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import product
from typing import Protocol

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry import transform
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.matrices import IDENTITY
from vomstudio.geometry.patches import has_id
from vomstudio.geometry.plane_discs import disc_of_fit
from vomstudio.io.text.rows import shorten
from vomstudio.project.edit import Edit
from vomstudio.project.kinds import GROUPS, get_kind, visibility_group
from vomstudio.project.measurement import Measurement
from vomstudio.project.measurement_cache import LABEL_FIELDS, is_equal_except
from vomstudio.project.records import (
    Feature,
    FeatureType,
    Model,
    PaintedFeature,
    PickedFeature,
    Record,
    get,
    get_feature,
)
from vomstudio.rendering.qt.legend_painting import ColorLegend
from vomstudio.rendering.qt.viewport import Viewport
from vomstudio.rendering.view.clipping import ClipBox
from vomstudio.rendering.view.drawing import PREVIEW, FeatureDrawing, Symbol
from vomstudio.rendering.view.first_view import first_view
from vomstudio.rendering.view.scalars import field_names
from vomstudio.rendering.view.symbols import disc_symbol, line_symbol, plane_symbol
from vomstudio.studio.tools.interaction_types import (
    Area,
    Button,
    Hit,
    Pointer,
    PointerEvent,
    Preview,
)
from vomstudio.studio.tools.polyline import rgb
from vomstudio.ui.base.feature_colors import feature_color, legend, set_colors
from vomstudio.ui.base.number_formatting import extent_points, orientation_text
from vomstudio.ui.base.qt_owner import IncrementalWork
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.outcrop.surface_pieces import SurfacePieces

_STEP_FEATURES, _MAX_IMMEDIATE_POINTS, _STEP_POINTS = 250, 20_000, 4_000
"""Limits for drawing many features in steps between events: drawings and points per step."""
_UNDRAWN_FIELDS = LABEL_FIELDS - {"name"}
"""Feature attributes that the outcrop shows only as colours, if at all."""


class FeatureView(Protocol):
    """View of the outcrop in which features can be selected by clicks."""

    def pick(self, x: float, y: float) -> Hit | None: ...

    def world_position(self, hit: Hit) -> FloatArray: ...

    def feature_at(self, x: float, y: float, *, include_discs: bool = True) -> str | None: ...


class ScenePresenter:
    """Presenter that keeps models, features and previews consistent with the studio."""

    def __init__(self, studio: Studio, viewport: Viewport) -> None:
        self._studio = studio
        self._viewport = viewport
        self._models, self._moves, self._layer = viewport.models, viewport.moves, viewport.features
        self._drawn_model_ids: set[str] = set()
        self._drawn_feature_ids: set[str] = set()
        self._is_camera_placed = False
        self._drawing_work = IncrementalWork(viewport)
        self._pieces = SurfacePieces(studio, viewport, lambda id_: self._draw([id_]))
        self._drawn_settings = self._settings()
        self.edit_callback: Callable[[], object] = lambda: None
        """Called for a double click on a feature."""
        studio.project_opened.connect(self.rebuild)
        studio.edited.connect(self._follow_edit)
        studio.model_loaded.connect(self._add_model)
        studio.visibility_changed.connect(self._update_visibility)
        studio.selection_changed.connect(viewport.features.select)
        studio.preview.connect(self._show_tool_preview)
        studio.settings_changed.connect(self._handle_settings_change)
        studio.display.changed.connect(self._follow_display)
        viewport.clip_changed.connect(studio.display.set_clip)
        self._stages: dict[str, set[str]] = {}
        self._previews: set[str] = set()
        self._obsolete_previews: set[str] = set()
        studio.loader.previewed.connect(self._show_preview)
        studio.loader.ended.connect(self._end_preview)
        viewport.model_stage.connect(self._record_stage)
        viewport.pointer.connect(self._handle_pointer)

    def rebuild(self) -> None:
        """Show another project by removing all contents and drawing its models and features."""
        self._drawing_work.cancel()
        for model_id in self._drawn_model_ids:
            self._models.remove(model_id)
        self._drawn_model_ids.clear()
        self._layer.change(dict.fromkeys(self._drawn_feature_ids))
        self._drawn_feature_ids.clear()
        self._pieces.clear()
        self._is_camera_placed = self._restore_camera()
        for setting in ("mode", "lit", "point_size", "eye_dome", "clip"):
            self._follow_display(setting)
        for model_id in self._studio.models:
            self._add_model(model_id)
        self._draw_all_features()
        self._update_frame()

    def _restore_camera(self) -> bool:
        """Restore the saved camera of a project, and return whether this was possible.

        Otherwise, frame the features, which exist even if the model is missing.
        """
        camera = self._studio.project.journal.view("camera")
        try:
            if camera is not None:
                self._moves.set_camera_state(camera)
                return True
        except (ValueError, KeyError, TypeError):
            pass
        measurements = self._studio.measured(f.id for f in self._studio.session.features())
        points = [p for m in measurements.values() if len(p := extent_points(m))]
        if points:
            self._moves.frame(np.concatenate(points))
        return False

    # --- models ------------------------------------------------------------------------------
    def _add_model(self, model_id: str) -> None:
        record = self._studio.records.get(model_id)
        open_model = self._studio.models.get(model_id)
        if not isinstance(record, Model) or open_model is None or model_id in self._drawn_model_ids:
            return
        is_first = not self._drawn_model_ids and not self._is_camera_placed
        if is_first:
            self._face_model(model_id)
        self._stages.pop(model_id, None)
        self._models.add(
            model_id, open_model.data, transform.matrix(record.to_world), frame_camera=is_first
        )
        self._models.set_visible(model_id, self._is_model_visible(model_id))
        self._drawn_model_ids.add(model_id)
        self._show_field(model_id)
        self._update_frame()
        painted_ids = [
            feature.id
            for feature in self._studio.session.features()
            if (isinstance(feature, PaintedFeature) or get_kind(feature).filled)
            and getattr(feature, "model_id", None) == model_id
        ]
        if painted_ids:
            self._draw(painted_ids)

    # --- display -----------------------------------------------------------------------------
    def _follow_display(self, setting: str) -> None:
        display, viewport = self._studio.display, self._viewport
        if setting == "mode":
            viewport.display.set_mode(display.mode)
        elif setting == "lit":
            for mode, is_lit in display.lit.items():
                viewport.display.set_lit(mode, is_lit)
        elif setting == "point_size":
            viewport.display.set_point_size(display.point_size)
        elif setting == "eye_dome":
            viewport.display.set_eye_dome(display.eye_dome)
        elif setting in ("clip", "box"):
            viewport.clip.set_box(display.effective_clip, handles=display.handles)
        elif setting == "fields":
            for model_id in self._drawn_model_ids:
                self._show_field(model_id)

    def _show_field(self, model_id: str) -> None:
        style, open_model = (
            self._studio.display.styles.get(model_id),
            self._studio.models[model_id],
        )
        if style is not None and style.name not in field_names(open_model.data):
            # The file has changed since the field was selected.
            style = None
        self._viewport.display.set_field(model_id, style, self._studio.records[model_id].name)

    def models_box(self) -> ClipBox | None:
        """Return the bounding box of all visible models, or None if no model is visible."""
        ids = [
            i
            for i in self._drawn_model_ids
            if self._is_model_visible(i) and i in self._studio.models
        ]
        if not ids:
            return None
        return ClipBox.from_points(np.concatenate([self._model_corners(i) for i in ids]))

    # --- preview of a cloud while it is read -------------------------------------------------
    def _show_preview(self, key: str, cloud: PointCloud) -> None:
        record = self._studio.records.get(key)
        frame = record.to_world if isinstance(record, Model) else IDENTITY
        to_world = transform.matrix(frame)
        is_first = not self._drawn_model_ids and not self._is_camera_placed
        if is_first:
            self._moves.look_along(*first_view(cloud, to_world))
            # Later models must not move the camera.
            self._is_camera_placed = True
        self._models.add(PREVIEW + key, cloud, to_world, frame_camera=is_first)
        self._previews.add(key)

    def _end_preview(self, key: str) -> None:
        """Mark a preview for removal after the loaded cloud has been drawn."""
        if key not in self._previews:
            return
        self._previews.discard(key)
        self._obsolete_previews.add(key)
        if all("shown" in self._stages.get(i, set()) for i in self._drawn_model_ids):
            self._remove_previews()

    def _record_stage(self, model_id: str, stage: str) -> None:
        self._stages.setdefault(model_id, set()).add(stage)
        if model_id in self._drawn_model_ids and stage == "shown":
            self._remove_previews()

    def _remove_previews(self) -> None:
        for key in self._obsolete_previews:
            self._models.remove(PREVIEW + key)
        self._obsolete_previews.clear()

    def frame_all(self, additional_points: FloatArray | None = None) -> None:
        """Frame all visible models, seen from the exposed side of the first model.

        Parameters
        ----------
        additional_points : (n, 3) array, optional
            Additional points to frame, in the World frame.
        """
        ids = [m.id for m in self._studio.session.of(Model) if self._is_model_visible(m.id)]
        ids = [i for i in ids if i in self._studio.models]
        if not ids:
            self._moves.home()
            return
        self._face_model(ids[0])
        extra_points = [] if additional_points is None else [additional_points]
        self._moves.frame(np.concatenate([*(self._model_corners(i) for i in ids), *extra_points]))

    def _face_model(self, model_id: str) -> None:
        model = self._studio.records[model_id]
        assert isinstance(model, Model)
        self._moves.look_along(
            *first_view(self._studio.models[model_id].data, transform.matrix(model.to_world))
        )

    def _model_corners(self, model_id: str) -> FloatArray:
        """Return the corners (8, 3) of a model's bounding box in the World frame."""
        model = self._studio.records[model_id]
        assert isinstance(model, Model)
        bounds = self._studio.models[model_id].data.bounds
        return transform.apply(model.to_world, np.array(list(product(*bounds.T))))

    def _warn_if_far(self, model_id: str) -> None:
        """Warn if a newly opened model is far from the other models, and show it."""
        other_ids = [i for i in self._drawn_model_ids if i != model_id and i in self._studio.models]
        if model_id not in self._drawn_model_ids or not other_ids:
            return
        corners, other_corners = (
            self._model_corners(model_id),
            np.concatenate([self._model_corners(i) for i in other_ids]),
        )
        gap = max(
            float((corners.min(axis=0) - other_corners.max(axis=0)).max()),
            float((other_corners.min(axis=0) - corners.max(axis=0)).max()),
        )
        if gap > max(
            float(np.ptp(corners, axis=0).max()), float(np.ptp(other_corners, axis=0).max())
        ):
            self._face_model(model_id)
            self._moves.frame(corners)
            self._studio.warn(
                Finding(
                    "model.far-away",
                    model=self._studio.records[model_id].name,
                    distance=gap,
                    unit="m" if self._studio.are_metres_known() else tr("units"),
                )
            )

    def _is_model_visible(self, model_id: str) -> bool:
        return self._studio.visible(model_id) and self._studio.visible("models")

    def _update_frame(self) -> None:
        self._viewport.set_frame(
            is_north_known=self._studio.is_north_known(),
            is_unit_known=self._studio.are_metres_known(),
        )

    # --- features ----------------------------------------------------------------------------
    def _follow_edit(self, edit: Edit) -> None:
        for id_, record in edit.after.items():
            if isinstance(edit.before[id_], Model) and record is None:
                self._models.remove(id_)
                self._drawn_model_ids.discard(id_)
            elif isinstance(record, Model):
                if id_ in self._drawn_model_ids:
                    self._models.set_to_world(id_, transform.matrix(record.to_world))
                    previous_model = edit.before[id_]
                    if (
                        isinstance(previous_model, Model)
                        and previous_model.to_world != record.to_world
                    ):
                        # Another unit or axis moves the model out of the view.
                        self.frame_all()
                    self._update_frame()
                else:
                    self._add_model(id_)
                    self._warn_if_far(id_)
        if self._drawn_settings != self._settings():
            self._draw_all_features()
            return
        records = self._studio.records
        ids = [
            i for i in self._studio.affected_ids(edit) if not self._is_drawing_unchanged(edit, i)
        ]
        is_large_edit = (
            len(ids) > _STEP_FEATURES or _count_painted(records, ids) > _MAX_IMMEDIATE_POINTS
        )
        if len(ids) > 1 and is_large_edit:
            self._drawing_work.finish()
            self._drawing_work.start(self._draw_in_steps(list(ids)))
        else:
            self._draw(ids)

    def _is_drawing_unchanged(self, edit: Edit, id_: str) -> bool:
        """Return whether an edit changes only attributes of a feature that are not drawn."""
        old_record, record_after = edit.before.get(id_), edit.after.get(id_)
        if id_ not in self._drawn_feature_ids or not isinstance(old_record, Feature):
            return False
        are_sets_colored = self._studio.settings.color_by == "set"
        hidden_fields = _UNDRAWN_FIELDS - {"set_name"} if are_sets_colored else _UNDRAWN_FIELDS
        return is_equal_except(old_record, record_after, hidden_fields)

    def _handle_settings_change(self) -> None:
        if self._drawn_settings != self._settings():
            self._draw_all_features()

    def _settings(self) -> tuple[object, ...]:
        """Return the settings that affect the drawings of features."""
        settings = self._studio.settings
        colors = None
        if settings.color_by == "set":
            # The colour of a set depends on all sets.
            colors = tuple(self._studio.session.records.cached(set_colors).items())
        return settings.notation, settings.planes_as, settings.color_by, colors

    def _draw_all_features(self) -> None:
        self._drawn_settings = self._settings()
        self._viewport.set_legend(ColorLegend(*legend(self._studio)))
        ids = [feature.id for feature in self._studio.session.features()]
        self._drawing_work.start(self._draw_in_steps(ids))

    def _draw(self, ids: Iterable[str]) -> None:
        """Finish the pending drawings, then draw the features with the given ids."""
        self._drawing_work.finish()
        self._change(self._create_drawings(list(ids)))

    def _draw_in_steps(self, ids: list[str]) -> Iterator[None]:
        """Prepare the drawings of many features in steps, and draw them together."""
        changes: dict[str, FeatureDrawing | None] = {}
        records, point_count = self._studio.records, 0
        if len(ids) > _STEP_FEATURES or _count_painted(records, ids) > _MAX_IMMEDIATE_POINTS:
            # Many other parts update at the same event.
            yield
        batch: list[str] = []
        for id_ in ids:
            patch = get(records, id_, PaintedFeature)
            batch.append(id_)
            point_count += 0 if patch is None else patch.n
            if len(batch) >= _STEP_FEATURES or point_count > _STEP_POINTS:
                changes.update(self._create_drawings(batch))
                batch, point_count = [], 0
                yield
        changes.update(self._create_drawings(batch))
        self._change(changes)

    def _create_drawings(self, ids: list[str]) -> dict[str, FeatureDrawing | None]:
        """Return the drawings by id, with None for features that are deleted or lack a position."""
        records, measurements = self._studio.records, self._studio.measured(ids)
        return {
            id_: self._create_drawing(feature, measurements[id_])
            if isinstance(feature := records.get(id_), Feature)
            else None
            for id_ in ids
        }

    def _change(self, changes: dict[str, FeatureDrawing | None]) -> None:
        for id_, drawing in changes.items():
            if drawing is None:
                self._drawn_feature_ids.discard(id_)
                self._pieces.remove(id_)
            else:
                self._drawn_feature_ids.add(id_)
        if changes:
            self._layer.change(changes)

    def _create_drawing(self, feature: Feature, measurement: Measurement) -> FeatureDrawing | None:
        """Return the drawing of a feature, or None if it has no position on the outcrop."""
        studio, feature_kind = self._studio, get_kind(feature)
        sketch = feature_kind.sketch(
            studio.subject(feature, measurement), lambda id_: studio.measured([id_]).get(id_)
        )
        if sketch is None:
            return None
        quality = measurement.verdict.quality if measurement.verdict else None
        # Poor planes are only outlined, so that they are less prominent than the others.
        is_poor = quality == "poor"
        is_painted = sketch.faces is not None and not is_poor
        piece = self._pieces.painted_area(sketch.faces) if is_painted and sketch.faces else None
        has_outline = is_poor and sketch.faces is not None and len(sketch.line) > 2
        group = visibility_group(feature)
        text = sketch.label
        if text is None:
            text = orientation_text(measurement, studio.settings.notation)
        extent = feature_extent(measurement)
        ring, symbol = None, None
        if studio.settings.planes_as == "symbols":
            symbol = feature_symbol(feature, measurement, sketch.sign, extent)
            if symbol is not None:
                # The symbol already shows the number.
                text = "–"
        elif studio.settings.planes_as == "discs" and piece is None and not has_outline:
            ring, symbol = feature_disc(measurement)
        if len(sketch.line) == 1 and measurement.plane is None and measurement.line is None:
            # A position without a direction is drawn as a dot.
            symbol = disc_symbol(sketch.anchor, 0.0)
        # Names from tables may be of any length.
        name = shorten(feature.name)
        area = piece
        if feature_kind.filled and isinstance(feature, PickedFeature) and len(feature.vertices) > 2:
            area = self._pieces.outlined_area(feature)
        return FeatureDrawing(
            id=feature.id,
            line=sketch.line if piece is None else np.zeros((0, 3)),
            disc=ring,
            color=rgb(feature_color(studio, feature, measurement) or "#ffffff"),
            label=name if text == "–" else f"{name}  {text}",
            anchor=sketch.anchor if piece is None else _central_vertex(piece),
            visible=studio.visible(feature.id) and studio.visible(group),
            area=area,
            symbol=symbol,
            extent=extent,
            verdict=quality,
            is_outlined=is_poor,
        )

    def _patch_at(self, view: FeatureView, x: float, y: float) -> str | None:
        """Return the id of the smallest visible patch or area at a pixel, or None."""
        return self._find_patch(view, view.pick(x, y))

    def _find_patch(self, view: FeatureView, hit: Hit | None) -> str | None:
        if hit is None:
            return None
        patches = [
            (patch.n, patch.id)
            for patch in self._studio.session.of(PaintedFeature)
            if patch.model_id == hit.model_id
            and patch.element == hit.element
            and has_id(patch.runs, hit.index)
            and self._studio.visible(patch.id)
            and self._studio.visible(visibility_group(patch))
        ]
        if patches:
            return min(patches)[1]
        areas = [
            (float(getattr(feature, "area", None) or 0.0), id_)
            for id_ in self._pieces.find_enclosing(view.world_position(hit))
            if (feature := get_feature(self._studio.records, id_)) is not None
            and self._studio.visible(id_)
            and self._studio.visible(visibility_group(feature))
        ]
        return min(areas)[1] if areas else None

    def _update_visibility(self, ids: tuple[str, ...]) -> None:
        self._drawing_work.finish()
        for model_id in self._drawn_model_ids:
            self._models.set_visible(model_id, self._is_model_visible(model_id))
        groups = {group.id for group in GROUPS}
        studio, records = self._studio, self._studio.records
        changed_ids = set(ids)
        if any(id_ in groups or get(records, id_, FeatureType) is not None for id_ in ids):
            features = [
                f
                for f in studio.session.features()
                if visibility_group(f) in changed_ids or f.id in changed_ids
            ]
        else:
            features = [f for id_ in ids if (f := get_feature(records, id_)) is not None]
        changes: dict[str, FeatureDrawing | None] = {}
        for feature in features:
            drawing = self._layer.drawings.get(feature.id)
            is_visible = studio.visible(feature.id) and studio.visible(visibility_group(feature))
            if drawing is not None and drawing.visible != is_visible:
                changes[feature.id] = replace(drawing, visible=is_visible)
        if changes:
            self._layer.change(changes)

    def _update_hover(self, event: PointerEvent) -> None:
        """Label the feature under the cursor while no feature is being picked."""
        if self._studio.open_tool is not None:
            self._layer.hover(None)
            return
        id_ = self._layer.at(event.x, event.y, include_discs=False) or self._find_patch(
            self._viewport, event.hit
        )
        self._layer.hover(id_, event.x, event.y)

    # --- tool and pointer --------------------------------------------------------------------
    def _show_tool_preview(self, preview: Preview | None) -> None:
        self._viewport.set_preview(preview)

    def feature_at(self, view: FeatureView, x: float, y: float) -> str | None:
        """Return the id of the feature at a pixel of a view, or None if no feature is there."""
        return (
            view.feature_at(x, y, include_discs=False)
            or self._patch_at(view, x, y)
            or view.feature_at(x, y)
        )

    def _handle_pointer(self, event: PointerEvent) -> None:
        if event.kind is Pointer.MOVE:
            self._update_hover(event)
        is_left_button = event.button is Button.LEFT
        if not self._studio.can_select_by_click:
            self._studio.pointer(event)
        elif event.kind is Pointer.CLICK and is_left_button:
            self.select_at(self._viewport, event)
        elif event.kind is Pointer.DOUBLE_CLICK and is_left_button and self._studio.tool is None:
            # The first click has selected the feature.
            if self.feature_at(self._viewport, event.x, event.y) in self._studio.selection.ids:
                self.edit_callback()
        elif event.kind is not Pointer.DOUBLE_CLICK:
            self._studio.pointer(event)

    def select_at(self, view: FeatureView, event: PointerEvent) -> None:
        """Select the feature at a click in a view, or else report the click on the surface."""
        if event.kind is not Pointer.CLICK or event.button is not Button.LEFT:
            return
        feature_id = self.feature_at(view, event.x, event.y)
        is_adding = event.ctrl or event.shift
        if feature_id is not None and is_adding:
            self._studio.selection.toggle(feature_id)
        elif not is_adding:
            self._studio.selection.set([] if feature_id is None else [feature_id])
            is_navigating = self._studio.tool is None
            if feature_id is None and is_navigating and (hit := view.pick(event.x, event.y)):
                self._studio.surface_clicked.emit(hit)


def _central_vertex(area: Area) -> FloatArray:
    """Return the vertex of an area that is nearest to its centroid."""
    points = area.corners.reshape(-1, 3)
    distances = ((points - points.mean(axis=0)) ** 2).sum(axis=1)
    return np.asarray(area.origin + points[int(distances.argmin())])


def _count_painted(records: Mapping[str, Record], ids: Iterable[str]) -> int:
    """Count the faces or points of the painted features with the given ids."""
    return sum(r.n for id_ in ids if (r := get(records, id_, PaintedFeature)) is not None)


def feature_extent(measurement: Measurement) -> float:
    """Return the extent of a feature in metres: longest axis, box diagonal, or 0 for a point."""
    if measurement.fit is not None and measurement.fit.extent is not None:
        return float(measurement.fit.extent)
    if not len(measurement.points):
        return 0.0
    return float(np.linalg.norm(np.ptp(measurement.points, axis=0)))


def feature_disc(measurement: Measurement) -> tuple[FloatArray | None, Symbol | None]:
    """Return the outline (c, 3) of a disc with the size of a feature, and a small symbol.

    The symbol replaces a disc that is small on the screen. A plane without extent or with an
    undefined dip has neither.
    """
    fit, ring = measurement.fit, disc_of_fit(measurement.fit)
    if fit is None or fit.extent is None or ring is None:
        return None, None
    return ring, disc_symbol(fit.centroid, fit.extent)


def feature_symbol(
    feature: Feature,
    measurement: Measurement,
    position: FloatArray | None,
    extent: float,
) -> Symbol | None:
    """Return the map symbol of a plane or line, or None if attitude or position is missing."""
    if position is None:
        return None
    if measurement.plane is not None:
        plane = measurement.plane
        return plane_symbol(
            plane.dip_direction_deg,
            plane.dip_deg,
            position,
            extent,
            is_overturned=bool(getattr(feature, "overturned", False)),
        )
    if measurement.line is not None:
        return line_symbol(
            measurement.line.trend_deg, measurement.line.plunge_deg, position, extent
        )
    return None
