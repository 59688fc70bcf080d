"""Where the decimal mark is a comma, files and JSON hold the same bytes as anywhere else."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from vomstudio.geometry.frames import Frame
from vomstudio.project import edits
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.records import Model

ROOT = Path(__file__).resolve().parents[2]
NAME = "de_DE.UTF-8"
# As a library would: Python alone never takes over the numbers of a locale.
PROGRAM = """
import json, locale, sys
locale.setlocale(locale.LC_ALL, '')
from vomstudio.cli import main
for words in json.loads(sys.argv[1]):
    code = main(words)
    if code:
        sys.exit(code)
"""
SHOW = (
    "import locale; locale.setlocale(locale.LC_ALL, ''); print(locale.format_string('%.1f', 0.5))"
)


@pytest.fixture(scope="module")
def comma(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """The environment of a German desktop; the locale is made where the system has none."""
    environment = {"LC_ALL": NAME, "LANG": NAME}
    if _decimal(environment) == "0,5":
        return environment
    folder = tmp_path_factory.mktemp("locales")
    if shutil.which("localedef") is None:
        pytest.skip(f"there is neither {NAME} nor localedef to make it")
    words = ["localedef", "-i", "de_DE", "-f", "UTF-8", str(folder / NAME)]
    subprocess.run(words, capture_output=True, check=False)
    environment["LOCPATH"] = str(folder)
    if _decimal(environment) != "0,5":
        pytest.skip(f"{NAME} cannot be made here (Debian: install the package locales)")
    return environment


def _decimal(extra: dict[str, str]) -> str:
    done = subprocess.run(
        [sys.executable, "-c", SHOW],
        env={**os.environ, **extra},
        capture_output=True,
        text=True,
        check=False,
    )
    return done.stdout.strip()


def run(folder: Path, extra: dict[str, str], commands: list[list[str]]) -> list[dict]:
    """What each command answered; all of them in one process, one after the other."""
    words = json.dumps([[*command, "--json"] for command in commands])
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, words],
        env={**os.environ, "LC_ALL": "C.UTF-8", "PYTHONPATH": str(ROOT), **extra},
        cwd=folder,
        capture_output=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr.decode()
    return [json.loads(line) for line in done.stdout.splitlines()]


def inputs(folder: Path) -> None:
    folder.mkdir()
    rng = np.random.default_rng(5)
    x, y = np.meshgrid(np.arange(12.0), np.arange(9.0))
    points = np.column_stack([x.ravel(), y.ravel(), (0.4 * x + 0.3 * y).ravel()])
    points = (points + rng.normal(0, 0.01, points.shape) + [576000.25, 5188000.5, 150.75]).round(4)
    rows = "".join(f"{a!r},{b!r},{c!r},0.5\n" for a, b, c in points.tolist())
    (folder / "points.csv").write_text("x,y,z,depth\n" + rows)
    corners = [k * 12 + j + 1 for k in range(8) for j in range(11)]
    faces = "".join(f"f {c} {c + 1} {c + 13}\nf {c} {c + 13} {c + 12}\n" for c in corners)
    vertices = "".join(f"v {a!r} {b!r} {c!r} 0.5 0.25 0.125\n" for a, b, c in points.tolist())
    (folder / "m.obj").write_text(vertices + faces)
    project = ProjectFolder.create(folder / "p.vom")
    session = project.session
    frame = Frame("crs", "EPSG:32615")
    model = Model("m1", "cliff", "m.obj", "mesh", "0" * 64, frame)
    session.apply(edits.add_model(session.records, model))
    vertices_of = tuple(map(tuple, points[::5].tolist()))
    trace = Trace("t1", "B1", "bedding", "m1", "0" * 64, vertices_of, resolution=0.05)
    session.apply(edits.add_trace(session.records, trace))
    session.save()
    project.close()


COMMANDS: list[list[str]] = [
    ["fit", "points.csv", "-o", "planes.csv"],
    ["stats", "planes.csv"],
    ["stereonet", "planes.csv", "-o", "net.svg"],
    *[["convert", "m.obj", f"mesh.{e}", "--crs", "32615"] for e in ("ply", "glb", "dxf", "obj")],
    *[["convert", "points.csv", f"c.{e}", "--crs", "32615"] for e in ("laz", "shp", "dxf", "xyz")],
    *[["export", "p.vom", "--to", e, "-o", f"e.{e}"] for e in ("csv", "shp", "dxf", "gpkg")],
    ["ortho", "m.obj", "--trend", "0", "--plunge", "90", "--gsd", "0.25", "-o", "o.tif"],
    ["info", "m.obj", "c.laz", "o.tif", "points.csv"],
]


@pytest.mark.full
def test_files_and_json_are_the_same_under_a_comma_locale(
    tmp_path: Path, comma: dict[str, str]
) -> None:
    answers = {}
    for name, extra in (("dot", {}), ("comma", comma)):
        inputs(tmp_path / name)
        answers[name] = run(tmp_path / name, extra, COMMANDS)
    for words, dot, other in zip(COMMANDS, answers["dot"], answers["comma"], strict=True):
        assert other == dot, words
    made = sorted(p.name for p in (tmp_path / "dot").iterdir() if p.is_file())
    assert len(made) > 25
    for name in made:
        if name.endswith((".gpkg", ".svg")):  # they hold the time at which they were made
            continue
        assert (tmp_path / "comma" / name).read_bytes() == (tmp_path / "dot" / name).read_bytes()
    import pyogrio

    for folder in ("dot", "comma"):
        _, _, _, columns = pyogrio.raw.read(tmp_path / folder / "e.gpkg", layer="planes")
        answers[folder] = [str(column.tolist()) for column in columns]
    assert answers["comma"] == answers["dot"]
    svg = [(tmp_path / f / "net.svg").read_text() for f in ("dot", "comma")]
    assert len(svg[0]) == len(svg[1])
