"""What a bundle leaves out: every rule with its reason."""

from __future__ import annotations

import ast
import json
import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from importlib.metadata import distributions
from pathlib import Path

from bundling import elf


@dataclass(frozen=True)
class Rule:
    """Files and folders that are left out.

    Attributes
    ----------
    patterns
        Glob patterns below the folder that the rule is applied to.
    reason
        Why the program does not need them.
    """

    patterns: tuple[str, ...]
    reason: str


def standard_library(name: str) -> list[Rule]:
    """Return the rules for the standard library of an interpreter named so."""
    library = f"lib/{name}"
    dynamic = f"{library}/lib-dynload"
    return [
        Rule((f"{library}/test", f"{library}/*/test", f"{library}/*/tests"), "tests of Python"),
        Rule(
            (f"{dynamic}/_test*", f"{dynamic}/_ctypes_test*", f"{dynamic}/_xx*", f"{dynamic}/xx*"),
            "tests of Python",
        ),
        Rule((f"{library}/config-*",), "static library and makefiles, for embedding Python"),
        Rule(
            (
                f"{library}/tkinter",
                f"{library}/idlelib",
                f"{library}/turtle*",
                f"{dynamic}/_tkinter*",
            ),
            "another window toolkit, and its editor",
        ),
        Rule(
            (
                f"{library}/ensurepip",
                f"{library}/venv",
                f"{library}/lib2to3",
                f"{library}/pydoc_data",
            ),
            "a bundle is not a place for development",
        ),
        Rule((f"{library}/sitecustomize.py",), "settings of the machine that builds"),
        Rule(
            (f"{dynamic}/readline*", f"{dynamic}/_curses*"),
            "no Python prompt; readline would bring its GPL",
        ),
        Rule(
            (
                f"{dynamic}/nis*",
                f"{dynamic}/_dbm*",
                f"{dynamic}/_gdbm*",
                f"{dynamic}/_crypt*",
                f"{dynamic}/ossaudiodev*",
                f"{dynamic}/spwd*",
            ),
            "network accounts, old databases and old sound; they need rare libraries",
        ),
    ]


# Dependencies that a package declares and the program's use of it does not need.
UNUSED_DEPENDENCIES = {
    # Its viewer in notebooks. (Open3D imports plotly and dash whenever it is imported.)
    "open3d": ("ipywidgets", "nbformat", "configargparse"),
    "open3d-cpu": ("ipywidgets", "nbformat", "configargparse"),
}

SITE_PACKAGES = [
    Rule(("bin", "share", "etc"), "commands and notebook extensions of packages"),
    Rule(("**/tests",), "tests of packages"),
    Rule(("**/*.pyi", "**/py.typed"), "types, for checkers"),
    Rule(
        ("**/*.a", "**/*.h", "**/*.hpp", "**/*.cuh", "**/*.pxd", "**/*.pyx", "**/*.cmake"),
        "for compiling against packages",
    ),
    Rule(("matplotlib/mpl-data/sample_data",), "data for examples"),
    Rule(
        (
            "open3d/resources",
            "open3d/examples",
            "open3d/agent_skills",
            "open3d/app.py",
            "open3d/*extension",
        ),
        "models and lights of Open3D's own viewer",
    ),
    Rule(("open3d/open3d_t*_ops.so", "open3d/_ml3d"), "operations for TensorFlow and PyTorch"),
    Rule(
        (
            "plotly/package_data/plotly.min.js",
            "plotly/labextension",
            "dash/**/*.js",
            "dash/**/*.js.map",
        ),
        "scripts of web pages, which nothing here opens",
    ),
    Rule(
        ("pyvista/examples", "pyvista/trame", "pyvista/ext", "pyvista/demos"),
        "example data and views in notebooks",
    ),
    Rule(
        (
            "PySide6/Qt/qml",
            "PySide6/Qt/metatypes",
            "PySide6/Qt/libexec",
            "PySide6/Qt/resources",
            "PySide6/doc",
            "PySide6/glue",
            "PySide6/include",
            "PySide6/typesystems",
            "PySide6/scripts",
        ),
        "Qt Quick, and tools that generate code",
    ),
    Rule(
        (
            "PySide6/assistant*",
            "PySide6/balsam*",
            "PySide6/designer*",
            "PySide6/linguist*",
            "PySide6/lrelease*",
            "PySide6/lupdate*",
            "PySide6/qml*",
            "PySide6/qsb*",
            "PySide6/svgtoqml*",
        ),
        "Qt's programs for development",
    ),
    Rule(
        (
            "PySide6/Qt/plugins/designer",
            "PySide6/Qt/plugins/qmllint",
            "PySide6/Qt/plugins/qmltooling",
            "PySide6/Qt/plugins/vectorimageformats",
            "PySide6/Qt/plugins/imageformats/libqpdf.so",
            "PySide6/Qt/plugins/platforminputcontexts/libqtvirtualkeyboardplugin.so",
        ),
        "plugins of modules that are left out",
    ),
    Rule(
        (
            "PySide6/Qt/plugins/sqldrivers",
            "PySide6/Qt/plugins/tls",
            "PySide6/Qt/plugins/networkinformation",
        ),
        "databases and network: not used through Qt",
    ),
    Rule(
        (
            "PySide6/Qt/plugins/egldeviceintegrations",
            "PySide6/Qt/plugins/generic",
            "PySide6/Qt/plugins/wayland-graphics-integration-server",
            *(
                f"PySide6/Qt/plugins/platforms/libq{name}.so"
                for name in ("eglfs", "linuxfb", "minimalegl", "vkkhrdisplay", "vnc")
            ),
        ),
        "screens without a desktop; Wayland's server",
    ),
    Rule(
        (
            "PySide6/Qt/translations/[!q]*",
            "PySide6/Qt/translations/qt_*",
            "PySide6/Qt/translations/qt[!b]*",
        ),
        "translations of Qt's other modules",
    ),
    Rule(
        (
            "vtkmodules/test",
            "vtkmodules/tk",
            "vtkmodules/gtk",
            "vtkmodules/wx",
            "vtkmodules/web",
            "vtkmodules/generate_pyi.py",
            "vtk.py",
            "vtkmodules/all.py",
        ),
        "other window toolkits, and the module that imports every other",
    ),
]

# Modules of Qt that PyVista's window and matplotlib's import beside the program's own.
QT_MODULES = ("QtCore", "QtGui", "QtWidgets", "QtOpenGL", "QtOpenGLWidgets", "QtSvg")

# Modules of VTK that PyVista can import and the program never makes it import.
UNUSED_VTK = {
    "vtkIO*": "readers and writers: models are read and written by the program",
    "vtkChartsCore": "charts: drawn by matplotlib",
    "vtkViewsContext2D": "charts: drawn by matplotlib",
    "vtkDomainsChemistry": "molecules",
    "vtkFiltersFlowPaths": "streamlines",
    "vtkFiltersParallelDIY2": "filters over several machines",
    "vtkFiltersVerdict": "quality of volume cells",
    "vtkFiltersTexture": "texture coordinates: computed by the program",
}
# Of those, what saves pictures.
USED_VTK = ("vtkIOImage", "vtkIOCore")


def remove(folder: Path, rules: Iterable[Rule]) -> None:
    """Remove what the rules name below a folder."""
    for rule in rules:
        for pattern in rule.patterns:
            for path in sorted(folder.glob(pattern)):
                _remove(path)


def remove_unused_distributions(site_packages: Path, requirements: Iterable[str]) -> list[str]:
    """Remove installed distributions that no requirement leads to.

    Parameters
    ----------
    site_packages
        Folder of installed packages. It must contain the package ``packaging``.
    requirements
        Requirements of the program, as in ``[project.dependencies]``.

    Returns
    -------
    list of str
        Names of the removed distributions.
    """
    sys.path.append(str(site_packages))
    from packaging.requirements import Requirement
    from packaging.utils import canonicalize_name

    installed = {canonicalize_name(d.name): d for d in distributions(path=[str(site_packages)])}
    used: set[tuple[str, str]] = set()
    pending = [Requirement(text) for text in requirements]
    while pending:
        requirement = pending.pop()
        name = canonicalize_name(requirement.name)
        if requirement.marker and not requirement.marker.evaluate({"extra": ""}):
            continue
        if name not in installed:
            raise SystemExit(f"Cannot bundle {name}: the lock lacks it. Run packaging/lock.")
        for extra in ("", *requirement.extras):
            if (name, extra) in used:
                continue
            used.add((name, extra))
            for text in installed[name].requires or ():
                other = Requirement(text)
                if canonicalize_name(other.name) in UNUSED_DEPENDENCIES.get(name, ()):
                    continue
                if other.marker is None or other.marker.evaluate({"extra": extra}):
                    # Its marker may name the extra that was followed.
                    other.marker = None
                    pending.append(other)
    names = {name for name, _extra in used}
    unused = sorted(set(installed) - names)
    for name in unused:
        for file in installed[name].files or ():
            path = site_packages / file
            if site_packages in path.resolve().parents:
                path.unlink(missing_ok=True)
    _remove_empty_folders(site_packages)
    return unused


def remove_unused_qt(site_packages: Path, sources: Path) -> None:
    """Remove modules of Qt that neither the program nor a plugin that stays needs.

    Parameters
    ----------
    site_packages
        Folder of installed packages.
    sources
        Folder of the program's modules.
    """
    root = site_packages / "PySide6"
    names = {*QT_MODULES, *_imported(sources, "PySide6")}
    modules = {path for path in root.glob("*.abi3.so") if path.name.split(".")[0] in names}
    plugins = elf.elf_files(root / "Qt" / "plugins")
    # Modules need libraries of both folders.
    libraries = elf.closure([*modules, *plugins], root / "Qt" / "lib")
    own = elf.closure(modules, root)
    for path in [*root.glob("*.so*"), *(root / "Qt" / "lib").iterdir()]:
        if path not in own | libraries:
            _remove(path)


def remove_unused_vtk(interpreter: Path, site_packages: Path, sources: Path) -> None:
    """Remove modules of VTK that the program does not reach.

    The program's own imports stay, and what PyVista can import except `UNUSED_VTK`, with
    everything these need.

    Parameters
    ----------
    interpreter
        Python that imports from `site_packages`: a module of VTK imports others from compiled
        code, so they are imported to be known.
    site_packages, sources
        As for `remove_unused_qt`.
    """
    names = json.dumps(
        {
            "own": sorted(_imported(sources, "vtkmodules")),
            "unused": sorted(UNUSED_VTK),
            "used": USED_VTK,
        }
    )
    output = subprocess.run(
        [str(interpreter), "-c", _VTK_IMPORTS, names], capture_output=True, text=True, check=True
    ).stdout
    root = site_packages / "vtkmodules"
    kept = elf.closure((root / line for line in output.split()), root)
    for path in root.glob("*.so*"):
        if path not in kept:
            path.unlink()


_VTK_IMPORTS = """
import importlib, json, sys
from fnmatch import fnmatch
from pathlib import Path
import pyvista._vtk
# Imports drawing modules for their side effects.
import pyvista.plotting, pyvistaqt
lists = json.loads(sys.argv[1])
names = {name for key, table in vars(pyvista._vtk).items() if key.endswith("_MODULES")
         and isinstance(table, dict) for name in table}
unused = {name for name in names if any(fnmatch(name, pattern) for pattern in lists["unused"])}
for name in sorted(names - unused | {*lists["used"], *lists["own"]}):
    importlib.import_module(f"vtkmodules.{name}")
for name, module in sys.modules.items():
    file = getattr(module, "__file__", None) or ""
    if name.startswith("vtkmodules.") and file.endswith(".so"):
        print(Path(file).name)
"""


def _imported(sources: Path, package: str) -> set[str]:
    """Collect the modules of a package that sources import, below its name."""
    names: set[str] = set()
    for path in sources.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names.update(_imported_by(node, package))
    return names


def _imported_by(node: ast.AST, package: str) -> Iterator[str]:
    if isinstance(node, ast.ImportFrom) and node.module == package:
        yield from (alias.name for alias in node.names)
    elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith(f"{package}."):
        yield (node.module or "").split(".", 1)[1]
    elif isinstance(node, ast.Import):
        for alias in node.names:
            if alias.name.startswith(f"{package}."):
                yield alias.name.split(".", 1)[1]


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def _remove_empty_folders(folder: Path) -> None:
    for path in sorted(folder.rglob("*"), reverse=True):
        if path.is_dir() and not path.is_symlink() and not any(path.iterdir()):
            path.rmdir()
