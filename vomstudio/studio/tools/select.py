"""The tool that chooses faces of a mesh or points of a cloud, for a patch or to be cut out.

A state machine without Qt or VTK. What is chosen belongs to one model and is unfinished until Enter
makes a patch of it or Esc lets it go, which undo brings back. Every way of choosing is a step that
undo takes back. Shapes that are drawn over the picture choose what lies inside of them, by centres
of gravity of faces, and what is hidden only where the user has said so.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from vomstudio.core.arrays import BoolArray
from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry import transform
from vomstudio.project import edits
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import Model, get
from vomstudio.studio.tools.element_selection import ChosenElements, Combine, combined
from vomstudio.studio.tools.growth import Growth, Seed
from vomstudio.studio.tools.interaction_types import Button, Discarded, Pointer, PointerEvent
from vomstudio.studio.tools.screen_shape import DrawnShape
from vomstudio.studio.tools.select_changes import SelectChanges
from vomstudio.studio.tools.select_preview import SelectPreview
from vomstudio.studio.tools.selection_messages import HINTS, STEPS, Way, chosen_text, nothing_inside
from vomstudio.studio.tools.tool_context import ToolContext
from vomstudio.studio.tools.tool_entry import ToolEntry

if TYPE_CHECKING:
    from vomstudio.extraction.selection.visible_region import Looking

MOST_IN_PATCH = 2_000_000


class SelectTool:
    """Chooses faces or points; see the module.

    growth : of a piece from a click; changes : what else is done with what is chosen
    way : what a click or drag does; combine : what is done with what it finds; through : whether
    shapes take what is hidden too
    """

    name = "select"
    paints = True

    def __init__(self, context: ToolContext) -> None:
        self._context = context
        self.way: Way = "grow"
        self.combine: Combine = "new"
        self.through = False
        self._chosen: ChosenElements | None = None
        self.growth = Growth(context)
        self.changes = SelectChanges(self, context)
        self._shape: DrawnShape | None = None
        self._preview = SelectPreview(context)

    # --- state -------------------------------------------------------------------------------
    @property
    def open(self) -> bool:
        """Something is chosen, or a shape is being drawn."""
        return self._shape is not None or self.count > 0

    @property
    def count(self) -> int:
        """How many faces or points are chosen."""
        return 0 if self._chosen is None else self._chosen.count

    @property
    def chosen(self) -> ChosenElements | None:
        """What is chosen; None where nothing is."""
        return self._chosen if self.count else None

    @property
    def drawing(self) -> bool:
        """A shape is being drawn."""
        return self._shape is not None

    @property
    def undo_label(self) -> str | None:
        if self._shape is not None:
            return tr("Corner") if self._shape.corners > 1 else None
        return None if self._chosen is None else self._chosen.last_step

    @property
    def redo_label(self) -> str | None:
        chosen = None if self._shape is not None else self._chosen
        return None if chosen is None else chosen.next_step

    @property
    def measurement(self) -> Measurement | None:
        """Of the plane through what is chosen; None where that is too much to be measured live."""
        return self._preview.measurement(self.chosen)

    def hint(self) -> str:
        if self._shape is not None:
            return self._shape.hint()
        return tr(HINTS[self.way]) + " " + chosen_text(self.count)

    def why_not_finish(self) -> Finding | None:
        if self._shape is not None:
            return self._shape.why_not_close()
        return None if self.count else Finding("selection.empty")

    def why_not_cancel(self) -> Finding | None:
        return None if self.open else Finding("selection.empty")

    # --- settings ----------------------------------------------------------------------------
    def set_way(self, way: Way) -> None:
        """What the next click or drag does. A shape that is being drawn is let go."""
        self._shape = None
        self.way = way
        self._changed()

    def set_combine(self, combine: Combine) -> None:
        """What is done with what is found next, without Shift and Ctrl."""
        self.combine = combine
        self._changed()

    def set_tolerance(
        self, *, angle_deg: float | None = None, distance: float | None = None
    ) -> None:
        """Of what grows: degrees, metres."""
        if angle_deg is not None:
            self.growth.set_angle(angle_deg)
        if distance is not None:
            self.growth.set_distance(distance)
        self.grow_anew()

    def set_through(self, through: bool) -> None:
        """Whether shapes take what is hidden too."""
        self.through = through
        self._changed()

    # --- gestures ----------------------------------------------------------------------------
    def pointer(self, event: PointerEvent) -> None:
        """Draw shapes with the left button; see `Tool`."""
        if self._shape is not None and event.kind is Pointer.MOVE:
            self._shape.move(event)
            self._show()
            return
        if event.kind is Pointer.WHEEL:
            self.turn(event.turns, distance=event.shift)
            return
        if event.button is not Button.LEFT:
            return
        if event.kind in (Pointer.CLICK, Pointer.DOUBLE_CLICK):
            self._click(event)
        elif event.kind is Pointer.DRAG_START:
            self._press(event)
        elif event.kind is Pointer.DRAG_MOVE and self._shape is not None:
            self._shape.drag(event)
            if not event.more:
                self._show()
        elif event.kind is Pointer.DRAG_END and self._shape is not None:
            self._shape.drag(event)
            if self._shape.way != "polygon":
                self._close()

    def _click(self, event: PointerEvent) -> None:
        if self.way == "grow":
            self._grow(event)
        elif self.way == "polygon":
            if self._shape is None:
                self._begin(event)
            elif self._shape.corner(event):
                self._close()
                return
            self._changed()
        else:
            self._context.hint(Finding("selection.hold-button"))

    def _press(self, event: PointerEvent) -> None:
        if self.way == "grow":
            # A click whose hand has moved.
            self._grow(event)
            return
        if self.way == "polygon" and self._shape is not None:
            self._shape.corner(event)
        else:
            self._begin(event)
        self._changed()

    def _grow(self, event: PointerEvent) -> None:
        if event.hit is None:
            self._context.hint(Finding("tool.no-surface"))
            return
        how = combination(event, self.combine)
        if self.chosen is not None and how != "new" and event.hit.model_id != self.chosen.model_id:
            self._context.hint(Finding("tool.other-model"))
            return
        self.growth.seed = None
        self._grow_from(Seed(event.hit, how))

    def _grow_from(self, seed: Seed) -> None:
        piece = self.growth.piece(seed.hit, lambda: self._grow_from(seed))
        if piece is not None:
            self.take(seed.hit.model_id, piece.mask, seed.how, tr(STEPS["grow"]))
            self.growth.seed = seed

    def turn(self, turns: float, *, distance: bool) -> None:
        """Change a tolerance by notches of the wheel."""
        self.growth.turn(turns, distance=distance)
        self.grow_anew()

    def grow_anew(self) -> None:
        """The tolerance has changed: the piece that was grown last follows."""
        seed, chosen = self.growth.seed, self._chosen
        if seed is not None and chosen is not None and chosen.last_step is not None:
            piece = self.growth.piece(seed.hit, lambda: None)
            if piece is not None:
                chosen.change_last(combined(chosen.before_last(), piece.mask, seed.how))
                self._keep_draft()
        self._changed()

    def _begin(self, event: PointerEvent) -> None:
        if event.in_photo:
            self._context.hint(Finding("selection.not-in-photo"))
            return
        how = combination(event, self.combine)
        self._shape = DrawnShape(self.way, how, (event.x, event.y))

    def _close(self) -> None:
        """Choose what lies inside of the shape."""
        shape, self._shape = self._shape, None
        looking = self._context.elements.looking()
        if shape is None or looking is None:
            return
        before, how = self._chosen, shape.combine
        ids = self._models(how)
        found = inside(self._context, looking, shape, ids, through=self.through)
        best = max(found, key=lambda id_: int(np.count_nonzero(found[id_])), default=None)
        if best is None:
            self._context.hint(Finding("selection.no-model"))
        elif not found[best].any() and (before is None or how in ("new", "add")):
            self._context.hint(nothing_inside(through=self.through))
        else:
            self.take(best, found[best], how, tr(STEPS[shape.way]))
        self._changed()

    def _models(self, how: Combine) -> list[str]:
        """Where to look: what is added to or taken from belongs to one model."""
        shown = self._context.elements.shown()
        if self.chosen is not None and how != "new":
            return [id_ for id_ in shown if id_ == self.chosen.model_id]
        return shown

    def take(self, model_id: str, found: BoolArray, how: Combine, step: str) -> None:
        """Choose what has been found on a model. step : in words, as undo names it"""
        chosen = self._chosen
        if chosen is None or chosen.model_id != model_id or len(chosen.mask) != len(found):
            if how in ("subtract", "intersect"):
                self._context.hint(Finding("selection.empty"))
                return
            chosen = ChosenElements(model_id, len(found))
        self.growth.seed = None
        hidden = self._context.elements.hidden(model_id)
        if hidden is not None:
            found = found & ~hidden
        if not chosen.change(combined(chosen.mask, found, how), step):
            self._context.hint(Finding("selection.no-change"))
            return
        self._chosen = chosen
        self._keep_draft()
        self._changed()

    # --- beginning and end -------------------------------------------------------------------
    def undo(self) -> bool:
        """Take the last corner of the shape back, else the last step."""
        if self._shape is not None:
            if not self._shape.take_back():
                self._shape = None
            self._changed()
            return True
        return self._chosen is not None and self._stepped(self._chosen.undo())

    def redo(self) -> bool:
        """Do the step again that was taken back last."""
        return self._chosen is not None and self._stepped(self._chosen.redo())

    def _stepped(self, done: bool) -> bool:
        self.growth.seed = None
        if done:
            self._keep_draft()
            self._changed()
        return done

    def finish(self) -> str | None:
        """Close the shape that is being drawn, else make a patch of what is chosen."""
        if self._shape is not None:
            if (reason := self._shape.why_not_close()) is not None:
                self._context.hint(reason)
            else:
                self._close()
            return None
        chosen = self.chosen
        if chosen is None:
            return None
        if chosen.count > MOST_IN_PATCH:
            self._context.say(
                Finding("selection.too-many", count=chosen.count, maximum=MOST_IN_PATCH)
            )
            return None
        patch = self._preview.patch(chosen)
        if patch is None:
            self._context.say(Finding("model.not-open", model=chosen.model_id))
            return None
        session = self._context.session
        before = session.top
        try:
            added = edits.add_features(session.records, [patch])
            session.apply(added, finishes_draft=session.draft is not None)
        except VomError as error:
            self._context.say(error)
            return None
        # Undo takes the patch back, and once more brings what was chosen for it.
        self._let_go(chosen, "Let go of what was chosen", lambda: None, after=before)
        self._context.created(patch.id)
        return patch.id

    def cancel(self) -> None:
        """Let the shape go that is being drawn, else what is chosen, which undo brings back."""
        if self._shape is not None:
            self._shape = None
            self._changed()
            return
        chosen = self.chosen
        if chosen is None:
            return
        self._let_go(chosen, "Discard what was chosen", lambda: None)

    def hide_chosen(self) -> None:
        """Hide what is chosen; undo shows and chooses it again."""
        chosen, elements = self.chosen, self._context.elements
        if chosen is None:
            return
        model_id, before = chosen.model_id, elements.hidden(chosen.model_id)
        elements.hide(model_id, chosen.mask if before is None else chosen.mask | before)
        self._let_go(chosen, "Hide what was chosen", lambda: elements.hide(model_id, before))

    def _let_go(
        self,
        chosen: ChosenElements,
        label: str,
        back: Callable[[], None],
        after: int | None = None,
    ) -> None:
        self._drop()
        self._keep_draft()
        chosen.settle()

        def bring_back() -> bool:
            back()
            self._chosen = chosen
            self._keep_draft()
            self._changed()
            return True

        untouched = chosen.mask
        self._context.discarded(
            Discarded(
                self.name,
                label,
                bring_back,
                lambda: self._chosen is chosen and np.array_equal(chosen.mask, untouched),
                after,
            )
        )

    def _drop(self) -> None:
        self._chosen, self._shape, self.growth.seed = None, None, None
        self._preview.forget()
        self._changed()

    def leave(self) -> None:
        """Another tool is chosen: what is chosen stays, a shape that is being drawn does not."""
        self._shape = None
        self._changed()

    def forget(self) -> None:
        """The project is being closed; what is chosen is kept as a draft."""
        self._chosen, self._shape, self.growth.seed = None, None, None
        self._preview.forget()
        self._context.show(None)

    def set_type(self, type_id: str, set_name: str) -> None:
        """Type and set are those of the patch that Enter will make."""
        self._preview.forget_measurement()
        if self.open:
            self._show()

    def document_changed(self) -> None:
        """The model of what is chosen may have been removed."""
        chosen = self._chosen
        if chosen is not None and chosen.model_id not in self._context.session.records:
            self._drop()
            self._keep_draft()

    # --- drafts ------------------------------------------------------------------------------
    def _keep_draft(self) -> None:
        chosen = self.chosen
        state = None if chosen is None else chosen.to_dict()
        try:
            self._context.session.set_draft(
                None if state is None else {"tool": self.name, "chosen": state}
            )
        except VomError as error:
            self._context.say(error)

    def restore(self, state: Mapping[str, Any]) -> bool:
        try:
            chosen = ChosenElements.from_dict(state["chosen"])
        except (KeyError, TypeError, ValueError):
            return False
        if chosen.model_id not in self._context.session.records:
            return False
        self._chosen = chosen
        self._changed()
        return True

    # --- what is seen ------------------------------------------------------------------------
    def _changed(self) -> None:
        self._show()
        self._context.tool_changed()

    def _show(self) -> None:
        self._preview.show(self.chosen, self._shape)


def inside(
    context: ToolContext,
    looking: Looking,
    shape: DrawnShape,
    model_ids: list[str],
    *,
    through: bool,
) -> dict[str, BoolArray]:
    """By model, what lies inside of a shape."""
    filled = looking.filled(shape.ring())
    elements, found = context.elements, {}
    for model_id in model_ids:
        data = elements.data(model_id)
        model = get(context.session.records, model_id, Model)
        if data is not None and model is not None:
            found[model_id] = looking.inside(
                data,
                transform.matrix(model.to_world),
                filled,
                through=through,
                spacing=elements.spacing(model_id) * transform.scale_of(model.to_world),
            )
    return found


def combination(event: PointerEvent, usual: Combine) -> Combine:
    """Shift adds, Ctrl takes away, both keep what is in both; else as usual."""
    if event.shift and event.ctrl:
        return "intersect"
    if event.shift:
        return "add"
    return "subtract" if event.ctrl else usual


TOOL = ToolEntry(
    SelectTool,
    label=to_translate("&Select"),
    icon="lasso",
    key="S",
    tip=to_translate(
        "Choose faces or points by growing from a click, or by drawing around them; for a patch, "
        "to hide them, or to cut them out."
    ),
    order=25,
    takes_keys=True,
)
