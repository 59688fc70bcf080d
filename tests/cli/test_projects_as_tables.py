"""Commands that take a table of planes also take a project, with the same results."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import vomstudio as vs

PROJECT = Path(__file__).parents[1] / "specimens" / "schema1.vom"
DIFFERENT = {"warnings", "dropped_lines"}


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project in a folder of the test, since opening may write."""
    return Path(shutil.copytree(PROJECT, tmp_path_factory.mktemp("project") / "beds.vom"))


@pytest.mark.parametrize(
    ("command", "options"),
    [
        ("stats", ()),
        ("fold", ()),
        ("rose", ("-o", "rose.svg")),
        ("stereonet", ("-o", "net.svg")),
        ("slope", ("--face", "310/75", "--friction", "35")),
    ],
)
def test_project_and_exported_table_give_equal_results(
    run,
    project: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    command: str,
    options: tuple[str, ...],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run("export", project, "--to", "csv", "-o", "table.csv").code == 0
    force = ["--force"] if "-o" in options else []
    of_project = run(command, project, *options, "--json").json
    of_table = run(command, "table.csv", *options, *force, "--json").json
    assert of_project["n"] > 0
    # The table has twelve digits.
    expected = pytest.approx(list(numbers(of_table)), rel=1e-3, abs=1e-6)
    assert list(numbers(of_project)) == expected


def numbers(value: Any) -> Iterator[float]:
    """Numbers of an object of JSON, without warnings and their rows."""
    if isinstance(value, dict):
        for name in sorted(value.keys() - DIFFERENT):
            yield from numbers(value[name])
    elif isinstance(value, list):
        for item in value:
            yield from numbers(item)
    elif isinstance(value, int | float):
        yield float(value)


@pytest.mark.filterwarnings("ignore::vomstudio.core.errors.VomWarning")
def test_python_accepts_project_folder(run, project: Path) -> None:
    assert vs.stats(project).n == run("stats", project, "--json").json["n"]


@pytest.mark.parametrize("command", [("fit",), ("fractures",), ("threepoint",)])
def test_other_commands_report_that_it_is_a_project(
    run, project: Path, command: tuple[str, ...]
) -> None:
    assert run(*command, project, "--json").json["error"]["code"] == "file.is-project"
