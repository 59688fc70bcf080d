"""The stereonet dock under a real mouse, and the figure it exports."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ElementTree

import pytest
from matplotlib.contour import ContourSet
from matplotlib.lines import Line2D
from PIL import Image
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt, QTimer
from PySide6.QtGui import QMouseEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tests import driver
from tests.samples import ZIGZAG
from tests.ui.conftest import add_bed, add_cliff
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.frames import Frame
from vomstudio.products.net.contours import contour_groups
from vomstudio.project import edits
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.records import Feature, Model
from vomstudio.rendering.qt.painting import VERDICT_COLORS
from vomstudio.studio.surfaces.proposed_planes import ProposedPlanes, proposal_indices
from vomstudio.ui.base import theme
from vomstudio.ui.commands.net import export_net
from vomstudio.ui.panels.net import stereonet_panel
from vomstudio.ui.panels.net.contour_button import ContourButton
from vomstudio.ui.panels.net.feature_sets import UNASSIGNED_COLOR

LEFT, NONE, CTRL = driver.LEFT, driver.NONE, driver.CTRL


@pytest.fixture
def net(window, studio):
    """A net with four clusters of poles, one to each quarter of the compass."""
    add_cliff(studio)
    window._add_stereonet()
    window.docks.bring_forward("stereonet")
    readings = [
        Reading(
            f"{name}{i}",
            f"{name}{i}",
            "bedding" if name in "NS" else "joint",
            "plane",
            azimuth + 2.0 * i,
            45.0,
            set_name=name,
        )
        for name, azimuth in (("S", 0.0), ("W", 90.0), ("N", 180.0), ("E", 270.0))
        for i in range(3)
    ]
    assert studio.attempt(edits.add_readings, readings)
    drawn(window)
    return window.net


def colors_of(widget) -> set[str]:
    picture = widget.grab().toImage()
    return {
        picture.pixelColor(x, y).name()
        for x in range(picture.width())
        for y in range(picture.height())
    }


def drawn(window) -> None:
    net = window.net
    driver.wait(lambda: net.artists is not None and net.is_up_to_date, "the net")
    QApplication.processEvents()


def at(net, azimuth: float, radius: float = 0.54) -> QPoint:
    """Where a pole of that trend is on the canvas."""
    x, y = net.artists.centre_px
    r, a = radius * net.artists.radius_px, math.radians(azimuth)
    ratio = net.canvas.devicePixelRatioF()
    height = net.canvas.height()
    return QPoint(
        round((x + r * math.sin(a)) / ratio), round(height - (y + r * math.cos(a)) / ratio)
    )


def lasso(net, corners: list[QPoint], modifier=NONE) -> None:
    def send(kind, where, button, held):
        event = QMouseEvent(
            kind, QPointF(where), QPointF(net.canvas.mapToGlobal(where)), button, held, modifier
        )
        QApplication.sendEvent(net.canvas, event)

    send(QEvent.Type.MouseButtonPress, corners[0], LEFT, LEFT)
    for corner in corners[1:]:
        send(QEvent.Type.MouseMove, corner, Qt.MouseButton.NoButton, LEFT)
        QApplication.processEvents()
    send(QEvent.Type.MouseButtonRelease, corners[-1], LEFT, Qt.MouseButton.NoButton)


def around(net, azimuth: float) -> list[QPoint]:
    return [
        at(net, azimuth - 25, 0.3),
        at(net, azimuth + 30, 0.3),
        at(net, azimuth + 30, 0.8),
        at(net, azimuth - 25, 0.8),
    ]


def test_lasso_selects_the_poles_inside_and_ctrl_adds_to_the_selection(net, studio):
    lasso(net, around(net, 0))
    assert set(studio.selection.ids) == {"N0", "N1", "N2"}
    lasso(net, around(net, 90), CTRL)
    assert set(studio.selection.ids) == {"N0", "N1", "N2", "E0", "E1", "E2"}
    lasso(net, around(net, 180))
    assert set(studio.selection.ids) == {"S0", "S1", "S2"}
    lasso(net, [at(net, 45, 0.05), at(net, 45, 0.15), at(net, 60, 0.15)])
    assert studio.selection.ids == ()


def test_proposed_poles_can_be_picked_by_lasso_and_click(window, net, studio):
    planes = (Plane(225.0, 45.0), Plane(229.0, 45.0), Plane(315.0, 45.0))
    features = set(net.printable_contents().sets)
    picked = []
    studio.proposals_picked.connect(lambda ids, add: picked.append((set(ids), add)))
    studio.selection.set(["N0"])
    for selection in (frozenset(), frozenset({4})):
        studio.planes_proposed.emit(
            "facet", ProposedPlanes("facet", "Proposed facets", planes, (4, 5, 9), selection)
        )
        drawn(window)
        shown = net.artists.contents
        assert [(s.name, len(s)) for s in shown.sets if s.ids[0].startswith("proposal")] == [
            ("Proposed facets", 3)
        ]
        proposals = {i for i in shown.selected if i != "N0"}
        assert proposal_indices("facet", proposals) == sorted(selection)
        assert len(net.printable_contents().sets) == len(features)
        assert {s.color for s in shown.sets if s.ids[0].startswith("proposal")} == {
            UNASSIGNED_COLOR
        }
    lasso(net, around(net, 45))
    ids, is_adding = picked.pop()
    assert proposal_indices("facet", ids) == [4, 5]
    assert proposal_indices("other", ids) == []
    assert not is_adding
    QTest.mouseClick(net.canvas, LEFT, CTRL, at(net, 135))
    assert [(proposal_indices("facet", ids), add) for ids, add in picked] == [([9], True)]
    # Contours are those of the most frequent planes, here of the proposals.
    studio.planes_proposed.emit(
        "facet",
        ProposedPlanes(
            "facet",
            "Proposed facets",
            tuple(Plane(220.0 + i, 45.0) for i in range(30)),
            tuple(range(30)),
        ),
    )
    net.contours.methods["linear_kamb"].trigger()
    drawn(window)
    assert net.artists.contents.contouring.set_name == "Proposed facets"
    assert any(isinstance(each, ContourSet) for each in net.artists.axes.collections)
    (mode,) = contour_groups(net.artists.contents)
    assert len(mode[1]) == 30
    printed = net.printable_contents()
    assert len(printed.sets) == len(features)
    assert printed.contouring.set_name != "Proposed facets"
    studio.planes_proposed.emit("facet", None)
    drawn(window)
    assert not any(s.ids[0].startswith("proposal") for s in net.artists.contents.sets)


def test_click_selects_a_pole_and_a_click_on_the_empty_net_clears(net, studio):
    QTest.mouseClick(net.canvas, LEFT, NONE, at(net, 0))
    assert studio.selection.ids == ("N0",)
    QTest.mouseClick(net.canvas, LEFT, CTRL, at(net, 180))
    assert studio.selection.ids == ("N0", "S0")
    net._circles.setChecked(False)
    QTest.mouseClick(net.canvas, LEFT, NONE, at(net, 45, 0.1))
    assert studio.selection.ids == ()


def test_external_selection_is_emphasised_without_redrawing_the_net(net, studio):
    before, artists = net.canvas.grab().toImage(), net.artists
    draws: list[object] = []
    artists.axes.figure.canvas.mpl_connect("draw_event", draws.append)
    studio.selection.set(["E1"])
    driver.pause(50)
    assert net.artists is artists
    assert not draws
    assert net.canvas.grab().toImage() != before
    assert "E1" in net._corner_label.text()
    studio.selection.set(())
    driver.pause(50)
    assert net.canvas.grab().toImage() == before


def test_sets_of_a_type_share_its_colour_and_differ_in_symbol(window, net, studio):
    net.set_overlay(False)
    drawn(window)
    sets = net.contents().sets
    assert [(s.name, len(s)) for s in sets] == [
        ("Bedding: N (compass)", 3),
        ("Bedding: S (compass)", 3),
        ("Joint: E (compass)", 3),
        ("Joint: W (compass)", 3),
    ]
    style = net.artists.style
    assert sets[0].color == sets[1].color != sets[2].color
    assert len({s.marker for s in sets}) == 4
    assert style.symbol(sets[0])[:1] == style.symbol(sets[1])[:1] != style.symbol(sets[2])[:1]
    texts = [t.get_text() for t in net.artists.axes.texts]
    assert "Bedding: N (compass) (3)" in texts


def test_fold_axis_uses_picked_beds_of_all_sets_but_not_readings(net, window, studio):
    assert net.contents().fold is None
    for i, dip in enumerate((0.5, 1.0, -0.7)):
        add_bed(studio, f"b{i}", dip=dip, set_name="upper" if i else "lower")
    drawn(window)
    assert net.contents().fold is not None


def test_selected_circles_do_not_cross_the_fold_axis_label(net, window, studio):
    for i, dip in enumerate((0.5, 1.0, -0.7, -1.5)):
        add_bed(studio, f"b{i}", dip=dip)
    drawn(window)
    shown = net._net
    axes = shown.artists.axes
    (name,) = [t for t in axes.texts if re.match(r"β [\d.]+/", t.get_text())]
    box = name.get_window_extent()

    def ink() -> set[tuple[int, int]]:
        image, top = shown.image(), round(axes.figure.bbox.height - box.y1)
        return {
            (x, y)
            for x in range(round(box.x0), round(box.x1))
            for y in range(top, top + round(box.height))
            if max(image.pixelColor(x, y).getRgb()[:3]) < 90
        }

    before = ink()
    assert len(before) > 40
    # As a selected circle may run, wherever the name has found its place.
    ends = axes.transData.inverted().transform([(box.x0, box.y0), (box.x1, box.y1)])
    across = Line2D(*ends.T, linewidth=30.0, color="white")
    axes.add_line(across)
    shown.artists.emphasis.append(across)
    # All but a few points of curves that ran below the name, too.
    assert len(before - ink()) < 0.05 * len(before)


@pytest.mark.full
def test_great_circles_of_many_planes_are_omitted_with_a_note(net, window, studio):
    net.set_overlay(False)
    drawn(window)
    assert any(len(a) for a in net.artists.arcs)
    many = [Reading(f"x{i}", f"x{i}", "joint", "plane", float(i), 60.0) for i in range(60)]
    assert studio.attempt(edits.add_readings, many)
    drawn(window)
    assert not any(len(a) for a in net.artists.arcs)
    assert any("not drawn" in t.get_text() for t in net.artists.axes.texts)


def test_net_of_many_features_drawn_in_a_thread_is_identical(net, window, studio, monkeypatch):
    readings = [
        Reading(f"r{i}", f"r{i}", "joint", "plane", 0.61 * i, 20.0 + 0.1 * i) for i in range(500)
    ]
    assert studio.attempt(edits.add_readings, readings)
    drawn(window)
    shown = net.canvas.grab().toImage()
    monkeypatch.setattr(stereonet_panel, "_MAX_DIRECT_FEATURES", 1000)
    net.redraw()
    assert net.is_up_to_date
    assert net.canvas.grab().toImage() == shown
    monkeypatch.setattr(stereonet_panel, "_MAX_DIRECT_FEATURES", 100)
    net.redraw()
    # What is selected while it is being drawn is emphasised when it is there.
    assert not net.is_up_to_date
    studio.selection.set(["r7"])
    drawn(window)
    assert net.artists.contents.selected == {"r7"}
    assert net.canvas.grab().toImage() != shown


def test_net_keeps_its_aspect_ratio_while_resizing(net, window):
    window.docks["stereonet"].setFloating(True)
    window.docks["stereonet"].resize(400, 420)
    driver.pause(120)
    drawn(window)
    image = net.canvas._image
    for width, height in ((800, 420), (300, 600)):
        net.canvas.resize(width, height)
        place = net.canvas._image_rect(image)
        assert place.width() / place.height() == pytest.approx(image.width() / image.height())
        assert place.width() <= width + 1e-6
        assert place.height() <= height + 1e-6
    window.docks["stereonet"].setFloating(False)


@pytest.mark.full
def test_net_follows_the_theme_colours(net, window):
    def lightness() -> int:
        drawn(window)
        return net.canvas.grab().toImage().pixelColor(3, 3).lightness()

    try:
        for name, dark in (("dark", True), ("light", False), ("dark", True)):
            window.actions_table.run(f"theme_{name}")
            QApplication.processEvents()
            assert (lightness() < 128) == dark
    finally:
        theme.use("system")


def test_legend_does_not_overlap_the_net_at_any_dock_size(net, window):
    for width, height in ((230, 260), (330, 340), (330, 520), (700, 300)):
        window.docks["stereonet"].setFloating(True)
        window.docks["stereonet"].resize(width, height)
        driver.pause(30)
        net.redraw()
        x, y = net.artists.centre_px
        for box in net.artists.text_boxes:
            gap = math.hypot(max(box[0] - x, 0, x - box[2]), max(box[1] - y, 0, y - box[3]))
            assert gap > net.artists.radius_px, box
    window.docks["stereonet"].setFloating(False)


def test_hidden_net_is_not_drawn_until_shown(net, window, studio):
    window.docks.close_page("stereonet")
    driver.wait(lambda: net.canvas.visibleRegion().isEmpty(), "the net's end")
    artists = net.artists
    add_bed(studio, "b1")
    driver.pause(120)
    assert net.artists is artists
    window.docks.bring_forward("stereonet")
    driver.wait(lambda: net.artists is not artists, "the net's drawing")


def test_contours_are_off_by_default_and_remembered(net, window, studio):
    from matplotlib.contour import ContourSet

    def contours() -> list[ContourSet]:
        drawn(window)
        return [c for c in net.artists.axes.collections if isinstance(c, ContourSet)]

    assert not contours()
    assert not net.contours.isChecked()
    assert not net.contours.fill_action.isEnabled()
    net.contours.methods["linear_kamb"].trigger()
    assert [c.filled for c in contours()] == [True, False]
    assert net.contours.isChecked()
    assert studio.settings.contour == "linear_kamb"
    net.contours.fill_action.trigger()
    net.contours.each_set_action.trigger()
    # Bedding in two sets and joints in two: each has its own.
    assert [c.filled for c in contours()] == [False] * 4
    assert net.printable_contents().contour == "linear_kamb"
    assert net.printable_contents().contouring.each_set
    again = ContourButton(studio, net.view_settings, list)
    again.setParent(net)  # so that it goes with the window
    assert again.method == "linear_kamb"
    assert again.each_set_action.isChecked()
    assert not again.fill_action.isChecked()
    net.contours.methods[""].trigger()
    assert not contours()
    assert studio.settings.contour == ""
    studio.settings.contour = "heat"  # of a settings file written by hand
    again._show_settings()
    assert again.method is None
    assert again.methods[""].isChecked()


def test_one_type_is_contoured_until_another_or_all_are_chosen(net, window, studio):
    for i in range(4):
        assert studio.attempt(
            edits.add_readings, [Reading(f"j{i}", f"j{i}", "joint", "plane", 10.0 * i, 80.0)]
        )
    net.contours.methods["exponential_kamb"].trigger()

    def choices() -> dict[str, object]:
        net.contours.menu().aboutToShow.emit()
        return {action.text(): action for action in net.contours.subject.actions()}

    def contoured() -> tuple[str | None, bool]:
        drawn(window)
        words = [t.get_text() for t in net.artists.axes.texts]
        only = net.artists.contents.contouring.set_name
        return only, any(str(only or "all") in w for w in words if w.startswith("Contours"))

    # Ten joints and six beds.
    assert contoured() == ("Joint", True)
    assert list(choices())[1:-1] == ["Bedding", "Joint"]
    choices()["Bedding"].trigger()
    assert contoured() == ("Bedding", True)
    assert net.printable_contents().contouring.set_name == "Bedding"
    choices()["All sets"].trigger()
    assert contoured() == (None, True)
    studio.workspace.projects.new()
    assert net.view_settings.contoured_type == ""


def test_contour_smoothness_is_selected_and_remembered(net, window, studio):
    assert not net.contours.smoothness.isEnabled()
    net.contours.methods["exponential_kamb"].trigger()
    assert net.contours.smoothness.isEnabled()
    net.contours.sigmas[6.0].trigger()
    drawn(window)
    assert net.artists.contents.contouring.sigma == 6.0
    assert studio.settings.contour_sigma == 6.0
    net.contours.methods["schmidt"].trigger()
    assert not net.contours.smoothness.isEnabled()


def test_overlay_selection_label_does_not_overlap_net_labels(net, window, studio):
    for i, dip in enumerate((0.5, 1.0, -0.7, -1.5)):
        add_bed(studio, f"b{i}", dip=dip)
    window.docks.bring_forward("stereonet")
    for side, is_below in ((280, True), (420, False)):
        net.set_overlay(True)
        net.canvas.setFixedSize(side, side)
        drawn(window)
        studio.selection.set(["b1"])
        driver.pause(60)
        assert net.artists.contents.brief == is_below
        label = net._corner_label
        assert ("\n" in label.text()) != is_below
        at = label.geometry()
        assert (at.top() > side / 2) == is_below
        ratio = net.canvas.devicePixelRatioF()
        wide = label.fontMetrics().horizontalAdvance(max(label.text().split("\n"), key=len))
        for x0, y0, x1, y1 in net.artists.text_boxes:
            apart = x0 / ratio > at.left() + wide or x1 / ratio < at.left()
            top, bottom = side - y1 / ratio, side - y0 / ratio
            assert apart or top >= at.bottom() or bottom <= at.top()
    color = VERDICT_COLORS[studio.measured(["b1"])["b1"].verdict.quality]
    assert color in colors_of(net._corner_label)
    studio.selection.set(["b1", "b2"])
    assert color not in colors_of(net._corner_label)


def test_the_space_bar_opens_the_menu_of_contours(net, window):
    opened: list[bool] = []
    menu = net.contours.menu()
    menu.aboutToShow.connect(lambda: opened.append(True))
    QTimer.singleShot(200, menu.close)
    QTest.keyClick(net.contours, Qt.Key.Key_Space)
    assert opened
    assert not net.contours.isChecked()


@pytest.mark.full
def test_contours_of_many_features_drawn_in_a_thread_are_identical(
    net, window, studio, monkeypatch
):
    readings = [
        Reading(f"r{i}", f"r{i}", "joint", "plane", 0.31 * i, 20.0 + 0.1 * i) for i in range(500)
    ]
    assert studio.attempt(edits.add_readings, readings)
    net.contours.methods["exponential_kamb"].trigger()
    drawn(window)
    shown = net.canvas.grab().toImage()
    monkeypatch.setattr(stereonet_panel, "_MAX_DIRECT_FEATURES", 1000)
    net.redraw()
    assert net.is_up_to_date
    assert net.canvas.grab().toImage() == shown


@pytest.mark.full
def test_figure_is_copied_as_svg_and_image(net, window, studio):
    window.actions_table.all["copy_net"].trigger()
    mime = QApplication.clipboard().mimeData()
    root = ElementTree.fromstring(bytes(mime.data("image/svg+xml").data()))
    assert root.tag.endswith("svg")
    assert mime.hasImage()
    assert QApplication.clipboard().image().width() > 1500


# --- export ----------------------------------------------------------------------------------
@pytest.mark.full
def test_exported_figure_is_readable_and_describes_its_contents(net, window, studio, tmp_path):
    studio.save_as(tmp_path / "cliff.vom")
    studio.selection.set(["N0"])
    for ending in ("svg", "pdf", "png"):
        export_net(studio, window.net, tmp_path / f"net.{ending}")
    root = ElementTree.parse(tmp_path / "net.svg").getroot()
    assert root.tag.endswith("svg")
    assert float(root.attrib["width"].removesuffix("pt")) == pytest.approx(170 / 25.4 * 72)
    words = " ".join(root.itertext())
    for word in (
        "cliff",
        "Bedding: N (compass), poles (n = 3)",
        "Equal area, lower hemisphere",
        "local, north known",
    ):
        assert word in words
    assert (tmp_path / "net.pdf").read_bytes()[:5] == b"%PDF-"
    with Image.open(tmp_path / "net.png") as picture:
        assert picture.size == (round(170 / 25.4 * 300 - 0.5), round(115 / 25.4 * 300 - 0.5))
        assert picture.convert("RGB").getpixel((3, 3)) == (255, 255, 255)


def test_unwritable_export_target_is_reported_and_leaves_no_file(net, window, studio, tmp_path):
    export_net(studio, window.net, tmp_path / "missing" / "net.svg")
    assert "missing" in studio.notices[-1].text
    assert studio.notices[-1].level == "error"
    (tmp_path / "net.png").mkdir()
    export_net(studio, window.net, tmp_path / "net.png")
    assert "folder" in studio.notices[-1].text
    assert [p.name for p in tmp_path.iterdir() if "net" in p.name] == ["net.png"]


@pytest.mark.full
def test_north_is_not_drawn_if_unknown(net, window, studio, tmp_path):
    """A model without north has a y axis; compass readings know theirs."""
    undeclared = Model("m2", "rock", "rock.obj", "mesh", "1" * 64, Frame("undeclared"))
    assert studio.attempt(edits.add_model, undeclared)
    drawn(window)
    assert net.contents().north, "all that is shown are readings"
    points = tuple((x, y, 0.5 * x + z) for x, y, z in ZIGZAG)
    assert studio.attempt(edits.add_trace, Trace("t1", "", "bedding", "m2", "1" * 64, points))
    drawn(window)
    assert not net.contents().north
    assert any("Local frame" in note for note in net.printable_contents().notes)
    target = tmp_path / "net.svg"
    export_net(studio, net, target)
    words = "".join(ElementTree.parse(target).getroot().itertext())
    assert "Local frame" in words
    net.view_settings.show_view("strike", "area")
    found = net.rose_contents()
    assert not found.north
    assert any("Local frame" in note for note in found.notes)
    studio.undo()
    assert net.rose_contents().north
    net.view_settings.show_view("net", "area")
    assert studio.attempt(edits.delete, [r.id for r in studio.session.of(Feature)])
    drawn(window)
    assert not net.artists.contents.north, "an empty net has the axes of the outcrop"
    assert studio.attempt(edits.declare_frame, "m2", Frame("crs", "EPSG:32633", 1.0))
    driver.wait(lambda: net.artists.contents.north, "a net drawn with north")
