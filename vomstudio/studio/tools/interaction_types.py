"""Data passed between the viewport and a tool; without Qt and VTK."""

from __future__ import annotations

import enum
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vomstudio.core.arrays import Float32Array, FloatArray

Point = tuple[float, float, float]
MAX_CLICK_PX = 4.0
"""Maximum distance, in logical pixels, between press and release of a click."""


def is_click(dx: float, dy: float) -> bool:
    """Return whether a pointer that moved by these logical pixels is still a click.

    A longer movement is a drag. Every view uses this threshold.
    """
    return math.hypot(dx, dy) <= MAX_CLICK_PX


class Button(enum.Enum):
    """A mouse button."""

    NONE = "none"
    LEFT = "left"
    MIDDLE = "middle"
    RIGHT = "right"


class Pointer(enum.Enum):
    """Kind of a pointer event.

    MOVE is sent without a button held. CLICK is press and release within `MAX_CLICK_PX`. DRAG
    events are sent only for a button that the viewport leaves to the tool (a vertex handle
    under the cursor). WHEEL is sent only with Ctrl or Shift, to a tool that has requested it.
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
        Index of that face or point.
    barycentric : tuple of float, optional
        Weights of the face's three vertices, None for a point.
    """

    model_id: str
    element: str
    index: int
    position: Point
    barycentric: tuple[float, float, float] | None = None


@dataclass(frozen=True)
class PointerEvent:
    """Pointer event; pixels are logical, from the viewport's top left corner.

    Parameters
    ----------
    handle : int, optional
        Index of the preview's vertex handle under the cursor.
    more : bool
        Whether another event of the same drag follows at once, so that drawing can wait.
    turns : float
        Notches of the wheel, positive away from the user.
    in_photo : bool
        Whether x and y are pixels of a photo, not of the viewport.
    photo : str
        Name of the photo.
    """

    kind: Pointer
    x: float
    y: float
    button: Button = Button.NONE
    shift: bool = False
    ctrl: bool = False
    hit: Hit | None = None
    handle: int | None = None
    more: bool = False
    turns: float = 0.0
    in_photo: bool = False
    photo: str = ""


@dataclass(frozen=True, eq=False)
class Area:
    """Part of a model's surface as it is drawn.

    Parameters
    ----------
    origin : (3,) float64
        World.
    corners : (k, 3, 3) or (k, 3) float32
        Triangles, or points, World minus `origin`.
    border : (b, 2, 3) float32
        Edges around it, World minus `origin`.
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
        World.
    radius : float
        Metres.
    normal : (3,) float64 or None
        Normal of the surface, None if unknown.
    removes : bool
        Whether the brush erases.
    """

    centre: FloatArray
    radius: float
    normal: FloatArray | None
    removes: bool = False


@dataclass(frozen=True)
class Outline:
    """Shape that is being drawn over the picture.

    Parameters
    ----------
    pixels : tuple of (float, float)
        Corners in order, logical, from the viewport's top left corner.
    closed : bool
        Whether the last corner is joined to the first.
    takes_away : bool
        Whether elements inside will be removed.
    """

    pixels: tuple[tuple[float, float], ...]
    closed: bool
    takes_away: bool = False


@dataclass(frozen=True, eq=False)
class Preview:
    """Preview of an unfinished tool, in World (float64).

    Parameters
    ----------
    line : (k, 3) float64
        Vertices joined in order, which are also handles.
    rubber : (3,) float64, optional
        End of the rubber band from the last vertex.
    patch : (c, 3) float64, optional
        Corners of the live plane's patch (a convex ring).
    marked : int, optional
        Index of the vertex that Delete removes.
    color : tuple of float
        RGB, 0 to 1.
    reading : tuple of str
        Lines of text beside the cursor, the most important first.
    verdict : {"good", "doubtful", "poor"}, optional
        None if nothing can be judged yet.
    brush : BrushRing, optional
        Brush over the surface.
    area : Area, optional
        Painted or selected area.
    path : (n, 3) float64, optional
        Path through the vertices of `line` in place of straight pieces.
    ahead : (m, 3) float64, optional
        Path from the last vertex to `rubber` in place of a straight band.
    doubtful : tuple of (k, 3) float64
        Parts of `path` that may be on another contact, drawn dashed in the colour of doubt.
    outline : Outline, optional
        Shape that is being drawn around a selection.
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


@dataclass(frozen=True, eq=False)
class Discarded:
    """Unfinished work that a tool has discarded.

    Parameters
    ----------
    tool, label : str
        Name of the tool, and a label like that of an edit.
    bring_back : callable
        Restores it. Returns False, after showing the reason, if that is not possible.
    untouched : callable
        Returns whether it is open and unchanged since it was restored.
    after : int, optional
        Number of the last edit before it was discarded, by default the latest.
    """

    tool: str
    label: str
    bring_back: Callable[[], bool]
    untouched: Callable[[], bool]
    after: int | None = None
