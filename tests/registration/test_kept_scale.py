"""A scale that is known beforehand, and what cannot be right beside the others left out."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import vomstudio as vs
from tests.messages import refused, with_code
from tests.tiers import first_in_default_tier
from vomstudio.io.control.observation_tables import Pairs
from vomstudio.registration.evidence import Evidence, register
from vomstudio.registration.placing import register_points
from vomstudio.registration.results import ModelPlacement

TURN = Rotation.from_euler("zyx", [40.0, 3.0, -5.0], degrees=True).as_matrix()
SHIFT = np.array([398_000.0, 4_980_000.0, 320.0])


def drawn(
    rng: np.random.Generator, n: int, sigma: float, scale: float = 1.0
) -> tuple[np.ndarray, np.ndarray]:
    model = rng.uniform(-1.0, 1.0, (n, 3)) * [15.0, 6.0, 8.0]
    return model, scale * model @ TURN.T + SHIFT + rng.normal(size=(n, 3)) * sigma


def by_kabsch(model: np.ndarray, world: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rotation and shift alone, by scipy."""
    a, b = model.mean(axis=0), world.mean(axis=0)
    turn = Rotation.align_vectors(world - b, model - a)[0].as_matrix()
    return turn, b - turn @ a


def test_fixed_scale_gives_the_rigid_transform_of_kabsch() -> None:
    model, world = drawn(np.random.default_rng(1), 6, 0.5)
    free = register_points(model, world)
    placed = register_points(model, world, scale=1.0)
    assert abs(free.scale - 1.0) > 0.005
    assert placed.scale == pytest.approx(1.0, abs=1e-4)
    turn, shift = by_kabsch(model, world)
    assert placed.matrix[:3, :3] == pytest.approx(turn, abs=1e-4)
    assert placed(model) == pytest.approx(model @ turn.T + shift, abs=1e-3)
    assert placed.scale_error_95 == pytest.approx(1.96e-4, rel=0.05)
    assert free.scale_error_95 is not None
    assert free.scale_error_95 > 20 * 1.96e-4


@pytest.mark.full
def test_stated_error_covers_the_true_rotation_with_fixed_scale() -> None:
    rng = np.random.default_rng(2)
    runs, inside = 60, np.zeros(3)
    for _ in range(runs):
        model, world = drawn(rng, 6, 0.05)
        placed = register_points(model, world, np.full(world.shape, 0.05), scale=1.0)
        off = np.abs(
            np.degrees(
                Rotation.from_matrix(placed.matrix[:3, :3] / placed.scale @ TURN.T).as_rotvec()
            )
        )
        told = placed.rotation_error_95_deg
        inside += off <= [told.about_east, told.about_north, told.about_up]
    # Three standard deviations of 60 runs at 95 %.
    assert (np.abs(inside / runs - 0.95) < 0.085).all()


@pytest.mark.parametrize(
    "times", first_in_default_tier([1e-3, 0.3, 0.8, 1.0, 1.5, 2.5, 10.0, 1e3], 2)
)
@pytest.mark.parametrize("stated", first_in_default_tier([True, False], 2))
def test_wrong_fixed_scale_still_matches_the_closed_form(times: float, stated: bool) -> None:
    """Rotation and shift of Kabsch's solution do not depend on the scale, for equal weights."""
    for seed in range(3):
        model, world = drawn(np.random.default_rng(seed), 6, 0.05 * times, scale=times)
        sigma = np.full(world.shape, 0.05 * times) if stated else None
        placed = register_points(model, world, sigma, scale=1.0)
        turn, shift = by_kabsch(model, world)
        assert placed.scale == pytest.approx(1.0, abs=1e-8)
        assert placed.matrix[:3, :3] / placed.scale == pytest.approx(turn, abs=1e-8)
        assert placed(model) == pytest.approx(model @ turn.T + shift, abs=1e-6)


def test_accurate_points_contradicting_the_fixed_scale_do_not_rotate_the_model() -> None:
    """Heights ten times worse than positions, as of GNSS: of a scale of 1 instead of 0.01 the
    squares alone would be least with the model on its side."""
    rng = np.random.default_rng(7)
    for times in (0.01, 0.4, 3.0):
        model, world = drawn(rng, 8, 0.0, scale=times)
        sigma = np.tile(np.array([0.02, 0.02, 0.2]) * times, (8, 1))
        world = world + rng.normal(size=world.shape) * sigma
        placed = register_points(model, world, sigma, scale=1.0)
        off = Rotation.from_matrix(placed.matrix[:3, :3] / placed.scale @ TURN.T).magnitude()
        limit = placed.rotation_error_95_deg.weakest.error_deg
        assert limit is not None
        assert np.degrees(off) < 1.5 * limit < 10.0


@pytest.mark.parametrize("stated", [True, False])
def test_points_contradicting_the_fixed_scale_are_reported(stated: bool) -> None:
    model, world = drawn(np.random.default_rng(3), 6, 0.01, scale=1.06)
    sigma = np.full(world.shape, 0.01) if stated else None
    placed = register_points(model, world, sigma, scale=1.0)
    assert placed.scale == pytest.approx(1.0, abs=1e-2)
    (finding,) = with_code(placed.warnings, "registration.scale-contradicted")
    assert finding.values["times"] == pytest.approx(1.06, abs=0.005)
    assert not [b.label for b in placed.blunders if "scale" in b.label]


def test_points_consistent_with_the_fixed_scale_give_no_finding() -> None:
    for seed in range(8):
        model, world = drawn(np.random.default_rng(seed), 6, 0.05)
        placed = register_points(model, world, scale=1.0)
        assert not with_code(placed.warnings, "registration.scale-contradicted")


def test_robust_fit_excludes_and_reports_a_wrong_point() -> None:
    model, world = drawn(np.random.default_rng(4), 8, 0.01)
    world[2] += [0.0, 2.0, 0.0]
    right = np.arange(8) != 2
    alone = register_points(model[right], world[right])
    placed = register_points(model, world, is_robust=True)
    assert placed.matrix == pytest.approx(alone.matrix, abs=1e-9 * 5e6)
    assert [b.label for b in placed.blunders] == ["3"]
    assert placed.blunders[0].error_m == pytest.approx(2.0, abs=0.1)
    (finding,) = with_code(placed.warnings, "registration.left-out")
    assert finding.values["labels"][0].startswith("3 (2")
    assert [p.label for p in placed.control] == ["1", "2", "4", "5", "6", "7", "8"]
    # As before where it was not asked for.
    kept = register_points(model, world)
    assert len(kept.control) == 8
    assert [b.label for b in kept.blunders] == ["3"]


def test_robust_fit_of_consistent_points_equals_the_plain_fit() -> None:
    model, world = drawn(np.random.default_rng(5), 8, 0.01)
    assert register_points(model, world, is_robust=True).matrix == pytest.approx(
        register_points(model, world).matrix, abs=0.0
    )


def test_command_table_and_python_give_the_same_registration(tmp_path, capsys) -> None:
    import json

    from vomstudio.cli import main

    model, world = drawn(np.random.default_rng(6), 8, 0.01)
    world[5] += [1.5, 0.0, 0.0]
    table = tmp_path / "pairs.csv"
    rows = np.hstack([model, world]).tolist()
    table.write_text(
        "label,model_x,model_y,model_z,x,y,z\n"
        + "\n".join(f"{i}," + ",".join(map(repr, row)) for i, row in enumerate(rows, 1))
    )
    code = main(["register", "-", "--pairs", str(table), "--robust", "--keep-scale", "--json"])
    assert code == 0
    found = json.loads(capsys.readouterr().out)
    with pytest.warns(vs.errors.VomWarning) as warned:
        placed = vs.register(model, world, robust=True, keep_scale=True)
    assert warned[0].message.code == "registration.left-out"
    assert isinstance(placed, ModelPlacement)
    assert found["scale"] == pytest.approx(1.0, abs=1e-4)
    assert np.array(found["matrix"]) == pytest.approx(placed.matrix, abs=1e-6)
    assert [b["label"] for b in found["blunders"]] == ["6"]
    assert len(found["control"]) == 7


@pytest.mark.parametrize("name", ["keep_scale", "robust"])
def test_non_boolean_flag_is_rejected(name: str) -> None:
    model, world = drawn(np.random.default_rng(7), 5, 0.01)
    with refused("argument.wrong-type", field=name, type="str", expected="bool"):
        vs.register(model, world, **{name: "yes"})


def test_known_scale_does_not_determine_the_vertical() -> None:
    model, world = drawn(np.random.default_rng(8), 2, 0.01)
    pairs = Pairs(("a", "b"), model, world, np.full((2, 3), np.nan), np.zeros(2, bool))
    placed = register(Evidence(pairs=pairs, scale=1.0))
    assert not placed.known.vertical
    assert placed.known.scale
