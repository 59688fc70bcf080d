"""Changes of a project in a script: features of all kinds, registrations, values, deletions."""

from __future__ import annotations

import inspect
import re
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pytest

import vomstudio as vs
from tests.messages import refused, warned
from vomstudio.core.options import declarations
from vomstudio.extraction.facet_options import FacetOptions
from vomstudio.extraction.trace_options import ProposalOptions
from vomstudio.registration.register_options import Observations
from vomstudio.studio.project_options import (
    AcceptOptions,
    FeatureValues,
    PickOptions,
    PlacementOptions,
)

pytestmark = pytest.mark.usefixtures("own_folders")
STEPS = np.arange(0.0, 4.0, 0.1)
X, Z = (a.ravel() for a in np.meshgrid(STEPS, STEPS))
WALL = np.column_stack([X, np.zeros_like(X), Z])
BEHIND = WALL + [0.0, 3.0, 0.0]
"""A second wall, which an outline on the first one also encloses as seen along its normal."""
CONTACT = [[0.0, 0, 1], [2, 0, 1], [2, 0, 3]]
RING = [[0.95, 0, 0.95], [2.05, 0, 0.95], [2.05, 0, 2.05], [0.95, 0, 2.05]]


def grid_faces(n: int) -> np.ndarray:
    corner = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    first = np.column_stack([corner, corner + 1, corner + n])
    return np.concatenate([first, np.column_stack([corner + 1, corner + n + 1, corner + n])])


@pytest.fixture
def project(tmp_path: Path) -> Iterator[vs.Project]:
    """A project with two parallel vertical walls."""
    faces = grid_faces(len(STEPS))
    mesh = vs.Mesh.from_arrays(
        np.concatenate([WALL, BEHIND]), np.concatenate([faces, faces + len(WALL)])
    )
    with vs.Project.create(tmp_path / "walls.vom") as project:
        project.add_model(mesh, name="walls")
        yield project


def steps_back(project: vs.Project) -> int:
    """Undo everything, and return the number of steps."""
    count = 0
    while True:
        try:
            project.undo()
        except vs.errors.DocumentError:
            return count
        count += 1


# --- features ------------------------------------------------------------------------------------
def test_each_call_is_one_undo_step_and_unsaved_changes_are_discarded(project: vs.Project) -> None:
    bed = project.add_trace([[0, 0, 1], [2, 0, 1.5], [2, 3, 1]], type="bedding", name="B1")
    project.add_line([[0, 0, 1], [2, 0, 1.5]], type="lineation", on=bed)
    project.add_line(CONTACT, type="contact")
    project.add_patch(RING, type="joint")
    project.add_station([1, 0, 1], number="7")
    project.set_type(bed, "Fault")
    project.delete("B1")
    tables = (project.lines, project.contacts, project.patches, project.stations)
    assert [len(table()) for table in tables] == [1, 1, 1, 1]
    assert all(table().geometry.has_z.all() for table in tables)
    assert steps_back(project) == 8  # With the model.
    while True:
        try:
            project.redo()
        except vs.errors.DocumentError:
            break
    assert [len(table()) for table in tables] == [1, 1, 1, 1]
    folder = project.path
    project.close()
    with vs.Project.open(folder) as again:
        assert again.models == ()


def test_the_type_decides_between_a_lineation_and_a_contact_line(project: vs.Project) -> None:
    lineation = project.add_line([[0, 0, 1], [0, 0, 3]], type="Lineation", set="s")
    contact = project.add_line(CONTACT, type="fault", name="F1", domain="east")
    fit = project.fit(lineation)
    assert isinstance(fit, vs.LineFit)
    assert (fit.plunge_deg, fit.set) == (90.0, "s")
    (row,) = project.contacts().to_dict("records")
    assert (row["id"], row["name"], row["length_m"]) == (contact, "F1", 4.0)
    with refused("option.not-a-choice", vs.errors.UsageError, value="Fault", field="type"):
        project.add_line(CONTACT, type="fault", slip_sense="normal")


def test_features_without_a_type_are_renamed_and_deleted_by_name(project: vs.Project) -> None:
    station = project.add_station([1, 0, 1], number="7")
    (name,) = project.stations()["name"]
    assert project.set_values(name, name="camp") == (station,)
    with refused("feature.no-attribute", vs.errors.DocumentError):
        project.set_values("camp", set="west")
    with refused("feature.without-plane", vs.errors.GeometryError):
        project.fit("camp")
    assert project.delete("camp") == (station,)
    assert len(project.stations()) == 0


def test_a_patch_is_the_connected_part_inside_an_outline(project: vs.Project) -> None:
    inside = project.add_patch(RING, type="joint")
    (outline,) = project.patches().geometry
    corners = np.array(outline.exterior.coords)
    assert np.abs(corners[:, 1]).max() == 0.0  # Nothing of the wall behind.
    # Faces by their centroids: 11 squares of two triangles, all inside the ring.
    assert corners[:, [0, 2]].min() >= 0.9
    assert corners[:, [0, 2]].max() <= 2.1
    fit = project.fit(inside)
    assert fit.dip_deg == pytest.approx(90.0)
    assert fit.area_m2 == pytest.approx(1.21, rel=0.02)
    centroids = WALL[grid_faces(len(STEPS))].mean(axis=1)
    mask = np.zeros(2 * len(centroids), bool)
    low, high = 0.95, 2.05
    axes = centroids[:, [0, 2]]
    mask[: len(centroids)] = ((axes > low) & (axes < high)).all(axis=1)
    same = project.add_patch(elements=mask, type="joint")
    by_index = project.add_patch(elements=np.flatnonzero(mask)[::-1], type="joint")
    for each in (same, by_index):
        assert project.fit(each).area_m2 == fit.area_m2


@pytest.mark.parametrize(
    ("call", "kind", "code"),
    [
        (lambda p: p.add_patch(type="joint"), "UsageError", "option.none-given"),
        (lambda p: p.add_patch(RING, elements=[1], type="joint"), "UsageError", "option.conflict"),
        (lambda p: p.add_patch(RING[:2], type="joint"), "GeometryError", "feature.too-few-points"),
        (lambda p: p.add_patch([RING[0]] * 4, type="joint"), "GeometryError", "tool.no-area"),
        (
            lambda p: p.add_patch([RING[k] for k in (0, 2, 1, 3)], type="joint"),
            "GeometryError",
            "patch.crossing-outline",
        ),
        (
            lambda p: p.add_patch(np.add(RING, [0, 1.5, 0]), type="joint"),
            "GeometryError",
            "patch.no-elements",
        ),
        (lambda p: p.add_patch(elements=[-1], type="joint"), "InputError", "array.no-such-element"),
        (
            lambda p: p.add_patch(elements=[True], type="joint"),
            "InputError",
            "array.no-such-element",
        ),
        (lambda p: p.add_patch(elements=[], type="joint"), "GeometryError", "patch.no-elements"),
        (lambda p: p.add_line(RING[:1], type="fault"), "GeometryError", "feature.too-few-points"),
        (lambda p: p.add_line([RING[0]] * 2, type="fault"), "GeometryError", "points.coincident"),
        (
            lambda p: p.add_line(CONTACT, type="lineation", on="B9"),
            "InputError",
            "record.missing",
        ),
        (lambda p: p.add_station([1, 0], model=None), "InputError", "array.not-points"),
        (lambda p: p.set_values("J1"), "UsageError", "option.none-given"),
        (lambda p: p.set_type("J1", "fault"), "InputError", "record.missing"),
        (lambda p: p.delete([]), "DocumentError", "selection.empty"),
        (lambda p: p.register(), "UsageError", "registration.no-observations"),
        (
            lambda p: p.register(WALL[:4], WALL[:4], pairs="pairs.csv"),
            "UsageError",
            "option.conflict",
        ),
        (lambda p: p.accept_traces(type="fault", cost="none"), "UsageError", "option.not-a-choice"),
    ],
)
def test_changes_that_are_not_possible_are_refused(
    project: vs.Project, call: Callable[[vs.Project], Any], kind: str, code: str
) -> None:
    before = repr(project)
    with refused(code, getattr(vs.errors, kind)):
        call(project)
    assert repr(project) == before
    assert steps_back(project) == 1


def test_points_far_from_the_model_are_refused(project: vs.Project) -> None:
    far = np.array(CONTACT) + [1e5, 0, 0]
    for call in (
        lambda: project.add_line(far, type="contact"),
        lambda: project.add_station(far[0]),
        lambda: project.add_patch(far, type="joint"),
    ):
        with pytest.raises(vs.errors.GeometryError):
            call()
    assert steps_back(project) == 1


def test_groups_without_a_plane_are_left_out_with_a_warning(project: vs.Project) -> None:
    table = pandas.DataFrame(
        {
            "bed": [1.0, 1.0, 1.0, 2.0, 2.0],
            "x": [0, 2, 2, 0, 1],
            "y": [0, 0, 3, 0, 0],
            "z": [1, 1.5, 1, 0, 0],
        }
    )
    with warned("feature.left-out", feature="2"):
        (added,) = project.add_points(table, by="bed", type="bedding")
    assert project.traces()[["id", "name"]].values.tolist() == [[added, "1"]]


def test_groups_are_added_as_lines_or_patches_in_one_step(project: vs.Project) -> None:
    groups = {"a": RING, "b": np.add(RING, [1.0, 0, 1.0])}
    for shape, kind, table in (
        ("line", "contact", project.contacts),
        ("line", "lineation", project.lines),
        ("patch", "joint", project.patches),
    ):
        added = project.add_points(groups, type=kind, shape=shape, set="s")
        assert table()[["id", "name", "set"]].values.tolist() == [
            [added[0], "a", "s"],
            [added[1], "b", "s"],
        ]
    (single,) = project.add_points({"a": RING}, type="joint", shape="patch", set="t")
    alone = project.fit(project.add_patch(RING, type="joint"))
    assert project.fit(single).area_m2 == alone.area_m2
    off_surface = {"a": np.add(RING, [0, 1.5, 0]), "b": RING[:2]}
    with refused("picks.none-usable", vs.errors.GeometryError, count=2):
        project.add_points(off_surface, type="joint", shape="patch")
    with warned("feature.left-out", feature="b"):
        assert len(project.add_points({"a": RING, "b": RING[:2]}, type="joint", shape="patch")) == 1
    assert steps_back(project) == 7


def test_a_model_in_memory_is_written_into_the_project(project: vs.Project) -> None:
    import pyvista

    first = project.add_model(WALL, name="a/b: wall")
    with warned("model.already-added"):
        assert project.add_model(WALL, name="again") == first
    project.add_model(pyvista.Plane(i_resolution=3, j_resolution=3))
    _, cloud, plane = project.models
    assert (cloud.kind, plane.kind, plane.name) == ("cloud", "mesh", "model")
    assert all(not Path(each.path).is_absolute() for each in project.models)
    assert np.array_equal(cloud.read().points, WALL)
    with refused("argument.requires-type", vs.errors.UsageError, field="crs"):
        project.add_model(WALL, crs="EPSG:32633")


def test_registration_by_directions_leaves_position_undetermined(
    project: vs.Project, tmp_path: Path
) -> None:
    joint = project.add_patch(RING, type="joint")
    before = project.fit(joint)
    bearing = [0, 0, 0, 3, 0, 0, 100, 0.5]
    with pytest.warns(vs.errors.VomWarning):
        placed = project.register(bearing=[bearing], level=[[0, 0, 0, 3, 0, 0]])
    assert placed.known.north
    assert not placed.known.position
    fit = project.fit(joint)
    assert (fit.dip_direction_deg - before.dip_direction_deg) % 180 == pytest.approx(10.0)
    assert fit.registration_error_deg is not None
    assert fit.registration_error_deg > 0.5
    project.undo()
    assert project.fit(joint) == before


# --- the report ----------------------------------------------------------------------------------
def test_report_lists_every_feature_with_values_of_table(
    project: vs.Project, tmp_path: Path
) -> None:
    project.add_trace(
        [[0, 0, 1], [2, 0, 1.5], [2, 3, 1], [1, 0, 2]], type="bedding", name="<B1>", set="west"
    )
    project.add_patch(RING, type="joint", name="J1")
    project.add_line([[0, 0, 1], [2, 0, 2]], type="lineation", name="L1")
    project.add_station([1, 0, 1], name="S1")
    path = tmp_path / "report.html"
    report = project.report(path)
    assert report.to_dict() == {
        "file": str(path),
        "planes": 2,
        "lines": 1,
        "quality": Counter([*project.planes()["quality"], *project.lines()["quality"]]),
        "skipped": [],
    }
    text = path.read_text("utf-8")
    assert all(f"<td>{name}</td>" in text for name in ("&lt;B1&gt;", "J1", "L1", "S1"))
    assert "svg+xml" in text
    with refused("output.exists", vs.errors.TargetError):
        project.report(path)
    project.report(path, force=True)
    assert path.read_text("utf-8") == text
    with refused("output.unknown-format", vs.errors.UsageError, field="path"):
        project.report(tmp_path / "report.pdf")


# --- signatures ----------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("method", "options", "omitted"),
    [
        ("accept_facets", (AcceptOptions, FacetOptions), {"propose_sets", "preset"}),
        ("accept_traces", (AcceptOptions, ProposalOptions), set()),
        ("register", (PlacementOptions,), set()),
        ("add_points", (PickOptions,), set()),
        ("set_values", (FeatureValues,), set()),
    ],
)
def test_methods_have_the_options_of_the_actions(
    method: str, options: tuple[type, ...], omitted: set[str]
) -> None:
    parameters = inspect.signature(getattr(vs.Project, method)).parameters
    declared = [each for one in options for each in declarations(one)]
    for each in declared:
        if each.name in omitted:
            assert each.name not in parameters
            continue
        assert parameters[each.name].kind is inspect.Parameter.KEYWORD_ONLY
        if each.is_required:
            assert parameters[each.name].default is inspect.Parameter.empty
        else:
            assert parameters[each.name].default == each.default
    assert issubclass(PlacementOptions, Observations)


def test_public_members_declare_their_types() -> None:
    for name, member in inspect.getmembers(vs.Project):
        if name.startswith("_"):
            continue
        function = member.fget if isinstance(member, property) else member
        annotations = inspect.get_annotations(getattr(function, "__func__", function))
        assert "return" in annotations, name
        words = " ".join(map(str, annotations.values()))
        assert not re.search(r"\bAny\b", words), name
