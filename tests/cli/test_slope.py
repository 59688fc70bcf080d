"""`vomstudio slope` and `vs.slope`."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import vomstudio as vs
from tests.messages import codes, messages, shown_codes

TABLE = "id,dipdir,dip\na,100,45\nb,120,60\nc,280,80\nd,100,20\n"
MODES = ("planar", "wedge", "flexural_toppling", "direct_toppling")


def test_counts_and_shares_are_reported_for_each_mode(run, write) -> None:
    ran = run("slope", write(TABLE), "--face", "100/70", "--friction", 30, "--json")
    assert ran.code == 0
    for mode in MODES:
        found = ran.json[mode]
        assert found.keys() >= {"critical", "of", "share", "probability"}
        assert found["share"] == found["critical"] / found["of"]
        assert found["probability"] is None
    assert [ran.json[mode]["of"] for mode in MODES] == [4, 6, 4, 6]
    assert ran.json["planar"]["ids"] == ["a", "b"]
    assert ran.json["flexural_toppling"]["ids"] == ["c"]
    assert ran.json["lateral_deg"] == 20.0


def test_sets_of_one_name_but_different_kinds_are_different_sets(run, write) -> None:
    lines = TABLE.splitlines()[1:]
    words = ("--face", "100/70", "--friction", 30, "--json")
    plain = [f"{line},A" for line in lines]
    kinds = [
        f"{line},A,{kind}"
        for line, kind in zip(lines, ("bedding",) * 2 + ("joint",) * 2, strict=True)
    ]
    one_set = run("slope", write("\n".join(["id,dipdir,dip,set", *plain])), *words).json
    assert (one_set["wedge"]["of"], one_set["wedge"]["same_set"]) == (0, 6)
    two_sets = run("slope", write("\n".join(["id,dipdir,dip,set,kind", *kinds])), *words).json
    # Of six pairs, one is of beds and one is of joints.
    assert (two_sets["wedge"]["of"], two_sets["wedge"]["same_set"]) == (4, 2)


def test_lateral_limit_applies_to_planes_but_not_wedges(run, write) -> None:
    path = write(TABLE)
    words = ["slope", path, "--face", "100/70", "--friction", 30, "--json"]
    narrow, wide = (run(*words, "--lateral", limit).json for limit in (5, 90))
    assert narrow["planar"]["ids"] == ["a"]
    assert wide["planar"]["ids"] == ["a", "b"]
    assert narrow["wedge"] == wide["wedge"]
    assert narrow["direct_toppling"] != wide["direct_toppling"]


def test_one_plane_has_no_intersections_and_gives_warning(run, write) -> None:
    ran = run(
        "slope", write("dipdir,dip\n100,45\n"), "--face", "100/70", "--friction", 30, "--json"
    )
    assert ran.code == 0
    assert (ran.json["wedge"]["of"], ran.json["wedge"]["share"]) == (0, None)
    assert "two planes" in messages(ran.json)[-1]


def test_rows_without_angles_are_dropped_and_reported(run, write) -> None:
    ran = run("slope", write(TABLE + "e,nan,30\n"), "--face", "100/70", "--friction", 30, "--json")
    assert ran.json["n"] == 4
    assert ran.json["dropped_lines"] == [6]


def test_face_flatter_than_friction_angle_has_no_sliding(run, write) -> None:
    ran = run("slope", write(TABLE), "--face", "100/25", "--friction", 30, "--json")
    assert [ran.json[mode]["critical"] for mode in MODES[:3]] == [0, 0, 0]
    assert "slope.gentle-face" in codes(ran.json)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--face", "100/0", "--friction", "30"], "--face"),
        (["--face", "100", "--friction", "30"], "--face"),
        (["--face", "100/70", "--friction", "90"], "--friction"),
        (["--face", "100/70", "--friction", "nan"], "--friction"),
        (["--face", "100/70", "--friction", "30", "--lateral", "-3"], "--lateral"),
        (["--face", "100/70"], "--friction"),
    ],
)
def test_invalid_angles_are_reported_with_their_option(run, write, words, said) -> None:
    ran = run("slope", write(TABLE), *words)
    assert ran.code == 2
    assert said in ran.said


def test_table_with_only_lines_is_refused(run, write) -> None:
    ran = run("slope", write("trend,plunge\n100,20\n"), "--face", "100/70", "--friction", 30)
    assert ran.code == 2
    assert "orientation.no-planes" in shown_codes(ran.said)


def test_text_output_shows_same_counts(run, write) -> None:
    ran = run("slope", write(TABLE), "--face", "100/70", "--friction", 30)
    line = next(line for line in ran.out.splitlines() if line.startswith("planar"))
    assert line.split() == ["planar", "sliding", "planes", "2", "4", "50.0", "-"]


def test_python_function_matches_command_output(run, write) -> None:
    path = write(TABLE)
    ran = run("slope", path, "--face", "100/70", "--friction", 30, "--lateral", 15, "--json")
    for face in ("100/70", (100, 70)):
        found = vs.slope(path, face, friction_deg=30, lateral_deg=15)
        assert found.planar.share == ran.json["planar"]["share"]
        assert found.to_dict()["wedge"] == ran.json["wedge"]


@pytest.mark.full
def test_five_thousand_planes_are_tested_in_pairs() -> None:
    generator = np.random.default_rng(5)
    azimuth, dip = generator.uniform(0, 360, 5000), generator.uniform(1, 89, 5000)
    found = vs.slope((azimuth, dip), (90, 70), friction_deg=30)
    assert found.wedge.of == 5000 * 4999 // 2


def test_figure_shows_same_numbers_as_output(run, write, tmp_path: Path) -> None:
    import xml.etree.ElementTree as ElementTree

    path, target = write(TABLE), tmp_path / "s.svg"
    words = ["slope", path, "--face", "100/70", "--friction", 30, "--plot", target]
    ran = run(*words, "--json")
    assert ran.json["image"] == str(target)
    said = " ".join(ElementTree.parse(target).getroot().itertext())
    for title in ("Planar sliding", "Wedge sliding", "Flexural toppling", "Direct toppling"):
        assert title in said
    assert re.search(r"\b2 of 4 [^:]*: 50\.0 %", said)
    again = run(*words)
    assert again.code == 2
    assert "exists" in again.said
    assert "--plot" in run(*words[:-1], tmp_path / "s.docx").said


def test_shaded_zone_contains_only_critical_poles() -> None:
    from matplotlib.figure import Figure

    from vomstudio.geology.orientation import planes_to_poles
    from vomstudio.geology.slope_options import SlopeOptions
    from vomstudio.geology.stereonet import vectors_to_longitude_latitude
    from vomstudio.geology.table_slopes import slope_face, table_slope
    from vomstudio.io.text.orientation_reading import extract_orientations
    from vomstudio.io.text.tables import table_from_cells
    from vomstudio.products.net.slope_figure import draw_slope

    generator = np.random.default_rng(3)
    azimuth, dip = generator.uniform(0, 360, 300), generator.uniform(1, 89, 300)
    cells = [[repr(float(a)), repr(float(d))] for a, d in zip(azimuth, dip, strict=True)]
    table = extract_orientations(table_from_cells(("dipdir", "dip"), cells, "t"))
    face = slope_face("120/75", SlopeOptions(30.0))
    found = table_slope(table, face)
    planar, _, flexural, _ = draw_slope(Figure((6, 7)), table, face, found)
    places = vectors_to_longitude_latitude(planes_to_poles(azimuth, dip))
    for ax, mode in ((planar, found.planar), (flexural, found.flexural_toppling)):
        (zone,) = (c for c in ax.collections if type(c).__name__.endswith("ContourSet"))
        (path,) = zone.get_paths()
        inside = path.contains_points(places)
        critical = np.isin(np.arange(300) + 1, [int(i) for i in mode.ids])
        # But for what lies within a cell of the grid of the edge.
        assert (inside != critical).sum() <= 2
        assert critical.any()


@pytest.mark.parametrize("face", [(100,), 100, (100, 70, 3), ("east", 70), (100, 120), (100, 0)])
def test_python_function_refuses_invalid_face(face) -> None:
    with pytest.raises((vs.errors.InputError, vs.errors.UsageError, vs.errors.GeometryError)):
        vs.slope(([90], [45]), face, friction_deg=30)
