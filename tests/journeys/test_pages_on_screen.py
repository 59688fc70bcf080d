"""Texts of every page, workspace and tool are whole and readable at all sizes and scales."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.full


@pytest.mark.parametrize(
    ("width", "height", "scale", "theme"),
    [
        (960, 540, 2.0, "dark"),
        pytest.param(960, 540, 1.0, "light", marks=pytest.mark.slow),
        pytest.param(1280, 720, 1.25, "light", marks=pytest.mark.slow),
        pytest.param(1280, 720, 1.0, "light", marks=pytest.mark.slow),
        pytest.param(1600, 1000, 1.0, "dark", marks=pytest.mark.slow),
        pytest.param(1600, 1000, 1.0, "light", marks=pytest.mark.slow),
    ],
)
def test_page_texts_are_complete_and_readable(
    qapp,
    own_folders: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    width: int,
    height: int,
    scale: float,
    theme: str,
) -> None:
    monkeypatch.setenv("QT_SCALE_FACTOR", str(scale))
    words = [str(tmp_path), str(width), str(height), theme]
    ran = subprocess.run(
        [sys.executable, "-m", "tests.journeys.pages_on_screen", *words],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert ran.returncode == 0, ran.stderr
    seen = [json.loads(line) for line in ran.stdout.splitlines()]
    assert len(seen) > 30
    assert {each["place"]: each["violations"] for each in seen if each["violations"]} == {}
