"""The first words of the command line: commands, files for the window, and what is neither."""

from __future__ import annotations

import configparser
import json
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import pytest

from tests.messages import error_of, refused, shown_codes
from vomstudio.cli import COMMANDS, opens_window
from vomstudio.core.errors import TargetError
from vomstudio.core.files.desktop import install
from vomstudio.core.findings import Finding
from vomstudio.core.paths import resource
from vomstudio.core.version import __version__
from vomstudio.ui.shell.window_start import DESKTOP_NAME


def unknown_command(value: str, nearest: str | None) -> Finding:
    commands = ", ".join(COMMANDS)
    return Finding("command.unknown", value=value, nearest=nearest, commands=commands)


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a model in it, in which the program is started."""
    (tmp_path / "cliff.obj").write_text("v 0 0 0\n")
    (tmp_path / "photos").mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("words", [[], ["cliff.obj"], ["photos"], ["./cliff.obj", "photos"]])
def test_existing_files_and_folders_open_the_window(here: Path, words: list[str]) -> None:
    assert opens_window(words)


@pytest.mark.parametrize("words", [["fit"], ["--version"], ["clif.obj"], ["cliff.obj", "gone"]])
def test_all_other_arguments_go_to_the_command_line(here: Path, words: list[str]) -> None:
    assert not opens_window(words)


def test_command_takes_precedence_over_file_of_same_name(here: Path) -> None:
    (here / "fit").touch()
    assert not opens_window(["fit"])


@pytest.mark.parametrize(
    ("word", "nearest"),
    [("stero", "stereonet"), ("Fit", "fit"), ("reconstuct", "reconstruct"), ("exprot", "export")],
)
def test_misspelt_command_suggests_the_nearest(
    here: Path, run: Any, word: str, nearest: str
) -> None:
    done = run(word)
    assert (done.code, done.out) == (2, "")
    assert str(unknown_command(word, nearest)) in done.err


@pytest.mark.parametrize(
    ("words", "nearest", "page"),
    [
        ("ortho m.obj --trned 3 -o o.tif", "--trend", "ortho"),
        ("ortho m.obj --trned 3", "--trend", "ortho"),
        ("ortho m.obj --trned=3", "--trend", "ortho"),
        ("ortho m.obj --out o.tif", "--output", "ortho"),
        ("section m.obj --plane 30/40 --throuhg -5,3,2 -o s.csv", "--through", "section"),
        ("fit p.csv --Method pca", "--method", "fit"),
        ("fit p.csv --method pcaa", "pca", "fit"),
        ("project P lsit", "list", "project"),
        ("project P ad-model m.obj", "add-model", "project"),
        ("project P --jsn", "--json", "project"),
        ("project P undo --jsn", "--json", "project PROJECT undo"),
        ("project P add-picks t.csv --tpye bedding", "--type", "project PROJECT add-picks"),
        ("--verison", "--version", ""),
    ],
)
def test_misspelt_options_and_actions_suggest_the_nearest(
    run: Any, words: str, nearest: str, page: str
) -> None:
    done = run(*words.split(), "--json")
    assert done.code == 2
    error_of(done.json, "command.misspelt", nearest=nearest, program=f"vomstudio {page}".strip())


@pytest.mark.parametrize(
    ("words", "value", "page"),
    [
        ("fit p.csv --wxyz", "--wxyz", "fit"),
        ("project P undo extra", "extra", "project PROJECT undo"),
        ("fit a.csv b.csv", "b.csv", "fit"),
    ],
)
def test_unknown_arguments_refer_to_help_of_their_command(
    run: Any, words: str, value: str, page: str
) -> None:
    done = run(*words.split(), "--json")
    assert done.code == 2
    error_of(done.json, "command.unknown-argument", value=value, program=f"vomstudio {page}")


def test_unknown_action_lists_all_actions(run: Any) -> None:
    error = error_of(
        run("project", "P", "dance", "--json").json, "option.not-a-choice", value="dance"
    )
    assert {"list", "undo", "add-model"} <= set(error["choices"])


@pytest.mark.parametrize(
    "words",
    ["fit --wrong --help", "fit -- --method", "ortho m.obj --trend -5 --plunge -.5 -oo.png"],
)
def test_values_and_words_after_double_dash_are_not_misspelt_options(run: Any, words: str) -> None:
    codes = shown_codes(run(*words.split()).err)
    assert not codes & {"command.misspelt", "command.unknown-argument"}


@pytest.mark.parametrize("words", [["dance"], ["wxyz", "--json"], ["wxyz", "cliff.obj"]])
def test_unknown_command_is_reported(here: Path, run: Any, words: list[str]) -> None:
    done = run(*words)
    assert done.code == 2
    nearest = "trace" if words == ["dance"] else None
    finding = unknown_command(words[0], nearest)
    assert str(finding) in done.err
    if "--json" in words:
        assert done.json["error"]["code"] == finding.code


def test_missing_file_suggests_nearest_name(here: Path, run: Any) -> None:
    done = run("clif.obj")
    assert (done.code, done.out) == (2, "")
    assert f"clif.obj: {Finding('file.misspelt', nearest='cliff.obj')}" in done.err
    assert f"gone: {Finding('folder.missing')}" in run("gone/a.obj").err
    assert f"photos/9.jpg: {Finding('file.missing')}" in run("photos/9.jpg").err
    # Also the second one, and also where there is no screen.
    assert f"zzz.ply: {Finding('file.missing')}" in run("cliff.obj", "zzz.ply").err
    assert f"--force: {Finding('command.window-options')}" in run("cliff.obj", "--force").err


def test_invalid_file_name_is_reported_without_traceback(here: Path, run: Any) -> None:
    for name in ("a" * 5000, "a/" * 3000 + "b.obj", "a\0b.obj"):
        assert not opens_window([name])
        done = run(name)
        assert (done.code, done.out) == (2, "")
        assert "Traceback" not in done.err


def test_misspelt_command_is_reported_without_display(here: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "vomstudio", "stereonett"],
        capture_output=True,
        text=True,
        check=False,
        env={"PATH": "/usr/bin", "HOME": str(here), "PYTHONPATH": str(Path(__file__).parents[2])},
    )
    assert done.returncode == 2
    assert str(unknown_command("stereonett", "stereonet")) in done.stderr
    assert "screen" not in done.stderr


# The program's own options -------------------------------------------------------------------
@pytest.mark.full
def test_version_option_reports_installed_versions(run: Any) -> None:
    import numpy
    import vtkmodules.all as vtk

    assert run("--version").out == f"VOM Studio {__version__}\n"
    found = json.loads(run("--version", "--json").out)
    assert found["version"] == __version__
    assert found["python"] == sys.version.split()[0]
    assert found["packages"]["numpy"] == numpy.__version__
    assert found["packages"]["vtk"] == vtk.vtkVersion.GetVTKVersion()
    assert set(found["graphics"]) == {"vendor", "renderer", "version"}
    assert all(found["graphics"].values())


def test_broken_graphics_driver_does_not_prevent_version_output(
    run: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vomstudio.cli.common.global_options.sys.executable", "/bin/false")
    assert json.loads(run("--version", "--json").out)["graphics"] is None


def test_desktop_entry_icon_and_file_type_are_installed(
    run: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    # A path with everything that the specification escapes.
    python = '/a "b" $c/100 %/`d`\\python'
    monkeypatch.setattr("vomstudio.core.paths.sys.executable", python)
    monkeypatch.delenv("VOMSTUDIO_LAUNCHER", raising=False)
    files = [Path(path) for path in json.loads(run("--install-desktop", "--json").out)["files"]]
    entry_file, icon, types = files
    entry = configparser.RawConfigParser()
    entry.optionxform = str  # type: ignore[assignment, method-assign]
    entry.read(entry_file, "utf-8")
    said = dict(entry["Desktop Entry"])
    assert (said["Type"], said["Name"], said["Icon"]) == ("Application", "VOM Studio", icon.stem)
    # By it desktops find the entry of a window.
    assert said["StartupWMClass"] == entry_file.stem == DESKTOP_NAME
    # Of the entry's value, then of the quoted word, as the specification has them.
    line = re.sub(r"\\\\", r"\\", said["Exec"])
    quoted = re.fullmatch(r'"((?:\\.|[^"\\])*)" -P -m vomstudio %F', line)
    assert quoted
    assert re.sub(r"\\(.)", r"\1", quoted[1]).replace("%%", "%") == python
    assert icon.read_bytes() == resource("icon", "vomstudio.svg").read_bytes()
    root = ElementTree.parse(types).getroot()
    (kind,) = root
    assert kind.get("type") in said["MimeType"].split(";")
    (glob,) = [part.get("pattern") for part in kind if part.tag.endswith("glob")]
    assert glob == "*.vom"
    # Again, over the files of before.
    assert [Path(p) for p in json.loads(run("--install-desktop", "--json").out)["files"]] == files
    # A bundle is started by its launcher: the interpreter inside may be elsewhere next time.
    monkeypatch.setenv("VOMSTUDIO_LAUNCHER", str(tmp_path / "vomstudio.run"))
    run("--install-desktop")
    entry.read(entry_file, "utf-8")
    assert entry["Desktop Entry"]["Exec"] == f'"{tmp_path / "vomstudio.run"}" %F'


def test_uninstalling_removes_what_was_installed_and_nothing_else(
    run: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    data = tmp_path / "data"
    monkeypatch.setenv("XDG_DATA_HOME", str(data))
    monkeypatch.setenv("PATH", str(_indexers(tmp_path)))
    none = run("--uninstall-desktop", "--json")
    assert (none.code, none.json["files"]) == (0, [])
    assert not (tmp_path / "calls").exists()
    installed = run("--install-desktop", "--json").json["files"]
    other = data / "applications" / "other.desktop"
    other.write_text("[Desktop Entry]")
    (tmp_path / "calls").unlink()
    done = run("--uninstall-desktop")
    assert (done.code, done.out.splitlines()) == (0, installed)
    assert [path for path in data.rglob("*") if path.is_file()] == [other]
    assert (tmp_path / "calls").read_text().split() == [
        "update-desktop-database",
        str(data / "applications"),
        "update-mime-database",
        str(data / "mime"),
    ]
    # A part of it is removed too, and again there is nothing.
    run("--install-desktop")
    Path(installed[0]).unlink()
    assert run("--uninstall-desktop", "--json").json["files"] == installed[1:]
    again = run("--uninstall-desktop")
    assert (again.code, "removed" in again.out) == (0, True)


def _indexers(folder: Path) -> Path:
    """A folder of programs that record how they are called in place of refreshing indexes."""
    programs = folder / "bin"
    programs.mkdir()
    for name in ("update-desktop-database", "update-mime-database"):
        script = f'#!/bin/sh\necho {name} "$@" >> "{folder / "calls"}"\n'
        (programs / name).write_text(script)
        (programs / name).chmod(0o755)
    return programs


def test_a_file_that_cannot_be_removed_is_named(
    run: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    entry = tmp_path / "applications" / "vomstudio.desktop"
    entry.mkdir(parents=True)
    done = run("--uninstall-desktop", "--json")
    assert (done.code, done.json["error"]["file"]) == (2, str(entry))
    both = run("--install-desktop", "--uninstall-desktop", "--json")
    assert (both.code, both.json["error"]["code"]) == (2, "command.invalid")


def test_a_folder_that_cannot_be_made_is_named(
    run: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "data").write_text("a file")
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    done = run("--install-desktop")
    assert done.code == 2
    assert str(tmp_path / "data" / "applications") in done.err


def test_desktop_installation_is_refused_on_other_systems(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vomstudio.core.files.desktop.sys.platform", "darwin")
    with refused("desktop.not-linux", TargetError):
        install()
