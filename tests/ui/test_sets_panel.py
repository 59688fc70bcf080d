"""The sets dock where there is little to propose from: a sentence each time, nothing changed."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests import driver
from tests.geology.test_set_proposals import cluster
from tests.messages import shown_codes
from tests.ui.conftest import add_bed, add_cliff
from vomstudio.document import edits
from vomstudio.document.kinds.reading import Reading
from vomstudio.errors import DocumentError
from vomstudio.geology.common_turns import together
from vomstudio.geology.sets.set_options import SetOptions
from vomstudio.ui.analyse.set_candidates import Candidates, propose
from vomstudio.ui.analyse.sets_panel import SetsPanel


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
    driver.wait(lambda: not panel._newest.waiting, "the proposal")
    return panel.said.text()


def test_without_planes_the_command_says_so(window, panel) -> None:
    assert window.actions_table.why_not("propose_sets") == "There are no planes yet."


def test_two_planes_make_no_set(window, studio, panel) -> None:
    read(studio, [(10, 20), (30, 40)])
    assert proposed(window, panel) == "Sets need at least 3 planes; there are 2 here."
    assert not panel.accept.isEnabled()


def test_four_planes_of_no_set_are_no_set(window, studio, panel) -> None:
    read(studio, [(10, 20), (100, 80), (200, 40), (300, 70)])
    assert "No set stands out" in proposed(window, panel)
    assert not panel.accept.isEnabled()


def test_parallel_planes_without_places_are_one_set(window, studio, panel) -> None:
    read(studio, [(90, 45)] * 10)
    said = proposed(window, panel)
    assert "parallel" in said
    assert "No spacing: the planes have no coordinates in metres." in said
    name, count, mean, kappa = (panel.table.item(0, i).text() for i in range(4))
    assert (name, count, mean.partition(" ± ")[0], kappa) == ("J1", "10", "090.00/45.00", "–")
    panel.count.setValue(3)
    assert "sets.fewer" in shown_codes(proposed(window, panel))
    panel.accept.click()
    assert {r.set_name for r in studio.session.of(Reading)} == {"J1"}
    assert proposed(window, panel).endswith("to propose anew among all.")


def test_what_a_selection_is_not_is_left_alone(window, studio, panel) -> None:
    read(studio, [(90 + i % 2, 45) for i in range(12)])
    studio.selection.set([f"r{i}" for i in range(6)])
    proposed(window, panel)
    panel.of.setCurrentIndex(0)
    proposed(window, panel)
    panel.accept.click()
    assert [bool(r.set_name) for r in studio.session.of(Reading)] == [True] * 6 + [False] * 6


def test_one_edit_puts_features_in_several_sets(studio, panel) -> None:
    read(studio, [(90, 45)] * 3)
    edit = edits.put_in_sets(studio.records, {"r0": "A", "r1": "B", "r2": ""})
    assert edit.ids == {"r0", "r1"}
    assert edit.label == "Put 2 features in 2 sets"
    with pytest.raises(DocumentError, match="already"):
        edits.put_in_sets(studio.records, {"r2": ""})


def test_the_cone_holds_the_error_of_the_registration() -> None:
    """Of equal turns about all axes a mean is off by the root of 5.99 times their error, 95 % of a
    chi-square with two degrees of freedom; it adds to the set's own cone in squares."""
    chance = np.random.default_rng(2)
    poles = cluster((40, 60, 300, 80), chance)
    sigma = math.radians(1.0)
    turns = together([("registration", sigma**2 * np.eye(3))] * 80)
    nowhere = np.full((80, 3), np.nan)
    ids = tuple(map(str, range(80)))
    of = Candidates(ids, poles, nowhere, turns, frozenset(), (), replacing=False)
    made = propose(of, SetOptions(exactly=1))
    own = made.sets[0].cone95_deg
    assert made.sets[0].n == 80
    assert made.cones_deg[0] == pytest.approx(math.hypot(own, math.sqrt(5.991)), rel=0.02)


def test_the_preview_ends_where_nobody_can_decide_on_it(window, studio, panel) -> None:
    read(studio, [(90 + i % 2, 45) for i in range(12)])
    seen = []
    studio.sets_proposed.connect(seen.append)
    proposed(window, panel)
    assert [name for name, _ in seen[-1]] == ["J1", ""]
    window.workspaces.switch("interpret")
    assert seen[-1] is None
    window.workspaces.switch("analyse")
    window.docks.bring_forward("sets")
    assert panel.proposed is not None
    assert seen[-1] is not None


def test_what_was_picked_is_pooled_across_types_and_said_so(window, studio, panel) -> None:
    for i in range(8):
        add_bed(studio, f"b{i}", dip=0.5 + 0.01 * i, type_id="bedding" if i % 2 else "joint")
    read(studio, [(10, 20), (100, 80), (200, 40)])
    said = proposed(window, panel)
    assert panel.of.currentText() == "All picked planes"
    assert "Types are pooled" in said
    assert set(panel.proposed.of.ids) == {f"b{i}" for i in range(8)}
    assert panel.table.item(0, 1).text() == "8"
