"""`vomstudio facets`: the object and table that are promised, the labels, what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shapely

from tests.extraction.planes_by_construction import angle_deg, clouds_of, normal_of, sheet
from tests.messages import messages
from vomstudio.io.gate.orientation_files import read_orientations
from vomstudio.io.models.opening import read_model

PROMISED = {"facets", "table", "coverage", "near_planar_share", "sets"}
ATTITUDES = [(40.0, 70.0), (130.0, 85.0), (250.0, 15.0)]


@pytest.fixture
def cloud(tmp_path: Path) -> Path:
    rng = np.random.default_rng(1)
    parts = [sheet(rng, a, (4.0 * i, 0.0, 0.0), count=2000) for i, a in enumerate(ATTITUDES)]
    points = clouds_of(*parts)[0].points
    path = tmp_path / "cloud.xyz"
    np.savetxt(path, points, fmt="%.5f")
    return path


def test_facets_are_reported_in_json_and_written_to_table(run, cloud: Path, tmp_path: Path) -> None:
    table, labels = tmp_path / "facets.csv", tmp_path / "labels.ply"
    ran = run("facets", cloud, "-o", table, "--labels", labels, "--json")
    assert ran.code == 0
    assert ran.json.keys() >= PROMISED
    assert ran.json["facets"] == 3
    assert ran.json["sets"] == []
    assert ran.json["coverage"] > 0.95
    assert ran.json["near_planar_share"] > 0.95
    read = read_orientations(table)
    found = sorted(zip(read.dip_deg.tolist(), read.dip_direction_deg.tolist(), strict=True))
    for (dip, direction), (wanted_direction, wanted_dip) in zip(
        found, sorted(ATTITUDES, key=lambda a: a[1]), strict=True
    ):
        assert dip == pytest.approx(wanted_dip, abs=0.1)
        assert direction == pytest.approx(wanted_direction, abs=0.3)
    data = read_model(labels).data
    for name in ("facet", "set"):
        assert data.fields[name].dtype == np.int32
    facet = np.asarray(data.fields["facet"])
    assert set(facet.tolist()) <= {-1, 0, 1, 2}
    assert (np.asarray(data.fields["set"]) == -1).all()
    assert set(read.ids) == {"0", "1", "2"}


def test_sets_are_named_in_table_and_numbered_in_labels(run, tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    parts = [
        sheet(
            rng,
            ATTITUDES[k % 3],
            (3.0 * (k % 6), 3.0 * (k // 6), 0.0),
            size=1.5,
            count=400,
        )
        for k in range(36)
    ]
    cloud, part = clouds_of(*parts)
    path, table, labels = (tmp_path / name for name in ("c.xyz", "t.csv", "l.ply"))
    np.savetxt(path, cloud.points, fmt="%.5f")
    ran = run("facets", path, "-o", table, "--labels", labels, "--propose-sets", "--json")
    assert ran.code == 0
    assert ran.json["facets"] == 36
    sets = ran.json["sets"]
    assert [one["n"] for one in sets] == [12, 12, 12]
    for direction, dip in ATTITUDES:
        near = min(
            sets,
            key=lambda one: angle_deg(
                normal_of(one["dip_direction_deg"], one["dip_deg"]), normal_of(direction, dip)
            ),
        )
        found = normal_of(near["dip_direction_deg"], near["dip_deg"])
        assert angle_deg(found, normal_of(direction, dip)) < 1.0
    field = np.asarray(read_model(labels).data.fields["set"])
    assert field.dtype == np.int32
    for k in range(3):
        assert len(set(field[(part % 3 == k) & (field >= 0)].tolist())) == 1
    names = read_orientations(table).sets
    assert names is not None
    assert set(names) == {one["name"] for one in sets}


def test_stats_and_fold_read_the_table(run, cloud: Path, tmp_path: Path) -> None:
    table = tmp_path / "facets.csv"
    assert run("facets", cloud, "-o", table).code == 0
    assert run("stats", table, "--json").json["n"] == 3
    assert run("fold", table, "--json").json["n"] == 3
    assert run("stereonet", table, "-o", tmp_path / "net.svg").code == 0


def test_facet_outline_has_area_of_its_row(run, cloud: Path, tmp_path: Path) -> None:
    import pandas

    table = tmp_path / "facets.csv"
    assert run("facets", cloud, "-o", table).code == 0
    rows = pandas.read_csv(table, comment="#")
    for text, area, dip in rows[["wkt", "area_m2", "dip_deg"]].itertuples(index=False):
        border = shapely.from_wkt(text)
        assert border.is_valid
        # Seen from above it is smaller by the cosine of the dip.
        assert border.area == pytest.approx(area * np.cos(np.radians(dip)), rel=0.05)


def test_no_facets_is_a_valid_result(run, cloud: Path, tmp_path: Path) -> None:
    ran = run("facets", cloud, "-o", tmp_path / "none.csv", "--min-area", "1000", "--json")
    assert ran.code == 0
    assert ran.json["facets"] == 0
    assert ran.json["coverage"] == 0.0
    assert "No facet" in messages(ran.json)[-1]


@pytest.mark.parametrize(
    "words",
    [
        ["--angle", "0"],
        ["--angle", "90"],
        ["--angle", "nan"],
        ["--max-distance", "-1"],
        ["--min-points", "2"],
        ["--min-area", "inf"],
        ["--labels", "out.doc"],
    ],
)
def test_wrong_thresholds_are_refused_before_anything_is_read(
    run, tmp_path: Path, words: list[str]
) -> None:
    ran = run("facets", tmp_path / "missing.ply", "-o", tmp_path / "t.csv", *words)
    assert ran.code == 2
    assert words[0] in ran.said or words[1] in ran.said


def test_outputs_are_replaced_with_force_only(run, cloud: Path, tmp_path: Path) -> None:
    table = tmp_path / "facets.csv"
    table.write_text("mine")
    assert run("facets", cloud, "-o", table).code == 2
    assert table.read_text() == "mine"
    assert run("facets", cloud, "-o", table, "--force").code == 0
    assert run("facets", cloud, "-o", cloud, "--force").code == 2


def test_dse_preset_finds_sets_and_discontinuities(run, tmp_path: Path) -> None:
    path = tmp_path / "cube.xyz"
    rng = np.random.default_rng(3)
    squares = [
        sheet(rng, attitude, tuple(end * normal_of(*attitude)), count=1500)
        for attitude in ((20.0, 90.0), (110.0, 90.0), (0.0, 0.0))
        for end in (-1.0, 1.0)
    ]
    np.savetxt(path, np.concatenate(squares), fmt="%.4f")
    table = tmp_path / "planes.csv"
    ran = run("facets", path, "-o", table, "--preset", "dse", "--json")
    assert ran.code == 0, ran.err
    assert len(ran.json["sets"]) == 3
    assert len(ran.json["discontinuities"]) == 6
    header = next(line for line in table.read_text().splitlines() if not line.startswith("#"))
    assert header.split(",")[-2:] == ["discontinuity", "wkt"]
    again = run("sets", table, "-o", tmp_path / "sets.csv", "--json")
    assert again.code == 0, again.err
    assert again.json["n"] == 6
