"""The tool that chooses faces of a mesh or points of a cloud, for a patch or to be cut out.

A state machine without Qt or VTK. What is chosen belongs to one model and is unfinished until Enter
makes a patch of it or Esc lets it go, which undo brings back. Every way of choosing is a step that
undo takes back. Shapes that are drawn over the picture choose what lies inside of them, by centres
of gravity of faces, and what is hidden only where the user has said so.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from vomstudio.document import edits
from vomstudio.document.measurement import Measurement
from vomstudio.document.records import FeatureType, Model, get
from vomstudio.errors import VomError
from vomstudio.geometry import transform
from vomstudio.tools.brush_stroke import figures_of
from vomstudio.tools.chosen_elements import ChosenElements, Combine, Mask, combined
from vomstudio.tools.drawn_shape import DrawnShape
from vomstudio.tools.interaction_types import Area, Button, Pointer, PointerEvent, Preview
from vomstudio.tools.open_steps import Discarded
from vomstudio.tools.painted_area import chosen_area
from vomstudio.tools.patch import new_patch
from vomstudio.tools.patch_reading import patch_reading
from vomstudio.tools.polyline import rgb
from vomstudio.tools.select_words import HINTS, STEPS, Way, chosen_text
from vomstudio.tools.tool_context import ToolContext
from vomstudio.tools.tool_entry import ToolEntry
from vomstudio.words import to_translate, tr

Ints = npt.NDArray[np.int64]

LIVE = 60_000
"""So many chosen faces or points are measured at every step; of more the plane is told by Enter."""
MOST_IN_PATCH = 2_000_000
_COLOR = (0.05, 0.75, 0.95)


class SelectTool:
    """Chooses faces or points; see the module.

    way : what a click or drag does; combine : what is done with what it finds; through : whether
    shapes take what is hidden too
    """

    name = "select"
    paints = True
    takes_keys = True

    def __init__(self, context: ToolContext) -> None:
        self._context = context
        self.way: Way = "lasso"
        self.combine: Combine = "new"
        self.through = False
        self._chosen: ChosenElements | None = None
        self._shape: DrawnShape | None = None
        self._area: tuple[Mask, Area | None] | None = None
        self._live: tuple[Mask, Measurement | None] | None = None

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
    def measurement(self) -> Measurement | None:
        """Of the plane through what is chosen; None where that is too much to be measured live."""
        chosen = self.chosen
        if chosen is None or chosen.count > LIVE:
            return None
        if self._live is None or self._live[0] is not chosen.mask:
            patch = self._patch(chosen)
            self._live = (chosen.mask, None if patch is None else self._context.measure(patch))
        return self._live[1]

    def hint(self) -> str:
        if self._shape is not None:
            return self._shape.hint()
        return tr(HINTS[self.way]) + " " + chosen_text(self)

    def why_not_finish(self) -> str | None:
        if self._shape is not None:
            return self._shape.why_not_close()
        return None if self.count else tr("Nothing is chosen.")

    def why_not_cancel(self) -> str | None:
        return None if self.open else tr("Nothing is chosen.")

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
        if self.way == "polygon":
            if self._shape is None:
                self._begin(event)
            elif self._shape.corner(event):
                self._close()
                return
            self._changed()
        else:
            self._context.hint(tr("Hold the left button and draw around what you want."))

    def _press(self, event: PointerEvent) -> None:
        if self.way == "polygon" and self._shape is not None:
            # A click whose hand has moved.
            self._shape.corner(event)
        else:
            self._begin(event)
        self._changed()

    def _begin(self, event: PointerEvent) -> None:
        how = combination(event, self.combine)
        self._shape = DrawnShape(self.way, how, (event.x, event.y))

    def _close(self) -> None:
        """Choose what lies inside of the shape."""
        shape, self._shape = self._shape, None
        looking = self._context.elements.looking()
        if shape is None or looking is None:
            return
        inside = looking.filled(shape.ring())
        before, how = self._chosen, shape.combine
        found: dict[str, Mask] = {}
        for model_id in self._models(how):
            data = self._context.elements.data(model_id)
            model = get(self._context.session.records, model_id, Model)
            if data is None or model is None:
                continue
            scale = transform.scale_of(model.to_world)
            found[model_id] = looking.inside(
                data,
                transform.matrix(model.to_world),
                inside,
                through=self.through,
                spacing=self._context.elements.spacing(model_id) * scale,
            )
        best = max(found, key=lambda id_: int(np.count_nonzero(found[id_])), default=None)
        if best is None:
            self._context.hint(tr("No model is open and shown, so there is nothing to choose."))
        elif not found[best].any() and (before is None or how in ("new", "add")):
            self._context.hint(self._nothing_inside())
        else:
            self.take(best, found[best], how, tr(STEPS[shape.way]))
        self._changed()

    def _nothing_inside(self) -> str:
        if self.through:
            return tr("No centre of a face and no point lies inside. Draw around more.")
        return tr(
            "Nothing that is seen lies inside. Draw around more, come nearer, or choose through "
            "the surface."
        )

    def _models(self, how: Combine) -> list[str]:
        """Where to look: what is added to or taken from belongs to one model."""
        shown = self._context.elements.shown()
        if self.chosen is not None and how != "new":
            return [id_ for id_ in shown if id_ == self.chosen.model_id]
        return shown

    def take(self, model_id: str, found: Mask, how: Combine, step: str) -> None:
        """Choose what has been found on a model. step : in words, as undo names it"""
        chosen = self._chosen
        if chosen is None or chosen.model_id != model_id or len(chosen.mask) != len(found):
            if how in ("subtract", "intersect"):
                self._context.hint(tr("Nothing is chosen yet that something could be taken from."))
                return
            chosen = ChosenElements(model_id, len(found))
        if not chosen.change(combined(chosen.mask, found, how), step):
            self._context.hint(tr("That changes nothing of what is chosen."))
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
        done = self._chosen is not None and self._chosen.undo()
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
                tr(
                    "{count:,} are too many for a patch, which is one plane: at most {most:,}. "
                    "Choose less, or cut it out as a model.",
                    count=chosen.count,
                    most=MOST_IN_PATCH,
                )
            )
            return None
        patch = self._patch(chosen)
        if patch is None:
            self._context.say(tr("The model of what is chosen is not open."))
            return None
        session = self._context.session
        try:
            session.apply(
                edits.add_features(session.records, [patch]),
                finishes_draft=session.draft is not None,
            )
        except VomError as error:
            self._context.say(str(error))
            return None
        self._drop()
        self._context.created(patch.id)
        return patch.id

    def _patch(self, chosen: ChosenElements) -> Any:
        surface = self._context.surface(chosen.model_id)
        model = get(self._context.session.records, chosen.model_id, Model)
        if surface is None or model is None or surface.count != len(chosen.mask):
            return None
        patch = new_patch(self._context, model, surface.element)
        return patch.but(**figures_of(surface, chosen.ids()))

    def cancel(self) -> None:
        """Let the shape go that is being drawn, else what is chosen, which undo brings back."""
        if self._shape is not None:
            self._shape = None
            self._changed()
            return
        chosen = self.chosen
        if chosen is None:
            return
        self._drop()
        self._keep_draft()

        def bring_back() -> bool:
            self._chosen = chosen
            self._keep_draft()
            self._changed()
            return True

        untouched = chosen.mask
        self._context.discarded(
            Discarded(
                self.name,
                "Discard what was chosen",
                bring_back,
                lambda: self._chosen is chosen and chosen.mask is untouched,
            )
        )

    def _drop(self) -> None:
        self._chosen, self._shape = None, None
        self._area = self._live = None
        self._changed()

    def leave(self) -> None:
        """Another tool is chosen: what is chosen stays, a shape that is being drawn does not."""
        self._shape = None
        self._changed()

    def forget(self) -> None:
        """The project is being closed; what is chosen is kept as a draft."""
        self._chosen, self._shape = None, None
        self._area = self._live = None
        self._context.show(None)

    def set_type(self, type_id: str, set_name: str) -> None:
        """Type and set are those of the patch that Enter will make."""
        self._live = None
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
        state = None if chosen is None else chosen.as_dict()
        try:
            self._context.session.set_draft(
                None if state is None else {"tool": self.name, "chosen": state}
            )
        except VomError as error:
            self._context.say(str(error))

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
        shape, chosen = self._shape, self.chosen
        if shape is None and chosen is None:
            self._context.show(None)
            return
        measurement = None if shape is not None else self.measurement
        records = self._context.session.records
        kind = records.get(self._context.next_type_id)
        verdict = measurement.verdict if measurement else None
        self._context.show(
            Preview(
                line=np.zeros((0, 3)),
                color=rgb(kind.color) if isinstance(kind, FeatureType) else _COLOR,
                reading=patch_reading(self._context, measurement, painting=False),
                verdict=verdict.quality if verdict else None,
                area=self._chosen_area(),
                outline=None if shape is None else shape.outline(),
            )
        )

    def _chosen_area(self) -> Area | None:
        chosen = self.chosen
        if chosen is None:
            return None
        if self._area is None or self._area[0] is not chosen.mask:
            surface = self._context.surface(chosen.model_id)
            model = get(self._context.session.records, chosen.model_id, Model)
            if surface is None or model is None or surface.count != len(chosen.mask):
                return None
            self._area = (chosen.mask, chosen_area(chosen.ids(), model, surface))
        return self._area[1]


def combination(event: PointerEvent, usual: Combine) -> Combine:
    """Shift adds, Ctrl takes away, both keep what is in both; else as usual."""
    if event.shift and event.ctrl:
        return "intersect"
    if event.shift:
        return "add"
    return "subtract" if event.ctrl else usual


TOOL = ToolEntry(
    SelectTool,
    label=to_translate("&Select on surface"),
    icon="lasso",
    key="S",
    tip=to_translate(
        "Choose faces or points by growing from a click, or by drawing around them; for a patch, "
        "to hide them, or to cut them out."
    ),
    order=25,
)
