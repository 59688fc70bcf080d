"""The check of an aligned set, on scenes made by projection."""

from __future__ import annotations

import numpy as np
import pytest

from tests.messages import by_code
from tests.photogrammetry.surface.wall_maker import rotation_to
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.geometry.plane_sizes import PlaneSizes
from vomstudio.photogrammetry.align.scene_check import (
    check_scene,
    count_views_of_points,
    face_normal,
    mean_views,
    obliquity_deg,
    overlap_matrix,
    photo_pixel_sizes,
)
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.survey.check_results import ADVICE

SIZE, FOCAL = (800, 600), 800.0


def view(name: str, centre, target, focal: float = FOCAL) -> View:
    turn = rotation_to(centre, target)
    lens = Intrinsics.pinhole(*SIZE, focal, 400.0, 300.0)
    return View(name, lens, turn, -turn @ np.asarray(centre, float))


def scene(views: list[View], *, scaled: bool = True, noise_px: float = 0.5) -> SparseScene:
    """Points of a wall z = 0, each tied wherever it is seen."""
    rng = np.random.default_rng(1)
    points = np.column_stack([rng.uniform(-12, 12, 3000), rng.uniform(0, 8, 3000), np.zeros(3000)])
    points[:, 2] += rng.normal(0, 0.05, 3000)
    rows = []
    for i, v in enumerate(views):
        pixels = v.project(points)
        inside = np.flatnonzero(v.contains(pixels))
        rows += [(p, i, *pixels[p]) for p in inside]
    table = np.array(sorted(rows)).reshape(-1, 4)
    counts = np.bincount(table[:, 0].astype(int), minlength=3000)
    keep = counts >= 2
    new = np.cumsum(keep) - 1
    table = table[keep[table[:, 0].astype(int)]]
    counts = np.bincount(new[table[:, 0].astype(int)], minlength=int(keep.sum()))
    return SparseScene(
        tuple(views),
        points[keep],
        np.zeros((int(keep.sum()), 3), np.uint8),
        np.full(int(keep.sum()), noise_px, np.float32),
        np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        table[:, 1].astype(np.int32),
        table[:, 2:].astype(np.float32),
        scaled=scaled,
    )


def good_views() -> list[View]:
    found = []
    for k, y in enumerate((2.5, 5.0)):
        for i, x in enumerate(np.arange(-8, 8.1, 2.0)):
            found.append(view(f"p{k}{i}", (x, y, 8.0), (x, y, 0)))
        for i, x in enumerate(np.arange(-6, 6.1, 4.0)):
            side = 4.0 if i % 2 else -4.0
            found.append(view(f"o{k}{i}", (x + side, y, 7.0), (x, y, 0)))
    return found


def grave(report) -> set[str]:
    return {f.code for f in report.findings if f.severity != "info"}


def test_good_alignment_has_no_serious_findings() -> None:
    report = check_scene(scene(good_views()))
    assert grave(report) == set()
    assert report.assessment[0].code == "survey.sound"
    # 8 m over 800 px.
    assert report.gsd_m == pytest.approx(0.01, rel=0.03)
    assert report.smallest_plane_m == pytest.approx(10, rel=0.03)


def test_registration_with_seven_degrees_error_is_not_rated_sound() -> None:
    report = check_scene(scene(good_views()), planes=PlaneSizes(0.02, 0.005, 7.0))
    assert grave(report) == {"rotation"}
    verdict = by_code(report.assessment)
    assert "survey.sound" not in verdict
    assert verdict["survey.reservations"]["codes"] == ("rotation",)
    assert verdict["survey.no-planes"] == {"wanted_deg": 5.0, "registration_deg": 7.0}
    assert report.next_time[0] == ADVICE["rotation"]


def test_smallest_measurable_plane_depends_on_model_resolution_not_pixel_size() -> None:
    """8 m over 800 px are 1 cm, but the model resolves 30 mm."""
    report = check_scene(scene(good_views()), planes=PlaneSizes(0.03, 0.005))
    assert report.gsd_m == pytest.approx(0.01, rel=0.03)
    assert report.smallest_plane_m == pytest.approx(3.0)
    verdict = by_code(report.assessment)
    assert verdict["survey.model-resolution"] == {"size": "3.0 cm"}
    assert "survey.planes-by-model" in verdict
    assert "survey.planes-by-photos" not in verdict
    assert grave(report) == set()


def test_figures_match_the_cameras() -> None:
    views = [
        view("a", (0, 4, 8), (0, 4, 0)),
        view("b", (2, 4, 8), (2, 4, 0)),
        view("c", (0, 4, 16), (0, 4, 0)),
        view("d", (4.62, 4, 8), (0, 4, 0)),
    ]
    made = scene(views)
    assert photo_pixel_sizes(made)[:3] == pytest.approx([0.01, 0.01, 0.02], rel=0.02)
    # 8 m are seen, moved by 2 m: three quarters; the farther one sees all of the nearer.
    shares = overlap_matrix(made)
    assert shares[0, 1] == pytest.approx(0.75, abs=0.01)
    assert shares[0, 2] == 1
    assert shares[0, 0] == 0
    normal = face_normal(made)
    assert normal == pytest.approx([0, 0, 1], abs=0.01)
    assert obliquity_deg(made, normal) == pytest.approx([0, 0, 0, 30], abs=0.6)
    # The same photos from behind are as oblique: their side is the one on which they stand.
    assert obliquity_deg(made, -normal) == pytest.approx([0, 0, 0, 30], abs=0.6)
    assert 2 <= mean_views(made).min() <= mean_views(made).max() <= 4
    assert count_views_of_points(made).min() >= 2


@pytest.mark.parametrize("scaled", [True, False])
def test_local_frame_reports_no_metres(scaled: bool) -> None:
    report = check_scene(scene(good_views(), scaled=scaled))
    (*_, expected) = report.assessment
    assert expected.values["textbook_size"].endswith("units") == (not scaled)
    told = report.to_dict()
    metres = [told["gsd_m"], told["smallest_plane_m"]]
    metres += [each["size_m"] for each in told["plane_error"]]
    metres += [photo["gsd_m"] for photo in told["photos"]]
    assert [value is not None for value in metres] == [scaled] * len(metres)
    units = [told.get("gsd"), told.get("smallest_plane")]
    units += [each.get("size") for each in told["plane_error"]]
    units += [photo.get("gsd") for photo in told["photos"]]
    assert [value is None for value in units] == [scaled] * len(units)
    other = check_scene(scene(good_views(), scaled=not scaled)).to_dict()
    assert (told["gsd_m"] or told.get("gsd")) == (other["gsd_m"] or other.get("gsd"))


def test_parallel_views_in_a_line_are_reported_as_doming_and_collinear() -> None:
    views = [view(f"v{i}", (x, 3, 8), (x, 3, 0)) for i, x in enumerate(np.arange(-6, 6.1, 1.5))]
    assert {"one-direction", "collinear"} <= grave(check_scene(scene(views)))


def test_photos_turned_or_zoomed_at_one_position_are_reported() -> None:
    extra = [view("turn", (0, 2.5, 8), (3, 2.5, 0)), view("zoom", (0, 2.5, 8), (0, 2.5, 0), 1400.0)]
    report = check_scene(scene([*good_views(), *extra]))
    (found,) = [f for f in report.findings if f.code == "same-position"]
    assert set(found.values["photos"]) == {"p04", "turn", "zoom"}


def test_unregistered_photos_and_separate_components_are_reported() -> None:
    views = good_views()
    report = check_scene(
        scene(views[:12]), unregistered_names=["x.jpg"], other_parts=[scene(views[13:16])]
    )
    by_code = {f.code: f for f in report.findings}
    assert by_code["unregistered"].values["photos"] == ("x.jpg",)
    assert by_code["unregistered"].values["total"] == 16
    assert by_code["parts"].values["value"] == 2
    lost = check_scene(scene(views[:2]), unregistered_names=[f"{i}.jpg" for i in range(9)])
    assert any(f.severity == "error" for f in lost.findings)


def test_pixel_sizes_low_overlap_few_views_and_errors_are_measured() -> None:
    views = [
        view(f"v{i}", (x, 4, 8), (x + (1.5 if i % 2 else -1.5), 4, 0))
        for i, x in enumerate((-8.0, -4.0, 0.0, 4.0, 8.0))
    ]
    report = check_scene(scene([*views, view("far", (0, 4, 200), (0, 4, 0))], noise_px=3.0))
    assert {"gsd-spread", "few-views", "high-error"} <= grave(report)
    by_code = {f.code: f for f in report.findings}
    assert by_code["gsd-spread"].values["value"] == pytest.approx(25, rel=0.1)
    assert by_code["gsd-spread"].values["photos"] == ("far",)


def test_empty_scene_is_assessed_without_errors() -> None:
    empty = SparseScene(
        (),
        np.empty((0, 3)),
        np.empty((0, 3), np.uint8),
        np.empty(0, np.float32),
        np.zeros(1, np.int64),
        np.empty(0, np.int32),
        np.empty((0, 2), np.float32),
    )
    report = check_scene(empty, unregistered_names=["a.jpg", "b.jpg"])
    assert report.assessment[0].code == "survey.incomplete"
    # Placed, but without a single point.
    alone = SparseScene(
        (view("a", (0, 0, 8), (0, 0, 0)),),
        *(
            getattr(empty, n)
            for n in (
                "points",
                "colors",
                "errors_px",
                "track_offsets",
                "track_views",
                "track_pixels",
            )
        ),
    )
    assert "weak-photos" in grave(check_scene(alone))
