"""Every argument of every public name, with values that it cannot have: the program's own error
names the argument, whatever the value; nothing of NumPy, pandas or Python gets through."""

from __future__ import annotations

import inspect
import os
import shutil
import warnings
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import numpy as np
import pandas
import pytest

import vomstudio as vs


class Odd:
    """Something that nobody expects."""


NEVER: dict[str, Any] = {
    "an object": Odd(),
    "bytes": b"x",
    "a function": lambda: 3,
    "a set": {1, 2},
    "a complex number": 1 + 2j,
    "a mapping": {"a": 1},
}
"""What no argument can be, but for what `TAKEN` names."""
SELDOM: dict[str, Any] = {
    "three": 3,
    "a negative number": -2.5,
    "not a number": float("nan"),
    "infinite": float("inf"),
    "huge": -1e308,
    "larger than a float": 10**400,
    "numbers larger than a float": [[10**400] * 3] * 3,
    "a word": "abc",
    "a long word": "x" * 5000,
    "a zero byte": "a\0b",
    "half a character": "\ud800",
    "true": True,
    "nothing": None,
    "empty": [],
    "one number": [3],
    "one row": [[3]],
    "words": ["a"],
    "no numbers": np.full((5, 3), np.nan),
    "huge numbers": np.full((5, 3), 1e308) * [1, -1, 1],
    "objects": np.array([None, {}], object),
    "rows of different lengths": [[1, 2], [3]],
    "a table": pandas.DataFrame({"a": [1]}),
}
"""What some arguments can be; which may give a result, or an error of ours."""
TAKEN = {
    ("fit_planes", "groups", "a mapping"),  # Then `by` is what cannot be.
    ("fit_planes dict", "groups", "a mapping"),
    ("fit_parallel", "groups", "a mapping"),
    ("fit_curved", "groups", "a mapping"),
}
"""Points of groups by their ids."""


class Case(NamedTuple):
    function: Callable[..., Any]
    good: Mapping[str, Any]


PLANES = ([90, 100, 95, 92, 10, 200, 210], [40, 42, 38, 41, 80, 60, 62])
GROUPS = {
    "a": [[0, 0, 0], [0, 5, 0], [3, 1, -3], [4, 4, -4.01], [2, 3, -2]],
    "b": [[0, 0, 1], [0, 5, 1], [3, 1, -2], [4, 4, -3.01], [2, 3, -1]],
}
CROSS = [[(0, 0), (1, 1)], [(0, 1), (1, 0)]]
LEVEL, DOWN = (
    np.outer(np.linspace(0, 5, 60), along) + np.random.default_rng(seed).normal(0, 0.01, (60, 3))
    for seed, along in enumerate(([0, 1, 0], [0.77, 0, -0.64]))
)
X, Y = (a.ravel() for a in np.meshgrid(np.arange(0, 3, 0.1), np.arange(0, 3, 0.1)))
GROUND = np.column_stack([X, Y, 0.2 * X + 0.02 * np.sin(9 * Y)])
MODEL = np.array([[0, 0, 0], [9, 0, 0], [0, 8, 1], [3, 2, 7], [5, 6, 0.5]], float)
WORLD = 2.0 * MODEL[:, [1, 0, 2]] * [-1, 1, 1] + [500.0, 100.0, 20.0]
SLIPS = pandas.DataFrame({"strike": [20], "dip": [60], "rake": [80], "sense": ["N"]})
REPEATED = pandas.DataFrame(
    {"dip_direction": [90, 92, 200, 201], "dip": [40, 42, 60, 62], "bed": list("AABB")}
)
CAMERA = "23.5x15.6,35,6000x4000"


@pytest.fixture(scope="module")
def cases(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Case]]:
    folder = tmp_path_factory.mktemp("wrong")
    before = Path.cwd()
    os.chdir(folder)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", vs.errors.VomWarning)
        with _project(folder) as project:
            yield _cases(folder, project)
    os.chdir(before)


def _project(folder: Path) -> vs.Project:
    """One with a trace B01 on a small ground."""
    corner = np.arange(29 * 29) % 29 + np.arange(29 * 29) // 29 * 30 + 1
    faces = np.concatenate(
        [
            np.column_stack([corner, corner + 1, corner + 31]),
            np.column_stack([corner, corner + 31, corner + 30]),
        ]
    )
    lines = [
        *("v {:f} {:f} {:f}".format(*p) for p in GROUND),
        *("f {} {} {}".format(*f) for f in faces),
    ]
    (folder / "ground.obj").write_text("\n".join(lines))
    project = vs.Project.create(folder / "ground.vom")
    model = project.add_model(folder / "ground.obj")
    project.add_trace(GROUND[:70:7] + [0, 0, 0.01], model=model, type="bedding", name="B01")
    project.save()
    return project


def _cases(folder: Path, project: vs.Project) -> dict[str, Case]:
    table = folder / "planes.csv"
    rows = enumerate(zip(*PLANES, strict=True))
    table.write_text(
        "dip_direction,dip,set,kind,x,y,z\n"
        + "\n".join(f"{a},{d},{'AB'[i % 2]},bedding,{i},{i},{i % 3}" for i, (a, d) in rows)
    )
    mesh = project.models[0].read()
    picture = vs.orthophoto(mesh, trend_deg=0, plunge_deg=90, gsd_m=0.1)
    cut = {"model": mesh, "plane": "90/50", "through": [1.5, 1.5, 0.3]}
    trace = {"points": GROUND[:70:7], "model": project.models[0].id, "type": "bedding"}
    photos = {"photos": folder / "none", "folder": folder / "made"}
    return {
        "read": Case(vs.read, {"path": folder / "ground.obj"}),
        "read_photos": Case(vs.read_photos, {"folder": vs.sample("photos")}),
        "check": Case(vs.check, {"folder": folder}),
        "plan": Case(vs.plan, {"camera": CAMERA, "distance_m": 20, "width_m": 30, "height_m": 10}),
        "fit_plane": Case(vs.fit_plane, {"points": GROUPS["a"]}),
        "fit_planes": Case(
            vs.fit_planes,
            {
                "groups": pandas.DataFrame(
                    {"x": X, "y": Y, "z": GROUND[:, 2], "b": np.arange(len(X)) % 3}
                ),
                "by": "b",
            },
        ),
        "fit_planes dict": Case(vs.fit_planes, {"groups": GROUPS}),
        "fit_parallel": Case(vs.fit_parallel, {"groups": GROUPS}),
        "fit_curved": Case(vs.fit_curved, {"groups": {"a": LEVEL, "b": DOWN}}),
        "plane_band": Case(vs.plane_band, {"points": LEVEL}),
        "plane_of_crossing": Case(vs.plane_of_crossing, {"first": LEVEL, "second": DOWN}),
        "read_orientations": Case(vs.read_orientations, {"path": table}),
        "stats": Case(vs.stats, {"table": table}),
        "fold": Case(vs.fold, {"table": table}),
        "slip": Case(vs.slip, {"table": SLIPS}),
        "sets": Case(vs.sets, {"table": PLANES}),
        "slope": Case(vs.slope, {"table": PLANES, "face": (100, 70), "friction_deg": 30}),
        "displacement": Case(
            vs.displacement,
            {"pairs": [[5, 0, -8.66, 0, 0, 0]], "fault": (90, 60), "bed": (200, 10)},
        ),
        "threepoint": Case(vs.threepoint, {"points": [[0, 0, 100], [0, 50, 100], [40, 20, 80]]}),
        "log": Case(vs.log, {"table": [[0, 0, 0], [10, 0, 0]], "bed": (90, 30)}),
        "fractures": Case(vs.fractures, {"traces": CROSS}),
        "stereonet": Case(vs.stereonet, {"table": PLANES, "contour": "kamb"}),
        "rose": Case(vs.rose, {"table": PLANES}),
        "orthophoto": Case(
            vs.orthophoto, {"model": mesh, "trend_deg": 0, "plunge_deg": 90, "gsd_m": 0.1}
        ),
        "orthophoto plane": Case(vs.orthophoto, {"model": mesh, "plane": "90/50", "gsd_m": 0.1}),
        "orthophoto fold": Case(vs.orthophoto, {"model": mesh, "fold": PLANES, "gsd_m": 0.1}),
        "dem": Case(vs.dem, {"model": mesh, "gsd_m": 0.1}),
        "section": Case(vs.section, cut),
        "section line": Case(vs.section, {"model": mesh, "section_line": [[0, 0], [2, 2]]}),
        "extend": Case(
            vs.extend, {"model": GROUND, "plane": (90, 45), "through": (1, 1, 0.2), "error_deg": 2}
        ),
        "extend of": Case(
            vs.extend,
            {"model": GROUND, "of": [[1, 1, 0.2], [1, 2, 0.2], [1.2, 1, 0], [1.2, 2, 0.01]]},
        ),
        "surface": Case(vs.surface, {"model": GROUND}),
        "register": Case(vs.register, {"model_points": MODEL, "world_points": WORLD}),
        "register -": Case(
            vs.register,
            {"model_points": "-", "level": [[0, 0, 0, 5, 0, 0.1], [0, 0, 0, 0, 5, 0.2]]},
        ),
        "register()": Case(vs.register(MODEL, WORLD), {"points": MODEL}),
        "compare": Case(vs.compare, {"model": GROUND + [0, 0, 0.05], "benchmark": GROUND}),
        "agreement": Case(vs.agreement, {"first": table, "second": table}),
        "repeats": Case(vs.repeats, {"table": REPEATED, "by": "bed"}),
        "facets": Case(vs.facets, {"model": GROUND}),
        "measurable": Case(vs.measurable, {"model": GROUND, "plane": (90, 45), "length_m": 1.0}),
        "follow": Case(
            vs.follow,
            {"model": mesh, "through": [[0.1, 0.1, 0.02], [2, 2, 0.4]], "cost": "curvature"},
        ),
        "propose_traces": Case(vs.propose_traces, {"model": mesh, "cost": "curvature"}),
        "reconstruct": Case(vs.reconstruct, photos),
        "export_cameras": Case(
            vs.export_cameras,
            {"source": vs.sample("cameras.json"), "target": folder / "transforms.json"},
        ),
        "sample": Case(lambda parts: vs.sample(parts), {"parts": "picks.csv"}),
        "Mesh.from_arrays": Case(vs.Mesh.from_arrays, {"points": GROUND, "faces": [[0, 1, 2]]}),
        "Mesh.from_pyvista": Case(vs.Mesh.from_pyvista, {"mesh": mesh.to_pyvista()}),
        "Mesh.save": Case(mesh.save, {"path": folder / "out.ply", "force": True}),
        "PointCloud.save": Case(mesh.save, {"path": folder / "out.ply", "force": True}),
        "Orthophoto.save": Case(picture.save, {"path": folder / "out.tif", "force": True}),
        "ElevationModel.save": Case(
            vs.dem(mesh, gsd_m=0.1).save, {"path": folder / "dem.tif", "force": True}
        ),
        "Section.save": Case(vs.section(**cut).save, {"path": folder / "cut.csv", "force": True}),
        "Project.open": Case(vs.Project.open, {"path": folder / "none.vom"}),
        "Project.create": Case(vs.Project.create, {"path": folder / "ground.vom"}),
        "Project.add_model": Case(project.add_model, {"path": folder / "ground.obj"}),
        "Project.add_trace": Case(project.add_trace, trace),
        "Project.add_points": Case(
            project.add_points, {"points": {"a": trace["points"]}, "type": "bedding"}
        ),
        "Project.add_line": Case(
            project.add_line, {"points": GROUND[:2], "type": "lineation", "on": "B01"}
        ),
        "Project.add_patch": Case(
            project.add_patch,
            {"outline": GROUND[[0, 20, 20 + 30 * 20, 30 * 20]], "type": "joint"},
        ),
        "Project.add_patch elements": Case(
            project.add_patch, {"elements": np.arange(50), "type": "joint"}
        ),
        "Project.add_station": Case(project.add_station, {"point": GROUND[0]}),
        "Project.import_file": Case(project.import_file, {"path": folder / "none.gpkg"}),
        "Project.accept_facets": Case(project.accept_facets, {"type": "joint"}),
        "Project.accept_traces": Case(
            project.accept_traces, {"type": "bedding", "cost": "curvature"}
        ),
        "Project.register": Case(
            project.register, {"model_points": GROUND[:70:7], "world_points": GROUND[:70:7]}
        ),
        "Project.set_type": Case(project.set_type, {"features": "B01", "type": "bedding"}),
        "Project.set_values": Case(project.set_values, {"features": "B01", "set": "west"}),
        "Project.delete": Case(project.delete, {"features": "B99"}),
        "Project.fit": Case(project.fit, {"id": "B01"}),
        "Project.judge_by": Case(project.judge_by, {"profile": "error"}),
        "Project.report": Case(project.report, {"path": folder / "report.html", "force": True}),
        "Project.export": Case(
            project.export, {"format": "csv", "path": folder / "out.csv", "force": True}
        ),
        "Project.save_as": Case(project.save_as, {"path": folder / "ground.vom"}),
    }


NAMES = (
    "read",
    "read_photos",
    "check",
    "plan",
    "fit_plane",
    "fit_planes",
    "fit_planes dict",
    "fit_parallel",
    "fit_curved",
    "plane_band",
    "plane_of_crossing",
    "read_orientations",
    "stats",
    "fold",
    "slip",
    "sets",
    "slope",
    "displacement",
    "threepoint",
    "log",
    "fractures",
    "stereonet",
    "rose",
    "orthophoto",
    "orthophoto plane",
    "orthophoto fold",
    "dem",
    "section",
    "section line",
    "extend",
    "extend of",
    "surface",
    "register",
    "register -",
    "register()",
    "compare",
    "agreement",
    "facets",
    "measurable",
    "follow",
    "propose_traces",
    "export_cameras",
    "reconstruct",
    "sample",
    "Mesh.from_arrays",
    "Mesh.from_pyvista",
    "Mesh.save",
    "PointCloud.save",
    "Orthophoto.save",
    "ElevationModel.save",
    "Section.save",
    "Project.open",
    "Project.create",
    "Project.add_model",
    "Project.add_trace",
    "Project.add_points",
    "Project.add_line",
    "Project.add_patch",
    "Project.add_patch elements",
    "Project.add_station",
    "Project.import_file",
    "Project.accept_facets",
    "Project.accept_traces",
    "Project.register",
    "Project.set_type",
    "Project.set_values",
    "Project.delete",
    "Project.fit",
    "Project.judge_by",
    "Project.report",
    "Project.export",
    "Project.save_as",
    "repeats",
)


def arguments(case: Case) -> list[str]:
    parameters = inspect.signature(case.function).parameters.values()
    kinds = (inspect.Parameter.VAR_KEYWORD, inspect.Parameter.VAR_POSITIONAL)
    return [p.name for p in parameters if p.kind not in kinds]


def answer(case: Case, argument: str, value: Any) -> vs.errors.VomError | None:
    """The error of ours, None for a result; anything else is raised."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", vs.errors.VomWarning)
        try:
            made = case.function(**{**case.good, argument: value})
        except vs.errors.VomError as error:
            return error
        finally:
            plt.close("all")
    if isinstance(made, vs.Project):
        shutil.rmtree(made.path)
        made.close()
    return None


def test_every_public_function_and_method_is_covered() -> None:
    tried = {name.split(" ")[0] for name in NAMES}
    functions = {n for n in vs.__all__ if inspect.isfunction(getattr(vs, n))}
    assert functions <= tried
    for kind in (getattr(vs, n) for n in vs.__all__ if inspect.isclass(getattr(vs, n))):
        for name, method in inspect.getmembers(kind, callable):
            if not name.startswith("_") and set(inspect.signature(method).parameters) - {"self"}:
                assert f"{kind.__name__}.{name}" in tried


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_impossible_values_are_refused_by_argument_name(name: str, cases: dict[str, Case]) -> None:
    case = cases[name]
    for argument in arguments(case):
        for what, value in NEVER.items():
            if (name, argument, what) in TAKEN:
                continue
            error = answer(case, argument, value)
            assert error is not None, f"{argument}: {what} is taken"
            named = f"{error.field} {error.message}".replace("-", "_")
            assert argument.split("_")[0] in named, f"{argument}: {what}: {error}"


@pytest.mark.full
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_unusual_values_give_result_or_sentence(name: str, cases: dict[str, Case]) -> None:
    case = cases[name]
    for argument in arguments(case):
        for value in SELDOM.values():
            error = answer(case, argument, value)
            assert error is None or error.message.endswith("."), str(error)


@pytest.mark.parametrize(
    "call",
    [
        lambda folder: vs.fit_plane([[0, 0, 0], [1, 1, 1], [2, 2, 2]]),
        lambda folder: vs.fit_planes({"a": GROUND[:2]}),
        lambda folder: vs.register(GROUND[:2], GROUND[:2]),
        lambda folder: vs.fold(([90, 90], [30, 30])),
        lambda folder: vs.plan("no such camera", distance_m=9, width_m=9, height_m=9),
        lambda folder: vs.orthophoto(vs.sample("sample.obj"), trend_deg=3),
        lambda folder: vs.Project.open(folder / "none.vom"),
        lambda folder: vs.Project.create(vs.sample("sample.obj")),
        lambda folder: vs.read(folder / "none.obj"),
        lambda folder: vs.stats(folder / "none.csv"),
    ],
)
def test_user_correctable_errors_are_input_errors(
    call: Callable[[Path], Any], tmp_path: Path
) -> None:
    with pytest.raises(vs.errors.InputError):
        call(tmp_path)


def test_only_cancellation_and_internal_errors_are_not_input_errors() -> None:
    kinds = vars(vs.errors).values()
    expected = {k for k in kinds if isinstance(k, type) and issubclass(k, vs.errors.VomError)}
    others = {k for k in expected if not issubclass(k, vs.errors.InputError)}
    assert others == {vs.errors.VomError, vs.errors.Cancelled, vs.errors.WorkerError}
