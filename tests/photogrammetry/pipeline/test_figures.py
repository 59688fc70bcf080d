"""What the report says of cameras, after the model was placed."""

import numpy as np
import pytest

from vomstudio.core.findings import Finding
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.photogrammetry.align.priors import Calibration
from vomstudio.photogrammetry.align.scene_check import check_scene
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.pipeline.report_data import calibration, cameras_after_placement

NAMES = ("f", "cx", "cy", "k")
ASSUMED = Finding("lens.focal-assumed", focal_mm=30.0, error_percent=None)
BY_GROUND = Finding(
    "lens.ground-estimated",
    count=3,
    focal_px=1500.0,
    sigma_px=6.0,
    change_percent=15.0,
    ground_percent=0.4,
    required_percent=1.5,
)
UNKNOWN = np.full((4, 4), np.nan)
UNKNOWN[3, 3] = 1.0
HELD = Calibration(
    "SIMPLE_RADIAL",
    NAMES,
    (1300.0, 800.0, 600.0, 0.01),
    (0.0, 0.0, 0.0, 0.002),
    tuple(map(tuple, UNKNOWN)),
    ("a.jpg", "b.jpg", "c.jpg"),
    "held",
    (ASSUMED,),
    None,
    20.0,
)
LENS = {"photos": list(HELD.photos), "freed": True, "sigma_px": 6.0, "reason": BY_GROUND.to_dict()}
FREED = {"lenses": [LENS]}


def scene(focal: float) -> SparseScene:
    """Three cameras side by side before 60 points on a wall 10 m away."""
    lens = Intrinsics("SIMPLE_RADIAL", 1600, 1200, (focal, 800.0, 600.0, 0.01))
    views = tuple(
        View(name, lens, np.eye(3), np.array([-x, 0.0, 0.0]))
        for name, x in zip(HELD.photos, (-2.0, 0.0, 2.0), strict=True)
    )
    rng = np.random.default_rng(1)
    points = np.column_stack([rng.uniform(-2, 2, (60, 2)), rng.uniform(9, 11, 60)])
    pixels = np.stack([view.project(points) for view in views], axis=1).reshape(-1, 2)
    return SparseScene(
        views,
        points,
        np.zeros((60, 3), np.uint8),
        np.zeros(60, np.float32),
        np.arange(0, 181, 3),
        np.tile(np.arange(3, dtype=np.int32), 60),
        pixels.astype(np.float32),
    )


def test_focal_length_estimated_from_the_ground_is_not_reported_as_vague() -> None:
    guessed = check_scene(scene(1300.0), cameras=[HELD])
    assert any(finding.code == "focal-vague" for finding in guessed.findings)
    (camera,) = cameras_after_placement([HELD], scene(1500.0), FREED)
    assert camera.values[0] == 1500.0
    assert (camera.focal, camera.sigma[0]) == ("freed", 6.0)
    assert camera.reasons == (ASSUMED, BY_GROUND)
    told = check_scene(scene(1500.0), cameras=[camera])
    assert not any(finding.code == "focal-vague" for finding in told.findings)


def test_unadjusted_cameras_keep_their_values() -> None:
    (camera,) = cameras_after_placement([HELD], scene(1300.0), {})
    assert camera.values == HELD.values
    assert (camera.focal, camera.reasons) == (HELD.focal, HELD.reasons)


def test_parameters_freed_by_the_ground_have_errors_and_no_correlations() -> None:
    class Seen:
        name, camera, width, height = "a.jpg", "Acme", 1600, 1200

    (row,) = calibration(cameras_after_placement([HELD], scene(1500.0), FREED), [Seen()])  # type: ignore[list-item]
    assert row["sigma"] == [6.0, 0.0, 0.0, pytest.approx(0.002)]
    assert row["free"] == ["k"]
    assert row["correlation"] == [[1.0]]
