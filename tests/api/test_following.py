"""`vs.follow` in a photo, and `vs.plane_band`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import vomstudio as vs
from tests.extraction.test_photo_following import clicks, wall, written
from tests.messages import refused


@pytest.mark.full
def test_trace_is_followed_in_photo_on_point_array_with_cameras(tmp_path: Path) -> None:
    made = wall(4)
    folder = written(made, tmp_path)
    cloud = made.mesh(0.02).vertices
    found = vs.follow(
        cloud, clicks(made), cost="dark", photo=folder / "p0.png", cameras=folder / "cameras.json"
    )
    assert np.median(np.abs(found.points @ made.normal - made.level)) < 0.012
    assert found.pixels.shape == (found.vertices, 2)
    assert found.seen.shape == found.agreeing.shape == (found.vertices,)
    with refused("cameras.missing", vs.errors.UsageError, field="cameras"):
        vs.follow(cloud, clicks(made), photo=folder / "p0.png")
    with refused("option.requires", vs.errors.UsageError, option="cameras", other="photo"):
        vs.follow(cloud, clicks(made), cameras=folder / "cameras.json")


def test_bent_trace_has_no_plane_band_and_no_crossing() -> None:
    t = np.linspace(0.0, 5.0, 60)
    bent = np.column_stack([t, np.sin(2.0 * t), 0.2 * t])
    bent += np.random.default_rng(0).normal(0.0, 0.01, bent.shape)
    assert vs.plane_band(bent) is None
    with refused("trace.not-straight", vs.errors.GeometryError, trace="first"):
        vs.plane_of_crossing(bent, bent)
