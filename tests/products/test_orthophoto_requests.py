"""Which orthophoto is asked for, what is said of it, and the same picture in memory."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rasterio

from tests.marked import UTM, marked_cloud, marked_mesh
from tests.messages import refused
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import Plane, lines_to_vectors
from vomstudio.geology.table_folds import TableFold, table_fold
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.gate.orientation_files import read_orientations
from vomstudio.products.ortho import tiles
from vomstudio.products.ortho.drawn_picture import draw_picture, picture_figures
from vomstudio.products.ortho.ortho_options import OrthoOptions
from vomstudio.products.ortho.orthophoto import write_orthophoto
from vomstudio.products.ortho.planning import plan
from vomstudio.products.ortho.requests import (
    Direction,
    PlannedPicture,
    collect_result,
    direction_from_options,
    plan_picture,
)
from vomstudio.products.ortho.view_directions import (
    AS_GIVEN,
    REVERSED,
    cost_of_direction,
    is_costly,
    view_along_axis,
    view_along_line,
)

SAME = np.eye(4)
MODEL = Path("model.obj")
FLOOR = Mesh(
    np.array([(0, 0, 0), (10, 0, 0), (10, 10, 0), (0, 10, 0)], np.float64),
    np.array([[0, 1, 2], [0, 2, 3]], np.int32),
)


def ask(data: Any, direction: Direction, **more: Any) -> PlannedPicture:
    return plan_picture(data, direction, to_world=SAME, path=MODEL, **more)


def cylinder(folder: Path, wobble_deg: float = 1.0) -> TableFold:
    """Beds about an axis that plunges 20 degrees to 090, their poles a little off its pi-plane."""
    rng = np.random.default_rng(7)
    axis = lines_to_vectors(90.0, 20.0)
    one = np.cross(axis, (0.0, 0.0, 1.0))
    one /= np.linalg.norm(one)
    two = np.cross(axis, one)
    turn = np.radians(np.linspace(-70, 70, 30))[:, None]
    poles = np.cos(turn) * two + np.sin(turn) * one
    poles += math.radians(wobble_deg) * rng.normal(size=poles.shape)
    poles /= np.linalg.norm(poles, axis=1, keepdims=True)
    poles *= np.where(poles[:, 2:] < 0, -1.0, 1.0)
    dip = np.degrees(np.arccos(poles[:, 2]))
    direction = np.degrees(np.arctan2(poles[:, 0], poles[:, 1])) % 360
    table = folder / "beds.csv"
    rows = "".join(f"{a:.3f},{b:.3f}\n" for a, b in zip(direction, dip, strict=True))
    table.write_text("dip_direction,dip\n" + rows, encoding="utf-8")
    return table_fold(read_orientations(table))


# Which way ------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("inputs", "code", "field"),
    [
        ({"trend_deg": 10.0, "plunge_deg": 20.0, "plane": "10/20"}, "option.conflict", "--plane"),
        ({"trend_deg": 10.0, "plunge_deg": 20.0, "fold": "t.csv"}, "option.conflict", "--fold"),
        ({"plane": "10/20", "fold": "t.csv"}, "option.conflict", "--fold"),
        ({"plunge_deg": 10.0, "plane": "10/20"}, "option.conflict", "--plane"),
        ({"trend_deg": 10.0}, "option.requires", "--trend"),
        ({"plunge_deg": 10.0}, "option.requires", "--plunge"),
        ({"plunge_deg": 91.0, "trend_deg": 1.0}, "option.out-of-range", "--plunge"),
        ({"gsd_m": 0.0}, "option.not-a-length", "--gsd"),
        ({"gsd_m": -0.1}, "option.not-a-length", "--gsd"),
        ({"gsd_m": math.inf}, "option.not-a-length", "--gsd"),
        ({"gsd_m": math.nan}, "option.not-a-length", "--gsd"),
    ],
)
def test_invalid_directions_and_sizes_are_rejected(
    inputs: dict[str, Any], code: str, field: str
) -> None:
    with pytest.raises(UsageError) as error:
        OrthoOptions(**inputs)
    assert (error.value.code, error.value.field) == (code, field)


def test_direction_is_required() -> None:
    with pytest.raises(UsageError) as error:
        direction_from_options(OrthoOptions(gsd_m=1e-9), None)
    assert error.value.code == "option.none-given"


def test_view_follows_the_requested_direction(tmp_path: Path) -> None:
    line = direction_from_options(OrthoOptions(trend_deg=370.0, plunge_deg=-30.0), None)
    assert line.view is not None
    assert (line.view.trend_deg, line.view.plunge_deg, line.fold) == (10.0, -30.0, None)
    plane = direction_from_options(OrthoOptions(plane="120/40"), None)
    assert plane.view is not None
    assert plane.view.frame.direction == pytest.approx(-Plane(120, 40).normal(), abs=1e-12)
    fold = cylinder(tmp_path)
    assert direction_from_options(OrthoOptions(fold="t.csv"), fold) == Direction(None, fold)
    with pytest.raises(UsageError) as raised:
        direction_from_options(OrthoOptions(plane="steep"), None)
    assert raised.value.field == "--plane"
    assert "steep" in raised.value.message


# What is asked for ----------------------------------------------------------------------------
def test_request_contains_the_plan_of_its_view() -> None:
    requests = ask(
        FLOOR, direction_from_options(OrthoOptions(trend_deg=0.0, plunge_deg=90.0), None), gsd_m=0.5
    )
    assert (requests.plan.grid.width, requests.plan.grid.height, requests.plan.grid.gsd) == (
        20,
        20,
        0.5,
    )
    assert (requests.fold, requests.warnings) == (None, ())
    assert requests.plan.view.is_north_known
    assert requests.plan.view.is_metric


def test_flipped_request_has_the_opposite_direction() -> None:
    direction = direction_from_options(OrthoOptions(trend_deg=30.0, plunge_deg=50.0), None)
    there, back = (ask(FLOOR, direction, gsd_m=1.0, flip=flip) for flip in (False, True))
    assert back.plan.frame.direction == pytest.approx(-there.plan.frame.direction, abs=1e-12)
    assert back.plan.view.sense == REVERSED


@pytest.mark.parametrize("metric", [True, False])
def test_unregistered_model_is_reported(metric: bool) -> None:
    requests = ask(
        FLOOR,
        direction_from_options(OrthoOptions(trend_deg=0.0, plunge_deg=90.0), None),
        gsd_m=1,
        is_placed=False,
        is_metric=metric,
    )
    assert requests.warnings == (Finding("view.not-placed"),)
    assert not requests.plan.view.is_north_known
    assert requests.plan.view.is_metric == metric


def test_model_that_cannot_be_drawn_is_reported_with_its_file() -> None:
    empty = Mesh(FLOOR.vertices, np.zeros((0, 3), np.int32))
    with refused("model.no-surface", file=MODEL):
        ask(empty, direction_from_options(OrthoOptions(trend_deg=0.0, plunge_deg=90.0), None))
    for data in (empty, PointCloud(np.zeros((0, 3)))):
        with refused("model.no-surface"):
            view_along_axis(0.0, 30.0, data, SAME)


def test_too_many_pixels_are_rejected_with_their_number() -> None:
    """10 m by 10 m at a hundredth of a millimetre are 10^12 pixels."""
    with refused("gsd.too-many-pixels", UsageError, megapixels=1e6, limit=300):
        ask(
            FLOOR,
            direction_from_options(OrthoOptions(trend_deg=0.0, plunge_deg=90.0), None),
            gsd_m=1e-5,
        )


# Along the axis of a fold ---------------------------------------------------------------------
def test_fold_is_viewed_along_its_axis_with_the_cost_of_the_axis_error(tmp_path: Path) -> None:
    fold = replace(cylinder(tmp_path), valid="yes")
    assert fold.beta.trend_deg == pytest.approx(90, abs=1)
    assert fold.beta.plunge_deg == pytest.approx(20, abs=1)
    # A wall that faces West, 4 m deep along the view's horizontal.
    corners = [(0, 0, 0), (0, 10, 0), (0, 10, 5), (0, 0, 5), (4, 0, 0), (4, 10, 0), (4, 10, 5)]
    wall = Mesh(
        np.array(corners, np.float64),
        np.array([[0, 3, 2], [0, 2, 1], [4, 6, 5]], np.int32),
    )
    requests = ask(wall, Direction(None, fold), gsd_m=0.5)
    assert requests.plan.view.sense == "down-plunge"
    assert requests.plan.view.trend_deg == pytest.approx(fold.beta.trend_deg)
    assert requests.plan.view.plunge_deg == pytest.approx(fold.beta.plunge_deg)
    axis = lines_to_vectors(fold.beta.trend_deg, fold.beta.plunge_deg)
    depth = float(np.ptp(wall.vertices @ axis))
    along = requests.fold
    assert along is not None
    assert along.cost == cost_of_direction(fold.beta.max_confidence95_deg, depth)
    assert (along.beta, along.valid, along.verdict) == (fold.beta, fold.valid, fold.verdict)
    assert (along.reasons, along.used, along.left_out) == (fold.reasons, 30, ())


@pytest.mark.parametrize(
    ("error_deg", "depth", "costs"),
    [
        # Tables of sines and cosines: sin 0.5 = 0.0087, sin 0.6 = 0.0105, sin 5.7 = 0.0993,
        # cos 8.1 = 0.9900, cos 8.2 = 0.9898.
        (0.5, 10.0, False),
        (0.6, 10.0, True),
        (5.0, 1.0, False),
        (5.8, 1.0, True),
        (8.1, 0.0, False),
        (8.2, 0.0, True),
        (0.0, 50.0, False),
        (None, 0.0, True),
    ],
)
def test_cost_below_a_hundredth_of_the_picture_is_negligible(
    error_deg: float | None, depth: float, costs: bool
) -> None:
    """A picture 10 m long: its hundredth is 0.1 m."""
    assert is_costly(error_deg, depth, 10.0) == costs


@pytest.mark.parametrize(("deep", "warned"), [(0.05, False), (60.0, True)])
def test_axis_error_gives_a_warning_only_if_its_cost_is_not_negligible(
    tmp_path: Path, deep: float, warned: bool
) -> None:
    fold = replace(cylinder(tmp_path), valid="yes")
    axis = lines_to_vectors(fold.beta.trend_deg, fold.beta.plunge_deg)
    across = np.cross(axis, (0.0, 0.0, 1.0))
    across /= np.linalg.norm(across)
    up = np.cross(across, axis)
    corners = [20 * a * across + 10 * b * up for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
    wall = Mesh(
        np.array([*corners, corners[2] + deep * axis]),
        np.array([[0, 1, 2], [0, 2, 3], [1, 2, 4]], np.int32),
    )
    requests = ask(wall, Direction(None, fold), gsd_m=0.5)
    assert requests.fold is not None
    assert requests.fold.cost
    assert requests.warnings == ((requests.fold.cost,) if warned else ())


def test_untrusted_fold_axis_is_reported(tmp_path: Path) -> None:
    warning = Finding("table.rows-left-out", count=1, needed="angles", lines=7)
    fold = replace(cylinder(tmp_path), warnings=(warning,))
    for valid, code in (("conditional", "view.axis-conditional"), ("no", "view.axis-not-valid")):
        doubtful = replace(fold, valid=valid, verdict="few planes")
        requests = ask(FLOOR, Direction(None, doubtful), gsd_m=1.0, is_placed=False)
        assert requests.fold is not None
        first, second, *others = requests.warnings
        assert first == warning
        assert second == Finding(code, verdict="few planes")
        assert others == [requests.fold.cost, Finding("view.not-placed")]


# What is drawn --------------------------------------------------------------------------------
@pytest.mark.parametrize("kind", ["mesh", "cloud"])
def test_picture_in_memory_matches_the_files(
    tmp_path: Path, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In tiles that do not divide the picture."""
    monkeypatch.setattr(tiles, "TILE", 64)
    data = marked_mesh(tmp_path)[0] if kind == "mesh" else marked_cloud(20_000)[0]
    planned = plan(data, view_along_line(40.0, 35.0), to_world=SAME, gsd=0.03)
    assert planned.grid.width > 64
    assert planned.grid.height > 64
    assert planned.grid.width % 64
    drawn = draw_picture(data, planned)
    output = write_orthophoto(data, planned, tmp_path / "o.tif", crs="EPSG:32633")
    with rasterio.open(output.image) as image, rasterio.open(output.depth) as depth:
        assert np.array_equal(np.moveaxis(image.read(), 0, 2), drawn.rgba)
        np.testing.assert_array_equal(depth.read(1), drawn.depth)
    assert np.array_equal(drawn.rgba[..., 3] > 0, np.isfinite(drawn.depth))
    figures = picture_figures(drawn, planned, "EPSG:32633")
    of_view, of_model = Finding("view.not-placed"), Finding("frame.no-unit")
    requests = PlannedPicture(planned, None, (of_view,))
    report = collect_result(output, requests, str(output.image), None, (of_model,))
    assert report.figures.to_dict() == figures.to_dict()
    assert report.warnings == (of_model, of_view, *output.warnings)
    assert figures.crs is None
    if kind == "cloud":
        assert drawn.filled > 0
        assert figures.holes_filled_px == drawn.filled
        assert figures.holes_filled_up_to_m == drawn.hole_m
    # Written from memory, nothing is drawn or counted twice.
    again = write_orthophoto(data, planned, tmp_path / "again.tif", drawn_source=drawn)
    assert again.metadata["holes_filled_px"] == drawn.filled
    assert again.image.read_bytes()[-1000:] == output.image.read_bytes()[-1000:]
    with rasterio.open(again.image) as image:
        assert np.array_equal(np.moveaxis(image.read(), 0, 2), drawn.rgba)


def test_figures_describe_the_picture(tmp_path: Path) -> None:
    """A floor of 10 m by 10 m at UTM, as a map, of which a quarter is cut out."""
    corners = [(0, 0), (5, 0), (10, 0), (0, 5), (5, 5), (10, 5), (0, 10), (5, 10)]
    floor = Mesh(
        np.column_stack([np.array(corners, np.float64), np.zeros(8)]) + UTM,
        np.array([[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [3, 4, 7], [3, 7, 6]], np.int32),
    )
    requests = ask(
        floor, direction_from_options(OrthoOptions(trend_deg=0.0, plunge_deg=90.0), None), gsd_m=0.5
    )
    drawn = draw_picture(floor, requests.plan)
    figures = picture_figures(drawn, requests.plan, "EPSG:32633")
    assert (figures.width, figures.height, figures.gsd_m) == (20, 20, 0.5)
    assert figures.coverage == pytest.approx(0.75, abs=0.01)
    assert figures.reference_point == pytest.approx(UTM + [5, 5, 0], abs=1e-9)
    assert figures.crs == "EPSG:32633"
    assert (figures.holes_filled_px, figures.holes_filled_up_to_m) == (0, None)
    assert (figures.sense, figures.sense_reason) == (AS_GIVEN, Finding("view.as-given"))
    assert figures.direction == pytest.approx((0, 0, -1))
    assert figures.right == pytest.approx((1, 0, 0))
    assert figures.down == pytest.approx((0, -1, 0))
    matrix = np.array(figures.pixel_to_world)
    assert matrix @ (0, 0, 0, 1) == pytest.approx([*(UTM + [0, 10, 0]), 1], abs=1e-6)
    output = write_orthophoto(floor, requests.plan, tmp_path / "o.tif", crs="EPSG:32633")
    report = collect_result(output, requests, "o.tif", None).to_dict()
    assert report["world_file"] == str(tmp_path / "o.tfw")
    assert report["sidecar"] == str(tmp_path / "o.json")
    assert report["depth"] == str(tmp_path / "o_depth.tif")
    assert (report["image"], report["sheet"], report["fold"]) == ("o.tif", None, None)
    expected = figures.to_dict()
    assert {name: report[name] for name in expected} == expected
    assert list(report)[-2:] == ["fold", "warnings"]


def test_away_facing_share_of_two_halves_does_not_depend_on_point_order() -> None:
    """Two halves of one area: one faces the viewer, one, far behind, turns its back. Its share is a
    half whichever point is named first."""
    from vomstudio.geometry.view_frame import ViewFrame
    from vomstudio.products.ortho.cloud_picture import away_facing_share

    g = np.linspace(-1, 1, 200)
    x, y = (part.ravel() for part in np.meshgrid(g, g))
    points = np.column_stack([x, y, np.where(x + y > 0, -10.0, 0.0)])
    normals = np.column_stack([np.zeros((len(x), 2)), np.where(x + y > 0, -1.0, 1.0)])
    frame = ViewFrame.from_direction((0.0, 0.0, -1.0))
    seen = frame.to_view(points, np.zeros(3))
    up = np.array([0.0, 0.0, 1.0]) @ frame.axes
    for order in (slice(None), slice(None, None, -1)):
        share, guessed = away_facing_share(seen[order], normals[order] @ frame.axes, up)
        assert not guessed
        assert share == pytest.approx(0.5, abs=0.02)
