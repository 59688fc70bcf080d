"""Marks that do not meet: by names, and by pixels that are counted otherwise."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest

from tests.messages import refused
from tests.registrations import TURN
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import GeometryError
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.registration.marks.mark_checks import (
    most_similar_name,
    name_findings,
    require_photo_pixels,
)

Array = npt.NDArray[np.float64]
WIDTH, HEIGHT = 4000, 3000
LENS = Intrinsics.pinhole(WIDTH, HEIGHT, 3200.0, 2000.0, 1500.0)


def cameras(kind: str, rng: np.random.Generator) -> dict[str, View]:
    """Six around a face, or six side by side that look the same way."""
    views = {}
    for number in range(6):
        if kind == "arc":
            angle = -0.8 + 0.32 * number
            centre = np.array([4 + 14 * np.sin(angle), -14 * np.cos(angle), 2.0 + 0.3 * number])
            forward = np.array([4.0, 2.0, 2.0]) + rng.normal(size=3) - centre
        else:
            centre = np.array([-1.0 + 2.0 * number, -14.0, 2.0]) + rng.normal(size=3) * 0.1
            forward = np.array([0.0, 1.0, 0.0])
        forward /= np.linalg.norm(forward)
        right = np.cross(forward, [0, 0, 1.0])
        right /= np.linalg.norm(right)
        rotation = np.stack([right, np.cross(forward, right), forward])
        name = f"IMG_{number:02d}.jpg"
        views[name] = View(name, LENS, rotation, -rotation @ centre)
    return views


def survey(kind: str, seed: int, noise: float = 0.5, world_noise: float = 0.01):  # type: ignore[no-untyped-def]
    """Cameras, marks and coordinates of eight points."""
    rng = np.random.default_rng(seed)
    views = cameras(kind, rng)
    points = rng.uniform([1.0, -1.0, 0.0], [7.0, 4.0, 4.0], (8, 3))
    there = 2.5 * points @ TURN.T + [398_000.0, 4_980_000.0, 320.0]
    there += rng.normal(size=there.shape) * world_noise
    marks = []
    for name, view in views.items():
        for number, (x, y) in enumerate(view.project(points) + rng.normal(size=(8, 2)) * noise):
            if 0 < x < WIDTH and 0 < y < HEIGHT:
                marks.append((f"P{number}", name, float(x), float(y)))
    return views, marks, {f"P{i}": tuple(place) for i, place in enumerate(there)}


@pytest.mark.parametrize("kind", ["arc", "strip"])
@pytest.mark.parametrize(
    ("change", "named"),
    [
        (lambda x, y: (x / 2, y / 2), "multiplied by 2."),
        (lambda x, y: (x * 2, y * 2), "multiplied by 0.5."),
        (lambda x, y: (x * 0.3, y * 0.3), "multiplied by 3.3"),
        (lambda x, y: (y, x), "column and row are swapped"),
        (lambda x, y: (x, HEIGHT - y), "from the lower edge"),
        (lambda x, y: (WIDTH - x, y), "from the right edge"),
        (lambda x, y: (WIDTH - x, HEIGHT - y), "rotated by 180"),
        (lambda x, y: (HEIGHT - y, x), "rotated by 90"),
        (lambda x, y: (y, WIDTH - x), "rotated by 270"),
        (lambda x, y: (x - WIDTH / 2, HEIGHT / 2 - y), "rows increasing upward"),
        (lambda x, y: (x - WIDTH / 2, y - HEIGHT / 2), "rows increasing downward"),
    ],
)
def test_marks_in_another_pixel_convention_are_rejected(
    kind: str, change: Callable[[float, float], tuple[float, float]], named: str
) -> None:
    views, marks, world = survey(kind, 3)
    wrong = [(label, photo, *change(x, y)) for label, photo, x, y in marks]
    with refused("control.other-pixels", GeometryError) as failure:
        require_photo_pixels(wrong, views, world)
    assert named in f"{failure.value.values['change']}."


@pytest.mark.parametrize("kind", first_in_default_tier(["arc", "strip"], 1))
def test_valid_marks_are_accepted(kind: str) -> None:
    """Set roughly, beside coordinates that are poor, with two of these exchanged."""
    for seed in range(10):
        views, marks, world = survey(kind, seed, 6.0 if seed % 2 else 1.0, 0.3)
        world["P0"], world["P1"] = world["P1"], world["P0"]
        require_photo_pixels(marks, views, world)


def test_unmatched_names_are_reported_with_the_most_similar_name() -> None:
    views, marks, _ = survey("arc", 1)
    points = [f"P{i:02d}" for i in range(8)]
    strange = [("P00", "DSC_00.jpg", 1.0, 1.0), *marks]
    photos, labels, few = name_findings(points, strange, views)
    assert photos.code == "control.photos-without-pose"
    assert photos.values["photos"] == ("DSC_00.jpg (IMG_00.jpg?)",)
    assert labels.code == "control.without-coordinates"
    assert "P0 (P00?)" in labels.values["labels"]
    assert few.code == "control.few-marks"
    assert "P07" in few.values["labels"]
    assert name_findings([f"P{i}" for i in range(8)], marks, views) == []
    once = [mark for mark in marks if mark[0] != "P3" or mark[1] == "IMG_02.jpg"]
    (few,) = name_findings([f"P{i}" for i in range(8)], once, views)
    assert (few.code, few.values["labels"]) == ("control.few-marks", ("P3",))


@pytest.mark.parametrize("name", ["p 7", "P07", "P_7", "P-007"])
def test_most_similar_name_differs_in_spelling_only(name: str) -> None:
    assert most_similar_name(name, ["P1", "P7", "P70"]) == "P7"
    assert most_similar_name("Q9", ["P1", "P7"]) is None
