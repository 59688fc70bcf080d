"""`vomstudio fractures`: files of every kind, bad ones, scanlines, the figure."""

from __future__ import annotations

import json
import math
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pyogrio
import pytest
import shapely
from pyproj import Transformer

from tests.messages import by_code, codes, messages, shown_codes, shown_values
from tests.tiers import first_in_default_tier

CRS = "EPSG:32633"
AT = np.array([500_000.0, 5_200_000.0])


def save(
    path: Path, shapes: list, crs: str | None = CRS, layer: str | None = None, **columns
) -> Path:
    kind = "Polygon" if shapes[0].geom_type == "Polygon" else "Unknown"
    pyogrio.raw.write(
        path,
        shapely.to_wkb(np.array(shapes, object)),
        [np.array(v) for v in columns.values()],
        list(columns),
        geometry_type=kind if path.suffix == ".shp" else "Unknown",
        crs=crs,
        layer=layer,
        append=layer is not None and path.exists(),
    )
    return path


def line(*points: tuple[float, float]) -> shapely.LineString:
    return shapely.LineString(np.array(points, float) + AT)


def ladder() -> list[shapely.LineString]:
    """Nine rungs a metre apart from 1 to 9, 4 long, on a stile that they cross."""
    return [line((-2, y), (2, y)) for y in range(1, 10)] + [line((0, 0), (0, 10))]


def geojson(path: Path, shapes: list, crs: str | None) -> Path:
    features = [
        {"type": "Feature", "properties": {}, "geometry": shapely.geometry.mapping(s)}
        for s in shapes
    ]
    told = {"crs": {"type": "name", "properties": {"name": crs}}} if crs else {}
    path.write_text(json.dumps({"type": "FeatureCollection", **told, "features": features}))
    return path


@pytest.mark.parametrize("ending", first_in_default_tier(["gpkg", "geojson", "shp"]))
def test_gis_formats_are_read(run, tmp_path: Path, ending: str) -> None:
    area = save(tmp_path / "area.gpkg", [shapely.box(*(AT - [5, 0]), *(AT + [5, 10]))])
    path = tmp_path / f"traces.{ending}"
    if ending == "shp":
        pyogrio.raw.write(
            path,
            shapely.to_wkb(np.array(ladder(), object)),
            [],
            [],
            geometry_type="LineString",
            crs=CRS,
        )
    elif ending == "geojson":
        geojson(path, ladder(), "urn:ogc:def:crs:EPSG::32633")
    else:
        save(path, ladder())
    ran = run("fractures", path, "--area", area, "--json")
    assert ran.code == 0, ran.err
    assert ran.json["traces"] == ran.json["pieces"] == 10
    assert ran.json["area_m2"] == pytest.approx(100.0)
    assert ran.json["P21_1_per_m"] == pytest.approx(46 / 100)
    # Both ends of the stile are on the edge.
    assert ran.json["nodes"] == {"I": 18, "Y": 0, "X": 9, "E": 2, "L": 0, "other": 0}
    assert ran.json["P10_1_per_m"] is None
    assert messages(ran.json) == []


def test_drawing_in_millimetres_is_converted(run, tmp_path: Path) -> None:
    import ezdxf

    drawing = ezdxf.new(units=4)
    for y in (1000, 2000):
        drawing.modelspace().add_line((0, y), (4000, y))
    drawing.modelspace().add_lwpolyline([(1000, 0), (1000, 2500), (1500, 3000)])
    drawing.saveas(tmp_path / "traces.dxf")
    ran = run("fractures", tmp_path / "traces.dxf", "--circle", "1,1.5,10", "--json")
    assert ran.code == 0, ran.err
    assert ran.json["nodes"]["X"] == 2
    total = 8 + 2.5 + math.hypot(0.5, 0.5)
    assert ran.json["P21_1_per_m"] == pytest.approx(total / (math.pi * 100))
    (finding,) = ran.json["warnings"]
    assert (finding["code"], finding["unit"]) == ("frame.unit-converted", "mm")


def test_scanline_gives_frequency_and_spacing(run, tmp_path: Path) -> None:
    traces = save(tmp_path / "t.gpkg", ladder())
    across = save(tmp_path / "s.gpkg", [line((1, 0), (1, 12))])
    found = run("fractures", traces, "--scanline", across, "--json").json
    assert found["P10_1_per_m"] == pytest.approx(9 / 12)
    assert found["area_m2"] is found["P20_1_per_m2"] is found["P21_1_per_m"] is None
    spacing = found["sets"][0]["spacing"]
    assert (spacing["n"], spacing["gaps"], spacing["capped"]) == (9, 8, 0)
    assert spacing["mean_m"] == spacing["true_mean_m"] == pytest.approx(1.0)
    assert spacing["cv"] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.full
def test_terzaghi_weights_are_uncapped_by_default(run, tmp_path: Path) -> None:
    """A line at 30 degrees to the rungs meets them every 2 m; weighed they are one a metre."""
    rungs = [line((-40, y), (40, y)) for y in range(1, 10)]
    traces = save(tmp_path / "t.gpkg", rungs)
    c, s = 20 * math.cos(math.radians(30)), 20 * math.sin(math.radians(30))
    slanting = save(tmp_path / "s.gpkg", [line((0, 0), (c, s))])
    found = run("fractures", traces, "--scanline", slanting, "--json").json
    assert found["P10_1_per_m"] == pytest.approx(9 / 20)
    assert found["scanline"]["P21_1_per_m"] == pytest.approx(0.9)
    assert found["scanline"]["mean_m"] == pytest.approx(2.0)
    assert found["scanline"]["true_mean_m"] == pytest.approx(1.0)
    assert found["terzaghi_cap"] is None
    ran = run("fractures", traces, "--scanline", slanting, "--terzaghi-cap", "1.5")
    capped = shown_values(ran.err, "fractures.weights-capped")
    assert capped == {"count": "9", "maximum": "1.5"}
    assert "cap: 1.5" in ran.out


@pytest.mark.full
def test_sets_are_formed_by_attribute_or_strike(run, tmp_path: Path) -> None:
    names = ["rung"] * 9 + [""]
    traces = save(tmp_path / "t.gpkg", ladder(), set=names, type=["a"] * 5 + ["b"] * 5)
    by_default = run("fractures", traces, "--json").json["sets"]
    assert [(s["name"], s["n"]) for s in by_default] == [("rung", 9), ("unassigned", 1)]
    assert by_default[0]["strike_deg"] == pytest.approx(90.0)
    by_name = run("fractures", traces, "--by", "TYPE", "--json").json["sets"]
    assert [(s["name"], s["n"]) for s in by_name] == [("a", 5), ("b", 5)]
    by_strike = run("fractures", traces, "--strikes", "350-10,80-100", "--json").json["sets"]
    assert [(s["name"], s["n"]) for s in by_strike] == [("080-100", 9), ("350-010", 1)]
    wrong = run("fractures", traces, "--by", "colour")
    assert (wrong.code, "set, type" in wrong.said) == (2, True)


def test_circle_centre_may_be_negative(run, tmp_path: Path) -> None:
    traces = save(tmp_path / "t.gpkg", [shapely.LineString([(-7, -3), (-5, -3)])])
    ran = run("fractures", traces, "--circle", "-6,-3,2", "--json")
    assert ran.code == 0, ran.err
    assert ran.json["P20_1_per_m2"] == pytest.approx(1 / (4 * math.pi))


def test_degrees_are_refused_or_converted(run, tmp_path: Path) -> None:
    here = [shapely.LineString([(12.0, 47.0), (12.001, 47.001)])]
    named = save(tmp_path / "t.gpkg", here, "EPSG:4326")
    refused = run("fractures", named, "--json")
    assert (refused.code, refused.json["error"]["code"]) == (2, "frame.degrees")
    # GeoJSON is in degrees by its standard, so this is not a doubt.
    for crs in (None, "urn:ogc:def:crs:OGC:1.3:CRS84"):
        converted = run("fractures", geojson(tmp_path / "t.geojson", here, crs), "--json")
        if crs is None:
            assert "frame.reprojected" in codes(converted.json)
            assert converted.json["length"]["naive_mean_m"] == pytest.approx(134.7, abs=0.5)
        else:
            assert converted.json["error"]["code"] == "frame.degrees"
    metres = run("fractures", geojson(tmp_path / "m.geojson", ladder(), None), "--json")
    assert metres.json["error"]["code"] == "frame.not-degrees"


@pytest.mark.full
def test_an_area_in_another_reference_system_is_converted(run, tmp_path: Path) -> None:
    traces = save(tmp_path / "t.gpkg", ladder())
    square = shapely.box(*(AT - 5.3), *(AT + 5.3))
    expected = run(
        "fractures", traces, "--area", save(tmp_path / "a.gpkg", [square]), "--json"
    ).json
    transformer = Transformer.from_crs("EPSG:32633", "EPSG:32632", always_xy=True)
    corners = np.array(square.exterior.coords)
    moved = shapely.Polygon(np.column_stack(transformer.transform(*corners.T)))
    area = save(tmp_path / "b.gpkg", [moved], "EPSG:32632")
    found = run("fractures", traces, "--area", area, "--json").json
    assert "frame.reprojected" in codes(found)
    assert found["area_m2"] == pytest.approx(expected["area_m2"], rel=1e-6)
    assert found["P21_1_per_m"] == pytest.approx(expected["P21_1_per_m"], rel=1e-6)


def test_feet_become_metres(run, tmp_path: Path) -> None:
    x, y = 6_561_666.0, 2_000_000.0
    trace = shapely.LineString([(x, y), (x, y + 10)])
    found = run("fractures", save(tmp_path / "t.gpkg", [trace], "EPSG:2225"), "--json").json
    assert found["length"]["naive_mean_m"] == pytest.approx(10 * 1200 / 3937)
    (finding,) = found["warnings"]
    assert (finding["code"], finding["unit"]) == ("frame.unit-converted", "US survey feet")


@pytest.mark.full
def test_unusable_lines_are_left_out_and_reported(run, tmp_path: Path) -> None:
    with np.errstate(invalid="ignore"):
        lost = shapely.LineString([(0, 0), (math.nan, 1), (2, 2)])
    shapes = [
        line((0, 0), (4, 0)),
        line((1, 1), (1, 1)),  # without length
        lost,
        shapely.MultiLineString([line((0, 2), (1, 2)), line((1, 2), (2, 2))]),  # joins
        shapely.MultiLineString([line((0, 3), (1, 3)), line((3, 3), (4, 3))]),
        line((4, 0), (0, 0)),  # the first again
        shapely.Point(AT),
    ]
    ran = run("fractures", save(tmp_path / "t.gpkg", shapes), "--json")
    assert ran.code == 0, ran.err
    assert ran.json["traces"] == 4
    assert ran.json["length"]["naive_mean_m"] == pytest.approx((4 + 2 + 1 + 1) / 4)
    assert {
        "drawing.invalid-shapes",
        "drawing.other-shapes",
        "drawing.separate-parts",
        "drawing.duplicates",
    } <= set(codes(ran.json))
    assert 2 in [w.get("first_feature") for w in ran.json["warnings"]]


@pytest.mark.parametrize("content", [b"", b"nothing of the kind", b'{"type": "FeatureCollection"'])
def test_invalid_drawing_files_are_refused(run, write, content: bytes) -> None:
    ran = run("fractures", write(content, "t.geojson"))
    assert ran.code == 2
    assert "t.geojson" in ran.said


@pytest.mark.full
def test_empty_layers_wrong_geometry_and_missing_files_are_refused(run, tmp_path: Path) -> None:
    traces = save(tmp_path / "t.gpkg", ladder())
    areas = save(tmp_path / "a.gpkg", [shapely.box(*(AT - 5), *(AT + 5))])
    assert "drawing.no-traces" in shown_codes(run("fractures", areas).said)
    gone = tmp_path / "gone.gpkg"
    for words, code in (
        ((traces, "--area", traces), "drawing.no-polygons"),
        ((gone,), "file.missing"),
        ((traces, "--area", gone), "file.missing"),
        ((tmp_path,), "file.is-folder"),
    ):
        assert run("fractures", *words, "--json").json["error"]["code"] == code
    empty = geojson(tmp_path / "e.geojson", [], "urn:ogc:def:crs:EPSG::32633")
    assert run("fractures", empty).code == 2


@pytest.mark.full
def test_layer_option_selects_one_of_several_layers(run, tmp_path: Path) -> None:
    path = save(tmp_path / "t.gpkg", ladder(), layer="east")
    save(path, ladder()[:3], layer="west")
    assert "east, west" in run("fractures", path).said
    assert run("fractures", path, "--layer", "west", "--json").json["traces"] == 3
    error = run("fractures", path, "--layer", "north", "--json").json["error"]
    assert (error["code"], error["field"]) == ("drawing.unknown-layer", "--layer")
    assert error["layers"] == ["east", "west"]


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (["--snap", "-1"], "option.too-small"),
        (["--snap", "nan"], "option.too-small"),
        (["--circle", "1,2"], "fractures.not-a-circle"),
        (["--circle", "1,2,0"], "fractures.not-a-circle"),
        (["--circle", "1,2,inf"], "fractures.not-a-circle"),
        (["--strikes", "north"], "fractures.not-a-strike-range"),
        (["--strikes", "0-10", "--by", "set"], "option.conflict"),
        (["--terzaghi-cap", "0.5"], "option.too-small"),
        (["--circle", "0,0,3", "--area", "a.gpkg"], "option.conflict"),
        (["--circle", "0,0,3"], "fractures.area-elsewhere"),
        (["--plot", "p.doc"], "output.unknown-format"),
    ],
)
def test_invalid_options_are_refused(run, tmp_path: Path, words: list[str], code: str) -> None:
    ran = run("fractures", save(tmp_path / "t.gpkg", ladder()), *words, "--json")
    assert (ran.code, ran.json["error"]["code"]) == (2, code)


@pytest.mark.full
def test_figure_contains_all_panels_and_labels(run, tmp_path: Path) -> None:
    traces = save(tmp_path / "t.gpkg", ladder(), set=["rung"] * 9 + ["stile"])
    area = save(tmp_path / "a.gpkg", [shapely.box(*(AT - [1, 0]), *(AT + [5, 10]))])
    picture = tmp_path / "p.svg"
    ran = run("fractures", traces, "--area", area, "--plot", picture)
    assert ran.code == 0, ran.err
    words = " ".join(ElementTree.parse(picture).getroot().itertext())
    for wanted in (
        "10 traces",
        "I 9, Y 0, X 9",
        "n = 10 pieces",
        "rung (9)",
        "stile (1)",
        "whole area",
    ):
        assert wanted in words
    again = run("fractures", traces, "--area", area, "--plot", picture)
    assert again.code == 2
    for words_ in ([], ["--scanline", save(tmp_path / "s.gpkg", [line((1, 0), (1, 12))])]):
        plot = tmp_path / f"{len(words_)}.png"
        assert run("fractures", traces, *words_, "--plot", plot).code == 0
        assert plot.stat().st_size > 10_000


@pytest.mark.parametrize("ending", ["dxf", "gpkg"])
@pytest.mark.filterwarnings("ignore:'crs' was not provided")
def test_closed_lines_are_used_as_area_without_polygons(run, tmp_path, ending) -> None:  # type: ignore[no-untyped-def]
    """A drawing for CAD has no polygons. Open lines beside the outline are none."""
    import ezdxf

    corners = [(0, 0), (10, 0), (10, 10), (0, 10)]
    traces, area = tmp_path / "t.dxf", tmp_path / f"a.{ending}"
    for path, lines in (
        (traces, [[(1, 5), (9, 5)], [(-4, 2), (6, 2)]]),
        (area, [[(1, 1), (2, 9)]]),
    ):
        if path.suffix == ".gpkg":
            ring = shapely.LineString([*corners, corners[0]])
            shapes = np.array([ring, shapely.LineString(lines[0])], object)
            pyogrio.raw.write(path, shapely.to_wkb(shapes), [], [], geometry_type="LineString")
            continue
        document = ezdxf.new("R2010")
        document.header["$INSUNITS"] = 6
        for line in lines:
            document.modelspace().add_lwpolyline(line)
        if path is area:
            document.modelspace().add_lwpolyline(corners, close=True)
        document.saveas(path)
    ran = run("fractures", traces, "--area", area, "--json")
    assert ran.code == 0, ran.err
    assert ran.json["area_m2"] == pytest.approx(100)
    assert ran.json["P21_1_per_m"] == pytest.approx((8 + 6) / 100)
    assert by_code(ran.json["warnings"])["drawing.lines-as-area"]["count"] == 1
