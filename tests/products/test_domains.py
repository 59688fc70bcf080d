"""Domains with axes of their own (textbook fig. 31c): in sections each along its own, in an
orthophoto one of them with the rest grey."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import rasterio

from tests.messages import by_code, refused
from vomstudio.core.errors import UsageError
from vomstudio.geology.domains import projection_axes
from vomstudio.geology.notation import parse_plane_option
from vomstudio.geology.orientation import Line, angle_between_lines, planes_to_normals
from vomstudio.geometry.mesh import Mesh
from vomstudio.products.ortho.domain_axes import compute_domain_axes
from vomstudio.products.ortho.domain_mask import domain_extent
from vomstudio.products.ortho.interpretation import Item, items_from_table
from vomstudio.products.ortho.orthophoto import write_orthophoto
from vomstudio.products.ortho.planning import plan
from vomstudio.products.ortho.view_directions import view_along_line
from vomstudio.products.section.directions import (
    ProjectionDirections,
    assign_domain_axes,
    domain_projections,
)
from vomstudio.products.section.section_lines import curtain_from_plane
from vomstudio.products.section.writing import project_items

Floats = npt.NDArray[np.float64]

HANGING, FOOT, FAULT = (100.0, 30.0), (215.0, 40.0), (60.0, 65.0)


def met(one: tuple[float, float], other: tuple[float, float]) -> Line:
    """The line in which two planes meet, by their normals."""
    return Line.from_vector(np.cross(planes_to_normals(*one), planes_to_normals(*other)))


def around(plane: tuple[float, float], n: int, sigma: float, rng: Any) -> tuple[Floats, Floats]:
    return plane[0] + rng.normal(0, sigma, n), plane[1] + rng.normal(0, sigma, n)


def faulted(turn: float = 0.0) -> tuple[Item, ...]:
    """Beds left and right of a fault that dips to the right (x), without noise."""
    rows, places = [], []
    for domain, plane, side in (("hanging wall", HANGING, 1.0), ("footwall", FOOT, -1.0)):
        for k in range(4):
            places.append([side * (4.0 + k), 0.0, float(k)])
            rows.append(("bedding", domain, plane))
    for k in range(3):
        places.append([0.0, 0.0, float(k)])
        rows.append(("fault", "", (90.0, 90.0)))
    output = [
        {
            "id": str(i),
            "name": str(i),
            "kind": kind,
            "domain": domain,
            "set": "F" if kind == "fault" else "",
            "dip_direction_deg": (dd + turn) % 360.0,
            "dip_deg": dip,
        }
        for i, (kind, domain, (dd, dip)) in enumerate(rows)
    ]
    return items_from_table(np.array(places), output)


def test_homoclinal_beds_are_projected_along_their_intersection_with_the_fault() -> None:
    result = projection_axes(
        {name: ([dd] * 5, [dip] * 5) for name, (dd, dip) in (("h", HANGING), ("f", FOOT))},
        ([FAULT[0]] * 3, [FAULT[1]] * 3),
    )
    for name, plane in (("h", HANGING), ("f", FOOT)):
        line = result[name].line
        assert line is not None
        assert angle_between_lines(line, met(plane, FAULT)) < 1e-4


def test_axes_rotate_with_the_world() -> None:
    rng = np.random.default_rng(4)
    beds = {"h": around(HANGING, 8, 2.0, rng), "f": around(FOOT, 8, 2.0, rng)}
    fault = around(FAULT, 5, 1.0, rng)
    here = projection_axes(beds, fault)
    turned = projection_axes(
        {name: (dd + 30.0, dip) for name, (dd, dip) in beds.items()}, (fault[0] + 30.0, fault[1])
    )
    for name in beds:
        one, other = here[name].line, turned[name].line
        assert one is not None
        assert other is not None
        assert (other.trend_deg - one.trend_deg) % 360.0 == pytest.approx(30.0, abs=1e-6)
        assert other.plunge_deg == pytest.approx(one.plunge_deg, abs=1e-9)
        assert turned[name].error95_deg == pytest.approx(here[name].error95_deg)


@pytest.mark.full
def test_stated_axis_error_contains_the_truth_in_95_percent_of_cases() -> None:
    rng = np.random.default_rng(11)
    inside = 0
    for _ in range(400):
        # Poles that stray evenly about those of the planes.
        beds = {"h": strayed(HANGING, 8, 3.0, rng)}
        axis = projection_axes(beds, strayed(FAULT, 6, 3.0, rng))["h"]
        assert axis.line is not None
        assert axis.error95_deg is not None
        inside += angle_between_lines(axis.line, met(HANGING, FAULT)) <= axis.error95_deg
    assert 0.93 <= inside / 400 <= 1.0


def strayed(
    plane: tuple[float, float], n: int, sigma_deg: float, rng: Any
) -> tuple[Floats, Floats]:
    normal = planes_to_normals(*plane)
    v = normal + np.radians(sigma_deg) * rng.normal(size=(n, 3))
    v /= np.linalg.norm(v, axis=1)[:, None]
    v = np.where(v[:, 2:] < 0, -v, v)
    return (
        np.degrees(np.arctan2(v[:, 0], v[:, 1])) % 360.0,
        np.degrees(np.arccos(v[:, 2])),
    )


def test_a_folded_domain_is_projected_along_its_own_fold_axis() -> None:
    axis = Line(40.0, 15.0).vector()
    side = np.cross(axis, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side)
    top = np.cross(side, axis)
    poles = [np.cos(a) * top + np.sin(a) * side for a in np.radians([-50, -30, -10, 10, 30, 50])]
    lines = [Line.from_vector(p if p[2] < 0 else -p) for p in poles]
    beds = ([(t.trend_deg + 180.0) % 360.0 for t in lines], [90.0 - t.plunge_deg for t in lines])
    result = projection_axes({"fold": beds})["fold"]
    assert result.line is not None
    assert angle_between_lines(result.line, Line(40.0, 15.0)) < 1e-4
    assert "fold axis" in result.description


def test_homoclinal_domain_without_a_fault_has_no_axis_and_gives_the_reason() -> None:
    result = projection_axes({"h": around(HANGING, 6, 1.0, np.random.default_rng(1))})["h"]
    assert result.line is None
    assert "no fault" in result.description


def test_section_projects_each_domain_along_its_own_axis() -> None:
    """Points on a line along the axis of their domain come to one place."""
    axes = compute_domain_axes(faulted(), "--along")
    curtain = curtain_from_plane(parse_plane_option("000/90"), (0.0, 0.0, 0.0))
    for domain in ("hanging wall", "footwall"):
        line = axes[domain].line
        assert line is not None
        points = np.array([1.0, 0.0, 2.0]) + np.outer([-5.0, 0.0, 9.0], line.vector())
        item = Item("traces", "line", points, "t", "t", "bedding", "", "", domain=domain)
        (flat,), _ = project_items((item,), curtain, ProjectionDirections(None, axes), None)
        assert flat.points == pytest.approx(np.tile(flat.points[:1], (3, 1)), abs=1e-6)
    (finding,) = ProjectionDirections(None, compute_domain_axes(faulted()[:4], "-")).check(curtain)
    assert finding.code == "section.domain-without-axis"
    assert finding.values["domain"] == "hanging wall"


def test_a_fault_between_domains_is_a_line_in_the_section() -> None:
    """All of its points come to the line in which its plane meets the section."""
    items = faulted()
    directions = assign_domain_axes(items, "--along")
    curtain = curtain_from_plane(parse_plane_option("000/90"), (0.0, 0.0, 0.0))
    fault = next(item for item in items if item.kind == "fault")
    rng = np.random.default_rng(2)
    points = np.column_stack([np.zeros(9), rng.uniform(-3, 3, 9), np.linspace(0, 4, 9)])
    trace = replace(fault, layer="traces", form="line", points=points, normal=None)
    (flat,), _ = project_items((trace,), curtain, directions, None)
    assert flat.points[:, 0] == pytest.approx(np.full(9, flat.points[0, 0]), abs=1e-9)
    report = domain_projections(directions, curtain)
    assert sum(each.faults for each in report) == 3


def wall() -> Mesh:
    """An upright coloured wall, 20 m wide and 6 m high, along x."""
    vertices = np.array([[-10.0, 0, -1], [10, 0, -1], [10, 0, 5], [-10, 0, 5]])
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    return Mesh(vertices, faces, colors=np.full((4, 3), [200, 80, 30], np.uint8))


def drawn(tmp_path: Path, items: tuple[Item, ...], name: str) -> tuple[Any, Any, list[str]]:
    planned = plan(wall(), view_along_line(0.0, 0.0), to_world=np.eye(4), gsd=0.1)
    output = write_orthophoto(
        wall(), planned, tmp_path / "o.tif", domain_extent=domain_extent(items, name), force=True
    )
    facts = json.loads(output.sidecar.read_text("utf-8"))
    with rasterio.open(output.image) as file:
        rgba = np.moveaxis(file.read(), 0, 2)
    return rgba, facts, list(output.warnings)


@pytest.mark.parametrize(("name", "right"), [("hanging wall", True), ("footwall", False)])
def test_the_picture_of_a_domain_is_grey_beyond_the_fault(
    tmp_path: Path, name: str, right: bool
) -> None:
    rgba, facts, messages = drawn(tmp_path, faulted(), name)
    middle = rgba.shape[1] // 2
    own, rest = rgba[:, middle + 1 :], rgba[:, : middle - 1]
    if not right:
        own, rest = rest, own
    assert (own[3:-3, 3:-3, :3] == [200, 80, 30]).all()
    assert (np.ptp(rest[3:-3, 3:-3, :3].astype(int), axis=2) == 0).all()
    assert facts["domain"] == {"name": name, "ends_at": ["F"]}
    assert by_code(messages)["domain.ends-at-faults"] == {"domain": name, "faults": ("F",)}


def test_nearest_feature_separates_domains_without_a_fault(tmp_path: Path) -> None:
    items = tuple(item for item in faulted() if item.kind == "bedding")
    rgba, _, messages = drawn(tmp_path, items, "hanging wall")
    assert by_code(messages)["domain.no-fault-between"] == {
        "domain": "hanging wall",
        "others": ("footwall",),
    }
    # The nearest of both lie at x = 4 and -4, z = 0: half way is x = 0 at that height.
    row = rgba[int((5.0 - 0.0) / 0.1), :, :3].astype(int)
    coloured = np.flatnonzero(np.ptp(row, axis=1) > 0)
    assert abs((coloured.min() - 100) * 0.1) < 0.85
    assert coloured.max() >= 198


def test_off_axis_picture_reports_its_distortion() -> None:
    """Lengths times cos d, places displaced by h sin d (CONVENTIONS), d between axis and view."""
    items = faulted()
    line = compute_domain_axes(items, "")["footwall"].line
    assert line is not None
    deep = Mesh(
        np.array([[0.0, 0, 0], [6, 0, 0], [6, 40, 9], [0, 40, 9]]),
        np.array([[0, 1, 2], [0, 2, 3]], np.int32),
    )
    aside = view_along_line((line.trend_deg + 25.0) % 360.0, line.plunge_deg)
    planned = plan(deep, aside, to_world=np.eye(4), gsd=0.5)
    *_, off, cost = domain_extent(items, "footwall").add_view_findings(items, planned).notes
    d = math.acos(abs(float(line.vector() @ planned.frame.direction)))
    h = float(np.ptp(deep.vertices @ planned.frame.direction))
    assert (off.code, cost.code) == ("view.off-axis", "view.off-axis-cost")
    assert off.values["off_deg"] == pytest.approx(math.degrees(d))
    assert cost.values["share_percent"] == pytest.approx(100 * (1 - math.cos(d)))
    assert cost.values["displacement"] == pytest.approx(h * math.sin(d))
    assert cost.values["unit"] == "m"
    along = plan(deep, view_along_line(line.trend_deg, line.plunge_deg), to_world=np.eye(4))
    here = domain_extent(items, "footwall")
    assert here.add_view_findings(items, along).notes == here.notes


def test_conditional_domain_axis_is_reported() -> None:
    """Four beds of a fold tell no shape of the scatter (fold verdict: conditional)."""
    rng = np.random.default_rng(1)
    t = np.radians([-40.0, -10.0, 15.0, 45.0])
    poles = np.column_stack([np.sin(t), 0.02 * rng.normal(size=4), np.cos(t)])
    poles /= np.linalg.norm(poles, axis=1)[:, None]
    beds = (
        np.degrees(np.arctan2(poles[:, 0], poles[:, 1])) % 360,
        np.degrees(np.arccos(poles[:, 2])),
    )
    axes = projection_axes({"fold": beds})
    assert axes["fold"].valid == "conditional"
    curtain = curtain_from_plane(parse_plane_option("010/90"), (0.0, 0.0, 0.0))
    (report,) = domain_projections(ProjectionDirections(None, axes), curtain)
    assert report.valid == "conditional"
    assert report.words.startswith(f"{replace(report, valid='yes').words}; ")


def test_unknown_domain_is_rejected_with_the_available_ones() -> None:
    with refused("domain.unknown", UsageError, domain="wall", domains=("footwall", "hanging wall")):
        domain_extent(faulted(), "wall")
    with refused("domain.none", UsageError, field="--along"):
        compute_domain_axes((), "--along")
