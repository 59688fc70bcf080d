"""A model of unknown scale has no metres: what panels say of lengths names units then."""

from __future__ import annotations

import re

import pytest
from PySide6.QtWidgets import QDoubleSpinBox, QLabel, QTableWidget

from tests import driver
from tests.messages import shown_values
from tests.samples import ZIGZAG
from tests.tiers import first_in_default_tier
from tests.ui.conftest import add_bed, add_cliff
from vomstudio.geometry.frames import Frame
from vomstudio.project import edits

METRES = re.compile(r"\(m\)|\(1σ, m\)| m\b|metres")
DOCKS = (
    "displacement",
    "three_points",
    "bed_log",
    "section",
    "elevation",
    "fractures",
    "looked_at",
    "display",
)


def said(window, dock: str) -> str:
    """Titles of rows and columns, units of fields, and sentences."""
    top = window.docks[dock].widget()
    texts = [label.text() for label in top.findChildren(QLabel)]
    texts += [field.suffix() for field in top.findChildren(QDoubleSpinBox)]
    for table in top.findChildren(QTableWidget):
        heads = (table.horizontalHeaderItem(i) for i in range(table.columnCount()))
        texts += [head.text() for head in heads if head is not None]
    return "\n".join(texts)


@pytest.mark.parametrize("dock", first_in_default_tier(DOCKS))
def test_no_panel_uses_metres_if_the_scale_is_unknown(window, studio, dock) -> None:
    add_cliff(studio, Frame("undeclared"))
    window.docks.bring_forward(dock)
    assert not METRES.search(said(window, dock)), said(window, dock)
    assert "units" in said(window, dock)
    frame = Frame("local", up_axis="z", unit_m=1.0)
    assert studio.attempt(edits.declare_frame, "m1", frame)
    assert "units" not in said(window, dock)
    assert METRES.search(said(window, dock))
    studio.undo()
    assert "units" in said(window, dock)


def test_displacement_is_shown_in_model_units(window, studio) -> None:
    add_cliff(studio, Frame("undeclared"))
    steep = tuple((0.02 * z + 0.01 * y, x, 3.0 * y + z) for x, y, z in ZIGZAG)
    add_bed(studio, "f1", "F", vertices=steep, type_id="fault")
    for id_, side in (("b1", -2.0), ("b2", 2.0)):
        low = [(x + side, y, 0.1 * x + side) for x, y, _ in ZIGZAG]
        add_bed(studio, id_, id_, vertices=tuple(low))
    panel = window.docks["displacement"].widget().widget()
    window.docks.bring_forward("displacement")
    studio.selection.set(["f1"])
    panel.fault.take_button.click()
    studio.selection.set(["b1", "b2"])
    panel.add.click()
    panel.update_widgets()
    driver.wait(lambda: panel.result is not None, "the displacement")
    assert shown_values(panel.message.text(), "displacement.separation")["unit"] == "units"
    assert " m " not in panel.message.text()


@pytest.mark.full
def test_misfit_of_copied_points_is_not_treated_as_a_known_error(window, studio) -> None:
    """The misfit of a few points is known as well as so few can tell it: Student and Fisher."""
    add_cliff(studio)
    five = ((0, 0, 0), (2, 0.3, 0.1), (4, 0, -0.1), (6, 0.4, 0.1), (8, 0.1, 0.0))
    add_bed(studio, "t1", vertices=five)
    window.docks.bring_forward("three_points")
    panel = window.docks["three_points"].widget().widget()
    studio.selection.set(["t1"])
    panel.take.click()
    errors_deg = []
    for sigma in (panel.options.value("sigma_m"), studio.measured(["t1"])["t1"].fit.rms):
        panel.options.show_value("sigma_m", sigma)
        panel.update_widgets()
        driver.wait(lambda: not panel._requests.is_waiting, "the plane")
        errors_deg.append(panel.result.plane.max_confidence95_deg)
    assert errors_deg[0] > 2.0 * errors_deg[1]
