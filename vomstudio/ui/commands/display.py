"""Commands for the display of models and for the clipping box."""

from __future__ import annotations

from collections.abc import Callable

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr, tr_n
from vomstudio.rendering.view.scalars import FieldStyle
from vomstudio.studio import display
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.base.window_protocols import Docks
from vomstudio.ui.outcrop.camera_view import CameraView
from vomstudio.ui.outcrop.outcrop_view import OutcropView

_DOCK_NAME = "display"

MODES_BY_COMMAND = {
    "display_textured": "textured",
    "display_colors": "vertex_colors",
    "display_plain": "plain shaded",
    "display_wireframe": "wireframe",
    "display_points": "points",
}


def commands(studio: Studio, view: OutcropView, cameras: CameraView, docks: Docks) -> list[Command]:
    """Create the display commands; `docks` contains the display page."""
    state = studio.display

    def models() -> list[display.ModelData]:
        return [m.data for m in studio.models.values()]

    def set_mode(value: str) -> Callable[[], None]:
        return lambda: state.set_mode(value)

    def is_mode(value: str) -> Callable[[], bool]:
        return lambda: current_mode() == value

    def current_mode() -> str:
        return display.effective_mode(state.mode, models())

    def toggle_lighting() -> None:
        state.set_lit(current_mode(), not state.lit[current_mode()])

    def mode_problem(value: str) -> Callable[[], Finding | None]:
        return lambda: display.mode_problem(value, models())

    def set_point_size(value: float | None) -> Callable[[], None]:
        return lambda: state.set_point_size(value)

    def is_point_size(value: float | None) -> Callable[[], bool]:
        return lambda: state.point_size == value

    table = [
        Command(
            name,
            tr(display.MODES[value]),
            set_mode(value),
            disabled_reason=mode_problem(value),
            is_checked=is_mode(value),
        )
        for name, value in MODES_BY_COMMAND.items()
    ]
    table += [
        Command(
            "display_field",
            tr("Scalar field"),
            lambda: choose_field(studio, docks),
            tip=tr("Colour the model by intensity, classification, elevation or another field."),
            disabled_reason=view.disabled_reason,
            is_checked=lambda: state.mode == "field",
        ),
        Command(
            "display_lit",
            tr("&Lighting"),
            toggle_lighting,
            tip=tr("Shade the surface with a light; turn off to see true colours."),
            disabled_reason=lambda: display.lighting_problem(models()),
            is_checked=lambda: state.lit[current_mode()],
        ),
        Command(
            "display_eye_dome",
            tr("&Eye-dome lighting"),
            lambda: state.set_eye_dome(not state.eye_dome),
            tip=tr("Shade a point cloud by depth while the view is still."),
            disabled_reason=lambda: display.eye_dome_problem(models()),
            is_checked=lambda: state.eye_dome,
        ),
        Command(
            "display_cameras",
            tr("&Cameras"),
            lambda: state.set_cameras(not state.cameras),
            icon="camera-outline",
            tip=tr("Show where the photos of the model were taken."),
            disabled_reason=cameras.disabled_reason,
            is_checked=lambda: state.cameras,
        ),
        Command(
            "display_size_auto",
            tr("Automatic (fill gaps)"),
            set_point_size(None),
            disabled_reason=view.disabled_reason,
            is_checked=is_point_size(None),
        ),
        Command(
            "clipping_box",
            tr("&Clipping box"),
            lambda: toggle_clipping_box(studio, view, docks),
            icon="cube-scan",
            tip=tr("Show and pick only the part of the model inside a box."),
            disabled_reason=view.disabled_reason,
            is_checked=lambda: state.clipping,
        ),
        Command(
            "clipping_reset",
            tr("Fit clipping box"),
            lambda: fit_clipping_box(studio, view),
            disabled_reason=lambda: None if state.clipping else Finding("action.no-clipping-box"),
        ),
        Command(
            "display_settings", tr("Display settings"), lambda: docks.bring_forward(_DOCK_NAME)
        ),
    ]
    for pixels in display.POINT_SIZES:
        text = tr_n("{count} pixel", "{count} pixels", round(pixels))
        table.append(
            Command(
                f"display_size_{pixels:g}",
                text,
                set_point_size(pixels),
                disabled_reason=view.disabled_reason,
                is_checked=is_point_size(pixels),
            )
        )
    return table


def choose_field(studio: Studio, docks: Docks) -> None:
    """Show the display panel, and colour each model by its selected or default field."""
    state = studio.display
    for model_id, open_model in studio.models.items():
        if model_id not in state.styles:
            style = FieldStyle(display.default_field(open_model.data))
            state.show_field(model_id, style)
    state.set_mode("field")
    docks.bring_forward(_DOCK_NAME)


def toggle_clipping_box(studio: Studio, view: OutcropView, docks: Docks) -> None:
    """Switch the clipping box on or off; a box without contents is first fitted."""
    state = studio.display
    if state.clipping:
        state.set_clip(state.box, False)
    elif state.box is not None and view.has_content_in_clip_box():
        state.set_clip(state.box, True)
        docks.bring_forward(_DOCK_NAME)
    else:
        fit_clipping_box(studio, view)
        docks.bring_forward(_DOCK_NAME)


def fit_clipping_box(studio: Studio, view: OutcropView) -> None:
    """Fit the clipping box to all visible models, and switch it on."""
    box = view.models_box()
    if box is not None:
        studio.display.set_clip(box, True)
