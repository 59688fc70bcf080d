"""A distance has a direction, and as many digits as its error justifies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.samples import HASH
from vomstudio.geology.orientation import Line
from vomstudio.geometry.frames import Frame
from vomstudio.project.codec import decode, encode
from vomstudio.project.dimension_errors import point_errors
from vomstudio.project.kinds.dimension import Dimension
from vomstudio.project.length_figures import headline, words
from vomstudio.project.measurement_cache import measure_all
from vomstudio.project.records import Model

MODEL = Model("m1", "cliff", "cliff.obj", "mesh", HASH, Frame("crs", "EPSG:32633"))
STEP = np.array([3.0, 4.0, -12.0])


def distance(resolution: float | None = None, kind: str = "distance") -> Dimension:
    start = np.array([500000.0, 5100000.0, 100.0])
    ends = (tuple(start.tolist()), tuple((start + STEP).tolist()))
    return Dimension("d1", "D01", kind, "m1", HASH, ends, resolution=resolution)


def measure(dimension: Dimension):
    (measured,) = measure_all({"m1": MODEL, "d1": dimension}, [dimension])
    return measured


def test_a_distance_has_the_direction_from_its_first_to_its_last_point() -> None:
    figures = measure(distance()).dimension
    expected = Line.from_vector(STEP)
    assert figures["distance_m"] == pytest.approx(13.0)
    assert figures["trend_deg"] == pytest.approx(expected.trend_deg)
    assert figures["plunge_deg"] == pytest.approx(expected.plunge_deg)
    assert any("037/67" in line for line in words(measure(distance())))


@pytest.mark.parametrize("kind", ["polyline", "area", "thickness"])
def test_other_dimensions_have_no_direction(kind: str) -> None:
    assert "trend_deg" not in (measure(distance(kind=kind)).dimension or {})


@pytest.mark.parametrize(
    ("resolution", "text"),
    [
        (None, "13.0 m"),
        (0.001, "13.0000 m ± 0.22 mm"),
        (0.01, "13.0000 m ± 2.2 mm"),
        (0.1, "13.000 m ± 2.2 cm"),
        (5.0, "13.0 m ± 1.1 m"),
    ],
)
def test_digits_follow_the_error(resolution: float | None, text: str) -> None:
    assert headline(measure(distance(resolution))) == text


def test_errors_follow_from_those_of_the_two_points() -> None:
    """Against simulated points whose coordinates have the stated error."""
    errors = point_errors({"distance_m": 13.0}, 0.1)
    rng = np.random.default_rng(3)
    noise = rng.normal(0.0, 0.08 * 0.1, (20_000, 2, 3))
    steps = STEP + noise[:, 1] - noise[:, 0]
    lengths = np.linalg.norm(steps, axis=1)
    assert np.mean(np.abs(lengths - 13.0) <= errors["distance_error95_m"]) == pytest.approx(
        0.95, abs=0.01
    )
    turned = np.degrees(np.arccos(np.clip(steps @ STEP / (13.0 * lengths), -1.0, 1.0)))
    assert np.mean(turned <= errors["direction_points95_deg"]) == pytest.approx(0.95, abs=0.01)


def test_distance_without_resolution_opens_unchanged() -> None:
    old = encode(distance())
    del old["resolution"]
    assert decode(old) == replace(distance(), resolution=None)
    assert headline(measure(decode(old))) == "13.0 m"


def test_coinciding_points_have_no_direction() -> None:
    point = (1.0, 2.0, 3.0)
    at = replace(distance(0.1), vertices=(point, point))
    assert measure(at).dimension == {"distance_m": 0.0, "horizontal_m": 0.0, "vertical_m": 0.0}
