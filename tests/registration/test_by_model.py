"""A model fitted to a reference: where it comes to lie, and how well it says that it does."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pyogrio
import pytest
import shapely
from scipy.spatial.transform import Rotation
from scipy.stats import norm

from tests.frames import ZONE, bed_grid, convert
from tests.messages import refused, with_code
from tests.registration.rock_faces import Case, ledges, once, sampled, smooth
from vomstudio.core.errors import Cancelled, GeometryError, InputError
from vomstudio.core.progress import CancelToken, SilentProgress
from vomstudio.registration.by_model.reference import FREE_PARAMETERS, fit_to_reference
from vomstudio.registration.by_model.refining import Refinement, determined_directions
from vomstudio.registration.by_model.stable import find_inside_polygons, find_near_cloud
from vomstudio.registration.by_model.subsets import cut_into_blocks, jackknife_error
from vomstudio.registration.observations import Points
from vomstudio.registration.placing import place
from vomstudio.registration.similarity import Similarity
from vomstudio.registration.similarity_observation import SimilarityObservation, difference

Array = npt.NDArray[np.float64]
STAYS = Similarity(1.0, np.eye(3), np.zeros(3))
FAR = np.array([364_520.0, 4_721_864.0, 846.0])
QUICK = Case(n=(2_500, 3_500), size=9.0)


# --- the fit --------------------------------------------------------------------------------------
def test_rotated_and_shifted_model_is_registered_accurately() -> None:
    found = once(Case(n=(10_000, 15_000), size=14.0), 1)
    assert np.abs(found.off_deg).max() < 0.03
    assert (found.stated_deg < 0.06).all()
    corner = np.array([[0.0, 0.0, 0.0], [14.0, 0.0, 14.0]])
    placed = found.placed(found.truth.inverse(corner))
    assert placed == pytest.approx(corner, abs=0.005)
    # What two samples with 1 cm of noise each leave between means of some fifty points.
    assert 0.001 < found.fitted.rms_m < 0.02
    assert found.fitted.overlap > 0.9
    assert found.fitted.free == ()
    assert found.placed.known.all


@pytest.mark.full
def test_stated_error_covers_the_true_rotation_error() -> None:
    """Eight quick ones: chance leaves one of 24 axes outside; the benchmark has hundreds."""
    found = [once(QUICK, seed) for seed in range(200, 208)]
    off = np.array([np.abs(one.off_deg) for one in found])
    stated = np.array([one.stated_deg for one in found])
    assert (off <= stated).sum() >= 20
    # And it is no larger than it need be.
    assert np.median(stated) < 4.0 * np.sqrt((off**2).mean())


@pytest.mark.full
def test_unknown_scale_is_estimated_with_its_error() -> None:
    found = once(Case(n=(6_000, 8_000), size=12.0, scale=True), 5)
    assert abs(found.off_scale) <= 1.5 * found.stated_scale
    assert found.stated_scale < 0.01
    assert np.abs(found.off_deg / found.stated_deg).max() < 1.6


def test_flat_wall_leaves_sliding_and_rotation_undetermined() -> None:
    found = once(Case(n=(3_000, 4_000), size=12.0, relief=smooth), 2)
    # It faces south: a turn about north, along its normal, shows nowhere; nor does sliding.
    assert np.isnan(found.stated_deg[1])
    assert np.abs(found.off_deg[[0, 2]]).max() < 0.05
    assert not found.placed.known.vertical
    assert found.placed.known.north
    assert not found.placed.known.position
    assert found.fitted.free == (FREE_PARAMETERS["slide"], FREE_PARAMETERS["turn"])
    assert with_code(found.fitted.warnings, "reference.little-relief")
    weakest = found.placed.rotation_error_95_deg.weakest
    assert weakest.error_deg is None
    assert abs(np.cos(np.radians(weakest.trend_deg))) > 0.99


def test_points_determine_the_parameters_that_the_wall_leaves_free() -> None:
    case = Case(n=(3_000, 4_000), size=12.0, relief=smooth)
    found = once(case, 2)
    there = np.array([[1.0, 0, 1], [11, 0, 1], [11, 0, 11], [1, 0, 11]])
    model = found.truth.inverse(there)
    points = Points(list("ABCD"), model, there, np.full((4, 3), 0.05))
    placed = place([points, found.fitted.observation], None, model)
    alone = place([points], None, model)
    assert placed.known.all
    east, north = (
        [getattr(one.rotation_error_95_deg, about) for one in (alone, placed)]
        for about in ("about_east", "about_north")
    )
    assert east[1] < 0.2 * east[0]
    assert north[1] == pytest.approx(north[0], rel=0.1)


def test_mask_excludes_moved_areas() -> None:
    rng = np.random.default_rng(7)
    reference, model = (sampled(9_000, rng, 0.005, 12.0) for _ in range(2))
    fallen = model[:, 0] > 6.0
    model[fallen, 1] += 0.08
    options = {"spacing": (0.13, 0.13), "include_scale": False}
    stable = reference[:, 0] < 5.5
    masked = fit_to_reference(model, reference, STAYS, stable=stable, **options)
    bare = fit_to_reference(model, reference, STAYS, **options)
    corners = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 12.0], [5.0, 0.0, 6.0]])
    assert masked.observation.start(corners) == pytest.approx(corners, abs=0.02)
    assert np.abs(bare.observation.start(corners) - corners).max() > 0.03
    assert masked.overlap < 0.6


@pytest.mark.full
def test_bent_model_is_reported() -> None:
    rng = np.random.default_rng(7)
    reference, model = (sampled(6_000, rng, 0.005, 12.0) for _ in range(2))
    options = {"spacing": (0.16, 0.16), "include_scale": False}
    straight = fit_to_reference(model, reference, STAYS, **options)
    model[:, 1] += 0.1 * (((model[:, 0] - 6.0) / 6.0) ** 2 + ((model[:, 2] - 6.0) / 6.0) ** 2)
    bent = fit_to_reference(model, reference, STAYS, **options)
    assert with_code(bent.warnings, "reference.bent")
    assert not with_code(straight.warnings, "reference.bent")
    assert bent.rms_m > 1.5 * straight.rms_m


def test_large_grid_coordinates_keep_their_precision() -> None:
    rng = np.random.default_rng(8)
    reference, model = sampled(4_000, rng, 0.01, 10.0), sampled(3_000, rng, 0.01, 10.0)
    options = {"spacing": (0.18, 0.16), "include_scale": False}
    near = fit_to_reference(model, reference, STAYS, **options)
    far = fit_to_reference(model, reference + FAR, Similarity(1.0, np.eye(3), FAR), **options)
    assert near.observation.start(model) + FAR == pytest.approx(
        far.observation.start(model), abs=0.003
    )
    placed = place([far.observation], None, model)
    assert placed(model) == pytest.approx(far.observation.start(model), abs=1e-6)


def test_models_without_overlap_are_rejected() -> None:
    rng = np.random.default_rng(9)
    reference, model = sampled(2_000, rng, 0.01), sampled(2_000, rng, 0.01)
    with refused("reference.apart", GeometryError):
        fit_to_reference(
            model + [500.0, 0, 0], reference, STAYS, spacing=(0.4, 0.4), include_scale=False
        )
    with refused("reference.nothing-stable", GeometryError):
        fit_to_reference(
            model,
            reference,
            STAYS,
            spacing=(0.4, 0.4),
            include_scale=False,
            stable=np.zeros(len(reference), bool),
        )


def test_fit_can_be_cancelled() -> None:
    token = CancelToken()
    token.cancel()
    rng = np.random.default_rng(9)
    points = sampled(2_000, rng, 0.01)
    with pytest.raises(Cancelled):
        fit_to_reference(
            points,
            points,
            STAYS,
            spacing=(0.4, 0.4),
            include_scale=False,
            progress=SilentProgress(token),
        )


# --- its error ------------------------------------------------------------------------------------
def clustered(seed: int, blocks: int = 16, each: int = 4) -> tuple[Refinement, Array]:
    """Misses of a wall of blocks with one error for each block and one for each place, and the
    seven numbers by least squares."""
    rng = np.random.default_rng(seed)
    cell = rng.uniform(0.0, 1.0, (blocks, blocks, each, 2))
    flat = (cell + np.indices((blocks, blocks)).transpose(1, 2, 0)[:, :, None]).reshape(-1, 2) / 2
    residuals = np.repeat(rng.normal(0, 0.02, blocks * blocks), each) + rng.normal(
        0, 0.02, len(flat)
    )
    places = np.column_stack([flat[:, 0], ledges(flat), flat[:, 1]])
    about = places.mean(axis=0)
    size = float(np.sqrt(((places - about) ** 2).sum(axis=1).mean()))
    moves = np.zeros((len(flat), 7))
    # What misses along north say of turns about east and up, and of a shift to the north.
    moves[:, 0] = -(places - about)[:, 2]
    moves[:, 2] = (places - about)[:, 0]
    moves[:, 5] = size
    held = determined_directions(moves.T @ moves, np.zeros((7, 7)))
    step = held @ (held.T @ (moves.T @ residuals))
    left = residuals - moves @ step
    ones = np.ones(len(flat))
    return (
        Refinement(STAYS, about, size, places, left, moves, left, ones, 0.03, held, np.eye(3)),
        step * [1, 1, 1, 1, size, size, size],
    )


@pytest.mark.full
def test_stated_error_includes_correlated_errors_within_blocks() -> None:
    """Least squares, where the truth is 0: the share within 95 %, of turns and of the shift."""
    inside, naive = [], []
    for seed in range(200):
        found, step = clustered(seed)
        whitening = jackknife_error(found, 0.5).whitening
        numbers = np.linalg.pinv(whitening)
        inside.append(np.abs(step) <= 1.96 * np.linalg.norm(numbers, axis=1))
        plain = found.determined_axes @ found.determined_axes.T * (found.residuals**2).mean()
        units = np.array([1, 1, 1, 1, found.size, found.size, found.size])
        naive.append(np.abs(step) <= 1.96 * np.sqrt(np.diag(plain)) * units)
    shares = np.array(inside).mean(axis=0)[[0, 2, 5]]
    # Blocks are cut without regard to what is alike, so that some is in two of them.
    assert (shares > 0.88).all()
    assert (shares < 0.996).all()
    # As if every place was independent, which ICP's own covariance takes them to be: the variance
    # of a mean is 0.02**2 + 0.02**2 / 4 in place of 2 * 0.02**2 / 4.
    taken = np.array(naive).mean(axis=0)[[0, 2, 5]]
    assert taken == pytest.approx(2 * norm.cdf(1.96 / np.sqrt(2.5)) - 1, abs=0.09)


def test_stated_error_matches_leave_one_block_out_fits() -> None:
    found, _ = clustered(3)
    spread = jackknife_error(found, 0.5)
    covariance = np.linalg.pinv(spread.whitening) @ np.linalg.pinv(spread.whitening).T
    named, side = cut_into_blocks(found.places, spread.blocks, 4 * 0.5)
    assert (int(named.max()) + 1, side) == (spread.blocks, pytest.approx(spread.side_m))
    columns = [0, 2, 5]
    moves, fits = found.design[:, columns], []
    for block in range(spread.blocks):
        rest = named != block
        fits.append(np.linalg.lstsq(moves[rest], found.residuals[rest], rcond=None)[0])
    scatter = np.sqrt((np.array(fits) ** 2).sum(axis=0)) * [1, 1, found.size]
    stated = np.sqrt(np.diag(covariance))[columns]
    # Student's t of ten degrees of freedom and more widens it by up to 14 %.
    assert (stated >= scatter).all()
    assert (stated <= 1.2 * scatter).all()


def test_directions_dominated_by_noise_are_undetermined() -> None:
    information = np.diag([9.0, 4.0, 1.0, 0.0, 16.0, 25.0, 1.0])
    noise = np.diag([0.9, 0.4, 0.8, 0.0, 0.0, 0.0, 0.2])
    held = determined_directions(information, noise)
    assert held.shape == (7, 5)
    assert held.T @ information @ held == pytest.approx(np.eye(5))
    # The third is mostly noise, of the fourth nothing is known.
    assert np.abs(held[[2, 3]]).max() < 1e-9


# --- as one observation ---------------------------------------------------------------------------
def combined(sigma: Array) -> SimilarityObservation:
    turn = Rotation.from_euler("zyx", [50.0, 12.0, -7.0], degrees=True).as_matrix()
    return SimilarityObservation(
        ["reference"], Similarity(2.0, turn, FAR), FAR + 10.0, np.diag(1.0 / sigma)
    )


def test_single_observation_is_reproduced_with_its_covariance() -> None:
    sigma = np.array([1e-3, 2e-3, 3e-3, 1e-4, 0.01, 0.02, 0.03])
    given = combined(sigma)
    model = np.random.default_rng(1).uniform(-20, 20, (50, 3))
    placed = place([given], None, model)
    assert placed(model) == pytest.approx(given.start(model), abs=1e-6)
    told = placed.rotation_error_deg
    assert [told.about_east, told.about_north, told.about_up] == pytest.approx(
        np.degrees(sigma[:3]), rel=1e-4
    )
    assert placed.scale_error_95 == pytest.approx(1.96e-4, rel=1e-3)
    assert placed.known.all
    assert placed.warnings == ()


def test_design_matrix_contains_the_derivatives_of_the_residuals() -> None:
    given = combined(np.full(7, 0.1))
    centre = FAR + [3.0, -2.0, 5.0]
    rows = given.rows(given.start, centre)
    assert rows.residuals == pytest.approx(np.zeros(7), abs=1e-7)
    for column in range(7):
        step = np.zeros(7)
        step[column] = 1e-4
        turn = Rotation.from_rotvec(step[:3]).as_matrix()
        grow = np.exp(step[3])
        moved = Similarity(
            given.start.scale * grow,
            turn @ given.start.rotation,
            grow * turn @ (given.start.translation - centre) + centre + step[4:],
        )
        change = given.rows(moved, centre).residuals - rows.residuals
        assert change / 1e-4 == pytest.approx(rows.design[:, column], abs=2e-2)


def test_two_observations_add_their_information() -> None:
    """Of the mean of two measurements with errors s and t the variance is st / (s + t)."""
    sigma = np.array([1e-3, 1e-3, 1e-3, 1e-4, 0.02, 0.02, 0.02])
    given = combined(sigma)
    both = place(
        [
            given,
            SimilarityObservation(["again"], given.start, given.rotation_centre, given.whitening),
        ],
        None,
    )
    assert both.rotation_error_deg.about_up == pytest.approx(
        np.degrees(1e-3 / np.sqrt(2)), rel=1e-4
    )


def test_point_contradicting_the_observation_is_reported() -> None:
    sigma = np.array([1e-4, 1e-4, 1e-4, 1e-5, 0.002, 0.002, 0.002])
    given = combined(sigma)
    model = np.random.default_rng(1).uniform(-20, 20, (6, 3))
    there = given.start(model)
    there[2] += [1.0, 0, 0]
    points = Points([f"P{k}" for k in range(6)], model, there, np.full((6, 3), 0.01))
    placed = place([points, given], None, model)
    assert [b.label for b in placed.blunders] == ["P2"]
    assert difference(given.start, given.start, given.rotation_centre) == pytest.approx(
        np.zeros(7), abs=1e-8
    )


# --- masks ----------------------------------------------------------------------------------------
def test_cloud_masks_the_points_near_it() -> None:
    points = np.column_stack([np.linspace(0, 10, 101), np.zeros(101), np.zeros(101)]) + FAR
    flags, reach = find_near_cloud(points, points[:11], 0.1)
    assert reach == pytest.approx(0.3)
    assert flags.sum() in (13, 14)


def test_polygons_mask_points_in_plan_view(tmp_path) -> None:
    import json

    ring = [[0, 0], [5, 0], [5, 5], [0, 5], [0, 0]]
    layer = {
        "type": "FeatureCollection",
        "crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32633"}},
        "features": [
            {
                "type": "Feature",
                "properties": {},
                "geometry": {"type": "Polygon", "coordinates": [ring]},
            }
        ],
    }
    path = tmp_path / "stable.geojson"
    path.write_text(json.dumps(layer))
    points = np.array([[1.0, 1, 90], [6, 1, 0], [4.9, 4.9, -5]])
    flags, messages = find_inside_polygons(points, path, "EPSG:32633")
    assert flags.tolist() == [True, False, True]
    assert {each.code for each in messages} <= {"frame.outside-area"}
    for wrong in (json.dumps({**layer, "features": []}), "nothing"):
        path.write_text(wrong)
        with pytest.raises(InputError) as refused:
            find_inside_polygons(points, path, "EPSG:32633")
        assert refused.value.file == str(path)


@pytest.mark.parametrize("crs", ["EPSG:4326", "EPSG:3857", "EPSG:32634"])
def test_polygons_in_another_crs_are_converted(tmp_path, crs: str) -> None:
    places = bed_grid(side_m=60.0, step_m=3.0)
    low, high = places.min(axis=0) + 14.0, places.max(axis=0) - 14.0
    ring = np.array(
        [
            [x, y, 0.0]
            for x, y in ((low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1]))
        ]
    )
    path = tmp_path / "mask.shp"
    shape = shapely.Polygon(convert(ring, crs)[:, :2])
    pyogrio.raw.write(path, shapely.to_wkb([shape]), [], [], geometry_type="Polygon", crs=crs)
    flags, messages = find_inside_polygons(places, path, ZONE)
    inside = ((places > low) & (places < high))[:, :2].all(axis=1)
    assert flags.tolist() == inside.tolist()
    assert inside.any()
    assert [each.code for each in messages] == ["frame.reprojected"]
