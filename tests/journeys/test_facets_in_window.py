"""Facets proposed on the sample, tried on a part, looked at, accepted, rejected, taken back."""

from __future__ import annotations

import csv
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLabel

from tests import driver
from tests.extraction.test_facets_with_levels import at_two_levels
from tests.messages import by_code, figures, shown_codes
from vomstudio.core.paths import resource
from vomstudio.geology.orientation import planes_to_normals
from vomstudio.geometry.patches import has_id
from vomstudio.project.kinds.patch import Patch
from vomstudio.studio.surfaces.facet_proposals import Proposals
from vomstudio.ui.base import theme
from vomstudio.ui.panels.surface.facet_texts import share_text
from vomstudio.ui.panels.surface.facets_panel import FacetsPanel


@pytest.fixture
def panel(window) -> FacetsPanel:
    window.open_path(resource("sample", "sample.obj"))
    driver.settled(window)
    window.actions_table.run("propose_facets")
    made = window.findChild(FacetsPanel)
    driver.wait(made.isVisible, "the panel")
    driver.settled(window)
    driver.wait(made.start.isEnabled, "the model")
    return made


def scale(window):
    return window.viewport.display.color_scale(next(iter(window.studio.models)))


def find(window, panel) -> None:
    driver.click(panel.start, panel.start.rect().center())
    assert panel.start.text() == "Stop"
    driver.wait(lambda: panel._facets.proposals is not None, "the facets", 120.0)
    driver.wait(lambda: scale(window) is not None, "the colours", 60.0)
    driver.settled(window)


def patches(window) -> list[Patch]:
    return window.studio.session.of(Patch)


@pytest.mark.full
def test_facets_are_found_inspected_accepted_and_undone(window, panel) -> None:
    studio = window.studio
    before = dict(studio.records)
    mode = studio.display.mode
    find(window, panel)
    assert dict(studio.records) == before
    said = panel.message.text()
    found = panel._facets.proposals
    assert figures(panel.summary.text())[0] == len(panel._facets.open_rows)
    shares = [100.0 * found.share(each) for each in (panel._facets.open_rows, ())]
    assert figures(said)[:2] == pytest.approx(shares, abs=0.5)
    # The most doubtful stand first.
    rows = [values for (values, _) in panel.table.numbers.rows]
    assert [row[0] for row in rows] == sorted((row[0] for row in rows), reverse=True)
    assert len(rows) > 100
    driver.keep_picture(window, "facets-label")
    for key in ("dip direction", "error", "exposure"):
        panel.colours.setCurrentIndex(panel.colours.findData(key))
        panel.colours.activated.emit(panel.colours.currentIndex())
        title = "exposure" if key == "exposure" else key.replace("error", "95 % error")
        driver.wait(lambda t=title: (s := scale(window)) and t in s.title, f"colours of {key}")
        driver.settled(window)
        driver.keep_picture(window, f"facets-{key}")

    # The least doubtful one, by its row and the keyboard.
    panel.table.setFocus()
    last = panel.table.numbers.rowCount() - 1
    panel.table.selectRow(last)
    driver.settled(window)
    driver.keep_picture(window, "facets-chosen")
    number = int(panel.table.numbers.rows[last][0][4])
    plane = panel.table.numbers.rows[last][0][2]
    QTest.keyClick(panel.table, Qt.Key.Key_Return)
    (patch,) = patches(window)
    found = panel._facets.proposals
    assert patch.runs == found.patches[number - 1].runs
    assert "Angle 20°" in patch.notes
    assert "Proposed" in patch.notes
    measured = studio.measured([patch.id])[patch.id]
    assert measured.verdict.quality == "good"
    assert plane == measured.attitude()
    assert number - 1 not in panel._facets.open_rows
    left = len(panel._facets.open_rows)
    QTest.keyClick(panel.table, Qt.Key.Key_Delete)
    assert len(panel._facets.open_rows) == left - 1
    assert len(patches(window)) == 1

    # All others, as one step that undo takes back.
    panel.colours.setCurrentIndex(panel.colours.findData("label"))
    panel.colours.activated.emit(panel.colours.currentIndex())
    left -= 1
    measured = [found.measured[row] for row in sorted(panel._facets.open_rows)]
    driver.click(panel.accept_all, panel.accept_all.rect().center())
    assert len(patches(window)) == left + 1
    # The window does not wait until hundreds are measured once more.
    others = [p.id for p in patches(window) if p.id != patch.id]
    assert [*map(id, studio.measured(others).values())] == [*map(id, measured)]
    assert not panel._facets.open_rows
    assert not panel.accept_all.isEnabled()
    assert "facets.none-open" in shown_codes(panel.accept_all.toolTip())
    # Nothing is left to be coloured.
    driver.wait(lambda: scale(window) is None, "the photo texture once all is decided")
    studio.undo()
    assert len(patches(window)) == 1
    # What was taken back is to be decided upon again.
    assert len(panel._facets.open_rows) == left
    assert panel.table.numbers.rowCount() == left
    driver.wait(lambda: scale(window) is not None, "the colours of what is open again")
    studio.redo()
    assert len(patches(window)) == left + 1
    assert not panel._facets.open_rows
    driver.click(panel.reject_all, panel.reject_all.rect().center())
    assert panel._facets.proposals is None
    assert studio.display.mode == mode
    driver.wait(lambda: scale(window) is None, "the photo texture")


@pytest.mark.full
def test_clicking_the_outcrop_selects_its_facet(window, panel) -> None:
    find(window, panel)
    # What accepting makes of facets is said above the buttons that do it.
    assert panel.type.mapTo(panel, QPoint()).y() < panel.accept_all.mapTo(panel, QPoint()).y()
    found = panel._facets.proposals
    # The largest, where its middle lies on it.
    model = driver.model(window)
    for row, patch in enumerate(found.patches):
        opened = window.studio.models[model.id]
        vertices = np.flatnonzero(found.label == row)
        place = opened.data.vertices[vertices].mean(axis=0)
        at = driver.pixel(window, place)
        hit = window.viewport.pick(at.x(), at.y())
        if hit is not None and has_id(patch.runs, hit.index):
            driver.click(window.viewport, at)
            break
    driver.wait(lambda: panel._selection() == [row], "the row")
    assert panel.accept.isEnabled()

    def row_in_sight() -> bool:
        at = panel.table.visualRect(panel.table.currentIndex()).center()
        return panel.table.viewport().visibleRegion().contains(at)

    driver.wait(row_in_sight, "the row in sight")


def test_accepting_a_facet_keeps_the_colors_of_the_others(window, panel) -> None:
    find(window, panel)
    before = {c.code: c.rgb for c in scale(window).categories}
    table = panel.table
    at = table.visualRect(table.model().index(0, 0)).center()
    QTest.mouseClick(table.viewport(), driver.LEFT, driver.NONE, at)
    QTest.keyClick(table, Qt.Key.Key_Return)
    driver.wait(lambda: len(patches(window)) == 1, "the accepted facet")
    driver.wait(
        lambda: (now := scale(window)) is not None and len(now.categories) < len(before),
        "the outcrop without it",
    )
    after = {c.code: c.rgb for c in scale(window).categories}
    assert len(after) == len(before) - 1
    assert after.items() <= before.items()


@pytest.mark.full
def test_facets_are_filtered_and_picked_on_the_net(window, panel) -> None:
    window.studio.set_next_type("joint", "")
    find(window, panel)
    proposals, net = panel._facets.proposals, window.net
    assert panel.type.currentData() == "joint"
    driver.wait(
        lambda: (
            net.is_up_to_date
            and net.artists is not None
            and any(s.name == panel.table.accessibleName() for s in net.artists.contents.sets)
        ),
        "the facets on the net",
    )
    driver.settled(window)
    driver.keep_picture(window, "facets-on-net")
    panel.filter.setText("quality:good dip>60 area>1m2")
    driver.wait(
        lambda: len(panel.listed_indices()) < len(panel._facets.open_rows), "the filtered list"
    )
    listed_indices = panel.listed_indices()
    assert listed_indices
    for row in listed_indices:
        measured = proposals.measured[row]
        assert measured.verdict.quality == "good"
        assert measured.plane.dip_deg > 60.0
        assert measured.area_m2 > 1.0
    # The order that the user selected survives another list.
    panel.table.sortByColumn(3, Qt.SortOrder.AscendingOrder)
    panel.filter.setText("quality:good dip>60")
    areas = [values[3] for values, _ in panel.table.numbers.rows]
    assert areas == sorted(areas)
    driver.wait(
        lambda: net.is_up_to_date and len(net.artists.contents.sets[-1]) == len(areas), "the poles"
    )
    # A click on a pole selects its row, which is highlighted in both views.
    last = net.artists.contents.sets[-1]
    pole = net.artists.positions[-1][0]
    x, y = net.artists.centre_px + net.artists.radius_px * pole
    window.studio.proposals_picked.emit(last.ids[:2], False)
    assert len(panel._selection()) == 2
    assert net.artists.feature_at(x, y, 4.0) in last.ids
    count = len(panel.listed_indices())
    driver.click(panel.accept_all, panel.accept_all.rect().center())
    assert len(patches(window)) == count
    assert {patch.type_id for patch in patches(window)} == {"joint"}
    panel.filter.clear()
    assert (
        len(panel.listed_indices())
        == len(panel._facets.open_rows)
        == len(proposals.patches) - count
    )
    assert panel._selection() == []

    # All selected facets are highlighted.
    previews = []
    window.studio.preview.connect(previews.append)
    sizes = []
    # The largest facets are listed last and have the lowest numbers, which other searches use, too.
    rows = range(len(panel.listed_indices()) - 2, len(panel.listed_indices()))
    for row in rows:
        panel.table.selectRow(row)
        sizes.append(len(previews[-1].area.corners))
    selection = {panel._index(row) for row in rows}
    panel.table.select_rows(lambda values: values[-1] - 1 in selection)
    assert set(panel._selection()) == selection
    assert len(previews[-1].area.corners) == sum(sizes)
    # A second search gives other facets, of which none is selected; the order remains.
    panel.limits.fields["angle_deg"].setValue(12.0)
    driver.click(panel.start, panel.start.rect().center())
    driver.wait(lambda: panel._facets.proposals is not proposals, "other facets", 120.0)
    driver.wait(lambda: not panel._facets.running, "the end of the search", 60.0)
    assert panel._facets.proposals.options.angle_deg == 12.0
    assert selection <= set(panel.listed_indices())
    assert panel._selection() == []
    assert previews[-1] is None
    assert panel.table.horizontalHeader().sortIndicatorSection() == 3
    areas = [values[3] for values, _ in panel.table.numbers.rows]
    assert len(areas) > 2
    assert areas == sorted(areas)


@pytest.mark.full
def test_doubtful_facet_shows_its_reasons_and_an_unknown_area_is_a_dash(
    window, panel, monkeypatch
) -> None:
    find(window, panel)
    proposals, table = panel._facets.proposals, panel.table
    title = table.numbers.headerData(0, Qt.Orientation.Horizontal, Qt.ItemDataRole.DisplayRole)
    assert title == "Quality"
    table.selectRow(0)
    (index,) = panel._selection()
    verdict = proposals.measured[index].verdict
    assert verdict.quality != "good"
    assert panel.reason.isVisible()
    assert panel.reason.text() == " ".join(reason.message for reason in verdict.reasons)
    assert table.geometry().bottom() < panel.reason.geometry().top()
    good = next(i for i, m in enumerate(proposals.measured) if m.verdict.quality == "good")
    table.select_rows(lambda values: values[-1] - 1 == good)
    assert not panel.reason.isVisible()

    # The page is a long list if it is in the centre of the window.
    window.resize(1920, 1080)
    window.docks.toggle_center("surface")
    driver.pause(100)
    assert table.viewport().height() // table.rowHeight(0) >= 25
    window.docks.toggle_center("surface")

    # No exposed points: the area is unknown, not zero.
    unknown = replace(proposals.measured[good], area_m2=None)
    measured = (*proposals.measured[:good], unknown, *proposals.measured[good + 1 :])
    monkeypatch.setattr(Proposals, "get_exposed_area", lambda *_: 0.0)
    monkeypatch.setattr(panel._facets, "proposals", replace(proposals, measured=measured))
    panel._fill(panel._facets.proposals)
    row = next(row for row in range(table.numbers.rowCount()) if panel._index(row) == good)
    shown = table.numbers.index(row, 3).data(Qt.ItemDataRole.DisplayRole)
    assert figures(shown) == []
    others = [r for r in range(table.numbers.rowCount()) if r != row]
    assert figures(table.numbers.index(others[0], 3).data(Qt.ItemDataRole.DisplayRole))


@pytest.mark.full
def test_thresholds_can_be_previewed_on_the_visible_part(window, panel) -> None:
    # On its box: a click beside the words means nothing.
    driver.click(panel.preview_box, QPoint(8, panel.preview_box.rect().center().y()))
    driver.wait(lambda: panel._facets.proposals is not None, "facets of the part", 60.0)
    first = panel._facets.proposals
    assert not first.is_whole_model
    assert share_text(first, (), ()) in panel.message.text()
    panel.limits.fields["angle_deg"].setFocus()
    panel.limits.fields["angle_deg"].selectAll()
    QTest.keyClicks(panel.limits.fields["angle_deg"], "8")
    QTest.keyClick(panel.limits.fields["angle_deg"], Qt.Key.Key_Return)
    driver.wait(
        lambda: panel._facets.proposals is not first and not panel._facets.running,
        "other facets",
        60.0,
    )
    assert panel._facets.proposals.options.angle_deg == 8.0
    driver.settled(window)
    driver.keep_picture(window, "facets-part")
    # A threshold that nothing meets is no fault.
    panel.limits.fields["min_area_m2"].setValue(5000.0)
    driver.wait(lambda: panel._facets.proposals.result.count == 0, "no facets", 60.0)
    assert str(panel._facets.proposals.result.warnings[0]) in panel.message.text()
    assert not panel.accept_all.isEnabled()


@pytest.mark.full
def test_stopping_the_facet_search_changes_nothing(window, panel) -> None:
    before, start = dict(window.studio.records), panel.start.text()
    driver.click(panel.start, panel.start.rect().center())
    driver.click(panel.start, panel.start.rect().center())
    assert panel.start.text() == start
    assert "job.stopped" in shown_codes(panel.message.text())
    assert dict(window.studio.records) == before
    # And it can be asked again.
    find(window, panel)


@pytest.mark.full
def test_the_planes_of_the_sample_are_among_its_facets(window, panel) -> None:
    """Whose attitudes are known, since it was made of them."""
    with resource("sample", "truth.csv").open(newline="") as stream:
        rows = list(csv.DictReader(line for line in stream if not line.startswith("#")))
    find(window, panel)
    found = panel._facets.proposals
    normals = np.array([m.plane.normal() for m in found.measured])
    area = np.array([m.area_m2 for m in found.measured])
    joints = [row for row in rows if row["kind"] == "joint"]
    assert joints
    for row in joints:
        wanted = planes_to_normals(
            np.array([float(row["dip_direction_deg"])]), np.array([float(row["dip_deg"])])
        )[0]
        angle = np.degrees(np.arccos(np.minimum(np.abs(normals @ wanted), 1.0)))
        assert area[angle < 2.0].sum() > 1.0, row


@pytest.mark.full
def test_widgets_do_not_overlap_in_a_low_dock(window, panel) -> None:
    """All words of the page have the height that they need, and its rows stand below each other."""
    window.resize(1280, 700)
    find(window, panel)
    driver.wait(lambda: panel.table.numbers.rows, "the list")
    driver.pause(200)
    driver.keep_picture(window, "facets-low")
    rows = [panel.layout().itemAt(i).widget() for i in range(panel.layout().count())]
    shown = [row for row in rows if row is not None and row.isVisible()]
    for above, below in pairwise(shown):
        assert above.geometry().bottom() < below.geometry().top(), (above, below)
    for label in panel.findChildren(QLabel):
        if label.isVisible() and label.wordWrap():
            assert label.height() >= label.heightForWidth(label.width()), label.text()
    # The list says what a facet is called elsewhere, by the same sign.
    first = panel.table.model().index(0, 0)
    icon = first.data(Qt.ItemDataRole.DecorationRole).pixmap(16, 16).toImage()
    assert icon == theme.verdict_icon(first.data()).pixmap(16, 16).toImage()


@pytest.mark.full
def test_facet_spanning_two_levels_is_marked_doubtful_in_list_and_as_patch(
    window, tmp_path
) -> None:
    path = tmp_path / "steps.xyz"
    np.savetxt(path, at_two_levels(720, 3.0).points, fmt="%.6f")
    window.open_path(path)
    driver.settled(window)
    window.actions_table.run("propose_facets")
    panel = window.findChild(FacetsPanel)
    driver.settled(window)
    driver.wait(panel.start.isEnabled, "the model")
    find(window, panel)
    (proposed,) = panel._facets.proposals.measured
    driver.click(panel.accept_all, panel.accept_all.rect().center())
    (patch,) = patches(window)
    for measured in (proposed, window.studio.measured([patch.id])[patch.id]):
        assert measured.verdict.quality == "doubtful"
        assert "plane.levels" in by_code(measured.verdict.reasons)
