"""The fold axis of thousands of beds is found beside the window."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests import driver
from tests.tiers import first_in_default_tier
from tests.ui.conftest import add_bed, add_cliff
from vomstudio.project import edits
from vomstudio.project.edit import change
from vomstudio.ui.panels.net import stereonet_panel
from vomstudio.ui.panels.view import view_panel


@pytest.fixture
def panel(own_folders, qtbot, monkeypatch):
    """Of a window that shows it, with seven beds, which are many here."""
    monkeypatch.setattr(view_panel, "_MAX_IMMEDIATE_BEDS", 3)
    window = driver.make_window()
    window.workspaces.switch("results")
    window.docks.bring_forward("view")
    studio = window.studio
    add_cliff(studio)
    bed = add_bed(studio, "t0", dip=0.3)
    more = [
        replace(
            bed,
            id=f"t{k}",
            name=f"B{k}",
            vertices=tuple((x, y + slope * (z + 0.3 * x), z) for x, y, z in bed.vertices),
        )
        for k, slope in enumerate(np.linspace(0.2, 1.4, 6), 1)
    ]
    studio.session.apply(change(studio.records, "Add more", {t.id: t for t in more}))
    yield window.view_panel
    driver.dismiss(window)


@pytest.mark.full
def test_fold_axis_of_many_beds_follows_edits(panel):
    driver.wait(lambda: "of 7 bedding planes" in panel._verdict.text(), "the axis of all")
    panel._studio.session.apply(edits.delete(panel._studio.records, ["t3"]))
    driver.wait(lambda: "of 6 bedding planes" in panel._verdict.text(), "the axis of the rest")
    assert panel.fold_axis_problem() is None


@pytest.mark.full
def test_stale_fold_axis_is_discarded(panel):
    driver.wait(lambda: "of 7 bedding planes" in panel._verdict.text(), "the axis of all")
    late = panel._bedding.search()
    panel._studio.session.apply(edits.delete(panel._studio.records, ["t3"]))
    panel._store_axis(late())
    assert not panel._bedding.is_known
    driver.wait(lambda: "of 6 bedding planes" in panel._verdict.text(), "the axis of the rest")


@pytest.mark.parametrize("many", first_in_default_tier([3, 100]), ids=["in_the_thread", "at_once"])
def test_drawn_net_contains_the_fold_axis(window, studio, monkeypatch, many):
    """Beds that all strike north to south have a horizontal axis to the north."""
    monkeypatch.setattr(stereonet_panel, "_MAX_DIRECT_FEATURES", many)
    window._add_stereonet()
    add_cliff(studio)
    for k, dip in enumerate((-0.8, -0.4, 0.1, 0.4, 0.9)):
        add_bed(studio, f"t{k}", dip=dip)
    net = window.net

    def drawn():
        return net.artists is not None and net.is_up_to_date and net.artists.contents.fold

    driver.wait(drawn, "a net with its axis")
    assert abs(net.artists.contents.fold.beta.vector()[1]) > np.cos(np.radians(3.0))
