"""Drawings as Inkscape, Illustrator, Affinity and CAD programs save them come back through
`vomstudio trace --from-ortho`: hidden parts, clones, several pictures, units, sheets."""

from __future__ import annotations

import gzip
from collections.abc import Callable
from pathlib import Path
from typing import Any

import ezdxf
import numpy as np
import pandas as pd
import pyogrio
import pytest
import rasterio
import shapely

from tests.cli.test_trace_drawing import check, drawn, scene, truth
from tests.messages import by_code, shown_codes, shown_values
from vomstudio.io.gis.line_reading import read_gis_lines
from vomstudio.io.gis.svg_lines import read_svg

__all__ = ["scene"]
pytestmark = pytest.mark.filterwarnings("ignore:'crs' was not provided")
HEAD = (
    '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '
    'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" {size}>'
)
NOWHERE = shapely.from_wkb(
    bytes.fromhex(
        "0102000000020000000000000000000000000000000000f07f000000000000f03f000000000000f03f"
    )
)
"""A line to infinity."""
A4 = 'width="297mm" height="210mm" viewBox="0 0 297 210"'


class Page:
    """The two true lines on a page: in pixels, or over a picture that is placed on it."""

    def __init__(self, folder: Path) -> None:
        self.pixels, self.plane = drawn(folder)
        with rasterio.open(folder / "o.tif") as file:
            self.w, self.h = file.width, file.height

    @property
    def size(self) -> str:
        return f'viewBox="0 0 {self.w} {self.h}"'

    def lines(self, scale: float = 1.0, shift: tuple[float, float] = (0.0, 0.0)) -> str:
        return "".join(self.line(k, scale, shift) for k in (0, 1))

    def line(self, k: int, scale: float = 1.0, shift: tuple[float, float] = (0.0, 0.0)) -> str:
        at = self.pixels[k] * scale + shift
        return '<path d="M ' + " L ".join(f"{x!r},{y!r}" for x, y in at.tolist()) + '"/>'

    def image(self, name: str, x: float, y: float, more: str = "", scale: float = 0.25) -> str:
        size = f'x="{x}" y="{y}" width="{self.w * scale}" height="{self.h * scale}"'
        return f'<image xlink:href="{name}" {size} {more}/>'


SVGS: dict[str, Callable[[Page], tuple[str, str]]] = {
    "hidden by visibility": lambda p: (
        p.size,
        p.lines() + '<g visibility="hidden"><path d="M 5 5 L 50 50"/></g>',
    ),
    "hidden by a style sheet": lambda p: (
        p.size,
        "<style>.st0{fill:none}.st1{display:none;}</style>"
        + p.lines()
        + '<path class="st0 st1" d="M 5 5 L 50 50"/>',
    ),
    "a clone": lambda p: (
        p.size,
        f"<defs><g id='k'>{p.line(0, 1, (-50, -20))}</g></defs>"
        f"<use xlink:href='#k' x='50' transform='translate(0,20)'/>{p.line(1)}",
    ),
    "a symbol": lambda p: (
        p.size,
        f'<symbol id="s">{p.line(0)}</symbol><use href="#s"/>{p.line(1)}',
    ),
    "layers called planes and frame": lambda p: (
        p.size,
        f'<g inkscape:groupmode="layer" id="layer1" inkscape:label="planes">{p.line(0)}</g>'
        f'<g inkscape:groupmode="layer" id="frame" inkscape:label="frame">{p.line(1)}</g>',
    ),
    "the picture's layer is hidden": lambda p: (
        A4,
        f'<g style="display:none">{p.image("o.png", 30, 10)}</g>{p.lines(0.25, (30, 10))}',
    ),
    "hidden picture on a page of its shape": lambda p: (
        f'viewBox="0 0 {p.w / 2} {p.h / 2}"',
        f'<g style="display:none">{p.image("o.png", 30, 10)}</g>{p.lines(0.25, (30, 10))}',
    ),
    "a picture among others of its shape": lambda p: (
        A4,
        p.image("other.png", 0, 0)
        + p.image("file:///C:/outcrop/o.jpg", 30, 10)
        + p.lines(0.25, (30, 10)),
    ),
    "a picture that keeps its shape in a wider place": lambda p: (
        'viewBox="0 0 2000 1000"',
        f'<image xlink:href="o.png" width="{2 * p.w}" height="{p.h}"/>' + p.lines(1, (p.w / 2, 0)),
    ),
    "a picture of the whole page": lambda p: (
        p.size,
        '<image xlink:href="o.png" width="100%" height="100%"/>' + p.lines(),
    ),
    "a picture that is used from the definitions": lambda p: (
        A4,
        f'<use xlink:href="#_Image1" transform="matrix(0.25,0,0,0.25,30,10)"/>'
        f'<defs><image id="_Image1" width="{p.w}px" height="{p.h}px" '
        f'xlink:href="data:image/png;base64,AAAA"/></defs>{p.lines(0.25, (30, 10))}',
    ),
    "a drawing in the drawing": lambda p: (
        A4,
        p.image("o.png", 30, 10) + f'<svg x="30" y="10" width="{p.w / 4}" height="{p.h / 4}" '
        f'viewBox="0 0 {p.w} {p.h}">{p.lines()}</svg>',
    ),
    "moved by its style": lambda p: (
        p.size,
        f'<g style="transform:translate(50px, 20px)">{p.lines(1, (-50, -20))}</g>',
    ),
    "turned over with its picture": lambda p: (
        p.size,
        f'<g transform="translate({p.w},0) scale(-1,1)">'
        f'<image xlink:href="o.png" width="{p.w}" height="{p.h}"/>{p.lines()}</g>',
    ),
}


@pytest.mark.parametrize("name", SVGS)
def test_lines_of_svg_drawing_are_read_back(run, scene: Path, tmp_path: Path, name: str) -> None:  # type: ignore[no-untyped-def]
    size, body = SVGS[name](Page(scene))
    drawing = tmp_path / "d.svg"
    drawing.write_text(HEAD.format(size=size) + body + "</svg>")
    check(run, scene, drawing)


def test_compressed_and_illustrator_svg_files_are_read(run, scene, tmp_path) -> None:  # type: ignore[no-untyped-def]
    page = Page(scene)
    text = HEAD.format(size=page.size) + page.lines() + "</svg>"
    packed = tmp_path / "d.svgz"
    packed.write_bytes(gzip.compress(text.encode()))
    check(run, scene, packed)
    declared = tmp_path / "ai.svg"
    declared.write_text(
        '<?xml version="1.0" encoding="utf-8"?>\n<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" '
        '"http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd" [\n'
        '  <!ENTITY ns_ai "http://ns.adobe.com/AdobeIllustrator/10.0/">\n]>\n'
        + text.replace("<svg ", '<svg xmlns:i="&ns_ai;" ', 1)
    )
    check(run, scene, declared)
    for broken in (b"\x1f\x8b broken", gzip.compress(text.encode())[:90]):
        packed.write_bytes(broken)
        ran = run(
            "trace",
            scene / "wall.obj",
            "--from-ortho",
            packed,
            "--sidecar",
            scene / "o.json",
            "-o",
            tmp_path / "x.csv",
        )
        assert ran.code == 2
        assert "file.damaged" in shown_codes(ran.err)


def test_drawing_with_ambiguous_images_is_refused(run, scene, tmp_path) -> None:  # type: ignore[no-untyped-def]
    page = Page(scene)
    drawing = tmp_path / "d.svg"
    body = page.image("data:image/png;base64,AAAA", 0, 0) + page.image("b.png", 30, 10)
    drawing.write_text(HEAD.format(size=A4) + body + page.lines(0.25, (30, 10)) + "</svg>")
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
    assert "2 pictures" in ran.err
    assert "o.tif" in ran.err


def test_svg_shapes_match_the_standard(tmp_path: Path) -> None:
    """Circles, ellipses and rounded rectangles, and clones that go round in a circle."""
    path = tmp_path / "c.svg"
    path.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 90 40">'
        '<circle cx="5" cy="4" r="10%"/><ellipse cx="1" cy="2" rx="3" ry="2"/>'
        '<rect x="10" y="20" width="30" height="10" rx="4"/><circle r="0"/>'
        '<g id="a"><use href="#b"/></g><g id="b"><use href="#a"/></g></svg>'
    )
    circle, ellipse, rounded = (line.points for line in read_svg(path).lines)
    # A hundredth of a length that is neither across nor down: of the diagonal over the root of 2.
    radius = 0.1 * np.hypot(90, 40) / np.sqrt(2)
    assert np.hypot(*(circle - [5, 4]).T) == pytest.approx(radius)
    assert ((ellipse - [1, 2]) ** 2 / [9, 4]).sum(axis=1) == pytest.approx(1)
    ring = shapely.Polygon(rounded)
    assert ring.area == pytest.approx(30 * 10 - (4 - np.pi) * 16, rel=2e-3)
    assert ring.bounds == (10, 20, 40, 30)


def saved(document: Any, tmp_path: Path, **how: Any) -> Path:
    path = tmp_path / "d.dxf"
    document.saveas(path, **how)
    return path


@pytest.mark.parametrize(
    ("unit", "factor"),
    [(4, 1.0), (1, 1.0), (0, 1.0), (4, 1000.0), (5, 100.0), (2, 1 / 0.3048), (6, 1.0)],
)
def test_drawing_in_declared_unit_or_metres_is_recognised(
    run, scene, tmp_path, unit, factor
) -> None:  # type: ignore[no-untyped-def]
    """Templates say millimetres or inches of drawings that are in metres."""
    document = ezdxf.new("R2010")
    document.header["$INSUNITS"] = unit
    for line in Page(scene).plane:
        document.modelspace().add_lwpolyline(line * factor)
    check(run, scene, saved(document, tmp_path))


@pytest.mark.parametrize("how", [{}, {"fmt": "bin"}], ids=["text", "binary"])
def test_other_cad_entities_and_hidden_layers_are_ignored(run, scene, tmp_path, how) -> None:  # type: ignore[no-untyped-def]
    document = ezdxf.new("R2010", setup=True)
    space = document.modelspace()
    for line in Page(scene).plane:
        space.add_lwpolyline(line)
    document.layers.add("Höhe").off()
    document.layers.add("frozen").freeze()
    for layer in ("Höhe", "frozen"):
        space.add_line((0, 0), (1, 1), dxfattribs={"layer": layer})
    space.add_line((0, 0), (1, 1), dxfattribs={"invisible": 1})
    space.add_linear_dim(base=(0, 1), p1=(0, 0), p2=(1, 0)).render()
    space.add_leader([(0, 0), (1, 0.5)])
    document.layout("Layout1").add_line((0, 0), (1, 1))
    check(run, scene, saved(document, tmp_path, **how))


def test_scaled_and_rotated_block_and_mirrored_line_are_read_back(run, scene, tmp_path) -> None:  # type: ignore[no-untyped-def]
    plane = Page(scene).plane
    document = ezdxf.new("R2010")
    turn = np.radians(30)
    rotation = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    block = document.blocks.new("B")
    block.add_lwpolyline((plane[0] - plane[0][0]) @ rotation.T / 2)
    document.modelspace().add_blockref(
        "B", plane[0][0], dxfattribs={"xscale": 2, "yscale": 2, "rotation": 30}
    )
    mirrored = document.modelspace().add_lwpolyline(plane[1] * [-1, 1])
    mirrored.dxf.extrusion = (0, 0, -1)
    check(run, scene, saved(document, tmp_path))


@pytest.mark.parametrize("closed", [False, True])
def test_splines_through_points_of_circle_follow_it(tmp_path, closed) -> None:  # type: ignore[no-untyped-def]
    """Half of one with its tangents at the ends, and a whole one that is closed."""
    angles = np.radians(np.arange(0.0, 360.0, 20.0) if closed else np.arange(0.0, 181.0, 20.0))
    circle = 5.0 * np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1) + [7.0, 9.0, 0.0]
    document = ezdxf.new("R2010")
    spline = document.modelspace().add_spline(fit_points=circle, dxfattribs={"layer": "beds"})
    spline.dxf.flags = 8 | int(closed)
    if not closed:
        spline.dxf.start_tangent = (0, 1, 0)
        spline.dxf.end_tangent = (0, -1, 0)
    document.modelspace().add_line((0, 0), (1, 1))
    read = read_gis_lines(saved(document, tmp_path))
    assert len(read.lines) == 2
    (line,) = (each for each in read.lines if each.layer == "beds")
    off = np.linalg.norm(line.points[:, :2] - [7.0, 9.0], axis=1) - 5.0
    # A cubic through points at chords h apart strays by about h^4 / (384 r^3).
    assert np.abs(off).max() < 0.002
    to_fit = [shapely.LineString(line.points).distance(shapely.Point(p)) for p in circle]
    assert max(to_fit) < 0.02
    if closed:
        assert np.allclose(line.points[0], line.points[-1])


def test_fit_point_splines_are_read_back_from_orthophoto(run, scene, tmp_path) -> None:  # type: ignore[no-untyped-def]
    """A straight one through the true ends lies where the line does, and one without length is
    left out with a sentence."""
    _, plane = drawn(scene)
    document = ezdxf.new("R2010")
    for line in plane:
        document.modelspace().add_spline(fit_points=[(*xy, 0.0) for xy in line])
    document.modelspace().add_spline(fit_points=[(*plane[0][0], 0.0)] * 2)
    table = tmp_path / "x.csv"
    ran = run(
        "trace",
        scene / "wall.obj",
        "--from-ortho",
        saved(document, tmp_path),
        "--sidecar",
        scene / "o.json",
        "-o",
        table,
        "--json",
    )
    assert ran.code == 0, ran.err
    assert ran.json["lines"] == 2
    (finding,) = [w for w in ran.json["warnings"] if w["code"] == "drawing.invalid-shapes"]
    assert finding["count"] == 1
    rows = pd.read_csv(table, comment="#")
    for k, line in enumerate(truth()):
        ours = rows[rows["line"] == rows["line"].unique()[k]][["x", "y", "z"]].to_numpy()
        apart = np.linalg.norm(ours[[0, -1]] - line[[0, -1]], axis=1)
        assert apart.max() < 0.05


def test_binary_spline_without_control_points_is_reported(run, scene, tmp_path) -> None:  # type: ignore[no-untyped-def]
    document = ezdxf.new("R2010")
    document.modelspace().add_spline(fit_points=[(0, 0, 0), (1, 1, 0), (2, 0, 0)])
    drawing = saved(document, tmp_path, fmt="bin")
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
    assert shown_values(ran.err, "drawing.splines") == {"count": "1"}


def layers(path: Path, *given: tuple[str, list[Any], str | None]) -> Path:
    for k, (name, lines, crs) in enumerate(given):
        pyogrio.raw.write(
            path,
            shapely.to_wkb(np.array(lines, object)),
            [],
            [],
            layer=name,
            driver="GPKG",
            geometry_type="LineString",
            crs=crs,
            append=k > 0,
        )
    return path


@pytest.mark.full
@pytest.mark.parametrize("order", [1, -1])
def test_each_layer_is_read_in_its_own_crs(run, scene, tmp_path, order) -> None:  # type: ignore[no-untyped-def]
    from pyproj import Transformer

    lines = [shapely.LineString(line[:, :2]) for line in truth()]
    away = Transformer.from_crs(32633, 4326, always_xy=True)
    degrees = shapely.transform(lines[1], lambda xy: np.stack(away.transform(*xy.T), 1))
    given = [("utm", [lines[0]], "EPSG:32633"), ("gps", [degrees], "EPSG:4326")][::order]
    path = layers(tmp_path / "d.gpkg", *given)
    ran = run(
        "trace",
        scene / "wall.obj",
        "--from-ortho",
        path,
        "--sidecar",
        scene / "map.json",
        "-o",
        tmp_path / "d.csv",
        "--json",
    )
    assert ran.code == 0, ran.err
    assert (ran.json["lines"], ran.json["off_surface"]) == (2, 0)
    rows = pd.read_csv(tmp_path / "d.csv", comment="#")[["x", "y"]].to_numpy()
    expected = truth()[::order, :, :2].reshape(-1, 2)
    assert rows == pytest.approx(expected, abs=1e-3)


@pytest.mark.full
def test_layers_of_other_images_and_invalid_lines_are_left_out(run, scene, tmp_path) -> None:  # type: ignore[no-untyped-def]
    plane = [shapely.LineString(line) for line in Page(scene).plane]
    _, elsewhere = drawn(scene, "other")
    systems = {}
    for name in ("o", "other"):
        with rasterio.open(scene / f"{name}.tif") as file:
            systems[name] = file.crs.to_wkt()
    bad = [
        shapely.LineString([(0, 0), (0, 0)]),
        NOWHERE,
        shapely.LineString(),
    ]
    path = layers(
        tmp_path / "d.gpkg",
        ("beds", [*plane, *bad], systems["o"]),
        ("beds of the other picture", [shapely.LineString(elsewhere[0])], systems["other"]),
        ("roads", [shapely.LineString(truth()[0][:, :2])], "EPSG:32633"),
    )
    check(run, scene, path)
    ran = run(
        "trace",
        scene / "wall.obj",
        "--from-ortho",
        path,
        "--sidecar",
        scene / "o.json",
        "-o",
        tmp_path / "e.csv",
        "--json",
    )
    others = ("beds of the other picture", "roads")
    assert by_code(ran.json["warnings"])["drawing.layers-left-out"]["names"] == others
    counts = {w["code"]: w.get("count") for w in ran.json["warnings"]}
    assert counts["drawing.invalid-shapes"] == 2
    assert counts["drawing.other-shapes"] == 1


@pytest.mark.full
@pytest.mark.parametrize("plunge", [90, -90])
@pytest.mark.filterwarnings("ignore::vomstudio.core.errors.VomWarning")
def test_the_interpretation_of_a_roof_lies_on_the_map(run, tmp_path, plunge) -> None:  # type: ignore[no-untyped-def]
    """Seen from above and from below, which turns the picture over: both are on the map."""
    import vomstudio as vs

    side = np.linspace(0, 6, 31)
    x, y = np.meshgrid(side, side)
    origin = np.array([500_000.0, 4_100_000.0, 100.0])
    points = np.stack([x, y, 0.1 * x], -1).reshape(-1, 3) + origin
    i = np.arange(31 * 31).reshape(31, 31)
    a, b, c, d = (k.ravel() for k in (i[:-1, :-1], i[:-1, 1:], i[1:, :-1], i[1:, 1:]))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([b, d, c], 1)]) + 1
    rows = [f"v {p[0]!r} {p[1]!r} {p[2]!r}" for p in points.tolist()]
    rows += [f"f {f[0]} {f[1]} {f[2]}" for f in faces]
    (tmp_path / "roof.obj").write_text("\n".join(rows) + "\n")
    (tmp_path / "roof.prj").write_text("EPSG:32633\n")
    trace = np.array([[1, 1, 0.1], [2, 4.5, 0.2], [5, 3, 0.5], [4, 1, 0.4]]) + origin
    table = pd.DataFrame(trace, columns=["x", "y", "z"]).assign(trace="bed")
    table.to_csv(tmp_path / "t.csv", index=False)
    with vs.Project.create(tmp_path / "p.vom"):
        pass
    run("project", tmp_path / "p.vom", "add-model", tmp_path / "roof.obj")
    run(
        "project",
        tmp_path / "p.vom",
        "add-picks",
        tmp_path / "t.csv",
        "--by",
        "trace",
        "--type",
        "bedding",
    )
    made = run(
        "ortho",
        tmp_path / "roof.obj",
        "--trend",
        0,
        f"--plunge={plunge}",
        "--gsd",
        0.05,
        "-o",
        tmp_path / "o.tif",
        "--draw",
        tmp_path / "p.vom",
        "--json",
    )
    assert made.code == 0, made.err
    for ending, name in (("gpkg", "bed"), ("dxf", "1"), ("svg", "bed")):
        ran = run(
            "trace",
            tmp_path / "roof.obj",
            "--from-ortho",
            made.json["drawing"][ending],
            "--sidecar",
            made.json["sidecar"],
            "-o",
            tmp_path / "back.csv",
            "--force",
        )
        assert ran.code == 0, (ending, ran.err)
        back = pd.read_csv(tmp_path / "back.csv", comment="#", dtype={"line": str})
        assert set(back["line"]) == {name}
        assert back[["x", "y", "z"]].to_numpy() == pytest.approx(trace, abs=1e-4)
    _, _, shapes, _ = pyogrio.raw.read(made.json["drawing"]["gpkg"], layer="traces")
    assert shapely.get_coordinates(shapely.from_wkb(shapes)) == pytest.approx(trace[:, :2])
    # The bar of the symbol runs along the strike of the plane on the map, here to the north.
    told, _, _, fields = pyogrio.raw.read(made.json["drawing"]["gpkg"], layer="planes")
    plane = dict(zip(told["fields"], fields, strict=True))
    _, _, symbols, _ = pyogrio.raw.read(made.json["drawing"]["gpkg"], layer="planes_symbols")
    bar = shapely.get_coordinates(shapely.get_parts(shapely.from_wkb(symbols))[0])
    way = bar[1] - bar[0]
    azimuth = np.degrees(np.arctan2(way[0], way[1]))
    turned = (azimuth - plane["dip_direction_deg"][0]) % 180
    assert turned == pytest.approx(90, abs=1e-6)


@pytest.mark.full
def test_line_on_point_cloud_lies_on_front_surface(run, tmp_path) -> None:  # type: ignore[no-untyped-def]
    """Points strewn at random leave gaps that the picture closes; behind them lies another wall,
    through which no point of the line may fall."""
    generator = np.random.default_rng(4)
    origin = np.array([431_000.0, 5_200_000.0, 800.0])

    def wall(wide: float, y: float, n: int) -> np.ndarray:
        x, z = generator.uniform(0, wide, n), generator.uniform(0, 4, n)
        return np.stack([x, y + 0.3 * x + 0.1 * z, z], 1) + origin

    cloud = np.concatenate([wall(3, 0.0, 30_000), wall(6, 2.0, 60_000)])
    np.savetxt(tmp_path / "c.xyz", cloud, fmt="%.5f")
    made = run(
        "ortho",
        tmp_path / "c.xyz",
        "--trend",
        0,
        "--plunge",
        0,
        "--gsd",
        0.03,
        "-o",
        tmp_path / "o.tif",
        "--json",
    )
    assert made.code == 0, made.err
    t = np.linspace(0.2, 2.6, 300)
    line = np.stack([t, 0.3 * t + 0.1 * (1 + t), 1 + t], 1) + origin
    matrix = np.array(made.json["pixel_to_world"])
    pixels = np.linalg.solve(matrix, np.c_[line, np.ones(300)].T).T[:, :2]
    with rasterio.open(tmp_path / "o.tif") as file:
        m, crs = file.transform, file.crs.to_wkt()
    plane = pixels @ [[m.a, m.d], [m.b, m.e]] + [m.c, m.f]
    path = layers(tmp_path / "d.gpkg", ("beds", [shapely.LineString(plane)], crs))
    ran = run(
        "trace",
        tmp_path / "c.xyz",
        "--from-ortho",
        path,
        "--sidecar",
        tmp_path / "o.json",
        "-o",
        tmp_path / "back.csv",
        "--json",
    )
    assert ran.code == 0, ran.err
    assert (ran.json["points"], ran.json["off_surface"]) == (300, 0)
    back = pd.read_csv(tmp_path / "back.csv", comment="#")[["x", "y", "z"]].to_numpy()
    assert np.linalg.norm(back - line, axis=1).max() < 0.03


@pytest.mark.filterwarnings("ignore::vomstudio.core.errors.VomWarning")
def test_cad_lines_get_name_and_type_from_their_layers(run, scene, tmp_path) -> None:  # type: ignore[no-untyped-def]
    import vomstudio as vs

    plane = Page(scene).plane
    document = ezdxf.new("R2010")
    for layer, line in zip(("FAULT", "Bedding", "Bedding", "0"), [*plane, *plane], strict=True):
        document.modelspace().add_lwpolyline(line, dxfattribs={"layer": layer})
    drawing, table = saved(document, tmp_path), tmp_path / "back.csv"
    back = ("trace", scene / "wall.obj", "--from-ortho", drawing, "--sidecar", scene / "o.json")
    assert run(*back, "-o", table).code == 0
    rows = pd.read_csv(table, comment="#", dtype={"line": str})
    assert list(dict.fromkeys(rows["line"])) == ["FAULT", "Bedding", "Bedding-2", "4"]
    projects = [tmp_path / "a.vom", tmp_path / "b.vom"]
    for project in projects:
        with vs.Project.create(project):
            pass
        assert run("project", project, "add-model", scene / "wall.obj").code == 0
    # One line lies on no layer of that kind.
    ran = run(*back, "-o", table, "--force", "--into", projects[0], "--json")
    assert (ran.code, ran.json["error"]["field"]) == (2, "--type")
    assert run(*back, "-o", table, "--force", "--into", projects[0], "--type", "vein").code == 0
    document.modelspace()[-1].destroy()
    document.saveas(drawing)
    # In the other project all lines are new.
    for project, kinds in zip(projects, (["vein"] * 4, ["bedding"] * 2 + ["fault"]), strict=True):
        ran = run(*back, "-o", table, "--force", "--into", project, "--json")
        assert ran.code == 0, ran.err
        listed = run("export", project, "--to", "csv", "-o", tmp_path / "f.csv", "--force")
        assert listed.code == 0, listed.err
        assert sorted(pd.read_csv(tmp_path / "f.csv", comment="#")["kind"]) == kinds
