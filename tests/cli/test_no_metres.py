"""What a model without scale says in JSON and tables: nothing that is not metres is called so."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import ezdxf
import numpy as np
import pytest

from vomstudio.cli.common.unitless_lengths import add_unitless_names
from vomstudio.io.photos.cameras_file import Cameras, write_cameras

GOLDEN = Path(__file__).parent / "golden"
ROW = ("pole_trend_deg", "extent_m", "n_points")
COMMANDS = {
    "section": "section {m} --plane 180/90 --through 5,5,0 -o {out}/s.csv",
    "dem": "dem {m} -o {out}/d.tif",
    "ortho": "ortho {m} --trend 0 --plunge 90 -o {out}/o.tif",
    "facets": "facets {m} -o {out}/f.csv --propose-sets",
    "surface": "surface {m} -o {out}/dev.csv --profiles {out}/p.csv",
    "measurable": "measurable {m} --plane 90/45",
    "compare": "compare {m} {m}",
    "trace": "trace {m} --through {m}.clicks.csv -o {out}/t.csv --cost curvature",
    "propose": "trace {m} --propose --cost curvature -o {out}/prop.csv",
    "extend": "extend {m} --plane 90/45 --through 5,5,0 --error 2 -o {out}/e.csv",
}


@pytest.fixture(scope="module")
def pair(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """The same rough slope twice: as a file that says nothing, and as made of photos that had
    neither control points nor GPS."""
    rng = np.random.default_rng(4)
    x, y = (a.ravel() for a in np.meshgrid(np.arange(0, 10.01, 0.25), np.arange(0, 10.01, 0.25)))
    z = 0.4 * np.abs(x - 5) + 0.02 * rng.standard_normal(len(x))
    n = 41
    at = np.arange(n * n).reshape(n, n)
    a, b, c, d = (w.ravel() + 1 for w in (at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]))
    text = "".join(f"v {p:.4f} {q:.4f} {r:.4f}\n" for p, q, r in zip(x, y, z, strict=True))
    text += "".join(
        f"f {i} {j} {k}\n" for i, j, k in [*zip(a, b, c, strict=True), *zip(a, c, d, strict=True)]
    )
    made = []
    for name in ("stated", "photos"):
        folder = tmp_path_factory.mktemp(name)
        (folder / "m.obj").write_text(text)
        (folder / "m.obj.clicks.csv").write_text(
            f"x,y,z\n1,5,{z[at[20, 4]]}\n4,5,{z[at[20, 16]]}\n"
        )
        made.append(folder / "m.obj")
    write_cameras(made[1].with_name("cameras.json"), Cameras((), made[1].parent))
    return made[0], made[1]


def lengths(value: Any, place: str = "") -> dict[str, Any]:
    """Every figure that is called metres, and where, but for rows of the orientation table."""
    if isinstance(value, list):
        return {
            k: v for n, each in enumerate(value) for k, v in lengths(each, f"{place}/{n}").items()
        }
    if not isinstance(value, dict) or all(name in value for name in ROW):
        return {}
    found: dict[str, Any] = {}
    for name, each in value.items():
        if name.endswith(("_m", "_m2")):
            found[f"{place}/{name}"] = each
        else:
            found |= lengths(each, f"{place}/{name}")
    return found


@pytest.mark.parametrize("command", list(COMMANDS))
def test_output_without_scale_also_has_unitless_names(  # type: ignore[no-untyped-def]
    run, pair: tuple[Path, Path], tmp_path: Path, command: str
) -> None:
    said = []
    for model in pair:
        out = tmp_path / model.parent.name
        out.mkdir()
        ran = run(*COMMANDS[command].format(m=model, out=out).split(), "--json")
        assert ran.code == 0, ran.err
        said.append(ran.json)
        for table in out.glob("*.csv"):
            metres = "_m," in table.read_text() or "_m\n" in table.read_text()
            rows = table.name == "f.csv"
            if command in ("section", "surface", "extend") or rows:
                assert metres == (model == pair[0] or rows), table
        if command in ("section", "dem", "ortho", "trace", "propose", "extend"):
            assert bool(re.search(r"\d m\b|\bm +m\b", ran.err)) == (model == pair[0]), ran.err
    stated, bare = said
    named = {k: v for k, v in lengths(stated).items() if v is not None}
    assert named, "the command tells lengths"
    assert lengths(bare).keys() >= {k for k in named if not isinstance(named[k], (list, dict))}
    for place, value in named.items():
        inside: Any = bare
        *way, last = place.strip("/").split("/")
        for step in way:
            inside = inside[int(step)] if isinstance(inside, list) else inside[step]
        name = last.removesuffix("_m2").removesuffix("_m")
        assert inside[last] == inside[name]
        assert value == pytest.approx(inside[name], rel=1e-6, nan_ok=True)


def test_drawing_states_metres_only_if_scale_is_known(  # type: ignore[no-untyped-def]
    run, pair: tuple[Path, Path], tmp_path: Path
) -> None:
    for model, unit in zip(pair, (ezdxf.units.M, 0), strict=True):
        out = tmp_path / f"{unit}.dxf"
        ran = run("section", model, "--plane", "180/90", "--through", "5,5,0", "-o", out)
        assert ran.code == 0, ran.err
        assert ezdxf.readfile(out).units == unit


def test_unitless_names_preserve_every_value() -> None:
    """Two figures of an object never get one name: of all commands' objects."""

    def kept(before: Any, after: Any) -> bool:
        if isinstance(before, list):
            return len(before) == len(after) and all(map(kept, before, after))
        if not isinstance(before, dict) or before.keys() >= set(ROW):
            return bool(before == after)
        lengths = [name for name in before if name.endswith(("_m", "_m2"))]
        return len(after) == len(before) + len(lengths) and all(
            kept(before[name], after[name]) for name in before
        )

    for path in GOLDEN.glob("*.json"):
        found = json.loads(path.read_text("utf-8")).get("json") or {}
        assert kept(found, add_unitless_names(found, is_metric=False)), path.name
        assert add_unitless_names(found, is_metric=True) == found
