"""`vomstudio rose`, and its figure."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from tests.messages import by_code, error_of, figures, shown_codes
from vomstudio.geology.roses import count_rose
from vomstudio.products.net.rose import TITLES, choose_rings, draw_roses, figure_size
from vomstudio.products.net.rose_contents import RoseContents
from vomstudio.project.catalogue import EXTENT

TABLE = "set,dipdir,dip,length\n" + "".join(
    f"{name},{azimuth + i},{60 + i},{1 + i}\n"
    for name, azimuth in (("A", 120), ("B", 300))
    for i in range(5)
)


def test_strikes_of_each_set_are_counted_in_both_directions(run, write, tmp_path: Path) -> None:
    ran = run("rose", write(TABLE), "-o", tmp_path / "r.svg", "--json")
    assert ran.code == 0
    assert (ran.json["of"], ran.json["axial"], ran.json["n"]) == ("strike", True, 10)
    # Strikes 30 to 34 and 210 to 214 are the same axes.
    for name in "AB":
        found = ran.json["sets"][name]
        assert found["shares"][3] == found["shares"][21] == 1.0
        assert found["mean_deg"] == pytest.approx(32.0)
    words = " ".join(ElementTree.parse(tmp_path / "r.svg").getroot().itertext())
    assert "A (n = 5)" in words
    assert "bins of 10°" in words


def test_dip_directions_are_directed_and_weighted_by_length(run, write, tmp_path: Path) -> None:
    words = ["--of", "dip-direction", "--bin", "2", "--weight", "length", "--scale", "length"]
    ran = run("rose", write(TABLE), "-o", tmp_path / "r.png", *words, "--json")
    found = ran.json["sets"]["A"]
    assert found["total"] == 15.0
    # 120 and 121 share a bin with weights 1 and 2 of 15, 122 and 123 one with 3 and 4.
    assert found["shares"][60:63] == pytest.approx([3 / 15, 7 / 15, 5 / 15])
    assert sum(found["shares"]) == pytest.approx(1.0)


def test_rows_without_azimuth_are_left_out_and_reported(run, write, tmp_path: Path) -> None:
    table = TABLE + "A,10,0,3\nA,10,20,\n"
    ran = run("rose", write(table), "-o", tmp_path / "r.pdf", "--weight", "length", "--json")
    assert ran.json["sets"]["A"]["left_out"] == 2
    assert by_code(ran.json["warnings"])["rose.rows-left-out"] == {"set": "A", "count": 2}


def test_set_without_azimuths_is_reported_and_not_drawn(run, write, tmp_path: Path) -> None:
    ran = run("rose", write(TABLE + "flat,10,0,3\n"), "-o", tmp_path / "r.svg", "--json")
    assert list(ran.json["sets"]) == ["A", "B"]
    assert by_code(ran.json["warnings"])["rose.no-azimuth"] == {"set": "flat"}
    flat = run("rose", write("dipdir,dip\n10,0\n"), "-o", tmp_path / "f.svg")
    assert flat.code == 2
    assert "rose.no-planes" in shown_codes(flat.said)


def test_table_with_only_lines_is_drawn_by_trend(run, write, tmp_path: Path) -> None:
    ran = run("rose", write("trend,plunge\n40,10\n42,5\n10,90\n"), "-o", tmp_path / "r.svg")
    assert ran.code == 0
    assert "n = 2" in ran.out
    assert "mean 041" in ran.out


@pytest.mark.parametrize(
    ("words", "code", "values"),
    [
        (["--bin", "7"], "rose.uneven-bins", {"bin_deg": 7, "field": "--bin"}),
        (["--of", "trend"], "rose.no-lines", {}),
        (["--weight", "set"], "table.not-a-number", {"column": "set", "field": "--weight"}),
        (["--weight", "depth"], "table.unknown-column", {"column": "depth"}),
        (["--of", "azimuth"], "option.not-a-choice", {"value": "azimuth", "field": "--of"}),
    ],
)
def test_invalid_options_are_refused_and_nothing_is_drawn(
    run, write, tmp_path: Path, words: list[str], code: str, values: dict[str, object]
) -> None:
    ran = run("rose", write(TABLE), "-o", tmp_path / "r.svg", *words, "--json")
    assert ran.code == 2
    error_of(ran.json, code, **values)
    assert not (tmp_path / "r.svg").exists()


@pytest.mark.parametrize("by_area", [True, False])
def test_petals_are_to_scale(by_area: bool) -> None:
    """Area by Gauss's formula: that of a sector of the rose, or its length as its share."""
    rose = count_rose([5, 5, 5, 5, 15, 15, 95], is_axial=False)
    figure = Figure(figsize=(6.7, 4.0))
    (ax,) = draw_roses(figure, RoseContents("trend", {"a": rose}, None, by_area)).axes.values()
    petals = [p.get_xy() for p in ax.patches if isinstance(p, Polygon)]
    assert len(petals) == 3
    lengths = [float(np.hypot(*p.T).max()) for p in petals]
    shares = np.array([4, 2, 1]) / 7
    size = np.square(lengths) if by_area else np.array(lengths)
    np.testing.assert_allclose(size / size.sum(), shares, rtol=1e-9)
    outermost = choose_rings(4 / 7)[-1]
    assert size[0] == pytest.approx(4 / 7 / outermost)
    for petal, middle in zip(petals, (5.0, 15.0, 95.0), strict=True):
        east, north = petal[7]
        assert np.degrees(np.arctan2(east, north)) == pytest.approx(middle)


@pytest.mark.parametrize("top", [0.001, 0.02, 0.06, 0.11, 0.3, 0.5, 0.61, 0.8, 1.0])
def test_rings_have_round_values_and_enclose_largest_petal(top: float) -> None:
    rings = choose_rings(top)
    assert 2 <= len(rings) <= 3
    assert rings[-1] >= top - 1e-9
    np.testing.assert_allclose(rings, rings[0] * np.arange(1, len(rings) + 1))


def test_multiple_roses_do_not_overlap() -> None:
    roses = {
        f"Set {i}": count_rose([10.0 * i + j for j in range(9)], is_axial=True) for i in range(7)
    }
    drawn = draw_roses(Figure(figsize=(6.7, 8.0)), RoseContents("strike", roses))
    boxes = [ax.get_position() for ax in drawn.axes.values()]
    for i, a in enumerate(boxes):
        assert 0 <= a.x0 < a.x1 <= 1
        assert a.y1 <= 1
        for b in boxes[:i]:
            assert a.x0 >= b.x1 - 1e-9 or b.x0 >= a.x1 - 1e-9 or a.y1 <= b.y0 or b.y1 <= a.y0


def test_titles_of_roses_are_complete_in_a_narrow_figure() -> None:
    names = ("Bedding: west limb", "Joint: J1, cross joints of the quarry", "Fault: reverse faults")
    roses = {
        name: count_rose([10.0 * i + j for j in range(9)], is_axial=True)
        for i, name in enumerate(names)
    }
    contents = RoseContents("strike", roses)
    for figure in (
        Figure(figsize=(2.6, 2.6)),
        Figure(figsize=figure_size(contents, width_mm=66.0)),
    ):
        draw_roses(figure, contents)
        texts = [text.get_text() for text in figure.texts]
        assert not [text for text in texts if text.endswith("…")]
        words = " ".join(texts).split()
        for name in names:
            for word in name.split():
                assert word in words
        assert words.count("(n") == 3


def test_dips_are_counted_in_a_histogram(run, write, tmp_path: Path) -> None:
    words = ["--of", "dip", "--bin", "5", "--weight", "length"]
    ran = run("rose", write(TABLE), "-o", tmp_path / "r.svg", *words, "--json")
    assert (ran.json["of"], ran.json["axial"]) == ("dip", False)
    found = ran.json["sets"]["A"]
    # 60 to 64 with weights 1 to 5, the last bins from 60 and 85.
    assert len(found["shares"]) == 18
    assert found["shares"][12] == pytest.approx(1.0)
    assert found["mean_deg"] == pytest.approx(np.average(range(60, 65), weights=range(1, 6)))
    assert found["resultant"] is None
    texts = ElementTree.parse(tmp_path / "r.svg").getroot().itertext()
    title, bins, heights = next(t for t in texts if t.startswith(TITLES["dip"])).split("; ")
    assert (title, figures(bins)) == (TITLES["dip"], [5.0])
    assert heights.endswith(" length")
    table = TABLE.replace("length", "extent_m")
    run("rose", write(table), "-o", tmp_path / "e.svg", *words[:-1], "extent_m")
    texts = ElementTree.parse(tmp_path / "e.svg").getroot().itertext()
    caption = next(t for t in texts if t.startswith(TITLES["dip"]))
    assert caption.endswith(EXTENT.title.lower())
    words = ("rose", write(TABLE), "-o", tmp_path / "s.svg", "--of", "dip", "--bin", "60", "--json")
    wrong = run(*words)
    assert wrong.code == 2
    error = wrong.json["error"]
    assert (error["code"], error["range_deg"]) == ("rose.uneven-bins", 90.0)
    none = run("rose", write(TABLE), "-o", tmp_path / "s.svg", "--of", "plunge")
    assert none.code == 2
    assert "--of strike" in none.said


def test_single_azimuth_column_is_enough_for_a_rose(run, write, tmp_path) -> None:
    path, image = write("strike\n10\n12\n14\n"), tmp_path / "rose.svg"
    ran = run("rose", path, "-o", image, "--json")
    assert (ran.code, ran.json["n"], ran.json["of"]) == (0, 3, "strike")
    assert run("stats", path, "--json").json["error"]["code"] == "table.missing-column"
