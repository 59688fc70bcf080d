"""The survey check: silent on a good set, and each defect found and named."""

from __future__ import annotations

import math
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.io.photos import photo_maker
from tests.photogrammetry.surface import wall_maker as wall
from tests.tiers import first_in_default_tier
from vomstudio.core.findings import Finding
from vomstudio.geometry.plane_sizes import PlaneSizes
from vomstudio.geometry.units import length_text
from vomstudio.io.photos.reading import read_photos
from vomstudio.photogrammetry.survey.camera_positions import (
    metres_from_gps,
    rotation_error95_deg,
    width_to_length_ratio,
)
from vomstudio.photogrammetry.survey.check import check_photos, pixel_size
from vomstudio.photogrammetry.survey.check_results import ADVICE, SurveyReport, assess
from vomstudio.photogrammetry.survey.overlap import (
    choose_check_pairs,
    compare_pair,
    compare_photos,
    extract_features,
    optical_axes,
)
from vomstudio.photogrammetry.survey.photo_quality import blur, linear_light, measure_resampling
from vomstudio.photogrammetry.survey.survey_resolution import expected_planes, planes_summary


def codes(report: SurveyReport, *, grave: bool = True) -> set[str]:
    return {f.code for f in report.findings if not grave or f.severity != "info"}


def finding(report: SurveyReport, code: str) -> Finding:
    (found,) = [f for f in report.findings if f.code == code]
    return found


def few(count: int = 8, step: float = 1.2):
    """Photos along the wall, alternately face on and turned by some 25 degrees."""
    return [
        (
            (i * step - 4 + (3.4 if i % 3 == 1 else -3.4 if i % 3 == 2 else 0), 3.5, 7.5),
            (i * step - 4, 3.5 + 0.3 * (i % 2), 0),
        )
        for i in range(count)
    ]


# -- blur ----------------------------------------------------------------------------------------
def edges(sigma: float, noise: float = 0.0) -> np.ndarray:
    """Squares whose edges are Gaussian of that sigma, made at four times the resolution."""
    rng = np.random.default_rng(0)
    squares = np.kron(rng.integers(0, 2, (14, 14)), np.ones((160, 160))).astype(np.float32)
    soft = cv2.GaussianBlur(squares, (0, 0), sigma * 4)
    small = cv2.resize(soft, None, fx=1 / 4, fy=1 / 4, interpolation=cv2.INTER_AREA)
    grey = 40 + 170 * small + rng.normal(0, 1, small.shape) * noise
    return np.clip(np.round(grey), 0, 255).astype(np.uint8)


@pytest.mark.parametrize("sigma", first_in_default_tier([1.0, 1.5, 2.0, 3.0, 4.0, 6.0], 2))
def test_blur_is_the_sigma_of_an_edge(sigma: float) -> None:
    assert blur(edges(sigma)) == pytest.approx(sigma, rel=0.2)


@pytest.mark.parametrize("sigma", [1.0, 2.0, 4.0])
def test_noise_barely_changes_the_blur(sigma: float) -> None:
    assert blur(edges(sigma, noise=3.0)) == pytest.approx(sigma, rel=0.2)


def test_motion_in_one_direction_counts_as_blur() -> None:
    sharp = edges(0.8)
    moved = cv2.blur(sharp, (14, 1))
    expected = 14 / math.sqrt(12)  # standard deviation of a box of that width
    assert blur(moved) == pytest.approx(expected, rel=0.3)
    assert blur(sharp) < 1.3


def test_featureless_picture_has_no_blur_value() -> None:
    assert blur(np.full((300, 300), 128, np.uint8)) is None
    assert blur(np.full((5, 5), 128, np.uint8)) is None


def test_blurring_real_photos_always_increases_the_blur(data_dir: Path) -> None:
    from vomstudio.io.photos.pixels import grey

    for path in ("saint_martin/IMGP4169.JPG", "brighton_beach/images/DJI_0025.JPG"):
        pixels = grey(data_dir / path)
        values = [blur(cv2.GaussianBlur(pixels, (0, 0), s)) for s in (1.5, 3.0, 6.0)]
        assert blur(pixels) < values[0] < values[1] < values[2]
        assert values[1] == pytest.approx(3.0, rel=0.45)


def test_interpolation_is_detected_by_its_period() -> None:
    rng = np.random.default_rng(2)
    sharp = rng.integers(0, 255, (700, 700)).astype(np.uint8)
    assert measure_resampling(sharp) < 8
    larger = cv2.resize(sharp, (1100, 1100), interpolation=cv2.INTER_CUBIC)
    assert measure_resampling(larger) > 40


def test_srgb_values_are_converted_to_linear_light() -> None:
    found = linear_light(np.array([0, 10, 188, 255], np.uint8))
    # IEC 61966-2-1: 188 is half the light, nearly.
    assert found == pytest.approx([0.0, 10 / 255 / 12.92, 0.503, 1.0], abs=2e-3)


# -- pairs ---------------------------------------------------------------------------------------
def pair(tmp_path: Path, *stations, focal=(720.0, 720.0)):
    for i, (where, f) in enumerate(zip(stations, focal, strict=True)):
        wall.write_set(tmp_path / str(i), [where], focal=f)
    photos = [read_photos(tmp_path / str(i)).photos[0] for i in range(2)]
    a, b = (extract_features(photo) for photo in photos)
    assert a is not None
    assert b is not None
    return compare_pair(0, 1, a, b)


def test_overlap_pixel_ratio_and_baseline_match_the_cameras(tmp_path: Path) -> None:
    # 8 m away a photo shows 800 / 720 * 8 = 8.89 m; a step of 2.22 m leaves three quarters.
    found = pair(tmp_path, ((-1, 3, 8), (-1, 3, 0)), ((1.222, 3, 8), (1.222, 3, 0)))
    assert found is not None
    assert found.overlap == pytest.approx(0.75, abs=0.07)
    assert found.pixel_ratio == pytest.approx(1.0, abs=0.02)
    assert found.baseline_ratio == pytest.approx(2.222 / 8, abs=0.02)
    assert found.turn_deg == pytest.approx(0.0, abs=1.0)


def test_doubling_the_distance_doubles_the_pixel_size(tmp_path: Path) -> None:
    found = pair(tmp_path, ((0, 4, 10), (0, 4, 0)), ((0, 4, 5), (0, 4, 0)))
    assert found is not None
    # A pixel of the first covers two of the second.
    assert found.pixel_ratio == pytest.approx(2.0, rel=0.03)


def test_turning_on_the_spot_has_no_baseline(tmp_path: Path) -> None:
    found = pair(tmp_path, ((0, 3, 8), (-1.2, 3, 0)), ((0, 3, 8), (1.2, 3, 0)))
    assert found is not None
    assert found.baseline_ratio < 0.006
    assert found.turn_deg == pytest.approx(2 * math.degrees(math.atan(1.2 / 8)), abs=0.5)


def test_photos_of_other_rock_do_not_match(tmp_path: Path) -> None:
    photo_maker.write_photo(tmp_path / "a.jpg", pixels=wall.render((0, 3, 8), (0, 3, 0)))
    photo_maker.write_photo(tmp_path / "b.jpg", pixels=wall.render((0, 3, 8), (0, 3, 0), seed=9))
    a, b = (extract_features(photo) for photo in read_photos(tmp_path).photos)
    assert a is not None
    assert b is not None
    assert compare_pair(0, 1, a, b) is None


@pytest.mark.full
def test_view_directions_are_chained_over_the_set(tmp_path: Path) -> None:
    stations = few(6)
    wall.write_set(tmp_path, stations)
    look = compare_photos([extract_features(photo) for photo in read_photos(tmp_path).photos])
    axes, known = optical_axes(look, len(stations))
    assert known.all()
    truth = np.array([wall.rotation_to(*s)[2] for s in stations])
    for i in range(len(stations)):
        for j in range(i):
            assert math.degrees(math.acos(np.clip(axes[i] @ axes[j], -1, 1))) == pytest.approx(
                math.degrees(math.acos(np.clip(truth[i] @ truth[j], -1, 1))), abs=2.5
            )


def test_photos_of_large_sets_are_compared_only_with_neighbours() -> None:
    assert len(choose_check_pairs(20)) == 190
    chosen = choose_check_pairs(500)
    assert len(chosen) < 500 * 8
    assert (0, 1) in chosen
    # Neighbours in place are found though they were taken long after one another.
    places = np.column_stack([np.r_[np.arange(250.0), np.arange(250.0)], np.zeros(500)])
    assert (10, 260) in choose_check_pairs(500, places)


@pytest.mark.full
def test_components_of_a_large_set_are_joined_in_a_second_pass(monkeypatch, tmp_path: Path) -> None:
    from vomstudio.photogrammetry.survey import overlap

    # As if eight photos were many: only neighbours in order are compared at first.
    monkeypatch.setattr(overlap, "_MAX_PHOTOS_ALL_PAIRS", 2)
    monkeypatch.setattr(overlap, "_N_NEIGHBOURS", 1)
    there = [((x, 3, 8), (x, 3, 0)) for x in (-6.0, 6.0, -5.0, 5.0, -2.0, 2.0)]
    wall.write_set(tmp_path, there, gps=False)
    look = compare_photos([extract_features(photo) for photo in read_photos(tmp_path).photos])
    assert len(look.components(6)) == 1


# -- whole sets ----------------------------------------------------------------------------------
@pytest.mark.full
def test_good_photo_set_has_no_serious_findings(tmp_path: Path) -> None:
    report = check_photos(read_photos(wall.write_set(tmp_path, wall.good_stations()[:12])))
    assert codes(report) == set(), report.findings
    assert report.assessment[0].code == "survey.sound"
    assert report.next_time == ()
    assert all(photo.views >= 3 for photo in report.photos)


@pytest.mark.full
def test_blurred_dark_and_unrelated_photos_are_reported(tmp_path: Path) -> None:
    change = {
        2: lambda p: cv2.GaussianBlur(p, (0, 0), 4),
        5: lambda p: (p * 0.5).astype(np.uint8),
        7: lambda p: wall.render((0, 3, 8), (0, 3, 0), seed=11),
    }
    folder = read_photos(wall.write_set(tmp_path, few(8), change=change))
    report = check_photos(folder)
    assert finding(report, "blurred").values["photos"] == ("w02.jpg",)
    assert finding(report, "blurred").values["value"] > 3
    assert finding(report, "brightness-jump").values["photos"] == ("w05.jpg",)
    assert finding(report, "unmatched").values["photos"] == ("w07.jpg",)
    assert report.assessment[0].code == "survey.reservations"
    assert "blurred" in report.assessment[0].values["codes"]
    assert ADVICE["blurred"] in report.next_time


@pytest.mark.full
def test_black_photos_do_not_affect_the_brightness_reference(tmp_path: Path) -> None:
    dark = {i: (lambda p: np.zeros_like(p) + 3) for i in (1, 2, 3)}
    report = check_photos(read_photos(wall.write_set(tmp_path, few(5), change=dark)))
    assert finding(report, "exposure").values["photos"] == ("w01.jpg", "w02.jpg", "w03.jpg")
    assert "brightness-jump" not in codes(report)


@pytest.mark.full
def test_photos_of_two_places_are_reported_as_two_components(tmp_path: Path) -> None:
    stations = few(4)
    change = {i: (lambda p, s=s: wall.render(*s, seed=5)) for i, s in enumerate(stations)}
    wall.write_set(tmp_path, stations)
    wall.write_set(tmp_path / "other", stations, change=change)
    report = check_photos(read_photos(tmp_path))
    assert finding(report, "parts").values["value"] == 2
    assert len(finding(report, "parts").values["photos"]) == 4


@pytest.mark.full
def test_single_view_direction_is_reported_as_a_risk_of_doming(tmp_path: Path) -> None:
    stations = [((x, 3, 8), (x, 3, 0)) for x in np.arange(-4, 4.1, 1.2)]
    report = check_photos(read_photos(wall.write_set(tmp_path, stations)))
    assert finding(report, "one-direction").values["value"] < 3
    # Positions in one line, too: nothing registers them.
    assert "collinear" in codes(report)


@pytest.mark.full
def test_photos_from_one_position_are_reported(tmp_path: Path) -> None:
    spot = (0.0, 3.0, 8.0)
    stations = [*few(5), (spot, (-1.5, 3, 0)), (spot, (1.5, 3, 0))]
    report = check_photos(read_photos(wall.write_set(tmp_path, stations)))
    assert set(finding(report, "same-position").values["photos"]) == {"w05.jpg", "w06.jpg"}


@pytest.mark.full
def test_low_overlap_is_measured_and_reported(tmp_path: Path) -> None:
    # 8.9 m are seen; steps of 6 m leave a third.
    stations = [((x, 4, 8), (x, 4, 0)) for x in (-6.0, 0.0, 6.0)]
    report = check_photos(read_photos(wall.write_set(tmp_path, stations)))
    found = finding(report, "low-overlap")
    assert len(found.values["photos"]) == 3
    assert found.values["value"] == pytest.approx(1 - 6 / 8.89, abs=0.08)
    assert "few-photos" in codes(report)


@pytest.mark.full
def test_digital_zoom_is_detected_by_tag_and_by_35_mm_equivalent(tmp_path: Path) -> None:
    wall.write_set(tmp_path, few(3), exif={0xA404: photo_maker.rational(2.0)})
    wall.write_set(tmp_path / "b", few(3))
    wall.write_set(tmp_path / "c", few(1), focal=1500.0)
    report = check_photos(read_photos(tmp_path))
    named = set(finding(report, "digital-zoom").values["photos"])
    assert named == {"w00.jpg", "w01.jpg", "w02.jpg", "c/w00.jpg"}


@pytest.mark.full
def test_identical_gps_positions_are_reported(tmp_path: Path) -> None:
    here = ((0, 0, 8), (0, 0, 0))
    wall.write_set(tmp_path, few(4), gps=False)
    for i in range(3):
        photo_maker.write_photo(
            tmp_path / f"x{i}.jpg",
            pixels=wall.render((i, 3, 8), (i, 3, 0)),
            gps=wall.gps_fields(here[0]),
        )
    report = check_photos(read_photos(tmp_path))
    assert finding(report, "gps-equal").values["photos"] == ("x0.jpg", "x1.jpg", "x2.jpg")


@pytest.mark.full
def test_metre_gps_over_a_small_wall_is_reported_as_too_noisy(tmp_path: Path) -> None:
    stations = wall.good_stations()[::3]
    report = check_photos(read_photos(wall.write_set(tmp_path, stations, accuracy_m=3.0)))
    found = finding(report, "gps-noise")
    assert found.values["value"] > 20
    assert found.values["sigma_m"] == pytest.approx(3.0, rel=0.5)
    assert ADVICE["gps-noise"] in report.next_time


def test_set_without_matching_photos_is_an_error(tmp_path: Path) -> None:
    for seed in range(3):
        pixels = wall.render((0, 3, 8), (0, 3, 0), seed=20 + seed)
        photo_maker.write_photo(tmp_path / f"{seed}.jpg", pixels=pixels)
    report = check_photos(read_photos(tmp_path))
    assert finding(report, "unmatched").severity == "error"
    assert report.assessment[0].code == "survey.incomplete"


def test_single_and_featureless_photos_are_reported(tmp_path: Path) -> None:
    photo_maker.write_photo(tmp_path / "a.jpg", pixels=np.full((300, 400), 90, np.uint8))
    assert "one-photo" in codes(check_photos(read_photos(tmp_path)))
    photo_maker.write_photo(tmp_path / "b.jpg", pixels=np.full((8, 8), 91, np.uint8))
    assert "unmatched" in codes(check_photos(read_photos(tmp_path)))


@pytest.mark.full
def test_photos_rotated_by_software_are_reported(tmp_path: Path) -> None:
    wall.write_set(tmp_path, few(3), change={1: lambda p: np.rot90(p)})
    report = check_photos(read_photos(tmp_path))
    assert {"several-cameras", "survey.turned-photos"} <= codes(report, grave=False)
    # They still match: the direction of view is not that of the paper.
    assert "unmatched" not in codes(report)


@pytest.mark.full
def test_undecodable_photo_is_reported(tmp_path: Path) -> None:
    wall.write_set(tmp_path, few(5))
    path = photo_maker.write_photo(tmp_path / "z.png", (300, 300))
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2] + bytes(400))
    report = check_photos(read_photos(tmp_path))
    assert finding(report, "damaged").values["photos"] == ("z.png",)


@pytest.mark.full
def test_pixel_sizes_ten_times_apart_are_flagged(tmp_path: Path) -> None:
    near = photo_maker.drone_xmp(
        GimbalYawDegree="0", GimbalPitchDegree="-90", GimbalRollDegree="0", RelativeAltitude="4"
    )
    far = photo_maker.drone_xmp(
        GimbalYawDegree="0", GimbalPitchDegree="-90", GimbalRollDegree="0", RelativeAltitude="50"
    )
    for i, xmp in enumerate((near, near, near, far)):
        photo_maker.write_photo(
            tmp_path / f"{i}.jpg",
            pixels=wall.render((i, 3, 8), (i, 3, 0)),
            exif={0xA405: photo_maker.short(36)},
            xmp=xmp,
        )
    report = check_photos(read_photos(tmp_path))
    assert finding(report, "gsd-spread").values["value"] == pytest.approx(12.5)
    # 50 m over a focal length of 800 px.
    assert report.photos[3].gsd_m == pytest.approx(50 / 800)


# -- the real sets -------------------------------------------------------------------------------
@pytest.mark.full
def test_the_four_photos_of_saint_martin_are_few_and_nearly_parallel(data_dir: Path) -> None:
    report = check_photos(read_photos(data_dir / "saint_martin"))
    assert codes(report) == {"few-photos", "one-direction"}
    assert "no-gps" in codes(report, grave=False)
    # The published orientations differ by some degrees only.
    assert finding(report, "one-direction").values["value"] < 5


@pytest.mark.slow
def test_brighton_looks_straight_down_and_panel17_has_useless_gps(data_dir: Path) -> None:
    report = check_photos(read_photos(data_dir / "brighton_beach"))
    assert codes(report) == {"one-direction"}
    assert finding(report, "one-direction").values["straight_down"]
    # Eq. 18: 40 m at 2222 px.
    assert report.gsd_m == pytest.approx(40 / 2222.2, rel=0.02)
    assert report.smallest_plane_m == pytest.approx(18, rel=0.02)
    report = check_photos(read_photos(data_dir / "panel17"))
    assert codes(report) == {"gps-equal"}
    assert len(finding(report, "gps-equal").values["photos"]) == 5


# -- positions and words -------------------------------------------------------------------------
def test_gps_degrees_are_converted_to_metres(tmp_path: Path) -> None:
    import pyproj

    for i, (lat, lon) in enumerate(((46.0, 7.0), (46.001, 7.002), (45.999, 7.001))):
        photo_maker.write_photo(tmp_path / f"{i}.jpg", seed=i, gps=photo_maker.at(lat, lon, 10 * i))
    photos = read_photos(tmp_path).photos
    found = metres_from_gps(photos)
    geod = pyproj.Geod(ellps="WGS84")
    for i in range(3):
        for j in range(i):
            *_, truth = geod.inv(
                photos[i].longitude_deg,
                photos[i].latitude_deg,
                photos[j].longitude_deg,
                photos[j].latitude_deg,
            )
            assert np.linalg.norm(found[i, :2] - found[j, :2]) == pytest.approx(truth, rel=1e-3)
    assert found[:, 2] == pytest.approx([-10, 0, 10])


def test_rotation_error_matches_a_simulation() -> None:
    rng = np.random.default_rng(4)
    places = rng.normal(size=(12, 3)) * [15.0, 4.0, 1.0]
    stated, axis = rotation_error95_deg(places, 0.1)
    from scipy.spatial.transform import Rotation

    turns = []
    for _ in range(400):
        noisy = places + rng.normal(0, 0.1, places.shape)
        fit, _ = Rotation.align_vectors(noisy - noisy.mean(0), places - places.mean(0))
        turns.append(abs(math.degrees(fit.as_rotvec() @ axis)))
    assert float(np.quantile(turns, 0.95)) == pytest.approx(stated, rel=0.15)


def test_collinear_positions_do_not_determine_the_rotation() -> None:
    line = np.arange(5.0)[:, None] * [1.0, 2.0, 0.5]
    assert rotation_error95_deg(line, 0.1)[0] == 180
    assert width_to_length_ratio(line) == pytest.approx(0, abs=1e-12)
    assert rotation_error95_deg(np.zeros((3, 3)), 0.1)[0] == 180
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    assert width_to_length_ratio(square) == pytest.approx(1)


def test_pixel_size_requires_a_distance(tmp_path: Path) -> None:
    photo_maker.write_photo(tmp_path / "a.jpg", (400, 300), exif={0xA405: photo_maker.short(36)})
    (photo,) = read_photos(tmp_path).photos
    assert pixel_size(photo) is None
    assert pixel_size(photo, 10.0) == pytest.approx(10 / 400)


@pytest.mark.parametrize("pixel", [0.0005, 0.004, 0.018, 0.25])
def test_plane_sizes_are_formatted_like_other_lengths(pixel: float) -> None:
    planes = PlaneSizes.from_pixel_size(pixel)
    large = length_text(1000 * pixel, 2)
    small = length_text(planes.size_for_error(5.0), 2)
    assert small in planes_summary(planes)
    assert f"{large} (1000 px)" in planes_summary(planes)
    assert expected_planes(planes).values["textbook_size"] == large
    _, covered, expected = assess([], pixel)
    assert covered == Finding("survey.pixel-size", pixel=length_text(pixel, 2))
    assert expected == expected_planes(planes)
    unscaled = expected_planes(planes, is_metric=False)
    assert unscaled.values["textbook_size"] == length_text(1000 * pixel, 2, is_metric=False)


def test_verdict_always_states_the_angle_with_the_size_of_a_plane() -> None:
    *_, expected = assess([], 0.018)
    assert expected.code == "survey.planes-by-photos"
    assert (expected.values["size"], expected.values["textbook_size"]) == ("1.8 m", "18 m")
    assert expected.values["error_deg"] == pytest.approx(3.3, abs=0.05)
    assert expected.values["textbook_error_deg"] == pytest.approx(0.3, abs=0.05)
    *_, off = assess([], 0.018, planes=PlaneSizes(0.2, 0.01, 7.0))
    assert off == Finding("survey.no-planes", wanted_deg=5.0, registration_deg=7.0)
    grave = Finding("blurred", "error", photos=(), value=3.0, sharp=1.0)
    (verdict,) = assess([grave], None)
    assert (verdict.code, verdict.values["codes"]) == ("survey.incomplete", ("blurred",))
