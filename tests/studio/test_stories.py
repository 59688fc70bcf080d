"""The workspace where Qt cannot be imported: each story in a fresh interpreter."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.studio.stories import STORIES
from tests.tiers import first_in_default_tier


@pytest.mark.full
@pytest.mark.parametrize("name", first_in_default_tier(STORIES, 1))
def test_workspace_runs_without_qt(name: str, own_folders: Path, tmp_path: Path) -> None:
    """`own_folders` is in the environment, which the interpreter takes over."""
    done = subprocess.run(
        [sys.executable, "-m", "tests.studio.stories", name, str(tmp_path)],
        cwd=Path(__file__).resolve().parents[2],
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
