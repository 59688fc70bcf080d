"""Arguments of the wrong type are refused with a sentence, and nothing is spoilt by them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vomstudio as vs
from tests.messages import refused

PLANES: Any = ([90, 100, 95, 92, 10], [40, 42, 38, 41, 80])
CROSS: Any = [[(0, 0), (1, 1)], [(0, 1), (1, 0)]]
ANY: Any = vs

CALLS: dict[str, Callable[[], Any]] = {
    "stats by": lambda: ANY.stats(PLANES, by=["set"]),
    "fold sets": lambda: ANY.fold(PLANES, sets=3),
    "fold waviness": lambda: ANY.fold(PLANES, waviness_deg="x"),
    "fold kind": lambda: ANY.fold(PLANES, kind=3),
    "slope friction": lambda: ANY.slope(PLANES, (90, 70), friction_deg="x"),
    "sets seed of words": lambda: ANY.sets(PLANES, seeds=[("a", 3)]),
    "sets seed of one number": lambda: ANY.sets(PLANES, seeds=[3]),
    "sets seeds": lambda: ANY.sets(PLANES, seeds=3),
    "sets most": lambda: ANY.sets(PLANES, max_sets=2.5),
    "sets exactly": lambda: ANY.sets(PLANES, exactly="two"),
    "rose bins": lambda: ANY.rose(PLANES, bin_deg="a"),
    "rose bins of dips": lambda: ANY.rose(PLANES, of="dip", bin_deg="a"),
    "read": lambda: ANY.read(3),
    "read crs": lambda: ANY.read(vs.sample("sample.obj"), crs=32633),
    "read_photos": lambda: ANY.read_photos(3),
    "check": lambda: ANY.check(None),
    "check distance": lambda: ANY.check(vs.sample("photos"), distance_m="far"),
    "read_orientations": lambda: ANY.read_orientations(3),
    "orthophoto": lambda: ANY.orthophoto(3, trend_deg=0, plunge_deg=90),
    "dem": lambda: ANY.dem(np.zeros((3, 3))),
    "compare": lambda: ANY.compare(3, vs.sample("sample.obj")),
    "fractures": lambda: ANY.fractures(3),
    "fractures strikes": lambda: ANY.fractures(CROSS, strikes=[3]),
    "fractures snap": lambda: ANY.fractures(CROSS, snap_m=[1, 2]),
    "fractures by": lambda: ANY.fractures(CROSS, by=3),
    "fractures cap": lambda: ANY.fractures(CROSS, scanline=CROSS[1], terzaghi_cap="a"),
    "displacement fault": lambda: ANY.displacement([[5, 0, -9, 0, 0, 0]], fault=3),
    "displacement sigma": lambda: ANY.displacement(
        [[5, 0, -9, 0, 0, 0]], fault=(90, 60), sigma_m="x"
    ),
    "displacement pairs": lambda: ANY.displacement(["ab", "cd"], fault=(90, 60)),
    "threepoint": lambda: ANY.threepoint([["a", 1, 2]] * 3),
    "log bed": lambda: ANY.log([[0, 0, 0], [10, 0, 0]], bed="x"),
    "reconstruct": lambda: ANY.reconstruct(3, "model"),
    "Project.open": lambda: ANY.Project.open(3),
    "Project.create": lambda: ANY.Project.create(None),
}


@pytest.mark.parametrize("name", CALLS)
def test_invalid_arguments_are_refused(name: str) -> None:
    with pytest.raises(vs.errors.VomError) as found:
        CALLS[name]()
    assert str(found.value).endswith(".")


@pytest.mark.parametrize(
    "more", [{"set": 3}, {"name": 3}, {"type": None}, {"type": 3}, {"model": 3}]
)
def test_refused_trace_leaves_journal_valid(
    tmp_path: Path, picks: Any, more: dict[str, Any]
) -> None:
    bed = picks[picks["pick"] == "B01"][["x", "y", "z"]]
    with vs.Project.create(tmp_path / "cliff.vom") as project:
        given: dict[str, Any] = {"model": project.add_model(vs.sample("sample.obj"))}
        with pytest.raises(vs.errors.VomError):
            project.add_trace(bed, **{**given, "type": "bedding", **more})
        assert len(project.planes()) == 0
        assert project.verify().sound
        with pytest.raises(vs.errors.InputError):
            project.export("csv", 3)  # type: ignore[arg-type]


def test_exactly_option_gives_same_number_of_sets_as_command(tmp_path: Path, command: Any) -> None:
    steep, flat = [90, 271, 92, 268, 91, 89, 94], [20, 25, 18, 30, 22, 24]
    dips = [88, 89, 87, 86, 90, 87, 88, 31, 34, 32, 35, 33, 34]
    table = tmp_path / "planes.csv"
    rows = [f"{a},{d}" for a, d in zip(steep + flat, dips, strict=True)]
    table.write_text("\n".join(["dip_direction,dip", *rows]))
    told = command("sets", table, "--exactly", 1, "-o", tmp_path / "sets.csv")
    found = vs.sets(table, exactly=1)
    assert [s.n for s in found.sets] == [s["n"] for s in told["sets"]]
    assert len(found.sets) == 1
    with pytest.raises(vs.errors.UsageError) as error:
        vs.sets(table, exactly=2, max_sets=3)
    assert (error.value.code, error.value.field) == ("option.conflict", "exactly")


def test_model_read_with_project_uses_its_frame(tmp_path: Path, command: Any) -> None:
    """A tower of five points that says nothing of itself, in centimetres with y up."""
    file = tmp_path / "tower.obj"
    file.write_text(
        "v 0 0 0\nv 400 0 0\nv 400 0 300\nv 0 0 300\nv 200 900 150\n"
        "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"
    )
    folder = tmp_path / "cliff.vom"
    with vs.Project.create(folder) as project:
        project.add_model(file, up="y", unit="cm")
        project.save()
        # Also while it is open.
        model = vs.read(file, project=folder)
        np.testing.assert_allclose(model.bounds[1] - model.bounds[0], [4, 3, 9])
        np.testing.assert_allclose(model.points, project.models[0].read().points)
    relief = vs.dem(model, gsd_m=0.5)
    told = command("dem", file, "--project", folder, "--gsd", 0.5, "-o", tmp_path / "dem.tif")
    assert relief.highest_m == pytest.approx(told["highest_m"])
    with refused("option.not-with-project", vs.errors.UsageError, field="--unit"):
        vs.read(file, project=folder, unit="m")
    with refused("project.other-model", vs.errors.UsageError):
        vs.read(vs.sample("sample.obj"), project=folder)
