"""Nets show what the registration adds: beta, means and planes have one ellipse that holds it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from vomstudio.geology.common_rotation_errors import RotationErrors, group_rotation_errors
from vomstudio.geology.folds import fold_axis
from vomstudio.geometry.rotation_errors import enlarged_semi_axes
from vomstudio.io.gate.orientation_files import read_orientations
from vomstudio.products.net.contents import (
    NetContents,
    NetLineEllipse,
    compute_means,
    fold_ellipse,
    make_sets,
)
from vomstudio.products.net.figure import draw_stereonet
from vomstudio.products.net.legend import legend_entries
from vomstudio.products.net.style import PRINT
from vomstudio.products.net.table_net import net_from_table

AZIMUTH = np.array([90.0, 92.0, 95.0, 88.0, 91.0, 100.0])
DIP = np.array([30.0, 32.0, 35.0, 28.0, 31.0, 40.0])


def rotation_errors(degrees: float = 2.0) -> RotationErrors:
    return group_rotation_errors([("r1", np.radians(degrees) ** 2 * np.eye(3))] * len(AZIMUTH))


def net(known: RotationErrors | None, *, compact: bool = False) -> NetContents:
    sets = make_sets(
        {"beds": ("plane", AZIMUTH, DIP)}, rotation_errors={"beds": known} if known else None
    )
    return NetContents(
        sets=sets, means=compute_means(sets), fold=fold_axis(AZIMUTH, DIP, known), compact=compact
    )


def test_beta_ellipse_includes_the_registration_error() -> None:
    """Turns alike about all axes add the root of 5.99 times their standard deviation."""
    with_it, without = net(rotation_errors()).fold, net(None).fold
    assert with_it is not None
    assert without is not None
    large, own = fold_ellipse(with_it), fold_ellipse(without)
    assert large is not None
    assert own is not None
    added = (2.0 * 2.447746830680816) ** 2
    assert large.max_angle_deg**2 == pytest.approx(own.max_angle_deg**2 + added, rel=1e-3)
    assert large.min_angle_deg**2 == pytest.approx(own.min_angle_deg**2 + added, rel=1e-3)


def test_total_error_of_a_mean_combines_its_cone_and_the_rotation_error() -> None:
    (mean,) = net(rotation_errors()).means
    assert mean.total is not None
    (larger,) = net(rotation_errors(4.0)).means
    assert larger.total is not None
    # The own cone is the same in both: half-angles add as squares, 2 and 4 degrees of one sigma.
    factor = 2.447746830680816
    own = mean.total.max_angle_deg**2 - (2.0 * factor) ** 2
    assert larger.total.max_angle_deg == pytest.approx(np.sqrt(own + (4.0 * factor) ** 2))


def test_the_legend_names_the_ellipse_of_means() -> None:
    known, unknown = (legend_entries(net(each), PRINT) for each in (rotation_errors(), None))
    assert len(known) == len(unknown) + 1


def test_selecting_draws_the_ellipse_and_deselecting_removes_it() -> None:
    shown = net(rotation_errors())
    drawn = draw_stereonet(Figure(figsize=(6.0, 4.0)), shown)
    before = len(drawn.axes.lines)
    ellipse = NetLineEllipse(shown.means[0].line, 5.0, 3.0, np.eye(3)[1])
    drawn.select([], [ellipse])
    assert len(drawn.axes.lines) > before
    drawn.select([])
    assert len(drawn.axes.lines) == before


def test_table_with_registration_errors_shows_them_on_its_net(tmp_path: Path) -> None:
    path = tmp_path / "beds.csv"
    rows = [f"{a},{d},2.5" for a, d in zip(AZIMUTH, DIP, strict=True)]
    path.write_text("\n".join(["dip_direction_deg,dip_deg,registration_error_deg", *rows]))
    shown = net_from_table(read_orientations(path))
    assert [
        s.rotation_errors is not None and s.rotation_errors.has_known_errors for s in shown.sets
    ] == [True]
    assert shown.means[0].total is not None


def test_added_error_is_the_same_in_all_directions() -> None:
    largest, smallest = enlarged_semi_axes([3.0, 3.0, 40.0], [1.0, 1.0, 2.0], [5.0, 3.0, 90.0])
    assert largest == pytest.approx([5.0, 3.0, 90.0])
    # 3-4-5; nothing; a plane that may turn about its line is as well known across it as before.
    assert smallest == pytest.approx([np.sqrt(17.0), 1.0, 2.0])
    apart = enlarged_semi_axes(3.0, 1.0, 13.0, excluded_deg=np.sqrt(13.0**2 - 5.0**2))
    assert [float(each) for each in apart] == pytest.approx([5.0, np.sqrt(17.0)])
