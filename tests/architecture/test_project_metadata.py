"""What the project states of itself to package indexes, libraries, lawyers and contributors."""

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
from packaging.utils import canonicalize_name

import vomstudio

ROOT = Path(__file__).resolve().parents[2]
LOCKED = re.compile(r"^([A-Za-z0-9][\w.-]*)(?:\[[\w,-]+\])?==", re.MULTILINE)
THIRD_PARTY_ROW = re.compile(r"^\| ([\w.-]+) \| ([^|]+) \|$", re.MULTILINE)


def locked_names() -> set[str]:
    """Names of all packages that the lock files pin, for any system."""
    locks = sorted((ROOT / "packaging").glob("requirements*.lock"))
    names = {
        canonicalize_name(n) for lock in locks for n in LOCKED.findall(lock.read_text("utf-8"))
    }
    assert len(names) > 50
    return names


def test_third_party_lists_the_packages_of_the_lock_file_each_with_a_licence() -> None:
    """After packaging/lock comes packaging/make_third_party."""
    text = (ROOT / "THIRD_PARTY.md").read_text("utf-8")
    tables = text[text.index("## Packages of") :]
    rows = [row for row in THIRD_PARTY_ROW.findall(tables) if row[0] != "package"]
    names = [canonicalize_name(name) for name, _ in rows]
    assert len(names) == len(set(names))
    assert set(names) == locked_names()
    assert [row for row in rows if row[1].startswith(("Copyright", "UNKNOWN"))] == []


def test_third_party_states_gpl_licence_of_bundles() -> None:
    text = (ROOT / "THIRD_PARTY.md").read_text("utf-8")
    bundles = text[text.index("## Binary bundles") : text.index("## Packages")]
    assert {"pycolmap", "pyceres"} <= locked_names()
    assert all(word in bundles for word in ("pycolmap", "pyceres", "SuiteSparse", "GPL, version 3"))


def test_citation_has_current_version_and_licence() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    assert citation["cff-version"] == "1.2.0"
    assert citation["version"] == vomstudio.__version__
    assert citation["license"] == project["license"]
    assert citation["authors"] == project["authors"]
    assert citation["title"].startswith("VOM Studio")


def test_issue_forms_and_hooks_are_valid() -> None:
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
    source.mkdir()
    modules = ("vomstudio/__init__.py", "vomstudio/core/version.py")
    for name in ("pyproject.toml", "setup.py", "README.md", "LICENSE", "THIRD_PARTY.md", *modules):
        (source / name).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / name, source / name)
    code = (
        "import sys; from setuptools import build_meta; "
        "print(build_meta.prepare_metadata_for_build_wheel(sys.argv[1]))"
    )
    words = [sys.executable, "-c", code, str(folder)]
    done = subprocess.run(words, cwd=source, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return PathDistribution(folder / done.stdout.splitlines()[-1])


def test_package_metadata_has_author_keywords_and_classifiers(metadata: PathDistribution) -> None:
    fields = metadata.metadata
    assert "The VOM Studio developers" in (fields["Author"] or fields["Author-Email"])
    assert fields["License-Expression"] == "BSD-3-Clause"
    assert "structural geology" in fields["Keywords"]
    assert "Programming Language :: Python :: 3.11" in fields.get_all("Classifier")
    assert set(fields.get_all("License-File")) == {"LICENSE", "THIRD_PARTY.md"}


def test_package_description_has_only_absolute_links(
    metadata: PathDistribution,
) -> None:
    text = metadata.metadata.get_payload() or metadata.metadata["Description"]
    assert metadata.metadata["Description-Content-Type"].startswith("text/markdown")
    assert text.strip().startswith("# VOM Studio")
    assert "packaging/run" in text
    targets = re.findall(r"\]\(([^)]*)\)", text)
    assert [target for target in targets if not target.startswith("https://")] == []
