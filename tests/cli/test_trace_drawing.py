"""Lines drawn on an orthophoto come back: `vomstudio ortho --draw`, `trace --from-ortho`."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import ezdxf
import numpy as np
import pandas as pd
import pyogrio
import pytest
import rasterio
import shapely

import vomstudio as vs
from tests.messages import codes, error_of, shown_codes
from vomstudio.io.gis.svg_lines import read_svg
from vomstudio.io.gis.svg_paths import parse_transform

SPECIMEN = Path(__file__).resolve().parents[1] / "specimens" / "schema1.vom"
GSD = 0.02
pytestmark = pytest.mark.filterwarnings("ignore:'crs' was not provided")


def height(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Of the surface, over the y of a wall that faces South."""
    return np.asarray(0.4 * np.sin(x) + 0.1 * y)


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A wavy wall at the coordinates of a map, its picture along 10/5, and one straight down."""
    from vomstudio.cli import main

    folder = tmp_path_factory.mktemp("scene")
    g = np.linspace(0, 6, 160)
    x, z = np.meshgrid(g, g)
    points = np.stack([x, height(x, z), z], -1).reshape(-1, 3) + [500_000, 4_100_000, 100]
    i = np.arange(160 * 160).reshape(160, 160)
    a, b, c, d = (k.ravel() for k in (i[:-1, :-1], i[:-1, 1:], i[1:, :-1], i[1:, 1:]))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([b, d, c], 1)]) + 1
    lines = [f"v {p[0]:.6f} {p[1]:.6f} {p[2]:.6f}" for p in points]
    lines += [f"f {f[0]} {f[1]} {f[2]}" for f in faces]
    (folder / "wall.obj").write_text("\n".join(lines) + "\n")
    (folder / "wall.prj").write_text("EPSG:32633\n")
    for name, trend, plunge in (("o", 10, 5), ("other", 340, 5), ("map", 0, 90)):
        words = [
            "ortho",
            folder / "wall.obj",
            "--trend",
            trend,
            "--plunge",
            plunge,
            "--gsd",
            GSD,
            "-o",
            folder / f"{name}.tif",
            "--json",
        ]
        assert main([str(word) for word in words]) == 0
    return folder


def truth(count: int = 9) -> np.ndarray:
    """Points on the wall, (2, count, 3): two lines."""
    t = np.linspace(0.1, 0.9, count)
    x, z = np.stack([6 * t, 5 * t**2 + 0.5]), np.stack([1 + 3 * t, 5.5 - 4 * t])
    return np.stack([x, height(x, z), z], -1) + [500_000, 4_100_000, 100]


def drawn(folder: Path, name: str = "o") -> tuple[np.ndarray, np.ndarray]:
    """The true points in pixels, and in the GeoTIFF's coordinates; a geologist's clicks."""
    facts = json.loads((folder / f"{name}.json").read_text("utf-8"))
    points = truth()
    pixels = np.linalg.solve(
        np.array(facts["pixel_to_world"]),
        np.concatenate([points.reshape(-1, 3).T, np.ones((1, points.size // 3))]),
    ).T[:, :2]
    with rasterio.open(folder / f"{name}.tif") as file:
        t = file.transform
    xy = pixels @ [[t.a, t.d], [t.b, t.e]] + [t.c, t.f]
    return pixels.reshape(2, -1, 2), xy.reshape(2, -1, 2)


def check(run, scene: Path, drawing: Path, names=("1", "2"), picture: str = "o") -> None:  # type: ignore[no-untyped-def]
    """Every vertex is back within a pixel."""
    table = drawing.with_suffix(".csv")
    ran = run(
        "trace",
        scene / "wall.obj",
        "--from-ortho",
        drawing,
        "--sidecar",
        scene / f"{picture}.json",
        "-o",
        table,
        "--json",
    )
    assert ran.code == 0, ran.err
    assert list(ran.json)[:4] == ["lines", "points", "off_surface", "table"]
    assert (ran.json["lines"], ran.json["points"], ran.json["off_surface"]) == (2, 18, 0)
    rows = pd.read_csv(table, comment="#", dtype={"line": str})
    assert list(rows) == ["line", "x", "y", "z"]
    assert list(dict.fromkeys(rows["line"])) == list(names)
    away = rows[["x", "y", "z"]].to_numpy() - truth().reshape(-1, 3)
    assert np.linalg.norm(away, axis=1).max() < GSD


@pytest.mark.parametrize("ending", ["gpkg", "geojson", "shp", "dxf"])
@pytest.mark.parametrize("picture", ["o", "map"])
def test_lines_written_by_ogr_are_read_back(run, scene, tmp_path, ending, picture) -> None:  # type: ignore[no-untyped-def]
    if picture == "map" and ending == "geojson":
        pytest.skip("a GeoJSON on the map has degrees")
    _, xy = drawn(scene, picture)
    with rasterio.open(scene / f"{picture}.tif") as file:
        crs = None if ending in ("dxf", "geojson") else file.crs.to_wkt()
    path = tmp_path / f"d.{ending}"
    fields = {} if ending == "dxf" else {"name": np.array(["bed", "fault"], object)}
    pyogrio.raw.write(
        path,
        shapely.to_wkb(shapely.linestrings(xy)),
        list(fields.values()),
        np.array(list(fields), object),
        geometry_type="LineString",
        crs=crs,
    )
    if picture == "map":
        # From above a wall shows its upper edge; it is the geometry of the file that counts here.
        table = tmp_path / "d.csv"
        ran = run(
            "trace",
            scene / "wall.obj",
            "--from-ortho",
            path,
            "--sidecar",
            scene / "map.json",
            "-o",
            table,
            "--json",
        )
        assert ran.code == 0, ran.err
        rows = pd.read_csv(table, comment="#")
        if not ran.json["off_surface"]:
            assert np.abs(rows[["x", "y"]].to_numpy() - xy.reshape(-1, 2)).max() < GSD
    else:
        check(run, scene, path, ("bed", "fault") if fields else ("1", "2"))


def test_ezdxf_drawing_is_read_back(run, scene: Path, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    _, xy = drawn(scene)
    document = ezdxf.new("R2010")
    document.modelspace().add_lwpolyline(xy[0])
    document.modelspace().add_polyline2d(xy[1])
    document.saveas(tmp_path / "d.dxf")
    check(run, scene, tmp_path / "d.dxf")


INKSCAPE = """<?xml version="1.0" encoding="UTF-8"?>
<svg width="297mm" height="210mm" viewBox="0 0 297 210" xmlns="http://www.w3.org/2000/svg"
  xmlns:xlink="http://www.w3.org/1999/xlink"
  xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape">
 <defs><path id="never" d="M 0 0 L 9 9"/></defs>
 <g inkscape:groupmode="layer" inkscape:label="photo" transform="translate(12.5,-3)">
  <image xlink:href="o.png" x="20" y="30" width="{w}" height="{h}" preserveAspectRatio="none"
   transform="rotate(8 50 60)"/>
 </g>
 <g inkscape:groupmode="layer" inkscape:label="lines" transform="scale(2)">
  <path inkscape:label="bed" style="fill:none" d="{path}"/>
  <g transform="matrix(0 1 -1 0 30 -40)"><polyline id="fault" points="{points}"/></g>
 </g>
 <path style="display:none" d="M 1 1 L 2 2"/>
</svg>
"""


def test_inkscape_drawing_is_read_back_through_transforms(run, scene, tmp_path) -> None:  # type: ignore[no-untyped-def]
    pixels, _ = drawn(scene)
    with rasterio.open(scene / "o.tif") as file:
        w, h = 0.2 * file.width, 0.2 * file.height
    page = 0.2 * pixels + [20, 30]
    turn = np.radians(8)
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    page = (page - [50, 60]) @ rotation.T + [50, 60] + [12.5, -3]
    first = page[0] / 2
    path = f"m {first[0, 0]},{first[0, 1]} " + " ".join(
        f"{dx},{dy}" for dx, dy in np.diff(first, axis=0)
    )
    second = page[1] / 2 - [30, -40]
    points = " ".join(f"{y},{-x}" for x, y in second)
    drawing = tmp_path / "d.svg"
    drawing.write_text(INKSCAPE.format(w=w, h=h, path=path, points=points))
    check(run, scene, drawing, ("bed", "fault"))


def test_svg_page_in_image_pixels_is_read_back(run, scene: Path, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    pixels, _ = drawn(scene)
    with rasterio.open(scene / "o.tif") as file:
        size = f'viewBox="0 0 {file.width} {file.height}"'
    lines = ['<polyline points="{}"/>'.format(" ".join(f"{x},{y}" for x, y in p)) for p in pixels]
    drawing = tmp_path / "d.svg"
    drawing.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" {size}>{"".join(lines)}</svg>')
    check(run, scene, drawing)
    drawing.write_text(drawing.read_text().replace('viewBox="0 0', 'viewBox="0 0 3'))
    ran = run(
        "trace",
        scene / "wall.obj",
        "--from-ortho",
        drawing,
        "--sidecar",
        scene / "o.json",
        "-o",
        tmp_path / "x.csv",
    )
    assert ran.code == 2
    assert "drawing.other-picture" in shown_codes(ran.err)


def test_svg_path_curves_match_the_standard(tmp_path: Path) -> None:
    """A circle of arcs; a parabola; cubic curves against their formula."""
    path = tmp_path / "c.svg"
    path.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9">'
        '<path d="M1 0A1 1 0 01-1 0 1 1 0 0 1 1 0z"/>'
        '<path d="M0 0Q1 2 2 0T4 0"/><path d="M0,0C1,2,3,2,4,0S7-2 8 0"/>'
        '<path d="m1 1h2v2H1zm5 5l1-1"/></svg>'
    )
    lines = read_svg(path).lines
    assert [line.closed for line in lines] == [True, False, False, True, False]
    circle, parabola, cubic, square, last = (line.points for line in lines)
    assert np.hypot(*circle.T) == pytest.approx(1, abs=1e-9)
    assert circle[:, 1].min() == pytest.approx(-1)
    assert circle[:, 1].max() == pytest.approx(1)
    x, y = parabola.T
    assert np.where(x <= 2, x * (2 - x), -(x - 2) * (4 - x)) == pytest.approx(y, abs=1e-9)
    t = np.linspace(0, 1, 17)[:, None]
    p = np.array([[0, 0], [1, 2], [3, 2], [4, 0]])
    bernstein = [(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3]
    assert cubic[:17] == pytest.approx(sum(b * q for b, q in zip(bernstein, p, strict=True)))
    assert cubic[16 + 8] == pytest.approx([6.0, -1.5])
    assert square.tolist() == [[1, 1], [3, 1], [3, 3], [1, 3], [1, 1]]
    assert last.tolist() == [[6, 6], [7, 5]]
    assert parse_transform("translate(3) rotate(90 1 1) skewX(45)") @ [2, 1, 1] == pytest.approx(
        [4, 3, 1]
    )


@pytest.mark.full
def test_a_drawing_of_another_picture_is_refused(run, scene: Path, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    _, xy = drawn(scene, "other")
    with rasterio.open(scene / "other.tif") as file:
        crs = file.crs.to_wkt()
    path = tmp_path / "d.gpkg"
    shapes = shapely.to_wkb(shapely.linestrings(xy))
    pyogrio.raw.write(path, shapes, [], [], geometry_type="LineString", crs=crs)
    for sidecar in ("o", "map"):
        ran = run(
            "trace",
            scene / "wall.obj",
            "--from-ortho",
            path,
            "--sidecar",
            scene / f"{sidecar}.json",
            "-o",
            tmp_path / "x.csv",
        )
        assert ran.code == 2
        assert "drawing.other-picture" in shown_codes(ran.err)
    check(run, scene, path, picture="other")
    plain = tmp_path / "plain.dxf"
    pyogrio.raw.write(
        plain, shapely.to_wkb(shapely.linestrings(xy + 1000)), [], [], geometry_type="LineString"
    )
    ran = run(
        "trace",
        scene / "wall.obj",
        "--from-ortho",
        plain,
        "--sidecar",
        scene / "other.json",
        "-o",
        tmp_path / "x.csv",
    )
    assert "drawing.other-picture" in shown_codes(ran.err)
    for drawing, sidecar, said in (
        (path, scene / "wall.obj", "not the sidecar"),
        (scene / "wall.obj", scene / "o.json", "cannot be read as a drawing"),
        (path, scene / "none.json", "cannot be read"),
    ):
        ran = run(
            "trace",
            scene / "wall.obj",
            "--from-ortho",
            drawing,
            "--sidecar",
            sidecar,
            "-o",
            tmp_path / "x.csv",
        )
        assert ran.code == 2
        assert said in ran.err
    assert not (tmp_path / "x.csv").exists()


@pytest.mark.full
def test_points_off_surface_are_counted_and_step_densifies_line(run, scene, tmp_path) -> None:  # type: ignore[no-untyped-def]
    _, xy = drawn(scene)
    facts = json.loads((scene / "o.json").read_text("utf-8"))
    a, _, c, _, e, f = facts["geotransform"]
    # The upper left corner of the picture shows nothing.
    beside = np.array([[c, f], [c + a, f + e], *xy[0]])
    path = tmp_path / "d.gpkg"
    both = [shapely.linestrings(beside), shapely.linestrings(xy[1])]
    pyogrio.raw.write(path, shapely.to_wkb(both), [], [], geometry_type="LineString")
    words = ("trace", scene / "wall.obj", "--from-ortho", path, "--sidecar", scene / "o.json")
    ran = run(*words, "-o", tmp_path / "a.csv", "--json")
    assert ran.json["points"] == 18
    assert ran.json["off_surface"] == 2
    ran = run(*words, "-o", tmp_path / "b.csv", "--step", 0.05, "--json")
    rows = pd.read_csv(tmp_path / "b.csv", comment="#")
    line = rows[rows["line"] == 2][["x", "y", "z"]].to_numpy() - [500_000, 4_100_000, 100]
    assert len(line) > 80
    assert np.abs(line[:, 1] - height(line[:, 0], line[:, 2])).max() < 2e-3


@pytest.mark.filterwarnings("ignore::vomstudio.core.errors.VomWarning")
def test_interpretation_is_drawn_on_orthophoto_and_read_back(run, tmp_path) -> None:  # type: ignore[no-untyped-def]
    project = tmp_path / "p.vom"
    shutil.copytree(SPECIMEN, project)
    model = project / "models" / "face" / "face.obj"
    words = ("ortho", model, "--trend", 31, "--plunge", 11, "--gsd", 0.05, "-o", tmp_path / "o.tif")
    found = run(*words, "--draw", project, "--json").json
    assert set(found["drawing"]) == {"gpkg", "svg", "dxf"}
    gpkg = found["drawing"]["gpkg"]
    layers = [name for name, _ in pyogrio.list_layers(gpkg)]
    assert {"planes", "traces"} <= set(layers)
    with rasterio.open(found["image"]) as file:
        assert (
            pyogrio.read_info(gpkg, layer="traces")["crs"] == file.crs.to_wkt()
            or "view plane" in (pyogrio.read_info(gpkg, layer="traces")["crs"])
        )
    matrix = np.linalg.inv(np.array(found["pixel_to_world"]))
    with vs.Project.open(project) as opened:
        traces = opened.traces().set_index("id")["geometry"]
        planes = opened.planes().set_index("id")
    facts = json.loads(Path(found["sidecar"]).read_text("utf-8"))
    a, _, c, _, e, f = facts["geotransform"]
    meta, _, shapes, fields = pyogrio.raw.read(gpkg, layer="traces")
    ids = fields[list(meta["fields"]).index("id")]
    for name, shape in zip(ids, shapely.from_wkb(shapes), strict=True):
        world = shapely.get_coordinates(traces[name], include_z=True)
        pixels = (matrix @ np.column_stack([world, np.ones(len(world))]).T).T[:, :2]
        assert shapely.get_coordinates(shape) == pytest.approx(pixels * [a, e] + [c, f], abs=1e-6)
    # Apparent dips: the line in which the plane meets the plane of the picture.
    meta, _, _, fields = pyogrio.raw.read(gpkg, layer="planes")
    column = dict(zip(meta["fields"], fields, strict=True))
    view, right = np.array(found["direction"]), np.array(found["right"])
    for name, dip in zip(column["id"], column["apparent_dip_deg"], strict=True):
        row = planes.loc[name]
        d, s = np.radians([row["dip_direction_deg"], row["dip_deg"]])
        normal = [np.sin(d) * np.sin(s), np.cos(d) * np.sin(s), np.cos(s)]
        line = np.cross(normal, view)
        cosine = abs(line @ right) / np.linalg.norm(line)
        assert abs(dip) == pytest.approx(np.degrees(np.arccos(cosine)), abs=1e-4)
    back = ("trace", model, "--sidecar", found["sidecar"])
    refused = run(
        *back,
        "--from-ortho",
        found["drawing"]["svg"],
        "-o",
        tmp_path / "u.csv",
        "--type",
        "bedding",
    )
    assert refused.code == 2
    assert run(*back, "--from-ortho", found["drawing"]["svg"], "-o", tmp_path / "u.csv").code == 0
    assert run(*back, "--from-ortho", found["drawing"]["dxf"], "-o", tmp_path / "v.csv").code == 0


@pytest.mark.full
@pytest.mark.filterwarnings("ignore::vomstudio.core.errors.VomWarning")
def test_show_option_selects_parts_of_interpretation(run, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    model = SPECIMEN / "models" / "face" / "face.obj"
    words = ("ortho", model, "--trend", 31, "--plunge", 11, "--gsd", 0.1)

    def layers(name: str, *more: object) -> dict[str, str]:
        found = run(*words, "-o", tmp_path / name, "--draw", SPECIMEN, "--json", *more)
        assert found.code == 0, found.err
        gpkg = found.json["drawing"]["gpkg"]
        return {str(layer): str(kind) for layer, kind in pyogrio.list_layers(gpkg)}

    whole = layers("all.tif")
    points = layers("points.tif", "--show", "symbols")
    lines = layers("lines.tif", "--show", "Traces, legend", "--sheet", tmp_path / "lines.pdf")
    assert set(points.values()) == {"Point"}
    assert set(lines.values()) == {"LineString"}
    assert set(whole) == {*points, *lines, *layers("patches.tif", "--show", "patches")}
    # A picture beside everything has no drawing, and says so.
    far = run(
        *words,
        "-o",
        tmp_path / "far.tif",
        "--draw",
        SPECIMEN,
        "--json",
        "--sheet",
        tmp_path / "far.png",
        "--around",
        "364534,4721857,859,0.3,0.3",
    )
    assert far.code == 0, far.err
    assert far.json["drawing"] is None
    assert "interpretation.not-in-view" in codes(far.json)
    assert not list(tmp_path.glob("far_drawing*"))
    alone = run(*words, "-o", tmp_path / "none.tif", "--show", "traces", "--json")
    assert alone.code == 2
    error = alone.json["error"]
    assert (error["code"], error["option"], error["other"], error["field"]) == (
        "option.requires",
        "--show",
        "--draw",
        "--show",
    )
    assert not (tmp_path / "none.tif").exists()
    parts = ["traces", "patches", "symbols", "legend"]
    for show, code, values in (
        ("faults", "option.not-a-choice", {"value": "faults", "choices": parts}),
        ("", "option.not-a-choice", {"value": "", "choices": parts}),
        ("legend", "interpretation.legend-alone", {}),
    ):
        more = ("--draw", SPECIMEN, "--show", show)
        ran = run(*words, "-o", tmp_path / "none.tif", *more, "--json")
        assert ran.code == 2
        error_of(ran.json, code, field="--show", **values)
        assert not (tmp_path / "none.tif").exists()
