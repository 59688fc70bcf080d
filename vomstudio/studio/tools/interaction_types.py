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
    """Whether a pointer that moved by these logical pixels since the press has not left the click.

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
    """MOVE without a button held; CLICK is press and release within `MAX_CLICK_PX`; the DRAG kinds
    come only for a button that the viewport leaves to the tool (a vertex handle under the cursor);
    WHEEL only with Ctrl or Shift, for a tool that has asked for it."""

    MOVE = "move"
    CLICK = "click"
    DOUBLE_CLICK = "double_click"
    DRAG_START = "drag_start"
    DRAG_MOVE = "drag_move"
    DRAG_END = "drag_end"
    WHEEL = "wheel"


@dataclass(frozen=True)
class Hit:
    """A point on a model. `position` is float64 in the model's file frame, computed from the model
    itself: the barycentric sum of the face's vertices, or the cloud point.

    element: "face" or "point"; index: of that face or point.
    barycentric: weights of the face's three vertices; None for a point.
    """

    model_id: str
    element: str
    index: int
    position: Point
    barycentric: tuple[float, float, float] | None = None


@dataclass(frozen=True)
class PointerEvent:
    """Pixels are logical (device independent), from the viewport's top left corner.

    `handle` is the index of the preview's vertex handle under the cursor, or None. `more`: another
    one of the same drag follows at once, so nothing needs to be shown yet. `turns`: notches of the
    wheel, positive away from the user. `in_photo`: x, y are of a photo, not of the viewport,
    and `photo` is its name.
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
    """A piece of a model's surface as it is drawn.

    origin : (3,) float64 World
    corners : (k, 3, 3) float32 of triangles, or (k, 3) of points, World minus `origin`
    border : (b, 2, 3) float32 edges around it, World minus `origin`
    """

    origin: FloatArray
    corners: Float32Array
    border: Float32Array


@dataclass(frozen=True, eq=False)
class BrushRing:
    """Where a round brush touches the surface.

    centre : (3,) World; radius : m; normal : (3,) of the surface there, None where unknown
    removes : the brush erases
    """

    centre: FloatArray
    radius: float
    normal: FloatArray | None
    removes: bool = False


@dataclass(frozen=True)
class Outline:
    """A shape that is being drawn over the picture.

    pixels : its corners in order, logical, from the viewport's top left corner
    closed : the last is joined with the first
    takes_away : what lies inside will be taken away
    """

    pixels: tuple[tuple[float, float], ...]
    closed: bool
    takes_away: bool = False


@dataclass(frozen=True, eq=False)
class Preview:
    """What an unfinished tool shows, all in World (float64).

    line : (k, 3) vertices joined in order; also the handles that can be grabbed
    rubber : (3,) the end of the rubber band from the last vertex, or None
    path : (n, 3) drawn through the vertices of `line` in place of straight pieces, or None
    ahead : (m, 3) from the last vertex to `rubber` in place of a straight band, or None
    doubtful : parts (k, 3) of `path` that may be on another contact, drawn dashed in the colour of
        a doubtful verdict
    patch : (c, 3) corners of the live plane's patch (a convex ring), or None
    marked : index of the vertex that Delete removes, or None
    color : RGB 0..1
    reading : lines of text beside the cursor, the first the most important
    verdict : "good", "doubtful", "poor" or None where nothing can be judged yet
    brush : the brush over the surface, or None
    area : what the brush has touched since it was put down, or what is chosen, or None
    outline : the shape that is being drawn around what will be chosen, or None
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
    """What a tool has let go unfinished.

    tool : the name of the tool; label : in words, like the label of an edit
    bring_back : open it again as it was; False, with the reason shown, where that cannot be
    untouched : whether it is open now, as it was when it was brought back
    after : number of the last edit before it was let go; None : the last one that there is
    """

    tool: str
    label: str
    bring_back: Callable[[], bool]
    untouched: Callable[[], bool]
    after: int | None = None
