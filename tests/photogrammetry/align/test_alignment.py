"""Cameras and points of made photos, whose truth is known."""

from __future__ import annotations

import itertools
import sqlite3
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.messages import refused, with_code
from tests.photogrammetry.made_photos import LENS, Finder, Made, abreast, around, face, make
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import Cancelled
from vomstudio.core.findings import Finding
from vomstudio.core.progress import SilentProgress
from vomstudio.geometry.cameras import Intrinsics
from vomstudio.photogrammetry.align import adjustment, mapping
from vomstudio.photogrammetry.align.adjustment import adjust, cross_validation_error
from vomstudio.photogrammetry.align.alignment import Alignment, AlignmentOptions, align
from vomstudio.photogrammetry.align.features import Features
from vomstudio.photogrammetry.align.mapping import residuals, to_scene
from vomstudio.photogrammetry.align.match_database import read_pair_matches
from vomstudio.photogrammetry.align.priors import ALL_FIXED, Freedom
from vomstudio.photogrammetry.base.colmap import colmap
from vomstudio.registration.similarity import fit_similarity

ONE = AlignmentOptions(threads=1)


def aligned(made: Made, work: Path, options: AlignmentOptions = ONE) -> Alignment:
    return align(made.photos, work, options, Finder([made]), SilentProgress())


def camera_errors(alignment: Alignment, made: Made, part: int = 0) -> np.ndarray:
    """(n,) distances of the camera centres from the truth, after a similarity."""
    truth = {view.name: view.centre for view in made.views}
    scene = alignment.parts[part]
    wanted = np.array([truth[view.name] for view in scene.views])
    fit = fit_similarity(scene.centres, wanted)
    return np.linalg.norm(fit(scene.centres) - wanted, axis=1)


@pytest.fixture(scope="module")
def arc(tmp_path_factory: pytest.TempPathFactory) -> tuple[Made, Alignment, Path]:
    folder = tmp_path_factory.mktemp("arc")
    made = make(folder / "photos", around(), face())
    return made, aligned(made, folder / "work"), folder / "work"


def test_alignment_recovers_cameras_and_points(arc: tuple[Made, Alignment, Path]) -> None:
    made, alignment, _ = arc
    assert alignment.registered_photo_count == len(made.views)
    assert not alignment.unregistered_photos
    # A third of a pixel is 2.4 mm at 12 m.
    assert np.median(camera_errors(alignment, made)) < 0.004
    scene = alignment.parts[0]
    truth = np.array([view.centre for view in made.views])
    fit = fit_similarity(scene.centres, truth)
    from scipy.spatial import cKDTree

    distances, _ = cKDTree(made.points).query(fit(scene.points))
    assert np.median(distances) < 0.004


def test_observations_belong_to_their_photos(arc: tuple[Made, Alignment, Path]) -> None:
    made, alignment, _ = arc
    scene = alignment.parts[0]
    misses = np.linalg.norm(residuals(scene), axis=1)
    assert np.nanmean(misses) == pytest.approx(alignment.reprojection_error_px)
    # The mean length of a Gaussian in the plane, 0.3 px in each direction, less what the fit takes.
    assert 0.25 < alignment.reprojection_error_px < 0.3 * np.sqrt(np.pi / 2)
    for row, name in enumerate(view.name for view in scene.views):
        found = made.features[[p.name for p in made.photos].index(name)].keypoints[:, :2]
        mine = scene.track_pixels[scene.track_views == row]
        assert set(map(tuple, mine.tolist())) <= set(map(tuple, found.tolist()))
    assert (scene.colors == [200, 150, 100]).all()
    assert alignment.tie_point_count == (scene.track_lengths >= 3).sum() > 500


@pytest.mark.full
def test_convergent_photos_correct_a_wrong_focal_length(tmp_path: Path) -> None:
    made = make(tmp_path / "photos", around(12), face(), focal_px=1450.0)
    alignment = aligned(made, tmp_path / "work")
    camera = alignment.cameras[0]
    assert camera.focal == "freed"
    f, k1 = camera.values[0], camera.values[3]
    assert abs(f - 1500) < 3 * camera.sigma[0]
    assert camera.sigma[0] < 8
    assert k1 == pytest.approx(-0.05, abs=0.01)
    assert camera.strongest_correlation is not None


@pytest.mark.full
def test_convergent_photos_determine_all_lens_parameters(tmp_path: Path) -> None:
    lens = Intrinsics("OPENCV", 1600, 1200, (1500, 1500, 810, 594, -0.1, 0.1, 0, 0))
    made = make(tmp_path / "photos", around(12, lens), face(), noise_px=0.1, focal_px=1450.0)
    alignment = aligned(made, tmp_path / "work")
    camera = alignment.cameras[0]
    true = {"f": 1500.0, "cx": 810.0, "cy": 594.0, "k1": -0.1, "k2": 0.1}
    assert camera.model == "RADIAL"
    for name, value, sigma in zip(camera.names, camera.values, camera.sigma, strict=True):
        assert abs(value - true[name]) < 3 * sigma
    assert np.isfinite(camera.correlation).all()
    (finding,) = with_code(camera.reasons, "lens.centre-estimated")
    assert finding.values["x_px"] > 0.0
    assert np.median(camera_errors(alignment, made)) < 0.004


@pytest.mark.full
def test_parallel_photos_keep_the_principal_point_in_the_middle(tmp_path: Path) -> None:
    lens = Intrinsics("OPENCV", 1600, 1200, (1500, 1500, 810, 594, -0.06, 0.03, 0, 0))
    made = make(tmp_path / "photos", abreast(8, lens), face(relief=0.2))
    camera = aligned(made, tmp_path / "work").cameras[0]
    assert camera.focal == "held"
    assert camera.values[1:3] == (800.0, 600.0)


@pytest.mark.full
def test_parallel_photos_determine_the_distortion(tmp_path: Path) -> None:
    lens = Intrinsics("RADIAL", 1600, 1200, (1500, 800, 600, -0.06, 0.08))
    made = make(tmp_path / "photos", abreast(8, lens), face())
    camera = aligned(made, tmp_path / "work").cameras[0]
    assert camera.focal == "held"
    assert camera.values[3] == pytest.approx(-0.06, abs=3 * camera.sigma[3])
    assert camera.values[4] == pytest.approx(0.08, abs=3 * camera.sigma[4])
    # Whatever error is stated: they are found.
    assert camera.values[3:5] == pytest.approx((-0.06, 0.08), abs=0.005)
    assert with_code(camera.reasons, "lens.distortion-estimated")


@pytest.mark.full
def test_parallel_photos_keep_the_exif_focal_length(
    tmp_path: Path,
) -> None:
    made = make(tmp_path / "photos", abreast(), face(relief=0.2), focal_px=1450.0)
    camera = aligned(made, tmp_path / "work").cameras[0]
    assert camera.focal == "held"
    assert camera.values[0] == 1450.0
    assert camera.sigma[0] == 0
    (finding,) = with_code(camera.reasons, "lens.focal-held-one-direction")
    assert finding.values["spread_deg"] == pytest.approx(0.0, abs=0.05)


@pytest.mark.full
def test_unknown_focal_length_is_estimated_and_reported(tmp_path: Path) -> None:
    made = make(tmp_path / "photos", around(10), face(), focal_px=None)
    alignment = aligned(made, tmp_path / "work")
    camera = alignment.cameras[0]
    assert camera.focal == "freed"
    assert camera.values[0] == pytest.approx(1500, rel=0.01)
    (reason,) = with_code(camera.reasons, "lens.focal-estimated-without-exif")
    assert reason in alignment.notes


@pytest.mark.full
def test_cameras_with_different_photo_sizes_are_distinguished(tmp_path: Path) -> None:
    small = Intrinsics("SIMPLE_RADIAL", 1200, 1600, (1500.0, 600.0, 800.0, -0.05))
    views = around(10)
    views = [replace(view, intrinsics=small) if i % 2 else view for i, view in enumerate(views)]
    made = make(tmp_path / "photos", views, face())
    alignment = aligned(made, tmp_path / "work")
    assert alignment.registered_photo_count == 10
    assert sorted((len(c.photos), c.values[1]) for c in alignment.cameras) == [
        (5, 600.0),
        (5, 800.0),
    ]
    assert np.median(camera_errors(alignment, made)) < 0.01


@pytest.mark.full
def test_unconnected_components_are_all_kept_largest_first(tmp_path: Path) -> None:
    one = make(tmp_path / "photos", around(5), face())
    others = [replace(view, name=f"z{view.name}") for view in around(8)]
    two = make(tmp_path / "photos", others, face(seed=7))
    photos = one.photos + two.photos
    alignment = align(photos, tmp_path / "work", ONE, Finder([one, two]), SilentProgress())
    assert [len(part.views) for part in alignment.parts] == [8, 5]
    assert np.median(camera_errors(alignment, two, 0)) < 0.01
    assert np.median(camera_errors(alignment, one, 1)) < 0.01
    (finding,) = with_code(alignment.notes, "parts")
    assert finding.values["sizes"] == (8, 5)


@pytest.mark.full
def test_components_sharing_a_photo_are_aligned_and_largest_contains_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two walls, each seen by photos of its own, and one photo that shows both: too little to hold
    them together, so that the mapper places this photo twice."""
    one = make(tmp_path / "photos", around(8), face(500))
    views = [replace(view, name=f"z{view.name}") for view in around(6)]
    two = make(tmp_path / "photos", views, face(500, seed=7))
    both = one.features[3]
    joint = Features(
        *(
            np.concatenate([getattr(f, name) for f in (both, two.features[2])])
            for name in ("keypoints", "descriptors", "colors")
        ),
        both.width,
        both.height,
    )
    features = [*one.features[:3], joint, *one.features[4:], *two.features[:2], *two.features[3:]]
    photos = [*one.photos, *two.photos[:2], *two.photos[3:]]
    made = Made(photos, features, [*one.views, *views[:2], *views[3:]], one.points)
    mapped: list[list[int]] = []

    def map_photos(*args: object) -> mapping.MappingResult:
        result = mapping_photos(*args)
        mapped.extend(list(part.reg_image_ids()) for part in result.reconstructions)
        return result

    mapping_photos = mapping.map_photos
    monkeypatch.setattr(mapping, "map_photos", map_photos)
    alignment = aligned(made, tmp_path / "work")
    assert [sorted(images) for images in mapped] == [[*range(1, 9)], [4, *range(9, 14)]]
    assert [len(part.views) for part in alignment.parts] == [8, 5]
    assert not alignment.unregistered_photos
    assert np.median(camera_errors(alignment, made, 0)) < 0.01
    assert np.median(camera_errors(alignment, made, 1)) < 0.01
    assert all(len(part.points) > 100 for part in alignment.parts)
    # Every photo has one calibration, also the one that two components share.
    calibrated = [name for camera in alignment.cameras for name in camera.photos]
    assert sorted(calibrated) == sorted(photo.name for photo in photos)
    again = Alignment.load(tmp_path / "work")
    assert [len(part.views) for part in again.parts] == [8, 5]


def test_shared_photos_are_assigned_to_the_larger_component(
    arc: tuple[Made, Alignment, Path],
) -> None:
    made, _, work = arc

    def component(*rows: int) -> object:
        """COLMAP's, of these photos of the arc, as its mapper gives components that overlap."""
        found = colmap().Reconstruction(work / "part0" / "colmap")
        for image in set(found.reg_image_ids()) - {row + 1 for row in rows}:
            found.deregister_frame(found.image(image).frame_id)
        return found

    parts = mapping._sort_parts(
        {0: component(0, 1, 2), 1: component(2, 3, 4, 5, 6, 7), 2: component(2, 3, 0)}
    )
    shared = mapping.shared_images(parts)
    assert shared == [set(), {3}]
    scenes = []
    for part, images in zip(parts, shared, strict=True):
        mapping.remove_images(part, images)
        assert all(frame.has_pose() for frame in part.frames.values())
        scenes.append(to_scene(part, made.photos, made.features))
    names = [[view.name for view in scene.views] for scene in scenes]
    assert [len(part) for part in names] == [6, 2]
    assert sorted(itertools.chain(*names)) == sorted(photo.name for photo in made.photos)
    # The remaining observations are of remaining photos, at points that two of them see.
    assert all(scene.track_lengths.min() >= 2 for scene in scenes)


@pytest.mark.parametrize("cameras", [1, 2])
def test_images_without_a_pose_do_not_disturb_an_adjustment(cameras: int) -> None:
    """A deregistered frame is removed, with its camera if that has no other image; the result is
    that of a reconstruction that never contained it."""
    pycolmap = colmap()
    options = pycolmap.SyntheticDatasetOptions()
    options.num_rigs = cameras
    options.num_frames_per_rig = 6 // cameras
    results = []
    for removed in (False, True):
        pycolmap.set_random_seed(0)
        found = pycolmap.synthesize_dataset(options)
        last = sorted(found.reg_image_ids())[6 - 6 // cameras if cameras > 1 else 5 :]
        for image in last:
            found.deregister_frame(found.image(image).frame_id)
        numbers = sorted({found.image(i).camera_id for i in found.reg_image_ids()})
        if removed:
            found.tear_down()
        freedoms = {number: Freedom(True, True) for number in found.cameras}
        covariances = adjust(found, freedoms, threads=1)
        assert sorted(covariances) == numbers
        assert np.isfinite(cross_validation_error(found, freedoms, threads=1))
        assert set(found.images) == set(found.reg_image_ids())
        results.append([covariances[number] for number in numbers])
    np.testing.assert_allclose(results[0], results[1], rtol=1e-6)


def test_wrong_matches_along_a_repeated_feature_move_cameras_little(monkeypatch) -> None:
    """One track in ten runs, in half of the photos, along a repeated feature 3 pixels beside it."""
    pycolmap = colmap()
    options = pycolmap.SyntheticDatasetOptions()
    options.num_rigs, options.num_frames_per_rig, options.num_points3D = 1, 8, 300
    noise = pycolmap.SyntheticNoiseOptions()
    noise.point2D_stddev = 0.3
    errors = {}
    for loss_px in (None, adjustment.LOSS_SCALE_PX):
        monkeypatch.setattr(adjustment, "LOSS_SCALE_PX", loss_px)
        pycolmap.set_random_seed(0)
        found = pycolmap.synthesize_dataset(options)
        truth = {i: found.image(i).projection_center() for i in found.reg_image_ids()}
        pycolmap.synthesize_noise(noise, found)
        for image in sorted(truth)[:4]:
            for point in found.image(image).points2D:
                if point.has_point3D() and point.point3D_id % 10 == 0:
                    point.xy = point.xy + [3.0, 0.0]
        adjust(found, dict.fromkeys(found.cameras, ALL_FIXED), threads=1)
        centres = {i: found.image(i).projection_center() for i in truth}
        errors[loss_px] = apart(np.array([*centres.values()]), np.array([*truth.values()]))
    assert errors[adjustment.LOSS_SCALE_PX] < 0.6 * errors[None]


def apart(points: np.ndarray, truth: np.ndarray) -> float:
    """RMS distance after the best similarity."""
    off = fit_similarity(points, truth)(points) - truth
    return float(np.sqrt((off**2).sum(axis=1).mean()))


@pytest.mark.full
def test_unusable_photos_are_listed_with_a_reason(tmp_path: Path) -> None:
    made = make(tmp_path / "photos", around(), face())
    elsewhere = [replace(around()[0], name="elsewhere.jpg"), replace(around()[1], name="torn.jpg")]
    other = make(tmp_path / "photos", elsewhere, face(seed=9))
    photos = made.photos[:4] + other.photos + made.photos[4:]
    gone = replace(made.photos[0], path=tmp_path / "gone.jpg", name="gone.jpg")
    finder = Finder(
        [made, other], problems={"torn.jpg": Finding("alignment.photo-unreadable", reason="torn")}
    )
    alignment = align([*photos, gone], tmp_path / "work", ONE, finder, SilentProgress())
    assert alignment.registered_photo_count == 8
    reasons = dict(alignment.unregistered_photos)
    assert set(reasons) == {"elsewhere.jpg", "torn.jpg", "gone.jpg"}
    assert reasons["torn.jpg"] == Finding("alignment.photo-unreadable", reason="torn")
    assert reasons["elsewhere.jpg"].code == "alignment.photo-unmatched"
    assert reasons["gone.jpg"].code == "alignment.photo-unreadable"


@pytest.mark.parametrize("count", [0, 1])
def test_fewer_than_two_photos_are_refused(tmp_path: Path, count: int) -> None:
    made = make(tmp_path / "photos", around()[:count], face())
    with refused("one-photo"):
        aligned(made, tmp_path / "work")


def test_two_photos_make_a_model(tmp_path: Path) -> None:
    made = make(tmp_path / "photos", around(8)[3:5], face())
    assert aligned(made, tmp_path / "work").registered_photo_count == 2


def test_photos_without_overlap_are_refused_with_the_reason(tmp_path: Path) -> None:
    one = make(tmp_path / "photos", around()[:1], face())
    two = make(tmp_path / "photos", around()[1:2], face(seed=5))
    photos = one.photos + two.photos
    with refused("unmatched"):
        align(photos, tmp_path / "work", ONE, Finder([one, two]), SilentProgress())


@pytest.mark.full
def test_photos_from_one_position_are_refused_without_a_base(tmp_path: Path) -> None:
    view = around()[0]
    same = [replace(view, name=f"{i}.jpg") for i in range(3)]
    made = make(tmp_path / "photos", same, face())
    with refused("alignment.no-base"):
        aligned(made, tmp_path / "work")


@pytest.mark.full
def test_one_thread_and_one_seed_give_identical_results(
    arc: tuple[Made, Alignment, Path], tmp_path: Path
) -> None:
    made, first, _ = arc
    again = aligned(made, tmp_path / "work")
    one, two = first.parts[0], again.parts[0]
    assert np.array_equal(one.points, two.points)
    assert np.array_equal(one.centres, two.centres)
    assert np.array_equal(one.track_pixels, two.track_pixels)
    assert first.cameras[0].values == again.cameras[0].values


def test_finished_alignment_is_loaded_from_its_folder(arc: tuple[Made, Alignment, Path]) -> None:
    _, alignment, work = arc
    again = Alignment.load(work)
    assert np.array_equal(again.parts[0].points, alignment.parts[0].points)
    assert again.notes == alignment.notes
    assert again.cameras[0].values == alignment.cameras[0].values
    with refused("alignment.damaged"):
        Alignment.load(work / "features")


def test_matches_of_a_pair_are_read_in_either_order(arc: tuple[Made, Alignment, Path]) -> None:
    made, _, work = arc
    left, right, _, rows = read_pair_matches(work / "database.db", 2, 3)
    left, right = left[rows[:, 0]], right[rows[:, 1]]
    assert len(rows) > 300
    back, _, _, other = read_pair_matches(work / "database.db", 3, 2)
    assert np.array_equal(back[other[:, 0]], right)
    # The same point of the rock: triangulated rays meet.
    a, b = made.views[2], made.views[3]
    gap = np.cross(a.rays(left), b.rays(right)) @ (b.centre - a.centre)
    assert np.median(np.abs(gap)) < 0.01


class Stop(SilentProgress):
    """Raises Cancelled at a step of a stage."""

    def __init__(self, stage: str, at: int) -> None:
        super().__init__()
        self.wanted, self.at, self.here, self.seen = stage, at, "", []

    def stage(self, name: str, total: int | None = None) -> None:
        self.here = name
        self.seen.append((name, total))
        self.step(0)

    def step(self, done: int) -> None:
        if self.here == self.wanted and done >= self.at:
            raise Cancelled()


@pytest.mark.parametrize(
    ("stage", "at"),
    first_in_default_tier(
        [("Detecting features", 4), ("Matching photos", 8), ("Computing poses", 3)], 1
    ),
)
def test_stopped_run_resumes_where_it_stopped(
    arc: tuple[Made, Alignment, Path], tmp_path: Path, stage: str, at: int
) -> None:
    made, whole, _ = arc
    finder, work = Finder([made]), tmp_path / "work"
    with pytest.raises(Cancelled):
        align(made.photos, work, ONE, finder, Stop(stage, at))
    before = _finished(work)
    alignment = align(made.photos, work, ONE, finder, SilentProgress())
    assert sorted(finder.asked) == sorted(p.name for p in made.photos)
    if stage == "Matching photos":
        assert at <= before < 28
    assert np.array_equal(alignment.parts[0].points, whole.parts[0].points)


def _finished(work: Path) -> int:
    if not (work / "database.db").exists():
        return 0
    connection = sqlite3.connect(work / "database.db")
    try:
        return int(connection.execute("SELECT count(*) FROM two_view_geometries").fetchone()[0])
    finally:
        connection.close()


@pytest.mark.full
def test_damaged_database_is_rebuilt(arc: tuple[Made, Alignment, Path], tmp_path: Path) -> None:
    made, whole, _ = arc
    work = tmp_path / "work"
    aligned(made, work)
    data = bytearray((work / "database.db").read_bytes())
    data[4096:40960] = bytes(36864)
    (work / "database.db").write_bytes(data)
    again = aligned(made, work)
    assert np.array_equal(again.parts[0].points, whole.parts[0].points)


@pytest.mark.full
def test_stages_report_real_counts(arc: tuple[Made, Alignment, Path], tmp_path: Path) -> None:
    made, _, _ = arc
    told = Stop("", 0)
    align(made.photos, tmp_path / "work", ONE, Finder([made]), told)
    assert told.seen[:3] == [
        ("Detecting features", 8),
        ("Matching photos", 28),
        ("Computing poses", 8),
    ]


@pytest.mark.full
def test_adding_a_photo_restarts_the_matching(
    arc: tuple[Made, Alignment, Path], tmp_path: Path
) -> None:
    made, _, _ = arc
    finder, work = Finder([made]), tmp_path / "work"
    assert align(made.photos[:5], work, ONE, finder, SilentProgress()).registered_photo_count == 5
    assert align(made.photos, work, ONE, finder, SilentProgress()).registered_photo_count == 8
    assert len(finder.asked) == 8


@pytest.mark.slow
def test_many_photos_are_matched_by_likeness_and_mapped_globally(tmp_path: Path) -> None:
    made = make(tmp_path / "photos", around(70, LENS), face(500))
    options = replace(ONE, mapper="global")
    alignment = aligned(made, tmp_path / "work", options)
    assert alignment.registered_photo_count == 70
    assert alignment.notes[0].code == "alignment.matched-by-likeness"
    assert np.median(camera_errors(alignment, made)) < 0.01
