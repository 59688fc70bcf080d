"""Which photos of a set are called blurred."""

from __future__ import annotations

import pytest

from vomstudio.photogrammetry.survey.check_limits import Limits
from vomstudio.photogrammetry.survey.picture_checks import blur_findings


def blurred(*values: float) -> list[float]:
    """Blurs of the photos that are reported, in the order of the set."""
    blurs = {f"{k}.jpg": value for k, value in enumerate(values)}
    names = [
        name
        for finding in blur_findings(blurs, Limits())
        if finding.code == "blurred"
        for name in finding.values["photos"]
    ]
    return [blurs[name] for name in names]


def codes(*values: float) -> list[str]:
    blurs = {f"{k}.jpg": value for k, value in enumerate(values)}
    return [finding.code for finding in blur_findings(blurs, Limits())]


@pytest.mark.parametrize("share", [1, 4, 6, 8])
def test_blurred_photos_are_found_whatever_their_share_of_the_set(share: int) -> None:
    values = [0.9] * (10 - share) + [3.2] * share
    expected = [3.2] * share
    if share < 8:
        assert blurred(*values) == expected
    else:
        # Two sharp photos of ten are not enough to tell what the camera resolves.
        assert codes(*values) == ["soft"]


def test_half_of_the_blurred_half_is_not_overlooked() -> None:
    values = [0.8, 0.9, 1.0, 1.0, 2.0, 2.2, 3.0, 4.0]
    assert blurred(*values) == [2.0, 2.2, 3.0, 4.0]


def test_slightly_soft_lens_is_not_called_blurred() -> None:
    assert codes(1.6, 1.7, 1.7, 1.75, 1.8, 1.9, 2.0) == []


def test_set_without_a_sharp_photo_is_called_soft() -> None:
    assert codes(2.8, 2.9, 3.0, 3.1) == ["soft"]
    assert codes(2.8, 2.9, 3.0, 3.1, 8.0) == ["blurred", "soft"]


def test_no_measured_blur_gives_no_finding() -> None:
    assert codes() == []
