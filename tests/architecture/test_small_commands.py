"""What a command on a small input must not import: seconds of every user's day, measured in
modules, since a clock on a busy machine says little."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from vomstudio.cli import COMMANDS

ROOT = Path(__file__).resolve().parents[2]

OBJ = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n"
PLY = (
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n"
)
FACET = (
    "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex {} 0\nvertex {} 0\nendloop\nendfacet\n"
)
FILES = {
    "two.obj": OBJ,
    "two.ply": PLY,
    "two.stl": f"solid s\n{FACET.format('1 0', '1 1')}{FACET.format('1 1', '0 1')}endsolid s\n",
    "points.csv": "x,y,z\n0,0,0\n1,0,0.5\n1,1,0\n0,1,2.25\n",
    "points.xyz": "0 0 0\n1 0 0.5\n1 1 0\n0 1 2.25\n",
    "planes.csv": "dip_direction,dip\n100,30\n110,32\n97,25\n105,31\n",
}
HEAVY = {
    "numba",
    "scipy",
    "pandas",
    "pyproj",
    "laspy",
    "PIL",
    "matplotlib",
    "shapely",
    "rasterio",
    "cv2",
    "open3d",
    "rich",
    "importlib.metadata",
    "logging.handlers",
}
SCRIPT = """
import sys
from vomstudio.app import main
code = main(sys.argv[1:])
print("LOADED", code, *sorted(sys.modules), file=sys.stderr)
"""
# Text has no magic word, so the readers of other packages are asked about it first.
ASKS_OTHERS = {"info points.xyz"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    where = tmp_path_factory.mktemp("small")
    for name, text in FILES.items():
        (where / name).write_text(text)
    # Compiles as well what was never used on this machine.
    loaded_by(where, "convert", "two.obj", "two.glb")
    loaded_by(where, "info", "two.ply")
    return where


def loaded_by(folder: Path, *words: str) -> set[str]:
    """Dotted names of all modules of a process that runs a command, which must succeed."""
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, *words],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=300,
    )
    said = done.stderr.splitlines()[-1].split()
    assert said[:2] == ["LOADED", "0"], done.stderr
    return set(said[2:])


@pytest.mark.parametrize(
    "command",
    [
        "info two.obj",
        "info two.ply",
        "info two.glb",
        "info two.stl",
        "info points.csv",
        "info points.xyz",
        "fit points.csv",
        "stats planes.csv",
        "fold planes.csv",
    ],
)
def test_a_command_on_a_small_input_imports_nothing_heavy(folder: Path, command: str) -> None:
    loaded = loaded_by(folder, *command.split())
    assert "numpy" in loaded
    heavy = HEAVY - ({"importlib.metadata"} if command in ASKS_OTHERS else set())
    assert not heavy & loaded


def test_a_command_imports_no_other_command_and_no_other_format(folder: Path) -> None:
    loaded = loaded_by(folder, "info", "two.stl")
    commands = {f"vomstudio.cli.{name}" for name in COMMANDS}
    assert commands & loaded == {"vomstudio.cli.info"}
    formats = {f"vomstudio.io.models.formats.{name}" for name in ("obj", "ply", "gltf", "las")}
    assert not formats & loaded


def test_version_option_imports_no_numpy(folder: Path) -> None:
    assert not (HEAVY | {"numpy", "vomstudio.cli.info"}) & loaded_by(folder, "--version")
