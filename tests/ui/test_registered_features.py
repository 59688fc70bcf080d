"""What the window shows of a registration's error: the panel of a feature and of a model, the net,
the fold axis."""

from __future__ import annotations

import pytest
from PySide6.QtWidgets import QLabel

from tests.messages import shown_codes, shown_values
from tests.project.test_bowed_models import registration
from tests.ui.conftest import add_bed, add_cliff
from vomstudio.products.net.contents import fold_ellipse
from vomstudio.project import catalogue, edits
from vomstudio.project.figures import Subject
from vomstudio.ui.panels.view.view_panel import ViewPanel


@pytest.fixture
def beds(studio):
    add_cliff(studio)
    for i, dip in enumerate((0.3, 0.6, 0.9, 1.3)):
        add_bed(studio, f"t{i}", f"B{i}", dip=dip)
    return [f"t{i}" for i in range(4)]


def register(studio, curvature: float = 0.0) -> None:
    assert studio.attempt(edits.set_registration, registration(curvature), ["m1"])


def row(window, title: str) -> str:
    fit = window.properties._fit
    return dict(zip([t.text() for t in fit._titles], [v.text() for v in fit._values], strict=True))[
        title
    ]


@pytest.mark.full
def test_panel_shows_the_registration_error_and_the_total_error(window, studio, beds):
    studio.selection.set(["t1"])
    assert row(window, "95 % error").endswith("–")
    register(studio)
    measured = studio.measured(["t1"])["t1"]
    subject = Subject(None, measured)
    shown = row(window, "95 % error")
    assert shown == (
        f"{catalogue.TOTAL_ERROR.text(subject)} / {catalogue.REGISTRATION_ERROR.text(subject)}"
    )
    assert measured.registration_error_deg > 0.0
    assert catalogue.TOTAL_ERROR.value(subject) > measured.registration_error_deg
    studio.undo()
    assert row(window, "95 % error").endswith("–")


def test_the_ellipse_about_the_selected_pole_grows_with_the_registration(window, studio, beds):
    window._add_stereonet()
    studio.selection.set(["t1"])
    (before,) = window.net.contents().ellipses
    register(studio)
    (ellipse,) = window.net.contents().ellipses
    measured = studio.measured(["t1"])["t1"]
    assert ellipse.max_angle_deg == pytest.approx(measured.total95_deg)
    turned = measured.registration_error_deg
    assert turned > 0.0
    assert ellipse.max_angle_deg**2 - before.max_angle_deg**2 == pytest.approx(turned**2)
    assert ellipse.min_angle_deg**2 - before.min_angle_deg**2 == pytest.approx(turned**2)
    fold = window.net.contents().fold
    assert fold.registration_error_deg > 0.0
    assert fold_ellipse(fold).max_angle_deg == fold.total.largest_deg > fold.max_confidence95_deg
    # Printed without what is selected; beta keeps its own.
    assert window.net.printable_contents().ellipses == ()


@pytest.mark.full
def test_model_panel_shows_the_quality_of_its_registration(window, studio, beds):
    register(studio, -0.001)
    studio.selection.set(["m1"])
    text = " ".join(label.text() for label in window.properties.findChildren(QLabel))
    assert "Weakest axis, 95 %: 090/00 ± 0.59°" in text
    axis = shown_values(text, "registration.weakest-axis")
    assert axis == {"error95_deg": "0.59", "trend": "090", "plunge_deg": "00"}
    assert "registration.bowed" in shown_codes(text)


@pytest.mark.full
def test_fold_axis_comparable_to_the_bowing_is_reported(window, studio):
    add_cliff(studio)
    for i, dip in enumerate((0.30, 0.31, 0.32)):
        add_bed(studio, f"t{i}", f"B{i}", dip=dip)
    panel = window.view_panel if hasattr(window, "view_panel") else window.findChild(ViewPanel)
    assert "fold.bowed" not in shown_codes(panel._verdict.toolTip())
    register(studio, -0.001)
    assert "fold.bowed" in shown_codes(panel._verdict.toolTip())
