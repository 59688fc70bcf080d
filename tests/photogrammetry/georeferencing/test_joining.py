"""Parts of an alignment joined by markers, judged by a wall whose truth is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.messages import with_code
from tests.photogrammetry.georeferencing.test_georeference import scene_of
from tests.photogrammetry.made_photos import ORIGIN, around, face
from vomstudio.geometry.cameras import View
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.georeferencing.component_joining import (
    JoinReport,
    join_components,
    merge_scenes,
)
from vomstudio.photogrammetry.georeferencing.control import place_by_control
from vomstudio.photogrammetry.georeferencing.ground_adjustment import bundle_adjust
from vomstudio.photogrammetry.georeferencing.mark_observations import marks_by_point
from vomstudio.registration.similarity import Similarity, fit_similarity

MARKERS = {
    "P1": (-4.0, 0.2, 0.0),
    "P2": (4.0, 0.1, 0.2),
    "P3": (0.0, -0.8, 2.0),
    "P4": (-4.0, 0.6, 4.0),
    "P5": (4.0, 0.0, 4.2),
}


class Wall:
    """Two parts of 5 and 4 photos in frames of their own, noisy, and what was marked in them."""

    def __init__(self, noise_px: float = 0.3, mark_px: float = 0.5) -> None:
        rng = np.random.default_rng(2)
        self.views = around(9)
        self.points = [face(160, seed=1), face(150, seed=2)]
        self.parts = []
        groups = (self.views[1::2], self.views[0::2])
        for views, points in zip(groups, self.points, strict=True):
            scene = scene_of(views, points)
            noise = rng.normal(0, noise_px, scene.track_pixels.shape)
            noisy = replace(scene, track_pixels=(scene.track_pixels + noise).astype("f4"))
            self.parts.append(bundle_adjust(noisy, (), threads=1))
        turned = Similarity(
            7.0, Rotation.from_euler("xyz", [50, -20, 200], degrees=True).as_matrix(), np.ones(3)
        )
        self.parts[1] = _moved(self.parts[1], turned)
        self.parts.sort(key=lambda part: -len(part.views))
        self.marks = [
            Mark(label, view.name, *map(float, view.project(place)[0] + rng.normal(0, mark_px, 2)))
            for label, place in MARKERS.items()
            for view in self.views
            if view.contains(view.project(place))[0]
        ]

    def errors(self, scene: SparseScene) -> np.ndarray:
        """Of the camera centres, metres, after one similarity for all."""
        truth = {view.name: view.centre for view in self.views}
        wanted = np.array([truth[view.name] for view in scene.views])
        return np.linalg.norm(fit_similarity(scene.centres, wanted)(scene.centres) - wanted, axis=1)


def _moved(scene: SparseScene, by: Similarity) -> SparseScene:
    views = tuple(v.moved(by.scale, by.rotation, by.translation) for v in scene.views)
    return replace(scene, views=views, points=by(scene.points))


@pytest.fixture(scope="module")
def wall() -> Wall:
    return Wall()


@pytest.fixture(scope="module")
def joined(wall: Wall) -> tuple[SparseScene, JoinReport]:
    parts, report = join_components(wall.parts, wall.marks, threads=1)
    assert len(parts) == 1
    return parts[0], report


def test_markers_join_the_components_at_their_true_positions(
    wall: Wall, joined: tuple[SparseScene, JoinReport]
) -> None:
    scene, report = joined
    assert [view.name for view in scene.views] == [view.name for view in wall.views]
    assert len(scene.points) == 310
    # Five markers of half a pixel, 8 mm a pixel, under cameras 12 m away.
    assert np.median(wall.errors(scene)) < 0.01
    assert wall.errors(scene).max() < 0.03
    assert not report.not_joined
    (junction,) = report.joined
    assert junction.photos == (5, 4)
    assert junction.by == "markers"
    assert len(junction.markers) == 5
    assert junction.rms_px is not None
    assert 0 < junction.rms_px < 2
    assert junction.rotation_error_deg is not None
    assert 0 < max(junction.rotation_error_deg) < 0.3
    assert not junction.warnings


def test_every_observation_keeps_its_photo_and_point(
    wall: Wall, joined: tuple[SparseScene, JoinReport]
) -> None:
    scene, _ = joined
    assert sorted(np.diff(scene.track_offsets)) == [4] * 160 + [5] * 150
    assert np.nanmean(scene.errors_px) < 0.45
    for part in wall.parts:
        for row, view in enumerate(part.views):
            other = [v.name for v in scene.views].index(view.name)
            before = {tuple(p) for p in part.track_pixels[part.track_views == row]}
            after = {tuple(p) for p in scene.track_pixels[scene.track_views == other]}
            assert before == after


def test_marker_rays_meet_more_closely_than_after_the_similarity_alone(wall: Wall) -> None:
    few = [mark for mark in wall.marks if mark.label in ("P1", "P2", "P4")]
    parts, report = join_components(wall.parts, few, threads=1)
    assert with_code(report.joined[0].warnings, "control.no-redundancy")
    a, b = (placed(part, few) for part in wall.parts)
    fit = fit_similarity([b[label] for label in a], list(a.values()))
    rough = merge_scenes(wall.parts[0], wall.parts[1], fit)

    def miss(scene: SparseScene) -> float:
        found, _ = marks_by_point(scene, few)
        misses = [
            scene.views[row].project(sighting.place(scene))[0] - pixel
            for sighting in found.values()
            for row, pixel in zip(sighting.views, sighting.pixels, strict=True)
        ]
        return float(np.sqrt(np.mean(np.square(misses))))

    assert miss(parts[0]) < miss(rough)
    assert np.median(wall.errors(parts[0])) < 0.015


def placed(scene: SparseScene, marks: list[Mark]) -> dict[str, np.ndarray]:
    return {label: s.place(scene) for label, s in marks_by_point(scene, marks)[0].items()}


def test_wrong_mark_is_left_out_and_reported() -> None:
    wall = Wall()
    more = {"P6": (2.0, 0.3, 3.0), "P7": (-2.0, -0.2, 1.0)}
    marks = wall.marks + [
        Mark(label, view.name, *map(float, view.project(place)[0]))
        for label, place in more.items()
        for view in wall.views
    ]
    inside = {view.name for view in wall.parts[1].views}
    # In the one part another stone was taken for it.
    marks = [replace(m, x=m.x + 60) if m.label == "P3" and m.photo in inside else m for m in marks]
    parts, report = join_components(wall.parts, marks, threads=1)
    assert len(parts) == 1
    assert [m.label for m in report.joined[0].markers if not m.used] == ["P3"]
    (finding,) = with_code(report.joined[0].warnings, "control.left-out")
    assert finding.values["labels"] == ("P3",)
    assert np.median(wall.errors(parts[0])) < 0.01


def test_reasons_for_unjoined_components_are_reported(wall: Wall) -> None:
    two = [m for m in wall.marks if m.label in ("P1", "P2")]
    lone = wall.parts[1].views[0].name
    once = [
        m
        for m in wall.marks
        if m.label == "P3" and (m.photo == lone or m.photo in {v.name for v in wall.parts[0].views})
    ]
    parts, report = join_components(wall.parts, two + once, threads=1)
    assert len(parts) == 2
    assert not report.joined
    (finding,) = report.not_joined
    values = {
        "reason_code": "join.few-markers",
        "size": 4,
        "least": 3,
        "markers": ("P1", "P2"),
        "not_located": ("P3",),
    }
    assert values.items() <= finding.values.items()
    _, report = join_components(wall.parts, [], threads=1)
    assert report.not_joined[0].values["markers"] == ()


def test_markers_on_a_line_are_refused(wall: Wall) -> None:
    line = [
        Mark(str(x), view.name, *map(float, view.project((x, 0.0, 2.0))[0]))
        for x in (-3.0, -1.0, 1.0, 3.0)
        for view in wall.views
    ]
    parts, report = join_components(wall.parts, line, threads=1)
    assert len(parts) == 2
    assert report.not_joined[0].values["reason_code"] == "join.collinear"


def test_markers_of_other_points_join_nothing(wall: Wall) -> None:
    inside = {view.name for view in wall.parts[1].views}
    swap = {"P1": "P2", "P2": "P3", "P3": "P4", "P4": "P1"}
    wrong = [
        replace(m, label=swap.get(m.label, m.label)) if m.photo in inside else m for m in wall.marks
    ]
    parts, report = join_components(wall.parts, wrong, threads=1)
    assert len(parts) == 2
    assert report.not_joined[0].values["reason_code"] == "join.contradicted"


def test_components_with_separate_control_points_are_joined(wall: Wall) -> None:
    names = list(MARKERS)
    extra = {"Q1": (-3.0, 0.1, 1.0), "Q2": (3.0, -0.3, 1.5), "Q3": (1.0, 0.4, 3.6)}
    places = {**MARKERS, **extra}
    control = [
        ControlPoint(label, tuple(float(v) for v in np.array(place) + ORIGIN), 0.005)
        for label, place in places.items()
    ]
    first = {view.name for view in wall.parts[0].views}

    def seen(view: View, labels: list[str]) -> list[Mark]:
        return [Mark(n, view.name, *map(float, view.project(places[n])[0])) for n in labels]

    marks = [
        mark
        for view in wall.views
        for mark in seen(view, names[:4] if view.name in first else ["Q1", "Q2", "Q3"])
    ]
    parts, report = join_components(wall.parts, marks, control, threads=1)
    assert len(parts) == 1
    assert report.joined[0].by == "control points"
    scene, fitted = place_by_control(parts[0], control, marks, threads=1)
    truth = np.array([view.centre for view in wall.views]) + ORIGIN
    assert fitted.adjusted
    assert np.median(np.linalg.norm(scene.centres + scene.origin - truth, axis=1)) < 0.02


def test_photo_in_both_components_is_kept_once(wall: Wall) -> None:
    extra = scene_of([*wall.views[1::2], wall.views[0]], wall.points[0])
    parts, _ = join_components([wall.parts[0], extra], wall.marks, threads=1)
    assert [view.name for view in parts[0].views] == [view.name for view in wall.views]
    assert (np.diff(parts[0].track_offsets) >= 2).all()
    assert np.nanmean(parts[0].errors_px) < 0.45


def test_one_thread_gives_identical_results(
    wall: Wall, joined: tuple[SparseScene, JoinReport]
) -> None:
    again, _ = join_components(wall.parts, wall.marks, threads=1)
    assert np.array_equal(again[0].points, joined[0].points)
    assert np.array_equal(again[0].centres, joined[0].centres)
