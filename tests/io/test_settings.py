from __future__ import annotations

import os
import tomllib
from pathlib import Path

import pytest

from tests.messages import refused
from vomstudio.core.errors import TargetError
from vomstudio.io.settings import Settings, read_settings, write_settings


def test_settings_round_trip(tmp_path):
    path = tmp_path / "deep" / "settings.toml"
    settings = Settings(notation="quadrant", projection="angle", turntable=False)
    settings.limits = {"good_K": 0.7}
    settings.window = {"geometry": "AdnQywAD=="}
    settings.add_recent_project(Path('/data/ä "quoted" \\ back.obj'))
    write_settings(settings, path)
    again, problems = read_settings(path)
    assert again == settings
    assert problems == []
    assert again.thresholds.good_K == 0.7
    assert again.thresholds.good_M == Settings().thresholds.good_M


def test_no_file_means_defaults(tmp_path):
    assert read_settings(tmp_path / "none.toml") == (Settings(), [])


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("notation = 3\n", "notation"),
        ("[limits]\nnonsense = 3\n", "limits"),
        ('[limits]\ngood_K = "x"\n', "limits"),
        ("not toml at all", "settings"),
        ("\x00\x01", "settings"),
        ("recent" + "[" * 100_000, "settings"),
        ("x = " + "[" * 100_000, "settings"),
        ("x = '" + "x" * 2_000_000 + "'", "settings"),
        ('notation = "none"\n', "notation"),
        ('theme = "none"\n', "theme"),
        ('planes_as = "none"\n', "planes_as"),
        ("recent = [1, 2]\n", "recent"),
        ("unclosed = [{}]\n", "unclosed"),
        ('contour_levels = ["a"]\n', "contour_levels"),
        ("window.geometry = 5\n", "window"),
        ("point_budget = -5\n", "point_budget"),
        ("point_budget = true\n", "point_budget"),
    ],
)
def test_invalid_setting_is_reported_and_gets_its_default(tmp_path, text, named):
    path = tmp_path / "settings.toml"
    path.write_text('projection = "angle"\n' + text if "=" in text else text)
    settings, problems = read_settings(path)
    assert len(problems) == 1
    (problem,) = problems
    expected = "settings.unreadable" if named == "settings" else "settings.invalid-value"
    assert problem.code == expected
    assert problem.values.get("setting", "settings") == named
    assert settings.notation == "dipdir/dip"
    assert settings.limits == {}


def test_unknown_settings_of_other_versions_do_not_disturb(tmp_path):
    path = tmp_path / "settings.toml"
    path.write_text('notation = "strike/dip"\nfuture = 3\n')
    settings, problems = read_settings(path)
    assert settings.notation == "strike/dip"
    assert problems == []


BY_HAND = """# of the field laptop
notation = "strike/dip"  # as in my books
future = 3  # of a newer version
turntable = 1
recent = [
    "/m/1.obj",  # the quarry
]
limits.good_K = 0.7
unclosed = []

[limits.of_a_newer_version]
x = 1

[window]
geometry = "AA="
# kept by hand
panels = "BB="
"""


def test_comments_and_unknown_settings_survive_a_change(tmp_path):
    path = tmp_path / "settings.toml"
    path.write_text(BY_HAND)
    settings, problems = read_settings(path)
    assert len(problems) == 2
    settings.projection = "angle"
    settings.window = {"panels": "CC="}
    settings.limits = {"good_M": 5.0}
    write_settings(settings, path)
    again, problems = read_settings(path)
    assert (again, problems) == (settings, [])
    text = path.read_text()
    assert tomllib.loads(text)["future"] == 3
    for kept in (
        "# of the field laptop",
        '"strike/dip"  # as in my books',
        "# of a newer version",
        "# the quarry",
        "# kept by hand",
    ):
        assert kept in text
    write_settings(settings, path)
    assert path.read_text() == text


@pytest.mark.parametrize(
    "older",
    [
        "window.geometry = 'x'\n[limits]\n",
        "limits = {good_K = 0.7}\nwindow = {}\n",
        "window = 3\n",
        "[[limits]]\n[[limits]]\n",
        "a = 1\na = 2\n",
        "\ufeffx = 1\n",
        "[window]\n[window.deep]\nx = 1\n",
        "[limits]\ngood_K = 1\n[a]\n[window]\n[a.b]\n",
        "recent = [1, {x = 2}]\n",
        "turntable = 0\npoint_budget = true\n",
        b"\xff\xfe = 1",
        "[window.a]\nx = 1\n[limits]\n[window.b]\nx = 1\n",
        "window.a = 1\nx = 1\nwindow.b = 2\n",
    ],
)
def test_written_settings_can_be_read_after_any_previous_content(tmp_path, older):
    path = tmp_path / "settings.toml"
    path.write_bytes(older if isinstance(older, bytes) else older.encode())
    settings = Settings(turntable=False, recent=["/a", "/b"], hidden_columns=["x"])
    settings.window, settings.limits = {"geometry": "A=", "panels": "B="}, {"good_M": 4.5}
    write_settings(settings, path)
    assert read_settings(path) == (settings, [])
    empty = Settings()
    write_settings(empty, path)
    assert read_settings(path) == (empty, [])


def test_recent_files_are_ten_the_newest_first_each_once():
    settings = Settings()
    for number in (*range(14), 3):
        settings.add_recent_project(Path(f"/m/{number}.obj"))
    assert settings.recent[:2] == ["/m/3.obj", "/m/13.obj"]
    assert len(settings.recent) == 10


@pytest.mark.skipif(os.name != "posix", reason="a file where a folder should be")
def test_unwritable_settings_path_is_reported(tmp_path):
    (tmp_path / "file").write_text("x")
    with refused("output.unwritable", TargetError):
        write_settings(Settings(), tmp_path / "file" / "settings.toml")


def test_named_pipe_as_settings_file_does_not_block(tmp_path):
    import os

    path = tmp_path / "settings.toml"
    os.mkfifo(path)
    settings, problems = read_settings(path)
    assert settings == Settings()
    assert len(problems) == 1


def test_settings_changed_by_several_windows_are_merged(tmp_path: Path) -> None:
    path = tmp_path / "settings.toml"
    start = Settings(recent=["/a", "/b"], unclosed=["/old"])
    write_settings(start, path)
    first, second = (read_settings(path)[0] for _ in range(2))
    first.add_recent_project(Path("/first"))
    first.theme, first.unclosed = "dark", ["/first"]
    write_settings(first, path, start)
    second.add_recent_project(Path("/b"))
    second.notation, second.unclosed = "quadrant", ["/old", "/second"]
    write_settings(second, path, start)
    merged = read_settings(path)[0]
    assert merged.recent == ["/b", "/first", "/a"]
    assert (merged.theme, merged.notation) == ("dark", "quadrant")
    assert merged.unclosed == ["/first", "/second"]


def test_settings_are_written_completely_if_their_file_is_missing(tmp_path: Path) -> None:
    path = tmp_path / "settings.toml"
    settings = Settings(theme="dark", recent=["/a"])
    write_settings(settings, path, settings)
    assert read_settings(path)[0] == settings
