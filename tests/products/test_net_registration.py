"""Nets show what the registration adds: a second ellipse, dotted, and named in the legend."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from vomstudio.geology.common_turns import Turns, together
from vomstudio.geology.folds import fold_axis
from vomstudio.io.text.orientation_reading import read_orientations
from vomstudio.products.net.contents import NetContents, NetLineEllipse, make_sets, means_of
from vomstudio.products.net.figure import draw_stereonet
from vomstudio.products.net.legend import legend_entries
from vomstudio.products.net.style import PRINT, REGISTERED_LINE
from vomstudio.products.net.table_net import net_of_table

SAID = "95 % with registration"
AZIMUTH = np.array([90.0, 92.0, 95.0, 88.0, 91.0, 100.0])
DIP = np.array([30.0, 32.0, 35.0, 28.0, 31.0, 40.0])


def turns(degrees: float = 2.0) -> Turns:
    return together([("r1", np.radians(degrees) ** 2 * np.eye(3))] * len(AZIMUTH))


def net(known: Turns | None, *, compact: bool = False) -> NetContents:
    sets = make_sets({"beds": ("plane", AZIMUTH, DIP)}, turns={"beds": known} if known else None)
    return NetContents(
        sets=sets, means=means_of(sets), fold=fold_axis(AZIMUTH, DIP, known), compact=compact
    )


def said(contents: NetContents) -> list[str]:
    return [entry.text for entry in legend_entries(contents, PRINT)]


def dotted(contents: NetContents) -> int:
    """Lines in the net that are dotted, not the sample of the legend."""
    drawn = draw_stereonet(Figure(figsize=(6.0, 4.0)), contents)
    lines = [line for line in drawn.axes.lines if line.get_linestyle() == REGISTERED_LINE]
    return sum(len(line.get_xdata()) > 2 for line in lines)


def test_beta_and_means_have_a_second_ellipse() -> None:
    shown = net(turns())
    assert SAID in said(shown)
    assert dotted(shown) >= 2
    assert len(shown.with_registration) == 2


def test_there_is_none_where_no_error_is_known() -> None:
    shown = net(None)
    assert SAID not in said(shown)
    assert dotted(shown) == 0
    assert shown.with_registration == ()


def test_a_mean_that_turns_by_two_degrees_has_them_and_its_own_cone() -> None:
    (mean,) = net(turns()).means
    assert mean.total is not None
    (larger,) = net(turns(4.0)).means
    assert larger.total is not None
    # The own cone is the same in both: half-angles add as squares, 2 and 4 degrees of one sigma.
    factor = 2.447746830680816
    own = mean.total.max_angle_deg**2 - (2.0 * factor) ** 2
    assert larger.total.max_angle_deg == pytest.approx(np.sqrt(own + (4.0 * factor) ** 2))


def test_the_legend_on_a_screen_does_not_change_with_what_is_selected() -> None:
    shown = replace(net(turns(), compact=True), means=(), fold=None)
    picked = NetLineEllipse(
        shown.fold.beta if shown.fold else mean_of(shown), 5.0, 3.0, np.eye(3)[0]
    )
    assert said(shown) == said(shown.with_selection([], [picked], [picked]))
    assert SAID in said(shown)


def mean_of(shown: NetContents):  # type: ignore[no-untyped-def]
    return means_of(shown.sets)[0].line


def test_selecting_draws_it_and_deselecting_takes_it_away() -> None:
    shown = replace(net(turns()), means=(), fold=None)
    drawn = draw_stereonet(Figure(figsize=(6.0, 4.0)), shown)
    before = len(drawn.axes.lines)
    ellipse = NetLineEllipse(mean_of(shown), 5.0, 3.0, np.eye(3)[1])
    drawn.select([], [ellipse], [ellipse])
    assert any(line.get_linestyle() == REGISTERED_LINE for line in drawn.axes.lines)
    drawn.select([])
    assert len(drawn.axes.lines) == before


def test_a_table_with_the_column_has_it_on_its_net(tmp_path: Path) -> None:
    path = tmp_path / "beds.csv"
    rows = [f"{a},{d},2.5" for a, d in zip(AZIMUTH, DIP, strict=True)]
    path.write_text("\n".join(["dip_direction_deg,dip_deg,registration_error_deg", *rows]))
    shown = net_of_table(read_orientations(path))
    assert [s.registered for s in shown.sets] == [True]
    assert SAID in said(shown)
