"""The maker of the sample outcrop is a witness from outside."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.sample_maker import maker
from vomstudio.core.paths import resource
from vomstudio.project.sample import read_picks, read_truth, sample_model

ROOT = Path(__file__).resolve().parents[2]
FILES = [ROOT / "packaging" / "make_sample", *(ROOT / "packaging" / "sample_outcrop").glob("*.py")]


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_the_maker_names_no_module_of_the_program(file: Path) -> None:
    names = []
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names.append(node.module or "")
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            names += [node.value] if node.value.startswith("vomstudio") else []
    assert not [name for name in names if name.split(".")[0] == "vomstudio"]


def test_the_maker_runs_without_the_program() -> None:
    code = (
        f"import sys; sys.path.insert(0, {str(ROOT / 'packaging')!r})\n"
        "import sample_outcrop.files\n"
        "print([m for m in sys.modules if m.split('.')[0] == 'vomstudio'])"
    )
    done = subprocess.run(
        [sys.executable, "-P", "-c", code], capture_output=True, text=True, check=True, timeout=60
    )
    assert done.stdout.strip() == "[]"


def test_the_program_never_imports_its_maker() -> None:
    for file in (ROOT / "vomstudio").rglob("*.py"):
        assert "sample_outcrop" not in file.read_text("utf-8"), file


def test_the_model_of_the_sample_is_under_8_mb_with_several_textures() -> None:
    files = [file for file in resource("sample").iterdir() if file.is_file()]
    assert sum(file.stat().st_size for file in files) < 8_000_000
    assert len([file for file in files if file.suffix == ".jpg"]) >= 4


def test_all_resources_are_under_15_mb() -> None:
    files = [file for file in resource().rglob("*") if file.is_file()]
    assert sum(file.stat().st_size for file in files) < 15_000_000


def test_every_true_bed_and_the_fault_contain_the_axis() -> None:
    truth, picks = read_truth(), read_picks()
    for name, kind in zip(picks.names, picks.kinds, strict=True):
        if kind != "joint":
            assert abs(truth.planes[name].normal() @ truth.axis.vector()) < 1e-5
    assert np.allclose(truth.axis.vector(), truth.intersection.vector())


def test_slip_is_perpendicular_to_axis_and_offsets_beds_by_stated_amount() -> None:
    geology = maker("geology")
    slip = geology.FAULT_UP[0] * geology.ACROSS + geology.FAULT_UP[1] * geology.RISING
    assert abs(slip @ geology.AXIS) < 1e-12
    assert abs(slip @ geology.FAULT_NORMAL) < 1e-12
    # A point of the footwall, and where its neighbour across the fault has gone.
    foot = geology.place(*(np.array(x) for x in (19.2, 6.0, 0.0))) + 0.01 * geology.FAULT_NORMAL
    foot = foot - (geology.from_fault(foot) - 1e-6) * geology.FAULT_NORMAL
    hanging = foot - 2e-6 * geology.FAULT_NORMAL - geology.DISPLACEMENT * slip
    assert geology.from_fault(hanging) < 0
    assert geology.level(foot) == pytest.approx(geology.level(hanging), abs=1e-5)
    assert read_truth().displacement_m == geology.DISPLACEMENT


def test_picks_lie_on_the_surface_of_the_model() -> None:
    from scipy.spatial import cKDTree

    from vomstudio.io.models.opening import read_model

    mesh = read_model(sample_model())
    corners = mesh.data.vertices[mesh.data.faces]
    centres = corners.mean(axis=1)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.mean(normals @ maker("geology").OUT > 0) > 0.9  # faces look out of the rock
    normals /= np.linalg.norm(normals, axis=1, keepdims=True) + 1e-12
    points = read_picks().points
    _, near = cKDTree(centres).query(points, k=6)
    gaps = np.abs(np.einsum("ijk,ijk->ij", points[:, None] - centres[near], normals[near]))
    assert np.median(gaps.min(axis=1)) < 0.005
    assert np.quantile(gaps.min(axis=1), 0.95) < 0.02
    assert mesh.crs == "EPSG:32633"
    assert len(mesh.data.materials) >= 4
    assert not mesh.warnings
