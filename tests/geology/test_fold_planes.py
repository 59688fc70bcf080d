"""Which planes a fold axis is computed from, in tables and in projects."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import vomstudio as vs
from vomstudio.core.errors import UsageError
from vomstudio.geology.fold_options import FoldOptions
from vomstudio.geology.fold_planes import FoldFilter, select_planes
from vomstudio.geology.folds import fold_axis
from vomstudio.geology.table_folds import table_fold
from vomstudio.io.gate.orientation_files import read_orientations

QUALITIES = ["good", "poor", "doubtful", "good", "", "Good", "1"]
SETS = ["a", "a", "b", "b", "a", "A", ""]


@pytest.mark.parametrize(
    ("which", "used", "not_good"),
    [
        (FoldFilter(), [0, 1, 2, 3, 5], 2),
        (FoldFilter("doubtful"), [0, 2, 3, 5], 1),
        (FoldFilter("good"), [0, 3, 5], 0),
        (FoldFilter(set_name="a"), [0, 1, 5], 1),
        (FoldFilter("good", "B"), [3], 0),
        (FoldFilter("good", "c"), [], None),
    ],
)
def test_planes_are_chosen_by_verdict_and_set(
    which: FoldFilter, used: list[int], not_good: int | None
) -> None:
    chosen = select_planes(QUALITIES, SETS, which)
    assert np.flatnonzero(chosen.is_used).tolist() == used
    assert chosen.not_good == not_good
    assert sum(each.n for each in chosen.left_out) == len(QUALITIES) - len(used)


def test_planes_without_a_verdict_are_used_if_none_has_one() -> None:
    chosen = select_planes([None, "", "?"], ["", "", ""], FoldFilter())
    assert chosen.is_used.all()
    assert (chosen.left_out, chosen.not_good) == ((), None)


def table(tmp_path: Path) -> Path:
    """Eight good beds about 090/20, three red ones that strike otherwise, one compass reading."""
    turns = np.radians(np.linspace(-60.0, 60.0, 8))
    axis = np.array([np.cos(np.radians(20.0)), 0.0, -np.sin(np.radians(20.0))])
    up = np.array([np.sin(np.radians(20.0)), 0.0, np.cos(np.radians(20.0))])
    normals = np.cos(turns)[:, None] * up + np.sin(turns)[:, None] * np.cross(axis, up)
    dips = np.degrees(np.arccos(normals[:, 2]))
    azimuths = np.degrees(np.arctan2(normals[:, 0], normals[:, 1])) % 360.0
    rows = [f"{a},{d},good,bedding" for a, d in zip(azimuths, dips, strict=True)]
    rows += [f"{a},70,poor,bedding" for a in (60, 100, 250)] + ["5,80,,bedding"]
    path = tmp_path / "beds.csv"
    path.write_text("\n".join(["dip_direction_deg,dip_deg,quality,kind", *rows]))
    return path


def test_a_table_states_how_many_planes_are_not_good_and_can_leave_them_out(
    tmp_path: Path,
) -> None:
    rows = read_orientations(table(tmp_path))
    every = table_fold(rows)
    assert (every.n, every.used, every.not_good) == (12, 11, 3)
    (finding,) = [w for w in every.warnings if getattr(w, "code", "") == "fold.planes-not-good"]
    assert finding.values == {"not_good": 3, "used": 11}
    good = table_fold(rows, FoldOptions(quality="good"))
    assert (good.used, good.not_good, len(good.left_out)) == (8, 0, 2)
    assert not good.warnings
    beta = fold_axis(rows.dip_direction_deg[:8], rows.dip_deg[:8]).beta
    assert (good.beta.trend_deg, good.beta.plunge_deg) == pytest.approx(
        (beta.trend_deg, beta.plunge_deg)
    )
    assert (beta.trend_deg, beta.plunge_deg) == pytest.approx((90.0, 20.0))


def test_python_function_has_same_filter(tmp_path: Path) -> None:
    with pytest.warns(vs.errors.VomWarning):
        assert vs.fold(table(tmp_path)).not_good == 3
    assert vs.fold(table(tmp_path), quality="good").used == 8
    with pytest.raises(vs.errors.InputError):
        vs.fold(table(tmp_path), quality="poor")  # type: ignore[arg-type]
    with pytest.raises(UsageError):
        vs.fold(table(tmp_path), only_set="nowhere")
    with pytest.raises(UsageError):
        vs.fold(([90, 100, 120], [20, 30, 40]), quality="good")
