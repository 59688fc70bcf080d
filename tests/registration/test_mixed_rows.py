"""Rows that mean something else than the others are named, and the right ones are not."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest
from pyproj import Transformer

from tests.messages import with_code
from vomstudio.core.errors import GeometryError
from vomstudio.registration.checks.heights import missing_height_findings
from vomstudio.registration.checks.mixed_values import find_mixed_values, mixed_row_findings
from vomstudio.registration.coordinate_checks import find_misplaced_points, misreading_findings
from vomstudio.registration.placing import register_points

Array = npt.NDArray[np.float64]
LABELS = [f"P{i + 1}" for i in range(8)]
ORIGIN = np.array([576_700.0, 5_188_160.0, 160.0])


def site(seed: int, n: int = 8, noise: float = 0.02) -> tuple[Array, Array]:
    chance = np.random.default_rng(seed)
    model = chance.uniform(-0.5, 0.5, (n, 3)) * [60.0, 40.0, 25.0]
    return model, model + chance.normal(size=model.shape) * noise


def exchanged(world: Array) -> Array:
    return world[:, [1, 0, 2]]


def degrees(world: Array) -> Array:
    back = Transformer.from_crs("EPSG:32615", "EPSG:4326", always_xy=True)
    return np.column_stack([*back.transform(world[:, 0], world[:, 1]), world[:, 2]])


def of_another_zone(world: Array) -> Array:
    to = Transformer.from_crs("EPSG:32615", "EPSG:32616", always_xy=True)
    return np.column_stack([*to.transform(world[:, 0], world[:, 1]), world[:, 2]])


def changed(world: Array, rows: list[int], by: Callable[[Array], Array]) -> Array:
    world = world.copy()
    world[rows] = by(world)[rows]
    return world


@pytest.mark.parametrize(
    ("rows", "by", "code"),
    [
        ([0, 1, 3, 5, 6], exchanged, "control.swapped-columns"),
        ([1, 3, 5, 6], exchanged, "control.swapped-columns"),
        ([1, 2, 3, 4], of_another_zone, "control.far-away"),
        ([0, 1, 2, 3, 6], degrees, "control.some-in-degrees"),
        ([2, 3], degrees, "control.some-in-degrees"),
        ([1], lambda w: w * 1000.0, "control.other-unit"),
    ],
)
def test_crs_area_determines_which_rows_are_correct(
    rows: list[int], by: Callable[[Array], Array], code: str
) -> None:
    model, world = site(0)
    wrong = changed(world + ORIGIN, rows, by)
    (found,), which = find_misplaced_points(LABELS, model, wrong, "EPSG:32615")
    assert found.code == code
    names = tuple(LABELS[row] for row in rows)
    assert found.values.get("labels", names) == names
    assert np.flatnonzero(which).tolist() == rows


def test_swapped_half_of_the_rows_is_reported_without_a_crs() -> None:
    model, world = site(0)
    wrong = changed(world + ORIGIN, [1, 3, 5, 6], exchanged)
    (found,), which = find_misplaced_points(LABELS, model, wrong, None)
    assert found.code == "control.group-swapped"
    assert not which.any()
    # A model in map coordinates tells it by itself.
    (found,), which = find_misplaced_points(LABELS, model + ORIGIN, wrong, None)
    assert np.flatnonzero(which).tolist() == [1, 3, 5, 6]


def test_points_far_apart_in_both_frames_give_no_finding() -> None:
    near, world = site(1)
    far = np.arange(8) > 3
    for away in ([5000.0, 0.0, 0.0], [0.0, 90_000.0, 0.0]):
        shift = np.outer(far, away)
        assert find_misplaced_points(LABELS, near + shift, world + shift, None)[0] == []


def test_wrong_digit_in_one_point_is_reported_for_that_point_only() -> None:
    model, world = site(6)
    world[3, 0] += 5000.0
    (found,), which = find_misplaced_points(LABELS, model, world, None)
    assert (found.code, found.values["labels"]) == ("control.far-away", ("P4",))
    assert found.values["distance_m"] == pytest.approx(4975.0, abs=1.0)
    assert np.flatnonzero(which).tolist() == [3]


@pytest.mark.parametrize("rows", [[0, 3, 5], [0, 3, 5, 6], [1, 2]])
def test_rows_in_another_unit_or_height_system_are_reported(rows: list[int]) -> None:
    names = tuple(LABELS[row] for row in rows)
    for seed in range(3):
        model, world = site(seed)
        world += [0.0, 0.0, 160.0]
        lower = changed(world, rows, lambda w: w - [0.0, 0.0, 27.3])
        (found,) = mixed_row_findings(LABELS, model, lower)
        assert found.code == "control.height-offset"
        assert abs(found.values["offset_m"]) == pytest.approx(27.3, abs=0.2)
        if len(rows) < 4:
            assert found.values["labels"] == names
        feet = changed(world, rows, lambda w: w / [1.0, 1.0, 0.3048])
        (found,) = mixed_row_findings(LABELS, model, feet)
        assert (found.code, found.values["unit"]) == ("control.other-unit", "feet")
        turned = changed(world, rows, exchanged)
        (found,) = mixed_row_findings(LABELS, model, turned)
        assert (found.code, found.values["labels"]) == ("control.swapped-columns", names)


def test_height_offset_in_half_of_the_rows_is_not_mistaken_for_feet() -> None:
    model, world = site(36, 6)
    found = find_mixed_values(model, changed(world, [0, 2, 4], lambda w: w - [0.0, 0.0, 27.3]))
    assert found is not None
    assert found.kind == "offset"
    assert abs(found.offset_m or 0.0) == pytest.approx(27.3, abs=0.2)


@pytest.mark.parametrize("none", [0.0, -9999.0])
def test_placeholder_heights_are_reported_as_missing(none: float) -> None:
    model, world = site(4)
    world += [0.0, 0.0, 160.0]
    assert missing_height_findings(LABELS, model, world) == []
    world[[1, 4, 6], 2] = none
    (found,) = missing_height_findings(LABELS, model, world)
    assert found.code == "control.missing-heights"
    assert found.values["labels"] == ("P2", "P5", "P7")
    # A local zero is a height like any other.
    model, world = site(5, noise=0.0)
    world[:, 2] -= world[3, 2]
    assert missing_height_findings(LABELS, model, world) == []


def test_correct_points_and_single_blunders_are_not_reported_as_mixed() -> None:
    alarms = 0
    for seed in range(40):
        chance = np.random.default_rng(seed)
        model, world = site(seed, int(chance.integers(5, 12)), float(chance.choice([0.02, 2.0])))
        world[0] += chance.normal(size=3) * 3.0 * (seed % 2)
        alarms += find_mixed_values(model, world) is not None
    assert alarms <= 1


@pytest.mark.parametrize(("times", "unit"), [(1000.0, "millimetres"), (100.0, "centimetres")])
def test_heights_in_another_unit_are_reported(times: float, unit: str) -> None:
    model, world = site(2)
    (found,) = misreading_findings(model, world * [1.0, 1.0, times], include_mirrors=False)
    assert (found.code, found.values["unit"]) == ("control.other-unit", unit)
    cliff, there = model * [0.1, 0.1, 10.0], world * [0.1, 0.1, 10.0]
    assert misreading_findings(cliff, there, include_mirrors=False) == []


def test_shuffled_points_are_reported_as_fitting_nowhere() -> None:
    model, world = site(3)
    found = register_points(model, world[np.random.default_rng(1).permutation(8)])
    assert with_code(found.warnings, "registration.points-nowhere")
    with pytest.raises(GeometryError):
        register_points(model[:2], world[:2])
