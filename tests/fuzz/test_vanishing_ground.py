"""Short runs of the campaigns of kills and of faults of the disk."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.fuzz import disk_faults, faulty_disk
from tests.tiers import first_in_default_tier

ROOT = Path(__file__).resolve().parents[2]
TEMPLATES = [template for kind in disk_faults.COMMANDS.values() for template in kind]

pytestmark = [
    pytest.mark.full,
    pytest.mark.skipif(
        faulty_disk.unavailable_reason() is not None, reason=str(faulty_disk.unavailable_reason())
    ),
]


def run(module: str, *words: str) -> str:
    """In a process of its own, whose disk can fail."""
    done = subprocess.run(
        [sys.executable, "-m", f"tests.fuzz.{module}", *words],
        env=faulty_disk.environment(),
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def of_each(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[str]]:
    words = run("disk_faults", "--each", str(tmp_path_factory.mktemp("each")))
    return dict(json.loads(words.splitlines()[-1]))


@pytest.mark.parametrize("template", TEMPLATES)
def test_write_error_reports_target_and_cause_and_leaves_no_files(
    of_each: dict[str, list[str]], template: str
) -> None:
    """On a disk that is full, and on one that is read-only."""
    assert of_each[template] == ["said", "said"]


@pytest.mark.parametrize("kind", first_in_default_tier(["save", "save-as", "compact"], 1))
def test_project_is_intact_after_disk_fault_at_any_call(kind: str) -> None:
    assert f"{kind}: 15 faults" in run("disk_faults", "--faults", "15", "--seed", "7", kind)


@pytest.mark.slow
@pytest.mark.parametrize("kind", disk_faults.COMMANDS)
def test_outputs_are_intact_after_disk_fault_at_any_call(kind: str) -> None:
    assert f"{kind}: 60 faults" in run("disk_faults", "--faults", "60", "--seed", "7", kind)


def test_kill_at_any_moment_loses_no_displayed_step() -> None:
    said = run("kills", "--kills", "12", "--seed", "7")
    assert "wrong" not in said
    assert "12 kills" in said
