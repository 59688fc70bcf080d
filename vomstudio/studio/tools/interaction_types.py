"""Data that the viewport and a tool exchange, independent of Qt and VTK."""

from __future__ import annotations

import enum
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vomstudio.core.arrays import Float32Array, FloatArray

Point = tuple[float, float, float]
ERASER_COLOR = (1.0, 1.0, 1.0)
MAX_CLICK_PX = 4.0
"""Maximum distance, in logical pixels, between press and release of a click."""


def is_click(dx: float, dy: float) -> bool:
    """Return whether a press and release with this movement (logical px) is a click.

    A longer movement is a drag. Every view uses this threshold.
    """
    return math.hypot(dx, dy) <= MAX_CLICK_PX


class Button(enum.Enum):
    """Mouse button."""

    NONE = "none"
    LEFT = "left"
    MIDDLE = "middle"
    RIGHT = "right"


class Pointer(enum.Enum):
    """Kind of a pointer event.

    MOVE is sent while no button is pressed. CLICK is a press and release within `MAX_CLICK_PX`.
    DRAG events are sent only if the tool draws with the left button or if a vertex handle is under
    the cursor. WHEEL is sent only with Ctrl or Shift, and only to a tool that has requested it.
    """

    MOVE = "move"
    CLICK = "click"
    DOUBLE_CLICK = "double_click"
    DRAG_START = "drag_start"
    DRAG_MOVE = "drag_move"
    DRAG_END = "drag_end"
    WHEEL = "wheel"


@dataclass(frozen=True)
class Hit:
    """Point on a model.

    `position` is float64 in the model's file frame, computed from the model itself: the
    barycentric sum of the face's vertices, or the cloud point.

    Parameters
    ----------
    element : {"face", "point"}
    index : int
        Index of the face or point.
    barycentric : tuple of float, optional
        Weights of the three vertices of the face; None for a point.
    """

    model_id: str
    element: str
    index: int
    position: Point
    barycentric: tuple[float, float, float] | None = None


@dataclass(frozen=True)
class PointerEvent:
    """Pointer event; pixels are logical, from the viewport's upper-left corner.

    Parameters
    ----------
    handle : int, optional
        Index of the preview's vertex handle under the cursor.
    has_more_steps : bool
        Whether another event of the same drag follows immediately, so that drawing can be
        postponed.
    wheel_notches : float
        Number of wheel notches, positive for rotation away from the user.
    is_in_photo : bool
        Whether `x` and `y` are pixels of a photo or of the second view instead of the viewport.
    photo : str
        Name of the photo.
    alt : bool
        Whether Alt is pressed; like Ctrl, it removes elements.
    """

    kind: Pointer
    x: float
    y: float
    button: Button = Button.NONE
    shift: bool = False
    ctrl: bool = False
    hit: Hit | None = None
    handle: int | None = None
    has_more_steps: bool = False
    wheel_notches: float = 0.0
    is_in_photo: bool = False
    photo: str = ""
    alt: bool = False


@dataclass(frozen=True, eq=False)
class Area:
    """Part of a model's surface for drawing.

    Parameters
    ----------
    origin : (3,) float64
        Origin in the World frame.
    corners : (k, 3, 3) or (k, 3) float32
        Triangles or points, in World coordinates minus `origin`.
    border : (b, 2, 3) float32
        Border edges, in World coordinates minus `origin`.
    """

    origin: FloatArray
    corners: Float32Array
    border: Float32Array


@dataclass(frozen=True, eq=False)
class BrushRing:
    """Contact of a round brush with the surface.

    Parameters
    ----------
    centre : (3,) float64
        Centre in the World frame.
    radius : float
        Radius in metres.
    normal : (3,) float64 or None
        Normal of the surface, or None if it is unknown.
    is_removing : bool
        Whether the brush erases.
    """

    centre: FloatArray
    radius: float
    normal: FloatArray | None
    is_removing: bool = False


@dataclass(frozen=True)
class Outline:
    """Shape that is being drawn over the picture.

    Parameters
    ----------
    pixels : tuple of (float, float)
        Corners in order, in logical pixels from the upper-left corner of the viewport.
    closed : bool
        Whether the last corner is joined to the first.
    is_subtracting : bool
        Whether elements inside will be removed.
    """

    pixels: tuple[tuple[float, float], ...]
    closed: bool
    is_subtracting: bool = False


@dataclass(frozen=True, eq=False)
class Preview:
    """Preview of an unfinished feature, in the World frame (float64).

    Parameters
    ----------
    line : (k, 3) float64
        Vertices of the line, which are also handles.
    rubber : (3,) float64, optional
        End of the rubber band from the last vertex.
    patch : (c, 3) float64, optional
        Corners of a convex polygon that shows the live plane.
    marked : int, optional
        Index of the vertex that Delete removes.
    color : tuple of float
        RGB colour, each component from 0 to 1.
    reading : tuple of str
        Lines of text beside the cursor, the most important first.
    verdict : {"good", "doubtful", "poor"}, optional
        Verdict on the feature, or None if it cannot be assessed yet.
    brush : BrushRing, optional
        Brush ring over the surface.
    area : Area, optional
        Painted or selected area.
    path : (n, 3) float64, optional
        Path through the vertices of `line`, which replaces the straight segments.
    ahead : (m, 3) float64, optional
        Path from the last vertex to `rubber`, which replaces the straight rubber band.
    doubtful : tuple of (k, 3) float64
        Parts of `path` that may follow another contact; they are drawn dashed in a warning
        colour.
    outline : Outline, optional
        Shape that is being drawn around a selection.
    stroke : Area, optional
        Area that the present brush stroke has touched; it is drawn over `area`.
    is_erasing : bool
        Whether the stroke erases.
    pending_positions : (k, 3) float64, optional
        Positions of clicks that take effect as soon as earlier work is complete.
    """

    line: FloatArray
    rubber: FloatArray | None = None
    patch: FloatArray | None = None
    marked: int | None = None
    color: tuple[float, float, float] = (0.9, 0.6, 0.0)
    reading: tuple[str, ...] = ()
    verdict: str | None = None
    brush: BrushRing | None = None
    area: Area | None = None
    path: FloatArray | None = None
    ahead: FloatArray | None = None
    doubtful: tuple[FloatArray, ...] = ()
    outline: Outline | None = None
    stroke: Area | None = None
    is_erasing: bool = False
    pending_positions: FloatArray | None = None

    def areas(self) -> list[tuple[Area, tuple[float, float, float]]]:
        """Return the areas to draw with their colours; erased parts are white."""
        stroke_color = ERASER_COLOR if self.is_erasing else self.color
        pairs = ((self.area, self.color), (self.stroke, stroke_color))
        return [(area, color) for area, color in pairs if area is not None]


@dataclass(frozen=True, eq=False)
class DiscardedFeature:
    """Unfinished work that a tool has discarded.

    Parameters
    ----------
    tool, label : str
        Name of the tool, and a label like that of an edit.
    restore_work : callable
        Restores the work. Returns False, after showing the reason, if this is not possible.
    is_untouched : callable
        Returns whether the work is open and unchanged since it was restored.
    after : int, optional
        Number of the last edit before the work was discarded, by default the latest edit.
    """

    tool: str
    label: str
    restore_work: Callable[[], bool]
    is_untouched: Callable[[], bool]
    after: int | None = None
