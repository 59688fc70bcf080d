"""Facets of a cliff become sets of joints on the net, at every size of the window."""

from __future__ import annotations

import pytest

from tests import driver
from tests.driver import wait
from tests.journeys.conftest import SCREENS
from vomstudio.core.paths import resource
from vomstudio.project.kinds.patch import Patch
from vomstudio.ui.panels.sets.sets_panel import SetsPanel
from vomstudio.ui.panels.surface.facets_panel import FacetsPanel

pytestmark = pytest.mark.full


def press(window, button) -> None:
    driver.click(button, button.rect().center())


def find_facets(window) -> FacetsPanel:
    window.actions_table.run("propose_facets")
    panel = window.findChild(FacetsPanel)
    wait(lambda: panel.isVisible() and panel.start.isEnabled(), "the model")
    press(window, panel.start)
    wait(lambda: panel._facets.proposals is not None, "the facets", 120.0)
    return panel


def net_sets(window) -> dict[str, str]:
    """Colours of the sets on the net, by name."""
    net = window.net
    wait(lambda: net.is_up_to_date and net.artists is not None, "the net", 60.0)
    return {each.name: each.color for each in net.artists.contents.sets}


def set_names(window) -> set[str]:
    return {patch.set_name for patch in window.studio.session.of(Patch)}


def drawn_colors(window) -> set[tuple[float, ...]]:
    """Colours of the planes on the outcrop, of which each set has one."""
    drawings = window.viewport.features.drawings
    colors: dict[str, set[tuple[float, ...]]] = {}
    for patch in window.studio.session.of(Patch):
        colors.setdefault(patch.set_name, set()).add(drawings[patch.id].color)
    assert all(len(of_set) == 1 for of_set in colors.values())
    return set().union(*colors.values())


@pytest.mark.parametrize("screen", SCREENS, indirect=True)
def test_facets_become_coloured_sets_on_the_net(window, screen) -> None:
    studio = window.studio
    window.open_path(resource("sample", "sample.obj"))
    driver.settled(window)
    studio.set_next_type("joint", "")
    panel = find_facets(window)
    driver.keep_picture(window, f"facets-{screen}")
    assert panel.table.accessibleName() in net_sets(window)
    panel.filter.setText("quality:good area>0.3m2")
    listed = len(panel.listed_indices())
    assert listed >= 20
    press(window, panel.accept_all)
    patches = studio.session.of(Patch)
    assert len(patches) == listed
    assert {patch.type_id for patch in patches} == {"joint"}

    studio.selection.set([])
    window.actions_table.run("propose_sets")
    sets = window.findChild(SetsPanel)
    wait(lambda: sets.isVisible() and sets.result is not None, "the sets", 60.0)
    driver.keep_picture(window, f"facets-sets-{screen}")
    before = dict(studio.records)
    names = {n for n in sets.result.names if n}
    assert len(names) >= 2
    press(window, sets.accept)
    assert studio.settings.color_by == "set"
    wait(lambda: len(drawn_colors(window)) == len(set_names(window)), "the colours of the sets")
    assert names <= set_names(window)
    colors = net_sets(window)
    assert len(set(colors.values())) == len(colors)
    assert len(colors) == len(set_names(window))
    driver.keep_picture(window, f"facets-coloured-{screen}")
    studio.undo()
    assert dict(studio.records) == before
