"""Every command answers with the JSON object that is written down in `golden`.

Renewed by `python -m tests.cli.renew_golden`, see there.
"""

from __future__ import annotations

import pytest

from tests.cli.golden_cases import (
    CASES,
    GOLDEN,
    Case,
    Runner,
    differences,
    golden,
    outline,
)
from vomstudio.cli import COMMANDS

PROMISED = {
    "photos",
    "registered",
    "unregistered",
    "reprojection_error_px",
    "cameras",
    "sparse",
    "dense",
    "mesh",
    "dense_points",
    "faces",
    "frame",
    "seconds",
    "peak_memory_mb",
    "unseen_share",
    "texel",
    "photo_pixel",
    "unit",
    "device",
}


@pytest.fixture(scope="module")
def runner(tmp_path_factory: pytest.TempPathFactory) -> Runner:
    return Runner(tmp_path_factory.mktemp("golden") / "cases")


@pytest.mark.parametrize(
    "case",
    [
        pytest.param(case, id=case.name, marks=[pytest.mark.slow] if case.slow else [])
        for case in CASES
    ],
)
def test_command_output_matches_golden_file(runner: Runner, case: Case) -> None:
    ran, was = runner.ran(case.name), golden(case.name)
    assert ran["code"] == case.code == was["code"], ran["json"]
    if case.like:
        ran, was = outline(ran), outline(was)
    assert list(differences(was, ran)) == []


def test_every_command_has_golden_success_and_failure() -> None:
    for command in COMMANDS:
        codes = {case.code for case in CASES if case.words.split()[:1] == [command]}
        assert codes == {0, 2}, command


def test_every_golden_file_has_a_case() -> None:
    assert {path.stem for path in GOLDEN.glob("*.json")} == {case.name for case in CASES}


def test_golden_reconstruction_has_documented_fields() -> None:
    assert set(golden("reconstruct")["json"]) >= PROMISED
