"""What a function gives has the names of what its command prints, with the same values."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

import vomstudio as vs
from vomstudio.cli.common.output import to_json
from vomstudio.core.findings import Finding

OBJ = vs.sample("sample.obj")
CAMERA = "23.5x15.6,35,6000x4000"
MIDDLE = "364534,4721859.5,852"


class Pair(NamedTuple):
    """words : of the command, {table}, {cloud} and {out} filled in; call : of two paths, the table
    and the cloud; files : of the command only"""

    words: str
    call: Callable[[Path, Path], Any]
    files: tuple[str, ...] = ()


PAIRS = {
    "stats": Pair("stats {table} --by kind", lambda t, _: vs.stats(t, by="kind")),
    "fold": Pair("fold {table}", lambda t, _: vs.fold(t)),
    "sets": Pair("sets {table} -o {out}", lambda t, _: vs.sets(t), ("table",)),
    "slope": Pair(
        "slope {table} --face 310/75 --friction 35",
        lambda t, _: vs.slope(t, (310, 75), friction_deg=35),
        ("image",),
    ),
    "plan": Pair(
        f"plan --camera {CAMERA} --distance 20 --width 30 --height 10",
        lambda *_: vs.plan(CAMERA, distance_m=20, width_m=30, height_m=10),
        # Positions are `stations`, not rounded; `select_kind` returns those of one kind.
        ("sheet", "positions", "perpendicular", "oblique"),
    ),
    "check": Pair(
        f"check {vs.sample('photos')} --distance 20",
        lambda *_: vs.check(vs.sample("photos"), distance_m=20),
    ),
    "section": Pair(
        f"section {OBJ} --plane 110/90 --through {MIDDLE} -o {{out}}",
        lambda *_: vs.section(OBJ, plane="110/90", through=[364534, 4721859.5, 852]),
        # Of a section in memory there are the lines, and no features beside.
        (
            "file",
            "polylines",
            "points",
            "features",
            "left_out",
            "features_file",
            "convention",
            "projection_trend_deg",
            "projection_plunge_deg",
            "projection_angle_deg",
            "domains",
        ),
    ),
    "dem": Pair(
        f"dem {OBJ} --gsd 0.5 -o {{out}}.tif",
        lambda *_: vs.dem(OBJ, gsd_m=0.5),
        ("raster", "sidecar", "hillshade", "slope", "aspect", "contours"),
    ),
    "ortho": Pair(
        f"ortho {OBJ} --trend 31 --plunge 10 --gsd 0.5 -o {{out}}.tif",
        lambda *_: vs.orthophoto(OBJ, trend_deg=31, plunge_deg=10, gsd_m=0.5),
        (
            "image",
            "depth",
            "sidecar",
            "world_file",
            "sheet",
            "drawing",
            "holes_filled_px",
            "holes_filled_up_to_m",
        ),
    ),
    "facets": Pair(
        # What reading the model has to say is a warning of `vs.read` in Python.
        "facets {cloud} -o {out}",
        lambda _, c: vs.facets(c),
        ("table", "labels", "warnings"),
    ),
    "compare": Pair("compare {cloud} {cloud}", lambda _, c: vs.compare(c, c), ("warnings",)),
}


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.full] if name == "check" else []) for name in PAIRS],
)
@pytest.mark.filterwarnings("ignore::vomstudio.core.errors.VomWarning")
def test_names_and_values_match_command_output(
    name: str, tmp_path: Path, command: Callable[..., dict[str, Any]]
) -> None:
    table, cloud = tmp_path / "planes.csv", tmp_path / "cloud.xyz"
    command("fit", vs.sample("picks.csv"), "--by", "pick", "-o", table)
    x, y = (v.ravel() for v in np.meshgrid(np.arange(0, 3, 0.1), np.arange(0, 3, 0.1)))
    np.savetxt(cloud, np.column_stack([x, y, 0.2 * x]))
    words, call, files = PAIRS[name]
    told = command(*words.format(table=table, cloud=cloud, out=tmp_path / "out.csv").split())
    found = call(table, cloud)
    assert [key for key in told if key not in files and not hasattr(found, key)] == []
    for key in told.keys() - {*files}:
        same(told[key], getattr(found, key), key)


@pytest.mark.filterwarnings("ignore::vomstudio.core.errors.VomWarning")
def test_facet_sets_have_same_attributes_as_orientation_sets(
    tmp_path: Path, command: Callable[..., dict[str, Any]]
) -> None:
    """Stairs: six treads and six risers of a square metre."""
    u, v = (w.ravel() for w in np.meshgrid(np.arange(0, 1, 0.05), np.arange(0, 1, 0.05)))
    level, steep = np.stack([u, v, 0 * u], axis=1), np.stack([0 * u, v, u], axis=1)
    stairs = [part + [k, 0, k] for k in range(6) for part in (level, steep + [1.0, 0, 0])]
    np.savetxt(tmp_path / "stairs.xyz", np.concatenate(stairs))
    told = command("facets", tmp_path / "stairs.xyz", "-o", tmp_path / "f.csv", "--propose-sets")
    found = vs.facets(tmp_path / "stairs.xyz", propose_sets=True)
    assert [one.n for one in found.sets] == [6, 6]
    assert sorted(one.dip_deg for one in found.sets) == pytest.approx([0, 90], abs=0.1)
    assert found.discontinuities[0].set == found.sets[0].name == "S1"
    for name in ("sets", "discontinuities"):
        same(told[name], getattr(found, name), name)
        same(told[name], found.to_dict()[name], name)


def same(told: Any, found: Any, path: str) -> None:
    """Numbers, texts and None of JSON, whatever holds them in Python."""
    if isinstance(told, dict) and isinstance(found, Finding | str):
        assert found.to_dict() == told, path
    elif isinstance(told, dict):
        for key, value in told.items():
            inner = found[key] if isinstance(found, dict) else getattr(found, key)
            same(value, inner, f"{path}.{key}")
    elif isinstance(told, list):
        assert len(told) == len(found), path
        for place, (one, other) in enumerate(zip(told, found, strict=True)):
            same(one, other, f"{path}[{place}]")
    elif isinstance(told, float):
        assert float(found) == pytest.approx(told), path
    elif told is None:
        assert found in (None, "") or to_json({"v": found}) == '{"v": null}', path
    else:
        assert found == told, path
