"""Striae on the window's net: arrows of the hanging wall's movement where it is known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from matplotlib.collections import PolyCollection

from tests import driver
from tests.tiers import first_in_default_tier
from tests.ui.conftest import add_cliff
from vomstudio.products.net.legend import SYMBOLS
from vomstudio.project import edits
from vomstudio.project.kinds.lineation import Lineation
from vomstudio.project.kinds.reading import Reading

EAST = (math.cos(math.radians(60.0)), 0.0, -math.sin(math.radians(60.0)))
"""Down the dip of a fault 090/60."""


@pytest.fixture
def net(window, studio):
    add_cliff(studio)
    window._add_stereonet()
    window.docks.bring_forward("stereonet")
    window.net.set_overlay(False)
    assert studio.attempt(edits.add_readings, [Reading("f", "F1", "fault", "plane", 90.0, 60.0)])
    return window.net


def add_striae(studio, id_: str, direction, slip: str = "") -> None:
    vertices = ((0.0, 0.0, 0.0), tuple(float(v) for v in direction))
    striae = Lineation(id_, id_, "lineation", "m1", "0" * 64, vertices, None, "f", slip)
    assert studio.attempt(edits.add_features, [striae])


def arrows(net) -> list[tuple[np.ndarray, np.ndarray]]:
    """Head and tail of each, on the net."""
    driver.wait(lambda: net.artists is not None and net.is_up_to_date, "the net")
    collections = net.artists.axes.collections
    paths = [p for c in collections if isinstance(c, PolyCollection) for p in c.get_paths()]
    return [(p.vertices[0], p.vertices[1:3].mean(axis=0)) for p in paths]


def legend(net) -> str:
    return " ".join(text.get_text() for text in net.artists.axes.texts)


@pytest.mark.full
def test_striae_without_slip_sense_have_no_arrow(net, studio) -> None:
    add_striae(studio, "s", EAST)
    assert arrows(net) == []
    assert "Slip" not in legend(net)


@pytest.mark.parametrize(
    ("direction", "slip", "toward"),
    first_in_default_tier(
        [
            (EAST, "normal", (1.0, 0.0)),
            (EAST, "reverse", (-1.0, 0.0)),
            # On a plane that dips east the eastern block, its hanging wall, goes north where
            # sinistral.
            ((0.0, 1.0, 0.0), "dextral", (0.0, -1.0)),
            ((0.0, 1.0, 0.0), "sinistral", (0.0, 1.0)),
        ]
    ),
)
def test_the_arrow_points_where_the_hanging_wall_moves(
    net, studio, direction, slip: str, toward
) -> None:
    add_striae(studio, "s", direction, slip)
    ((head, tail),) = arrows(net)
    step = (head - tail) / np.linalg.norm(head - tail)
    assert step == pytest.approx(toward, abs=1e-6)
    assert SYMBOLS["slip"] in legend(net)


@pytest.mark.full
def test_hiding_the_poles_hides_the_slip_arrows(net, studio) -> None:
    add_striae(studio, "s", EAST, "normal")
    add_striae(studio, "t", EAST)
    assert len(arrows(net)) == 1
    net._poles.click()
    assert arrows(net) == []
