"""By what round factor residuals are enlarged."""

from __future__ import annotations

import numpy as np
import pytest

from vomstudio.ui.dialogs.alignment.residual_scale import exaggeration


@pytest.mark.parametrize("side", [900.0, 4000.0])
@pytest.mark.parametrize("usual", np.geomspace(0.003, 300.0, 57))
def test_median_residual_is_drawn_at_up_to_one_fiftieth_of_the_photo(
    side: float, usual: float
) -> None:
    factor = exaggeration([usual / 2, usual, 9 * usual], side)
    rounds = [step * 10**power for power in range(6) for step in (1, 2, 5)]
    wanted = side / 50 / usual
    assert factor == max([1, *(each for each in rounds if each <= wanted)])


def test_long_or_zero_residuals_are_not_exaggerated() -> None:
    assert exaggeration([500.0, 700.0], 4000.0) == 1
    assert exaggeration([], 4000.0) == exaggeration([0.0, 0.0], 4000.0) == 1
