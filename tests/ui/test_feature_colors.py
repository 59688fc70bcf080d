"""One colour of a feature in the outcrop, the table and the net."""

from __future__ import annotations

import pytest

from tests.tiers import first_in_default_tier
from tests.ui.conftest import add_bed, add_cliff
from vomstudio.rendering.qt.painting import VERDICT_COLORS
from vomstudio.ui.base.feature_colors import (
    COLOR_MODES,
    UNKNOWN_COLOR,
    feature_color,
    legend,
    set_colors,
)

MODES = tuple(COLOR_MODES)


@pytest.fixture
def planes(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1", dip=0.5, set_name="A")
    add_bed(studio, "t2", dip=1.5, set_name="B")
    add_bed(studio, "j1", dip=-0.8, type_id="joint", set_name="A")
    add_bed(studio, "j2", dip=-0.4, type_id="joint")
    window._add_stereonet()
    return studio


def color(studio, id_: str) -> str:
    return feature_color(studio, studio.records[id_], studio.measured([id_])[id_])


def net_colors(window) -> dict[str, str]:
    return {id_: s.color for s in window.net.contents().sets for id_ in s.ids}


@pytest.mark.parametrize("mode", first_in_default_tier(MODES))
def test_the_net_has_the_colours_of_the_outcrop(window, planes, mode):
    window.actions_table.run(f"color_by_{mode}")
    assert planes.settings.color_by == mode
    expected = {id_: color(planes, id_) for id_ in ("t1", "t2", "j1", "j2")}
    assert net_colors(window) == expected
    # The sets of the statistics stay whole.
    assert sum(len(s) for s in window.net.contents().sets) == 4


def test_sets_with_one_name_in_two_types_have_different_colours(window, planes):
    window.actions_table.run("color_by_set")
    colors = set_colors(planes.session.records)
    assert set(colors) == {("bedding", "A"), ("bedding", "B"), ("joint", "A")}
    assert len(set(colors.values())) == 3
    assert color(planes, "j2") == UNKNOWN_COLOR


def test_quality_colours_match_the_verdict_marks(window, planes):
    window.actions_table.run("color_by_quality")
    for id_ in ("t1", "j2"):
        quality = planes.measured([id_])[id_].verdict.quality
        assert color(planes, id_) == VERDICT_COLORS[quality]
    rows = legend(planes)[1]
    assert [row.verdict for row in rows] == list(VERDICT_COLORS)


def test_opposite_dip_directions_have_different_colours(window, planes):
    window.actions_table.run("color_by_dip_direction")
    assert color(planes, "t1") == color(planes, "t2")
    assert color(planes, "t1") != color(planes, "j1")
    assert len(legend(planes)[1]) == 8


def test_colours_by_type_need_no_legend(window, planes):
    assert legend(planes)[1] == []


def test_display_page_selects_the_colouring_property(window, planes):
    box = window.display_panel.colors
    box.setCurrentIndex(box.findData("quality"))
    box.activated.emit(box.currentIndex())
    assert planes.settings.color_by == "quality"
    window.actions_table.run("color_by_type")
    assert box.currentData() == "type"
