"""Surveys of many kinds: cameras are where they were, whatever the files say of them."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.photogrammetry.align.made_surveys import centre_error, made, pixel_on_rock
from tests.photogrammetry.align.surveys import SURVEYS
from tests.photogrammetry.made_photos import Finder
from vomstudio.core.progress import SilentProgress
from vomstudio.photogrammetry.align.alignment import AlignmentOptions, align


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "pixels"),
    [
        ("castle", 1.0),
        ("court", 1.0),
        ("nadir", 2.0),
        ("nadir-wrong", 2.0),
        ("bent-bare", 1.0),
        ("two-bare", 1.0),
        ("phones-bare", 1.0),
        ("wrong-narrow", 2.0),
        ("boulder", 1.0),
        ("turned", 1.0),
    ],
)
def test_cameras_of_a_survey_are_recovered_within_a_pixel_on_the_rock(
    tmp_path: Path, name: str, pixels: float
) -> None:
    survey = SURVEYS[name]()
    features = made(survey, tmp_path, per_photo=1500)
    alignment = align(
        features.photos, tmp_path, AlignmentOptions(), Finder([features]), SilentProgress()
    )
    part = alignment.parts[0]
    assert len(part.views) == len(survey.views)
    error, _ = centre_error([view.name for view in part.views], part.centres, survey)
    assert error < pixels * pixel_on_rock(survey)
    true = {view.name: view.intrinsics.focal[0] for view in survey.views}
    for camera in alignment.cameras:
        if camera.focal == "freed":
            assert camera.values[0] == pytest.approx(true[camera.photos[0]], rel=0.02)
