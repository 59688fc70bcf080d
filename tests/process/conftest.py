"""Photos, and the model that an undisturbed run makes of them."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.photogrammetry.photo_set import write_photos
from tests.process.reconstruction_runs import reconstruct


@pytest.fixture(scope="session")
def photos(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_photos(tmp_path_factory.mktemp("photos") / "face")


@pytest.fixture(scope="session")
def undisturbed(photos: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The output of a run on one thread that nobody interrupted."""
    out = tmp_path_factory.mktemp("undisturbed") / "out"
    end = reconstruct(photos, out, "--threads", 1)
    assert end.code == 0, end.err
    assert end.json["registered"] == 6
    return out
