"""Statistics and folds against the commands, published figures and mplstereonet."""

from __future__ import annotations

import warnings
from dataclasses import FrozenInstanceError
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pytest

import vomstudio as vs
from tests.messages import by_code


def plain(value: Any) -> Any:
    """As JSON has it."""
    if isinstance(value, dict):
        return {k: plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    return value


@pytest.fixture
def big_elk(data_dir: Path) -> Path:
    return data_dir / "planes" / "big_elk_strike_dip.txt"


@pytest.fixture
def planes(picks: Any, tmp_path: Path) -> tuple[Any, Path]:
    """The planes of the sample with their kinds, as a DataFrame and as a file."""
    made = vs.fit_planes(picks, by="pick")
    kinds = picks.drop_duplicates("pick").set_index("pick")["kind"]
    made["kind"] = made["id"].map(kinds)
    path = tmp_path / "planes.csv"
    made.to_csv(path, index=False)
    return made, path


def test_published_tensor_is_reproduced(big_elk: Path) -> None:
    found = vs.stats(big_elk).sets["all"]
    assert found.tensor.eigenvalues == pytest.approx((0.5901, 0.3525, 0.0573), abs=1e-4)
    assert pytest.approx((0.2837, 2.3312), abs=1e-4) == (found.woodcock.K, found.woodcock.C)
    assert pytest.approx(0.5904, abs=1e-4) == found.vollmer.G


def test_published_axis_is_reproduced(big_elk: Path) -> None:
    found = vs.fold(big_elk)
    assert (found.beta.trend_deg, found.beta.plunge_deg) == pytest.approx((125.3, 26.1), abs=0.1)
    assert found.pi_plane.strike_rhr_deg == pytest.approx(215.3, abs=0.1)


@pytest.mark.parametrize("by", [None, "kind"])
def test_statistics_match_command_output(command: Any, planes: Any, by: Any) -> None:
    table, path = planes
    words = ["stats", path] if by is None else ["stats", path, "--by", by]
    told = command(*words)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = plain(vs.stats(table, by=by).to_dict())
    assert found["sets"] == told["sets"]
    assert found["n"] == told["n"]


def test_folds_match_command_output(command: Any, planes: Any) -> None:
    table, path = planes
    assert plain(vs.fold(table).to_dict()) == command("fold", path)
    assert plain(vs.fold(table, kind="joint").to_dict()) == command("fold", path, "--kind", "joint")
    told = command("fold", path, "--sets", "4 east limb,fault")
    assert plain(vs.fold(table, sets=["4 east limb", "fault"]).to_dict()) == told


def test_fisher_mean_matches_mplstereonet() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import mplstereonet
    chance = np.random.default_rng(8)
    direction, dip = 120 + 6 * chance.normal(size=40), 50 + 5 * chance.normal(size=40)
    (vector, (_, _, kappa)) = mplstereonet.find_fisher_stats(
        direction - 90, dip.copy(), measurement="poles"
    )
    found = vs.stats((direction, dip)).sets["all"].fisher
    assert found is not None
    assert found.kappa == pytest.approx(float(kappa), rel=1e-6)
    assert (found.plunge_deg, found.trend_deg) == pytest.approx([float(v) for v in vector])


def test_rotating_input_rotates_fold_axis() -> None:
    chance = np.random.default_rng(2)
    direction, dip = chance.uniform(0, 360, 25), chance.uniform(5, 85, 25)
    here, there = vs.fold((direction, dip)), vs.fold(((direction + 30) % 360, dip))
    turned = (there.beta.trend_deg - here.beta.trend_deg) % 360
    assert turned == pytest.approx(30.0)
    assert there.beta.plunge_deg == pytest.approx(here.beta.plunge_deg)
    assert there.eigenvalues == pytest.approx(here.eigenvalues)


def test_pooling_kinds_gives_warning(planes: Any) -> None:
    with pytest.warns(vs.errors.VomWarning):
        found = vs.stats(planes[0])
    assert len(by_code(found.warnings)["stats.several-kinds"]["kinds"]) == 3


def test_directed_lines_use_fisher_statistics() -> None:
    lines = pandas.DataFrame({"trend": [10, 12, 8], "plunge": [-20, -22, -21]})
    found = vs.stats(lines, directed=True).sets["all"]
    assert found.of == "lines"
    assert not found.axial
    assert found.fisher is not None
    assert found.fisher.plunge_deg < 0


def test_results_are_immutable_and_have_repr(big_elk: Path) -> None:
    for found in (vs.stats(big_elk), vs.fold(big_elk)):
        with pytest.raises(FrozenInstanceError):
            found.n = 3  # type: ignore[misc]
        assert "61" in repr(found)
        assert "<table>" in found._repr_html_()


@pytest.mark.parametrize(
    ("call", "kind", "said"),
    [
        (lambda t: vs.stats(t, by="site"), "UsageError", "no column 'site'"),
        (lambda t: vs.fold(t, kind="dyke"), "UsageError", "No plane has the kind “dyke”"),
        (lambda t: vs.fold(t, sets=["bedding"]), "UsageError", "two or three different sets"),
        (
            lambda t: vs.fold(t, sets=["bedding", "dyke"]),
            "UsageError",
            "No plane belongs to",
        ),
        (lambda t: vs.fold(([10, 10, 10], [5, 5, 5])), "GeometryError", "parallel"),
        (lambda t: vs.fold(([10], [5])), "GeometryError", "at least two planes"),
    ],
)
def test_impossible_requests_are_refused_with_reason(
    planes: Any, call: Any, kind: str, said: str
) -> None:
    with pytest.raises(getattr(vs.errors, kind), match=said):
        call(planes[0])
