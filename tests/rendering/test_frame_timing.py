"""How much is drawn at once, from how long drawing took."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from vomstudio.rendering.view.frame_timing import BATCH_S, MAX_MOVING_FRAME_S, Pace, point_weight


@dataclass
class Part:
    elements: int = 50_000
    weight: float = 1.0
    is_uploaded: bool = True


def taught(seconds_per_part: float) -> Pace:
    pace = Pace()
    for _ in range(40):
        pace.record_frame([Part()], seconds_per_part)
    return pace


def test_estimate_follows_recorded_frame_times() -> None:
    pace = taught(0.004)
    assert pace.estimate_seconds([Part(), Part()]) == pytest.approx(0.008, rel=0.01)
    assert pace.estimate_seconds([Part(is_uploaded=False)]) > pace.estimate_seconds([Part()])
    assert pace.estimate_seconds([Part(weight=point_weight(9.0))]) > 3.0 * pace.estimate_seconds(
        [Part()]
    )


def test_batch_fills_its_time_budget_and_has_at_least_one_part() -> None:
    many = [Part() for _ in range(100)]
    assert taught(BATCH_S / 5.0).next_batch(many) in (4, 5)
    assert taught(10.0 * BATCH_S).next_batch(many) == 1
    assert taught(1e-6).next_batch(many) == 100
    assert Pace().next_batch([]) == 0


def test_slowdown_raises_the_estimate_immediately() -> None:
    pace = taught(0.002)
    pace.record_frame([Part()], 0.040)
    assert pace.estimate_seconds([Part()]) > 0.015


def test_first_uploads_do_not_affect_the_estimate() -> None:
    pace = taught(0.002)
    pace.record_frame([Part(), Part(is_uploaded=False)], 5.0)
    assert pace.estimate_seconds([Part()]) == pytest.approx(0.002, rel=0.01)


def test_number_of_sets_in_motion_fits_the_frame_time() -> None:
    pace = Pace()
    for _ in range(30):
        pace.record_moving_frame(0.001, 6)
    assert pace.moving_sets == 6
    for _ in range(30):
        pace.record_moving_frame(0.012 * pace.moving_sets, 6)
    assert pace.moving_sets > 1
    assert 0.012 * pace.moving_sets <= MAX_MOVING_FRAME_S
    for _ in range(30):
        pace.record_moving_frame(1.0, 6)
    assert pace.moving_sets == 1
