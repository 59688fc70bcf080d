"""One wrong reading of a few planes by compass, named although it hides in what is left over."""

from __future__ import annotations

import numpy as np
import pytest

from tests.benchmarks.bench_registration import few_planes, named_shares
from tests.messages import with_code
from tests.tiers import first_in_default_tier
from vomstudio.registration.placing import place


@pytest.mark.parametrize("stated", first_in_default_tier([True, False]))
@pytest.mark.parametrize("added", first_in_default_tier([90.0, -90.0]))
@pytest.mark.parametrize("n", first_in_default_tier([4, 6, 8]))
def test_strike_read_as_dip_direction_is_reported_with_the_fit_without_it(n, added, stated) -> None:
    readings = few_planes(np.random.default_rng(n), n, added, stated=stated)
    placed = place([readings.kind])
    first = placed.without[0]
    assert first.suspect
    assert first.label == readings.wrong
    assert [blunder.label for blunder in placed.blunders] == [readings.wrong]
    assert first.azimuth_off_deg == -added
    (finding,) = with_code(placed.warnings, "registration.suspect")
    assert finding.values["label"] == readings.wrong
    again = place([readings.rest])
    turned = np.array(again.matrix)[:3, :3] @ np.array(placed.matrix)[:3, :3].T
    angle = np.degrees(np.arccos((np.trace(turned) - 1.0) / 2.0))
    assert first.turned_deg == pytest.approx(angle, abs=0.01)
    assert first.others_deg < 6.0
    assert len(placed.without) == n


def test_consistent_readings_give_no_blunder() -> None:
    for seed in range(4):
        readings = few_planes(np.random.default_rng(seed), 5, None)
        placed = place([readings.kind])
        assert placed.without == ()
        assert placed.blunders == ()


@pytest.mark.slow
def test_wrong_reading_is_reported_and_rarely_another() -> None:
    for n, right in ((4, 0.8), (6, 0.9)):
        shares = named_shares(n, "strike", 40, stated=False)
        assert shares.right >= right
        assert shares.wrong <= 0.05
