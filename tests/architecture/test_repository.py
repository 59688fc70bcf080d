"""Promises of the repository: lock file, scripts, changelog, no addresses and no private paths."""

from __future__ import annotations

import re
import subprocess
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

import vomstudio

ROOT = Path(__file__).resolve().parents[2]
RUN_LOCK = ROOT / "packaging" / "requirements.lock"
TEST_LOCK = ROOT / "packaging" / "requirements_test.lock"
SCRIPTS = ("packaging/run", "packaging/test", "packaging/lock", ".ci/run")

# Put together from pieces, so that this file does not name what it forbids.
REGISTRIES = [
    ".".join(parts)
    for parts in (
        ("pypi", "org"),
        ("pythonhosted", "org"),
        ("deb", "debian", "org"),
        ("archive", "ubuntu", "com"),
        ("npmjs", "org"),
        ("npmjs", "com"),
        ("anaconda", "org"),
    )
]
PRIVATE_PATH = re.compile(
    r"(?<![\w.~/])/(?:" + "|".join(("home", "Users", "root", "work", "opt")) + r")/\w"
    r"|[A-Z]:[\\/]+Users[\\/]"
)


def git(*arguments: str) -> str:
    try:
        done = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True)
    except FileNotFoundError:
        pytest.skip("git is not installed")
    if done.returncode != 0:
        pytest.skip("this folder is not a git checkout")
    return done.stdout


@pytest.fixture(scope="module")
def texts() -> dict[str, str]:
    """Text of every file that is, or is about to be, in the repository."""
    found = {}
    for name in git("ls-files", "-z", "-co", "--exclude-standard").split("\0"):
        path = ROOT / name
        if name and path.is_file():
            raw = path.read_bytes()
            if b"\0" not in raw[:4096]:
                found[name] = raw.decode("utf-8", errors="replace")
    assert "pyproject.toml" in found
    return found


def locked(lock: Path) -> list[Requirement]:
    lines = lock.read_text("utf-8").replace("\\\n", " ").splitlines()
    return [Requirement(line.split(" --hash")[0].strip()) for line in lines if line.strip()]


def test_no_file_names_a_package_registry(texts: dict[str, str]) -> None:
    guilty = [(name, host) for name, text in texts.items() for host in REGISTRIES if host in text]
    assert not guilty


def test_no_file_contains_private_paths(texts: dict[str, str]) -> None:
    guilty = [
        f"{name}:{number}: {line.strip()[:120]}"
        for name, text in texts.items()
        for number, line in enumerate(text.splitlines(), 1)
        if PRIVATE_PATH.search(line)
    ]
    assert not guilty


@pytest.mark.parametrize("locks", [(RUN_LOCK,), (RUN_LOCK, TEST_LOCK)], ids=["run", "test"])
def test_the_lock_files_satisfy_every_declared_dependency(locks: tuple[Path, ...]) -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    declared = project["dependencies"]
    if TEST_LOCK in locks:
        declared = declared + project["optional-dependencies"]["dev"]
    pinned: dict[str, list[Version]] = {}
    for requirement in (requirement for lock in locks for requirement in locked(lock)):
        (pin,) = requirement.specifier
        assert pin.operator == "==", f"{requirement} is not pinned"
        pinned.setdefault(canonicalize_name(requirement.name), []).append(Version(pin.version))
    for text in declared:
        wanted = Requirement(text)
        versions = pinned.get(canonicalize_name(wanted.name))
        assert versions, f"{text} is not in the lock files: run packaging/lock"
        for version in versions:
            assert wanted.specifier.contains(version, prereleases=True), (
                f"{text} is locked at {version}: run packaging/lock"
            )


def test_tests_use_same_versions_as_users() -> None:
    versions = {r.name: r.specifier for r in locked(RUN_LOCK)}
    others = [r for r in locked(TEST_LOCK) if versions.get(r.name, r.specifier) != r.specifier]
    assert others == []


def test_program_lock_file_excludes_test_packages() -> None:
    names = {requirement.name for requirement in locked(RUN_LOCK)}
    assert names.isdisjoint({"pytest", "mypy", "ruff", "hypothesis", "ipykernel"})


@pytest.mark.parametrize("lock", [RUN_LOCK, TEST_LOCK], ids=["run", "test"])
def test_lock_file_contains_hashes_and_no_urls(lock: Path) -> None:
    text = lock.read_text("utf-8")
    entries = text.replace("\\\n", " ").splitlines()
    assert entries
    assert [entry for entry in entries if "--hash=sha256:" not in entry] == []
    for forbidden in ("://", " @ ", "--index", "--extra-index", "--find-links", "--trusted"):
        assert forbidden not in text


@pytest.mark.parametrize("script", SCRIPTS)
def test_scripts_are_executable_and_valid(script: str) -> None:
    subprocess.run(["bash", "-n", ROOT / script], check=True)
    assert git("ls-files", "-s", script).startswith("100755")


def test_every_system_package_states_its_use_and_reason() -> None:
    lines = (ROOT / "packaging" / "system_packages.txt").read_text("utf-8").splitlines()
    rows = [line.split(maxsplit=3) for line in lines if line and not line.startswith("#")]
    assert rows
    assert [row for row in rows if len(row) != 4 or row[2] not in ("run", "test")] == []


def test_the_changelog_opens_with_this_version() -> None:
    headings = re.findall(r"^## (\S+)", (ROOT / "CHANGELOG.md").read_text("utf-8"), re.MULTILINE)
    assert headings[0] == vomstudio.__version__
