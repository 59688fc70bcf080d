"""The sets dock where there is little to propose from: a sentence each time, nothing changed."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests import driver
from tests.geology.test_set_proposals import cluster
from tests.messages import refused, shown_codes, shown_values
from tests.ui.conftest import add_bed, add_cliff
from vomstudio.core.errors import DocumentError
from vomstudio.core.findings import Finding
from vomstudio.geology.common_rotation_errors import group_rotation_errors
from vomstudio.geology.sets.set_options import SetOptions
from vomstudio.project import edits
from vomstudio.project.kinds.reading import Reading
from vomstudio.ui.panels.sets.candidates import Candidates, propose
from vomstudio.ui.panels.sets.sets_panel import SetsPanel


@pytest.fixture
def panel(window, studio) -> SetsPanel:
    add_cliff(studio)
    return window.docks["sets"].widget().widget()


def read(studio, planes, **more) -> None:
    readings = [
        Reading(f"r{i}", f"r{i}", "joint", "plane", float(a), float(d), **more)
        for i, (a, d) in enumerate(planes)
    ]
    assert studio.attempt(edits.add_readings, readings)


def proposed(window, panel) -> str:
    window.actions_table.run("propose_sets")
    driver.wait(lambda: not panel._newest.is_waiting, "the proposal")
    return panel.message.text()


def test_set_proposal_is_disabled_without_planes(window, panel) -> None:
    assert window.actions_table.disabled_reason("propose_sets") == Finding("planes.none")


def test_two_planes_are_too_few_for_a_set(window, studio, panel) -> None:
    read(studio, [(10, 20), (30, 40)])
    said = proposed(window, panel)
    assert shown_values(said, "sets.too-few-planes") == {"minimum": "3", "count": "2"}
    assert not panel.accept.isEnabled()


def test_four_scattered_planes_form_no_set(window, studio, panel) -> None:
    read(studio, [(10, 20), (100, 80), (200, 40), (300, 70)])
    assert "sets.none-distinct" in shown_codes(proposed(window, panel))
    assert not panel.accept.isEnabled()


@pytest.mark.full
def test_parallel_planes_without_positions_form_one_set(window, studio, panel) -> None:
    read(studio, [(90, 45)] * 10)
    codes = shown_codes(proposed(window, panel))
    assert {"sets.parallel", "sets.not-in-metres"} <= codes
    name, count, mean, kappa = (panel.table.item(0, i).text() for i in range(4))
    assert (name, count, mean.partition(" ± ")[0], kappa) == ("J1", "10", "090.00/45.00", "–")
    panel.count.setValue(3)
    proposed(window, panel)
    assert len(panel.result.sets) == 1
    assert panel.result.warnings[0] == Finding("sets.fewer", count=1, minimum=3, wanted=3)
    assert studio.settings.color_by == "type"
    panel.accept.click()
    assert {r.set_name for r in studio.session.of(Reading)} == {"J1"}
    assert studio.settings.color_by == "set"
    driver.wait(window.actions_table.all["color_by_set"].isChecked, "the mark in the menu", 5.0)
    assert "sets.too-few-without-set" in shown_codes(proposed(window, panel))


@pytest.mark.full
def test_accepting_sets_of_a_selection_changes_only_the_selected(window, studio, panel) -> None:
    read(studio, [(90 + i % 2, 45) for i in range(12)])
    studio.selection.set([f"r{i}" for i in range(6)])
    proposed(window, panel)
    panel.group_box.setCurrentIndex(0)
    proposed(window, panel)
    panel.accept.click()
    assert [bool(r.set_name) for r in studio.session.of(Reading)] == [True] * 6 + [False] * 6


def test_one_edit_puts_features_in_several_sets(studio, panel) -> None:
    read(studio, [(90, 45)] * 3)
    edit = edits.assign_sets(studio.records, {"r0": "A", "r1": "B", "r2": ""})
    assert edit.ids == {"r0", "r1"}
    assert {id_: after.set_name for id_, after in edit.after.items()} == {"r0": "A", "r1": "B"}
    with refused("edit.no-change", DocumentError):
        edits.assign_sets(studio.records, {"r2": ""})


def test_cone_includes_the_registration_error() -> None:
    """Of equal turns about all axes a mean is off by the root of 5.99 times their error, 95 % of a
    chi-square with two degrees of freedom; it adds to the set's own cone in squares."""
    chance = np.random.default_rng(2)
    poles = cluster((40, 60, 300, 80), chance)
    sigma = math.radians(1.0)
    rotation_errors = group_rotation_errors([("registration", sigma**2 * np.eye(3))] * 80)
    nowhere = np.full((80, 3), np.nan)
    ids = tuple(map(str, range(80)))
    of = Candidates(
        ids=ids,
        types=("Joint",) * 80,
        poles=poles,
        centres=nowhere,
        rotation_errors=rotation_errors,
        reserved_names=frozenset(),
        warnings=(),
        includes_assigned=False,
    )
    made = propose(of, SetOptions(exactly=1))
    own = made.sets[0].cone95_deg
    assert made.sets[0].n == 80
    assert made.cones_deg[0] == pytest.approx(math.hypot(own, math.sqrt(5.991)), rel=0.02)


def test_preview_is_hidden_when_its_panel_is_not_shown(window, studio, panel) -> None:
    read(studio, [(90 + i % 2, 45) for i in range(12)])
    seen = []
    studio.sets_proposed.connect(seen.append)
    proposed(window, panel)
    assert [name for name, _ in seen[-1]] == ["J1", ""]
    window.workspaces.switch("interpret")
    assert seen[-1] is None
    window.workspaces.switch("results")
    window.docks.bring_forward("sets")
    assert panel.result is not None
    assert seen[-1] is not None


@pytest.mark.full
def test_a_set_never_contains_several_types(window, studio, panel) -> None:
    for i in range(16):
        add_bed(studio, f"b{i}", dip=0.5 + 0.01 * i, type_id="bedding" if i % 2 else "joint")
    add_bed(studio, "lonely", dip=0.5, type_id="fault")
    read(studio, [(10, 20), (100, 80), (200, 40)])
    text = proposed(window, panel)
    assert panel.group_box.currentData() == ("picked", "")
    assert shown_values(text, "sets.type-too-small") == {"type": "Fault", "count": "1"}
    assert set(panel.result.candidates.ids) == {*(f"b{i}" for i in range(16)), "lonely"}
    groups = {
        name: {studio.records[id_].type_id for id_ in ids}
        for name, ids in panel.result.groups(panel.result.names)
        if name
    }
    assert groups == {"B1": {"bedding"}, "J1": {"joint"}}
