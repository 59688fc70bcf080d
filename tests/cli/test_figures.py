"""Every figure of the program: no texts overlap, leave the page or show internal words."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import shapely
from matplotlib.figure import Figure

import vomstudio
from tests.figure_texts import Page, page_of_svg, recorded
from tests.messages import figures
from tests.tiers import first_in_default_tier
from vomstudio.core.findings import Finding
from vomstudio.products.fractures.figure import MAX_SETS
from vomstudio.products.ortho.sheet import write_sheet
from vomstudio.products.ortho.vector_drawing import Drawing, DrawingShape, svg_text
from vomstudio.products.ortho.view_directions import view_along_line

SETS = ("west limb", "crest of the fold", "hanging wall", "footwall", "J1", "J2", "J3", "fault")
SIZES_MM = (90, 170, 300)


@pytest.fixture
def planes(tmp_path: Path) -> Path:
    """Forty planes of eight sets with errors."""
    rng = np.random.default_rng(5)
    path = tmp_path / "planes.csv"
    rows = ["id,kind,element,set,dip_direction_deg,dip_deg,total95_deg"]
    for i in range(40):
        k = i % len(SETS)
        azimuth, dip = (45 * k + rng.normal(0, 4)) % 360, min(89.0, 20 + 8 * k + rng.normal(0, 3))
        kind = "bedding" if k < 4 else "joint"
        rows.append(f"P{i:02d},{kind},plane,{SETS[k]},{azimuth:.1f},{dip:.1f},1.5")
    path.write_text("\n".join(rows) + "\n")
    return path


def check(run, *words: object) -> Page:
    """Run a command that draws, look at all pages that it drew, and return the last one."""
    with recorded() as pages:
        ran = run(*words, "-q")
    assert ran.code == 0, ran.err
    assert pages
    assert [fault for page in pages for fault in page.faults()] == []
    return pages[-1]


@pytest.mark.full
@pytest.mark.parametrize("width", first_in_default_tier(SIZES_MM, 2))
@pytest.mark.parametrize("of", first_in_default_tier(["strike", "dip"]))
def test_rose_has_no_layout_faults(run, planes, tmp_path, width, of) -> None:
    check(
        run, "rose", planes, "--by", "set", "--of", of, "--width", width, "-o", tmp_path / "r.svg"
    )


@pytest.mark.full
@pytest.mark.parametrize("friction", first_in_default_tier([35, 10, 80]))
def test_slope_figure_has_no_layout_faults(run, planes, tmp_path, friction) -> None:
    words = ("slope", planes, "--face", "310/75", "--friction", friction)
    check(run, *words, "--plot", tmp_path / "s.svg")


@pytest.mark.parametrize("count", first_in_default_tier([3, 40, 1]))
def test_slip_figure_has_no_layout_faults(run, tmp_path, count) -> None:
    table = tmp_path / "faults.csv"
    rows = [f"{(20 + 7 * i) % 360},{50 + i % 30},{60 + i % 50},N" for i in range(count)]
    table.write_text("\n".join(["strike,dip,rake,sense", *rows]) + "\n")
    check(run, "slip", table, "--plot", tmp_path / "slip.svg")


@pytest.mark.parametrize("spread", first_in_default_tier([0.5, 0.01, 3.0]))
def test_plane_shape_figure_has_no_layout_faults(run, tmp_path, spread) -> None:
    rng = np.random.default_rng(2)
    rows = ["pick,x,y,z"]
    for k in range(12):
        points = rng.normal(0, [4, 0.3 + spread, 0.02 * (k + 1)], (20, 3))
        rows += [f"P{k:02d},{x:.4f},{y:.4f},{z:.4f}" for x, y, z in points.tolist()]
    (tmp_path / "points.csv").write_text("\n".join(rows) + "\n")
    check(run, "fit", tmp_path / "points.csv", "--by", "pick", "--plot", tmp_path / "f.svg")


def traces(path: Path, count: int, sets: int, size: float) -> Path:
    """A layer of straight traces around a place in UTM."""
    import pyogrio

    rng = np.random.default_rng(3)
    start = np.array([5e5, 5e6]) + rng.uniform(0, size, (count, 2))
    ends = start + rng.normal(0, 0.2 * size, (count, 2))
    names = np.array([f"set of fractures {k % sets}" for k in range(count)], object)
    lines = shapely.linestrings(np.stack([start, ends], axis=1))
    pyogrio.raw.write(
        path, shapely.to_wkb(lines), [names], ["set"], geometry_type="LineString", crs="EPSG:32633"
    )
    return path


@pytest.mark.full
@pytest.mark.parametrize(
    ("count", "sets", "size"),
    first_in_default_tier([(60, 9, 20.0), (3, 1, 0.05), (300, 40, 900.0), (40, 2, 7e4)]),
)
@pytest.mark.parametrize("window", first_in_default_tier([True, False]))
def test_fracture_figure_has_no_layout_faults(run, tmp_path, count, sets, size, window) -> None:
    layer = traces(tmp_path / "t.gpkg", count, sets, size)
    circle = ("--circle", f"{5e5 + size / 2},{5e6 + size / 2},{size / 2}") if window else ()
    page = check(run, "fractures", layer, *circle, "--plot", tmp_path / "f.svg")
    texts = [text for text, _, _ in page.texts]
    is_named = {k: any(f"set of fractures {k} (" in text for text in texts) for k in range(sets)}
    if sets == 1:
        assert not any(is_named.values())
    elif sets <= MAX_SETS:
        assert all(is_named.values())
    else:
        # The last row of the legend counts the other sets.
        assert sum(is_named.values()) == MAX_SETS - 1
        others = [text for text in texts if figures(text) == [sets - MAX_SETS + 1]]
        assert [text for text in others if re.search("[a-z]", text)]


@pytest.mark.full
@pytest.mark.parametrize("scanline", [True])
def test_fracture_figure_without_complete_lengths_has_no_empty_panel(
    run, tmp_path, scanline
) -> None:
    """A small circle inside long traces: no length is known."""
    import pyogrio

    lines = [shapely.LineString([(5e5 - 50, 5e6 + k), (5e5 + 50, 5e6 + k)]) for k in range(5)]
    pyogrio.raw.write(
        tmp_path / "t.gpkg",
        shapely.to_wkb(np.array(lines, object)),
        [],
        [],
        geometry_type="LineString",
        crs="EPSG:32633",
    )
    with recorded() as pages:
        words = ("--circle", "500000,5000002,3", "--plot", tmp_path / "f.svg", "-q")
        assert run("fractures", tmp_path / "t.gpkg", *words).code == 0
    (page,) = pages
    letters = {text for text, _, _ in page.texts if re.fullmatch("[a-e]", text)}
    assert letters >= {"a", "b", "c"}
    assert "d" not in letters
    assert page.faults() == []


@pytest.mark.parametrize(
    ("rows", "thick"), first_in_default_tier([(12, 0.4), (2, 30.0), (80, 0.02), (5, 0.001)])
)
@pytest.mark.parametrize("described", first_in_default_tier([True, False]))
def test_log_figure_has_no_layout_faults(run, tmp_path, rows, thick, described) -> None:
    rocks = ("sandstone", "claystone", "limestone", "wackestone", "tuff", "covered", "breccia")
    lines = ["x,y,z,lithology,notes" if described else "x,y,z"]
    for i in range(rows):
        words = f",{rocks[i % 7]},{'red at the base of it' if i % 3 else ''}" if described else ""
        lines.append(f"0,0,{thick * i * (1 + i % 2):.5f}{words}")
    (tmp_path / "b.csv").write_text("\n".join(lines) + "\n")
    words = ("log", tmp_path / "b.csv", "--bed", "90/5", "--bed-error", 2)
    check(run, *words, "--plot", tmp_path / "log.svg")


@pytest.mark.parametrize(
    ("width", "height"), first_in_default_tier([(80, 25), (4, 40), (1500, 30)])
)
@pytest.mark.parametrize("manner", first_in_default_tier(["drone", "handheld", "terrain"]))
def test_plan_sheet_has_no_layout_faults(run, tmp_path, width, height, manner) -> None:
    words = ("plan", "--camera", "23.5x15.6,35,6000x4000", "--distance", 30, "--manner", manner)
    check(run, *words, "--width", width, "--height", height, "-o", tmp_path / "plan.svg")


def drawing(width: float, height: float) -> Drawing:
    """Forty planes on a picture, most of them in one corner, and a few long traces."""
    rng = np.random.default_rng(4)
    low = np.array([-width / 2, -height / 2])
    shapes = []
    for i in range(40):
        kind = ("bedding", "fault", "joint")[i % 3]
        color = ("#0072b2", "#d55e00", "#009e73")[i % 3]
        at = low + rng.uniform(0, 0.5 if i % 4 else 1.0, 2) * [width, height]
        typed = {"values": {"kind": kind}, "label": f"P{i:02d} {i * 2}°", "dip_deg": 2.0 * i}
        shapes.append(DrawingShape("planes", at[None], color, **typed))
        if i % 5 == 0:
            line = np.stack([at, at + rng.normal(0, 0.2, 2) * [width, height]])
            shapes.append(DrawingShape("traces", line, color, values={"kind": kind}))
    bounds = np.stack([low, -low])
    axes = ("distance toward ESE (m)", "distance up (m)")
    return Drawing(tuple(shapes), bounds, ("WNW (301)", "ESE (121)"), axes, ("A title",))


SHAPES = [(30.0, 16.0), (4.0, 40.0), (2400.0, 300.0), (0.4, 0.3)]


@pytest.mark.parametrize(("width", "height"), first_in_default_tier(SHAPES, 2))
def test_orthophoto_sheet_has_no_layout_faults(tmp_path, width, height) -> None:
    view = replace(view_along_line(31, 11), reason=Finding("view.as-given"))
    with recorded() as pages:
        write_sheet(tmp_path / "s.pdf", drawing(width, height), view, "pdf")
    assert [fault for page in pages for fault in page.faults()] == []


@pytest.mark.parametrize(("width", "height"), SHAPES)
def test_section_drawing_has_no_layout_faults(width, height) -> None:
    page = page_of_svg(svg_text(drawing(width, height)))
    assert len(page.texts) > 20
    assert page.faults() == []


@pytest.mark.parametrize("width", first_in_default_tier([9.0, 6.0, 14.0]))
def test_surface_figure_has_no_layout_faults(width) -> None:
    from tests.products.test_surface import grooves, mesh_over
    from vomstudio.products.surface.analysis import analyse
    from vomstudio.products.surface.figure import draw_surface

    figures = analyse(mesh_over(grooves(60, 0.05, 30.0, 0.6, 0.02), 0.05), noise_m=1e-3)
    figure = Figure(figsize=(width, 0.5 * width))
    draw_surface(figure, figures)
    with recorded() as pages:
        figure.draw_without_rendering()
    assert [fault for page in pages for fault in page.faults()] == []


@pytest.mark.parametrize("count", first_in_default_tier([6, 25, 60]))
def test_residual_map_has_no_layout_faults(count) -> None:
    from vomstudio.products.report.residual_map import residual_map

    rng = np.random.default_rng(1)
    rows = [
        {
            "label": f"T{i}",
            "role": "check" if i % 4 == 0 else "control",
            "surveyed": [*rng.uniform(0, 30, 2).tolist(), float(rng.uniform(0, 12))],
            "residual_m": rng.normal(0, 0.01, 3).tolist(),
        }
        for i in range(count)
    ]
    with recorded() as pages:
        assert "<img" in residual_map({"points": rows}, is_scaled=True)
    assert [fault for page in pages for fault in page.faults()] == []


def test_every_module_that_writes_figures_is_tested() -> None:
    """Modules that write figures: each of them is drawn by a test above, or is a net."""
    root = Path(vomstudio.__file__).parent / "products"
    writes = re.compile(r"\b(savefig|write_figure|save_figure|print_svg)\(")
    found = {
        path.relative_to(root).as_posix()
        for path in root.rglob("*.py")
        if path.parent.name != "net" and writes.search(path.read_text("utf-8"))
    }
    assert found == {
        "fractures/figure.py",
        "ortho/sheet.py",
        "report/field_sheet.py",
        "report/residual_map.py",
        "section/bed_log_figure.py",
    }
