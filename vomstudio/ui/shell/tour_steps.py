"""Steps of the introductory tour: target, instruction and condition of completion."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QToolBar, QToolButton, QWidget

from vomstudio.core.words import to_translate, tr
from vomstudio.project.kinds.trace import Trace
from vomstudio.ui.base.number_formatting import orientation_text
from vomstudio.ui.base.studio import Notice, Studio
from vomstudio.ui.base.window_protocols import Docks
from vomstudio.ui.outcrop.outcrop_view import OutcropView

_TURNED_DEG = 8.0


@dataclass(frozen=True)
class TourStep:
    """Step of the tour.

    `text` is marked for translation. `target` returns the widget concerned, or None if it is not
    visible. `now` returns a state, and `done` receives the state at the start of the step and
    returns whether the step is complete. If `has_next_button` is True, the step needs no action,
    and its button is "Next". `result` describes what the user has done; this is shown together
    with the next step.
    """

    name: str
    text: str
    target: Callable[[], QWidget | None]
    now: Callable[[], Any]
    done: Callable[[Any], bool]
    has_next_button: bool = False
    result: Callable[[], str] = str


def find_button(action: QAction) -> QWidget | None:
    """Return the visible button or toolbar entry of an action, or None if it has none."""
    for holder in action.associatedObjects():
        button: QWidget | None = None
        if isinstance(holder, QToolBar):
            button = holder.widgetForAction(action)
        elif isinstance(holder, QToolButton):
            button = holder
        if button is not None and button.isVisible():
            return button
    return None


def steps(
    studio: Studio,
    actions: Mapping[str, QAction],
    view: OutcropView,
    docks: Docks,
) -> list[TourStep]:
    """Return the steps of the tour for a window with these parts."""

    def viewport() -> QWidget | None:
        return view.viewport

    def button(*names: str) -> Callable[[], QWidget | None]:
        return lambda: next((b for n in names if (b := find_button(actions[n])) is not None), None)

    def dock(name: str) -> Callable[[], QWidget | None]:
        return lambda: docks.find_page_widget(name)

    def direction() -> np.ndarray | None:
        return None if view.viewport is None else view.viewport.camera.direction.copy()

    def has_turned(previous_direction: np.ndarray | None) -> bool:
        current_direction = direction()
        if current_direction is None or previous_direction is None:
            return False
        return bool(current_direction @ previous_direction < np.cos(np.radians(_TURNED_DEG)))

    def picked_count() -> int:
        tool = studio.open_tool
        return len(getattr(tool, "vertices", ()))

    def traces() -> int:
        return len(studio.session.of(Trace))

    def create_mouse_check(name: str) -> Callable[[Any], bool]:
        def is_under_mouse(_: object) -> bool:
            place = docks.find_page_widget(name)
            return place is not None and place.underMouse()

        return is_under_mouse

    def is_saved(_: object) -> bool:
        return not (studio.project.is_untitled or studio.session.dirty)

    orthophotos: list[str] = []

    def note(notice: Notice) -> None:
        if notice.code == "ortho.written" and notice.file is not None:
            orthophotos.append(notice.file.name)

    studio.notice.connect(note)

    def plane_text() -> str:
        trace = studio.session.of(Trace)[-1]
        orientation = orientation_text(studio.measure(trace), studio.settings.notation)
        return f"{trace.name}: {orientation}"

    def no_state() -> None:
        return None

    return [
        TourStep(
            "open",
            to_translate(
                "Open the sample outcrop: click the button, or search for it with Ctrl+K."
            ),
            button("open_sample", "open"),
            no_state,
            lambda _: bool(studio.models),
            result=lambda: tr("The model is open."),
        ),
        TourStep(
            "turn",
            to_translate(
                "Rotate the outcrop: drag with the left mouse button. The wheel zooms to the"
                " cursor; Home shows the whole model."
            ),
            viewport,
            direction,
            has_turned,
        ),
        TourStep(
            "trace",
            to_translate(
                "Choose the trace tool, here or with the key T. It fits a plane to a line of"
                " clicks."
            ),
            button("trace"),
            no_state,
            lambda _: studio.tool_name == "trace",
        ),
        TourStep(
            "pick",
            to_translate(
                "Click at least five points along one bed, around a corner of the rock if"
                " possible. The plane is fitted as you click."
            ),
            viewport,
            no_state,
            lambda _: picked_count() >= 5,
        ),
        TourStep(
            "finish",
            to_translate(
                "Press Enter to save the trace. Undo (Ctrl+Z) reverts any step, including this one."
            ),
            viewport,
            traces,
            lambda before: traces() > before,
            result=plane_text,
        ),
        TourStep(
            "numbers",
            to_translate(
                "Choose Properties in the inspector. It shows the errors of the plane. Point at a"
                " value and press F1 for an explanation."
            ),
            lambda: docks.find_page_widget("properties") or docks.find_page_widget("tool"),
            no_state,
            create_mouse_check("properties"),
            has_next_button=True,
        ),
        TourStep(
            "net",
            to_translate(
                "The stereonet shows the same plane. Click its pole to select it in outcrop, table"
                " and net."
            ),
            dock("stereonet"),
            no_state,
            create_mouse_check("stereonet"),
            has_next_button=True,
        ),
        TourStep(
            "orthophoto",
            to_translate(
                "Make a true-to-scale picture along this view: press Ctrl+P, then choose Make"
                " orthophoto in the dialog."
            ),
            lambda: button("orthophoto")() or viewport(),
            lambda: len(orthophotos),
            lambda before: len(orthophotos) > before,
            result=lambda: tr("{file} has been saved.", file=orthophotos[-1]),
        ),
        TourStep(
            "save",
            to_translate("Save the project (Ctrl+S). Unsaved work also survives a crash."),
            button("save"),
            no_state,
            is_saved,
            result=lambda: tr("The project {name} has been saved.", name=studio.project.name),
        ),
    ]
