"""The layers of the program, checked on what is really imported."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

UNDER_THE_WINDOW = (
    "core",
    "geometry",
    "geology",
    "io",
    "project",
    "registration",
    "photogrammetry",
    "extraction",
    "products",
    "studio",
    "cli",
    "api",
)
QT_AND_VTK = ("PySide6", "shiboken6", "qtpy", "qtawesome", "vtk", "vtkmodules", "pyvista")
SLOW_TO_IMPORT = ("scipy", "pandas", "matplotlib", "mplstereonet", "numba", "laspy", "pyproj")
SLOW_TO_IMPORT += ("shapely", "geopandas", "pyogrio", "PIL", "rasterio", "embreex", "lxml")
SLOW_TO_IMPORT += ("tomlkit",)


def loaded_after(statements: str) -> set[str]:
    """Top-level names in sys.modules of a fresh interpreter after `statements`."""
    report = "\nimport sys\nprint('LOADED', *sorted({m.split('.')[0] for m in sys.modules}))"
    done = subprocess.run(
        [sys.executable, "-c", statements + report],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    return set(done.stdout.splitlines()[-1].split()[1:])


def modules_of(name: str) -> list[str]:
    """Dotted names of one package or module of vomstudio and of everything inside it."""
    folder = ROOT / "vomstudio" / name
    files = sorted(folder.rglob("*.py")) if folder.is_dir() else [folder.with_suffix(".py")]
    assert files, f"vomstudio/{name} is gone: bring this list up to date"
    dotted = (".".join(file.relative_to(ROOT).with_suffix("").parts) for file in files)
    return [module.removesuffix(".__init__") for module in dotted]


def test_import_contracts_hold() -> None:
    done = subprocess.run(
        [sys.executable, "-c", "from importlinter.cli import lint_imports_command as c; c()"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_modules_below_ui_import_without_qt_or_vtk() -> None:
    modules = [module for name in UNDER_THE_WINDOW for module in modules_of(name)]
    loaded = loaded_after("\n".join(f"import {module}" for module in modules))
    assert not loaded & set(QT_AND_VTK)


@pytest.mark.parametrize("module", ["vomstudio.app", "vomstudio.cli"])
def test_starting_loads_nothing_slow(module: str) -> None:
    loaded = loaded_after(f"import {module}")
    assert not loaded & set(QT_AND_VTK + SLOW_TO_IMPORT)


def test_laspy_import_does_not_load_requests() -> None:
    statements = "from vomstudio.io.models.las_library import import_laspy as f; assert f() is f()"
    assert "requests" not in loaded_after(statements)
    assert "requests" in loaded_after(f"{statements}; import requests")


def test_window_imports_no_numerical_libraries() -> None:
    """But for the net, which draws with matplotlib and comes after the first frame."""
    modules = [m for m in modules_of("ui") if not m.endswith((".stereonet_panel", ".net.canvas"))]
    loaded = loaded_after("\n".join(f"import {module}" for module in modules))
    assert "PySide6" in loaded
    assert not loaded & {"numba", "scipy", "matplotlib", "cv2", "open3d", "pycolmap", "pyproj"}


@pytest.mark.full
def test_benchmarks_can_be_imported() -> None:
    """No test runs them, so that nothing else notices when what they stand on moves."""
    files = sorted((ROOT / "tests" / "benchmarks").glob("bench_*.py"))
    assert files
    loaded_after("\n".join(f"import tests.benchmarks.{file.stem}" for file in files))
