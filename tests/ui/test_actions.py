"""Actions, palette, shortcuts, view direction, messages: what can be done, and what is said."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLineEdit, QToolButton

from tests import driver
from tests.messages import shown_codes
from tests.tiers import first_in_default_tier
from tests.ui.conftest import add_bed, add_cliff
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.frames import Frame
from vomstudio.project.kinds.trace import Trace
from vomstudio.studio.history import step_title
from vomstudio.studio.tools.trace import TraceTool
from vomstudio.ui.base.actions import strip_mnemonic
from vomstudio.ui.dialogs.command_palette import CommandPalette
from vomstudio.ui.panels.tools.trace import TracePanel


def beds(studio) -> None:
    """Two limbs of a fold whose axis plunges."""
    add_cliff(studio)
    for i, dip in enumerate((0.3, 0.8, 1.4)):
        add_bed(studio, f"t{i}", dip=dip)


# --- actions -------------------------------------------------------------------------------
def test_disabled_actions_of_an_empty_window_state_a_reason(window):
    disabled = [a for a in window.actions_table.all.values() if not a.isEnabled()]
    assert len(disabled) > 10
    for action in disabled:
        reason = action.toolTip().rpartition("Not now: ")[2]
        assert "Not now: " in action.toolTip(), action.objectName()
        assert len(reason) > 8
        assert reason[0].isupper(), "the reason is a sentence"
        assert reason.endswith(".")
    enabled = [a for a in window.actions_table.all.values() if a.isEnabled()]
    assert all("Not now" not in a.toolTip() for a in enabled)


def test_every_command_is_found_by_its_own_name(window):
    palette = CommandPalette(window, window.actions_table)
    for command in window.actions_table.commands():
        title = strip_mnemonic(command.text).rstrip("…")
        palette._search.setText(title)
        items = [palette._list.item(i) for i in range(palette._list.count())]
        first = next(item for item in items if item.text().startswith(title))
        assert items.index(first) == 0, title


def test_the_menus_have_fewer_than_90_entries(window):
    count, menus = 0, [action.menu() for action in window.menuBar().actions()]
    while menus:
        for action in menus.pop().actions():
            if action.menu() is not None:
                menus.append(action.menu())
            else:
                count += not action.isSeparator()
    assert 40 < count < 90


def test_every_menu_fits_a_laptop_screen(window):
    menus = [action.menu() for action in window.menuBar().actions()]
    inner = [action.menu() for menu in menus for action in menu.actions() if action.menu()]
    entries = {m.title(): sum(not a.isSeparator() for a in m.actions()) for m in menus + inner}
    # Each is some 22 pixels high, of 720.
    assert max(entries.values()) <= 32, entries


def test_menu_entries_have_unique_names(window):
    menus = [action.menu() for action in window.menuBar().actions()]
    inner = [action.menu() for menu in menus for action in menu.actions() if action.menu()]
    named = {}
    for menu in menus + inner:
        for action in menu.actions():
            if action.objectName() and not action.menu():
                named.setdefault(action.text().replace("&", ""), set()).add(action.objectName())
    twice = {text: names for text, names in named.items() if len(names) > 1}
    assert not twice


def test_shortcuts_are_unique(window):
    seen: dict[str, str] = {}
    for name, action in window.actions_table.all.items():
        for keys in action.shortcuts():
            assert seen.setdefault(keys.toString(), name) == name, keys.toString()


def test_tooltips_carry_the_shortcut(window):
    for action in window.actions_table.all.values():
        for keys in action.shortcuts():
            assert keys.toString(keys.SequenceFormat.NativeText) in action.toolTip()


def test_icon_buttons_have_a_tooltip(window):
    """What has only an icon has a tooltip and a name for screen readers."""
    for button in window.findChildren(QToolButton):
        if button.isVisible() and not button.text() and not button.objectName().startswith("qt_"):
            assert button.toolTip(), button.objectName() or button.parent()


def test_undo_and_redo_tooltips_name_the_step(window, studio):
    beds(studio)
    step = step_title(studio.undo_label)
    assert "B03" in step
    assert f"Undo {step}" in window.actions_table.all["undo"].toolTip()
    studio.undo()
    assert f"Redo {step}" in window.actions_table.all["redo"].toolTip()


def test_step_of_an_open_trace_is_undone_before_older_edits(window, studio):
    beds(studio)
    studio.activate("trace")
    studio.get_tool(TraceTool).continue_feature("t1")
    before = studio.records["t1"]
    studio.get_tool(TraceTool).delete_vertex(0)
    window.actions_table.run("undo")
    assert studio.get_tool(TraceTool).vertices == before.vertices
    assert len(studio.session.of(Trace)) == 3


# --- typing ---------------------------------------------------------------------------------
def test_letters_typed_into_a_field_trigger_no_command(window, studio):
    """Also the one-key commands of the viewport, and Delete, Backspace, Return, Home."""
    beds(studio)
    studio.selection.set(["t0"])
    before = dict(studio.records)
    for field in (
        window.table._filter,
        window.view_panel.direction_field,
        driver.tool_panel(window, TracePanel).set_name_edit,
    ):
        field.setFocus()
        field.clear()
        QTest.keyClicks(field, "tnfopb178")
        assert field.text() == "tnfopb178"
        QTest.keyClick(field, Qt.Key.Key_Home)
        QTest.keyClick(field, Qt.Key.Key_Delete)
        QTest.keyClick(field, Qt.Key.Key_End)
        QTest.keyClick(field, Qt.Key.Key_Backspace)
        assert field.text() == "nfopb17"
        QTest.keyClick(field, Qt.Key.Key_A, Qt.KeyboardModifier.ControlModifier)
        assert field.selectedText() == "nfopb17"
        QTest.keyClick(field, Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
        field.clear()
    assert studio.tool_name == "navigate"
    assert dict(studio.records) == before
    assert studio.selection.ids == ("t0",)


# --- palette ---------------------------------------------------------------------------------
def words_of(palette: CommandPalette) -> list[str]:
    return [palette._list.item(i).text() for i in range(palette._list.count())]


def test_a_command_is_found_by_its_words_and_run_by_return(window, studio, qtbot):
    beds(studio)
    palette = CommandPalette(window, window.actions_table)
    qtbot.addWidget(palette)
    palette.show()
    QTest.keyClicks(palette._search, "strike")
    assert palette.selected_command == "notation_strike"
    QTest.keyClick(palette._search, Qt.Key.Key_Return)
    assert palette.result() == 1
    window.actions_table.run(palette.selected_command)
    assert studio.settings.notation == "strike/dip"


@pytest.mark.full
def test_a_disabled_command_is_listed_with_its_reason_and_does_not_run(window, qtbot):
    palette = CommandPalette(window, window.actions_table)
    qtbot.addWidget(palette)
    palette.show()
    QTest.keyClicks(palette._search, "redo")
    assert "edit.nothing-to-redo" in shown_codes(words_of(palette)[0])
    assert palette.selected_command is None
    QTest.keyClick(palette._search, Qt.Key.Key_Return)
    assert palette.isVisible(), "no other command runs instead"
    palette._search.setText("looking north")
    assert palette._list.currentRow() == 0
    assert words_of(palette)[0].startswith("Looking north")
    palette._search.setText("no such thing at all")
    assert words_of(palette) == []
    assert palette._no_match_label.isVisible()
    QTest.keyClick(palette._search, Qt.Key.Key_Return)
    assert palette.selected_command is None


# --- view direction --------------------------------------------------------------------------
class Looks:
    def __init__(self, window) -> None:
        self.at: list[tuple[float, float]] = []
        window.view_panel._look_along = lambda trend, plunge: self.at.append((trend, plunge))


def direction(trend: float, plunge: float) -> np.ndarray:
    t, p = np.radians([trend, plunge])
    return np.array([np.sin(t) * np.cos(p), np.cos(t) * np.cos(p), -np.sin(p)])


@pytest.mark.parametrize(
    ("text", "trend", "plunge"),
    first_in_default_tier(
        [
            ("125/26", 125, 26),
            ("125 26", 125, 26),
            ("125,5/26,5", 125.5, 26.5),
            ("000/90", 0, 90),
            ("305/-26", 305, -26),
        ]
    ),
)
def test_a_direction_can_be_typed(window, studio, text, trend, plunge):
    looks = Looks(window)
    field = window.view_panel.direction_field
    field.setFocus()
    QTest.keyClicks(field, text)
    QTest.keyClick(field, Qt.Key.Key_Return)
    assert looks.at, window.message_bar.text
    assert looks.at[-1] == pytest.approx((trend, plunge))


@pytest.mark.parametrize("text", first_in_default_tier(["", "north", "125/126", "400/10/3"]))
def test_invalid_direction_is_rejected_with_a_message(window, studio, text):
    looks = Looks(window)
    window.view_panel.direction_field.setText(text)
    QTest.keyClick(window.view_panel.direction_field, Qt.Key.Key_Return)
    assert looks.at == []
    assert window.message_bar.isVisible()
    assert window.message_bar.text


def test_facing_a_plane_looks_against_its_upward_normal(window, studio):
    beds(studio)
    looks = Looks(window)
    for id_ in ("t0", "t2"):
        studio.selection.set([id_])
        window.actions_table.run("face_plane")
    # The action needs a model on the screen or not, but the button of the panel is the same call.
    if not looks.at:
        for id_ in ("t0", "t2"):
            studio.selection.set([id_])
            window.view_panel._buttons["facing"].click()
    for id_, (trend, plunge) in zip(("t0", "t2"), looks.at, strict=True):
        normal = np.asarray(studio.measured([id_])[id_].fit.normal)
        assert normal[2] > 0
        assert direction(trend, plunge) == pytest.approx(-normal, abs=1e-9)


def test_strike_and_dip_views_are_parallel_to_the_plane(window, studio):
    beds(studio)
    looks = Looks(window)
    studio.selection.set(["t1"])
    window.view_panel._buttons["strike"].click()
    window.view_panel._buttons["dip"].click()
    fit = studio.measured(["t1"])["t1"].fit
    plane = Plane.from_normal(fit.normal)
    for look in looks.at:
        assert abs(direction(*look) @ fit.normal) < 1e-9
    assert looks.at == [
        pytest.approx((plane.strike_rhr_deg, 0.0)),
        pytest.approx((plane.dip_direction_deg, plane.dip_deg)),
    ]


def test_beta_view_uses_the_bedding_only(window, studio):
    beds(studio)
    looks = Looks(window)
    window.view_panel._buttons["beta"].click()
    add_bed(studio, "f", dip=-3.0, type_id="fault")
    window.view_panel._buttons["beta"].click()
    assert looks.at[0] == looks.at[1]
    window.view_panel.selected_only_box.setChecked(True)
    assert not window.view_panel._buttons["beta"].isEnabled()
    tip = window.view_panel._buttons["beta"].toolTip()
    assert "fold.needs-selected-planes" in shown_codes(tip)


def test_flip_reverses_the_view_direction(window):
    looks = Looks(window)
    window.view_panel.show_direction(30.0, 12.0, True)
    window.view_panel._buttons["flip"].click()
    assert direction(*looks.at[0]) == pytest.approx(-direction(30.0, 12.0))
    assert "orthographic" in window.view_panel.current_label.text()


# --- messages and badges ------------------------------------------------------------------------
def test_messages_are_listed_and_the_newest_is_shown_above_the_view(window, studio):
    studio.warn("first thing")
    studio.warn("second thing", "error")
    assert window.message_bar.text == "second thing"
    assert window.message_bar.isVisible()
    texts = [window.messages.item(i).text() for i in range(window.messages.count())]
    assert [t.split("  ", 1)[1] for t in texts[-2:]] == ["first thing", "second thing"]


def test_the_frame_badge_warns_until_the_frame_is_declared(window, studio):
    add_cliff(studio, Frame())
    assert "not registered" in window.status_line._badge.text()
    add_bed(studio, "t1")
    studio.selection.set(["t1"])
    from vomstudio.project import edits

    studio.attempt(edits.declare_frame, "m1", Frame("crs", "EPSG:32633"))
    assert window.status_line._badge.text() == "EPSG:32633, grid north"
    studio.undo()
    studio.undo()
    assert "not registered" in window.status_line._badge.text()


@pytest.mark.parametrize(("sigma_deg", "is_amber"), [(7.0, False), (8.0, True)])
def test_frame_badge_is_amber_if_the_rotation_error_reaches_15_degrees(
    window, studio, sigma_deg, is_amber
):
    from vomstudio.geometry.registrations import Registration
    from vomstudio.project import edits
    from vomstudio.registration.summary import summarize_registration

    add_cliff(studio, Frame())
    record = Registration(
        "r1", "compass", "lines", Frame("local"), rotation_error_deg=(1.0, sigma_deg, 1.0)
    )
    studio.attempt(edits.set_registration, record, ["m1"])
    badge = window.status_line._badge
    assert ("#e69f00" in badge.styleSheet()) == is_amber
    assert (f"{1.96 * sigma_deg:.0f}°" in badge.text()) == is_amber
    # The same rule, and the same figure.
    assert list(studio.turn_findings()) == [
        each
        for each in summarize_registration(record).warnings
        if getattr(each, "code", "") == "registration.poor"
    ]
    assert [each.values["rotation95_deg"] for each in studio.turn_findings()] == (
        [pytest.approx(1.95996 * sigma_deg, rel=1e-4)] if is_amber else []
    )


def test_declaring_y_up_turns_every_plane_with_the_model(window, studio):
    from vomstudio.project import edits

    add_cliff(studio, Frame())
    add_bed(studio, "t1", dip=0.5)
    before = np.asarray(studio.measured(["t1"])["t1"].fit.normal)
    studio.attempt(edits.declare_frame, "m1", Frame("local", None, 1.0, "y"))
    after = np.asarray(studio.measured(["t1"])["t1"].fit.normal)
    turned = np.array([before[0], -before[2], before[1]])
    assert abs(after @ turned) == pytest.approx(1.0)


def test_status_line_shows_the_selection_count_and_the_tool_hint(window, studio):
    beds(studio)
    window.actions_table.run("select_all")
    assert window.status_line._selected.text() == "3 selected"
    hint = window.status_line._hint.text()
    assert hint.startswith("Navigate: ")
    # The key that adds a feature to the selection is named where the mouse is explained.
    assert "Ctrl+click" in hint
    studio.activate("trace")
    assert window.status_line._hint.text() == studio.tool.hint()


# --- panels ---------------------------------------------------------------------------------
def test_only_outcrop_hides_all_panels_and_restores_them(window):
    shown = {n for n, d in window.docks.items() if not d.isHidden()}
    assert shown
    window.actions_table.run("only_outcrop")
    assert all(d.isHidden() for d in window.docks.values())
    window.actions_table.run("only_outcrop")
    assert {n for n, d in window.docks.items() if not d.isHidden()} == shown


def test_the_outcrop_has_more_than_half_of_the_width(window):
    window.resize(1400, 900)
    QApplication.processEvents()
    window.workspaces.reset()
    QApplication.processEvents()
    assert window.centralWidget().width() >= 0.55 * window.width()


def test_no_text_is_smaller_than_nine_points(window):
    from PySide6.QtWidgets import QLabel

    for widget in (*window.findChildren(QLabel), *window.findChildren(QLineEdit)):
        size = widget.font().pointSizeF()
        assert size < 0 or size >= 9.0, widget.text()


def test_labels_are_not_cut_off_by_their_panels(window, studio):
    beds(studio)
    studio.selection.set(["t1"])
    QApplication.processEvents()
    for name, value in enumerate(window.properties._fit._values):
        if value.isVisible():
            assert value.width() >= value.sizeHint().width(), name


# --- end ------------------------------------------------------------------------------------
def test_a_window_that_is_closed_leaves_no_timer_no_thread_and_no_process(own_folders, qtbot):
    import subprocess
    import threading

    from PySide6.QtCore import QTimer

    from tests.driver import delete
    from tests.studio.jobs.odd_jobs import LEVITATE
    from vomstudio.io.settings import read_settings
    from vomstudio.studio.jobs.job import NoArguments
    from vomstudio.ui.shell.main_window import MainWindow

    threads = set(threading.enumerate())
    made = MainWindow(read_settings()[0])
    made.show()
    made._fill()
    jobs = made.studio.jobs
    failed = []
    jobs.submit(LEVITATE, NoArguments(), title="", on_done=print, on_failed=failed.append)
    qtbot.waitUntil(lambda: bool(failed), timeout=20_000)
    processes = [w._process for w in jobs.workers.values() if w._process]
    assert all(isinstance(p, subprocess.Popen) for p in processes)
    made.close()
    assert all(p.poll() is not None for p in processes)
    running = [
        t
        for t in (*made.findChildren(QTimer), *made.studio.findChildren(QTimer))
        if t.isActive() and not t.parent().inherits("QMenuBar")
    ]
    QTest.qWait(50)
    assert [t for t in running if t.isActive()] == []
    qtbot.waitUntil(lambda: not (set(threading.enumerate()) - threads), timeout=5000)
    delete(made)
