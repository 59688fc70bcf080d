"""The parts of a bundle: its interpreter, its start, its image, and what is left out of it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from tests.bundle_maker import PACKAGING, bundling

ROOT = PACKAGING.parent

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="bundles are for Linux")


def run(*command: str | Path, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [str(word) for word in command],
        env={"PATH": os.environ["PATH"], "HOME": "/nonexistent", **environment},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture
def interpreter(tmp_path: Path) -> Path:
    """Interpreter in a folder of its own, which imports by the list of a bundle.

    The standard library and the packages are links, so that nothing is copied.
    """
    name = f"python{sys.version_info.major}.{sys.version_info.minor}"
    folder = tmp_path / "a bundle" / "python"
    library = folder / "lib" / name
    library.mkdir(parents=True)
    base = Path(sys.base_exec_prefix, "bin", name).resolve()
    shutil.copy2(base, folder / name)
    for path in Path(os.__file__).parent.iterdir():
        if path.name not in ("site-packages", "dist-packages"):
            (library / path.name).symlink_to(path)
    (library / "site-packages").mkdir()
    for folder_name in map(Path, (p for p in sys.path if p.endswith("site-packages"))):
        for path in folder_name.iterdir():
            if not path.name.startswith(("vomstudio", "__editable__")):
                (library / "site-packages" / path.name).symlink_to(path)
    (library / "site-packages" / "vomstudio").symlink_to(ROOT / "vomstudio")
    (folder / f"{name}._pth").write_text(bundling("interpreter").import_paths(name))
    return folder / name


def test_worker_of_bundle_ignores_other_python_installations(
    interpreter: Path, tmp_path: Path
) -> None:
    """A worker starts from the bundle alone, whatever variables another Python has set."""
    poison = tmp_path / "poison"
    poison.mkdir()
    (poison / "json.py").write_text("raise SystemExit('imported from PYTHONPATH')")
    script = """
        import sys, threading
        from vomstudio.studio.jobs.model_tasks import LOAD_MODEL, ModelFile
        from vomstudio.studio.jobs.supervisor import WorkerSupervisor
        from pathlib import Path
        end = threading.Event()
        events = []
        def listen(event):
            events.append(event)
            if type(event).__name__ in ("Done", "Failed"):
                end.set()
        worker = WorkerSupervisor()
        worker.submit(LOAD_MODEL, ModelFile(Path("gone.obj"), Path(sys.argv[1])), listen)
        end.wait(60)
        import psutil
        print(type(events[-1]).__name__, "gone.obj" in events[-1].message)
        print(psutil.Process(worker._process.pid).exe())
        print(sys.prefix)
        print(any("poison" in p or not p.startswith(sys.prefix) for p in sys.path))
        worker.close()
    """
    done = run(
        interpreter,
        "-c",
        textwrap.dedent(script),
        tmp_path,
        PYTHONPATH=str(poison),
        PYTHONHOME=str(poison),
    )
    assert done.stderr == ""
    kind, program, prefix, strangers = done.stdout.splitlines()
    assert kind == "Failed True"
    assert Path(program) == interpreter
    assert Path(prefix) == interpreter.parent
    assert strangers == "False"


# --- the launcher and the image -----------------------------------------------------------------


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """Bundle whose interpreter prints the launcher's name and its arguments."""
    folder = tmp_path / "VOM Studio, moved"
    (folder / "python").mkdir(parents=True)
    python = folder / "python" / "pythonX"
    python.write_text('#!/bin/sh\nprintf "%s\\n" "$VOMSTUDIO_LAUNCHER" "$0" "$@"\n')
    python.chmod(0o755)
    launcher = folder / "vomstudio"
    text = (PACKAGING / "bundling" / "launcher.sh").read_text()
    launcher.write_text(text.replace("@PYTHON@", "pythonX"))
    launcher.chmod(0o755)
    return folder


ARGUMENTS = ("open", "a model.obj", "", "*")


def test_the_launcher_finds_its_folder_through_a_link(tree: Path, tmp_path: Path) -> None:
    link = tmp_path / "bin" / "vomstudio"
    link.parent.mkdir()
    link.symlink_to(tree / "vomstudio")
    lines = run(link, *ARGUMENTS).stdout.split("\n")[:-1]
    program = str(tree / "python" / "pythonX")
    assert lines == [str(tree / "vomstudio"), program, "-P", "-m", "vomstudio", *ARGUMENTS]


@pytest.fixture
def image(tree: Path, tmp_path: Path) -> Path:
    """Image with a tar archive in the place of the file system."""
    header = bundling("image").header(
        name="vomstudio.run", version="1", python="pythonX", digest="d1"
    )
    archive = tmp_path / "bundle.tar"
    subprocess.run(["tar", "-C", tree, "-cf", archive, "."], check=True)
    path = tmp_path / "images of mine" / "vomstudio.run"
    path.parent.mkdir()
    path.write_bytes(header + archive.read_bytes())
    path.chmod(0o755)
    return path


@pytest.fixture
def commands(tmp_path: Path) -> Path:
    """PATH of a machine without squashfuse and unsquashfs."""
    folder = tmp_path / "commands"
    folder.mkdir()
    for name in ("sh", "readlink", "dirname", "id", "mkdir", "mktemp", "mv", "rm", "tail", "tar"):
        found = shutil.which(name)
        assert found
        (folder / name).symlink_to(found)
    return folder


def unsquashfs(commands: Path) -> None:
    """Install a command with the options of unsquashfs that unpacks a tar archive."""
    command = commands / "unsquashfs"
    command.write_text(
        "#!/bin/sh\n"
        '[ "$1 $2 $3 $5" = "-quiet -no-progress -offset -dest" ] || exit 2\n'
        'mkdir "$6" && tail -c +"$(($4 + 1))" "$7" | tar -C "$6" -xf -\n'
    )
    command.chmod(0o755)


def test_an_image_is_unpacked_once_and_starts(image: Path, commands: Path, tmp_path: Path) -> None:
    unsquashfs(commands)
    settings = {"PATH": str(commands), "XDG_CACHE_HOME": str(tmp_path / "cache")}
    folder = tmp_path / "cache" / "vomstudio" / "bundle-d1"
    expected = [str(image), f"{folder}/python/pythonX", "-P", "-m", "vomstudio", *ARGUMENTS]
    first = run(image, *ARGUMENTS, **settings)
    assert first.stdout.split("\n")[:-1] == expected
    assert os.listdir(folder.parent) == [folder.name]
    (commands / "unsquashfs").unlink()
    second = run(image, *ARGUMENTS, **settings)
    assert second.stdout == first.stdout
    assert second.stderr == ""


def test_image_that_cannot_be_unpacked_names_required_packages(
    image: Path, commands: Path, tmp_path: Path
) -> None:
    done = run(image, PATH=str(commands), XDG_CACHE_HOME=str(tmp_path / "cache"))
    assert done.returncode == 1
    assert done.stdout == ""
    assert "squashfs-tools" in done.stderr
    assert not (tmp_path / "cache").exists()


def test_a_failed_unpacking_leaves_nothing(image: Path, commands: Path, tmp_path: Path) -> None:
    unsquashfs(commands)
    image.write_bytes(image.read_bytes()[:-5000])
    with image.open("r+b") as file:
        file.seek(bundling("image").OFFSET)
        file.write(b"damaged" * 100)
    done = run(image, PATH=str(commands), XDG_CACHE_HOME=str(tmp_path / "cache"))
    assert done.returncode == 1
    assert "XDG_CACHE_HOME" in done.stderr
    assert os.listdir(tmp_path / "cache" / "vomstudio") == []


# --- what is left out ---------------------------------------------------------------------------


def install(folder: Path, name: str, *requirements: str) -> None:
    """Install a distribution of one module."""
    (folder / f"{name}.py").write_text("")
    facts = folder / f"{name}-1.dist-info"
    facts.mkdir()
    lines = [f"Requires-Dist: {text}" for text in requirements]
    (facts / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: {name}\nVersion: 1\n"
        + "".join(f"{line}\n" for line in lines)
    )
    (facts / "RECORD").write_text(f"{name}.py,,\n{facts.name}/METADATA,,\n{facts.name}/RECORD,,\n")


def modules(folder: Path) -> set[str]:
    return {path.stem for path in folder.glob("*.py")}


def test_unused_distributions_are_removed(tmp_path: Path) -> None:
    install(tmp_path, "direct", "indirect", "other; extra == 'more'", "never; python_version < '3'")
    install(tmp_path, "indirect", "direct")
    install(tmp_path, "other")
    install(tmp_path, "checker", "indirect")
    install(tmp_path, "open3d-cpu", "indirect", "ipywidgets")
    install(tmp_path, "ipywidgets", "comm")
    install(tmp_path, "comm")
    remove = bundling("pruning").remove_unused_distributions
    requirements = ["Direct[more]>=1", "open3d_cpu", "absent; sys_platform == 'win32'"]
    assert remove(tmp_path, requirements) == ["checker", "comm", "ipywidgets"]
    assert modules(tmp_path) == {"direct", "indirect", "other", "open3d-cpu"}
    assert len(list(tmp_path.glob("*.dist-info"))) == 4
    # Without its extra.
    assert remove(tmp_path, ["direct"]) == ["open3d-cpu", "other"]


def test_a_requirement_that_is_not_installed_stops_the_build(tmp_path: Path) -> None:
    install(tmp_path, "direct", "indirect")
    with pytest.raises(SystemExit, match="indirect"):
        bundling("pruning").remove_unused_distributions(tmp_path, ["direct"])


def test_pruning_rules_do_not_match_program_files() -> None:
    """Rules for packages match no file of the program but its types for checkers."""
    rules = bundling("pruning").SITE_PACKAGES
    for folder in ("vomstudio", "resources", "docs"):
        for rule in rules:
            matches = {path.name for p in rule.patterns for path in (ROOT / folder).glob(p)}
            assert matches <= {"__init__.pyi", "py.typed"}, rule.reason


def test_imported_modules_are_found_in_every_import_form(tmp_path: Path) -> None:
    (tmp_path / "one.py").write_text(
        "def late():\n"
        "    from vtkmodules.vtkCommonCore import vtkObject\n"
        "    import vtkmodules.vtkFiltersCore as core\n"
        "from vtkmodules import vtkRenderingCore, util\n"
        "import vtkmodules_of_others.vtkNot\n"
    )
    found = bundling("pruning")._imported(tmp_path, "vtkmodules")
    assert found == {"vtkCommonCore", "vtkFiltersCore", "vtkRenderingCore", "util"}


def test_debian_package_depends_on_runtime_packages_only() -> None:
    packages = set(bundling("debian").run_packages(PACKAGING / "system_packages.txt"))
    assert {"libgl1", "libxcb-cursor0"} <= packages
    assert not packages & {"xvfb", "xauth", "#"}


def test_debian_copyright_file_is_indented_correctly() -> None:
    text = bundling("licences").debian_copyright("First.\n\nSecond:\n  part 1: MIT\n")
    body = text.split("License: GPL-3\n")[1]
    assert all(line.startswith(" ") for line in body.splitlines())
    assert "\n .\n Second:\n   part 1: MIT\n" in body
