"""Numbers that cannot be, empty words and help that is missing, command by command."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

import pytest

from tests.tiers import first_in_default_tier
from vomstudio.cli import COMMANDS
from vomstudio.cli.common.arguments import Parser

POINTS = "name,x,y,z\na,0,0,0\nb,10,0,1\nc,0,10,2\n"
LINE = "name,x,y,z\na,0,0,0\nb,1,1,1\nc,2,2,2\n"
CUTOFFS = "name,hanging_x,hanging_y,hanging_z,footwall_x,footwall_y,footwall_z\nA,1,2,-5,0,0,0\n"
PLANES = "dip_direction,dip\n" + "".join(f"{100 + i},{30 + i % 3}\n" for i in range(9))


def _actions(parser: argparse.ArgumentParser) -> list[argparse.Action]:
    found = []
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for each in action.choices.values():
                found += _actions(each)
        else:
            found.append(action)
    return found


@pytest.mark.parametrize("command", COMMANDS)
def test_every_option_of_every_command_is_explained(command: str) -> None:
    import importlib

    parser = Parser(prog="vomstudio")
    commands = parser.add_subparsers(parser_class=Parser)
    importlib.import_module(f"vomstudio.cli.{command}").add_parser(commands)
    unexplained = [a.dest for a in _actions(commands.choices[command]) if not a.help]
    assert unexplained == []


@pytest.mark.parametrize("error", ["nan", "inf", "-1", "1e308"])
@pytest.mark.parametrize(
    ("words", "option"),
    [
        ("threepoint points.csv", "--sigma"),
        ("log points.csv --bed 90/30", "--sigma"),
        ("log points.csv --bed 90/30", "--bed-error"),
        ("displacement pairs.csv --fault 90/60 --bed 270/10", "--sigma"),
        ("displacement pairs.csv --fault 90/60 --bed 270/10", "--fault-error"),
        ("displacement pairs.csv --fault 90/60 --bed 270/10", "--bed-error"),
        ("displacement pairs.csv --fault 90/60 --bed 270/10 --rake 80", "--rake-error"),
        ("extend points.csv --plane 90/30 --through 0,0,0 -o out.csv", "--error"),
        ("extend points.csv --plane 90/30 --through 0,0,0 --error 1 -o out.csv", "--through-error"),
        (
            "extend points.csv --plane 90/30 --through 0,0,0 --error 1 --thickness 2 -o out.csv",
            "--thickness-error",
        ),
    ],
)
def test_invalid_error_value_is_refused_with_its_option(
    run, write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: str, option: str, error: str
) -> None:
    write(POINTS, "points.csv")
    write(CUTOFFS, "pairs.csv")
    monkeypatch.chdir(tmp_path)
    ran = run(*words.split(), f"{option}={error}", "--json")
    assert ran.code == 2, ran.out
    assert ran.json["error"]["field"] == option


@pytest.mark.parametrize("rake", ["nan", "inf", "1e9"])
def test_invalid_rake_is_refused(run, write, tmp_path: Path, rake: str) -> None:
    words = ("displacement", write(CUTOFFS), "--fault", "90/60", "--bed", "270/10", "--json")
    ran = run(*words, "--rake", rake)
    assert ran.code == 2, ran.out
    assert ran.json["error"]["field"] == "--rake"
    net = ("stereonet", write(PLANES), "-o", tmp_path / "n.svg", "--json")
    ran = run(*net, "--slip-line", f"90/30/{rake}")
    assert ran.code == 2, ran.out
    assert ran.json["error"]["field"] == "--slip-line"


@pytest.mark.parametrize("plane", ["400/30", "1e308/20", "90/95", "nan/20", "90", "north"])
@pytest.mark.parametrize(
    ("words", "option"),
    [
        ("log points.csv", "--bed"),
        ("displacement pairs.csv --bed 270/10", "--fault"),
        ("displacement pairs.csv --fault 90/60", "--bed"),
        ("displacement pairs.csv --fault 90/60 --bed 270/10", "--slip"),
        ("sets planes.csv -o out.csv", "--seeds"),
    ],
)
def test_invalid_attitude_is_refused_with_its_option(
    run, write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: str, option: str, plane: str
) -> None:
    write(POINTS, "points.csv")
    write(CUTOFFS, "pairs.csv")
    write(PLANES, "planes.csv")
    monkeypatch.chdir(tmp_path)
    ran = run(*words.split(), option, plane, "--json")
    assert ran.code == 2, ran.out
    assert ran.json["error"]["field"] == option


@pytest.mark.parametrize("count", ["0", "-1", "10", "99999999999999999999"])
def test_invalid_number_of_sets_is_refused(run, write, tmp_path: Path, count: str) -> None:
    ran = run("sets", write(PLANES), "-o", tmp_path / "o.csv", "--exactly", count, "--json")
    assert ran.code == 2
    assert ran.json["error"]["field"] == "--exactly"


@pytest.mark.parametrize(
    "gsd", first_in_default_tier(["1e308", "1e-308", "1e9", "nan", "inf", "0"])
)
@pytest.mark.parametrize("command", first_in_default_tier(["ortho", "dem", "surface"]))
def test_invalid_pixel_size_is_refused(run, write, tmp_path: Path, command: str, gsd) -> None:
    cloud = "x,y,z\n" + "".join(f"{i},{j},{0.1 * i}\n" for i in range(12) for j in range(12))
    way = ["--trend", "10", "--plunge", "20"] if command == "ortho" else []
    target = tmp_path / "o.tif"
    ran = run(command, write(cloud), *way, "-o", target, "--gsd", gsd, "--json")
    assert ran.code == 2, ran.out
    error = ran.json["error"]
    # Cells as large as all of a patch leave it no map: then the patch is named.
    assert error["field"] == "--gsd" or "too small" in error["message"]
    assert not target.exists()


@pytest.mark.full
def test_pixel_may_be_larger_than_textured_model(run, tmp_path: Path) -> None:
    from vomstudio.core.paths import resource

    model = resource("outcrop") / "outcrop.obj"
    words = ("ortho", model, "--trend", "10", "--plunge", "20", "-o", tmp_path / "o.tif")
    ran = run(*words, "--gsd", "1e6", "--json")
    assert ran.code == 0, ran.err
    assert (ran.json["width"], ran.json["height"]) == (1, 1)


@pytest.mark.parametrize(
    "words",
    [
        ["info", ""],
        ["check", ""],
        ["reconstruct", "", "-o", "out"],
        ["reconstruct", "photos", "-o", ""],
        ["demo", "-o", ""],
        ["section", "m.obj", "--plane", "90/90", "--through", "0,0,0", "-o", ""],
        ["register", "-", "--cameras", ""],
        ["register", "-", "--attitudes", ""],
        ["register", "-", "--gcp", ""],
    ],
)
def test_empty_argument_does_not_mean_current_folder(
    run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: list[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    ran = run(*words, "--json")
    assert ran.code == 2, ran.err
    assert ran.json["error"]["message"]
    assert os.listdir(tmp_path) == []


def test_empty_set_name_is_accepted(run, tmp_path: Path) -> None:
    words = ("project", tmp_path / "none.vom", "add-picks", "p.csv", "--type", "bedding")
    assert "empty word" not in run(*words, "--set", "").said


@pytest.mark.parametrize(
    ("words", "content"),
    [
        ("threepoint {}", LINE),
        ("threepoint {}", POINTS.splitlines()[0] + "\na,0,0,0\nb,1,1,2\n"),
        ("log {} --bed 90/30", "name,x,y,z\na,0,0,0\n"),
        ("displacement {} --fault 90/60 --bed 90/60", CUTOFFS),
        ("facets {} -o facets.csv", "x,y,z\n1,2,3\n"),
    ],
)
def test_error_for_degenerate_points_names_their_file(
    run, write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: str, content: str
) -> None:
    path = write(content)
    monkeypatch.chdir(tmp_path)
    ran = run(*words.format(path).split(), "--json")
    assert ran.code == 2
    assert ran.json["error"]["file"] == str(path)


@pytest.mark.parametrize(
    ("option", "value"),
    [("--threads", "0"), ("--threads", "9" * 20), ("--seed", "-1"), ("--seed", "9" * 20)],
)
def test_reconstruction_refuses_unusable_numbers(
    run, tmp_path: Path, option: str, value: str
) -> None:
    ran = run("reconstruct", tmp_path, "-o", tmp_path / "out", f"{option}={value}", "--json")
    assert ran.code == 2
    assert ran.json["error"]["field"] == option
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("option", ["--receiver", "--control"])
def test_plan_refuses_unrealistic_accuracies(run, option: str) -> None:
    words = "plan --camera 23.5x15.6,35,6000x4000 --distance 20 --width 30 --height 10 --json"
    ran = run(*words.split(), option, "1e-308")
    assert ran.code == 2
    assert ran.json["error"]["field"] == option


def test_huge_patch_radius_does_not_overflow(run, write, tmp_path: Path) -> None:
    cloud = "x,y,z\n" + "".join(f"{i},{j},{0.1 * i}\n" for i in range(12) for j in range(12))
    ran = run("surface", write(cloud), "-o", tmp_path / "o.csv", "--around", "1,1,0,1e300")
    assert ran.code == 0, ran.err
