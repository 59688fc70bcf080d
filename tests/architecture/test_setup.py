"""When the start scripts take an installation for finished: a wrong yes is a broken program."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the start scripts need bash")


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A project with the real scripts and what looks like a finished installation."""
    folder = tmp_path / "a folder with spaces"
    (folder / ".venv" / "bin").mkdir(parents=True)
    shutil.copytree(ROOT / "packaging", folder / "packaging")
    shutil.copy(ROOT / "pyproject.toml", folder)
    # Not a link: through one, Python would look for its packages beside the link.
    python = folder / ".venv" / "bin" / "python"
    python.write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n')
    python.chmod(0o755)
    for use in ("run", "test"):
        assert bash(folder, f'wanted_stamp {use} >"$stamp-{use}"').returncode == 0
    return folder


def bash(project: Path, commands: str) -> subprocess.CompletedProcess[str]:
    """Run bash commands with packaging/_setup.sh sourced, from another folder."""
    script = f'set -euo pipefail; source "$1"; {commands}'
    return subprocess.run(
        ["bash", "-c", script, "test", project / "packaging" / "_setup.sh"],
        cwd="/",
        capture_output=True,
        text=True,
    )


def is_installed(project: Path, use: str = "run") -> bool:
    return bash(project, f"is_installed {use}").returncode == 0


def test_a_finished_installation_is_recognised(project: Path) -> None:
    assert is_installed(project)


def test_an_interrupted_installation_is_not_taken_for_finished(project: Path) -> None:
    (project / ".venv" / "installation-unfinished").touch()
    assert not is_installed(project)
    assert bash(project, "environment_is_usable").returncode != 0


def test_a_changed_lock_file_asks_for_an_installation_into_the_same_environment(
    project: Path,
) -> None:
    with (project / "packaging" / "requirements.lock").open("a") as lock:
        lock.write("something==1.0\n")
    assert not is_installed(project)
    assert bash(project, "environment_is_usable").returncode == 0


def test_a_moved_project_makes_its_environment_anew(project: Path) -> None:
    moved = project.rename(project.with_name("moved"))
    assert not is_installed(moved)
    assert bash(moved, "environment_is_usable").returncode != 0


def test_an_environment_whose_python_is_gone_is_made_anew(project: Path) -> None:
    (project / ".venv" / "bin" / "python").unlink()
    assert not is_installed(project)
    assert bash(project, "environment_is_usable").returncode != 0


def test_without_python_one_sentence_says_what_to_install(project: Path) -> None:
    done = bash(project, "find_python() { return 1; }; can_use_apt() { return 1; }; need_python")
    assert done.returncode == 1
    assert "Python 3.11" in done.stderr
    assert "python3-venv" in done.stderr
