"""One small study by commands, in Python, and with the edits of the window: equal figures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pytest

import vomstudio as vs
from tests.extraction.planes_by_construction import sheet
from vomstudio.core.identifiers import new_id
from vomstudio.core.progress import SilentProgress
from vomstudio.extraction.facet_options import FacetOptions
from vomstudio.geology.profiles import DEFAULT_THRESHOLDS
from vomstudio.geometry import transform
from vomstudio.geometry.streaming.surfaces import create_surface
from vomstudio.io.control.observation_tables import read_pairs
from vomstudio.io.gate.frame_options import FrameOptions
from vomstudio.project import edits
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.records import SURROUNDINGS_RULE
from vomstudio.registration.surface_points import known_resolution, sample_points
from vomstudio.studio.headless_project import HeadlessProject
from vomstudio.studio.jobs.surface_tasks import FIND_FACETS, FacetsRequest
from vomstudio.studio.models import placed_model
from vomstudio.studio.placing.registering import create_registration, place_by_points
from vomstudio.studio.project_summary import table_orientations
from vomstudio.studio.surfaces.facet_proposals import assess_facets
from vomstudio.studio.tools.local_surface import measure_surroundings

pytestmark = [
    pytest.mark.usefixtures("own_folders"),
    pytest.mark.filterwarnings("ignore::vomstudio.core.errors.VomWarning"),
]
CRS = "EPSG:32633"
WALLS = [(40.0, 70.0), (130.0, 85.0), (250.0, 15.0)]
CORNERS = np.array([[0, 0, 0], [8, 1, 0], [1, 6, 1], [4, 2, 3], [7, 5, 0.5], [3, 3, 2]], float)
NAMED_BY_DOOR = ("id", "name", "notes", "model")
"""Columns that contain random ids or the name of the model's file."""


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cloud of three walls, points along a bed, and control points."""
    folder = tmp_path_factory.mktemp("study")
    rng = np.random.default_rng(3)
    parts = [sheet(rng, each, (4.0 * i, 0.0, 0.0), count=250) for i, each in enumerate(WALLS)]
    np.savetxt(folder / "walls.xyz", np.concatenate(parts), fmt="%.5f")
    bed = sheet(rng, (95.0, 30.0), (4.0, 0.0, 0.0), count=12, noise=0.01)
    pandas.DataFrame(bed, columns=list("xyz")).assign(bed="B1").to_csv(
        folder / "bed.csv", index=False
    )
    world = CORNERS[:, [1, 0, 2]] * [-1, 1, 1] + [500_000, 4_700_000, 300]
    world += rng.normal(0.0, 0.01, world.shape)
    names = [*("model_x", "model_y", "model_z"), *"xyz"]
    pandas.DataFrame(np.column_stack([CORNERS, world]), columns=names).assign(
        label=[f"P{i}" for i in range(len(CORNERS))]
    ).to_csv(folder / "pairs.csv", index=False)
    return folder


def by_commands(command: Callable[..., Any], study: Path, folder: Path) -> None:
    command("project", folder, "create")
    command("project", folder, "add-model", study / "walls.xyz", "--up", "z", "--unit", "m")
    command("project", folder, "add-picks", study / "bed.csv", "--by", "bed", "--type", "bedding")
    command("project", folder, "accept", "facets", "--type", "joint", "--quality", "doubtful")
    command("project", folder, "register", study / "pairs.csv", "--crs", CRS)
    command("project", folder, "set", "B1", "--set", "west")


def by_python(study: Path, folder: Path) -> None:
    pairs = pandas.read_csv(study / "pairs.csv")
    with vs.Project.create(folder) as project:
        project.add_model(np.loadtxt(study / "walls.xyz"), name="walls")
        project.add_points(pandas.read_csv(study / "bed.csv"), by="bed", type="bedding")
        project.accept_facets(type="joint", quality="doubtful")
        project.register(
            pairs[["model_x", "model_y", "model_z"]].to_numpy(), pairs[["x", "y", "z"]], crs=CRS
        )
        project.set_values("B1", set="west")
        project.save()


def by_window(study: Path, folder: Path) -> None:
    """The same steps with the functions that tools and panels of the window call."""
    with HeadlessProject.create(folder) as project:
        project.add_model(study / "walls.xyz", FrameOptions(up="z", unit="m"))
        model, session = project.find_model(None), project.session
        data = project.read_model(model).data
        surface = create_surface(data)
        bed = pandas.read_csv(study / "bed.csv")[["x", "y", "z"]].to_numpy()
        vertices = tuple(map(tuple, transform.apply(transform.invert(model.to_world), bed)))
        trace = Trace(new_id("trace"), "B1", "bedding", model.id, model.content_hash, vertices)
        resolution, normal = measure_surroundings(surface, vertices)
        trace = replace(trace, resolution=resolution, outcrop_normal=normal, axis="auto")
        session.apply(edits.add_trace(session.records, replace(trace, rule=SURROUNDINGS_RULE)))
        options, placed = FacetOptions(), placed_model(model, study / "walls.xyz", folder / "cache")
        request = FacetsRequest(placed, options, None, folder / "facets.npz")
        found = FIND_FACETS.function(request, SilentProgress())
        records = dict(session.records)
        proposals = assess_facets(model, options, found, True, records, DEFAULT_THRESHOLDS)
        patches = [
            replace(patch, id=new_id("patch"), type_id="joint")
            for patch, measured in zip(proposals.patches, proposals.measured, strict=True)
            if measured.verdict is not None and measured.verdict.quality != "poor"
        ]
        session.apply(edits.add_features(records, patches))
        pairs = read_pairs(study / "pairs.csv")
        placement = place_by_points(
            pairs, data.bounds, model, CRS, sample_points(data), resolution=known_resolution(data)
        )
        registration = create_registration(placement, pairs, model, CRS)
        session.apply(edits.set_registration(session.records, registration, [model.id]))
        session.apply(edits.set_attributes(session.records, [trace.id], set_name="west"))
        project.save()


def figures(folder: Path) -> list[dict[str, Any]]:
    rows = [dict(row) for row in table_orientations(folder).rows]
    for row in rows:
        for column in NAMED_BY_DOOR:
            row.pop(column)
    return rows


def test_commands_python_and_window_give_equal_digits(
    command: Callable[..., Any], study: Path, tmp_path: Path
) -> None:
    by_commands(command, study, tmp_path / "commands.vom")
    by_python(study, tmp_path / "python.vom")
    by_window(study, tmp_path / "window.vom")
    expected = figures(tmp_path / "window.vom")
    assert len(expected) == 4
    assert {row["frame"] for row in expected} == {"EPSG:32633, grid north"}
    assert all(row["registration_error_deg"] > 0 for row in expected)
    assert figures(tmp_path / "commands.vom") == expected
    assert figures(tmp_path / "python.vom") == expected
