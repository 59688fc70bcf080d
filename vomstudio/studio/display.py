"""Display settings of the models, shared by the menus, a panel and the viewport."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping
from typing import Any

from vomstudio.core.findings import Finding
from vomstudio.core.signals import Signal
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry.boxes import ClipBox
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.field_style import ELEVATION, FieldStyle, field_names
from vomstudio.geometry.mesh import Mesh
from vomstudio.studio.owner_thread import TimerFactory

MODES = {
    "textured": to_translate("Textured"),
    "vertex_colors": to_translate("Vertex colours"),
    "plain shaded": to_translate("Shaded, without colour"),
    "wireframe": to_translate("Wireframe"),
    "points": to_translate("Points"),
    "field": to_translate("Scalar field"),
}
POINT_SIZES = (1.0, 2.0, 3.0, 5.0, 8.0)

SAVE_DELAY_S = 0.4

ModelData = Mesh | PointCloud


class Display:
    """Display settings of the models, saved with the project soon after a change.

    Parameters
    ----------
    save_state : callable
        Saves the settings.

    Attributes
    ----------
    computed : dict
        For each model, the request that recomputes its displayed field.
    changed : Signal
        Emits the name of the changed setting: mode, lit, point_size, eye_dome, cameras, fields,
        clip (on or off, or its handles) or box (the clipping box, at every step of a drag).
    """

    def __init__(self, save_state: Callable[[dict[str, Any]], None], later: TimerFactory) -> None:
        self.changed: Signal[str] = Signal()
        self._save_state = save_state
        self._timer = later(SAVE_DELAY_S, self.flush)
        self._clear()

    def _clear(self) -> None:
        self.mode = "textured"
        self.lit = {mode: mode == "plain shaded" for mode in MODES}
        self.point_size: float | None = None
        self.eye_dome = False
        self.cameras = False
        self.styles: dict[str, FieldStyle] = {}
        self.computed: dict[str, Any] = {}
        self.box: ClipBox | None = None
        self.clipping = False
        self.handles = True

    # --- changes -----------------------------------------------------------------------------
    def _notify_change(self, subject: str) -> None:
        self._timer.start()
        self.changed.emit(subject)

    def set_mode(self, mode: str) -> None:
        """Set the display mode, a key of MODES."""
        self.mode = mode
        self._notify_change("mode")

    def set_lit(self, mode: str, is_lit: bool) -> None:
        """Set whether models are lit in a mode."""
        self.lit[mode] = is_lit
        self._notify_change("lit")

    def set_point_size(self, pixels: float | None) -> None:
        """Set the point size in pixels; None fills the gaps between points."""
        self.point_size = pixels
        self._notify_change("point_size")

    def set_eye_dome(self, is_enabled: bool) -> None:
        """Set whether point clouds have eye-dome lighting."""
        self.eye_dome = is_enabled
        self._notify_change("eye_dome")

    def set_cameras(self, is_visible: bool) -> None:
        """Set whether the camera positions of reconstructed models are shown."""
        self.cameras = is_visible
        self._notify_change("cameras")

    def show_field(self, model_id: str, style: FieldStyle) -> None:
        """Set the display style of a model's field, and show the field."""
        self.styles[model_id] = style
        if self.mode != "field":
            self.mode = "field"
            self.changed.emit("mode")
        self._notify_change("fields")

    def hide_field(self, model_id: str) -> None:
        """Stop showing the field of a model because its values are outdated."""
        if self.styles.pop(model_id, None) is not None:
            self._notify_change("fields")

    def set_clip(self, box: ClipBox | None, is_enabled: bool | None = None) -> None:
        """Set the clipping box, and switch clipping on or off if `is_enabled` is given."""
        was_clipping, self.box = self.clipping, box
        if is_enabled is not None:
            self.clipping = is_enabled and box is not None
        self._notify_change("box" if self.clipping == was_clipping else "clip")

    def set_handles(self, is_visible: bool) -> None:
        """Set whether the faces of the clipping box can be dragged in the view."""
        self.handles = is_visible
        self._notify_change("clip")

    @property
    def effective_clip(self) -> ClipBox | None:
        """Clipping box that is in effect, or None if clipping is off."""
        return self.box if self.clipping else None

    # --- stored settings ----------------------------------------------------------------------
    def flush(self) -> None:
        """Save the last changes now."""
        self._timer.stop()
        self._save_state(self.to_dict())

    def to_dict(self) -> dict[str, Any]:
        """Return the settings that are saved with the project; `load` reads them."""
        return {
            "mode": self.mode,
            "lit": self.lit,
            "point_size": self.point_size,
            "eye_dome": self.eye_dome,
            "cameras": self.cameras,
            "fields": {key: style.to_dict() for key, style in self.styles.items()},
            "computed": dict(self.computed),
            "box": None if self.box is None else self.box.to_dict(),
            "clipping": self.clipping,
            "handles": self.handles,
        }

    def load(self, state: Any) -> None:
        """Load the settings of a project. Invalid values are replaced by defaults."""
        self._timer.stop()
        self._clear()
        if not isinstance(state, Mapping):
            return
        mode = state.get("mode")
        if isinstance(mode, str) and mode in MODES:
            self.mode = mode
        lit_state = state.get("lit")
        if isinstance(lit_state, Mapping):
            self.lit.update({k: bool(v) for k, v in lit_state.items() if k in MODES})
        size = state.get("point_size")
        if isinstance(size, int | float) and 0.5 <= size <= 50.0:
            self.point_size = float(size)
        self.eye_dome = bool(state.get("eye_dome"))
        self.cameras = bool(state.get("cameras"))
        fields = state.get("fields")
        for model_id, values in fields.items() if isinstance(fields, Mapping) else ():
            with contextlib.suppress(ValueError, TypeError, KeyError, AttributeError):
                self.styles[str(model_id)] = FieldStyle.from_dict(values)
        computed_state = state.get("computed")
        if isinstance(computed_state, Mapping):
            self.computed = {str(key): value for key, value in computed_state.items()}
        with contextlib.suppress(ValueError, TypeError, KeyError, AttributeError):
            self.box = ClipBox.from_dict(state.get("box"))
        self.clipping = bool(state.get("clipping")) and self.box is not None
        self.handles = bool(state.get("handles", True))


# --- available display modes ------------------------------------------------------------------
def default_field(data: ModelData) -> str:
    """Return the name of a model's default field, preferably classification or intensity."""
    names = field_names(data)
    for word in ("classification", "intensity"):
        for name in names:
            if word in name.lower():
                return name
    attributes = [name for name in names if name != ELEVATION]
    return attributes[0] if attributes else ELEVATION


def has_textures(data: ModelData) -> bool:
    """Return whether a mesh has texture coordinates and at least one texture."""
    return (
        isinstance(data, Mesh)
        and data.uv is not None
        and any(m.texture is not None for m in data.materials)
    )


def mode_problem(mode: str, models: list[ModelData]) -> Finding | None:
    """Return why a display mode is unavailable, or None if any of the models supports it."""
    if not models:
        return Finding("action.no-model")
    is_textured = any(has_textures(m) for m in models)
    if mode == "textured" and not is_textured:
        return Finding("display.no-textures")
    if mode == "vertex_colors" and not (is_textured or any(m.colors is not None for m in models)):
        return Finding("display.no-colours")
    if mode == "wireframe" and not any(isinstance(m, Mesh) for m in models):
        return Finding("display.cloud-without-faces")
    return None


def effective_mode(mode: str, models: list[ModelData]) -> str:
    """Return the effective display mode, which differs from `mode` if textures are missing."""
    if mode == "textured" and models and mode_problem(mode, models):
        if not mode_problem("vertex_colors", models):
            return "vertex_colors"
        if all(isinstance(m, Mesh) for m in models):
            return "plain shaded"
    return mode


def default_appearance(models: list[ModelData]) -> str:
    """Describe the appearance of models that are not coloured by a field."""
    mode = effective_mode("textured", models)
    if mode == "vertex_colors":
        return tr("Vertex colours")
    if mode == "plain shaded" or (models and mode_problem(mode, models)):
        return tr("No colours")
    return tr("Photo texture")


def lighting_problem(models: list[ModelData]) -> Finding | None:
    """Return why lighting is unavailable, or None if any of the models can be lit."""
    if not models:
        return Finding("action.no-model")
    if not any(isinstance(m, Mesh) for m in models):
        return Finding("display.cloud-not-lit")
    return None


def eye_dome_problem(models: list[ModelData]) -> Finding | None:
    """Return why eye-dome lighting is unavailable, or None if any model supports it."""
    if not models:
        return Finding("action.no-model")
    if not any(isinstance(m, PointCloud) for m in models):
        return Finding("display.no-cloud")
    return None
