"""The start scripts: what counts as installed, what continues, how failures are reported."""

from __future__ import annotations

import hashlib
import importlib.util
import os
import shutil
import signal
import subprocess
import sys
import zipfile
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.small_disk import small_disk

ROOT = Path(__file__).resolve().parents[2]

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the start scripts need bash")


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A project with the real scripts and what looks like a finished installation."""
    folder = tmp_path / "a folder with spaces"
    (folder / ".venv" / "bin").mkdir(parents=True)
    shutil.copytree(ROOT / "packaging", folder / "packaging")
    shutil.copy(ROOT / "pyproject.toml", folder)
    # Not a link: through one, Python would look for its packages beside the link.
    python = folder / ".venv" / "bin" / "python"
    python.write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n')
    python.chmod(0o755)
    for use in ("run", "test"):
        assert bash(folder, f'wanted_stamp {use} >"$stamp-{use}"').returncode == 0
    return folder


def bash(project: Path, commands: str) -> subprocess.CompletedProcess[str]:
    """Run bash commands with packaging/_setup.sh sourced, from another folder."""
    script = f'set -euo pipefail; source "$1"; {commands}'
    return subprocess.run(
        ["bash", "-c", script, "test", project / "packaging" / "_setup.sh"],
        cwd="/",
        capture_output=True,
        text=True,
    )


def is_installed(project: Path, use: str = "run") -> bool:
    return bash(project, f"is_installed {use}").returncode == 0


def test_a_finished_installation_is_recognised(project: Path) -> None:
    assert is_installed(project)


def test_an_interrupted_installation_is_not_taken_for_finished(project: Path) -> None:
    (project / ".venv" / "installation-unfinished").touch()
    assert not is_installed(project)
    assert bash(project, "environment_is_usable").returncode == 0
    (project / ".venv" / "creation-unfinished").touch()
    assert bash(project, "environment_is_usable").returncode != 0


@pytest.mark.parametrize("lock", ["requirements.lock", "requirements_test.lock"])
def test_test_packages_are_installed_only_for_tests(project: Path, lock: str) -> None:
    with (project / "packaging" / lock).open("a") as lines:
        lines.write("something==1.0\n")
    assert is_installed(project, "run") == (lock == "requirements_test.lock")
    assert not is_installed(project, "test")


def test_changed_lock_file_requires_reinstallation_into_same_environment(
    project: Path,
) -> None:
    with (project / "packaging" / "requirements.lock").open("a") as lock:
        lock.write("something==1.0\n")
    assert not is_installed(project)
    assert bash(project, "environment_is_usable").returncode == 0


def test_moved_project_recreates_its_environment(project: Path) -> None:
    moved = project.rename(project.with_name("moved"))
    assert not is_installed(moved)
    assert bash(moved, "environment_is_usable").returncode != 0


def test_environment_without_python_is_recreated(project: Path) -> None:
    (project / ".venv" / "bin" / "python").unlink()
    assert not is_installed(project)
    assert bash(project, "environment_is_usable").returncode != 0


# --- interrupted, offline, full: one sentence, and running again continues ------------------------


def wheel(folder: Path, name: str, size: int = 100) -> str:
    """Write a wheel of one module and return its entry of a lock file."""
    path = folder / f"{name}-1.0-py3-none-any.whl"
    info = f"{name}-1.0.dist-info"
    files = {
        f"{name}.py": b"#" * size,
        f"{info}/METADATA": f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n".encode(),
        f"{info}/WHEEL": b"Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
    }
    record = "".join(f"{file},,{len(content)}\n" for file, content in files.items())
    files[f"{info}/RECORD"] = f"{record}{info}/RECORD,,\n".encode()
    with zipfile.ZipFile(path, "w") as archive:
        for file, content in files.items():
            archive.writestr(file, content)
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    return f"{name}==1.0 \\\n    --hash=sha256:{digest}\n"


@dataclass
class Environment:
    """A virtual environment with nothing but pip, a folder of wheels, and a lock file."""

    folder: Path
    wheels: Path

    @property
    def site_packages(self) -> Path:
        return next((self.folder / ".venv" / "lib").glob("python*")) / "site-packages"

    def lock(self, *entries: str) -> Path:
        path = self.wheels / "requirements.lock"
        path.write_text("".join(entries))
        return path

    def install(
        self, lock: Path, stderr: int = subprocess.PIPE, **variables: str
    ) -> subprocess.CompletedProcess[str]:
        """Run packaging/_install.py with these wheels as the only source of packages."""
        environment = {k: v for k, v in os.environ.items() if not k.startswith(("PIP_", "PYTHON"))}
        environment |= {"PIP_CONFIG_FILE": os.devnull, "PIP_NO_CACHE_DIR": "1"}
        environment |= {"PIP_NO_INDEX": "1", "PIP_FIND_LINKS": str(self.wheels)} | variables
        venv, script = self.folder / ".venv", ROOT / "packaging" / "_install.py"
        return subprocess.run(
            [venv / "bin" / "python", script, "packages", venv / "installation.log", lock],
            env={k: v for k, v in environment.items() if v},
            stdout=subprocess.PIPE,
            stderr=stderr,
            text=True,
        )


def make_environment(folder: Path, wheels: Path) -> Environment:
    pip = importlib.util.find_spec("pip")
    if pip is None or pip.origin is None:
        pytest.skip("this environment has no pip")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder / ".venv"], check=True)
    environment = Environment(folder, wheels)
    # pip of this environment, and nothing else of it: creating one with pip takes seconds.
    alone = wheels / "pip alone"
    alone.mkdir(parents=True)
    (alone / "pip").symlink_to(Path(pip.origin).parent, target_is_directory=True)
    (environment.site_packages / "pip_alone.pth").write_text(f"{alone}\n")
    return environment


@pytest.fixture
def environment(tmp_path: Path) -> Environment:
    return make_environment(tmp_path / "project", tmp_path / "wheels")


def test_an_interrupted_installation_continues(environment: Environment) -> None:
    entries = [wheel(environment.wheels, name) for name in ("complete", "cut", "unfinished")]
    first = environment.install(environment.lock(*entries))
    assert first.returncode == 0, first.stderr
    # Where no terminal is, not a line for each package.
    assert first.stderr.splitlines()[0] == "Installing package 1 of 3: complete"
    assert len(first.stderr.splitlines()) < 3
    modules = {name: environment.site_packages / f"{name}.py" for name in ("complete", "cut")}
    inode = modules["complete"].stat().st_ino
    modules["cut"].write_bytes(b"#" * 50)
    (environment.site_packages / "unfinished-1.0.dist-info" / "RECORD").unlink()
    (environment.site_packages / "~emains-1.0.dist-info").mkdir()
    lock = environment.lock(*entries, wheel(environment.wheels, "absent"))

    second = environment.install(lock)
    assert second.returncode == 0, second.stderr
    assert modules["complete"].stat().st_ino == inode
    assert modules["cut"].stat().st_size == 100
    assert (environment.site_packages / "unfinished-1.0.dist-info" / "RECORD").is_file()
    assert (environment.site_packages / "absent.py").is_file()
    assert not list(environment.site_packages.glob("~*"))
    assert "package 2 of 4: cut" in second.stderr
    # Everything is there: not even pip is started.
    assert environment.install(lock, PIP_NO_INDEX="no boolean").returncode == 0


@pytest.mark.full
def test_a_package_that_is_no_longer_locked_is_removed(environment: Environment) -> None:
    """As open3d, whose module open3d-cpu replaces."""
    old, new = wheel(environment.wheels, "old"), wheel(environment.wheels, "new")
    other = wheel(environment.wheels, "of_the_user")
    for entries in ((other,), (old,)):
        assert environment.install(environment.lock(*entries)).returncode == 0
    (environment.folder / ".venv" / "installed-from-run").write_text(f"folder x\n{old}")
    assert environment.install(environment.lock(new)).returncode == 0
    modules = {path.name for path in environment.site_packages.glob("*.py")}
    assert modules == {"new.py", "of_the_user.py"}


def test_entries_for_other_systems_are_left_out(environment: Environment) -> None:
    entry = wheel(environment.wheels, "elsewhere").replace(" \\", " ; sys_platform == 'os2' \\", 1)
    assert environment.install(environment.lock(entry)).returncode == 0
    assert not (environment.site_packages / "elsewhere.py").exists()


def sentence_of(done: subprocess.CompletedProcess[str]) -> str:
    """Return the reported failure, which is one line of at most 40 words and no traceback."""
    assert done.returncode == 1
    lines = [line for line in done.stderr.splitlines() if not line.startswith("Installing package")]
    sentence, *log = lines
    assert len(sentence.split()) <= 40
    assert all("installation.log" in line for line in log)
    return sentence


@pytest.mark.full
def test_missing_network_is_reported(environment: Environment) -> None:
    lock = environment.lock(wheel(environment.wheels, "needed"))
    done = environment.install(
        lock,
        PIP_NO_INDEX="",
        PIP_FIND_LINKS="",
        PIP_INDEX_URL="http://127.0.0.1:9/simple",
        PIP_RETRIES="1",
    )
    sentence = sentence_of(done)
    assert "needed" in sentence
    assert "network" in sentence
    assert "Traceback" not in done.stderr
    assert environment.install(lock).returncode == 0


def test_wrong_checksum_is_reported(environment: Environment) -> None:
    lock = environment.lock(wheel(environment.wheels, "changed"))
    wheel(environment.wheels, "changed", 101)
    assert "checksum" in sentence_of(environment.install(lock))


def test_missing_wheel_error_names_python_version(environment: Environment) -> None:
    lock = environment.lock(f"missing==1.0 \\\n    --hash=sha256:{'0' * 64}\n")
    sentence = sentence_of(environment.install(lock))
    assert "missing" in sentence
    assert f"Python {sys.version_info[0]}.{sys.version_info[1]}" in sentence


@pytest.mark.full
def test_full_disk_is_reported_and_installation_resumes(tmp_path: Path) -> None:
    with small_disk(tmp_path / "disk") as disk:
        environment = make_environment(disk, tmp_path / "wheels")
        small = wheel(environment.wheels, "alone")
        lock = environment.lock(small, wheel(environment.wheels, "large", 4 << 20))
        filler = disk / "filler"
        filler.write_bytes(b"\0" * (6 << 20))
        sentence = sentence_of(environment.install(lock))
        assert "disk is full" in sentence
        assert "MB left" in sentence
        filler.unlink()
        assert environment.install(lock).returncode == 0


def test_insufficient_disk_space_is_reported_before_download(project: Path) -> None:
    done = bash(project, "need_python() { echo python3; }; needed_mb=999999999; create_environment")
    assert done.returncode == 1
    assert "999999999 MB are needed" in done.stderr


def test_ctrl_c_message_explains_that_installation_resumes(project: Path) -> None:
    """The terminal sends the signal to the script and to what it has started."""
    installer = project / "packaging" / "_install.py"
    installer.write_text("import time; print('started', flush=True); time.sleep(60)")
    script = project / "packaging" / "_setup.sh"
    process = subprocess.Popen(
        ["bash", "-c", 'set -euo pipefail; source "$1"; install_environment run', "x", script],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        # A shell in the background ignores it, and so does everything that it starts.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    assert process.stdout is not None
    process.stdout.readline()
    os.killpg(process.pid, signal.SIGINT)
    _, stderr = process.communicate(timeout=60)
    assert process.returncode == 1
    assert "continues" in stderr.splitlines()[-1]
    assert not is_installed(project)
    assert bash(project, "environment_is_usable").returncode == 0


# --- Python and apt -------------------------------------------------------------------------------


def fake_python(project: Path, version: str, modules: str = "") -> Path:
    """Write an interpreter that says it is of another version and lacks some modules."""
    path = project / "fake python"
    path.write_text(
        f"""#!{sys.executable}
import collections, sys
Version = collections.namedtuple("Version", "major minor micro")
sys.version_info = Version({version.replace(".", ", ")}, 0)
for name in {modules.split()!r}:
    sys.modules[name] = None
exec(sys.argv[2])
"""
    )
    path.chmod(0o755)
    return path


@pytest.mark.parametrize(
    ("version", "modules", "named"),
    [
        ("3.10", "", "Python 3.10"),
        ("3.15", "", "Python 3.15"),
        ("3.12", "venv", "python3.12-venv"),
        ("3.12", "ensurepip", "python3.12-venv"),
    ],
)
def test_unsuitable_python_is_reported(
    project: Path, version: str, modules: str, named: str
) -> None:
    fake = fake_python(project, version, modules)
    done = bash(project, f'VOMSTUDIO_PYTHON="{fake}"; base="$(need_python)"; echo unreached')
    assert done.returncode == 1
    assert done.stdout == ""
    (sentence,) = done.stderr.splitlines()
    assert named in sentence
    assert "3.11 to 3.14" in sentence
    assert "VOMSTUDIO_PYTHON=" in sentence


def test_suitable_python_is_used(project: Path) -> None:
    fake = fake_python(project, "3.13")
    done = bash(project, f'VOMSTUDIO_PYTHON="{fake}"; need_python')
    assert done.stdout == f"{fake}\n"


def test_missing_python_is_reported_in_one_sentence(project: Path) -> None:
    done = bash(project, "VOMSTUDIO_PYTHON=/nowhere/python; need_python")
    assert done.returncode == 1
    (sentence,) = done.stderr.splitlines()
    assert "/nowhere/python was not found" in sentence


def test_without_root_rights_system_packages_are_listed_in_one_sentence(project: Path) -> None:
    with (project / "packaging" / "system_packages.txt").open("a") as lines:
        lines.write("nosuchlib0 libnosuchlib.so.0 run no reason\n")
        lines.write("nosuchtool nosuchtool test no reason\n")
    for use, names in (("run", ["nosuchlib0"]), ("test", ["nosuchlib0", "nosuchtool"])):
        done = bash(project, f"can_use_apt() {{ return 1; }}; install_system_packages {use}")
        assert done.returncode == 0
        if sys.platform == "linux":
            (sentence,) = done.stderr.splitlines()
            assert sentence.split("apt-get install ")[1].split()[-len(names) :] == names


@pytest.mark.skipif(sys.platform != "linux", reason="apt-get is of Debian")
def test_a_failing_apt_is_quiet_and_the_rest_goes_on(project: Path) -> None:
    with (project / "packaging" / "system_packages.txt").open("a") as lines:
        lines.write("nosuchlib0 libnosuchlib.so.0 run no reason\n")
    fake = 'can_use_apt() { true; }; apt() { echo noise >>"$log"; return 100; }'
    done = bash(project, f"{fake}; install_system_packages run")
    assert done.returncode == 0
    assert "noise" not in done.stderr
    assert "installation.log" in done.stderr
    assert (project / ".venv" / "installation.log").read_text() == "noise\n"


# --- progress -------------------------------------------------------------------------------------


@pytest.mark.full
def test_a_terminal_gets_one_updating_line(environment: Environment) -> None:
    lock = environment.lock(*(wheel(environment.wheels, f"part{k}") for k in range(8)))
    terminal, its_end = os.openpty()
    try:
        assert environment.install(lock, its_end).returncode == 0
        shown = os.read(terminal, 1 << 16).decode()
    finally:
        os.close(terminal)
        os.close(its_end)
    assert "\n" not in shown
    start = "\r\033[K"
    assert shown.startswith(start)
    lines = shown.split(start)[1:]
    assert lines == [*(f"Installing package {k + 1} of 8: part{k}" for k in range(8)), ""]
