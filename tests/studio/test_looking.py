"""Directions to look along, against closed forms."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.messages import refused
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import Line, Plane, angle_between_lines
from vomstudio.geometry.frames import Frame
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import Model
from vomstudio.studio.saved_views import SavedView, SavedViews
from vomstudio.studio.view_quality import (
    AxialDirection,
    direction_across_slip,
    intersection_direction,
    scene_depth,
)

NOTHING = Measurement(np.zeros((0, 3)), None, None, None, None, None)


def slipped(plane: Plane, line: Line) -> Measurement:
    return replace(NOTHING, on_plane=plane, line=line, max_confidence95_deg=1.5)


@pytest.mark.parametrize("dip_direction", [0.0, 75.0, 200.0])
def test_dip_slip_is_viewed_along_strike(dip_direction: float) -> None:
    found = direction_across_slip(slipped(Plane(dip_direction, 60.0), Line(dip_direction, 60.0)))
    assert isinstance(found, AxialDirection)
    assert angle_between_lines(found.line, Line((dip_direction - 90.0) % 360.0, 0.0)) < 1e-6
    assert found.error95_deg == 1.5


def test_strike_slip_is_viewed_down_dip() -> None:
    found = direction_across_slip(slipped(Plane(120.0, 70.0), Line(30.0, 0.0)))
    assert isinstance(found, AxialDirection)
    assert angle_between_lines(found.line, Line(120.0, 70.0)) < 1e-6


def test_missing_or_invalid_slip_returns_a_finding() -> None:
    assert direction_across_slip(NOTHING) == Finding("selection.no-slip")
    upright = slipped(Plane(120.0, 70.0), Plane(120.0, 70.0).pole())
    assert direction_across_slip(upright) == Finding("slip.across-plane")


def test_intersection_direction_matches_textbook_cases() -> None:
    """Vertical planes that strike north and east meet in a vertical line; planes that dip east and
    west alike in a horizontal one along their strike."""
    planes = [replace(NOTHING, plane=Plane(azimuth, 90.0)) for azimuth in (90.0, 180.0)]
    found = intersection_direction(planes)
    assert isinstance(found, AxialDirection)
    assert found.line.plunge_deg == pytest.approx(90.0)
    assert found.error95_deg is None, "readings without an error"
    found = intersection_direction(
        [replace(NOTHING, plane=Plane(azimuth, 40.0)) for azimuth in (90.0, 270.0)]
    )
    assert isinstance(found, AxialDirection)
    assert angle_between_lines(found.line, Line(0.0, 0.0)) < 1e-6
    assert "parallel" in str(intersection_direction([planes[0], planes[0]]))
    assert "two planes" in str(intersection_direction(planes[:1]))


def test_scene_depth_is_the_box_extent_along_the_view() -> None:
    data = SimpleNamespace(bounds=np.array([[0.0, 0.0, 0.0], [10.0, 4.0, 3.0]]))
    opened: Any = {"m": SimpleNamespace(data=data)}
    records = {"m": Model("m", "cliff", "a.obj", "mesh", "0" * 64, Frame("local"))}
    assert scene_depth([1.0, 0.0, 0.0], opened, records) == (10.0, True)
    assert scene_depth([0.0, 1.0, 0.0], opened, records)[0] == pytest.approx(4.0)
    assert scene_depth([0.6, 0.8, 0.0], opened, records)[0] == pytest.approx(0.6 * 10 + 0.8 * 4)
    assert scene_depth([0.0, 1.0, 0.0], {}, {}) == (0.0, True)


# --- views by name -------------------------------------------------------------------------------
def test_saved_views_keep_their_order_and_are_replaced_by_name() -> None:
    kept: dict[str, object] = {}
    views = SavedViews(kept.get, kept.__setitem__)
    views.save(SavedView("  along   beta ", {"a": 1}, None))
    views.save(SavedView("face", {"a": 2}, {"low": [0, 0, 0], "high": [1, 1, 1]}))
    views.save(SavedView("along beta", {"a": 3}, None))
    assert [(view.name, view.camera["a"]) for view in views.all()] == [
        ("face", 2),
        ("along beta", 3),
    ]
    views.delete("face")
    assert [view.name for view in views.all()] == ["along beta"]
    with refused("view.name-length", UsageError, field="name"):
        views.save(SavedView("   ", {}, None))


@pytest.mark.parametrize("damaged", [None, 7, "x", {"a": 1}, [None, 3, {"name": 5}, {"name": "a"}]])
def test_damaged_views_are_skipped(damaged: object) -> None:
    assert SavedViews(lambda key: damaged, lambda key, value: None).all() == []
