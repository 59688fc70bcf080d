"""Regions, pages and workspaces of the window as plain data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.core.words import to_translate

Region = Literal["inspector", "drawer", "overlay", "beside"]

REGIONS: dict[str, Region] = {
    "project": "inspector",
    "tool": "inspector",
    "properties": "inspector",
    "view": "inspector",
    "display": "inspector",
    "surface": "inspector",
    "three_points": "inspector",
    "compare": "inspector",
    "stereonet": "overlay",
    "second_view": "beside",
    "table": "drawer",
    "statistics": "drawer",
    "sets": "drawer",
    "slopes": "drawer",
    "fractures": "drawer",
    "section": "drawer",
    "elevation": "drawer",
    "bed_log": "drawer",
    "displacement": "drawer",
    "looked_at": "drawer",
    "repeats": "drawer",
    "photos": "drawer",
    "in_photos": "drawer",
    "jobs": "drawer",
    "messages": "drawer",
}
"""Region of each page, in the order of the page menu."""

INSPECTOR_TABS = ("project", "tool", "properties")
"""Inspector pages that follow the user's work; other pages are opened from a menu."""


@dataclass(frozen=True)
class WorkspaceLayout:
    """Workspace for a stage of the work, with the pages of inspector and drawer.

    Attributes
    ----------
    title, purpose : str
        Texts that are marked for translation. The purpose is shown while the workspace is empty.
    required_content : str
        Data that the workspace requires. Without such data, its purpose is shown.
    inspector, drawer : tuple of str
        Pages that are offered in the inspector, in addition to its tabs, and in the drawer.
    center : str
        Page that is shown in the centre if there are photos and no open model.
    tools : tuple of str
        Tools in the rail in addition to the general ones.
    """

    name: str
    title: str
    icon: str
    purpose: str
    required_content: Literal["model", "features"]
    inspector: tuple[str, ...] = ()
    drawer: tuple[str, ...] = ()
    center: str = ""
    tools: tuple[str, ...] = ()


WORKSPACES: tuple[WorkspaceLayout, ...] = (
    WorkspaceLayout(
        "model",
        to_translate("Model"),
        "cube-outline",
        to_translate(
            "Model: check photos, reconstruct, open and register models. Open a model or photo"
            " folder to start."
        ),
        "model",
        inspector=("display", "compare"),
        drawer=("photos", "in_photos", "jobs", "messages"),
        center="photos",
        tools=("control", "known_line"),
    ),
    WorkspaceLayout(
        "interpret",
        to_translate("Interpret"),
        "vector-polyline",
        to_translate(
            "Interpret: pick traces and planes on the outcrop to measure their orientations. Open"
            " a model to start."
        ),
        "model",
        inspector=("surface", "three_points", "view", "display"),
        drawer=("table", "in_photos", "statistics", "bed_log", "looked_at", "messages"),
    ),
    WorkspaceLayout(
        "results",
        to_translate("Results"),
        "chart-scatter-plot",
        to_translate(
            "Results: nets, statistics, sections, logs and tables. Pick features or import field"
            " measurements to start."
        ),
        "features",
        inspector=("view", "display"),
        drawer=(
            "table",
            "statistics",
            "sets",
            "slopes",
            "fractures",
            "section",
            "elevation",
            "bed_log",
            "displacement",
            "looked_at",
            "repeats",
            "messages",
        ),
    ),
)
"""Workspaces in the order of their buttons and of the keys Ctrl+1 to Ctrl+3."""

DEFAULT_WORKSPACE = "interpret"
"""Workspace that is shown to a new user."""

PAGE_TOOLS = {"bed_log": ("contact", "lithology"), "looked_at": ("cells",)}
"""Tools that the rail offers while a page of the drawer is open, keyed by page."""

GENERAL_TOOLS = ("trace", "plane", "line", "measure", "station", "select")
"""Tools that the rail always offers, in order."""

_BY_NAME = {workspace.name: workspace for workspace in WORKSPACES}

MAX_NARROW_WIDTH_PX = 1100
INSPECTOR_WIDTH_PX, NARROW_INSPECTOR_WIDTH_PX = 300, 250
DRAWER_SHARE, MIN_DRAWER_HEIGHT_PX = 0.34, 190


def find_workspace(name: str) -> WorkspaceLayout:
    """Return the workspace with a name, or the default workspace for an unknown name."""
    return _BY_NAME.get(name, _BY_NAME[DEFAULT_WORKSPACE])


def inspector_width(window_width: int) -> int:
    """Return the initial width of the inspector for a window width, in logical pixels."""
    return NARROW_INSPECTOR_WIDTH_PX if window_width < MAX_NARROW_WIDTH_PX else INSPECTOR_WIDTH_PX


def drawer_height(window_height: int) -> int:
    """Return the initial height of the drawer for a window height, in logical pixels."""
    return max(MIN_DRAWER_HEIGHT_PX, round(DRAWER_SHARE * window_height))
