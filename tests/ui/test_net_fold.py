"""The fold axis on the net: that of the beds shown, found once while they stay the same."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from vomstudio.geology.common_turns import Turns
from vomstudio.geology.folds import fold_axis
from vomstudio.products.net.contents import NetContents, NetSet
from vomstudio.ui.analyse.net import source

DIPS = np.array([30.0, 35.0, 28.0, 40.0, 33.0, 27.0])
BEDS = NetSet("beds", "plane", np.array([100.0, 110.0, 95.0, 280.0, 270.0, 290.0]), DIPS)


@pytest.fixture
def found(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """One entry for each time that an axis was looked for."""
    times: list[int] = []

    def counted(*words: object) -> object:
        times.append(1)
        return fold_axis(*words)

    source._fold_of_planes.cache_clear()
    monkeypatch.setattr(source, "fold_axis", counted)
    return times


def beta(bed: NetSet) -> tuple[float, float]:
    fold = source.with_fold(NetContents(sets=()), [bed]).fold
    assert fold is not None
    return fold.beta.trend_deg, fold.error95_deg or 0.0


@pytest.mark.full
def test_it_is_found_once_for_the_same_beds_and_anew_for_others(found: list[int]) -> None:
    first = beta(BEDS)
    assert beta(replace(BEDS, azimuth_deg=BEDS.azimuth_deg.copy())) == first
    assert len(found) == 1
    turned = beta(replace(BEDS, azimuth_deg=(BEDS.azimuth_deg + 30.0) % 360.0))
    assert (turned[0] - first[0]) % 360.0 == pytest.approx(30.0)
    assert len(found) == 2


def test_another_registration_has_another_error(found: list[int]) -> None:
    group = np.zeros(6, np.int64)
    errors = [
        beta(replace(BEDS, turns=Turns(group, np.eye(3)[None] * np.radians(degrees) ** 2)))[1]
        for degrees in (1.0, 5.0)
    ]
    assert errors[0] < errors[1]
    assert len(found) == 2
