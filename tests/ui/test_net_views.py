"""What the dock of the net can show and do beside the net itself, with mouse and keys."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tests import driver
from tests.geology.samples import fisher_sample
from tests.messages import figures, shown_codes, shown_values
from tests.samples import ZIGZAG
from tests.ui.conftest import add_bed, add_cliff
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import (
    Line,
    Plane,
    angle_between_lines,
    normals_to_planes,
    planes_to_poles,
)
from vomstudio.products.net.rose import TITLES
from vomstudio.project import edits
from vomstudio.project.kinds.lineation import Lineation
from vomstudio.project.kinds.reading import Reading
from vomstudio.studio.tools.interaction_types import Button, Hit, Pointer, PointerEvent
from vomstudio.studio.tools.trace import TraceTool
from vomstudio.ui.commands.net import export_net
from vomstudio.ui.dialogs.figure_style_dialog import FigureStyleDialog
from vomstudio.ui.dialogs.net_drawing_dialog import NetDrawingDialog

LEFT, NONE = driver.LEFT, driver.NONE


@pytest.fixture
def net(window, studio):
    """A folded bedding and a cluster of joints, all read on a compass."""
    add_cliff(studio)
    window._add_stereonet()
    axis = Line(40, 20).vector()
    first = np.cross(axis, [0.0, 0.0, 1.0])
    first /= np.linalg.norm(first)
    turn = np.radians(np.arange(0, 180, 12))[:, None]
    beds = normals_to_planes(np.cos(turn) * first + np.sin(turn) * np.cross(axis, first))
    rng = np.random.default_rng(4)
    joints = normals_to_planes(fisher_sample(rng, 30, 60.0, planes_to_poles(120, 60)))
    readings = [
        Reading(f"{name}{i}", f"{name}{i}", kind, "plane", float(a), float(d))
        for name, kind, found in (("B", "bedding", beds), ("J", "joint", joints))
        for i, (a, d) in enumerate(zip(*found[:2], strict=True))
    ]
    assert studio.attempt(edits.add_readings, readings)
    drawn(window)
    return window.net


def drawn(window) -> None:
    net = window.net

    def shown() -> bool:
        has_net = net.artists is not None or net.roses is not None
        return has_net or net.view_settings.view != "net"

    driver.wait(lambda: shown() and net.is_up_to_date, "the net")
    QApplication.processEvents()


def show_view(window, title: str) -> None:
    """Choose it in the box as a person does, with the keyboard."""
    box = window.net.view
    row = box.findText(title)
    assert row >= 0
    box.setCurrentIndex(row)
    box.activated.emit(row)
    drawn(window)


def ask(window, *names: str) -> None:
    for name in names:
        window.net.menu_button.overlays[name].trigger()
    drawn(window)


def words(net) -> str:
    return " | ".join(text.get_text() for text in net.artists.axes.texts)


def typed(window) -> NetDrawingDialog:
    window.actions_table.all["type_on_net"].trigger()
    (dialog,) = [w for w in window.findChildren(NetDrawingDialog) if w.isVisible()]
    return dialog


def type_in(field, text: str) -> None:
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, text) if text else QTest.keyClick(field, Qt.Key.Key_Delete)


# --- roses and histograms --------------------------------------------------------------------
@pytest.mark.full
def test_click_on_a_rose_petal_selects_its_features(net, window, studio) -> None:
    show_view(window, "Rose of dip directions")
    assert net.artists is None
    roses = net.roses
    joint = next(name for name in roses.contents.roses if "Joint" in name)
    shares = roses.contents.roses[joint].shares
    place = int(np.argmax(shares))
    azimuth = np.radians((place + 0.5) * 10.0)
    x, y = roses.axes[joint].transData.transform((0.5 * np.sin(azimuth), 0.5 * np.cos(azimuth)))
    ratio = net.canvas.devicePixelRatioF()
    at = QPoint(round(x / ratio), round(net.canvas.height() - y / ratio))
    QTest.mouseClick(net.canvas, LEFT, NONE, at)
    chosen = [studio.records[id_] for id_ in studio.selection.ids]
    assert len(chosen) == round(shares[place] * 30)
    assert all(c.type_id == "joint" and c.azimuth_deg // 10 == place for c in chosen)
    driver.keep_picture(window, "net-rose")
    # Beside the petals nothing is counted.
    QTest.mouseClick(net.canvas, LEFT, NONE, QPoint(2, 2))
    assert studio.selection.ids == ()


@pytest.mark.full
def test_many_sets_share_one_rose_for_each_type(net, window, studio) -> None:
    read = studio.session.of(Reading)
    joints = [reading.id for reading in read if reading.type_id == "joint"]
    for number in range(5):
        assert studio.attempt(edits.set_attributes, joints[number::5], set_name=f"J{number}")
    show_view(window, "Rose of strikes")
    roses = net.roses.contents.roses
    assert len(roses) == len({reading.type_id for reading in read})
    assert sum(rose.n for rose in roses.values()) == len(read)
    assert net.roses.contents.notes


@pytest.mark.full
def test_rose_menu_sets_bins_and_weights(net, window, studio) -> None:
    add_bed(studio, "t1", "bed")
    show_view(window, "Rose of strikes")
    net.menu_button.widths[30.0].trigger()
    drawn(window)
    assert {r.bin_deg for r in net.roses.contents.roses.values()} == {30.0}
    net.menu_button.length_weight_action.trigger()
    drawn(window)
    # Only what was picked has a length.
    assert list(net.roses.contents.roses) == ["Bedding"]
    assert net.roses.contents.weight == "length"
    left_out = Finding("rose.left-out-by-length", count=45)
    assert net.roses.contents.notes == (left_out.message,)
    show_view(window, "Rose of trends")
    assert net.roses is None
    assert "lines" in net.canvas._message
    show_view(window, "Histogram of dips")
    driver.keep_picture(window, "net-histogram")
    net.menu_button.length_weight_action.trigger()
    drawn(window)
    assert all(len(r.shares) == 3 for r in net.roses.contents.roses.values())
    assert not net.contours.isEnabled()
    assert "net.only" in shown_codes(net.contours.toolTip())
    show_view(window, "Equal angle")
    assert net.artists.contents.projection == "angle"
    assert net.contours.isEnabled()


def test_roses_can_be_exported_and_copied(net, window, studio, tmp_path) -> None:
    show_view(window, "Histogram of dips")
    export_net(studio, net, tmp_path / "dips.svg")
    texts = ElementTree.parse(tmp_path / "dips.svg").getroot().itertext()
    _, bins, _ = next(text for text in texts if text.startswith(TITLES["dip"])).split("; ")
    assert figures(bins) == [10.0]
    QTest.mouseClick(net.copy, LEFT)
    assert QApplication.clipboard().image().width() > 1500


# --- what is drawn too -----------------------------------------------------------------------
def test_net_menu_options_are_drawn_and_saved(net, window, studio) -> None:
    window.actions_table.all["net_in_middle"].trigger()
    driver.pause(100)
    ask(window, "averages", "girdles", "maxima")
    said = words(net)
    assert "Joint (compass): n = 30," in said.replace("\n", " ")
    assert shown_values(said, "net.no-girdle")["sets"].startswith("Joint")
    assert "max " in said
    (girdle,) = net.artists.contents.user_circles
    assert angle_between_lines(girdle.axis, Line(40, 20)) < 1e-6
    assert studio.settings.net_asked == ["girdles", "maxima", "averages"]
    driver.keep_picture(window, "net-asked")
    ask(window, "averages", "girdles", "maxima", "intersections")
    assert net.artists.contents.user_circles == ()
    crossing = net.artists.contents.sets[-1]
    assert crossing.kind == "line"
    assert len(crossing) > 45 * 44 / 2 - 45


@pytest.mark.full
def test_net_shows_errors_of_all_planes_and_the_planes_of_striae(net, window, studio) -> None:
    add_bed(studio, "t1", "bed")
    ask(window, "errors")
    (ellipse,) = net.artists.contents.errors
    measured = studio.measured(["t1"])["t1"]
    assert ellipse.max_angle_deg == measured.total95_deg
    assert measured.total95_deg >= measured.fit.max_confidence95_deg
    fault = Reading("F", "F", "fault", "plane", 90.0, 60.0)
    assert studio.attempt(edits.add_readings, [fault])
    ends = ((0.0, 0.0, 0.0), (0.5, 0.0, -0.8660254))
    striae = Lineation("s", "s", "lineation", "m1", "0" * 64, ends, None, "F", "")
    assert studio.attempt(edits.add_features, [striae])
    ask(window, "slip planes")
    drawn(window)
    (circle,) = net.artists.contents.user_circles
    assert angle_between_lines(circle.axis, Plane(90, 60).pole()) < 1e-6


@pytest.mark.full
def test_hiding_a_set_in_the_menu_affects_only_the_net(net, window, studio) -> None:
    net.menu_button.menu().aboutToShow.emit()
    action = next(a for a in net.menu_button.sets.actions() if a.text().startswith("Joint"))
    action.trigger()
    drawn(window)
    assert [s.name for s in net.artists.contents.sets] == ["Bedding (compass)"]
    assert studio.visible("J0")
    net.menu_button.menu().aboutToShow.emit()
    next(a for a in net.menu_button.sets.actions() if a.text() == "Show all").trigger()
    drawn(window)
    assert len(net.artists.contents.sets) == 2


# --- typing ----------------------------------------------------------------------------------
@pytest.mark.full
def test_typed_circles_and_lines_are_drawn_while_typing(net, window) -> None:
    window.docks.move_to_center("stereonet")
    dialog = typed(window)
    type_in(dialog.fields["planes"], "120/60; 210/45")
    type_in(dialog.fields["cones"], "40/20/30")
    type_in(dialog.fields["slips"], "90/60/30")
    drawn(window)
    shown = net.artists.contents
    assert [c.half_angle_deg for c in shown.user_circles] == [90.0, 90.0, 30.0, 90.0]
    assert angle_between_lines(shown.user_circles[0].axis, Plane(120, 60).pole()) < 1e-6
    assert abs(Plane(90, 60).normal() @ shown.marks[0].line.vector()) < 1e-9
    assert "Cone 40/20/30" in words(net)
    driver.keep_picture(window, "net-typed")
    type_in(dialog.fields["cones"], "40/20/300")
    said = shown_values(dialog.message.text(), "angle.out-of-range")
    assert said == {"value": "300", "minimum": "0", "maximum": "90"}
    assert len(net.view_settings.circles) == 4
    QTest.mouseClick(dialog.clear_button, LEFT)
    assert net.view_settings.circles == ()
    assert dialog.message.text() == ""
    dialog.close()


@pytest.mark.full
def test_untilting_by_the_selected_plane_makes_it_horizontal(net, window, studio) -> None:
    dialog = typed(window)
    assert not dialog.use_plane_button.isEnabled()
    assert shown_codes(dialog.use_plane_button.toolTip()) == {"selection.no-plane"}
    studio.selection.set(["J0"])
    QTest.mouseClick(dialog.use_plane_button, LEFT)
    drawn(window)
    joints = next(s for s in net.artists.contents.sets if "Joint" in s.name)
    assert joints.angle_deg[joints.ids.index("J0")] < 0.1
    assert any("Untilted by" in note for note in net.artists.contents.notes)
    # What is selected on the turned net is still the feature.
    x, y = net.artists.centre_px
    ratio = net.canvas.devicePixelRatioF()
    QTest.mouseClick(
        net.canvas, LEFT, NONE, QPoint(round(x / ratio), round(net.canvas.height() - y / ratio))
    )
    assert studio.selection.ids == ("J0",)
    type_in(dialog.fields["untilt"], "")
    type_in(dialog.fields["rotate"], "0/90/30")
    drawn(window)
    turned = next(s for s in net.artists.contents.sets if "Joint" in s.name)
    here = (turned.azimuth_deg[0] - studio.records["J0"].azimuth_deg) % 360
    assert here == pytest.approx(30.0)
    dialog.close()


@pytest.mark.full
def test_typed_contour_levels_are_used(net, window, studio) -> None:
    net.contours.methods["linear_kamb"].trigger()
    dialog = typed(window)
    type_in(dialog.fields["levels"], "3, 7")
    drawn(window)
    assert net.artists.contents.contouring.levels == (3.0, 7.0)
    assert studio.settings.contour_levels == [3.0, 7.0]
    type_in(dialog.fields["levels"], "3, x")
    assert "levels" in dialog.message.text()
    dialog.close()


# --- picking ---------------------------------------------------------------------------------
@pytest.mark.full
def test_the_pole_and_cone_of_an_open_trace_move_while_it_is_picked(net, window, studio) -> None:
    studio.activate("trace")
    before = net.canvas.grab().toImage()
    artists = net.artists
    for i, point in enumerate(ZIGZAG):
        hit = Hit("m1", "face", 0, tuple(float(v) for v in point))
        studio.pointer(PointerEvent(Pointer.CLICK, 0, 0, Button.LEFT, hit=hit))
        live = artists.contents.live
        assert (live is not None) == (i >= 2)
    measured = studio.get_tool(TraceTool).measurement
    assert live.plane == measured.plane
    assert live.ellipse.max_angle_deg == measured.total95_deg
    assert net.canvas.grab().toImage() != before
    assert net.artists is artists  # not drawn anew
    driver.keep_picture(window, "net-live")
    studio.cancel_tool()
    assert artists.contents.live is None
    assert net.canvas.grab().toImage() == before


# --- figures and places ----------------------------------------------------------------------
@pytest.mark.full
def test_figure_style_is_previewed_and_saved(net, window, studio, tmp_path) -> None:
    window.actions_table.all["figure_style"].trigger()
    (dialog,) = window.findChildren(FigureStyleDialog)
    driver.wait(lambda: not dialog.preview.pixmap().isNull(), "the preview")
    before = dialog.preview.pixmap().toImage()
    box = dialog.options.fields["size_mm"]
    box.setFocus()
    box.selectAll()
    QTest.keyClicks(box, "90")
    QTest.keyClick(box, Qt.Key.Key_Return)
    grey_box = dialog.options.fields["grey"]
    QTest.mouseClick(grey_box, LEFT, pos=QPoint(8, grey_box.height() // 2))
    dialog.recolor(next(iter(dialog.colors)), "#102030")
    driver.wait(lambda: dialog.preview.pixmap().toImage() != before, "another preview")
    driver.keep_picture(dialog, "figure-style")
    assert studio.settings.figure_style["size_mm"] == "90"
    assert studio.settings.figure_style["grey"] is True
    export_net(studio, net, tmp_path / "net.svg")
    root = ElementTree.parse(tmp_path / "net.svg").getroot()
    assert float(root.attrib["width"].removesuffix("pt")) == pytest.approx(90 / 25.4 * 72)
    QTest.mouseClick(dialog.reset_button, LEFT)
    assert studio.settings.figure_style == {}
    dialog.close()


def test_net_can_replace_the_outcrop_and_return(net, window) -> None:
    window.workspaces.switch("results")
    # Sizes are kept once a workspace has stood for a moment.
    driver.pause(400)
    was = net.canvas.width() * net.canvas.height()
    window.actions_table.all["net_in_middle"].trigger()
    driver.pause(200)
    drawn(window)
    assert window.docks.center_page == "stereonet"
    assert not window._place.shows_outcrop
    assert net.canvas.width() * net.canvas.height() > 1.5 * was
    driver.keep_picture(window, "net-middle")
    window.actions_table.all["net_in_middle"].trigger()
    driver.pause(200)
    assert window._place.shows_outcrop
    assert window.docks.center_page == ""
    now = net.canvas.width() * net.canvas.height()
    assert now == pytest.approx(was, rel=0.1)


def test_returning_the_net_restores_all_dock_sizes(window, studio):
    add_cliff(studio)
    window.resize(1280, 720)
    QTest.keyClick(window, Qt.Key.Key_3, driver.CTRL)
    driver.pause(700)
    window.docks.bring_forward("fractures")
    driver.pause(100)
    front = [dock for dock in window.docks.values() if not dock.visibleRegion().isEmpty()]
    before = [dock.size() for dock in front]
    middle = window.centralWidget().size()
    for _ in range(2):
        window.actions_table.all["net_in_middle"].trigger()
        driver.pause(300)
    assert [dock.size() for dock in front] == before
    assert window.centralWidget().size() == middle
