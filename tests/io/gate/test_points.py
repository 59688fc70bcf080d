"""One bed, written in many frames, has one attitude in World."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from pyproj import CRS, Transformer

from tests.frames import DIP_DEG, DIP_DIRECTION_DEG, ORIGIN, ZONE, bed_points, convert, write_prj
from vomstudio.core.errors import InputError, UsageError
from vomstudio.geometry.planes import fit_plane
from vomstudio.geometry.units import METRES_PER_UNIT
from vomstudio.io.gate.frame_options import DEFAULT_FRAME, FrameOptions
from vomstudio.io.gate.points import ModelFrame, WorldPoints, points_to_world
from vomstudio.io.gate.stated_crs import parse_crs_comments
from vomstudio.io.models.frames import establish_frame
from vomstudio.io.models.opening import read_model

Array = npt.NDArray[np.float64]
ATTITUDE = (DIP_DIRECTION_DEG, DIP_DEG)


def bed(east: float = ORIGIN[0], north: float = ORIGIN[1]) -> Array:
    return bed_points(60, seed=38, origin=np.array([east, north, ORIGIN[2]]))


def placed(points: Array, path: Path, options: FrameOptions = DEFAULT_FRAME, **more) -> WorldPoints:
    return points_to_world(points, file=path, options=options, **more)


def attitude(points: Array) -> tuple[float, float]:
    fit = fit_plane(points)
    return fit.dip_direction_deg, fit.dip_deg


def codes(found: WorldPoints) -> list[str]:
    return [finding.code for finding in found.findings]


@pytest.fixture
def table(tmp_path: Path) -> Path:
    return tmp_path / "picks.csv"


FEET = METRES_PER_UNIT["us-ft"]


@pytest.mark.parametrize(
    ("crs", "factors", "expected"),
    [
        (ZONE, (1.0, 1.0, 1.0), []),
        (f"{ZONE}+5703", (1.0, 1.0, 1.0), []),
        (f"{ZONE}+6360", (1.0, 1.0, 1.0 / FEET), ["frame.unit-converted"]),
    ],
    ids=["metres", "heights in metres", "heights in US survey feet"],
)
def test_axes_have_the_units_of_the_prj(table: Path, crs, factors, expected) -> None:
    write_prj(table, crs)
    found = placed(bed() * factors, table)
    assert attitude(found.points) == pytest.approx(ATTITUDE, abs=1e-6)
    assert codes(found) == expected
    assert found.points == pytest.approx(bed(), abs=1e-6)


@pytest.mark.parametrize("heights", ["m", "us-ft"])
def test_state_plane_in_feet_is_converted_to_metres(table: Path, heights: str) -> None:
    crs = {"us-ft": "EPSG:2263", "m": "EPSG:2263+5703"}[heights]
    metric = bed(300_000.0, 60_000.0)
    factors = [1.0 / FEET, 1.0 / FEET, 1.0 / METRES_PER_UNIT[heights]]
    write_prj(table, crs)
    found = placed(metric * factors, table)
    assert found.points == pytest.approx(metric, abs=1e-6)
    assert codes(found) == ["frame.unit-converted"]
    assert found.crs is not None
    assert CRS.from_user_input(found.crs).axis_info[0].unit_name == "metre"


@pytest.mark.parametrize("statement", ["CRS: {}; x East, y North, metres", "{}", "picks, {}; seed"])
def test_a_comment_states_the_crs(table: Path, statement: str) -> None:
    points = convert(bed(), "EPSG:3857")
    with pytest.raises(InputError) as error:
        placed(points, table, comments=(statement.format("EPSG:3857"),))
    assert error.value.code == "frame.not-metric"
    assert error.value.values["suggested_crs"] == ZONE


@pytest.mark.parametrize(
    "source", ["EPSG:3857", "EPSG:4326", "EPSG:32632", "EPSG:3035", "EPSG:4978"]
)
def test_conversion_restores_the_attitude(table: Path, source: str) -> None:
    if source == "EPSG:4978":
        to_geocentric = Transformer.from_crs(CRS.from_user_input(ZONE).to_3d(), source)
        points = np.column_stack(to_geocentric.transform(*bed().T))
    else:
        points = convert(bed(), source)
    write_prj(table, source)
    found = placed(points, table, FrameOptions(to_crs=ZONE))
    assert found.points == pytest.approx(bed(), abs=1e-3)
    assert "frame.reprojected" in codes(found)
    assert attitude(found.points) == pytest.approx(ATTITUDE, abs=1e-3)


def test_points_of_a_model_are_converted_to_its_crs(table: Path) -> None:
    points = convert(bed(), "EPSG:4326")
    write_prj(table, "EPSG:4326")
    found = placed(points, table, model=ModelFrame(ZONE))
    assert found.points == pytest.approx(bed(), abs=1e-3)
    assert found.crs == ZONE


def test_points_without_frame_use_the_world_frame_of_their_model(table: Path) -> None:
    found = placed(bed(), table, model=ModelFrame(ZONE))
    assert (found.crs, codes(found)) == (ZONE, [])
    assert (found.points == bed()).all()


def test_frame_of_table_beside_model_without_crs_is_reported(table: Path) -> None:
    write_prj(table, ZONE)
    assert codes(placed(bed(), table, model=ModelFrame())) == ["frame.model-without-crs"]


@pytest.mark.parametrize(
    ("crs", "code"),
    [
        ("EPSG:4326", "frame.degrees"),
        ("EPSG:4978", "frame.geocentric"),
        ("EPSG:3857", "frame.not-metric"),
    ],
)
def test_non_metric_frame_is_rejected(table: Path, crs: str, code: str) -> None:
    points = bed() if code != "frame.degrees" else bed() * [3e-5, 9e-6, 1.0]
    write_prj(table, crs)
    with pytest.raises(InputError) as error:
        placed(points, table)
    assert error.value.code == code


def test_swapped_columns_are_detected(table: Path) -> None:
    write_prj(table, ZONE)
    with pytest.raises(InputError) as error:
        placed(bed()[:, [1, 0, 2]], table)
    assert error.value.code == "frame.swapped-axes"


def test_swapped_degrees_are_detected(table: Path) -> None:
    exchanged = convert(bed(), "EPSG:4326")[:, [1, 0, 2]]
    write_prj(table, "EPSG:4326")
    with pytest.raises(InputError) as error:
        placed(exchanged, table, FrameOptions(to_crs=ZONE))
    assert error.value.code == "frame.swapped-axes"


def test_a_table_without_a_frame_is_assumed_to_be_metric(table: Path) -> None:
    found = placed(bed(), table)
    (finding,) = found.findings
    assert finding.code == "frame.assumed"
    assert (finding.values["up"], finding.values["unit"]) == ("z", "m")
    assert not placed(bed(), table, comments=("CRS: local; x East, y North, metres",)).findings


def test_probable_degrees_are_reported(table: Path) -> None:
    assert "frame.maybe-degrees" in codes(placed(bed(0.0, 0.0) * [3e-5, 9e-6, 1.0], table))


@pytest.mark.parametrize("unit", sorted(METRES_PER_UNIT))
def test_the_unit_option_scales_all_axes(table: Path, unit: str) -> None:
    points = bed(0.0, 0.0)
    found = placed(points / METRES_PER_UNIT[unit], table, FrameOptions(unit=unit))
    assert found.points == pytest.approx(points, abs=1e-9)


def test_y_up_points_are_rotated_to_z_up(table: Path) -> None:
    points = bed()
    y_up = np.column_stack([points[:, 0], points[:, 2], -points[:, 1]])
    assert placed(y_up, table, FrameOptions(up="y")).points == pytest.approx(points)


def test_options_contradicting_the_table_are_rejected(table: Path) -> None:
    write_prj(table, ZONE)
    with pytest.raises(UsageError):
        placed(bed(), table, FrameOptions(unit="ft"))
    found = placed(bed(), table, FrameOptions(crs="EPSG:25833"))
    assert codes(found) == ["frame.crs-replaced"]


def test_conversion_needs_a_crs(table: Path) -> None:
    with pytest.raises(UsageError):
        placed(bed(), table, FrameOptions(to_crs=ZONE))


def test_an_unknown_crs_is_reported(table: Path) -> None:
    table.with_suffix(".prj").write_text("not a projection")
    assert codes(placed(bed(), table)) == ["frame.crs-unreadable", "frame.assumed"]


def test_rows_without_coordinates_stay_nan(table: Path) -> None:
    write_prj(table, ZONE)
    points = bed()
    points[3] = np.nan
    found = placed(points, table)
    assert np.isnan(found.points[3]).all()
    assert np.isfinite(np.delete(found.points, 3, axis=0)).all()


@pytest.mark.parametrize(
    ("comments", "text"),
    [
        (("CRS: EPSG:32633; x East",), "EPSG:32633"),
        (("from EPSG:4326", "CRS: EPSG:32633"), "EPSG:32633"),
        (("from EPSG:4326 to EPSG:32633",), None),
        (("EPSG::25833",), "EPSG:25833"),
        (("CRS: none declared, coordinates as given",), None),
        (("CRS: local; metres",), None),
        ((f"CoordinateSystem: {CRS.from_epsg(32633).to_wkt()}",), CRS.from_epsg(32633).to_wkt()),
        ((CRS.from_epsg(32633).to_wkt("WKT1_GDAL"),), CRS.from_epsg(32633).to_wkt("WKT1_GDAL")),
        (("nothing",), None),
    ],
)
def test_crs_is_read_from_comments(comments: tuple[str, ...], text: str | None) -> None:
    assert parse_crs_comments(comments).text == text


def test_given_unit_replaces_unit_of_local_crs(tmp_path: Path) -> None:
    """A model and a table state a local system in feet; --unit ft says the same again."""
    wkt = 'LOCAL_CS["site",UNIT["foot",0.3048],AXIS["x",EAST],AXIS["y",NORTH]]'
    feet = bed(0.0, 0.0) / METRES_PER_UNIT["ft"]
    path = tmp_path / "site.xyz"
    np.savetxt(path, feet, fmt="%.9f")
    for options in (DEFAULT_FRAME, FrameOptions(unit="ft")):
        found = points_to_world(feet, file=path, comments=(f"CRS: {wkt}",), options=options)
        assert found.points == pytest.approx(bed(0.0, 0.0), abs=1e-9)
    path.write_text(f"# CRS: {wkt}\n{path.read_text()}")
    for options in (DEFAULT_FRAME, FrameOptions(unit="ft")):
        loaded = read_model(path, options=options)
        to_world = np.array(establish_frame(loaded, options).to_world())
        world = loaded.data.points @ to_world[:3, :3].T + to_world[:3, 3]
        assert world == pytest.approx(bed(0.0, 0.0), abs=1e-6)
