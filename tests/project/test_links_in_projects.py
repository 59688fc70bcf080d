"""A project that came with links in it: nothing is written, moved or removed through them."""

from __future__ import annotations

import contextlib
import os
import shutil
import sys
from pathlib import Path

import pytest

from tests.tiers import first_in_default_tier
from vomstudio.cli import main
from vomstudio.core.errors import VomError
from vomstudio.project import edits
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.records import Feature

SPECIMENS = Path(__file__).parents[1] / "specimens"
FOLDERS = [
    "assets",
    "assets-before-compaction",
    "cache",
    "comparisons",
    "models",
    "photos",
    "reconstruction",
]
FILES = [
    "project.gpkg",
    "project.qgs",
    "journal-before-compaction.sqlite",
    "journal-compacted.sqlite",
    "journal.sqlite-wal",
    "journal.sqlite-shm",
    "journal.sqlite-journal",
    "lock",
    "lock-journal",
]

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="links need rights there")


def content(folder: Path) -> dict[str, bytes]:
    return {p.name: p.read_bytes() for p in folder.iterdir()}


@pytest.mark.parametrize("name", first_in_default_tier([*FOLDERS, *FILES]))
def test_target_of_a_symbolic_link_is_left_unchanged(
    tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    project, victim = tmp_path / "a.vom", tmp_path / "victim"
    project.mkdir()
    shutil.copy(SPECIMENS / "schema1.vom" / "journal.sqlite", project)
    victim.mkdir()
    for kept in ("letter.png", "cameras.json", "model-0", f"{'0' * 64}.png"):
        (victim / kept).write_bytes(b"not the project's")
    before = content(victim)
    if (project / name).exists():
        pytest.skip("the specimen has a file of its own there")
    os.symlink(victim if name in FOLDERS else victim / "letter.png", project / name)
    # Whether it is done or refused: not through the link.
    with contextlib.suppress(VomError):
        opened = ProjectFolder.open(project)
        opened.buffer_unwritten_steps(lambda _: None)
        feature = next(iter(opened.session.of(Feature)))
        change = edits.set_attributes(opened.session.records, [feature.id], notes="changed")
        opened.session.apply(change)
        opened.session.save()
        with contextlib.suppress(VomError):
            opened.compact()
        with contextlib.suppress(VomError):
            opened.assets.store(b"a mask", ".png")
        with contextlib.suppress(VomError):
            opened.save_as(tmp_path / "b.vom")
        opened.close()
    for words in (["compact"], ["repair"], ["verify"]):
        assert main(["project", str(project), *words]) in (0, 1, 2)
    capsys.readouterr()
    assert content(victim) == before
