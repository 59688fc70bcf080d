"""Patch tool, a round brush that selects the faces or points of one surface.

The tool is a state machine without Qt or VTK. A stroke consists of a press, a drag and a
release, and is one edit of the document. The first stroke creates the patch and later strokes
change it, so that undo reverts strokes and no painted area can be lost. Only an unfinished
stroke is `open`; `current` is the patch that the next stroke changes.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from vomstudio.core.errors import DocumentError, VomError
from vomstudio.core.findings import Finding
from vomstudio.core.identifiers import new_id
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry import transform
from vomstudio.geometry.brush import PaintSurface
from vomstudio.project import edits
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import FeatureType, Model, Record, get
from vomstudio.studio.tools.brush_stroke import Stroke
from vomstudio.studio.tools.interaction_types import (
    BrushRing,
    Button,
    Discarded,
    Hit,
    Pointer,
    PointerEvent,
    Preview,
)
from vomstudio.studio.tools.patch_readout import patch_reading
from vomstudio.studio.tools.polyline import rgb
from vomstudio.studio.tools.tool_context import ToolContext
from vomstudio.studio.tools.tool_entry import NoSteps, ToolEntry

MIN_RADIUS_M, MAX_RADIUS_M = 1e-3, 1e4
RADIUS_FACTOR = 1.25
# Initial size of the brush as a share of the model size.
DEFAULT_RADIUS_SHARE = 1.0 / 80.0
ERASER_COLOR = (1.0, 1.0, 1.0)
_HINT_NEW = to_translate(
    "Patch: paint over one surface with the left button; the right button orbits; "
    "[ and ] change the brush size."
)
_HINT_ADDS = to_translate(
    "Patch {patch}: the next stroke adds, with Ctrl it erases. Enter finishes; Esc discards the "
    "strokes; the right button orbits; [ and ] change the brush size."
)
_HINT_ERASES = to_translate(
    "Patch {patch}: the next stroke erases, with Ctrl it adds. Enter finishes; Esc discards the "
    "strokes; the right button orbits; [ and ] change the brush size."
)


class PatchTool(NoSteps):
    """Tool that paints patches; see the module."""

    name = "patch"
    paints = True

    def __init__(self, context: ToolContext) -> None:
        self._context = context
        self._radius: float | None = None
        self.removing = False
        self._id: str | None = None
        self._original: Patch | None = None
        self._down = False
        self._stroke: Stroke | None = None
        self._hover: Hit | None = None
        self._ctrl = False
        self._measured: tuple[Patch, Record | None, Measurement] | None = None
        self._live: Measurement | None = None
        self._given_up: tuple[int, str, Patch | None] | None = None

    # --- state -------------------------------------------------------------------------------
    @property
    def open(self) -> bool:
        """Whether a stroke is being painted."""
        return self._down

    @property
    def current(self) -> Patch | None:
        """Patch that the next stroke changes, or None if it creates a new patch."""
        return get(self._context.session.records, self._id, Patch)

    @property
    def continued(self) -> bool:
        """Whether the current patch existed before this tool continued it."""
        return self._original is not None and self.current is not None

    @property
    def radius(self) -> float:
        """Radius of the brush, metres."""
        return self._radius if self._radius is not None else 0.1

    @property
    def measurement(self) -> Measurement | None:
        """Measurement of the patch, including the unfinished stroke."""
        if self._live is not None:
            return self._live
        patch = self.current
        if patch is None:
            return None
        model = self._context.session.records.get(patch.model_id)
        cached = self._measured
        if cached is None or cached[0] is not patch or cached[1] is not model:
            cached = self._measured = (patch, model, self._context.measure(patch))
        return cached[2]

    def hint(self) -> str:
        if self._down:
            return tr("Patch: releasing the button ends the stroke; Esc discards it.")
        patch = self.current
        if patch is None:
            return tr(_HINT_NEW)
        return tr(_HINT_ERASES if self.removing else _HINT_ADDS, patch=patch.name)

    def why_not_finish(self) -> Finding | None:
        return None if self._down or self.current is not None else Finding("tool.nothing-open")

    def why_not_cancel(self) -> Finding | None:
        return self.why_not_finish()

    # --- the brush ---------------------------------------------------------------------------
    def set_radius(self, metres: float) -> None:
        """Set the radius of the brush in metres, limited to the permitted range."""
        metres = min(max(float(metres), MIN_RADIUS_M), MAX_RADIUS_M)
        if metres != self._radius:
            self._radius = metres
            self._show()
            self._context.tool_changed()

    def larger(self) -> None:
        """Enlarge the brush by one step."""
        self.set_radius(_two_digits(self.radius * RADIUS_FACTOR))

    def smaller(self) -> None:
        """Shrink the brush by one step."""
        self.set_radius(_two_digits(self.radius / RADIUS_FACTOR))

    def set_removing(self, removing: bool) -> None:
        """Set whether strokes erase; Ctrl inverts the setting."""
        self.removing = removing
        self._show()
        self._context.tool_changed()

    # --- gestures ----------------------------------------------------------------------------
    def pointer(self, event: PointerEvent) -> None:
        """Paint while the left button is held; see `Tool`."""
        if event.kind is Pointer.MOVE:
            self._ctrl, self._hover = event.ctrl, event.hit
            self._show()
        elif event.button is not Button.LEFT:
            return
        elif event.kind in (Pointer.CLICK, Pointer.DOUBLE_CLICK):
            if event.hit is None:
                self._context.hint(Finding("tool.no-surface"))
            elif not event.shift:
                self._press(event)
                self._release()
        elif event.kind is Pointer.DRAG_START:
            self._press(event)
        elif event.kind is Pointer.DRAG_MOVE and self._down:
            self._paint(event.hit)
            if not event.more:
                self._measure_live()
                self._show()
        elif event.kind is Pointer.DRAG_END and self._down:
            self._paint(event.hit)
            self._release()

    def _press(self, event: PointerEvent) -> None:
        self._down, self._ctrl, self._stroke = True, event.ctrl, None
        self._paint(event.hit)
        self._measure_live()
        self._show()
        self._context.tool_changed()

    def _begin(self, hit: Hit) -> Stroke | None:
        """Start a stroke where the brush first meets a surface."""
        records = self._context.session.records
        model, surface = records.get(hit.model_id), self._context.surface(hit.model_id)
        patch, removes = self.current, self.removing != self._ctrl
        problem: Finding | None = None
        if not isinstance(model, Model) or surface is None:
            problem = Finding("model.removed")
        elif patch is not None and patch.model_id != model.id:
            problem = Finding("tool.other-model")
        elif patch is None and removes:
            problem = Finding("tool.no-patch")
        if problem is not None or not isinstance(model, Model) or surface is None:
            self._down = False
            if problem is not None:
                self._context.hint(problem)
            self._context.tool_changed()
            return None
        self._suggest_radius(model, surface)
        return Stroke.begin(hit, model, surface, patch, removes=removes)

    def _paint(self, hit: Hit | None) -> None:
        self._hover = hit
        if hit is None:
            return
        if self._stroke is None:
            self._stroke = self._begin(hit)
        stroke = self._stroke
        if stroke is None or hit.model_id != stroke.model.id:
            return
        stroke.paint(hit, self.radius)

    def _release(self) -> None:
        stroke, self._down, self._stroke = self._stroke, False, None
        self._live = None
        if stroke is not None and stroke.count:
            try:
                self._keep(stroke)
            except VomError as error:
                self._context.report(error)
        self._show()
        self._context.tool_changed()

    def _keep(self, stroke: Stroke) -> None:
        """Apply a finished stroke as an edit."""
        session, patch = self._context.session, self.current
        ids = stroke.ids()
        if not len(ids):
            if patch is not None:
                session.apply(edits.delete(session.records, [patch.id]))
            return
        begun = patch or new_patch(self._context, stroke.model, stroke.surface.element)
        painted = replace(begun, **stroke.figures(ids, whole=True))
        if patch is None:
            session.apply(edits.add_features(session.records, [painted]))
            self._id, self._original = painted.id, None
        else:
            what = "Erase from" if stroke.removes else "Paint"
            session.apply(edits.change_feature(session.records, painted, what))
        self._context.created(painted.id)

    def _measure_live(self) -> None:
        """Fit a plane to the painted area, unless a slow fit was made just before."""
        stroke, started = self._stroke, time.perf_counter()
        if stroke is None or not stroke.due(started):
            return
        ids = stroke.ids()
        if not len(ids):
            self._live, stroke.measured = None, stroke.count
            return
        patch = self.current or new_patch(self._context, stroke.model, stroke.surface.element)
        self._live = self._context.measure(replace(patch, **stroke.figures(ids, whole=False)))
        stroke.note_measured(started)

    # --- start and end ------------------------------------------------------------------------
    def continue_patch(self, patch_id: str) -> None:
        """Continue painting a patch of the document. Raises DocumentError."""
        if self._down:
            raise DocumentError(Finding("tool.stroke-open"))
        patch = get(self._context.session.records, patch_id, Patch)
        if patch is None:
            raise DocumentError(Finding("tool.other-kind"))
        if self._context.surface(patch.model_id) is None:
            raise DocumentError(Finding("model.not-open", model=patch.model_id))
        self._id, self._original, self._hover = patch.id, patch, None
        self._show()
        self._context.tool_changed()

    def undo(self) -> bool:
        """Return False, because an unfinished stroke can only be released or discarded."""
        return self._down

    def finish(self) -> str | None:
        """Finish the patch; the next stroke creates a new patch."""
        if self._down:
            self._release()
        patch = self.current
        if patch is None:
            return None
        self._reset()
        self._context.created(patch.id)
        return patch.id

    def cancel(self) -> None:
        """Discard the unfinished stroke, or else all strokes of the current patch.

        Undo restores the strokes.
        """
        if self._down:
            self._discard_stroke()
            return
        patch, original = self.current, self._original
        if patch is None:
            return
        session = self._context.session
        top = session.top
        try:
            if original is None:
                session.apply(edits.delete(session.records, [patch.id]))
                self._context.hint(Finding("feature.discarded", feature=patch.name))
            elif patch.runs != original.runs:
                values = {name: getattr(original, name) for name in _PAINTED}
                what = "Discard strokes on"
                session.apply(edits.change_feature(session.records, replace(patch, **values), what))
                self._context.hint(Finding("feature.strokes-discarded", feature=patch.name))
        except VomError as error:
            self._context.report(error)
            return
        self._reset()
        self._given_up = (top, patch.id, original)

    def _discard_stroke(self) -> None:
        """Discard the unfinished stroke, which undo restores."""
        stroke, self._down, self._stroke, self._live = self._stroke, False, None, None
        self._show()
        self._context.tool_changed()
        if stroke is None or not stroke.count:
            return

        def paint() -> bool:
            try:
                self._keep(stroke)
            except VomError as error:
                self._context.report(error)
                return False
            self._show()
            self._context.tool_changed()
            return True

        self._context.discarded(Discarded(self.name, "Discard the stroke", paint, lambda: False))

    def leave(self) -> None:
        """Finish an unfinished stroke before another tool becomes active."""
        if self._down:
            self._release()
        self._reset()
        self._given_up = None
        self._context.show(None)

    def forget(self) -> None:
        """Reset because the project is being closed; its journal contains finished strokes."""
        self._down, self._stroke = False, None
        self._reset()
        self._given_up = None
        self._context.show(None)

    def _reset(self) -> None:
        self._id, self._original, self._live, self._measured = None, None, None, None
        # The next stroke creates a patch, from which nothing can be erased.
        self.removing = False
        self._show()
        self._context.tool_changed()

    def restore(self, state: Mapping[str, Any]) -> bool:
        """Return False, because strokes are edits and the tool has no drafts."""
        return False

    def set_type(self, type_id: str, set_name: str) -> None:
        """Set the feature type and set of the current patch, unless it was continued."""
        patch = self.current
        if patch is None or self.continued:
            return
        values = {
            key: value
            for key, value in (("type_id", type_id), ("set_name", set_name))
            if getattr(patch, key) != value
        }
        if values:
            session = self._context.session
            try:
                session.apply(edits.set_attributes(session.records, [patch.id], **values))
            except VomError as error:
                self._context.report(error)
        self._show()

    def document_changed(self) -> None:
        """Continue with a patch that undo has changed or restored."""
        given_up = self._given_up
        if self._id is None and given_up and given_up[0] == self._context.session.top:
            _, self._id, self._original = given_up
            self._context.tool_changed()
        if not self._down and self._hover is not None:
            self._show()

    # --- preview ------------------------------------------------------------------------------
    def _suggest_radius(self, model: Model, surface: PaintSurface) -> None:
        if self._radius is None:
            radius = surface.extent * transform.scale_factor(model.to_world) * DEFAULT_RADIUS_SHARE
            self._radius = max(_round(radius), MIN_RADIUS_M)
            self._context.tool_changed()

    def _show(self) -> None:
        brush = self._brush()
        measurement = self.measurement
        stroke = self._stroke
        removes = self.removing != self._ctrl if stroke is None else stroke.removes
        area = None if stroke is None else stroke.area()
        if brush is None and measurement is None and area is None:
            self._context.show(None)
            return
        patch, records = self.current, self._context.session.records
        kind = records.get(patch.type_id if patch else self._context.next_type_id)
        color = rgb(kind.color if isinstance(kind, FeatureType) else "#e69f00")
        verdict = measurement.verdict if measurement else None
        self._context.show(
            Preview(
                line=np.zeros((0, 3)),
                color=ERASER_COLOR if removes else color,
                reading=patch_reading(self._context, measurement, painting=self._down),
                verdict=verdict.quality if verdict else None,
                brush=brush,
                area=area,
            )
        )

    def _brush(self) -> BrushRing | None:
        hit = self._hover
        model = self._context.session.records.get(hit.model_id) if hit else None
        surface = self._context.surface(hit.model_id) if hit else None
        if hit is None or surface is None or not isinstance(model, Model):
            return None
        self._suggest_radius(model, surface)
        radius = self.radius / transform.scale_factor(model.to_world)
        normal = surface.normal_near(hit.index, hit.position, radius)
        return BrushRing(
            transform.apply(model.to_world, [hit.position])[0],
            self.radius,
            None if normal is None else transform.rotate(model.to_world, [normal])[0],
            self.removing != self._ctrl,
        )


_PAINTED = (
    "runs",
    "n",
    "mean",
    "scatter",
    "n_effective",
    "outline",
    "area",
    "resolution",
    "rule",
    "level_gap",
    "bent",
    "bend_deg",
)


def new_patch(context: ToolContext, model: Model, element: Literal["face", "point"]) -> Patch:
    """Create an empty patch with the next feature type and set."""
    zero = (0.0, 0.0, 0.0)
    return Patch(
        id=new_id("patch"),
        name="",
        type_id=context.next_type_id,
        model_id=model.id,
        model_hash=model.content_hash,
        element=element,
        runs=(),
        n=0,
        mean=zero,
        scatter=(zero, zero, zero),
        n_effective=0.0,
        set_name=context.next_set,
    )


def _round(length: float) -> float:
    """Round a length to the nearest 1, 2 or 5 times a power of ten."""
    power = 10.0 ** np.floor(np.log10(max(length, 1e-300)))
    return float(power * min((1.0, 2.0, 5.0, 10.0), key=lambda step: abs(step - length / power)))


def _two_digits(length: float) -> float:
    return float(f"{length:.2g}")


TOOL = ToolEntry(
    PatchTool,
    label=to_translate("&Patch"),
    icon="brush",
    key="P",
    tip=to_translate("Paint over one surface; its plane is fitted as you paint."),
    order=20,
)
