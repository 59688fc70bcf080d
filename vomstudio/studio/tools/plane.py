"""Tool that measures a plane on one surface of the outcrop.

A click grows the even surface around it, and dragging paints with a round brush; other modes draw
a lasso, polygon or rectangle. Enter creates a patch of the selected faces or points, whose plane is
fitted. Clicks are queued until the neighbour graph of the model is built.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.errors import DocumentError, VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry import transform
from vomstudio.geometry.brush import SelectableSurface
from vomstudio.geometry.patches import runs_to_ids
from vomstudio.project import edits
from vomstudio.project.edit import Edit
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import FeatureType, Model, get
from vomstudio.studio.tools.brush_stroke import Stroke, patch_fields
from vomstudio.studio.tools.element_preview import new_patch
from vomstudio.studio.tools.element_selection import Combine, ElementSelection, combine_masks
from vomstudio.studio.tools.element_tool import ElementTool, combination
from vomstudio.studio.tools.growth import Growth, Seed
from vomstudio.studio.tools.interaction_types import (
    BrushRing,
    Button,
    Hit,
    Pointer,
    PointerEvent,
    Preview,
)
from vomstudio.studio.tools.plane_readout import plane_reading
from vomstudio.studio.tools.polyline import BLANK_COLOR, rgb
from vomstudio.studio.tools.selection_messages import (
    ERASE_LABEL,
    GROW_LABEL,
    PAINT_LABEL,
    SHAPE_HINTS,
    ElementMode,
    count_text,
)
from vomstudio.studio.tools.tool_context import ToolContext
from vomstudio.studio.tools.tool_entry import ToolEntry

MIN_RADIUS_M, MAX_RADIUS_M = 1e-3, 1e4
RADIUS_FACTOR = 1.25
# Initial size of the brush as a share of the model size.
DEFAULT_RADIUS_SHARE = 1.0 / 80.0
MAX_PLANE_ELEMENTS = 2_000_000
_PICK_HINT = to_translate(
    "click to grow it, drag to paint it. Ctrl+wheel: angle, Shift+wheel: distance."
)
_HINT = to_translate("Plane: {how} {count}")
_HINT_OPEN = to_translate("Plane: {count} Press Enter to save the plane, Esc to discard it.")


class PlaneTool(ElementTool):
    """Tool that measures planes.

    Attributes
    ----------
    growth : Growth
        Growth from a click, with its tolerances.
    """

    name = noun = "plane"
    record = Patch

    def __init__(self, context: ToolContext) -> None:
        super().__init__(context)
        self.mode: ElementMode = "pick"
        self.growth = Growth(context)
        self._radius: float | None = None
        self._continued_patch: Patch | None = None
        # Clicks pending until the neighbour graph is built; None marks the end of the plane.
        self._waiting: list[Seed | None] = []
        self._stroke: Stroke | None = None
        self._stroke_combination: Combine = "new"
        self._is_pressed = False
        self._is_removing = False
        self._hover_hit: Hit | None = None
        self._live_measurement: Measurement | None = None

    # --- state -------------------------------------------------------------------------------
    @property
    def is_open(self) -> bool:
        """Whether a plane has been started."""
        return super().is_open or self._is_pressed or bool(self._waiting)

    @property
    def is_painting(self) -> bool:
        """Whether a stroke is being painted."""
        return self._is_pressed

    @property
    def is_continued(self) -> bool:
        """Whether a plane of the document is being changed."""
        return self._continued_patch is not None and self.is_open

    @property
    def continued_plane(self) -> Patch | None:
        """Plane of the document that is being changed, or None."""
        return self._continued_patch if self.is_open else None

    @property
    def is_finishing(self) -> bool:
        """Whether the plane will be stored as soon as the neighbour graph is built."""
        return None in self._waiting

    @property
    def radius(self) -> float:
        """Radius of the brush, metres."""
        return self._radius if self._radius is not None else 0.1

    @property
    def measurement(self) -> Measurement | None:
        """Measurement of the plane, or None if it is not measured yet or has too many elements."""
        if self._is_pressed:
            return self._live_measurement
        return self._preview.measurement(self.selection)

    @property
    def undo_label(self) -> str | None:
        if self._is_pressed:
            return None
        if self._waiting:
            return tr("Finish") if self._waiting[-1] is None else tr("Click")
        return super().undo_label

    @property
    def redo_label(self) -> str | None:
        return None if self._is_pressed or self._waiting else super().redo_label

    def hint(self) -> str:
        if self._is_pressed:
            return tr("Plane: release the button to end the stroke; press Esc to discard it.")
        if self._shape is not None:
            return self._shape.hint()
        if self.count:
            return tr(_HINT_OPEN, count=count_text(self.count))
        hint_text = tr(_PICK_HINT) if self.mode == "pick" else tr(SHAPE_HINTS[self.mode])
        return tr(_HINT, how=hint_text, count=count_text(0))

    def finish_problem(self) -> Finding | None:
        if self._shape is not None:
            return self._shape.close_problem()
        return None if self.is_open else Finding("plane.nothing-chosen")

    def cancel_problem(self) -> Finding | None:
        return None if self.is_open else Finding("tool.nothing-open")

    # --- settings ----------------------------------------------------------------------------
    def set_radius(self, metres: float) -> None:
        """Set the radius of the brush in metres, limited to the permitted range."""
        metres = min(max(float(metres), MIN_RADIUS_M), MAX_RADIUS_M)
        if metres != self._radius:
            self._radius = metres
            self._notify_change()

    def enlarge_brush(self) -> None:
        """Enlarge the brush by one step."""
        self.set_radius(_round_to_two_digits(self.radius * RADIUS_FACTOR))

    def shrink_brush(self) -> None:
        """Shrink the brush by one step."""
        self.set_radius(_round_to_two_digits(self.radius / RADIUS_FACTOR))

    def set_tolerance(
        self, *, angle_deg: float | None = None, distance: float | None = None
    ) -> None:
        """Set the tolerances of growth, in degrees and metres."""
        if angle_deg is not None:
            self.growth.set_angle(angle_deg)
        if distance is not None:
            self.growth.set_distance(distance)
        self.regrow()

    def set_type(self, type_id: str, set_name: str) -> None:
        """Show the plane in the colour of the next type."""
        self._preview.forget_measurement()
        if self.count:
            self._store_draft()
        if self.is_open or self._hover_hit is not None:
            self._show_preview()

    # --- gestures ----------------------------------------------------------------------------
    def pointer(self, event: PointerEvent) -> None:
        """Grow, paint or draw a shape with the left button; see `Tool`."""
        if event.kind is Pointer.WHEEL:
            self.growth.change_tolerance(event.wheel_notches, includes_distance=event.shift)
            self.regrow()
            return
        if event.kind is Pointer.MOVE:
            self._hover_hit, self._is_removing = event.hit, self._removes_elements(event)
            if self._shape is None:
                self._show_preview()
        if self.mode != "pick":
            self._draw(event)
        elif event.button is Button.LEFT:
            self._handle_pick(event)

    def _removes_elements(self, event: PointerEvent) -> bool:
        return combination(event, self.combine) == "subtract"

    def _handle_pick(self, event: PointerEvent) -> None:
        if event.kind in (Pointer.CLICK, Pointer.DOUBLE_CLICK):
            self._grow(event)
        elif event.kind is Pointer.DRAG_START:
            self._press(event)
        elif event.kind is Pointer.DRAG_MOVE and self._is_pressed:
            self._paint(event.hit)
            if not event.has_more_steps:
                self._measure_live()
                self._show_preview()
        elif event.kind is Pointer.DRAG_END and self._is_pressed:
            self._paint(event.hit)
            self._release()

    # --- growth ------------------------------------------------------------------------------
    def _grow(self, event: PointerEvent) -> None:
        if event.hit is None:
            self._context.hint(Finding("tool.no-surface"))
            return
        combination_mode = combination(event, self.combine)
        if combination_mode != "new" and self._is_on_other_model(event.hit):
            self._context.hint(Finding("tool.other-model"))
            return
        self._waiting.append(Seed(event.hit, combination_mode))
        self._grow_waiting_seeds()

    def _is_on_other_model(self, hit: Hit) -> bool:
        return self.selection is not None and hit.model_id != self.selection.model_id

    def _grow_waiting_seeds(self) -> None:
        """Grow from the pending clicks in order, as soon as the neighbour graph is built."""
        while self._waiting:
            seed = self._waiting[0]
            if seed is None:
                self._waiting.pop(0)
                self._keep_plane()
                continue
            try:
                piece = self.growth.piece(seed.hit, self._grow_waiting_seeds)
            except VomError as error:
                self._waiting.clear()
                self._context.report(error)
                break
            if piece is None and self.growth.is_pending:
                self._notify_change()
                return
            self._waiting.pop(0)
            if piece is not None:
                self.take(seed.hit.model_id, piece.mask, seed.combination_mode, tr(GROW_LABEL))
                self.growth.seed = seed
        self._notify_change()

    def regrow(self) -> None:
        """Repeat the last growth with the new tolerance."""
        seed, selection = self.growth.seed, self._selection
        if seed is not None and selection is not None and selection.last_step is not None:
            piece = self.growth.piece(seed.hit, lambda: None)
            if piece is not None:
                selection.change_last_step(
                    combine_masks(
                        selection.mask_before_last_step(), piece.mask, seed.combination_mode
                    )
                )
                self._store_draft()
        self._notify_change()

    # --- painting ----------------------------------------------------------------------------
    def _press(self, event: PointerEvent) -> None:
        self._is_pressed, self._stroke, self._live_measurement = True, None, None
        self._stroke_combination = combination(event, self.combine)
        self._is_removing = self._stroke_combination == "subtract"
        self._paint(event.hit)
        self._measure_live()
        self._notify_change()

    def _begin_stroke(self, hit: Hit) -> Stroke | None:
        """Start a stroke where the brush meets a surface, or show why not and return None."""
        model = get(self._context.session.records, hit.model_id, Model)
        surface, selection = self._context.surface(hit.model_id), self.selection
        was_empty = self._stroke_combination in ("new", "intersect") or selection is None
        problem: Finding | None = None
        if model is None or surface is None:
            problem = Finding("model.removed")
        elif self._stroke_combination != "new" and self._is_on_other_model(hit):
            problem = Finding("tool.other-model")
        elif self._stroke_combination in ("subtract", "intersect") and selection is None:
            problem = Finding("selection.empty")
        if problem is not None or model is None or surface is None:
            self._is_pressed = False
            if problem is not None:
                self._context.hint(problem)
            self._context.tool_changed()
            return None
        self._suggest_radius(model, surface)
        previous_mask = np.zeros(surface.count, np.bool_)
        if not was_empty and selection is not None and len(selection.mask) == surface.count:
            previous_mask = selection.mask
        return Stroke.begin(hit, model, surface, previous_mask, is_removing=self._is_removing)

    def _paint(self, hit: Hit | None) -> None:
        self._hover_hit = hit
        if hit is None:
            return
        if self._stroke is None:
            self._stroke = self._begin_stroke(hit)
        stroke = self._stroke
        if stroke is not None and hit.model_id == stroke.model.id:
            stroke.paint(hit, self.radius)

    def _release(self) -> None:
        stroke, combination_mode = self._stroke, self._stroke_combination
        self._stop_stroke()
        if stroke is not None and stroke.count:
            # The stroke already contains the previous selection.
            step_name = ERASE_LABEL if stroke.is_removing else PAINT_LABEL
            next_combine: Combine = "intersect" if combination_mode == "intersect" else "new"
            self.take(stroke.model.id, stroke.is_selected, next_combine, tr(step_name))
        self._notify_change()

    def _stop_stroke(self) -> None:
        self._is_pressed, self._stroke, self._live_measurement, self._is_removing = (
            False,
            None,
            None,
            False,
        )

    def _measure_live(self) -> None:
        """Fit a plane to the painted area, unless a slow fit has just been made."""
        stroke, start_time = self._stroke, time.perf_counter()
        if stroke is None or not stroke.is_due(start_time):
            return
        ids = stroke.ids()
        if not len(ids):
            self._live_measurement, stroke.measured_count = None, stroke.count
            return
        patch = self._continued_patch or new_patch(
            self._context, stroke.model, stroke.surface.element
        )
        self._live_measurement = self._context.measure(
            patch.replace_fields(**stroke.figures(ids, is_whole=False))
        )
        stroke.record_measurement(start_time)

    def take(self, model_id: str, mask: BoolArray, combination: Combine, step: str) -> None:
        self.growth.seed = None
        if self._continued_patch is not None and self._continued_patch.model_id != model_id:
            self._context.hint(Finding("tool.other-model"))
            return
        super().take(model_id, mask, combination, step)

    # --- start and end ------------------------------------------------------------------------
    def continue_feature(self, feature_id: str) -> None:
        """Change a plane of the document. Raises DocumentError."""
        if self.is_open:
            raise DocumentError(Finding("feature.open"))
        patch = get(self._context.session.records, feature_id, Patch)
        if patch is None:
            raise DocumentError(Finding("tool.other-kind"))
        surface = self._context.surface(patch.model_id)
        if surface is None:
            raise DocumentError(Finding("model.not-open", model=patch.model_id))
        selection = ElementSelection(patch.model_id, surface.count)
        ids = runs_to_ids(patch.runs)
        mask = np.zeros(surface.count, np.bool_)
        mask[ids[ids < surface.count]] = True
        selection.start(mask)
        self._continued_patch, self._hover_hit, self.growth.seed = patch, None, None
        self.adopt(selection)

    def undo(self) -> bool:
        if self._is_pressed:
            return False
        self.growth.seed = None
        if self._waiting:
            self._waiting.pop()
            self._notify_change()
            return True
        return super().undo()

    def redo(self) -> bool:
        self.growth.seed = None
        return super().redo()

    def finish(self) -> str | None:
        """Close the unfinished shape, or else store the plane and return its id.

        Returns None if a shape was closed, if clicks are pending, or if the plane was not stored.
        """
        if self._is_pressed:
            self._release()
        if self._shape is not None:
            self._close_shape()
            return None
        if self._waiting:
            if self._waiting[-1] is not None:
                self._waiting.append(None)
                self._notify_change()
            return None
        return self._keep_plane()

    def _keep_plane(self) -> str | None:
        selection = self.selection
        if selection is None:
            return None
        if selection.count > MAX_PLANE_ELEMENTS:
            self._context.report(
                Finding("selection.too-many", count=selection.count, maximum=MAX_PLANE_ELEMENTS)
            )
            return None
        patch = self._surrounding_patch(selection)
        if patch is None:
            self._context.report(Finding("model.not-open", model=selection.model_id))
            return None
        session = self._context.session
        try:
            session.apply(self._edit(patch), finishes_draft=session.draft is not None)
        except VomError as error:
            self._context.report(error)
            return None
        self._discard_state()
        self._context.report_created(patch.id)
        return patch.id

    def _surrounding_patch(self, selection: ElementSelection) -> Patch | None:
        if self._continued_patch is None:
            return self._preview.patch(selection)
        surface = self._context.surface(selection.model_id)
        stored_patch = get(self._context.session.records, self._continued_patch.id, Patch)
        if surface is None or surface.count != len(selection.mask):
            return None
        return replace(
            stored_patch or self._continued_patch, **patch_fields(surface, selection.ids())
        )

    def _edit(self, patch: Patch) -> Edit:
        records = self._context.session.records
        if get(records, patch.id, Patch) is not None:
            return edits.change_feature(records, patch)
        return edits.add_features(records, [patch])

    def _set_continued_patch(self, patch: Patch | None) -> None:
        self._continued_patch = patch

    def cancel(self) -> None:
        """Discard the stroke, shape or pending clicks, or else the plane; undo restores it."""
        if self._is_pressed:
            self._cancel_stroke()
        elif self._waiting:
            self._waiting.clear()
            self._notify_change()
        elif self._shape is not None or self._continued_patch is None:
            super().cancel()
        elif (selection := self.selection) is not None:
            if selection.last_step is None:
                self._discard_state()
                self._store_draft()
                return
            restore_continued_patch = partial(self._set_continued_patch, self._continued_patch)
            self._discard_selection(
                selection,
                f"Discard the changes of {self._continued_patch.name}",
                restore_continued_patch,
            )

    def _cancel_stroke(self) -> None:
        """Discard the unfinished stroke.

        Redo repeats the stroke or, if it was the first stroke of the plane, undo restores it.
        """
        stroke, had_stroke = self._stroke, self.count > 0
        if stroke is None or not stroke.count:
            self._stop_stroke()
            self._notify_change()
            return
        self._release()
        if had_stroke:
            self.undo()
        elif (selection := self.selection) is not None:
            self._discard_selection(selection, "Discard the stroke", lambda: None)

    def release(self) -> ElementSelection | None:
        self._waiting.clear()
        return super().release()

    def _discard_state(self) -> None:
        self._stop_stroke()
        self._continued_patch, self.growth.seed = None, None
        super()._discard_state()

    def leave(self) -> None:
        """End an unfinished stroke and discard an unfinished shape; the plane remains."""
        if self._is_pressed:
            self._release()
        self._hover_hit = None
        if not self.is_open:
            self._continued_patch = None
        super().leave()

    def clear_state(self) -> None:
        self._waiting.clear()
        self._stop_stroke()
        self._continued_patch, self.growth.seed, self._hover_hit = None, None, None
        super().clear_state()

    def document_changed(self) -> None:
        super().document_changed()
        records = self._context.session.records
        if any(seed is not None and seed.hit.model_id not in records for seed in self._waiting):
            self._waiting.clear()
            self._notify_change()
        if self._hover_hit is not None and not self._is_pressed:
            self._show_preview()

    # --- drafts ------------------------------------------------------------------------------
    def _extra_state(self) -> dict[str, Any]:
        return {
            "type_id": self._context.next_type_id,
            "set_name": self._context.next_set,
            "continued": "" if self._continued_patch is None else self._continued_patch.id,
        }

    def restore(self, state: Mapping[str, Any]) -> bool:
        records = self._context.session.records
        self._continued_patch = get(records, str(state.get("continued", "")), Patch)
        if not super().restore(state):
            self._continued_patch = None
            return False
        type_id = str(state.get("type_id", ""))
        if get(records, type_id, FeatureType) is not None:
            self._context.set_next_type(type_id, str(state.get("set_name", "")))
        return True

    # --- preview ------------------------------------------------------------------------------
    def _suggest_radius(self, model: Model, surface: SelectableSurface) -> None:
        if self._radius is None:
            radius = surface.extent * transform.scale_factor(model.to_world) * DEFAULT_RADIUS_SHARE
            self._radius = max(_round_to_series(radius), MIN_RADIUS_M)
            self._context.tool_changed()

    def _show_preview(self) -> None:
        brush, pending_positions = self._brush(), self._pending_positions()
        if brush is None and not self.is_open:
            self._context.show(None)
            return
        measurement = None if self._shape is not None else self.measurement
        type_id = (
            self._continued_patch.type_id if self._continued_patch else self._context.next_type_id
        )
        feature_type = get(self._context.session.records, type_id, FeatureType)
        verdict = measurement.verdict if measurement else None
        is_replaced = self._is_pressed and self._stroke_combination == "new"
        self._context.show(
            Preview(
                line=np.zeros((0, 3)),
                color=rgb(feature_type.color if feature_type is not None else BLANK_COLOR),
                reading=self._reading_lines(measurement),
                verdict=verdict.quality if verdict else None,
                brush=brush,
                area=None if is_replaced else self._preview.area(self.selection),
                stroke=None if self._stroke is None else self._stroke.area(),
                is_erasing=self._is_removing,
                outline=None if self._shape is None else self._shape.outline(),
                pending_positions=pending_positions,
            )
        )

    def _reading_lines(self, measurement: Measurement | None) -> tuple[str, ...]:
        if self._waiting:
            return (tr("Waiting for the neighbour graph"),)
        if measurement is None and self.count and self._shape is None and not self._is_pressed:
            return (tr("Press Enter to measure the plane"),)
        return plane_reading(self._context, measurement, is_painting=self._is_pressed)

    def _pending_positions(self) -> FloatArray | None:
        hits = [seed.hit for seed in self._waiting if seed is not None]
        return self._context.world_positions(hits) if hits else None

    def _brush(self) -> BrushRing | None:
        hit = self._hover_hit
        model = get(self._context.session.records, hit.model_id, Model) if hit else None
        surface = self._context.surface(hit.model_id) if hit else None
        if hit is None or surface is None or model is None or self.mode != "pick":
            return None
        self._suggest_radius(model, surface)
        radius = self.radius / transform.scale_factor(model.to_world)
        normal = surface.local_normal(hit.index, hit.position, radius)
        return BrushRing(
            transform.apply(model.to_world, [hit.position])[0],
            self.radius,
            None if normal is None else transform.rotate(model.to_world, [normal])[0],
            self._is_removing,
        )


def _round_to_series(length: float) -> float:
    """Round a length to the nearest 1, 2 or 5 times a power of ten."""
    power = 10.0 ** np.floor(np.log10(max(length, 1e-300)))
    return float(power * min((1.0, 2.0, 5.0, 10.0), key=lambda step: abs(step - length / power)))


def _round_to_two_digits(length: float) -> float:
    return float(f"{length:.2g}")


TOOL = ToolEntry(
    PlaneTool,
    label=to_translate("&Plane"),
    icon="layers-search-outline",
    key="P",
    tip=to_translate("Click or paint a surface to fit its plane."),
    order=20,
    uses_modifiers=True,
)
