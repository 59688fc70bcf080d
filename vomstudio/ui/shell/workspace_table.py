"""The workspaces along a geologist's day, as plain data: what each shows, and where."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.core.words import to_translate

Area = Literal["left", "right", "bottom"]
Stack = tuple[str, ...]
"""Docks that share one place as tabs, the one in front first."""
Places = dict[Area, tuple[Stack, ...]]
"""The stacks of each area: from top to bottom at the sides, from left to right at the bottom."""

HOMES: dict[str, Area] = {
    "project": "left",
    "tool": "left",
    "stereonet": "right",
    "statistics": "right",
    "sets": "right",
    "slopes": "right",
    "looked_at": "bottom",
    "repeats": "bottom",
    "displacement": "right",
    "three_points": "right",
    "fractures": "bottom",
    "bed_log": "bottom",
    "section": "bottom",
    "elevation": "bottom",
    "view": "right",
    "display": "right",
    "properties": "right",
    "surface": "right",
    "compare": "right",
    "table": "bottom",
    "photos": "bottom",
    "in_photos": "bottom",
    "jobs": "bottom",
    "messages": "bottom",
}
"""Where a dock comes to stand in a workspace that does not bring it. The order is that of the menu
of panels; a dock that is missing here would stand nowhere."""


@dataclass(frozen=True)
class WorkspaceLayout:
    """title, purpose : noted for translation; purpose : one line that is shown while there is
    nothing of what it needs. shares : of the left, right and bottom docks in the width and height
    of the window; first_share : of the upper stack of a side in its height. middle : the dock that
    takes the place of the outcrop while no model is open. beside_photo : the share of the bottom
    docks where a photo is open in the middle; 0 where that changes nothing"""

    name: str
    title: str
    icon: str
    purpose: str
    needs: Literal["photos", "model", "features"]
    left: tuple[Stack, ...] = ()
    right: tuple[Stack, ...] = ()
    bottom: tuple[Stack, ...] = ()
    shares: tuple[float, float, float] = (0.205, 0.233, 0.22)
    first_share: float = 0.5
    middle: str = ""
    beside_photo: float = 0.0

    @property
    def places(self) -> Places:
        return {"left": self.left, "right": self.right, "bottom": self.bottom}

    @property
    def docks(self) -> frozenset[str]:
        """The names of the docks that it brings."""
        areas = self.places.values()
        return frozenset(name for stacks in areas for stack in stacks for name in stack)


# The order is that of the strip and of the keys Ctrl+1 to Ctrl+6.
WORKSPACES: tuple[WorkspaceLayout, ...] = (
    WorkspaceLayout(
        "photos",
        to_translate("Photos"),
        "image-multiple-outline",
        to_translate(
            "Photos: check what a set of photos can give, mask and mark it, and reconstruct. "
            "Choose a folder of photos to begin."
        ),
        "photos",
        bottom=(("photos",),),
        shares=(0.205, 0.233, 0.5),
        middle="photos",
        beside_photo=0.22,
    ),
    WorkspaceLayout(
        "model",
        to_translate("Model"),
        "cube-outline",
        to_translate(
            "Model: follow the reconstruction, and choose how the model is displayed. Open a model "
            "to begin."
        ),
        "model",
        left=(("project",),),
        right=(("display",), ("properties",)),
        bottom=(("jobs", "messages"),),
        shares=(0.205, 0.233, 0.18),
    ),
    WorkspaceLayout(
        "register",
        to_translate("Register"),
        "map-marker-radius-outline",
        to_translate(
            "Register: give the model its place, scale and north, and see how far they can be "
            "trusted. Open a model to begin."
        ),
        "model",
        left=(("project",),),
        right=(("tool", "compare"), ("properties",)),
        bottom=(("in_photos", "photos"),),
        shares=(0.17, 0.33, 0.26),
        first_share=0.72,
        beside_photo=0.22,
    ),
    WorkspaceLayout(
        "interpret",
        to_translate("Interpret"),
        "vector-polyline",
        to_translate(
            "Interpret: pick traces and patches on the outcrop, and read their planes and how far "
            "these may be off. Open a model to begin."
        ),
        "model",
        left=(("project",), ("tool",)),
        right=(("stereonet",), ("properties", "surface", "three_points")),
        bottom=(("table", "in_photos"),),
    ),
    WorkspaceLayout(
        "analyse",
        to_translate("Analyse"),
        "chart-scatter-plot",
        to_translate(
            "Analyse: read sets, fold axes and intersections in the stereonet and the table. Pick "
            "features first, or import field measurements."
        ),
        "features",
        right=(
            ("stereonet",),
            ("statistics", "sets", "slopes", "displacement", "properties"),
        ),
        bottom=(("table", "fractures", "looked_at", "repeats"),),
        shares=(0.205, 0.36, 0.26),
        first_share=0.6,
    ),
    WorkspaceLayout(
        "views",
        to_translate("Views and export"),
        "export-variant",
        to_translate(
            "Views and export: look along a direction, and make orthophotos, tables and layers. "
            "Open a model to begin."
        ),
        "model",
        left=(("project",),),
        right=(("view",), ("display",)),
        bottom=(("section", "elevation", "bed_log"),),
        shares=(0.205, 0.233, 0.36),
    ),
)
FIRST = "interpret"
"""The one that a new user sees."""

_BY_NAME = {workspace.name: workspace for workspace in WORKSPACES}


def workspace_of(name: str) -> WorkspaceLayout:
    """The workspace of this name; the first one where there is none."""
    return _BY_NAME.get(name, _BY_NAME[FIRST])


_SMALL_WIDTH, _SMALL_HEIGHT = 1180, 620
_WIDE = ("photos", "in_photos", "section", "elevation", "bed_log")
"""Docks that are of use only where they are wide."""
_BARS_HEIGHT = 110
_SIDES: tuple[Area, Area] = ("left", "right")
_LEAST_STACK = 250
_LEAST_SIDE, _LEAST_BOTTOM = 210, 130
_LEAST_BESIDE_PHOTO = 800
"""Where the window is lower, an open photo has all of its height."""


def is_small(width: int, height: int) -> bool:
    """Whether docks fold together in a window of this size in logical pixels."""
    return width < _SMALL_WIDTH or height < _SMALL_HEIGHT


def places_in(
    workspace: WorkspaceLayout, width: int, height: int, *, photo: bool = False
) -> Places:
    """Where its docks stand in a window of this size. What has no height for itself becomes a tab.
    In a small window the docks at the bottom go to the side, where those that need width wait
    until they are called; where they stand in front, they have the bottom and the right side.
    photo : an open photo, which lists the others itself, stands in the middle"""
    places = workspace.places
    if photo and workspace.beside_photo and height < _LEAST_BESIDE_PHOTO:
        places["bottom"] = ()
    if is_small(width, height) and places["bottom"]:
        if places["bottom"][0][0] in _WIDE:
            places["left"] += places["right"]
            places["right"] = ()
        else:
            few = [s for s in _SIDES if places[s]]
            side = min(few, key=lambda s: sum(map(len, places[s])))
            places[side] += tuple(
                tuple(name for name in stack if name not in _WIDE) for stack in places["bottom"]
            )
            places["bottom"] = ()
    room = (height - _BARS_HEIGHT) // _LEAST_STACK
    for area in _SIDES:
        stacks = places[area]
        if len(stacks) > max(1, room):
            places[area] = (tuple(name for stack in stacks for name in stack),)
    return places


def sizes_in(
    workspace: WorkspaceLayout, width: int, height: int, *, photo: bool = False
) -> dict[Area, int]:
    """Width of the sides and height of the bottom in a window of this size, in pixels. photo : as
    in `places_in`"""
    left, right, bottom = workspace.shares
    if photo and workspace.beside_photo:
        bottom = workspace.beside_photo
    return {
        "left": max(_LEAST_SIDE, round(left * width)),
        "right": max(_LEAST_SIDE, round(right * width)),
        "bottom": max(_LEAST_BOTTOM, round(bottom * height)),
    }
