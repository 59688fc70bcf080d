"""`vomstudio dem`."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pyogrio
import pytest
import rasterio

from vomstudio.geometry.frames import WORLD_NORTHS

PROMISED = ("raster", "width", "height", "gsd_m", "coverage", "reference_point")


@pytest.fixture
def table(tmp_path: Path) -> Path:
    """z = 100 + 0.5 x - 0.25 y over 20 x 10 m, with a row without a height."""
    x, y = (v.ravel() for v in np.meshgrid(np.arange(0, 20.5, 0.5), np.arange(0, 10.5, 0.5)))
    rows = [f"{a},{b},{100 + 0.5 * a - 0.25 * b}" for a, b in zip(x, y, strict=True)]
    path = tmp_path / "points.csv"
    path.write_text("x,y,z\n" + "\n".join([*rows, "1,1,nan"]) + "\n")
    return path


def test_dem_reports_and_writes_documented_outputs(run, table: Path, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    out = tmp_path / "d.tif"
    ran = run(
        "dem",
        table,
        "-o",
        out,
        "--gsd",
        0.5,
        "--crs",
        "EPSG:32633",
        "--hillshade",
        "--slope",
        "--aspect",
        "--contours",
        1,
        "--json",
    )
    assert ran.code == 0, ran.err
    found = ran.json
    assert list(found)[:6] == list(PROMISED)
    assert (found["width"], found["height"], found["gsd_m"]) == (40, 20, 0.5)
    assert found["reference_point"] == [10.0, 5.0, 103.75]
    assert found["coverage"] == 1.0
    with rasterio.open(out) as file:
        assert file.crs.to_epsg() == 32633
        assert file.dtypes == ("float32",)
        assert file.nodata is not None
        z = file.read(1)
        for row, column in ((0, 0), (7, 21), (19, 39)):
            x, y = file.xy(row, column)
            assert z[row, column] == pytest.approx(100 + 0.5 * x - 0.25 * y, abs=1e-5)
    with rasterio.open(found["slope"]) as file:
        slope = file.read(1, masked=True)
        assert slope.max() == pytest.approx(np.degrees(np.arctan(np.hypot(0.5, 0.25))), abs=1e-3)
    with rasterio.open(found["aspect"]) as file:
        # It falls toward West and, half as steeply, North.
        assert file.read(1, masked=True).mean() == pytest.approx(296.565, abs=1e-2)
    with rasterio.open(found["hillshade"]) as file:
        assert (file.dtypes, file.nodata) == (("uint8",), 0)
    meta, _, _, (heights,) = pyogrio.raw.read(found["contours"])
    assert meta["crs"] == "EPSG:32633"
    assert sorted(set(heights)) == list(range(98, 110))
    facts = json.loads(Path(found["sidecar"]).read_text("utf-8"))
    assert facts["cell_to_world"] == found["cell_to_world"]
    assert (facts["world_crs"], facts["north"]) == ("EPSG:32633", WORLD_NORTHS["crs"])
    assert run("dem", table, "-o", out, "--json").code == 2
    assert run("dem", table, "-o", out, "--json", "--force").code == 0


def test_oblique_dem_is_true_to_scale_in_local_metres(run, table, tmp_path) -> None:  # type: ignore[no-untyped-def]
    out = tmp_path / "o.tif"
    found = run("dem", table, "-o", out, "--gsd", 0.5, "--plane", "270/26", "--json").json
    with rasterio.open(out) as file:
        assert not file.crs.is_geographic
        assert not file.crs.is_projected
        assert 'UNIT["metre",1' in file.crs.to_wkt()
        assert file.res == (0.5, 0.5)
        z = file.read(1)
        rows, columns = np.nonzero(np.isfinite(z))
        x, y = file.xy(rows, columns)
    cells = np.stack([columns + 0.5, rows + 0.5, z[rows, columns], np.ones(len(rows))])
    world = (np.array(found["cell_to_world"]) @ cells)[:3]
    assert np.abs(100 + 0.5 * world[0] - 0.25 * world[1] - world[2]).max() < 1e-5
    # Metres right and up of the reference point.
    across = world - np.array(found["reference_point"])[:, None]
    assert np.asarray(x) == pytest.approx(np.array(found["right"]) @ across)
    assert np.asarray(y) == pytest.approx(-np.array(found["down"]) @ across)
    assert found["coverage"] == pytest.approx(np.isfinite(z).mean())


@pytest.mark.parametrize(
    ("words", "code", "field"),
    [
        (["--gsd", "0"], "option.not-a-length", "--gsd"),
        (["--plane", "95"], "notation.one-angle", "--plane"),
        (["--plane", "10/95"], "notation.dip-out-of-range", "--plane"),
        (["--limit", "-1"], "option.not-a-length", "--limit"),
        (["--contours", "nan"], "option.not-a-length", "--contours"),
        (["--gsd", "1e-6"], "gsd.too-many-pixels", "--gsd"),
        (["--limit", "0.01"], "dem.no-heights", None),
    ],
)
def test_impossible_requests_are_refused_with_code_and_field(
    run, table, tmp_path, words, code, field
) -> None:  # type: ignore[no-untyped-def]
    ran = run("dem", table, "-o", tmp_path / "d.tif", *words, "--json")
    assert ran.code == 2
    assert (ran.json["error"]["code"], ran.json["error"]["field"]) == (code, field)
    assert not list(tmp_path.glob("d*"))


def test_a_wall_cannot_be_seen_from_above(run, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    wall = tmp_path / "wall.obj"
    wall.write_text("v 0 0 0\nv 0 5 0\nv 0 5 5\nv 0 0 5\nf 1 2 3\nf 1 3 4\n")
    ran = run("dem", wall, "-o", tmp_path / "d.tif", "--gsd", 0.5)
    assert ran.code == 2
    assert "edge-on" in ran.err
    assert run("dem", wall, "-o", tmp_path / "d.tif", "--gsd", 0.5, "--plane", "90/90").code == 0
    assert run("dem", wall, "-o", tmp_path / "x.txt").code == 2
    ran = run("dem", wall, "-o", tmp_path / "e.tif", "--limit", 3, "--json")
    assert ran.json["error"]["code"] == "option.clouds-only"


def test_model_uses_registration_of_its_project(run, table: Path, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    """Registered to World by points: twice as large, turned by 90 degrees, shifted."""
    import vomstudio as vs
    from vomstudio.geometry.frames import Frame
    from vomstudio.geometry.registrations import Registration
    from vomstudio.project import edits
    from vomstudio.project.folder import ProjectFolder
    from vomstudio.project.records import Model

    mesh = tmp_path / "face.xyz"
    mesh.write_text(table.read_text().replace("1,1,nan\n", ""))
    folder = tmp_path / "p.vom"
    with vs.Project.create(folder) as project:
        project.add_model(mesh, unit="m", up="z")
        project.save()
    turn = ((0.0, -2.0, 0.0, 1000.0), (2.0, 0.0, 0.0, 500.0), (0.0, 0.0, 2.0, 0.0), (0, 0, 0, 1.0))
    opened = ProjectFolder.open(folder)
    (model,) = opened.session.of(Model)
    record = Registration("r", "points", "points", Frame("crs", "EPSG:32633"), turn)
    opened.session.apply(edits.set_registration(opened.session.records, record, [model.id]))
    opened.close()
    asked = ("--gsd", 1.0, "--project", folder, "--json")
    ran = run("dem", mesh, "-o", tmp_path / "d.tif", *asked)
    assert ran.code == 0, ran.err
    assert ran.json["crs"] == "EPSG:32633"
    with rasterio.open(tmp_path / "d.tif") as file:
        z = file.read(1)
        for row, column in ((0, 0), (20, 9), (39, 19)):
            east, north = file.xy(row, column)
            x, y = (north - 500) / 2, (1000 - east) / 2
            assert z[row, column] == pytest.approx(2 * (100 + 0.5 * x - 0.25 * y), abs=1e-4)
    ran = run(
        "section",
        mesh,
        "--plane",
        "090/90",
        "--through",
        "990,510,200",
        "-o",
        tmp_path / "s.csv",
        "--slab",
        2,
        "--project",
        folder,
        "--json",
    )
    assert ran.code == 0, ran.err
    assert ran.json["length_m"] == pytest.approx(40 * np.hypot(1, 0.5), rel=0.1)
    for more, said in ((("--crs", "EPSG:32633"), "--crs"), (("--up", "y"), "--up")):
        ran = run("dem", mesh, "-o", tmp_path / "e.tif", *asked, *more)
        assert ran.code == 2
        assert ran.json["error"]["field"] == said
    other = tmp_path / "other.xyz"
    other.write_text("0 0 0\n1 0 0\n0 1 0\n1 1 1\n")
    ran = run("dem", other, "-o", tmp_path / "e.tif", *asked)
    assert ran.code == 2
    assert ran.json["error"]["code"] == "project.other-model"
    assert not (tmp_path / "e.tif").exists()
