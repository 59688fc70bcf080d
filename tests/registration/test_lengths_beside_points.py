"""Measured lengths that are not those which the control points give."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.messages import refused, with_code
from tests.registrations import TURN
from vomstudio.core.errors import UsageError
from vomstudio.io.control.observation_tables import Pairs, ScaleBar, read_scale_bars
from vomstudio.registration.compass_evidence import Segment
from vomstudio.registration.evidence import Evidence, register
from vomstudio.registration.length_evidence import length_findings, length_observations


def survey(n: int, seed: int, noise: float, stated: bool = False) -> Pairs:
    rng = np.random.default_rng(seed)
    model = rng.uniform(-0.5, 0.5, (n, 3)) * [60.0, 40.0, 25.0]
    world = model @ TURN.T + [576_700.0, 5_188_160.0, 160.0] + rng.normal(size=(n, 3)) * noise
    sigma = np.full((n, 3), noise if stated else np.nan)
    return Pairs(tuple(f"P{i}" for i in range(n)), model, world, sigma, np.zeros(n, bool))


def length(pairs: Pairs, first: int, second: int) -> float:
    return float(np.linalg.norm(pairs.world[first] - pairs.world[second]))


@pytest.mark.parametrize(
    ("n", "times", "unit"),
    [
        *((n, 1 / 0.3048, "feet") for n in (3, 4, 12)),
        *((n, 100.0, "centimetres") for n in (3, 8)),
        (4, 1000.0, "millimetres"),
        *((n, 1.2, None) for n in (5, 8, 12)),
    ],
)
def test_length_contradicting_the_points_is_reported(
    n: int, times: float, unit: str | None
) -> None:
    pairs = survey(n, n, 0.02)
    bars = [ScaleBar("P0", "P1", length(pairs, 0, 1) * times)]
    code = "length.contradicted" if unit is None else "length.other-unit"
    (finding,) = with_code(register(Evidence(pairs=pairs, bars=bars)).warnings, code)
    names = {"labels": ("P0 - P1",), "unit": unit} if unit else {"label": "P0 - P1"}
    assert names.items() <= finding.values.items()
    ends = tuple(pairs.model[0]), tuple(pairs.model[1])
    line = Segment(*ends, length(pairs, 0, 1) * times)  # type: ignore[arg-type]
    (finding,) = length_findings([], [line], pairs)
    assert (finding.code, finding.values.get("unit")) == (code, unit)


def test_correct_lengths_are_rarely_reported() -> None:
    """Two bars by a tape that is as good as it is taken to be, beside points of every number."""
    rng = np.random.default_rng(4)
    named = 0
    for seed in range(300):
        n = int(rng.integers(3, 13))
        pairs = survey(n, seed, float(rng.choice([0.005, 0.05, 0.5])), bool(seed % 2))
        true = [float(np.linalg.norm(pairs.model[i] - pairs.model[k])) for i, k in ((0, 1), (1, 2))]
        bars = [
            ScaleBar(f"P{i}", f"P{i + 1}", true[i] * (1 + 0.005 * rng.normal())) for i in range(2)
        ]
        named += bool(length_findings(bars, [], pairs))
    assert named <= 2


def test_unknown_bar_label_is_rejected_with_the_most_similar_label() -> None:
    with refused("length.unknown-point", UsageError, label="p1 (P1?)"):
        register(Evidence(pairs=survey(4, 1, 0.02), bars=[ScaleBar("P0", "p1", 3.0)]))


@pytest.mark.parametrize(
    ("row", "code"), [("P0,Q", "length.unknown-point"), ("P1,P0", "line.one-place")]
)
def test_invalid_scale_bar_is_reported_by_file_and_line(
    tmp_path: Path, row: str, code: str
) -> None:
    path = tmp_path / "bars.csv"
    path.write_text(f"from,to,length_m,use\nP0,P2,3,check\nP2,P3,3,\n{row},3,\n")
    pairs = survey(4, 1, 0.02)
    pairs.model[1] = pairs.model[0]
    with refused(code, UsageError, file=path, line=4):
        length_observations(read_scale_bars(path), [], pairs)


def test_lengths_in_the_same_wrong_unit_are_reported_together() -> None:
    pairs = survey(8, 1, 0.02)
    bars = [ScaleBar(f"P{i}", f"P{i + 1}", length(pairs, i, i + 1) / 0.3048) for i in range(3)]
    (finding,) = length_findings(bars, [], pairs)
    assert finding.values["labels"] == ("P0 - P1", "P1 - P2", "P2 - P3")
    assert finding.values["unit"] == "feet"
