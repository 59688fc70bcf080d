"""`vomstudio project ... accept`: what a search proposes becomes features of the project."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.extraction.planes_by_construction import clouds_of, sheet
from vomstudio.io.gate.orientation_files import read_orientations
from vomstudio.project.journal.database import read_replay
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.kinds.trace import Trace

pytestmark = pytest.mark.usefixtures("own_folders")
ATTITUDES = [(40.0, 70.0), (130.0, 85.0), (250.0, 15.0)]


@pytest.fixture
def cloud(tmp_path: Path) -> Path:
    rng = np.random.default_rng(1)
    parts = [sheet(rng, a, (4.0 * i, 0.0, 0.0), count=600) for i, a in enumerate(ATTITUDES)]
    np.savetxt(tmp_path / "cloud.xyz", clouds_of(*parts)[0].points, fmt="%.5f")
    return tmp_path / "cloud.xyz"


def project_of(run, model: Path) -> Path:
    folder = model.with_suffix(".vom")
    assert run("project", folder, "create").code == 0
    assert run("project", folder, "add-model", model, "--up", "z", "--unit", "m").code == 0
    return folder


def test_accepted_facets_become_patches_with_planes_of_facets_command(
    run, cloud: Path, tmp_path: Path
) -> None:
    project = project_of(run, cloud)
    ran = run("project", project, "accept", "facets", "--type", "joint", "--set", "S", "--json")
    assert ran.code == 0, ran.said
    assert (len(ran.json["added"]), ran.json["proposed"]) == (3, 3)
    patches = [r for r in read_replay(project).records.values() if isinstance(r, Patch)]
    assert {each["id"] for each in ran.json["added"]} == {patch.id for patch in patches}
    assert {(p.type_id, p.set_name, bool(p.notes)) for p in patches} == {("joint", "S", True)}
    assert run("facets", cloud, "-o", tmp_path / "f.csv").code == 0
    found = read_orientations(tmp_path / "f.csv")
    planes = run("project", project, "fit", "--json").json["planes"]
    assert sorted(row["dip_deg"] for row in planes) == pytest.approx(
        sorted(found.dip_deg.tolist()), abs=0.05
    )
    undone = run("project", project, "undo", "--json").json
    assert undone["features"] == 0


def test_search_options_and_quality_filter_proposals(run, cloud: Path) -> None:
    project = project_of(run, cloud)
    words = ("project", project, "accept", "facets", "--type", "joint", "--json")
    good = run(*words, "--quality", "good").json
    planes = run("project", project, "fit", "--json").json["planes"]
    assert {row["quality"] for row in planes} <= {"good"}
    assert len(planes) == len(good["added"])
    error = run(*words, "--min-area", "1e6").json["error"]
    assert error["code"] == "proposals.not-found"
    assert run("project", project, "list", "--json").json["features"] == len(planes)


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (("facets", "--type", "joint", "--preset", "dse"), "option.conflict"),
        (("facets", "--type", "nonsense"), "option.not-a-choice"),
        (("facets", "--type", "joint", "--cost", "dark"), "command.unknown-argument"),
        (("traces", "--type", "joint", "--min-area", "1"), "command.unknown-argument"),
        (("facets",), "command.arguments-missing"),
    ],
)
def test_invalid_search_changes_nothing(run, cloud: Path, words: tuple[str, ...], code) -> None:
    project = project_of(run, cloud)
    failed = run("project", project, "accept", *words, "--json")
    assert (failed.code, failed.json["error"]["code"]) == (2, code)
    assert run("project", project, "list", "--json").json["features"] == 0


def test_accepted_traces_are_not_proposed_again(run, tmp_path: Path) -> None:
    x, y = (a.ravel() for a in np.meshgrid(np.arange(0.0, 4.0, 0.05), np.arange(0.0, 4.0, 0.05)))
    z = 0.5 * y + 0.3 * np.sin(3.0 * x)
    grey = np.where(np.abs(z - 1.0) < 0.03, 20.0, 220.0)
    model = tmp_path / "slope.csv"
    rows = np.column_stack([x, y, z, grey])
    np.savetxt(model, rows, "%.4f", delimiter=",", header="x,y,z,grey", comments="")
    project = project_of(run, model)
    words = ("project", project, "accept", "traces", "--type", "bedding", "--cost", "grey")
    first = run(*words, "--json")
    assert first.code == 0, first.said
    traces = [r for r in read_replay(project).records.values() if isinstance(r, Trace)]
    assert len(traces) == len(first.json["added"]) == first.json["proposed"] >= 1
    heights = np.array(traces[0].vertices)[:, 2]
    assert np.percentile(np.abs(heights - 1.0), 90) < 0.1
    error = run(*words, "--json").json["error"]
    assert error["code"] == "proposals.not-found"
