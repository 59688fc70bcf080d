"""Display settings of the models, shared by menus, panel and viewport. No widgets."""

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
from vomstudio.studio.owner_thread import Later

MODES = {
    "textured": to_translate("Textured"),
    "vertex_colors": to_translate("Vertex colours"),
    "plain shaded": to_translate("Shaded, without colour"),
    "wireframe": to_translate("Wireframe"),
    "points": to_translate("Points"),
    "field": to_translate("Scalar field"),
}
POINT_SIZES = (1.0, 2.0, 3.0, 5.0, 8.0)

_KEEP_S = 0.4

Data = Mesh | PointCloud


class Display:
    """`changed` says which of mode, lit, point_size, eye_dome, cameras, fields, clip (on or off,
    handles) and box, which changes at every step of a drag.

    It is kept with the project, by `keep`, a little after the last change. computed : by model, how
    the field that was worked out for it is asked for again
    """

    def __init__(self, keep: Callable[[dict[str, Any]], None], later: Later) -> None:
        self.changed: Signal[str] = Signal()
        self._keep = keep
        self._timer = later(_KEEP_S, self.flush)
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
    def _tell(self, what: str) -> None:
        self._timer.start()
        self.changed.emit(what)

    def set_mode(self, mode: str) -> None:
        """mode : a key of MODES"""
        self.mode = mode
        self._tell("mode")

    def set_lit(self, mode: str, lit: bool) -> None:
        """Whether models are lit in a mode."""
        self.lit[mode] = lit
        self._tell("lit")

    def set_point_size(self, pixels: float | None) -> None:
        """pixels : None for a size that fills the gaps between points"""
        self.point_size = pixels
        self._tell("point_size")

    def set_eye_dome(self, on: bool) -> None:
        """Whether point clouds have eye-dome lighting."""
        self.eye_dome = on
        self._tell("eye_dome")

    def set_cameras(self, on: bool) -> None:
        """Whether the photos of a reconstructed model are shown where they were taken."""
        self.cameras = on
        self._tell("cameras")

    def show_field(self, model_id: str, style: FieldStyle) -> None:
        """Give a model a field and show it."""
        self.styles[model_id] = style
        if self.mode != "field":
            self.mode = "field"
            self.changed.emit("mode")
        self._tell("fields")

    def show_no_field(self, model_id: str) -> None:
        """Forget which field a model shows, whose values are not those any more."""
        if self.styles.pop(model_id, None) is not None:
            self._tell("fields")

    def set_clip(self, box: ClipBox | None, on: bool | None = None) -> None:
        """Set the clipping box, and switch it on or off where `on` is given."""
        before, self.box = self.clipping, box
        if on is not None:
            self.clipping = on and box is not None
        self._tell("box" if self.clipping == before else "clip")

    def set_handles(self, on: bool) -> None:
        """Whether the faces of the clipping box can be dragged in the view."""
        self.handles = on
        self._tell("clip")

    @property
    def clip_shown(self) -> ClipBox | None:
        """The clipping box that is in effect; None where it is off."""
        return self.box if self.clipping else None

    # --- with the project --------------------------------------------------------------------
    def flush(self) -> None:
        """Keep what was changed last."""
        self._timer.stop()
        self._keep(self.to_dict())

    def to_dict(self) -> dict[str, Any]:
        """What is kept with the project; `load` reads it."""
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

    def load(self, kept: Any) -> None:
        """Take over what a project has kept; what cannot be read is as in a new project."""
        self._timer.stop()
        self._clear()
        if not isinstance(kept, Mapping):
            return
        mode = kept.get("mode")
        if isinstance(mode, str) and mode in MODES:
            self.mode = mode
        lit = kept.get("lit")
        if isinstance(lit, Mapping):
            self.lit.update({k: bool(v) for k, v in lit.items() if k in MODES})
        size = kept.get("point_size")
        if isinstance(size, int | float) and 0.5 <= size <= 50.0:
            self.point_size = float(size)
        self.eye_dome = bool(kept.get("eye_dome"))
        self.cameras = bool(kept.get("cameras"))
        fields = kept.get("fields")
        for model_id, values in fields.items() if isinstance(fields, Mapping) else ():
            with contextlib.suppress(ValueError, TypeError, KeyError, AttributeError):
                self.styles[str(model_id)] = FieldStyle.from_dict(values)
        computed = kept.get("computed")
        if isinstance(computed, Mapping):
            self.computed = {str(key): value for key, value in computed.items()}
        with contextlib.suppress(ValueError, TypeError, KeyError, AttributeError):
            self.box = ClipBox.from_dict(kept.get("box"))
        self.clipping = bool(kept.get("clipping")) and self.box is not None
        self.handles = bool(kept.get("handles", True))


# --- what can be shown -----------------------------------------------------------------------
def default_field(data: Data) -> str:
    """The field that is shown where none was chosen: classification and intensity come first."""
    names = field_names(data)
    for word in ("classification", "intensity"):
        for name in names:
            if word in name.lower():
                return name
    own = [name for name in names if name != ELEVATION]
    return own[0] if own else ELEVATION


def has_textures(data: Data) -> bool:
    """Whether a mesh has texture coordinates and at least one texture."""
    return (
        isinstance(data, Mesh)
        and data.uv is not None
        and any(m.texture is not None for m in data.materials)
    )


def why_not_mode(mode: str, models: list[Data]) -> Finding | None:
    """Return why these models cannot be shown in a mode; None if one of them can."""
    if not models:
        return Finding("action.no-model")
    textured = any(has_textures(m) for m in models)
    if mode == "textured" and not textured:
        return Finding("display.no-textures")
    if mode == "vertex_colors" and not (textured or any(m.colors is not None for m in models)):
        return Finding("display.no-colours")
    if mode == "wireframe" and not any(isinstance(m, Mesh) for m in models):
        return Finding("display.cloud-without-faces")
    return None


def mode_shown(mode: str, models: list[Data]) -> str:
    """The mode that a model without textures shows in place of "textured"."""
    if mode == "textured" and models and why_not_mode(mode, models):
        if not why_not_mode("vertex_colors", models):
            return "vertex_colors"
        if all(isinstance(m, Mesh) for m in models):
            return "plain shaded"
    return mode


def usual_look(models: list[Data]) -> str:
    """What these models show where they are coloured by no field, in words."""
    shown = mode_shown("textured", models)
    if shown == "vertex_colors":
        return tr("Own colours")
    if shown == "plain shaded" or (models and why_not_mode(shown, models)):
        return tr("Without colours")
    return tr("Photo texture")


def why_not_lit(models: list[Data]) -> Finding | None:
    """Return why these models cannot be lit; None if one of them can."""
    if not models:
        return Finding("action.no-model")
    if not any(isinstance(m, Mesh) for m in models):
        return Finding("display.cloud-not-lit")
    return None


def why_not_eye_dome(models: list[Data]) -> Finding | None:
    """Return why these models have no eye-dome lighting; None if one of them has."""
    if not models:
        return Finding("action.no-model")
    if not any(isinstance(m, PointCloud) for m in models):
        return Finding("display.no-cloud")
    return None
