"""A straight trace on the net and in the properties: the band of planes, sets, a crossing trace."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtWidgets import QApplication

from tests import driver
from tests.messages import shown_values
from tests.ui.conftest import add_bed, add_cliff
from vomstudio.products.net.contents import NetBand, NetEllipse
from vomstudio.project import edits
from vomstudio.project.kinds.reading import Reading


def along(trend_deg: float, plunge_deg: float, seed: int) -> tuple:
    t, p = np.radians([trend_deg, plunge_deg])
    line = np.array([np.sin(t) * np.cos(p), np.cos(t) * np.cos(p), -np.sin(p)])
    noise = np.random.default_rng(seed).normal(0.0, 0.01, (30, 3))
    points = np.outer(np.linspace(-2.0, 2.0, 30), line) + noise
    return tuple(map(tuple, points.tolist()))


@pytest.fixture
def beds(window, studio):
    """A straight trace along strike, one down dip, and a set of readings that dips 90/40."""
    add_cliff(studio)
    window._add_stereonet()
    window.docks.bring_forward("stereonet")
    scatter = np.random.default_rng(3).normal(0.0, 5.0, (20, 2))
    readings = [
        Reading(f"r{i}", f"r{i}", "bedding", "plane", 90.0 + a, 40.0 + d, set_name="east")
        for i, (a, d) in enumerate(scatter.tolist())
    ]
    readings += [
        Reading(f"s{i}", f"s{i}", "joint", "plane", 180.0 + a, 60.0 + d, set_name="J")
        for i, (a, d) in enumerate(scatter.tolist())
    ]
    assert studio.attempt(edits.add_readings, readings)
    add_bed(studio, "t1", vertices=along(0.0, 0.0, 1))
    add_bed(studio, "t2", vertices=along(90.0, 40.0, 2))
    driver.wait(lambda: window.net.artists is not None and window.net.is_up_to_date, "the net")
    return window


@pytest.mark.full
def test_straight_trace_shows_its_band_and_the_compatible_sets(beds, studio):
    studio.selection.set(["t1"])
    QApplication.processEvents()
    (band,) = beds.net.contents().ellipses
    assert isinstance(band, NetBand)
    # Both edges run along the great circle whose pole is the trace.
    for edge in band.edges:
        assert np.abs(edge[:, 1]).max() < np.sin(np.radians(2.0))
    said = beds.properties._description_label.text()
    assert shown_values(said, "trace.straight")["line"] in ("000/00", "180/00")
    compatible = shown_values(said, "trace.compatible-sets")["sets"]
    assert "east" in compatible
    assert "J" not in compatible
    assert shown_values(said, "trace.plane-of-set")["set"] == "Bedding: east"
    beds.net.canvas.grab()
    driver.keep_picture(beds, "straight_trace")


def test_reading_has_no_band(beds, studio):
    studio.selection.set(["r1"])
    QApplication.processEvents()
    assert not any(isinstance(e, NetBand) for e in beds.net.contents().ellipses)
    assert "straight" not in beds.properties._description_label.text()


@pytest.mark.full
def test_curved_trace_keeps_its_ellipse(beds, studio):
    add_bed(studio, "t3")
    studio.selection.set(["t3"])
    QApplication.processEvents()
    (ellipse,) = beds.net.contents().ellipses
    assert isinstance(ellipse, NetEllipse)


def test_two_crossing_straight_traces_give_their_plane(beds, studio):
    studio.selection.set(["t1", "t2"])
    QApplication.processEvents()
    said = beds.properties._relation_label.text()
    assert "cross at 90" in said
    assert "/40.0 ± 0.20°" in said
