"""Promises of the repository: lock file, scripts, changelog, no addresses and no private paths."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tomllib
from importlib.metadata import PathDistribution
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

import vomstudio

ROOT = Path(__file__).resolve().parents[2]
LOCK = ROOT / "packaging" / "requirements.lock"
SCRIPTS = ("packaging/run", "packaging/test", "packaging/lock", ".ci/run")
THIRD_PARTY_ROW = re.compile(r"^\| ([\w.-]+) \| ([^|]+) \|$", re.MULTILINE)

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


def locked() -> list[Requirement]:
    lines = LOCK.read_text("utf-8").replace("\\\n", " ").splitlines()
    return [Requirement(line.split(" --hash")[0].strip()) for line in lines if line.strip()]


def test_no_file_names_a_package_registry(texts: dict[str, str]) -> None:
    guilty = [(name, host) for name, text in texts.items() for host in REGISTRIES if host in text]
    assert not guilty


def test_no_file_names_a_path_of_somebodys_machine(texts: dict[str, str]) -> None:
    guilty = [
        f"{name}:{number}: {line.strip()[:120]}"
        for name, text in texts.items()
        for number, line in enumerate(text.splitlines(), 1)
        if PRIVATE_PATH.search(line)
    ]
    assert not guilty


def test_the_lock_file_satisfies_every_declared_dependency() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    declared = project["dependencies"] + project["optional-dependencies"]["dev"]
    pinned: dict[str, list[Version]] = {}
    for requirement in locked():
        (pin,) = requirement.specifier
        assert pin.operator == "==", f"{requirement} is not pinned"
        pinned.setdefault(canonicalize_name(requirement.name), []).append(Version(pin.version))
    for text in declared:
        wanted = Requirement(text)
        versions = pinned.get(canonicalize_name(wanted.name))
        assert versions, f"{text} is not in the lock file: run packaging/lock"
        for version in versions:
            assert wanted.specifier.contains(version, prereleases=True), (
                f"{text} is locked at {version}: run packaging/lock"
            )


def test_the_lock_file_holds_hashes_and_no_address() -> None:
    text = LOCK.read_text("utf-8")
    entries = text.replace("\\\n", " ").splitlines()
    assert entries
    assert [entry for entry in entries if "--hash=sha256:" not in entry] == []
    for forbidden in ("://", " @ ", "--index", "--extra-index", "--find-links", "--trusted"):
        assert forbidden not in text


@pytest.mark.parametrize("script", SCRIPTS)
def test_scripts_are_executable_and_sound(script: str) -> None:
    subprocess.run(["bash", "-n", ROOT / script], check=True)
    assert git("ls-files", "-s", script).startswith("100755")


def test_every_system_package_says_who_needs_it_and_why() -> None:
    lines = (ROOT / "packaging" / "system_packages.txt").read_text("utf-8").splitlines()
    rows = [line.split(maxsplit=3) for line in lines if line and not line.startswith("#")]
    assert rows
    assert [row for row in rows if len(row) != 4 or row[2] not in ("run", "test")] == []


def test_the_changelog_opens_with_this_version() -> None:
    headings = re.findall(r"^## (\S+)", (ROOT / "CHANGELOG.md").read_text("utf-8"), re.MULTILINE)
    assert headings[0] == vomstudio.__version__


def test_third_party_lists_the_packages_of_the_lock_file_each_with_a_licence() -> None:
    """After packaging/lock comes packaging/make_third_party."""
    text = (ROOT / "THIRD_PARTY.md").read_text("utf-8")
    tables = text[text.index("## Packages that the program needs") :]
    rows = [row for row in THIRD_PARTY_ROW.findall(tables) if row[0] != "package"]
    names = [canonicalize_name(name) for name, _ in rows]
    assert len(names) == len(set(names))
    assert set(names) == {canonicalize_name(requirement.name) for requirement in locked()}
    assert [row for row in rows if row[1].startswith(("Copyright", "UNKNOWN"))] == []


def test_third_party_states_the_licence_of_bundles_while_their_wheels_contain_the_gpl() -> None:
    text = (ROOT / "THIRD_PARTY.md").read_text("utf-8")
    bundles = text[text.index("## Binary bundles") : text.index("## Packages")]
    assert {"pycolmap", "pyceres"} <= {r.name for r in locked()}
    assert all(word in bundles for word in ("pycolmap", "pyceres", "SuiteSparse", "GPL, version 3"))


def test_the_citation_is_of_this_version_under_this_licence() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    assert citation["cff-version"] == "1.2.0"
    assert citation["version"] == vomstudio.__version__
    assert citation["license"] == project["license"]
    assert citation["authors"] == project["authors"]
    assert citation["title"].startswith("VOM Studio")


def test_forms_and_hooks_are_valid_and_name_a_field_once() -> None:
    forms = sorted((ROOT / ".github" / "ISSUE_TEMPLATE").glob("*.yml"))
    assert len(forms) == 3
    for path in forms:
        form = yaml.safe_load(path.read_text("utf-8"))
        if path.name == "config.yml":
            assert form == {"blank_issues_enabled": True}
            continue
        assert {"name", "description", "body"} <= set(form)
        ids = [field["id"] for field in form["body"]]
        assert len(ids) == len(set(ids))
        assert all(field["attributes"]["label"] for field in form["body"])
    (repository,) = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text("utf-8"))["repos"]
    assert repository["repo"] == "local"
    assert {hook["language"] for hook in repository["hooks"]} == {"system"}


@pytest.fixture(scope="module")
def metadata(tmp_path_factory: pytest.TempPathFactory) -> PathDistribution:
    """Metadata of the wheel, made in a copy because building leaves files behind."""
    folder = tmp_path_factory.mktemp("metadata")
    source = folder / "source"
    (source / "vomstudio").mkdir(parents=True)
    modules = ("vomstudio/__init__.py", "vomstudio/version.py")
    for name in ("pyproject.toml", "setup.py", "README.md", "LICENSE", "THIRD_PARTY.md", *modules):
        shutil.copy(ROOT / name, source / name)
    code = (
        "import sys; from setuptools import build_meta; "
        "print(build_meta.prepare_metadata_for_build_wheel(sys.argv[1]))"
    )
    words = [sys.executable, "-c", code, str(folder)]
    done = subprocess.run(words, cwd=source, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return PathDistribution(folder / done.stdout.splitlines()[-1])


def test_the_package_index_gets_authors_keywords_and_kinds(metadata: PathDistribution) -> None:
    fields = metadata.metadata
    assert "The VOM Studio developers" in (fields["Author"] or fields["Author-Email"])
    assert fields["License-Expression"] == "BSD-3-Clause"
    assert "structural geology" in fields["Keywords"]
    assert "Programming Language :: Python :: 3.11" in fields.get_all("Classifier")
    assert set(fields.get_all("License-File")) == {"LICENSE", "THIRD_PARTY.md"}


def test_the_description_of_the_package_index_has_no_link_that_leads_nowhere_there(
    metadata: PathDistribution,
) -> None:
    text = metadata.metadata.get_payload() or metadata.metadata["Description"]
    assert metadata.metadata["Description-Content-Type"].startswith("text/markdown")
    assert text.strip().startswith("# VOM Studio")
    assert "packaging/run" in text
    targets = re.findall(r"\]\(([^)]*)\)", text)
    assert [target for target in targets if not target.startswith("https://")] == []
