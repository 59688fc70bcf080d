"""Domains in the real window: a fault parts the features, a section projects each domain along its
own axis, and an orthophoto shows one of them."""

from __future__ import annotations

import json
import shlex

import numpy as np
import pytest
from PySide6.QtGui import QGuiApplication
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tests import driver
from tests.driver import LEFT, NONE, wait
from vomstudio.cli.common.entry import main
from vomstudio.geology.orientation import planes_to_normals
from vomstudio.project import edits
from vomstudio.project.domains import domain_names
from vomstudio.project.kinds.trace import Trace
from vomstudio.ui.dialogs.orthophoto_dialog import OrthoDialog
from vomstudio.ui.panels.sections.section_panel import SectionPanel


@pytest.fixture
def parted(window, outcrop, picks):
    """The beds of the outcrop, parted by a fault through their middle, which is selected."""
    model_id = driver.open_outcrop(window, outcrop)
    model = window.studio.records[model_id]
    middles = np.array([points.mean(axis=0) for points in picks.values()])
    _, _, ways = np.linalg.svd(middles - middles.mean(axis=0))
    # Half upright, so that it has a wall that hangs.
    across = ways[0] - [0.0, 0.0, ways[0][2]]
    across = np.cross(across / np.linalg.norm(across), [0.0, 0.0, 1.0])
    along = np.cross(across, [0.0, 0.0, 1.0]) + [0.0, 0.0, 1.5]
    t = np.linspace(-2.0, 2.0, 15)
    fault = np.median(middles, axis=0) + np.outer(t, across) + np.outer(np.sin(4.0 * t), along)
    for name, points in {**picks, "F01": fault}.items():
        vertices = tuple(tuple(p) for p in points.tolist())
        kind = "bedding" if name[0] == "B" else "fault"
        trace = Trace(name, name, kind, model_id, model.content_hash, vertices)
        assert window.studio.attempt(edits.add_trace, trace)
    window.studio.selection.set(["F01"])
    driver.settled(window)
    window.actions_table.run("part_by_plane")
    driver.settled(window)
    return picks


@pytest.mark.full
def test_fault_splits_beds_into_domains_and_undo_rejoins_them(window, parted) -> None:
    studio = window.studio
    assert domain_names(studio.session.records) == ["footwall", "hanging wall"]
    fault = studio.measured(["F01"])["F01"]
    normal = planes_to_normals(fault.plane.dip_direction_deg, fault.plane.dip_deg)
    middle = fault.points.mean(axis=0)
    told = 0
    for name, points in parted.items():
        domain = getattr(studio.records.get(name), "domain", "")
        if domain:
            told += 1
            above = ((points - middle) @ normal > 0).mean()
            assert above > 0.5 if domain == "hanging wall" else above < 0.5
    assert told >= 4
    window.actions_table.run("undo")
    assert domain_names(studio.session.records) == []


@pytest.mark.full
def test_the_section_and_its_command_project_each_domain_along_its_axis(
    window, parted, tmp_path, capfd
) -> None:
    window.actions_table.run("section")
    panel = window.findChild(SectionPanel)
    panel.plane.line.setText("300/90")
    driver.pause(300)
    wait(lambda: panel.result is not None, "the section")
    assert panel.domain_axes.isVisible()
    panel.domain_axes.click()
    driver.pause(300)
    wait(lambda: panel.result is not None and panel.result.figures.domains, "both axes")
    shown = {each.name: each for each in panel.result.figures.domains}
    assert not panel.direction.isEnabled()
    for name, own in shown.items():
        assert own.words in panel.message.text(), name
    driver.keep_picture(window, "section_of_domains")
    QTest.mouseClick(panel.copy, LEFT, NONE, panel.copy.rect().center())
    program, *words = shlex.split(QGuiApplication.clipboard().text())
    assert program == "vomstudio"
    capfd.readouterr()
    assert main([*words, "-o", str(tmp_path / "s.csv"), "--json"]) == 0
    told = json.loads(capfd.readouterr().out)["domains"]
    assert {each["name"] for each in told} == set(shown)
    for each in told:
        own = shown[each["name"]]
        assert each["trend_deg"] == pytest.approx(own.trend_deg, abs=1e-6)
        assert each["plunge_deg"] == pytest.approx(own.plunge_deg, abs=1e-6)


@pytest.mark.full
def test_the_dialog_of_orthophotos_offers_each_domain(window, parted) -> None:
    window.actions_table.run("orthophoto")
    driver.pause(500)
    dialog = next(w for w in QApplication.topLevelWidgets() if isinstance(w, OrthoDialog))
    known = domain_names(window.studio.session.records)
    assert [dialog.domain.itemData(i) for i in range(dialog.domain.count())] == [None, *known]
    dialog.domain.setCurrentIndex(2)
    dialog.copy_command()
    words = shlex.split(QGuiApplication.clipboard().text())
    assert words[words.index("--domain") + 1] == known[1]
    dialog.close()
