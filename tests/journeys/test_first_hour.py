"""The first hour on screens of all sizes, each in a process and on a screen of its own."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.full

SLOW = pytest.mark.slow


@pytest.mark.skipif(shutil.which("xvfb-run") is None, reason="needs virtual screens")
@pytest.mark.parametrize(
    ("screen", "scale", "theme"),
    [
        ("1280x720", 1, "light"),
        ("1920x1080", 2, "dark"),
        pytest.param("1280x720", 1, "dark", marks=SLOW),
        pytest.param("1600x1000", 1, "light", marks=SLOW),
        pytest.param("1600x1000", 1, "dark", marks=SLOW),
        pytest.param("1920x1080", 2, "light", marks=SLOW),
    ],
)
def test_the_first_hour_of_a_geologist(
    own_folders: Path, tmp_path: Path, screen: str, scale: int, theme: str
) -> None:
    assert "11 tables" in play(tmp_path, screen, scale, theme)


@pytest.mark.skipif(shutil.which("xvfb-run") is None, reason="needs virtual screens")
@pytest.mark.parametrize(
    ("screen", "scale", "theme"),
    [
        ("1600x1000", 1, "dark"),
        pytest.param("1600x1000", 1, "light", marks=SLOW),
        pytest.param("1280x720", 1, "light", marks=SLOW),
        pytest.param("1280x720", 1, "dark", marks=SLOW),
        pytest.param("1920x1080", 2, "light", marks=SLOW),
        pytest.param("1920x1080", 2, "dark", marks=SLOW),
    ],
)
def test_the_first_hour_on_a_real_model(
    own_folders: Path, tmp_path: Path, data_dir: Path, screen: str, scale: int, theme: str
) -> None:
    model = data_dir / "brighton_model" / "brighton_utm15n.obj"
    assert "6 tables" in play(tmp_path, screen, scale, theme, "--real", str(model))


def play(tmp_path: Path, screen: str, scale: int, theme: str, *words: str) -> str:
    """Play an hour on a screen of its own; the steps that were done."""
    out = tmp_path / "out"
    out.mkdir()
    environment = {**os.environ, "QT_QPA_PLATFORM": "xcb", "QT_SCALE_FACTOR": str(scale)}
    done = subprocess.run(
        [
            "xvfb-run",
            "-a",
            "-s",
            f"-screen 0 {screen}x24 +extension GLX",
            sys.executable,
            "-m",
            "tests.journeys.first_hour",
            str(tmp_path / "models"),
            str(out),
            "--theme",
            theme,
            *words,
        ],
        capture_output=True,
        text=True,
        timeout=600,
        env=environment,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout
