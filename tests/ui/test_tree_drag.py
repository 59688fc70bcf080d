"""Features dragged in the tree with the pointer of the X server."""

from __future__ import annotations

import shutil
import subprocess

import pytest
from PySide6.QtGui import QGuiApplication

from tests.driver import pause, wait
from tests.ui.conftest import add_bed, add_cliff


@pytest.mark.full
def test_two_beds_are_dragged_onto_an_empty_type(window, studio):
    tool = shutil.which("xdotool")
    if tool is None or QGuiApplication.platformName() != "xcb":
        pytest.skip("a real drag needs xdotool and an X server")
    add_cliff(studio)
    for i in range(3):
        add_bed(studio, f"t{i}", f"B{i}")
    tree = window.tree
    tree.empty_types_button.click()
    studio.selection.set(["t0", "t2"])
    window.move(0, 0)
    pause(200)

    def place(id_: str) -> tuple[str, str]:
        view = tree.tree
        at = view.viewport().mapToGlobal(view.visualItemRect(tree._items[id_]).center())
        return str(at.x()), str(at.y())

    x, y = place("t2")
    there = place("fault")
    steps = [
        "mousemove",
        x,
        y,
        "mousedown",
        "1",
        "sleep",
        "0.1",
        "mousemove",
        x,
        str(int(y) + 14),
        "sleep",
        "0.2",
        "mousemove",
        *there,
        "sleep",
        "0.1",
        "mousemove",
        str(int(there[0]) + 2),
        there[1],
        "sleep",
        "0.4",
        "mouseup",
        "1",
    ]
    with subprocess.Popen([tool, *steps]) as hand:
        wait(lambda: hand.poll() is not None, "the drag", 10.0)
        wait(lambda: studio.records["t0"].type_id == "fault", "the drop", 10.0)
    assert [studio.records[f"t{i}"].type_id for i in range(3)] == ["fault", "bedding", "fault"]
    assert tree._items["t0"].parent() is tree._items["fault"]
    studio.undo()
    assert {studio.records[f"t{i}"].type_id for i in range(3)} == {"bedding"}, "one step"
