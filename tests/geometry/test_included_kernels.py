"""The program contains compiled kernels, which are used until this processor has its own."""

from __future__ import annotations

import ast
import platform
import subprocess
import sys
from pathlib import Path

import pytest

from tests.geometry.test_machine_code import MODULE
from tests.tiers import first_in_default_tier
from vomstudio.geometry.kernels import machine_code
from vomstudio.geometry.kernels.declared_kernels import declared_kernels
from vomstudio.geometry.kernels.jit import Kernel
from vomstudio.geometry.kernels.signatures import Signature

ROOT = Path(__file__).resolve().parents[2]

pytestmark = pytest.mark.skipif(
    sys.platform != "linux" or platform.machine() not in machine_code.BASELINES,
    reason="kernels are compiled on this system when they are used",
)

MAKE = """
import sys
from pathlib import Path
import kernel_file
from vomstudio.geometry.kernels import machine_code

name, content = machine_code.baseline_code(kernel_file.work.source)
folder = Path("resources", "kernels", machine_code.INCLUDED_FOLDER)
folder.mkdir(parents=True)
(folder / name).write_bytes(content)
"""
# The second kernel folder is of another program, which the resources belong to.
USE = """
import sys
from pathlib import Path
from vomstudio.core import paths
from vomstudio.geometry.kernels import machine_code

paths._RESOURCE_FOLDERS = (Path("resources"),)
machine_code.BASELINES = {name: machine_code.Baseline(cpu, features + FEATURES)
                          for name, (cpu, features) in machine_code.BASELINES.items()}
import kernel_file

print(kernel_file.work(1.5), "numba" in sys.modules)
kernel_file.work.compile_for_this_processor()
"""


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a module of one kernel, and resources that contain its code."""
    folder = tmp_path_factory.mktemp("program")
    (folder / "kernel_file.py").write_text(MODULE)
    baseline = machine_code.BASELINES[platform.machine()]
    variables = {"NUMBA_CPU_NAME": baseline.cpu, "NUMBA_CPU_FEATURES": ""}
    run(folder, MAKE, folder / "made", **variables)
    assert not (folder / "made").exists()
    return folder


def run(folder: Path, code: str, cache: Path, **variables: str) -> str:
    """What a new process with a cache folder of its own prints."""
    import os

    environment = os.environ | {"NUMBA_CACHE_DIR": str(cache)} | variables
    environment["PYTHONPATH"] = os.pathsep.join([str(folder), str(ROOT)])
    words = [sys.executable, "-B", "-c", code]
    done = subprocess.run(
        words, cwd=folder, env=environment, capture_output=True, text=True, check=True, timeout=120
    )
    return done.stdout.strip()


def test_first_call_uses_included_code_and_compiles_native_code_later(
    program: Path, tmp_path: Path
) -> None:
    use = USE.replace("FEATURES", "()")
    assert run(program, use, tmp_path) == "4.0 False"
    assert len(list(tmp_path.glob("*.code"))) == 1
    (included,) = (program / "resources").rglob("*.code")
    included_bytes = included.read_bytes()
    included.write_bytes(b"damaged")
    assert run(program, use, tmp_path) == "4.0 False"
    included.write_bytes(included_bytes)


@pytest.mark.parametrize(
    ("features", "text", "result"),
    first_in_default_tier(
        [
            ("('another feature',)", MODULE, "4.0 True"),
            ("()", MODULE.replace("FACTOR = 2.0", "FACTOR = 4.0"), "7.0 True"),
        ],
        1,
    ),
)
def test_code_of_another_processor_or_another_kernel_is_never_used(
    program: Path, tmp_path: Path, features: str, text: str, result: str
) -> None:
    (tmp_path / "kernel_file.py").write_text(text)
    (tmp_path / "resources").symlink_to(program / "resources")
    cache = tmp_path / "cache"
    assert run(tmp_path, USE.replace("FEATURES", features), cache) == result


def test_every_module_with_kernels_is_found() -> None:
    declared = {one.source.function.__module__ for one in declared_kernels()}
    assert declared == {
        ".".join(path.relative_to(ROOT).with_suffix("").parts)
        for path in (ROOT / "vomstudio").rglob("*.py")
        if "@kernel(" in path.read_text("utf-8") and _declares_kernels(path)
    }


def _declares_kernels(path: Path) -> bool:
    functions = (
        n for n in ast.walk(ast.parse(path.read_text("utf-8"))) if isinstance(n, ast.FunctionDef)
    )
    calls = (d.func for one in functions for d in one.decorator_list if isinstance(d, ast.Call))
    return any(isinstance(name, ast.Name) and name.id == "kernel" for name in calls)


def test_machine_code_supports_the_signatures_of_all_kernels() -> None:
    for one in declared_kernels():
        Signature(one.source.signature)


@pytest.mark.full
@pytest.mark.parametrize(
    "module", sorted({m.source.function.__module__ for m in declared_kernels()})
)
def test_no_kernel_needs_numba_when_it_runs(module: str) -> None:
    """One that allocates memory does, and could not be a part of the program."""
    kernels: list[Kernel] = [
        k for k in declared_kernels() if k.source.function.__module__ == module
    ]
    assert [
        k.__name__ for k in kernels if not machine_code.compile_for_this_processor(k.source)
    ] == []
