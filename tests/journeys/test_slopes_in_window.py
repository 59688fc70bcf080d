"""Kinematic analysis in the real window: a face typed and taken, modes and planes clicked, figure
and command taken away."""

from __future__ import annotations

import json
import shlex
import warnings
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QFileDialog

from tests import driver
from tests.driver import LEFT, NONE, wait
from tests.messages import shown_codes, shown_values
from vomstudio.cli.common.entry import main
from vomstudio.extraction.facet_options import FacetOptions
from vomstudio.project import edits
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.records import Model
from vomstudio.ui.panels.slopes.slopes_panel import SlopesPanel

FACE = (120.0, 70.0)


def attitudes() -> np.ndarray:
    """(60, 2) scattered dip directions and dips."""
    generator = np.random.default_rng(5)
    return np.column_stack([generator.uniform(0, 360, 60), generator.uniform(10, 88, 60)])


@pytest.fixture
def panel(window, outcrop, picks):
    """Sixty readings of joints, and three beds with errors."""
    model_id = driver.open_outcrop(window, outcrop)
    studio = window.studio
    model = studio.records[model_id]
    for name, points in list(picks.items())[:3]:
        vertices = tuple(tuple(p) for p in points.tolist())
        trace = Trace(name, name, "bedding", model_id, model.content_hash, vertices)
        assert studio.attempt(edits.add_trace, trace)
    joints = [
        Reading(f"J{i}", f"J{i}", "joint", "plane", azimuth, dip)
        for i, (azimuth, dip) in enumerate(attitudes().tolist())
    ]
    assert studio.attempt(edits.add_readings, joints)
    window.workspaces.switch("results")
    window.docks.bring_forward("slopes")
    made = window.findChild(SlopesPanel)
    wait(lambda: made.message.text(), "the panel")
    return made


def type_face(panel, text: str) -> None:
    panel.face.setFocus()
    panel.face.selectAll()
    QTest.keyClicks(panel.face, text)
    settle(panel)


def settle(panel) -> None:
    driver.pause(150)
    wait(lambda: not panel._requests.is_waiting and not panel._timer.isActive(), "the answer")


def choose(panel, text: str) -> None:
    panel.group_box.setCurrentIndex(panel.group_box.findText(text))
    panel.group_box.activated.emit(panel.group_box.currentIndex())
    settle(panel)


def cell(panel, row: int, column: int) -> str:
    return panel.results.table.item(row, column).text()


def click_mode(panel, row: int) -> None:
    table = panel.results.table
    QTest.mouseClick(
        table.viewport(), LEFT, NONE, table.visualItemRect(table.item(row, 0)).center()
    )


def click_plane(panel, row: int) -> str:
    planes = panel.results.planes
    item = planes.item(row)
    planes.scrollToItem(item)
    QTest.mouseClick(planes.viewport(), LEFT, NONE, planes.visualItemRect(item).center())
    return item.data(Qt.ItemDataRole.UserRole)


@pytest.mark.full
def test_failure_modes_match_mplstereonet_and_select_their_planes(window, panel) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import mplstereonet
        from mplstereonet import kinematic_analysis

    assert not panel.figure.isEnabled()
    assert shown_codes(panel.figure.toolTip()) == {"action.no-result"}
    choose(panel, "Joint")
    type_face(panel, f"{FACE[0]:g}/{FACE[1]:g}")
    azimuth, dip = attitudes().T
    asked = (FACE[0] - 90.0, FACE[1], 30.0, 20.0)
    for row, theirs in (
        (0, kinematic_analysis.PlanarSliding(*asked)),
        (2, kinematic_analysis.FlexuralToppling(*asked)),
    ):
        critical, _ = theirs.check_failure(azimuth - 90.0, dip.copy(), True)
        assert (cell(panel, row, 1), cell(panel, row, 2)) == (str(critical.sum()), "60")
        click_mode(panel, row)
        assert panel.results.critical_ids() == [f"J{i}" for i in np.flatnonzero(critical)]
        assert critical.any()
        clicked = click_plane(panel, 0)
        assert window.studio.selection.ids == (clicked,)
    first, second = np.triu_indices(60, 1)
    plunge, bearing = mplstereonet.plane_intersection(
        azimuth[first] - 90, dip[first], azimuth[second] - 90, dip[second]
    )
    wedges, _ = kinematic_analysis.WedgeSliding(*asked[:3]).check_failure(bearing, plunge)
    assert (cell(panel, 1, 1), cell(panel, 1, 2)) == (str(wedges.sum()), f"{60 * 59 // 2:,}")
    # In how many of them each plane takes part.
    members = np.bincount(np.concatenate([first[wedges], second[wedges]]), minlength=60)
    click_mode(panel, 1)
    assert set(panel.results.critical_ids()) == {f"J{i}" for i in np.flatnonzero(members)}
    # Planes of one set are nearly parallel, so their intersections are not counted.
    count_in_set = 30
    in_set = [f"J{i}" for i in range(count_in_set)]
    assert window.studio.attempt(edits.set_attributes, in_set, set_name="J1")
    settle(panel)
    is_counted = second >= count_in_set
    assert is_counted.sum() == 60 * 59 // 2 - 30 * 29 // 2
    assert cell(panel, 0, 2) == "60"
    assert cell(panel, 1, 1) == str(wedges[is_counted].sum())
    assert cell(panel, 1, 2) == cell(panel, 3, 2) == f"{is_counted.sum():,}"
    assert f"({members.max()})" in panel.results.planes.item(0).text()
    # Compass readings have no error: no probability is claimed.
    assert cell(panel, 0, 4) == "–"
    assert shown_values(panel.message.text(), "slope.no-errors") == {"n": "60"}
    driver.keep_picture(window, "slopes_panel")


@pytest.mark.full
def test_slope_face_is_taken_from_a_plane_and_clicks_keep_the_analysed_planes(
    window, panel
) -> None:
    studio = window.studio
    studio.selection.set([])
    assert not panel.take.isEnabled()
    assert shown_codes(panel.take.toolTip()) == {"selection.no-plane"}
    edits_before = len(studio.records)
    joints = [f"J{i}" for i in range(60)]
    studio.selection.set(["J3"])
    QTest.mouseClick(panel.take, LEFT, NONE, panel.take.rect().center())
    azimuth, dip = attitudes()[3]
    assert panel.face.text() == f"{azimuth:05.1f}/{dip:04.1f}"
    type_face(panel, "120/70")
    studio.selection.set(joints)
    choose(panel, "Selection")
    assert cell(panel, 0, 2) == "60"
    before = [cell(panel, row, 1) for row in range(5)]
    click_mode(panel, 0)
    click_plane(panel, 0)
    settle(panel)
    assert len(studio.selection.ids) == 1
    assert [cell(panel, row, 1) for row in range(5)] == before
    studio.selection.set(joints[:10])
    settle(panel)
    assert cell(panel, 0, 2) == "10"
    assert len(studio.records) == edits_before


@pytest.mark.full
def test_changing_the_notation_keeps_the_slope_face(window, panel) -> None:
    type_face(panel, "120/70")
    before = [cell(panel, row, 1) for row in range(5)]
    window.studio.settings.notation = "strike/dip"
    window.studio.keep_settings()
    settle(panel)
    assert panel.face.text() == "030/70 RHR"
    assert [cell(panel, row, 1) for row in range(5)] == before
    assert panel.result.request.face.plane.dip_direction_deg == 120.0


@pytest.mark.full
def test_invalid_slope_face_is_reported(window, panel) -> None:
    for typed, said in (
        ("120/0", "horizontal"),
        ("120/95", "90"),
        ("steep", "steep"),
        ("", "attitude of the face"),
    ):
        type_face(panel, "1")
        panel.face.clear()
        type_face(panel, typed)
        assert said in panel.message.text()
        assert panel.result is None
        assert not panel.copy.isEnabled()
    type_face(panel, "120/70")
    assert panel.result is not None
    friction = panel.angles.fields["friction_deg"]
    friction.setValue(80.0)
    settle(panel)
    assert "slope.gentle-face" in shown_codes(panel.message.text())
    friction.setValue(30.0)
    window.studio.selection.set([])
    choose(panel, "Selection")
    assert shown_codes(panel.message.text()) == {"selection.unsuitable"}


@pytest.mark.full
def test_slope_command_matches_the_panel_and_the_figure_is_written(
    window, panel, tmp_path, monkeypatch, capfd
) -> None:
    type_face(panel, "120/70")
    folder = tmp_path / "a folder"
    folder.mkdir()
    table, picture = folder / "planes.csv", folder / "slope.svg"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(table), ""))
    QTest.mouseClick(panel.copy, LEFT, NONE, panel.copy.rect().center())
    line = QGuiApplication.clipboard().text()
    assert "120/70" in line
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(picture), ""))
    QTest.mouseClick(panel.figure, LEFT, NONE, panel.figure.rect().center())
    wait(lambda: picture.exists() and panel.figure.isEnabled(), "the figure")
    text = picture.read_text()
    assert "Planar sliding" in text
    assert "120/70" in text

    capfd.readouterr()
    program, *arguments = shlex.split(line)
    assert program == "vomstudio"
    assert Path(arguments[1]) == table
    assert main([*arguments, "--json"]) == 0
    told = json.loads(capfd.readouterr().out)
    found = panel.result.analysis
    assert told["n"] == found.n == 63
    assert told["with_error"] == found.with_error == 3
    for mode in ("planar", "wedge", "flexural_toppling", "direct_toppling"):
        ours = getattr(found, mode)
        assert (told[mode]["critical"], told[mode]["of"]) == (ours.critical, ours.of)
        assert told[mode]["probability"] == pytest.approx(ours.probability, abs=1e-3)


@pytest.mark.full
def test_each_facet_is_analysed_as_a_slope_and_painted(
    window, panel, tmp_path, monkeypatch, capfd
) -> None:
    """Found, listed, painted in percent with a colour bar, and as a command; a rejected facet is
    one less."""
    studio = window.studio
    choose(panel, "Joint")
    panel.slope_kind.setCurrentIndex(1)
    panel.slope_kind.activated.emit(1)
    settle(panel)
    assert shown_codes(panel.message.text()) == {"action.no-proposals"}
    assert not panel.copy.isEnabled()
    model_id = studio.session.of(Model)[0].id
    studio.facets.find(model_id, FacetOptions(), None)
    wait(lambda: studio.facets.proposals is not None, "the facets", 120.0)
    settle(panel)
    found = panel.facets_result
    assert found is not None, panel.message.text()
    assert len(found.analysis.facets) == len(studio.facets.open_rows)
    assert panel.facets.table.numbers.rowCount() == len(found.analysis.facets)
    name = "planar sliding [%]"
    assert studio.display.styles[model_id].name == name
    assert studio.display.mode == "field"
    values = studio.models[model_id].data.fields[name]
    shares = {100.0 * f.planar.share for f in found.analysis.facets}
    shown = set(np.unique(values[np.isfinite(values)]).tolist())
    assert all(min(abs(v - s) for s in shares) < 1e-3 for v in shown)
    panel.facets.mode.setCurrentIndex(1)
    panel.facets.mode.activated.emit(1)
    assert studio.display.styles[model_id].name == "wedge sliding [%]"
    driver.pause(500)
    driver.keep_picture(window, "slope-facets")
    previews = []
    studio.preview.connect(previews.append)
    panel.facets.table.selectRow(0)
    assert previews[-1] is not None
    assert previews[-1].area is not None
    planes = tmp_path / "planes.csv"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(planes), ""))
    QTest.mouseClick(panel.copy, LEFT, NONE, panel.copy.rect().center())
    program, *arguments = shlex.split(QGuiApplication.clipboard().text())
    assert program == "vomstudio"
    capfd.readouterr()
    assert main([*arguments, "--json"]) == 0
    told = json.loads(capfd.readouterr().out)
    assert [f["id"] for f in told["facets"]] == [f.id for f in found.analysis.facets]
    for theirs, ours in zip(told["facets"], found.analysis.facets, strict=True):
        assert theirs["wedge"] == {
            "critical": ours.wedge.critical,
            "of": ours.wedge.of,
            "share": ours.wedge.share,
        }
        assert theirs["overhangs"] == ours.overhangs
    studio.facets.reject([int(found.analysis.facets[0].id)])
    settle(panel)
    assert len(panel.facets_result.analysis.facets) == len(found.analysis.facets) - 1
    button = panel.facets.reset_button
    QTest.mouseClick(button, LEFT, NONE, button.rect().center())
    assert studio.display.mode != "field"
    panel.slope_kind.setCurrentIndex(0)
    panel.slope_kind.activated.emit(0)
    settle(panel)
    type_face(panel, "120/70")
    assert panel.result is not None
    assert panel.results.isVisible()
