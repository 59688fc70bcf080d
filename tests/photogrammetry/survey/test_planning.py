"""Plans of surveys against the pinhole, closed forms and the textbook."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from tests.io.photos import photo_maker
from tests.messages import refused, with_code
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import InputError, UsageError
from vomstudio.photogrammetry.survey.plan_camera import PlanCamera, parse_camera
from vomstudio.photogrammetry.survey.planning import depth_of_field, distance_for_gsd, plan_survey
from vomstudio.photogrammetry.survey.survey_options import PlanOptions
from vomstudio.products.report.field_sheet import draw_field_sheet, write_field_sheet

APSC = PlanCamera("test", 24.0, 16.0, 24.0, 6000, 4000)


def test_pixel_size_footprint_and_spacing_follow_equation_18() -> None:
    plan = plan_survey(APSC, PlanOptions(width_m=30.0, height_m=10.0, distance_m=20.0))
    # Sw * D / (f * Iw): 24 mm * 20 m / (24 mm * 6000).
    assert plan.gsd_m == pytest.approx(20 / 6000)
    assert plan.footprint_m == pytest.approx((20.0, 20 * 2 / 3))
    assert plan.spacing_m == pytest.approx((0.3 * 20, 0.3 * 40 / 3))
    assert plan.smallest_plane_m == pytest.approx(1000 * plan.gsd_m)


def test_distance_for_a_requested_pixel_size_gives_that_pixel_size() -> None:
    plan = plan_survey(APSC, PlanOptions(width_m=30.0, height_m=10.0, gsd_m=0.002))
    assert plan.distance_m == pytest.approx(distance_for_gsd(APSC, 0.002)) == pytest.approx(12.0)
    assert plan.gsd_m == pytest.approx(0.002)
    # Both given: the distance counts, and the wish is not kept silent.
    plan = plan_survey(APSC, PlanOptions(width_m=30.0, height_m=10.0, distance_m=24.0, gsd_m=0.002))
    assert plan.gsd_m == pytest.approx(0.004)
    (finding,) = with_code(plan.warnings, "plan.too-far")
    assert finding.values["closer"] == pytest.approx(12.0)


def test_requested_smallest_plane_is_a_thousand_pixels_wide() -> None:
    plan = plan_survey(APSC, PlanOptions(width_m=30.0, height_m=10.0, plane_m=2.0))
    # 2 mm a pixel, for which this camera stands 12 m away.
    assert plan.gsd_m == pytest.approx(0.002)
    assert plan.distance_m == pytest.approx(12.0)
    assert plan.smallest_plane_m == pytest.approx(2.0)
    # Of two wishes the finer counts.
    assert plan_survey(
        APSC, PlanOptions(width_m=30.0, height_m=10.0, plane_m=2.0, gsd_m=0.001)
    ).distance_m == pytest.approx(6.0)
    assert plan_survey(
        APSC, PlanOptions(width_m=30.0, height_m=10.0, plane_m=0.5, gsd_m=0.001)
    ).distance_m == pytest.approx(3.0)
    with refused("option.not-a-length", UsageError, field="--plane"):
        plan_survey(APSC, PlanOptions(width_m=30.0, height_m=10.0, plane_m=0.0))


def test_high_rows_warning_suggests_a_distance_only_for_several_rows() -> None:
    """One row that shows all of a high face is still too high for a hand."""
    plan = plan_survey(APSC, PlanOptions(width_m=60.0, height_m=20.0, distance_m=40.0))
    (finding,) = with_code(plan.warnings, "plan.high-row")
    assert finding.values["height_m"] == pytest.approx(10.0)
    closer = plan_survey(APSC, PlanOptions(width_m=60.0, height_m=20.0, distance_m=10.0)).warnings
    # A footprint of 20 m in height: 2/3 of the distance.
    (finding,) = with_code(closer, "plan.high-rows")
    assert finding.values["distance_m"] == pytest.approx(30.0)


def test_camera_with_an_overlong_name_is_rejected_briefly() -> None:
    for words in ("q" * 10_000, "a\0b"):
        with refused("plan.unknown-camera", UsageError) as caught:
            parse_camera(words)
        assert len(str(caught.value)) < 400


def test_depth_of_field_follows_the_thin_lens() -> None:
    f, n, c, d = 35.0, 8.0, 0.01, 5.0
    near, far = depth_of_field(f, n, d, c)
    assert far is not None

    def circle(x_m: float) -> float:
        """Diameter of the circle on the sensor of a point at x, focused at d (lens equation)."""
        image_d = f * d * 1000 / (d * 1000 - f)
        image_x = f * x_m * 1000 / (x_m * 1000 - f)
        return f / n * abs(image_x - image_d) / image_x

    assert circle(near) == pytest.approx(c, rel=1e-9)
    assert circle(far) == pytest.approx(c, rel=1e-9)
    # At the hyperfocal distance and beyond, infinity is sharp.
    hyperfocal = (f * f / (n * c) + f) / 1000
    assert depth_of_field(f, n, hyperfocal * 1.001, c)[1] is None
    assert depth_of_field(f, n, hyperfocal, c)[0] == pytest.approx(hyperfocal / 2, rel=1e-6)


@pytest.mark.parametrize("manner", ["handheld", "drone", "terrain"])
@pytest.mark.parametrize("overlap", [0.6, 0.7, 0.8])
def test_every_point_is_covered_by_four_photos(manner, overlap: float) -> None:
    plan = plan_survey(
        APSC,
        PlanOptions(width_m=40.0, height_m=12.0, distance_m=15.0, overlap=overlap, manner=manner),
    )
    assert plan.views_least >= (3 if overlap == 0.6 and manner == "handheld" else 4)
    # Counted anew, by projecting places through each camera.
    for place in ([0.0, 0, 0], [40.0, 12, 0], [17.0, 5, 0]):
        seen = 0
        for s in plan.positions:
            centre = np.array([s.along_m, s.up_m, s.away_m])
            z = np.array([s.target_along_m, s.target_up_m, 0]) - centre
            z /= np.linalg.norm(z)
            x = np.cross(z, [0, 1, 0])
            x /= np.linalg.norm(x)
            y = np.cross(z, x)
            ray = np.subtract(place, centre)
            inside = abs(ray @ x / (ray @ z)) <= 0.5 + 1e-9
            seen += inside and abs(ray @ y / (ray @ z)) <= 1 / 3 + 1e-9
        assert seen >= plan.views_least


def test_neighbours_have_the_requested_overlap_and_distance() -> None:
    plan = plan_survey(APSC, PlanOptions(width_m=40.0, height_m=8.0, distance_m=15.0, overlap=0.75))
    straight = plan.select_kind("perpendicular")
    steps = np.diff([s.along_m for s in straight])
    assert 1 - steps.max() / plan.footprint_m[0] >= 0.75 - 1e-9
    for s in plan.positions:
        away = math.dist((s.along_m, s.up_m, s.away_m), (s.target_along_m, s.target_up_m, 0.0))
        assert away == pytest.approx(15.0)
    # Textbook 3.2.1: obliques at 60 degrees to the surface, from both sides.
    assert {round(s.turn_deg) for s in plan.select_kind("oblique")} == {-30, 30}
    drone = plan_survey(
        APSC, PlanOptions(width_m=40.0, height_m=8.0, distance_m=15.0, manner="drone")
    )
    assert {round(s.tilt_deg) for s in drone.select_kind("oblique")} == {-30}


def test_one_position_gets_one_photo() -> None:
    for manner in ("handheld", "drone", "terrain"):
        plan = plan_survey(
            APSC, PlanOptions(width_m=40.0, height_m=12.0, distance_m=15.0, manner=manner)
        )
        places = np.array([[s.along_m, s.up_m, s.away_m] for s in plan.positions])
        apart = np.linalg.norm(places[:, None] - places[None], axis=2)
        assert apart[~np.eye(len(places), dtype=bool)].min() > 0.02 * 15


def test_control_points_are_spread_and_not_in_line() -> None:
    plan = plan_survey(APSC, PlanOptions(width_m=30.0, height_m=10.0, distance_m=15.0))
    control = np.array([[p.along_m, p.up_m] for p in plan.control_points if p.use == "control"])
    assert len(control) >= 4
    s = np.linalg.svd(control - control.mean(0), compute_uv=False)
    assert s[1] / s[0] > 0.2
    assert any(p.use == "check" for p in plan.control_points)
    assert not with_code(plan.warnings, "plan.narrow-strip")
    strip = plan_survey(APSC, PlanOptions(width_m=60.0, height_m=5.0, distance_m=15.0))
    assert with_code(strip.warnings, "plan.narrow-strip")


def test_rows_out_of_reach_are_reported() -> None:
    low = plan_survey(APSC, PlanOptions(width_m=20.0, height_m=4.0, distance_m=10.0))
    assert not with_code(low.warnings, "plan.high-rows")
    high = plan_survey(APSC, PlanOptions(width_m=20.0, height_m=15.0, distance_m=10.0))
    (finding,) = with_code(high.warnings, "plan.high-rows")
    # 15 m high at 2/3.
    assert finding.values["distance_m"] == pytest.approx(22.5)


@pytest.mark.parametrize(
    ("field", "options"),
    [
        ("--distance", {"distance_m": 0.0}),
        ("--distance", {"distance_m": float("nan")}),
        ("--gsd", {"gsd_m": -1.0}),
        ("--overlap", {"distance_m": 5.0, "overlap": 0.3}),
        ("--overlap", {"distance_m": 5.0, "overlap": 1.0}),
        ("--aperture", {"distance_m": 5.0, "aperture": 0.0}),
        ("--distance", {"distance_m": 0.02}),
        ("--distance", {}),
    ],
)
def test_invalid_plan_options_are_rejected_with_their_field(field, options) -> None:
    with pytest.raises(UsageError) as caught:
        plan_survey(APSC, PlanOptions(width_m=20.0, height_m=5.0, **options))
    assert caught.value.field == field


def test_plan_with_too_many_photos_is_rejected() -> None:
    with refused("plan.too-many-photos", UsageError):
        plan_survey(APSC, PlanOptions(width_m=5000.0, height_m=5000.0, distance_m=5.0))


# -- the camera ----------------------------------------------------------------------------------
@pytest.mark.parametrize(
    "words",
    [
        "23.5x15.6,35,6000x4000",
        "23.5 35 6000 4000",
        "sensor=23.5 focal=35 pixels=6000x4000",
        "35,6000x4000,23.5x15.6",
        "6000x4000 23.5x15.6 35",
        "f=35;px=6000;sensor=23.5x15.667",
    ],
)
def test_camera_is_parsed_from_its_numbers(words: str) -> None:
    found = parse_camera(words)
    assert (found.sensor_width_mm, found.focal_mm) == (23.5, 35)
    assert (found.width_px, found.height_px) == (6000, 4000)


@pytest.mark.parametrize(
    "words",
    ["1,2", "23.5x15.6x3,35,6000", "-3,35,6000", "lens=3 f=2", "0,0,0", "1 2 3 4 5", "=", ","],
)
def test_invalid_camera_numbers_are_rejected(words: str) -> None:
    with pytest.raises(UsageError, match="camera"):
        parse_camera(words)


def test_a_camera_is_found_by_name_with_its_lens() -> None:
    assert parse_camera("DJI Air 2S").focal_mm == 8.38
    assert parse_camera("canon eos 450d", 50.0).focal_mm == 50
    with refused("plan.no-focal-length", UsageError):
        parse_camera("Canon EOS 450D")
    with refused("plan.unknown-camera", UsageError):
        parse_camera("Nikon D9O")


def test_photo_defines_its_camera(tmp_path: Path, data_dir: Path) -> None:
    found = parse_camera(str(data_dir / "brighton_beach" / "images" / "DJI_0018.JPG"))
    # A pixel at 40 m by the focal length of 2222 px.
    assert distance_for_gsd(found, 0.018) == pytest.approx(0.018 * 2222.22, rel=1e-4)
    assert (found.width_px, found.height_px) == (4000, 2250)
    bare = photo_maker.write_photo(tmp_path / "a.jpg")
    with refused("plan.photo-without-camera", UsageError):
        parse_camera(str(bare))
    (tmp_path / "b.jpg").write_text("x")
    with pytest.raises(InputError, match=r"b\.jpg"):
        parse_camera(str(tmp_path / "b.jpg"))


# -- the sheet -----------------------------------------------------------------------------------
@pytest.mark.parametrize("ending", first_in_default_tier(["pdf", "svg", "html"]))
def test_field_sheet_is_written_with_the_numbers_of_the_plan(tmp_path: Path, ending: str) -> None:
    plan = plan_survey(APSC, PlanOptions(width_m=30.0, height_m=10.0, distance_m=20.0))
    path = tmp_path / f"sheet.{ending}"
    write_field_sheet(path, plan)
    data = path.read_bytes()
    assert data.startswith({"pdf": b"%PDF", "svg": b"<?xml", "html": b"<!doctype"}[ending])
    if ending == "html":
        text = data.decode()
        assert "3.33 mm" in text
        assert "<svg" in text
        assert text.count("<tr>") > len(plan.positions)
        assert "http" not in text.replace("http://www.w3.org", "").replace(
            "http://purl.org", ""
        ).replace("http://creativecommons.org", "").replace("https://matplotlib.org", "")
    assert list(tmp_path.iterdir()) == [path]


def test_all_texts_of_the_sheet_are_inside_the_page() -> None:
    plan = plan_survey(APSC, PlanOptions(width_m=60.0, height_m=15.0, distance_m=10.0))
    assert len(plan.warnings) == 1
    figure = draw_field_sheet(plan)
    figure.draw_without_rendering()
    width, height = figure.get_size_inches() * figure.dpi
    for text in figure.texts:
        box = text.get_window_extent()
        assert box.x0 >= 0
        assert box.x1 <= width
        assert box.y0 >= 0
        assert box.y1 <= height


def test_sheet_in_another_format_is_rejected(tmp_path: Path) -> None:
    plan = plan_survey(APSC, PlanOptions(width_m=30.0, height_m=10.0, distance_m=20.0))
    with pytest.raises(UsageError, match=r"\.pdf"):
        write_field_sheet(tmp_path / "a.docx", plan)


@pytest.mark.parametrize(
    ("name", "width"),
    # As the textbook's photos of the Mi 9T Pro (exercise 4) and their makers' usual photos are.
    [("Mi 9T Pro", 4000), ("Mavic Air 2", 4000), ("Mini 3 Pro", 4032), ("iPhone 15 Pro", 4032)],
)
def test_cameras_have_true_pixels_and_not_those_of_an_enlarged_mode(name: str, width: int) -> None:
    camera = parse_camera(name)
    assert camera.width_px == width
    gsd = plan_survey(camera, PlanOptions(width_m=30.0, height_m=10.0, distance_m=20.0)).gsd_m
    assert gsd == pytest.approx(camera.sensor_width_mm / width * 20.0 / camera.focal_mm)


def test_fixed_aperture_is_kept_and_reported() -> None:
    phone = parse_camera("Mi 9T Pro")
    plan = plan_survey(phone, PlanOptions(width_m=30.0, height_m=10.0, distance_m=20.0))
    assert plan.f_number == 1.75
    assert not with_code(plan.warnings, "plan.fixed-aperture")
    asked = plan_survey(
        phone, PlanOptions(width_m=30.0, height_m=10.0, distance_m=20.0, aperture=8.0)
    )
    assert asked.f_number == 1.75
    assert asked.depth_of_field_m == plan.depth_of_field_m
    (finding,) = with_code(asked.warnings, "plan.fixed-aperture")
    assert finding.values["f_number"] == 1.75
    assert (
        plan_survey(APSC, PlanOptions(width_m=30.0, height_m=10.0, distance_m=20.0)).f_number == 8.0
    )
    assert (
        plan_survey(
            APSC, PlanOptions(width_m=30.0, height_m=10.0, distance_m=20.0, aperture=11.0)
        ).f_number
        == 11.0
    )
