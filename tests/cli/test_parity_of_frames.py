"""Every door that takes coordinates answers every odd frame with a code, never silently.

The table of answers is printed: ``pytest -s -m "" tests/cli/test_parity_of_frames.py``.
"""

from __future__ import annotations

import json
import warnings
from collections import defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vomstudio as vs
from tests.frames import bed_grid, convert, write_cloud, write_prj, write_table
from tests.messages import codes
from vomstudio.geometry.units import METRES_PER_UNIT

pytestmark = pytest.mark.full

ZONE, FEET_CRS = "EPSG:32618", "EPSG:2263"
ORIGIN = np.array([600_000.0, 4_510_000.0, 0.0])  # Long Island, where both are at home
US_FOOT = METRES_PER_UNIT["us-ft"]
Array = np.ndarray
TABLE: dict[tuple[str, str], str] = {}


# --- what is given ----------------------------------------------------------------------------
def bed(step_m: float = 0.5) -> Array:
    """Points of a bed of 090/30 in the metric zone."""
    points = bed_grid(30.0, 15.0, step_m, ORIGIN + [0.0, 0.0, 50.0])
    points[:, 2] += np.random.default_rng(1).normal(0.0, 0.002, len(points))
    return points


def moved(points: Array, crs: str) -> Array:
    return convert(points, crs, ZONE)


def in_feet(points: Array) -> Array:
    converted = moved(points, FEET_CRS)
    return np.column_stack([converted[:, :2], points[:, 2] / US_FOOT])


FRAMES: dict[str, tuple[Callable[[Array], Array], str | None, set[str]]] = {
    "web mercator": (lambda p: moved(p, "EPSG:3857"), "EPSG:3857", {"frame.not-metric"}),
    "equal area": (lambda p: moved(p, "EPSG:6933"), "EPSG:6933", {"frame.not-metric"}),
    "degrees": (
        lambda p: moved(p, "EPSG:4326"),
        "EPSG:4326",
        {"frame.degrees"},
    ),
    "feet": (in_feet, FEET_CRS, {"frame.unit-converted"}),
    "mixed units": (
        lambda p: p / [1.0, 1.0, US_FOOT],
        f"{ZONE}+6360",
        {"frame.unit-converted"},
    ),
    "exchanged": (lambda p: p[:, [1, 0, 2]], ZONE, {"frame.swapped-axes"}),
    "degrees, not stated": (
        lambda p: moved(p, "EPSG:4326"),
        None,
        {"frame.maybe-degrees"},
    ),
    "not stated": (lambda p: p, None, {"frame.assumed"}),
    "y up, not stated": (
        lambda p: p[:, [0, 2, 1]] * [1.0, 1.0, -1.0],
        None,
        {"frame.assumed"},
    ),
}


def write_model(path: Path, points: Array, crs: str | None) -> Path:
    return write_cloud(path.with_suffix(".xyz"), points, crs)


def write_points(path: Path, points: Array, crs: str | None) -> Path:
    selected = points[:: max(1, len(points) // 12)]
    return write_table(path.with_suffix(".csv"), selected, crs)


def write_pairs(path: Path, points: Array, crs: str | None) -> Path:
    """Pairs on both sides of a fault."""
    header = "hanging_x,hanging_y,hanging_z,footwall_x,footwall_y,footwall_z"
    rows = np.column_stack([points[:5], points[40:45]])
    return write_table(path.with_suffix(".csv"), rows, crs, header)


def write_oriented(path: Path, points: Array, crs: str | None) -> Path:
    """Planes with a place, as a table of orientations."""
    rng = np.random.default_rng(2)
    rows = np.column_stack([rng.normal(90, 3, 12), rng.normal(30, 3, 12), points[:12]])
    return write_table(path.with_suffix(".csv"), rows, crs, "dip_direction_deg,dip_deg,x,y,z")


def write_control(path: Path, points: Array, crs: str | None) -> Path:
    """Pairs of places on a model and in World."""
    pairs = np.column_stack([bed()[::97] - ORIGIN, points[::97]])
    rows = [(f"P{number}", *pair) for number, pair in enumerate(pairs)]
    header = "label,model_x,model_y,model_z,x,y,z"
    return write_table(path.with_suffix(".csv"), rows, crs, header)


def write_drawing(path: Path, points: Array, crs: str | None) -> Path:
    """Lines on a pavement: a shapefile, whose CRS is in its .prj."""
    import pyogrio.raw
    import shapely

    drawing = path.with_suffix(".shp")
    lines = [shapely.LineString(points[i : i + 2]) for i in range(0, 240, 24)]
    pyogrio.raw.write(
        drawing,
        shapely.to_wkb(np.array(lines, object)),
        [],
        [],
        driver="ESRI Shapefile",
        geometry_type="LineString Z",
        crs=ZONE,
    )
    drawing.with_suffix(".prj").unlink()
    if crs is not None:
        write_prj(drawing, crs)
    return drawing


# --- the doors --------------------------------------------------------------------------------
Write = Callable[[Path, Array, str | None], Path]
COMMANDS: dict[str, tuple[Write, str]] = {
    "info (model)": (write_model, "info {file}"),
    "info (table)": (write_points, "info {file}"),
    "convert": (write_model, "convert {file} {out}.ply"),
    "facets": (write_model, "facets {file} -o {out}.csv"),
    "compare": (write_model, "compare {file} {good}"),
    "dem": (write_model, "dem {file} -o {out}.tif"),
    "ortho": (write_model, "ortho {file} --trend 0 --plunge 90 -o {out}.tif"),
    "section": (write_model, "section {file} --plane 0/90 --through {middle} -o {out}.csv"),
    "extend": (
        write_model,
        "extend {file} --plane 0/60 --through {middle} --error 1 -o {out}.csv",
    ),
    "measurable": (write_model, "measurable {file} --plane 90/30"),
    "surface": (write_model, "surface {file} -o {out}.csv"),
    "trace --propose": (write_model, "trace {file} --propose --cost curvature -o {out}.csv"),
    "fit": (write_points, "fit {file}"),
    "threepoint": (write_points, "threepoint {file}"),
    "log": (write_points, "log {file} --bed 90/30"),
    "displacement": (write_pairs, "displacement {file} --fault 90/60"),
    "sets": (write_oriented, "sets {file} -o {out}.csv"),
    "extend POINTS": (write_points, "extend {good} {file} -o {out}.csv"),
    "section --features": (
        write_oriented,
        "section {good} --plane 0/90 --through {middle} --features {file} -o {out}.csv",
    ),
    "register --pairs": (write_control, "register - --pairs {file}"),
    "fractures": (write_drawing, "fractures {file}"),
}
PYTHON: dict[str, tuple[Write, Callable[[Path], Any]]] = {
    "vs.read": (write_model, vs.read),
    "vs.facets": (write_model, vs.facets),
    "vs.dem": (write_model, vs.dem),
    "vs.measurable": (write_model, lambda path: vs.measurable(path, plane=(90, 30))),
    "vs.threepoint": (write_points, vs.threepoint),
    "vs.log": (write_points, lambda path: vs.log(path, bed=(90, 30))),
    "vs.displacement": (write_pairs, lambda path: vs.displacement(path, fault=(90, 60))),
    "vs.sets": (write_oriented, vs.sets),
    "vs.fractures": (write_drawing, vs.fractures),
}
# Points of a model are in its World unless their table states another CRS.
_IN_WORLD = ("not stated", "y up, not stated", "degrees, not stated")
_CONVERTED = ("web mercator", "equal area", "degrees", "feet")
OTHER_ANSWERS: dict[tuple[str, str], set[str]] = {
    # The model and its reference are in two systems, or far apart.
    ("compare", "feet"): {"crs.different"},
    ("compare", "degrees, not stated"): {"reference.no-overlap"},
    ("compare", "y up, not stated"): {"reference.no-overlap"},
    # The bed is vertical then.
    ("dem", "y up, not stated"): {"view.edge-on"},
    ("vs.dem", "y up, not stated"): {"view.edge-on"},
    # The plane does not meet the model.
    ("extend", "degrees, not stated"): {"extension.misses-model"},
    ("extend POINTS", "degrees, not stated"): {"extension.misses-model"},
    ("extend POINTS", "y up, not stated"): {"extension.misses-model"},
    ("extend POINTS", "not stated"): set(),
    **{("section --features", frame): set() for frame in _IN_WORLD},
    **{
        (door, frame): {"frame.reprojected"}
        for door in ("extend POINTS", "section --features")
        for frame in _CONVERTED
    },
}
"""All codes of a door whose answer differs."""


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A model in the metric zone."""
    return write_model(tmp_path_factory.mktemp("good") / "good", bed(), ZONE)


@pytest.fixture(scope="module", autouse=True)
def table() -> Iterator[None]:
    yield
    doors = list(dict.fromkeys(door for door, _ in TABLE))
    for door in doors:
        print(f"\n{door}")
        for frame in FRAMES:
            print(f"    {frame:20} {TABLE.get((door, frame), '')}")


def expect(door: str, frame: str, found: set[str]) -> None:
    """Store the codes of a door, and check that they contain those of the frame."""
    TABLE[door, frame] = ", ".join(sorted(found))
    if (door, frame) in OTHER_ANSWERS:
        assert found == OTHER_ANSWERS[door, frame], f"{door}, {frame}"
        return
    *_, expected = FRAMES[frame]
    assert found >= expected, f"{door}, {frame}: {sorted(found)}"


@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("door", COMMANDS)
def test_command_reports_unusual_frame_with_a_code(
    run, tmp_path: Path, good: Path, door: str, frame: str
) -> None:
    write, words = COMMANDS[door]
    change, crs, _ = FRAMES[frame]
    file = write(tmp_path / "given", change(bed()), crs)
    place = ORIGIN[None] + [7.0, 7.0, 46.0]
    if words.split()[1] == "{file}":
        # In metres of the frame of the model.
        factors = {"feet": [US_FOOT] * 3, "mixed units": [1.0, 1.0, US_FOOT]}
        place = change(place) * factors.get(frame, [1.0] * 3)
    middle = ",".join(f"{value:.9f}" for value in place[0])
    command = words.format(file=file, good=good, out=tmp_path / "out", middle=middle)
    answer = run(*command.split(), "--json")
    found = {answer.json["error"]["code"]} if answer.code else set()
    found |= set(codes(answer.json)) if "warnings" in answer.json else set()
    for described in answer.json.get("files", ()):
        found |= set(codes(described)) if isinstance(described, dict) else set()
    expect(door, frame, found)


def codes_of_call(call: Callable[[], Any]) -> set[str]:
    """Return the codes of the Python warnings and the result of a call, or of its error."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            result = call()
        except vs.errors.VomError as error:
            return {error.code}
    found = {getattr(each.message, "code", "") for each in caught}
    return found | {each.code for each in getattr(result, "warnings", ())}


@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("door", PYTHON)
def test_python_function_reports_unusual_frame_with_a_code(
    tmp_path: Path, door: str, frame: str
) -> None:
    write, call = PYTHON[door]
    change, crs, _ = FRAMES[frame]
    file = write(tmp_path / "given", change(bed()), crs)
    expect(door, frame, codes_of_call(lambda: call(file)))


@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("door", ["project add-model", "Project.add_model"])
def test_project_reports_unusual_frame_with_a_code(
    run, tmp_path: Path, door: str, frame: str
) -> None:
    change, crs, _ = FRAMES[frame]
    file = write_model(tmp_path / "given", change(bed()), crs)
    folder = tmp_path / "study.vom"
    with vs.Project.create(folder) as project:
        if door == "Project.add_model":
            found = codes_of_call(lambda: project.add_model(file))
    if door == "project add-model":
        answer = run("project", folder, "add-model", file, "--json")
        found = {answer.json["error"]["code"]} if answer.code else set(codes(answer.json))
    expect(door, frame, found)


@pytest.mark.parametrize(
    "command", sorted({words.split()[0] for _, words in COMMANDS.values()} - {"info", "register"})
)
def test_every_command_has_the_options_of_the_frame(run, command: str) -> None:
    described = run(command, "--help").out.split()
    assert {"--up", "--unit", "--crs", "--to-crs"} <= set(described)


def test_geojson_without_a_crs_is_converted(run, tmp_path: Path) -> None:
    points = bed()
    lengths = defaultdict(list)
    for name, crs in (("degrees", None), ("metres", ZONE)):
        coordinates = moved(points, "EPSG:4326") if crs is None else points
        collection: dict[str, Any] = {
            "type": "FeatureCollection",
            "features": [
                {
                    "type": "Feature",
                    "properties": {},
                    "geometry": {
                        "type": "LineString",
                        "coordinates": coordinates[i : i + 20, :2].tolist(),
                    },
                }
                for i in range(0, 300, 30)
            ],
        }
        if crs is not None:
            collection["crs"] = {"type": "name", "properties": {"name": crs}}
        file = tmp_path / f"{name}.geojson"
        file.write_text(json.dumps(collection))
        answer = run("fractures", file, "--json").json
        lengths["mean_m"].append(answer["length"]["mean_m"])
        if crs is None:
            assert "frame.reprojected" in codes(answer)
    degrees, metres = lengths["mean_m"]
    assert degrees == pytest.approx(metres, rel=1e-6)
