"""A section says how features came onto it, warns of grazing directions and marks its bends."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from tests.messages import refused
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import Line, Plane
from vomstudio.geometry.mesh import Mesh
from vomstudio.products.ortho.interpretation import DEFAULT_COLOR, Item, items_from_table
from vomstudio.products.section.cutting import cut_model
from vomstudio.products.section.directions import ProjectionDirections
from vomstudio.products.section.section_lines import Curtain, curtain_from_line, curtain_from_plane
from vomstudio.products.section.writing import (
    PERPENDICULAR,
    project_items,
    section_drawing,
    section_figures,
    write_section,
)
from vomstudio.project.records.feature_types import DEFAULT_TYPES

EAST = curtain_from_plane(Plane(90.0, 90.0), (0.0, 0.0, 0.0))
GROUND = Mesh(
    np.array([[-99.0, -99.0, 0], [99.0, -99.0, 0], [99.0, 99.0, 5], [-99.0, 99.0, 5]]),
    np.array([[0, 1, 2], [0, 2, 3]], np.int32),
)
BEDS = items_from_table(
    np.array([[10.0, 5.0, 1.0], [-7.0, 20.0, 2.0]]),
    [{"id": str(k), "dip_direction_deg": 120.0, "dip_deg": 30.0} for k in range(2)],
)


def written(tmp_path: Path, curtain: Curtain, along: np.ndarray | None, name: str) -> str:
    cut = cut_model(GROUND, curtain, None, 0.0)
    flats, left_out = project_items(BEDS, curtain, ProjectionDirections(along), None)
    figures = section_figures(cut, curtain, flats, left_out, ProjectionDirections(along))
    write_section(tmp_path / name, cut, curtain, figures, flats)
    return (tmp_path / name).read_text("utf-8")


@pytest.mark.parametrize("angle", [3.0, 5.0, 12.0, 19.0])
def test_cost_of_a_grazing_direction_is_reported(angle: float) -> None:
    """Features move by h cot a in the section, h from it: that is what a degree changes."""
    (finding,) = ProjectionDirections(Line(angle, 0.0).vector()).check(EAST)
    cot = [1.0 / math.tan(math.radians(angle + step)) for step in (-0.05, 0.05)]
    expected = 100.0 * (cot[0] - cot[1]) * 10.0
    assert finding.code == "section.grazing-direction"
    assert finding.values["cost_percent"] == pytest.approx(expected, rel=1e-3)
    assert finding.values["angle_deg"] == pytest.approx(angle)


def test_directions_across_the_section_pass_and_those_within_it_are_rejected() -> None:
    for line in (Line(90, 0), Line(21, 0), Line(120, 20), Line(135, 60)):
        assert ProjectionDirections(line.vector()).check(EAST) == ()
    assert ProjectionDirections(None).check(EAST) == ()
    for line in (Line(0, 0), Line(1.5, 0), Line(181, 30), Line(0, 90)):
        with refused("section.along-direction", UsageError, limit_deg=2.0):
            ProjectionDirections(line.vector()).check(EAST)


def test_only_pieces_crossed_by_the_direction_contain_features() -> None:
    bent = curtain_from_line([[0, -50], [0, 0], [50, 0]])
    along = Line(0.0, 0.0).vector()
    (finding,) = ProjectionDirections(along).check(bent)
    assert finding == Finding("section.pieces-without-features", limit_deg=2.0)
    flats, _ = project_items(BEDS, bent, ProjectionDirections(along), None)
    assert [float(flat.points[0, 0]) for flat in flats] == pytest.approx([60.0])


def test_files_state_the_projection_direction(tmp_path: Path) -> None:
    along = Line(120.0, 20.0).vector()
    angle = math.degrees(math.asin(math.cos(math.radians(20)) * math.cos(math.radians(30))))
    assert "trend 120.0000, plunge 20.0000" in written(tmp_path, EAST, along, "a.csv")
    assert f"at {angle:.1f} deg" in (tmp_path / "a_features.csv").read_text("utf-8")
    assert "along 120.0/20.0" in written(tmp_path, EAST, along, "a.svg")
    assert PERPENDICULAR in written(tmp_path, EAST, None, "b.csv")
    assert PERPENDICULAR in written(tmp_path, EAST, None, "b.svg")
    cut = cut_model(GROUND, EAST, None, 0.0)
    figures = section_figures(cut, EAST, (), 0, None)
    assert figures.projection_angle_deg is None


def test_bends_are_marked_where_the_line_turns(tmp_path: Path) -> None:
    line = np.array([[0.0, 0.0], [30.0, 0.0], [60.0, 0.2], [60.0, 40.0]])
    curtain = curtain_from_line(line)
    cut = cut_model(GROUND, curtain, None, 0.0)
    (mark,) = (s for s in section_drawing(cut, curtain, ()).shapes if s.layer == "bends")
    assert mark.points[:, 0] == pytest.approx(30 + math.hypot(30, 0.2))
    assert mark.values["azimuth_deg"] == pytest.approx(0.0)
    assert "bends at distance_m 60.001" in written(tmp_path, curtain, None, "c.csv")
    # A line drawn with a mouse has many; the sharpest are marked.
    turn = np.linspace(0, np.pi, 90)
    many = curtain_from_line(80.0 * np.stack([np.cos(turn), np.sin(turn)], axis=1))
    assert len(many.bends(20)) == 20
    assert not curtain_from_line([[0, 0], [5, 0], [9, 0.05]]).bends(20)


def line_item(points: np.ndarray, form: str = "line") -> Item:
    return Item("traces", form, points, "t", "t", "bedding", "", "#000000")  # type: ignore[arg-type]


def test_feature_line_across_a_bend_is_drawn_on_both_pieces() -> None:
    """A line that lies on the section itself is drawn where it is, and one beside it is broken at
    the bend on the inner side, where both pieces have the corner before them."""
    bent = curtain_from_line([[0, -50], [0, 0], [50, 0]])
    on = np.array([[0, -20, 1.0], [0, -5, 2.0], [0, 0, 3.0], [7, 0, 4.0], [30, 0, 5.0]])
    (flat,), left_out = project_items((line_item(on),), bent, ProjectionDirections(None), None)
    assert left_out == 0
    for corner in ([30, 1], [45, 2], [50, 3], [57, 4], [80, 5.0]):
        assert np.abs(flat.points - corner).max(axis=1).min() < 1e-9
    assert (np.diff(flat.points[:, 0]) > 0).all()
    assert np.abs(flat.distance).max() < 1e-9
    # 6 m inside the corner, which is before both pieces.
    inner = np.array([[6, -30, 1.0], [6, -6, 1.0], [30, -6, 1.0]])
    flats, _ = project_items((line_item(inner),), bent, ProjectionDirections(None), None)
    assert [f.points[[0, -1], 0] for f in flats] == [
        pytest.approx([20, 44], abs=0.3),
        pytest.approx([56, 80], abs=0.3),
    ]
    for flat in flats:
        assert np.abs(flat.distance) == pytest.approx(np.full(len(flat.points), 6.0), abs=1e-9)
    outer = np.array([[-6, -30, 1.0], [-6, 6, 1.0], [30, 6, 1.0]])
    flats, _ = project_items((line_item(outer, "ring"),), bent, ProjectionDirections(None), None)
    (flat,) = flats
    assert flat.item.form == "line"
    assert flat.points[[0, -1], 0] == pytest.approx([20, 80], abs=0.3)
    assert (np.abs(flat.points[:, 0] - 50) < 0.5).sum() >= 2
    cut = cut_model(GROUND, bent, None, 0.0)
    assert section_figures(cut, bent, flats, 0).features == 1


def test_feature_line_along_a_hand_drawn_section_is_not_broken() -> None:
    turn = np.linspace(0, np.pi, 90)
    many = curtain_from_line(80.0 * np.stack([np.cos(turn), np.sin(turn)], axis=1))
    angle = np.linspace(0.1, 3.0, 40)
    beside = np.stack([80.5 * np.cos(angle), 80.5 * np.sin(angle), angle], axis=1)
    (flat,), _ = project_items((line_item(beside),), many, ProjectionDirections(None), None)
    assert (np.diff(flat.points[:, 0]) > 0).all()
    assert flat.points[[0, -1], 0] == pytest.approx(80 * angle[[0, -1]], abs=0.3)
    assert np.abs(flat.distance).max() < 0.6


def test_planes_of_a_table_have_the_colours_of_their_feature_types() -> None:
    colors = {each.name: each.color for each in DEFAULT_TYPES}
    rows = [
        {"id": kind, "kind": kind, "dip_direction_deg": 90.0, "dip_deg": 30.0}
        for kind in ("bedding", "Fault", "dyke")
    ]
    drawn = items_from_table(np.zeros((3, 3)), rows)
    assert [each.color for each in drawn] == [colors["Bedding"], colors["Fault"], DEFAULT_COLOR]
