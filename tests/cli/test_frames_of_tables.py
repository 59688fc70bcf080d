"""The `.prj` and the CRS of a table of points count in every command that reads one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import vomstudio as vs
from tests import frames
from tests.frames import ZONE, bed_grid, convert, write_cloud, write_table
from tests.messages import codes
from vomstudio.geometry.units import METRES_PER_UNIT

HEADER = "x,y,z"
PAIRS = "hanging_x,hanging_y,hanging_z,footwall_x,footwall_y,footwall_z"


def bed_points() -> np.ndarray:
    return frames.bed_points(12, seed=3)


def displaced_pairs() -> np.ndarray:
    """Pairs that a fault of 090/60 displaced by 10 m down the dip."""
    slip = 10.0 * np.array([np.cos(np.radians(60.0)), 0.0, -np.sin(np.radians(60.0))])
    footwall = bed_points()[:4]
    return np.column_stack([footwall + slip, footwall])


COMMANDS = {
    "fit": (HEADER, bed_points, "fit {table}"),
    "threepoint": (HEADER, bed_points, "threepoint {table}"),
    "log": (HEADER, bed_points, "log {table} --bed 60/60"),
    "displacement": (PAIRS, displaced_pairs, "displacement {table} --fault 90/60"),
}


def figures(name: str, answer: dict) -> list[float]:
    if name == "fit":
        return [answer["planes"][0]["dip_direction_deg"], answer["planes"][0]["dip_deg"]]
    if name == "threepoint":
        return [answer["dip_direction_deg"], answer["dip_deg"]]
    if name == "log":
        return [answer["total_m"]["value"]]
    return [answer["mean_net_m"], answer["mean_throw_m"]]


@pytest.mark.parametrize("name", COMMANDS)
class TestFramesOfTables:
    def test_results_do_not_depend_on_units_of_table(self, run, tmp_path: Path, name: str) -> None:
        header, points, words = COMMANDS[name]
        metric = write_table(tmp_path / "metric.csv", points(), ZONE, header)
        expected = figures(name, run(*words.format(table=metric).split(), "--json").json)
        feet = METRES_PER_UNIT["us-ft"]
        heights = points() / np.tile([1.0, 1.0, feet], len(header.split(",")) // 3)
        mixed = write_table(tmp_path / "mixed.csv", heights, f"{ZONE}+6360", header)
        answer = run(*words.format(table=mixed).split(), "--json").json
        assert figures(name, answer) == pytest.approx(expected, rel=1e-6)
        assert "frame.unit-converted" in codes(answer)
        all_feet = write_table(
            tmp_path / "feet.csv", points() / METRES_PER_UNIT["ft"], None, header
        )
        answer = run(*words.format(table=all_feet).split(), "--unit", "ft", "--json").json
        assert figures(name, answer) == pytest.approx(expected, rel=1e-6)

    @pytest.mark.parametrize(
        ("crs", "code"), [("EPSG:3857", "frame.not-metric"), ("EPSG:4326", "frame.degrees")]
    )
    def test_non_metric_table_is_refused_or_converted(
        self, run, tmp_path: Path, name: str, crs: str, code: str
    ) -> None:
        header, points, words = COMMANDS[name]
        metric = write_table(tmp_path / "metric.csv", points(), ZONE, header)
        expected = figures(name, run(*words.format(table=metric).split(), "--json").json)
        table = write_table(tmp_path / "picks.csv", convert(points(), crs), crs, header)
        command = words.format(table=table).split()
        refused = run(*command, "--json")
        assert (refused.code, refused.json["error"]["code"]) == (2, code)
        converted = run(*command, "--to-crs", ZONE, "--json")
        assert converted.code == 0, converted.err
        assert figures(name, converted.json) == pytest.approx(expected, rel=1e-4)
        assert "frame.reprojected" in codes(converted.json)

    def test_an_assumed_frame_is_reported(self, run, tmp_path: Path, name: str) -> None:
        header, points, words = COMMANDS[name]
        table = write_table(tmp_path / "picks.csv", points(), None, header)
        answer = run(*words.format(table=table).split(), "--json").json
        assert "frame.assumed" in codes(answer)


@pytest.mark.filterwarnings("ignore::vomstudio.core.errors.VomWarning")
@pytest.mark.parametrize("call", [vs.threepoint, lambda t, **k: vs.log(t, bed=(60, 60), **k)])
def test_python_functions_use_prj_file(tmp_path: Path, call) -> None:
    mercator = write_table(tmp_path / "picks.csv", convert(bed_points(), "EPSG:3857"), "EPSG:3857")
    with pytest.raises(vs.errors.InputError) as error:
        call(mercator)
    assert error.value.code == "frame.not-metric"
    metric = write_table(tmp_path / "metric.csv", bed_points(), ZONE)
    converted = call(mercator, to_crs=ZONE)
    assert "frame.reprojected" in codes({"warnings": converted.warnings})
    expected = call(metric)
    name = "dip_deg" if hasattr(expected, "dip_deg") else "total_m"
    first, second = getattr(converted, name), getattr(expected, name)
    first, second = getattr(first, "value", first), getattr(second, "value", second)
    assert first == pytest.approx(second, rel=1e-4)


def test_a_geodataframe_in_degrees_is_refused() -> None:
    geopandas = pytest.importorskip("geopandas")
    points = convert(bed_points(), "EPSG:4326")
    frame = pd.DataFrame(points, columns=["x", "y", "z"]).assign(bed="A")
    places = geopandas.points_from_xy(frame.x, frame.y)
    table = geopandas.GeoDataFrame(frame, geometry=places, crs="EPSG:4326")
    for call in (lambda: vs.fit_planes(table, by="bed"), lambda: vs.threepoint(table)):
        with pytest.raises(vs.errors.InputError) as error:
            call()
        assert error.value.code == "frame.degrees"


def test_picks_are_converted_to_crs_of_model(run, tmp_path: Path) -> None:
    cloud = bed_grid()
    model = write_cloud(tmp_path / "model.xyz", cloud, ZONE)
    rng = np.random.default_rng(5)
    picks = cloud[rng.choice(len(cloud), 12, replace=False)]
    answers = []
    for crs in (None, ZONE, "EPSG:4326"):
        points = picks if crs in (None, ZONE) else convert(picks, crs)
        table = write_table(tmp_path / f"picks_{len(answers)}.csv", points, crs)
        out = tmp_path / f"extended_{len(answers)}.csv"
        answers.append(run("extend", model, table, "-o", out, "--json").json)
    assert all(
        (each["dip_direction_deg"], each["dip_deg"]) == pytest.approx((90.0, 30.0), abs=1e-3)
        for each in answers
    )
    assert [codes(each) for each in answers[:2]] == [[], []]
    assert "frame.reprojected" in codes(answers[2])
