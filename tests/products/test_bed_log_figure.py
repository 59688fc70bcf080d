"""The figure of a log: to scale on paper, words whole, nothing over anything else."""

from __future__ import annotations

import re
from html import escape
from pathlib import Path

import numpy as np
import pytest

from vomstudio.core.errors import UsageError
from vomstudio.geology.beds import lithologies
from vomstudio.geology.beds.bed_log import bed_log
from vomstudio.geology.beds.lithologies import strabospot_fields
from vomstudio.geology.orientation import Plane
from vomstudio.products.section.bed_log_figure import lay_out_page, write_log_figure
from vomstudio.products.section.decimals import format_with_error
from vomstudio.products.section.lithology_style import find_style

LEVEL = Plane(0.0, 0.0)
HEIGHTS = [0.0, 4.0, 4.1, 4.2, 4.3, 9.0]


def log_of(heights, rocks=(), notes=(), **errors):
    n = len(heights)
    return bed_log(
        [[0.0, 0.0, h] for h in heights],
        LEVEL,
        lithologies=[*rocks, *[""] * (n - len(rocks))],
        notes=[*notes, *[""] * (n - len(notes))],
        **errors,
    )


def mm(svg: str, page_width_mm: float) -> float:
    """Of a unit of the file."""
    (size,) = re.findall(r"<svg[^>]* width=\"([\d.]+)pt\"", svg)
    return page_width_mm / float(size)


def test_column_height_on_paper_follows_its_scale(tmp_path: Path) -> None:
    result = log_of(HEIGHTS, ["sandstone", "shale", "limestone"], sigma_m=0.01)
    page = lay_out_page(result)
    assert page.scale == 50.0
    assert page.column_height_mm == pytest.approx(180.0)
    target = tmp_path / "log.svg"
    write_log_figure(target, result, format="svg", description="bedding 000/00")
    svg = target.read_text("utf-8")
    heights = {
        round(abs(float(b) - float(a)) * mm(svg, page.width_mm), 2)
        for x, a, b in re.findall(r'd="M ([\d.]+) ([\d.]+) \nL \1 ([\d.]+)', svg)
    }
    assert 180.0 in heights  # the axis
    assert 80.0 in heights  # four metres of the lowest bed
    for messages in (
        "1 : 50",
        "sandstone",
        "shale",
        "limestone",
        "bedding 000/00",
        "4.000 ± 0.028",
    ):
        assert messages in svg


def test_labels_of_thin_beds_stay_separate_and_in_order() -> None:
    page = lay_out_page(log_of(HEIGHTS))
    assert (np.diff(page.label_heights_mm) >= 4.0 - 1e-9).all()
    assert page.label_heights_mm[0] == pytest.approx(40.0)
    # Those of the three thin beds are moved as little as can be, around their middle.
    assert page.label_heights_mm[1:4].mean() == pytest.approx(83.0)
    many = lay_out_page(log_of(np.linspace(0.0, 3.0, 1001)))
    assert np.isnan(many.label_heights_mm).all()
    assert many.height_mm < 260.0
    few = lay_out_page(log_of(np.linspace(0.0, 0.01, 101)))
    assert few.height_mm > 400.0


def test_formulas_and_long_words_are_drawn_as_plain_text(tmp_path: Path) -> None:
    result = log_of([0, 1, 2], ["$\\frac{1", "x" * 300], ["$a$ <b> & c"])
    target = tmp_path / "log.svg"
    write_log_figure(target, result, format="svg")
    svg = target.read_text("utf-8")
    assert escape("$a$ <b> & c") in svg
    assert "…" in svg
    with pytest.raises(UsageError):
        write_log_figure(tmp_path / "log.gif", result, format="gif")


@pytest.mark.parametrize("word", lithologies.lithology_choices())
def test_every_offered_lithology_has_fields_and_a_style(word: str) -> None:
    fields = strabospot_fields(word)
    assert fields is not None
    look = find_style(word, fields)
    assert re.fullmatch("#[0-9a-f]{6}", look.color)
    if fields["primary_lithology"]:
        assert look != find_style("", {})


def test_coarser_beds_are_wider() -> None:
    def width(word: str) -> float:
        fields = strabospot_fields(word)
        assert fields is not None
        result = find_style(word, fields).width
        assert result is not None
        return result

    for words in (
        ("mudstone", "siltstone", "sandstone", "conglomerate"),
        ("lime mudstone", "wackestone", "packstone", "grainstone", "rudstone"),
    ):
        widths = [width(word) for word in words]
        assert widths == sorted(set(widths))
    assert find_style("coal", strabospot_fields("coal") or {}).width is None


def test_digits_follow_the_error() -> None:
    assert format_with_error(2.4621, 0.0571) == "2.462 ± 0.057"
    assert format_with_error(24.6, 1.83) == "24.6 ± 1.8"
    assert format_with_error(2.4621, None) == "2.462"
    assert format_with_error(2.4621, 0.0) == "2.462 ± 0.000"
