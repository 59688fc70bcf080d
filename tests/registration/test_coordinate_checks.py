"""Coordinates that are something else than they are taken for are named, with what to do."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from pyproj import Transformer

from tests.messages import refused, with_code
from vomstudio.core.errors import GeometryError, InputError
from vomstudio.registration import coordinate_checks as checks
from vomstudio.registration.observations import Points
from vomstudio.registration.placing import register_points

Array = npt.NDArray[np.float64]
LABELS = [f"P{i}" for i in range(8)]
ORIGIN = np.array([576_700.0, 5_188_160.0, 160.0])


def site(seed: int = 0) -> tuple[Array, Array]:
    """Points of a model, and where they are with 2 cm of error."""
    chance = np.random.default_rng(seed)
    model = chance.uniform([-50, -45, -6], [50, 45, 6], (8, 3))
    return model, ORIGIN + model + chance.normal(size=model.shape) * 0.02


def degrees(world: Array) -> Array:
    back = Transformer.from_crs("EPSG:32615", "EPSG:4326", always_xy=True)
    return np.column_stack([*back.transform(world[:, 0], world[:, 1]), world[:, 2]])


def test_correct_coordinates_give_no_finding() -> None:
    for seed in range(20):
        model, world = site(seed)
        assert not checks.is_far_from_others(world).any()
        assert checks.degree_findings(world) == []
        assert checks.misreading_findings(model, world) == []
        assert checks.swapped_label_findings(LABELS, model, world) == []
        assert checks.check_area(world, "EPSG:32615") == []
        assert checks.scale_unit_findings(1.0, 0.001) == []
        assert checks.relocation_findings(world, world + 100.0, "EPSG:32615") == []
        assert checks.position_noise_findings(world, world + 5.0) == []
        checks.require_on_model(model, model * 1.5)


def test_point_with_swapped_easting_and_northing_is_reported() -> None:
    _, world = site()
    world[2] = world[2, [1, 0, 2]]
    far = checks.is_far_from_others(world)
    assert np.flatnonzero(far).tolist() == [2]
    (said,) = checks.far_point_findings(LABELS, world, far)
    assert (said.code, said.values["labels"]) == ("control.swapped-columns", ("P2",))


def test_point_in_another_utm_zone_is_reported() -> None:
    _, world = site()
    to = Transformer.from_crs("EPSG:32615", "EPSG:32616", always_xy=True)
    world[5, :2] = to.transform(*world[5, :2])
    (said,) = checks.far_point_findings(LABELS, world, checks.is_far_from_others(world))
    assert (said.code, said.values["labels"]) == ("control.far-away", ("P5",))


def test_swapped_labels_are_distinguished_from_a_wrong_point() -> None:
    model, world = site()
    wrong = world.copy()
    wrong[[1, 4]] = world[[4, 1]]
    (said,) = checks.swapped_label_findings(LABELS, model, wrong)
    assert said.code == "control.swapped-labels"
    assert (said.values["first"], said.values["second"]) == ("P1", "P4")
    world[3, 0] += 5.0
    assert checks.swapped_label_findings(LABELS, model, world) == []


@pytest.mark.parametrize("latitude_first", [False, True])
def test_coordinates_in_degrees_are_reported(latitude_first: bool) -> None:
    table = degrees(site()[1])
    (said,) = checks.degree_findings(table[:, [1, 0, 2]] if latitude_first else table)
    assert said.code == "frame.maybe-degrees"
    assert said.values["latitude_first"] == latitude_first


@pytest.mark.parametrize(
    ("changed", "code", "axes"),
    [
        (lambda w: w / [1, 1, 0.3048], "control.other-unit", "heights"),
        (lambda w: w / [0.3048, 0.3048, 1], "control.other-unit", "x, y"),
        (lambda w: w[:, [1, 0, 2]], "control.swapped-columns", None),
        (lambda w: w * [1, 1, -1], "control.swapped-columns", None),
    ],
)
def test_misread_columns_are_reported(changed, code: str, axes: str | None) -> None:
    model, world = site()
    (found,) = checks.misreading_findings(model, changed(world))
    assert (found.code, found.values.get("axes")) == (code, axes)


def test_coordinates_in_feet_are_recognised_by_the_scale() -> None:
    (said,) = checks.scale_unit_findings(1 / 0.3048, 0.001)
    assert (said.code, said.values["unit"]) == ("control.scale-of-unit", "feet")
    assert checks.scale_unit_findings(1 / 0.3048, 0.2) == []
    assert checks.scale_unit_findings(3.2, 0.001) == []


@pytest.mark.parametrize(
    ("changed", "code"),
    [
        (lambda w: w[:, [1, 0, 2]], "frame.swapped-axes"),
        (lambda w: w / 0.3048, "control.other-unit"),
        (lambda w: w + [-1_100_000.0, 11_000.0, 0.0], "frame.not-metric"),
    ],
)
def test_coordinates_outside_the_crs_are_rejected(changed, code: str) -> None:
    with pytest.raises(InputError) as refused:
        checks.check_area(changed(site()[1]), "EPSG:32615")
    assert refused.value.code == code


def test_coordinates_in_kilometres_are_reported() -> None:
    found = checks.check_area(site()[1] / 1000.0, "EPSG:32615")
    assert [finding.code for finding in found] == ["control.other-unit", "frame.outside-area"]


def test_coordinates_outside_the_crs_area_are_reported() -> None:
    shifted = site()[1] + [-457_000.0, 11_000.0, 0.0]
    (found,) = checks.check_area(shifted, "EPSG:32615")
    assert found.code == "frame.outside-area"


def test_suitable_crs_is_suggested_for_a_wrong_zone() -> None:
    lon_lat = degrees(site()[1])
    to = Transformer.from_crs("EPSG:4326", "EPSG:32613", always_xy=True)
    world = np.column_stack([*to.transform(lon_lat[:, 0], lon_lat[:, 1]), lon_lat[:, 2]])
    with pytest.raises(InputError) as refused:
        checks.check_area(world, "EPSG:32613", is_converted=True)
    assert refused.value.values["suggested_crs"] == "EPSG:32615"


def test_table_in_another_frame_than_the_model_is_rejected() -> None:
    model, world = site()
    with refused("registration.off-model", GeometryError):
        checks.require_on_model(model, world)
    checks.require_on_model(model, None)


def test_large_shift_of_a_georeferenced_model_is_reported() -> None:
    _, world = site()
    (said,) = checks.relocation_findings(world, world + [457_000.0, 0.0, 0.0], "EPSG:32615")
    assert said.code == "registration.moved"
    assert said.values["distance_km"] == pytest.approx(457.0, abs=0.5)


def test_rotation_of_a_georeferenced_model_is_reported() -> None:
    _, world = site()
    middle = world.mean(axis=0)
    turned = (world - middle) @ np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    (said,) = checks.relocation_findings(world, middle + turned, "EPSG:32615")
    assert (said.code, said.values["turn_deg"]) == ("registration.turned", pytest.approx(90.0))


def test_upward_views_and_noisy_camera_positions_are_reported() -> None:
    down = np.tile([0.0, 0.0, -1.0], (5, 1))
    assert checks.view_direction_findings(down) == []
    assert checks.view_direction_findings(np.tile([0.0, 1.0, 0.0], (5, 1))) == []
    assert checks.view_direction_findings(-down)[0].code == "cameras.look-up"
    _, world = site()
    (said,) = checks.position_noise_findings(world, world + [60.0, 0.0, 0.0])
    assert (said.code, said.values["error_m"]) == ("cameras.noise", pytest.approx(60.0))


def test_constant_heights_are_reported() -> None:
    rng = np.random.default_rng(4)
    model = rng.uniform(-20, 20, (6, 3))
    level = np.column_stack([model[:, :2], np.full(6, 320.0)])
    (finding,) = checks.constant_height_findings(model, level)
    assert (finding.code, finding.values["height"]) == ("control.constant-heights", 320.0)
    # Points on flat ground are at one height.
    flat = model * [1.0, 1.0, 0.0]
    assert checks.constant_height_findings(flat, flat + [0.0, 0.0, 320.0]) == []


@pytest.mark.parametrize(
    ("labels", "alike"),
    [
        (["GCP 1", "gcp1", "GCP2"], True),
        (["P01", "P1"], True),
        (["1-1", "11", "A", "A'"], False),
        (["P1", "P10", "P2"], False),
    ],
)
def test_similar_labels_are_reported(labels: list[str], alike: bool) -> None:
    assert bool(checks.similar_label_findings(labels)) is alike


def test_accuracies_in_a_wrong_unit_are_reported() -> None:
    rng = np.random.default_rng(5)
    model = rng.uniform(-20, 20, (6, 3))
    there = model + rng.normal(0.0, 0.01, model.shape)
    for sigma, doubted in ((10.0, True), (0.01, False), (0.03, False)):
        found = register_points(model, there, np.full(model.shape, sigma))
        assert bool(with_code(found.warnings, "registration.residuals-small")) is doubted


def test_two_masking_blunders_are_both_reported() -> None:
    rng = np.random.default_rng(6)
    model = rng.uniform(-20, 20, (8, 3))
    there = model + rng.normal(0.0, 0.01, model.shape)
    there[0] += [2.0, 0.0, 0.0]
    there[1] += [0.0, -3.0, 1.0]
    found = register_points(model, there)
    assert {blunder.label for blunder in found.blunders} == {"1", "2"}
    sizes = sorted(blunder.error_m for blunder in found.blunders)
    assert sizes == pytest.approx([2.0, np.sqrt(10.0)], abs=0.1)


@pytest.mark.parametrize(
    ("scale", "unit"), [(1000.0, "millimetres"), (100.2, "centimetres"), (0.001, "kilometres")]
)
def test_unit_is_recognised_by_the_scale(scale: float, unit: str) -> None:
    (said,) = checks.scale_unit_findings(scale, 0.001)
    assert (said.code, said.values["unit"]) == ("control.scale-of-unit", unit)


@pytest.mark.parametrize(
    "order", [[7, 0, 1, 2, 3, 4, 5, 6], [2, 3, 4, 5, 6, 7, 0, 1], [7, 6, 5, 4, 3, 2, 1, 0]]
)
def test_points_numbered_in_another_order_are_reported(order: list[int]) -> None:
    chance = np.random.default_rng(3)
    model = chance.uniform([0, 0, 0], [60, 25, 30], (8, 3))
    world = model + [398_000.0, 4_980_000.0, 330.0] + chance.normal(size=model.shape) * 0.01
    labels = [f"P{i}" for i in range(1, 9)]
    control = Points(labels, model, world[order], np.full(model.shape, np.nan))
    (said,) = checks.point_findings(control, labels, control.world)
    assert said.code == "control.other-order"
    assert said.values["first"] == "P1"
    assert said.values["second"] == f"P{order.index(0) + 1}"
    right = Points(labels, model, world, np.full(model.shape, np.nan))
    assert checks.point_findings(right, labels, world) == []


def test_coincident_points_are_reported() -> None:
    world = site()[1].copy()
    world[3] = world[1]
    labels = [f"P{i}" for i in range(len(world))]
    (said,) = checks.coincident_point_findings(labels, world)
    assert (said.code, said.values["labels"]) == ("control.same-coordinates", ("P1", "P3"))


def test_web_mercator_is_rejected_with_a_suggested_crs() -> None:
    """Of Web Mercator the scale is 1 / cos(latitude), but for the ellipsoid."""
    from pyproj import Transformer

    x, y = Transformer.from_crs("EPSG:4326", "EPSG:3857", always_xy=True).transform(13.7, 45.0)
    places = np.array([[x, y, 330.0], [x + 20.0, y, 340.0], [x, y + 30.0, 335.0]])
    with pytest.raises(InputError) as refused:
        checks.check_area(places, "EPSG:3857")
    assert refused.value.values["scale"] == pytest.approx(1.0 / np.cos(np.radians(45.0)), rel=5e-3)
    assert refused.value.values["suggested_crs"] == "EPSG:32633"
    utm = Transformer.from_crs("EPSG:4326", "EPSG:32633", always_xy=True).transform(13.7, 45.0)
    assert checks.check_area(np.array([[*utm, 330.0]]), "EPSG:32633") == []
