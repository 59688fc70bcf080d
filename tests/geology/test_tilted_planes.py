"""Probabilities from each plane's own error, against normal distributions in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import norm

from tests.messages import by_code
from vomstudio.geology.intersections import intersection_line, uncertain_plane
from vomstudio.geology.orientation import Plane
from vomstudio.geology.slope_options import SlopeOptions
from vomstudio.geology.table_slopes import slope_face, table_slope
from vomstudio.io.text.orientation_reading import extract_orientations
from vomstudio.io.text.tables import table_from_cells

CHI = math.sqrt(5.991464547107979)
ERRORS = ("dip_direction", "dip", "max_confidence95_deg", "min_confidence95_deg", "error_rake_deg")


def table(rows, names=ERRORS, comments=()):
    cells = [["" if cell is None else repr(cell) for cell in row] for row in rows]
    return extract_orientations(table_from_cells(names, cells, "the table", comments))


@pytest.mark.parametrize("dip", [28.0, 30.0, 33.0, 67.0, 71.0])
def test_planar_probability_follows_from_dip_error(dip: float) -> None:
    """Its dip strays by 5 degrees (95 %, joint), its strike hardly: between 30 and 70 it slides."""
    found = table_slope(
        table([(90.0, dip, 5.0, 0.01, 90.0)]), slope_face("90/70", SlopeOptions(30.0))
    )
    sigma = 5.0 / CHI
    expected = norm.cdf(70, dip, sigma) - norm.cdf(30, dip, sigma)
    assert found.planar.probability == pytest.approx(expected, abs=0.02)


def test_strike_error_does_not_change_the_dip() -> None:
    found = table_slope(
        table([(90.0, 32.0, 5.0, 0.01, 0.0)]), slope_face("90/70", SlopeOptions(30.0))
    )
    assert found.planar.probability == pytest.approx(1.0, abs=0.01)


def test_wedge_probability_follows_from_intersection_error() -> None:
    """Against the propagated error of the line, where the friction angle alone limits it."""
    rows = [(40.0, 60.0, 3.0, 1.0, 70.0), (140.0, 55.0, 4.0, 2.0, 20.0)]
    planes = [Plane(row[0], row[1]) for row in rows]
    uncertain = []
    for row, plane in zip(rows, planes, strict=True):
        rake = math.radians(row[4])
        tilt = math.cos(rake) * plane.strike_vector() + math.sin(rake) * plane.dip_vector()
        uncertain.append(uncertain_plane(plane.normal(), tilt, row[2], row[3]))
    line = intersection_line(*uncertain)
    vector, axis = line.line.vector(), line.confidence_axis
    # The part of the line's ellipse along its plunge.
    down = np.array([0.0, 0.0, -1.0]) - vector * -vector[2]
    down /= np.linalg.norm(down)
    across = np.cross(vector, axis)
    semi = math.hypot(
        line.max_confidence95_deg * float(down @ axis),
        line.min_confidence95_deg * float(down @ across),
    )
    friction = line.line.plunge_deg + 0.4 * semi / CHI
    found = table_slope(table(rows), slope_face("90/89", SlopeOptions(friction)))
    assert found.wedge.critical == 0
    assert found.wedge.probability == pytest.approx(norm.sf(0.4), abs=0.02)


def test_probability_is_none_without_errors() -> None:
    found = table_slope(
        table([(90.0, 45.0), (30.0, 60.0)], ERRORS[:2]), slope_face("90/70", SlopeOptions(30.0))
    )
    modes = (found.planar, found.wedge, found.flexural_toppling, found.direct_toppling)
    assert [mode.probability for mode in modes] == [None] * 4
    assert found.draws is None


def test_planes_without_an_error_are_exact_and_counted() -> None:
    rows = [(90.0, 30.0, 5.0, 5.0, 0.0), (90.0, 45.0, None, None, None)]
    found = table_slope(table(rows), slope_face("90/70", SlopeOptions(30.0)))
    assert found.planar.probability == pytest.approx(0.75, abs=0.02)
    assert (found.with_error, found.n) == (1, 2)
    assert by_code(found.warnings)["slope.errors-unknown"] == {"count": 1}


def test_the_same_table_gives_the_same_probability() -> None:
    given = table([(90.0, 31.0, 5.0, 3.0, 20.0), (20.0, 60.0, 8.0, 2.0, 110.0)])
    face = slope_face("90/70", SlopeOptions(30.0))
    assert table_slope(given, face) == table_slope(given, face)


def test_total_error_replaces_smaller_fit_error() -> None:
    names = (*ERRORS, "total95_deg")
    found = table_slope(
        table([(90.0, 33.0, 3.0, 3.0, 0.0, 5.0)], names), slope_face("90/70", SlopeOptions(30.0))
    )
    assert found.planar.probability == pytest.approx(norm.cdf(3.0 / (5.0 / CHI)), abs=0.01)


def test_registration_error_tilts_planes_of_one_model_together() -> None:
    """Two planes that meet in a horizontal line at the limit: it rises or falls as one, so that the
    wedge is critical in half of the draws, and planar shares are those of the dip."""
    names = ("dip_direction", "dip", "registration_error_deg", "model")
    found = table_slope(
        table([(90.0, 33.0, 5.0, "a"), (90.0, 33.0, 5.0, "a")], names),
        slope_face("90/70", SlopeOptions(30.0)),
    )
    assert found.planar.probability == pytest.approx(norm.cdf(3.0 / (5.0 / CHI)), abs=0.02)
    # Turned together, parallel planes stay parallel: there is still no intersection.
    assert found.wedge.probability is None


@pytest.mark.parametrize(
    ("names", "row"),
    [
        (("max_confidence95_deg", "min_confidence95_deg"), (5.0, 0.1)),
        (("total95_deg",), (5.0,)),
        (("dip_error_deg", "dip_direction_error_deg"), (5.0, 0.1)),
        (("dip_error_deg",), (5.0,)),
    ],
)
def test_tables_with_fewer_error_columns_have_probabilities(names, row) -> None:
    """Without the rake of the larger error it may be that of the dip."""
    found = table_slope(
        table([(90.0, 33.0, *row)], ("dip_direction", "dip", *names)),
        slope_face("90/70", SlopeOptions(30.0)),
    )
    assert found.planar.probability == pytest.approx(norm.cdf(3.0 / (5.0 / CHI)), abs=0.01)


def test_dip_direction_error_alone_rotates_plane_about_vertical() -> None:
    """At the edge of a straight lateral limit half of the drawn planes are inside."""
    names = ("dip_direction", "dip", "dip_error_deg", "dip_direction_error_deg")
    found = table_slope(
        table([(112.0, 45.0, 0.001, 5.0)], names),
        slope_face("90/70", SlopeOptions(30.0, 20.0, "straight")),
    )
    expected = norm.cdf(-2.0 / (5.0 / CHI))
    assert found.planar.probability == pytest.approx(expected, abs=0.02)
