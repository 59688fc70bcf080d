"""Commands that take a table of planes also take a project, with the same results."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

import vomstudio as vs

PROJECT = Path(__file__).parents[1] / "specimens" / "schema1.vom"
DIFFERENT = {"convention", "image", "warnings", "dropped_lines"}


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
def test_a_project_gives_what_its_exported_table_gives(
    run, project: Path, tmp_path: Path, monkeypatch, command: str, options: tuple[str, ...]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run("export", project, "--to", "csv", "-o", "table.csv").code == 0
    force = ["--force"] if "-o" in options else []
    of_project = run(command, project, *options, "--json").json
    of_table = run(command, "table.csv", *options, *force, "--json").json
    assert of_project["n"] > 0
    assert {k: v for k, v in of_project.items() if k not in DIFFERENT} == {
        k: v for k, v in of_table.items() if k not in DIFFERENT
    }


def test_python_takes_the_folder_of_a_project(run, project: Path) -> None:
    assert vs.stats(project).n == run("stats", project, "--json").json["n"]


@pytest.mark.parametrize("command", [("fit",), ("fractures",), ("threepoint",)])
def test_other_commands_say_that_it_is_a_project(run, project: Path, command) -> None:
    assert run(*command, project, "--json").json["error"]["code"] == "file.is-project"
