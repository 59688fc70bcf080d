"""Scenes placed and adjusted by ground control."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.messages import refused, with_code
from tests.photogrammetry.georeferencing.test_georeference import scene_of
from tests.photogrammetry.georeferencing.test_gps_priors import block
from tests.photogrammetry.made_photos import LENS, ORIGIN, abreast, around, face
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geometry.cameras import View
from vomstudio.geometry.triangulation import triangulate
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.photogrammetry.align.mapping import residuals
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.georeferencing.control import place_by_control
from vomstudio.registration.evidence import Evidence, triangulate_marks
from vomstudio.registration.similarity import fit_similarity

PLACES = np.array(
    [[-5, 0.2, 0], [5, 0.1, 0.2], [0, -0.5, 2], [-5, 0.3, 4], [5, 0, 4.2], [1, 0.5, 0]]
)


def marked(
    views: list[View], noise_px: float = 0.3, sigma: float = 0.005
) -> tuple[list[ControlPoint], list[Mark]]:
    rng = np.random.default_rng(3)
    control, marks = [], []
    for label, place in zip("ABCDEF", PLACES, strict=True):
        x, y, z = place + ORIGIN + rng.normal(0, sigma, 3)
        control.append(ControlPoint(label, (x, y, z), sigma, check=label == "F"))
        for view in views:
            pixel = view.project(place)[0] + rng.normal(0, noise_px, 2)
            if view.contains(pixel)[0]:
                marks.append(Mark(label, view.name, float(pixel[0]), float(pixel[1])))
    return control, marks


@pytest.fixture(scope="module")
def wall() -> tuple[list[View], np.ndarray, SparseScene]:
    views, points = around(), face(200)
    scene = scene_of(views, points)
    noise = np.random.default_rng(0).normal(0, 0.3, scene.track_pixels.shape)
    return views, points, replace(scene, track_pixels=(scene.track_pixels + noise).astype("f4"))


def test_control_points_place_the_model_and_a_check_point_agrees(
    wall: tuple[list[View], np.ndarray, SparseScene],
) -> None:
    views, points, scene = wall
    control, marks = marked(views)
    placed, report = place_by_control(scene, control, marks, "EPSG:32632")
    assert np.median(np.abs(placed.points + placed.origin - points - ORIGIN)) < 0.004
    assert placed.crs == "EPSG:32632"
    assert placed.scaled
    assert report.adjusted
    assert [p.role for p in report.points] == ["control"] * 5 + ["check"]
    assert report.control_rms_m is not None
    assert 0 < report.control_rms_m < 0.015
    assert report.check_rms_m is not None
    assert report.check_rms_m < 0.025
    assert all(0 < (p.residual_px or 0) < 3 for p in report.points)
    assert report.tilt_error_deg < 0.2


def test_adjustment_corrects_a_bent_scene(
    wall: tuple[list[View], np.ndarray, SparseScene],
) -> None:
    views, _, scene = wall
    control, marks = marked(views, 0.1, 0.001)
    # Cameras pushed about by some centimetres, as a weak alignment leaves them.
    rng = np.random.default_rng(5)
    pushed = []
    for view in scene.views:
        centre = view.centre + rng.normal(0, 0.004, 3)
        pushed.append(replace(view, translation=-view.rotation @ centre))
    bent = replace(scene, views=tuple(pushed))
    loose, _ = place_by_control(bent, control, marks, includes_adjustment=False)
    tied, report = place_by_control(bent, control, marks)
    truth = np.array([view.centre for view in views]) + ORIGIN

    def error(s: SparseScene) -> float:
        return float(np.median(np.linalg.norm(s.centres + s.origin - truth, axis=1)))

    assert report.adjusted
    assert error(loose) > 0.02
    assert error(tied) < 0.004
    assert np.nanmean(np.linalg.norm(residuals(tied), axis=1)) < 0.45


@pytest.mark.parametrize(
    ("row", "slip"), first_in_default_tier([(2, (0.0, 1.0, 0.0)), (1, (2.0, 0.0, 0.0))])
)
def test_mistyped_control_point_is_left_out_and_its_marks_are_not_blamed(
    wall: tuple[list[View], np.ndarray, SparseScene], row: int, slip: tuple[float, float, float]
) -> None:
    views, points, scene = wall
    control, marks = marked(views)
    control = [replace(p, check=False) for p in control]
    x, y, z = np.add(control[row].position, slip).tolist()
    control[row] = replace(control[row], position=(x, y, z))
    placed, report = place_by_control(scene, control, marks)
    label = control[row].label
    assert [p.label for p in report.points if p.role == "left out"] == [label]
    (finding,) = with_code(report.warnings, "control.left-out")
    assert finding.values["labels"] == (label,)
    assert not with_code(report.warnings, "control.wrong-mark")
    assert np.median(np.abs(placed.points + placed.origin - points - ORIGIN)) < 0.006


def test_marks_without_a_point_or_photo_are_reported_and_ignored(
    wall: tuple[list[View], np.ndarray, SparseScene],
) -> None:
    views, _, scene = wall
    control, marks = marked(views)
    marks += [Mark("Z", views[0].name, 1, 2), Mark("A", "unknown.jpg", 1, 2)]
    control.append(ControlPoint("G", (0.0, 0.0, 0.0)))
    _, report = place_by_control(scene, control, marks, includes_adjustment=False)
    assert report.points[-1].role == "unseen"
    (photos,) = with_code(report.warnings, "control.photos-without-pose")
    assert photos.values["photos"] == ("unknown.jpg",)
    (labels,) = with_code(report.warnings, "control.without-coordinates")
    assert labels.values["labels"] == ("Z",)
    (few,) = with_code(report.warnings, "control.few-marks")
    assert few.values["labels"] == ("G",)


def surveyed(
    views: list[View], depth: float, sigma: float
) -> tuple[list[ControlPoint], list[Mark]]:
    """Twelve points, every other one so far before the wall."""
    rng = np.random.default_rng(3)
    places = np.vstack([PLACES, PLACES + [0.7, 0.2, 0.4]])
    places[1::2, 1] -= depth
    control, marks = [], []
    for number, place in enumerate(places):
        x, y, z = place + ORIGIN + rng.normal(0, sigma, 3)
        control.append(ControlPoint(str(number), (x, y, z), sigma))
        for view in views:
            pixel = view.project(place)[0] + rng.normal(0, 0.4, 2)
            if view.contains(pixel)[0]:
                marks.append(Mark(str(number), view.name, float(pixel[0]), float(pixel[1])))
    return control, marks


@pytest.mark.full
def test_stated_rotation_error_covers_the_errors_of_the_survey(
    wall: tuple[list[View], np.ndarray, SparseScene],
) -> None:
    """Marks are exact, the survey errs by 6 cm, of which the residuals of five points know little:
    what the model is turned by lies within the stated 95 % in 90 to 100 % of 120 repeats, each axis
    by itself, and no more is stated than the few points ask for (Student's t for 3 degrees of
    freedom is 1.6 times 1.96)."""
    views = wall[0][::3]
    scene = scene_of(views, face(20))
    rng = np.random.default_rng(8)
    places = PLACES[:5] - np.outer([0, 2, 0, 2, 0], [0, 1, 0])
    marks = [
        Mark(str(label), view.name, *map(float, view.project(place)[0]))
        for label, place in enumerate(places)
        for view in views
        if view.contains(view.project(place)[0])[0]
    ]
    true, stated, whole = [], [], []
    for _ in range(120):
        errors = rng.normal(0, 0.06, places.shape)
        control = [
            ControlPoint(str(i), (float(x), float(y), float(z)))
            for i, (x, y, z) in enumerate(places + ORIGIN + errors)
        ]
        placed, report = place_by_control(scene, control, marks, includes_adjustment=False)
        turn = placed.views[0].rotation.T @ views[0].rotation
        about = np.degrees(Rotation.from_matrix(turn).as_rotvec())
        true.append(about)
        stated.append(report.rotation_error_deg)
        own = report.covariance[:3, :3]
        assert np.degrees(np.sqrt(np.diag(own))) == pytest.approx(report.rotation_error_deg)
        whole.append(np.radians(about) @ np.linalg.solve(own, np.radians(about)))
        assert report.centre == pytest.approx(np.mean([p.position for p in control], axis=0))
        assert report.sigma_m < 0.15
    inside = (np.abs(true) <= 1.96 * np.array(stated)).mean(axis=0)
    assert (inside >= 0.9).all(), inside
    # All three at once, with their correlations: chi squared with three degrees of freedom.
    assert np.mean(np.array(whole) <= 7.815) >= 0.9
    ratio = np.sqrt((np.square(true).mean(axis=0)) / np.square(stated).mean(axis=0))
    assert (ratio > 0.55).all(), ratio
    assert (ratio < 1.1).all(), ratio


@pytest.fixture(scope="module")
def short() -> tuple[list[View], SparseScene]:
    """Photos that all look the same way, aligned with a focal length 5 % too short."""
    views = abreast(8)
    return views, block(views, face(500), (1425.0, 800.0, 600.0, -0.05))


def centre_error(scene: SparseScene, views: list[View]) -> float:
    truth = np.array([view.centre for view in views]) + ORIGIN
    return float(np.median(np.linalg.norm(scene.centres + scene.origin - truth, axis=1)))


@pytest.mark.full
def test_accurate_control_with_depth_frees_the_focal_length(
    short: tuple[list[View], SparseScene],
) -> None:
    views, scene = short
    placed, report = place_by_control(scene, *surveyed(views, 3.0, 0.005), threads=1)
    assert placed.views[0].intrinsics.focal[0] == pytest.approx(1500, rel=0.01)
    # 5 % of 12 m are 0.6 m.
    assert centre_error(placed, views) < 0.08
    assert report.decisions[0].code == "lens.ground-estimated"
    # A wrong lens makes good points contradict each other; none is left out for that.
    assert {p.role for p in report.points} == {"control"}


@pytest.mark.full
@pytest.mark.parametrize(("depth", "sigma"), [(0.0, 0.05), (1.5, 0.1)])
def test_weak_control_does_not_free_the_focal_length(
    short: tuple[list[View], SparseScene], depth: float, sigma: float
) -> None:
    views, scene = short
    placed, report = place_by_control(scene, *surveyed(views, depth, sigma), threads=1)
    assert placed.views[0].intrinsics.focal[0] == 1425.0
    (finding,) = with_code(report.decisions, "lens.ground-held")
    assert finding.values["focal_px"] == 1425.0
    assert finding.values["required_percent"] == pytest.approx(1.5)


def test_markers_without_coordinates_are_used_as_tie_points(
    wall: tuple[list[View], np.ndarray, SparseScene],
) -> None:
    views, _, scene = wall
    control, marks = marked(views)
    four = {point.label for point in control[:4]}
    placed, report = place_by_control(scene, control[:4], marks, threads=1)
    without, _ = place_by_control(
        scene, control[:4], [mark for mark in marks if mark.label in four], threads=1
    )
    assert np.abs(placed.centres - without.centres).max() > 1e-6
    assert Finding("control.tie-points", count=2) in report.decisions
    assert not with_code(report.warnings, "control.without-coordinates")


def test_control_marks_may_name_photos_without_their_folder(
    wall: tuple[list[View], np.ndarray, SparseScene],
) -> None:
    views, _, scene = wall
    named = tuple(replace(v, name=f"images/{v.name}") for v in scene.views)
    control, marks = marked(views)
    _, report = place_by_control(
        replace(scene, views=named), control, marks, includes_adjustment=False
    )
    assert report.control_rms_m is not None


def test_too_few_or_collinear_points_are_rejected(
    wall: tuple[list[View], np.ndarray, SparseScene],
) -> None:
    views, _, scene = wall
    control, marks = marked(views)
    with refused("control.too-few", GeometryError):
        place_by_control(scene, control[:2], marks)
    with refused("control.too-few", GeometryError):
        place_by_control(scene, control, marks[:1])
    line, seen = [], []
    for i, x in enumerate((-4.0, 0.0, 2.0, 4.0)):
        place = np.array([x, 0.0, 2.0])
        line.append(ControlPoint(str(i), tuple(place + ORIGIN)))
        seen += [Mark(str(i), v.name, *map(float, v.project(place)[0])) for v in views]
    with refused("control.collinear", GeometryError):
        place_by_control(scene, line, seen)


def test_triangulation_recovers_a_point() -> None:
    views = around()
    place = np.array([0.5, 0.2, 2.0])
    pixels = [view.project(place)[0] for view in views]
    assert triangulate(views, pixels) == pytest.approx(place, abs=1e-9)
    assert np.isnan(triangulate(views[:1], pixels[:1])).all()
    assert np.isnan(triangulate([views[0]] * 2, [pixels[0]] * 2)).all()
    assert LENS.has_distortion


# --- marks that scatter -----------------------------------------------------------------------
def test_registration_errors_include_the_scatter_of_the_marks(
    wall: tuple[list[View], np.ndarray, SparseScene],
) -> None:
    """The errors are those of the marks, and the tie points are not bent to them."""
    views, points, scene = wall
    control, marks = marked(views, 25.0)
    placed, report = place_by_control(scene, control, marks)
    assert report.mark_scatter_px == pytest.approx(25.0, rel=0.3)
    assert {p.role for p in report.points} == {"control", "check"}
    # 25 pixels in eight photos at 12 m are 7 cm.
    assert np.median(np.linalg.norm(placed.points + placed.origin - points - ORIGIN, axis=1)) < 0.2
    assert 0.02 < report.sigma_m < 0.4
    before, after = (np.nanmean(np.linalg.norm(residuals(s), axis=1)) for s in (scene, placed))
    assert after < 1.1 * before


def test_consistent_marks_have_the_scatter_of_manual_marks(
    wall: tuple[list[View], np.ndarray, SparseScene],
) -> None:
    views, _, scene = wall
    _, report = place_by_control(scene, *marked(views), includes_adjustment=False)
    assert report.mark_scatter_px == pytest.approx(0.3, rel=0.3)
    assert not any(each.code == "mark-scatter" for each in report.warnings)


def test_both_commands_find_the_same_scatter_and_errors_of_marks(
    wall: tuple[list[View], np.ndarray, SparseScene],
) -> None:
    views, _, scene = wall
    control, marks = marked(views, 12.0)
    _, report = place_by_control(scene, control, marks, includes_adjustment=False)
    evidence = Evidence(views={view.name: view for view in scene.views})
    places = triangulate_marks(evidence, [(m.label, m.photo, m.x, m.y) for m in marks])
    assert evidence.mark_scatter_px == pytest.approx(report.mark_scatter_px)
    assert report.mark_scatter_px == pytest.approx(12.0, rel=0.3)
    assert sorted(places) == sorted(p.label for p in report.points if p.role != "unseen")


def test_marks_of_other_points_are_rejected(
    wall: tuple[list[View], np.ndarray, SparseScene],
) -> None:
    views, _, scene = wall
    control, marks = marked(views)
    rng = np.random.default_rng(2)
    wild = [
        replace(mark, x=float(x), y=float(y))
        for mark, (x, y) in zip(marks, rng.uniform(100, 1100, (len(marks), 2)), strict=True)
    ]
    with pytest.raises(GeometryError):
        place_by_control(scene, control, wild)


@pytest.mark.parametrize("labels", ["ABCDE", "ABDE", "ABD"])
def test_control_that_does_not_determine_the_rotation_is_rejected(
    wall: tuple[list[View], np.ndarray, SparseScene], labels: str
) -> None:
    """Two labels are exchanged, and too few others tell which is wrong."""
    views, _, scene = wall
    control, marks = marked(views)
    with pytest.raises(GeometryError):
        place_by_control(scene, exchanged(control, labels), marks)


def exchanged(control: list[ControlPoint], labels: str) -> list[ControlPoint]:
    """The points with these labels, the first two with the coordinates of each other."""
    places = {p.label: p.position for p in control}
    places["A"], places["B"] = places["B"], places["A"]
    return [
        replace(p, position=places[p.label], sigma_m=None) for p in control if p.label in labels
    ]


# --- blunders ---------------------------------------------------------------------------------
def unstated(control: list[ControlPoint], error: np.ndarray) -> list[ControlPoint]:
    """Without accuracies, each point off by its error (n, 3)."""
    return [
        ControlPoint(p.label, tuple(float(v) for v in np.array(p.position) + e))  # type: ignore[arg-type]
        for p, e in zip(control, error, strict=True)
    ]


def test_inaccurate_control_of_unknown_accuracy_does_not_distort_the_scene(
    wall: tuple[list[View], np.ndarray, SparseScene],
) -> None:
    """The survey errs by half a metre, of which nothing is stated; a pixel is some millimetres."""
    views, points, scene = wall
    control, marks = marked(views)
    error = np.random.default_rng(4).normal(0, 0.5, (6, 3))
    placed, report = place_by_control(scene, unstated(control, error), marks)
    assert np.isfinite(placed.points).all()
    # Neither the shape of the scene nor the photos have become worse by the survey's errors.
    assert np.nanmean(np.linalg.norm(residuals(placed), axis=1)) < 0.5
    shape = fit_similarity(placed.points, points)
    assert np.median(np.linalg.norm(shape(placed.points) - points, axis=1)) < 0.02
    assert 0.2 < report.sigma_m < 1.2
    assert with_code(report.warnings, "registration.weak-scale")


def test_wrong_mark_is_reported_with_its_photo_and_expected_position(
    wall: tuple[list[View], np.ndarray, SparseScene],
) -> None:
    views, points, scene = wall
    control, marks = marked(views)
    row = next(i for i, mark in enumerate(marks) if mark.label == "B")
    right = marks[row]
    marks[row] = replace(right, x=right.x + 1100.0, y=right.y - 700.0)
    placed, report = place_by_control(scene, control, marks)
    assert np.median(np.abs(placed.points + placed.origin - points - ORIGIN)) < 0.006
    assert [p.role for p in report.points] == ["control"] * 5 + ["check"]
    (finding,) = with_code(report.warnings, "control.wrong-mark")
    values = finding.values
    assert (values["label"], values["photo"], values["x"]) == ("B", right.photo, right.x + 1100.0)
    wanted = values["wanted_x"], values["wanted_y"]
    assert wanted == pytest.approx((right.x, right.y), abs=2.0)


def test_wrong_one_of_two_marks_is_identified_by_the_point_position(
    wall: tuple[list[View], np.ndarray, SparseScene],
) -> None:
    views, _, scene = wall
    control, marks = marked(views)
    own = [mark for mark in marks if mark.label == "D"][:2]
    others = [mark for mark in marks if mark.label != "D"]
    wrong = replace(own[1], x=own[1].x - 300.0, y=own[1].y + 900.0)
    _, report = place_by_control(scene, control, [*others, own[0], wrong])
    (finding,) = with_code(report.warnings, "control.wrong-mark")
    assert (finding.values["label"], finding.values["photo"]) == ("D", wrong.photo)


def test_two_labels_at_one_position_of_a_photo_are_reported(
    wall: tuple[list[View], np.ndarray, SparseScene],
) -> None:
    views, _, scene = wall
    control, marks = marked(views)
    first = next(mark for mark in marks if mark.label == "A")
    row = next(i for i, mark in enumerate(marks) if mark.label == "C" and mark.photo == first.photo)
    marks[row] = replace(marks[row], x=first.x + 1.0, y=first.y)
    _, report = place_by_control(scene, control, marks)
    (finding,) = with_code(report.warnings, "control.same-spot")
    named = {"photo": first.photo, "first": "A", "second": "C"}
    assert named.items() <= finding.values.items()


@pytest.mark.full
def test_bad_control_with_small_stated_errors_does_not_bend_a_good_block(
    wall: tuple[list[View], np.ndarray, SparseScene],
) -> None:
    views, points, scene = wall
    control, marks = surveyed(views, 1.0, 0.0)
    error = np.random.default_rng(11).normal(0, 0.08, (12, 3))
    control = [
        replace(p, position=tuple(float(v) for v in np.array(p.position) + e), sigma_m=0.01)
        for p, e in zip(control, error, strict=True)
    ]
    placed, report = place_by_control(scene, control, marks)
    # Whichever of the two it is, it is not worse than the one that is not bent.
    stiff, _ = place_by_control(scene, control, marks, includes_adjustment=False)

    def off(s: SparseScene) -> float:
        return float(np.median(np.linalg.norm(s.points + s.origin - points - ORIGIN, axis=1)))

    assert off(placed) <= 1.05 * off(stiff)
    codes = {each.code for each in (*report.decisions, *report.warnings)}
    assert codes & {"control.adjusted", "control.not-adjusted", "control.contradicts-photos"}
