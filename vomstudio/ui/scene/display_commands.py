"""View > Display and the clipping box."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from PySide6.QtGui import QAction, QActionGroup
from PySide6.QtWidgets import QMenu

from vomstudio.rendering.view.scalars import ELEVATION, FieldStyle, field_names, title_of
from vomstudio.ui.common.actions import Command
from vomstudio.ui.common.command_targets import current_model
from vomstudio.ui.common.studio import Studio
from vomstudio.ui.common.window_protocols import Docks
from vomstudio.ui.scene.camera_view import CameraView
from vomstudio.ui.scene.outcrop_view import OutcropView
from vomstudio.words import tr
from vomstudio.workspace import display

_DOCK = "display"

MODE_NAMES = {
    "display_textured": "textured",
    "display_colors": "vertex_colors",
    "display_plain": "plain shaded",
    "display_wireframe": "wireframe",
    "display_points": "points",
}


def commands(studio: Studio, view: OutcropView, cameras: CameraView, docks: Docks) -> list[Command]:
    shown = studio.display

    def models() -> list[display.Data]:
        return [m.data for m in studio.models.values()]

    def mode(value: str) -> Callable[[], None]:
        return lambda: shown.set_mode(value)

    def is_mode(value: str) -> Callable[[], bool]:
        return lambda: now() == value

    def now() -> str:
        return display.mode_shown(shown.mode, models())

    def light() -> None:
        shown.set_lit(now(), not shown.lit[now()])

    def cannot(value: str) -> Callable[[], str | None]:
        return lambda: display.why_not_mode(value, models())

    def size(value: float | None) -> Callable[[], None]:
        return lambda: shown.set_point_size(value)

    def is_size(value: float | None) -> Callable[[], bool]:
        return lambda: shown.point_size == value

    table = [
        Command(name, display.MODES[value], mode(value), None, (), "", cannot(value),
                checked=is_mode(value))
        for name, value in MODE_NAMES.items()
    ]  # fmt: skip
    table += [
        Command("display_field", "Field in colours", lambda: choose_field(studio, docks), None, (),
                "Intensity, classification, elevation or any other value, with a colour bar",
                view.why_not, checked=lambda: shown.mode == "field"),
        Command("display_lit", "&Lit", light, None, (),
                "A light at the viewer shades the surface; without it colours are true",
                lambda: display.why_not_lit(models()), checked=lambda: shown.lit[now()]),
        Command("display_eye_dome", "&Eye-dome lighting",
                lambda: shown.set_eye_dome(not shown.eye_dome), None, (),
                "Shades a point cloud by its depth, once the view is at rest",
                lambda: display.why_not_eye_dome(models()), checked=lambda: shown.eye_dome),
        Command("display_cameras", "&Cameras", lambda: shown.set_cameras(not shown.cameras),
                "camera-outline", (),
                "Where the photos of the model were taken; hover over one for its name",
                cameras.why_not, checked=lambda: shown.cameras),
        Command("display_size_auto", "Points close the surface", size(None), None, (), "",
                view.why_not, checked=is_size(None)),
        Command("clipping_box", "&Clipping box", lambda: toggle_clip(studio, view, docks),
                "cube-scan", (),
                "Show and pick only what is inside a box; drag its faces or type them",
                view.why_not, checked=lambda: shown.clipping),
        Command("clipping_reset", "Clipping box around everything",
                lambda: fit_clip(studio, view), None, (), "",
                lambda: None if shown.clipping else "the clipping box is off"),
        Command("display_settings", "Display settings", lambda: docks.bring_forward(_DOCK)),
    ]  # fmt: skip
    for pixels in display.POINT_SIZES:
        text = f"Points of {pixels:g} pixel{'s' if pixels != 1 else ''}"
        table.append(
            Command(f"display_size_{pixels:g}", text, size(pixels), None, (), "", view.why_not,
                    checked=is_size(pixels))
        )  # fmt: skip
    return table


def fill_menu(menu: QMenu, actions: Mapping[str, QAction], studio: Studio) -> None:
    """View > Display."""
    menu.setToolTipsVisible(True)
    for name in MODE_NAMES:
        menu.addAction(actions[name])
    fields = menu.addMenu(tr("&Field"))
    fields.aboutToShow.connect(lambda: fill_fields(fields, studio))
    menu.addSeparator()
    menu.addAction(actions["display_lit"])
    menu.addAction(actions["display_eye_dome"])
    menu.addAction(actions["display_cameras"])
    sizes = menu.addMenu(tr("&Point size"))
    for name in ("auto", *(f"{pixels:g}" for pixels in display.POINT_SIZES)):
        sizes.addAction(actions[f"display_size_{name}"])
    menu.addSeparator()
    menu.addAction(actions["display_settings"])


def fill_fields(menu: QMenu, studio: Studio) -> None:
    """The fields of the current model."""
    menu.clear()
    model = current_model(studio)
    opened = None if model is None else studio.models.get(model.id)
    if model is None or opened is None:
        menu.addAction(tr("Open a model first")).setEnabled(False)
        return
    shown = studio.display
    current = shown.styles.get(model.id)
    group = QActionGroup(menu)
    for name in field_names(opened.data):
        text = "Elevation (Z)" if name == ELEVATION else title_of(name).replace("&", "&&")
        action = menu.addAction(text)
        action.setCheckable(True)
        action.setChecked(shown.mode == "field" and current is not None and current.name == name)
        group.addAction(action)
        action.triggered.connect(
            lambda _=False, n=name, m=model.id: shown.show_field(m, FieldStyle(n))
        )


def choose_field(studio: Studio, docks: Docks) -> None:
    """Show the fields that were chosen, or one that each model has; and where to choose."""
    shown = studio.display
    for model_id, opened in studio.models.items():
        if model_id not in shown.styles:
            style = FieldStyle(display.default_field(opened.data))
            shown.show_field(model_id, style)
    shown.set_mode("field")
    docks.bring_forward(_DOCK)


def toggle_clip(studio: Studio, view: OutcropView, docks: Docks) -> None:
    shown = studio.display
    if shown.clipping:
        shown.set_clip(shown.box, False)
    elif shown.box is not None and view.clip_holds_something():
        shown.set_clip(shown.box, True)
        docks.bring_forward(_DOCK)
    else:
        fit_clip(studio, view)
        docks.bring_forward(_DOCK)


def fit_clip(studio: Studio, view: OutcropView) -> None:
    box = view.models_box()
    if box is not None:
        studio.display.set_clip(box, True)
