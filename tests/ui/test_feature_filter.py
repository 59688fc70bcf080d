"""The filter line: words and conditions, and what it says of what it cannot read."""

from __future__ import annotations

import pytest

from tests.messages import refused, shown_codes
from tests.tiers import first_in_default_tier
from tests.ui.conftest import add_bed, add_cliff
from vomstudio.core.errors import UsageError
from vomstudio.project import edits
from vomstudio.project.kinds.reading import Reading
from vomstudio.ui.panels.features.feature_filter import parse_filter
from vomstudio.ui.panels.features.feature_row import create_row


def reading(name: str, azimuth: float, inclination: float, geometry: str = "plane", **more):
    return Reading(
        name, name, more.pop("type_id", "bedding"), geometry, azimuth, inclination, **more
    )


@pytest.fixture
def found(studio):
    """The names that pass a filter, of compass readings whose angles are exact."""
    add_cliff(studio)
    features = [
        reading("north", 350.0, 30.0, set_name="west limb", notes="wet"),
        reading("east", 95.0, 31.2, set_name="east limb", overturned=True),
        reading("crack", 20.0, 80.0, type_id="joint"),
        reading("axis", 30.0, 12.0, "line", type_id="fold_axis"),
    ]
    assert studio.attempt(edits.add_features, features)

    def names(text: str) -> list[str]:
        test = parse_filter(text)
        measured = studio.measured(f.id for f in features)
        return [f.name for f in features if test(create_row(studio, f, measured[f.id]))]

    return names


@pytest.mark.parametrize(
    ("text", "names"),
    first_in_default_tier(
        [
            ("dip>30", ["east", "crack"]),
            ("dip>=30", ["north", "east", "crack"]),
            ("dip=31", ["east"]),
            ("dip=31.0", []),
            ("dip:30..40", ["north", "east"]),
            ("dip<31,2", ["north"]),
            ("dipdir:340..40", ["north", "crack"]),
            ("dipdir!=340..40", ["east"]),
            ("strike:5", ["east"]),
            ("plunge<20", ["axis"]),
            ("type:joint", ["crack"]),
            ("type=joint|bedding dip<31", ["north"]),
            ("-type:bedding", ["crack", "axis"]),
            ('set:"west limb"', ["north"]),
            ("set:limb -wet", ["east"]),
            ("overturned:yes", ["east"]),
            ("overturned:no type:bedding", ["north"]),
            ("kind:reading joint", ["crack"]),
            # The names of files are understood too, where `kind` is the feature type.
            ("kind=joint", ["crack"]),
            ("kind!=reading", []),
            ("dip_deg>31", ["east", "crack"]),
            ("pole_trend_deg:180..210", ["crack"]),
            ("element:line", ["axis"]),
            ("350/30", ["north"]),
            ('"west limb"', ["north"]),
            ("", ["north", "east", "crack", "axis"]),
        ],
        6,
    ),
)
def test_filter_conditions_select_matching_features(found, text, names):
    assert found(text) == names


def test_undefined_values_match_no_condition(found):
    assert "axis" not in found("dip<90") + found("dip!=5")
    assert found("extent>0") == []


def test_lengths_may_have_a_unit(studio):
    add_cliff(studio)
    add_bed(studio, "t1", "bed")
    measured = studio.measured(["t1"])["t1"]
    row = create_row(studio, studio.records["t1"], measured)
    extent = measured.fit.extent
    assert parse_filter(f"extent>{extent * 99:.3f}cm")(row)
    assert not parse_filter(f"extent>{extent * 101:.3f}cm")(row)


@pytest.mark.parametrize(
    ("text", "code", "values"),
    [
        ("dip>steep", "filter.needs-number", {"name": "dip"}),
        ("dip>", "filter.needs-number", {"name": "dip"}),
        ("dip>30..40", "filter.needs-number", {"condition": "dip>30..40"}),
        ("slope>30", "filter.similar-column", {"name": "slope"}),
        ("zzzz>30", "filter.unknown-column", {"name": "zzzz"}),
        ("type>joint", "filter.text-has-no-size", {"condition": "type>joint"}),
        ("overturned:perhaps", "filter.needs-yes-or-no", {"name": "overturned"}),
        ("dip>3kg", "filter.needs-number", {"condition": "dip>3kg"}),
    ],
)
def test_invalid_filter_is_rejected_with_the_expected_form(text, code, values):
    with refused(code, UsageError, **values):
        parse_filter(text)


@pytest.mark.full
def test_unfinished_condition_keeps_the_previous_filter(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1", "flat", dip=0.2)
    add_bed(studio, "t2", "steep", dip=2.0)
    window.docks.bring_forward("table")
    panel = window.table
    panel._filter.setText("dip>45")
    assert panel._sorted_rows.rowCount() == 1
    panel._filter.setText("dip>45 dip<")
    assert panel._sorted_rows.rowCount() == 1
    assert panel._filter.problem.isVisible()
    assert "filter.needs-number" in shown_codes(panel._filter.problem.text())
    panel._filter.clear()
    assert panel._sorted_rows.rowCount() == 2
    assert not panel._filter.problem.isVisible()
    assert "dip>30" in panel._filter.toolTip()


def test_tree_filter_uses_the_same_words_and_shows_the_remaining_count(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1", "flat", dip=0.2)
    add_bed(studio, "t2", "steep", dip=2.0)
    add_bed(studio, "t3", "other", type_id="fault")
    studio.selection.set(["t1"])
    window.tree.filter.setText("type:bedding dip>45")
    items = window.tree._items
    assert [items[i].isHidden() for i in ("t1", "t2", "t3", "fault")] == [True, False, True, True]
    assert items["bedding"].text(0) == "Bedding (1 of 2)"
    assert studio.selection.ids == ("t1",)
    assert not items["models"].isHidden()
    window.tree.filter.clear()
    assert items["bedding"].text(0) == "Bedding (2)"
    assert not items["t1"].isHidden()


@pytest.mark.parametrize("unit", ["m2", "m²", "cm2", " m²"])
def test_areas_may_have_a_unit(unit):
    class Row:
        search_text = ""

        def __init__(self, area_m2: float) -> None:
            self.area_m2 = area_m2

        def value(self, figure):
            assert figure.unit == "m2"
            return self.area_m2

    size = 2.0 * (1e-4 if "cm" in unit else 1.0)
    test = parse_filter(f'area>"2{unit}"')
    assert (test(Row(0.9 * size)), test(Row(1.1 * size))) == (False, True)
