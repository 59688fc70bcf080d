"""The program's own data: found in a checkout and in a wheel, and true."""

from __future__ import annotations

import csv
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

from vomstudio.core.errors import InputError
from vomstudio.core.paths import documentation, resource

ROOT = Path(__file__).resolve().parents[2]


def rows(name: str) -> list[dict[str, str]]:
    lines = resource("outcrop", name).read_text("utf-8").splitlines()
    return list(csv.DictReader(line for line in lines if not line.startswith("#")))


def picks() -> dict[str, np.ndarray]:
    traces: dict[str, list[list[float]]] = {}
    for row in rows("picks.csv"):
        traces.setdefault(row["trace"], []).append([float(row[axis]) for axis in "xyz"])
    return {name: np.array(points) for name, points in traces.items()}


def upward_normal(dip_direction_deg: float, dip_deg: float) -> np.ndarray:
    a, d = np.radians([dip_direction_deg, dip_deg])
    return np.array([np.sin(a) * np.sin(d), np.cos(a) * np.sin(d), np.cos(d)])


def test_missing_resource_raises_error_with_its_name() -> None:
    with pytest.raises(InputError, match=r"missing\.txt"):
        resource("missing.txt")


def test_picks_lie_on_planes_of_truth_table() -> None:
    traces = picks()
    assert len(traces) == 8
    for row in rows("truth.csv"):
        points = traces.pop(row["trace"])
        assert 15 <= len(points) <= 40
        normal = upward_normal(float(row["dip_direction_deg"]), float(row["dip_deg"]))
        distances = (points - points.mean(axis=0)) @ normal
        # 5 mm of noise: the spread of some twenty points is known to about a sixth.
        assert 0.002 < distances.std(ddof=1) < 0.008
    assert not traces


def test_the_stated_fold_axis_lies_in_every_bed() -> None:
    note = resource("outcrop", "truth.csv").read_text("utf-8").splitlines()[0]
    trend, plunge = np.radians(
        [float(note.split(word)[1].split()[0].rstrip(",;")) for word in ("trend", "plunge")]
    )
    axis = [np.sin(trend) * np.cos(plunge), np.cos(trend) * np.cos(plunge), -np.sin(plunge)]
    for row in rows("truth.csv"):
        normal = upward_normal(float(row["dip_direction_deg"]), float(row["dip_deg"]))
        assert abs(normal @ axis) < 1e-5


def test_the_outcrop_has_its_textures_and_its_picks_on_its_surface() -> None:
    lines = resource("outcrop", "outcrop.obj").read_text("ascii").splitlines()
    vertices = np.array([line.split()[1:] for line in lines if line.startswith("v ")], dtype=float)
    for points in picks().values():
        nearest = np.linalg.norm(points[:, None] - vertices[None], axis=2).min(axis=1)
        assert nearest.max() < 0.2  # cells are some 0.13 m wide, ledges stretch them
    materials = resource("outcrop", "outcrop.mtl").read_text("ascii").splitlines()
    images = [line.split()[1] for line in materials if line.startswith("map_Kd")]
    assert len(images) == 2
    assert all(resource("outcrop", image).is_file() for image in images)
    size = sum(file.stat().st_size for file in resource("outcrop").iterdir())
    assert size < 600_000


@pytest.mark.full
def test_a_wheel_carries_the_resources_and_finds_them(tmp_path: Path) -> None:
    source = tmp_path / "source"
    source.mkdir()
    for name in ("vomstudio", "resources", "docs"):
        shutil.copytree(ROOT / name, source / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in (
        "pyproject.toml",
        "setup.py",
        "MANIFEST.in",
        "README.md",
        "LICENSE",
        "THIRD_PARTY.md",
    ):
        shutil.copy(ROOT / name, source)
    subprocess.run(
        [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", tmp_path, source],
        check=True,
        capture_output=True,
        timeout=120,
    )
    (wheel,) = tmp_path.glob("*.whl")
    installed = tmp_path / "installed"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(installed)
    asked = "from vomstudio.core.paths import documentation, resource; "
    asked += "print(resource('outcrop', 'outcrop.obj')); print(documentation())"
    found, pages = subprocess.run(
        [sys.executable, "-c", asked],
        cwd=installed,
        check=True,
        capture_output=True,
        text=True,
    ).stdout.splitlines()
    assert Path(found) == installed / "vomstudio" / "resources" / "outcrop" / "outcrop.obj"
    assert sorted(p.name for p in Path(found).parent.iterdir()) == sorted(
        p.name for p in resource("outcrop").iterdir()
    )
    assert Path(pages) == installed / "vomstudio" / "resources" / "docs"
    assert sorted(p.name for p in Path(pages).iterdir()) == sorted(
        p.name for p in documentation().iterdir()
    )
