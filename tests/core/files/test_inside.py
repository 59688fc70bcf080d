"""Links in a folder that came from somebody else are never written through."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tests.messages import refused
from vomstudio.cli import main
from vomstudio.core.errors import TargetError, VomError
from vomstudio.core.files.atomic import atomic_group, write_bytes
from vomstudio.core.files.backup import back_up
from vomstudio.core.files.containment import (
    check_generated_path,
    make_folder,
    refuse_links,
    require_inside,
)
from vomstudio.io.control.writing import write_marks
from vomstudio.io.models.model_copy import copy_model
from vomstudio.io.photos.cameras_file import Cameras, write_cameras
from vomstudio.io.photos.drawn_masks import write_mask
from vomstudio.photogrammetry.pipeline.outputs import claim_folder
from vomstudio.project.assets import store_asset
from vomstudio.project.folder import ProjectFolder


@pytest.fixture
def victim(tmp_path: Path) -> Path:
    (tmp_path / "outside").mkdir()
    path = tmp_path / "outside" / "victim"
    path.write_text("mine")
    return path


@pytest.fixture
def project(tmp_path: Path) -> Path:
    folder = tmp_path / "a.vom"
    ProjectFolder.create(folder).close()
    return folder


@pytest.mark.parametrize(
    "name", ["lock", "lock-journal", "journal.sqlite-wal", "journal.sqlite-shm", "journal.sqlite"]
)
def test_a_project_whose_own_files_are_links_is_not_opened(
    name: str, project: Path, victim: Path
) -> None:
    (project / name).unlink(missing_ok=True)
    (project / name).symlink_to(victim)
    with refused("output.link", VomError):
        ProjectFolder.open(project)
    assert victim.read_text() == "mine"
    assert [p.name for p in victim.parent.iterdir()] == ["victim"]


def test_linked_layers_and_assets_are_refused(project: Path, victim: Path) -> None:
    (project / "project.gpkg").symlink_to(victim)
    with refused("output.link", TargetError):
        write_bytes(project / "project.gpkg", b"new", force=True)
    (project / "assets").rmdir() if (project / "assets").exists() else None
    (project / "assets").symlink_to(victim.parent)
    with refused("output.link", TargetError):
        store_asset(project, b"content", ".png")
    (project / "cache").symlink_to(victim.parent) if not (project / "cache").exists() else None
    assert victim.read_text() == "mine"
    assert [p.name for p in victim.parent.iterdir()] == ["victim"]


def test_linked_masks_marks_and_backups_are_refused(tmp_path: Path, victim: Path) -> None:
    folder = tmp_path / "photos"
    folder.mkdir()
    for name in ("a_mask.png", "marks.csv", "b.csv.bak"):
        (folder / name).symlink_to(victim.parent / "made" if "bak" in name else victim)
    with refused("output.link", TargetError):
        write_mask(folder / "a_mask.png", np.ones((4, 4), bool))
    with refused("output.link", TargetError):
        write_marks(folder / "marks.csv", [])
    (folder / "b.csv").write_text("b")
    with refused("output.link", TargetError):
        back_up(folder / "b.csv")
    assert victim.read_text() == "mine"
    assert [p.name for p in victim.parent.iterdir()] == ["victim"]


def test_linked_companion_of_output_is_refused(tmp_path: Path, victim: Path) -> None:
    """The user named the first; a link of his own keeps its place."""
    named = tmp_path / "named.obj"
    named.symlink_to(tmp_path / "real.obj")
    (tmp_path / "named.mtl").symlink_to(victim)
    with (
        refused("output.link", TargetError),
        atomic_group([named, tmp_path / "named.mtl"], True),
    ):
        pass
    write_bytes(named, b"obj")
    assert (tmp_path / "real.obj").read_bytes() == b"obj"
    assert victim.read_text() == "mine"


def test_a_working_folder_with_links_is_refused(tmp_path: Path, victim: Path) -> None:
    (tmp_path / "out" / "work").mkdir(parents=True)
    (tmp_path / "out" / "work" / "log.txt").symlink_to(victim)
    with refused("output.link", TargetError):
        claim_folder(tmp_path / "out")


def test_copying_cameras_does_not_follow_links_out_of_folder(tmp_path: Path) -> None:
    """`x` is a link to a folder far away, so that x/../.. is not what it seems to be."""
    (tmp_path / "far" / "away" / "x").mkdir(parents=True)
    model = tmp_path / "model"
    (model / "photos").mkdir(parents=True)
    (model / "model.xyz").write_text("0 0 0\n1 0 0\n0 1 0\n")
    (model / "photos" / "x").symlink_to(tmp_path / "far" / "away" / "x")
    (model / "photos" / "a.jpg").write_bytes(b"photo")
    write_cameras(model / "cameras.json", Cameras((), Path("photos")))
    head = json.loads((model / "cameras.json").read_text())
    lens = {"model": "PINHOLE", "width": 4, "height": 4, "params": [4, 4, 2, 2]}
    view = {"name": "x/../../../photos/a.jpg", "rotation": np.eye(3).tolist()}
    head["views"] = [view | {"translation": [0, 0, 0], "intrinsics": lens, "centre": [0, 0, 0]}]
    (model / "cameras.json").write_text(json.dumps(head))
    before = sorted(p for p in tmp_path.rglob("*"))
    copy_model(model / "model.xyz", tmp_path / "copies", photos=True)
    made = {p for p in tmp_path.rglob("*")} - set(before)
    assert all(p.is_relative_to(tmp_path / "copies") for p in made)


def test_saving_as_leaves_links_out(project: Path, tmp_path: Path) -> None:
    (project / "models").mkdir(exist_ok=True)
    (project / "models" / "loop").symlink_to(project)
    opened = ProjectFolder.open(project)
    opened.save_as(tmp_path / "b.vom")
    opened.close()
    assert not (tmp_path / "b.vom" / "models" / "loop").exists()


def test_paths_outside_the_folder_and_links_are_refused(tmp_path: Path, victim: Path) -> None:
    (tmp_path / "to").symlink_to(victim.parent)
    assert require_inside(tmp_path / "a" / "b", tmp_path) == tmp_path / "a" / "b"
    for wrong in (tmp_path / "to" / "b", tmp_path / "a" / ".." / "b", victim.parent.parent.parent):
        with pytest.raises(TargetError):
            require_inside(wrong, tmp_path)
        with pytest.raises(TargetError):
            make_folder(wrong, tmp_path)
    assert require_inside(tmp_path / "to" / "b", tmp_path / "to")  # the way to the folder is free
    with pytest.raises(TargetError):
        refuse_links(tmp_path)
    refuse_links(victim.parent)


def test_project_path_may_be_relative_to_current_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    check_generated_path("cliff.vom/lock")
    check_generated_path(Path("cliff.vom") / "project.gpkg")
    Path("cliff.vom").mkdir()
    Path("cliff.vom/lock").symlink_to(tmp_path / "victim")
    with refused("output.link", TargetError):
        check_generated_path("cliff.vom/lock")


@pytest.mark.parametrize("name", ["reconstruction/photos-preview", "frames", "demo"])
def test_linked_result_folder_in_project_is_refused(
    name: str, project: Path, victim: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    place = project / name
    place.parent.mkdir(exist_ok=True)
    (victim.parent / "empty").mkdir()
    place.symlink_to(victim.parent / "empty")
    photos = Path(__file__).parents[2] / "specimens" / "photos"
    words = {
        "frames": ["frames", str(photos / "HL_2041.jpg")],
        "demo": ["demo", "--without-photos"],
    }.get(name, ["reconstruct", str(photos), "--quality", "preview"])
    assert main([*words, "-o", str(place)]) == 2
    assert "is a link" in capsys.readouterr().err
    assert not any((victim.parent / "empty").iterdir())


@pytest.mark.parametrize("name", [".vomstudio-demo", "sample.vom"])
def test_demo_folder_with_links_is_refused(
    name: str, tmp_path: Path, victim: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "demo"
    folder.mkdir()
    (folder / ".vomstudio-demo").write_text("made by vomstudio demo\n")
    (folder / name).unlink(missing_ok=True)
    (folder / name).symlink_to(victim)
    assert main(["demo", "--without-photos", "-o", str(folder)]) == 2
    assert "is a link" in capsys.readouterr().err
    assert victim.read_text() == "mine"
