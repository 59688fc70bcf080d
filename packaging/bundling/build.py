"""Steps of a bundle, from the lock file to the files that are published."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator
from pathlib import Path

from bundling import debian, image, licences, pruning
from bundling.interpreter import Interpreter, copy_interpreter, copy_library

ROOT = Path(__file__).resolve().parents[2]
LOCK = ROOT / "packaging" / "requirements.lock"
_LAUNCHER = Path(__file__).with_name("launcher.sh")

# Small libraries that desktops lack more often than not, beside the libraries of Qt that use them.
# All have permissive licences, and all they need from the system is libX11 and libxcb. A system
# whose Qt 6.5 programs work has them too, and the bundle's own are used nevertheless.
QT_LIBRARIES = (
    "libxcb-cursor.so.0",
    "libxcb-icccm.so.4",
    "libxcb-image.so.0",
    "libxcb-keysyms.so.1",
    "libxcb-render-util.so.0",
    "libxcb-util.so.1",
    "libxcb-xkb.so.1",
    # A pair: the second reads private structures of the first.
    "libxkbcommon.so.0",
    "libxkbcommon-x11.so.0",
)
# The same for Open3D, which looks for them beside the standard library. libusb is under the LGPL,
# libidn2 and libunistring under it or the GPL.
OPEN3D_LIBRARIES = ("libusb-1.0.so.0", "libidn2.so.0", "libunistring.so.2")

_IMPORT_ALL = """
import importlib, pkgutil, vomstudio
for module in pkgutil.walk_packages(vomstudio.__path__, "vomstudio."):
    if not module.name.endswith("__main__"):
        importlib.import_module(module.name)
import cv2, geopandas, lxml.etree, matplotlib.backends.backend_agg, mplstereonet, numba, open3d
import pandas, pyceres, pycolmap, pyogrio, pyproj, pyvista.plotting, rasterio, scipy.optimize
import matplotlib.backends.backend_qtagg, pyvistaqt, qtawesome, shapely

"""

_DESKTOP_FILES = """
import json, sys
from vomstudio.core.files.desktop import desktop_files
files = desktop_files(json.loads(sys.argv[1]))
print(json.dumps({str(path): text for path, text in files.items()}))
"""


def build_bundle(python: Path, target: Path, work: Path) -> Iterator[Path]:
    """Build a bundle; yield its files as they are finished.

    Parameters
    ----------
    python
        Interpreter that is copied.
    target
        Folder of the files.
    work
        Empty folder for temporary files.
    """
    tree = work / "vomstudio"
    tree.mkdir()
    interpreter = build_tree(python, tree, work)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    version = _version()
    notice = licences.write_licences(
        ROOT, tree / "licences", interpreter.site_packages, interpreter.folder / "lib"
    )
    say("Checking that the bundle has all it needs")
    depends = debian.dependencies(tree, ROOT / "packaging" / "system_packages.txt")
    check(interpreter)
    size = sum(path.lstat().st_size for path in tree.rglob("*"))
    say(f"The bundle has {size / 1e6:.0f} MB; it depends on {', '.join(depends)}")

    say("Writing the Debian package")
    package = target / f"vomstudio_{version}_amd64.deb"
    author = project.get("authors", [{"name": "VOM Studio"}])[0]
    debian.write_package(
        tree,
        package,
        version=version,
        maintainer=f"{author['name']} <{author.get('email', 'unknown')}>",
        depends=depends,
        desktop_files=_desktop_files(interpreter),
        copyright_text=licences.debian_copyright(notice),
        work=work,
    )
    yield package
    say("Writing the image")
    file = target / f"vomstudio-{version}-x86_64.run"
    image.write_image(tree, file, version=version, python=interpreter.name, work=work)
    yield file


def build_tree(python: Path, tree: Path, work: Path) -> Interpreter:
    """Fill the folder of a bundle, without what the program does not need."""
    say("Copying the interpreter")
    interpreter = copy_interpreter(python, tree / "python")
    say("Installing the packages of the lock file")
    install_packages(python, interpreter.site_packages, work)
    say("Removing what the program does not need")
    prune(interpreter)
    for name in QT_LIBRARIES:
        copy_library(name, interpreter.site_packages / "PySide6" / "Qt" / "lib")
    for name in OPEN3D_LIBRARIES:
        copy_library(name, interpreter.folder / "lib")
    launcher = tree / "vomstudio"
    text = _LAUNCHER.read_text(encoding="utf-8")
    launcher.write_text(text.replace("@PYTHON@", interpreter.name), encoding="utf-8")
    launcher.chmod(0o755)
    # Bytecode that is valid whatever the times of the files are: an image may change them, and
    # nobody can write it anew in a folder that is read-only.
    subprocess.run(
        [
            str(interpreter.executable),
            "-m",
            "compileall",
            "-q",
            "-j",
            "1",
            "--invalidation-mode",
            "unchecked-hash",
            "-s",
            str(tree),
            str(interpreter.folder / "lib"),
        ],
        check=True,
    )
    return interpreter


def install_packages(python: Path, site_packages: Path, work: Path) -> None:
    """Install the packages of the lock file and the program itself into a folder."""
    environment = work / "environment"
    subprocess.run([str(python), "-m", "venv", str(environment)], check=True)
    pip = [str(environment / "bin" / "python"), "-m", "pip", "--disable-pip-version-check", "-q"]
    # setuptools first: what has no wheel, and the program, are built with the locked one.
    lines = LOCK.read_text(encoding="utf-8").replace("\\\n", " ").splitlines()
    builder = work / "setuptools.txt"
    builder.write_text(next(line for line in lines if line.startswith("setuptools==")))
    subprocess.run([*pip, "install", "--require-hashes", "-r", str(builder)], check=True)
    # The lock file is complete, and it may leave out what a package declares without need.
    into = [
        "install",
        "--no-deps",
        "--no-compile",
        "--no-build-isolation",
        "--target",
        str(site_packages),
    ]
    subprocess.run([*pip, *into, "--use-pep517", "--require-hashes", "-r", str(LOCK)], check=True)
    # A copy: building writes into the folder of the sources.
    sources = work / "sources"
    shutil.copytree(
        ROOT, sources, ignore=lambda folder, names: [n for n in names if _is_ignored(folder, n)]
    )
    subprocess.run([*pip, *into, str(sources)], check=True)
    shutil.rmtree(sources)
    shutil.rmtree(environment)


def _is_ignored(folder: str, name: str) -> bool:
    """Report whether a file of the checkout is not needed to build the program."""
    needed = (
        "vomstudio",
        "resources",
        "docs",
        "pyproject.toml",
        "setup.py",
        "MANIFEST.in",
        "README.md",
        "LICENSE",
        "CHANGELOG.md",
    )
    return name == "__pycache__" or (Path(folder) == ROOT and name not in needed)


def prune(interpreter: Interpreter) -> None:
    """Remove what the program does not need from the installed packages."""
    packages = interpreter.site_packages
    sources = packages / "vomstudio"
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    requirements = [*project["dependencies"], "vomstudio"]
    pruning.remove_unused_distributions(packages, requirements)
    pruning.remove_unused_vtk(interpreter.executable, packages, sources)
    pruning.remove(packages, pruning.SITE_PACKAGES)
    pruning.remove_unused_qt(packages, sources)


def check(interpreter: Interpreter) -> None:
    """Import all that the program can import, from the bundle alone."""
    with tempfile.TemporaryDirectory() as home:
        subprocess.run(
            [str(interpreter.executable), "-c", _IMPORT_ALL],
            env={"PATH": os.defpath, "HOME": home, "QT_QPA_PLATFORM": "offscreen"},
            check=True,
        )


def _version() -> str:
    facts: dict[str, str] = {}
    exec((ROOT / "vomstudio" / "core" / "version.py").read_text(encoding="utf-8"), facts)
    return facts["__version__"]


def _desktop_files(interpreter: Interpreter) -> dict[Path, str]:
    """Return the files for the menu of the desktop that `--install-desktop` writes."""
    command = [str(Path("/", "usr", "bin", debian.NAME))]
    output = subprocess.run(
        [str(interpreter.executable), "-c", _DESKTOP_FILES, json.dumps(command)],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    return {Path(path): text for path, text in json.loads(output).items()}


def say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
