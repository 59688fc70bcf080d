"""What all commands promise: exit codes, one object, one sentence, no traceback."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import vomstudio as vs
from tests.messages import shown_codes
from tests.tiers import first_in_default_tier
from vomstudio.cli import COMMANDS
from vomstudio.cli.common.output import to_json
from vomstudio.core.errors import WorkerError
from vomstudio.core.findings import Finding

POINTS = "0 0 0\n9 0 0\n0 9 1\n9 9 1.1\n"


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help(run, command: str) -> None:
    ran = run(command, "--help")
    assert ran.code == 0
    assert ran.out.startswith(f"usage: vomstudio {command}")
    assert "--json" in ran.out
    assert ran.err == ""


def test_program_prints_help_and_version(run) -> None:
    assert all(command in run("--help").out for command in COMMANDS)
    assert run("--version").out.startswith("VOM Studio 0.")


@pytest.mark.parametrize(
    ("words", "code", "field"),
    first_in_default_tier(
        [
            ([], "command.missing", None),
            (["dance"], "command.unknown", "COMMAND"),
            (["fit"], "command.arguments-missing", "POINTS"),
            (["fit", "a", "b"], "command.unknown-argument", "b"),
            (["fit", "a", "--method", "magic"], "option.not-a-choice", "--method"),
            (["fit", "a", "--by"], "command.invalid", "--by"),
            (["fit", "a", "--wrong"], "command.unknown-argument", "--wrong"),
            (["fold", "a", "--azimuth", "north"], "option.not-a-choice", "--azimuth"),
            (["export", "a", "-o", "b"], "command.arguments-missing", "--to"),
            (["threepoint", "a", "--sigma", "large"], "number.invalid", "--sigma"),
            (["sets", "a", "-o", "b", "--exactly", "2.5"], "number.not-whole", "--exactly"),
        ],
        3,
    ),
)
def test_wrong_usage_gives_one_sentence_and_exit_code_2(
    run, words: list[str], code: str, field: str | None
) -> None:
    ran = run(*words)
    assert ran.code == 2
    assert code in shown_codes(ran.said)
    assert ran.out == ""
    failed = run(*words, "--json")
    assert failed.code == 2
    error = failed.json["error"]
    assert (error["code"], error["field"]) == (code, field)
    assert set(error) >= {"code", "file", "line", "field", "message"}


def test_unsupported_output_format_is_refused_with_supported_ones(run) -> None:
    ran = run("export", "a", "--to", "doc", "-o", "b")
    assert ran.code == 2
    assert "csv" in ran.said


HOSTILE = [
    (b"", ["file.empty"]),
    (b"\n\n", ["file.empty"]),
    (b"x,y,z\n", ["table.no-rows", "table.missing-column"]),
    (b"strike,dip\n", ["table.no-rows", "table.missing-column"]),
    (b"# nothing\n", ["table.no-rows"]),
    (b"one,two\nthree,four\n", ["table.missing-column", "orientation.no-columns"]),
    (b"x,y,z,strike,dip\n1,2,3,4,5\n1,2\n", ["table.ragged-row"]),
    (b"x,y,z,strike,dip\n1,2,3,4,5\n1;2;3;4;5\n", ["table.ragged-row"]),
    (b"x,y,z,strike,dip\n1,2,3,4,5\n1,2,three,4,steep\n", ["table.not-a-number"]),
    (b"x,x,y,z,dip,dip,strike\n1,2,3,4,5,6,7\n", ["table.repeated-column"]),
    (b"x,y,z,strike,dip\nnan,nan,nan,nan,nan\n", ["table.no-valid-rows"]),
    (b'x,y,z,strike,dip\n1,2,3,"4,5\n', ["table.open-quotes"]),
]
"""Contents of tables, and the codes with which they are refused."""
OTHER_KINDS = [
    (b"\x89PNG\r\n\x1a\n\x00\x00", "png"),
    (b"\x00" * 100, "binary"),
    (b"LASF" + b"\x00" * 300, "las"),
]
TABLE_COMMANDS = ["fit", "stats", "fold", "stereonet", "rose", "slope"]


def table_words(command: str, path: Path) -> list[object]:
    """Return the arguments with which a command reads a table."""
    target = path.parent / "out.svg"
    output = ["-o", target] if command in ("stereonet", "rose") else []
    output += ["--face", "90/70", "--friction", "30"] if command == "slope" else []
    return [command, path, *output]


@pytest.mark.parametrize("command", TABLE_COMMANDS)
@pytest.mark.parametrize(("content", "codes"), HOSTILE)
def test_hostile_tables_are_refused_by_every_command(
    run, write, tmp_path: Path, command: str, content: bytes, codes: list[str]
) -> None:
    words = table_words(command, path := write(content, "Ümläut 層.csv"))
    ran = run(*words)
    assert ran.code == 2
    assert str(path) in ran.said
    assert ran.out == ""
    failed = run(*words, "--json")
    assert failed.code == 2
    assert failed.json["error"]["code"] in codes
    assert failed.json["error"]["file"] == str(path)
    assert failed.json["error"]["message"]
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize("command", TABLE_COMMANDS)
@pytest.mark.parametrize(("content", "kind"), OTHER_KINDS)
def test_files_of_other_kinds_are_refused_by_every_command(
    run, write, tmp_path: Path, command: str, content: bytes, kind: str
) -> None:
    words = table_words(command, path := write(content, "Ümläut 層.csv"))
    failed = run(*words, "--json")
    error = failed.json["error"]
    assert failed.code == 2
    assert (error["code"], error["kind"]) == ("file.other-kind", kind)
    assert error["file"] == str(path)
    assert str(path) in run(*words).said
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize("command", ["info", "fit", "stats", "fold", "export"])
def test_a_missing_file_is_named(run, tmp_path: Path, command: str) -> None:
    path = tmp_path / "missing.csv"
    extra = ["--to", "csv", "-o", tmp_path / "o.csv"] if command == "export" else []
    ran = run(command, path, *extra)
    assert ran.code == 2
    assert str(path) in ran.said
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("command", ["info", "fit", "stats", "fold", "export"])
def test_folder_given_as_file_is_named(run, tmp_path: Path, command: str) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    extra = ["--to", "csv", "-o", tmp_path / "o.csv"] if command == "export" else []
    ran = run(command, folder, *extra)
    assert ran.code == 2
    assert str(folder) in ran.said


@pytest.mark.parametrize(
    ("target", "code"),
    [
        ("missing/out.csv", "output.no-folder"),
        (".", "output.is-folder"),
        ("in.csv", "output.is-input"),
    ],
)
def test_an_impossible_target_is_refused_before_any_work(
    run, write, tmp_path: Path, target: str, code: str
) -> None:
    path = write(POINTS)
    before = path.read_bytes()
    ran = run("fit", path, "-o", tmp_path / target, "--json")
    assert ran.code == 2
    assert ran.json["error"]["code"] == code
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["in.csv"]


def raises(error: BaseException):  # type: ignore[no-untyped-def]
    def broken(args: object, out: object) -> None:
        print("of a library")
        raise error

    return broken


@pytest.mark.parametrize(
    ("error", "exit_code", "expected"),
    [
        (KeyboardInterrupt(), 130, {"code": "cancelled"}),
        (
            ZeroDivisionError("division by zero"),
            1,
            {"code": "command.internal-error", "type": "ZeroDivisionError"},
        ),
        (
            RuntimeError("two\nlines"),
            1,
            {"code": "command.internal-error", "error": "two\nlines"},
        ),
        (MemoryError(), 1, {"code": "job.out-of-memory"}),
        (WorkerError(Finding("sample.damaged")), 1, {"code": "sample.damaged"}),
        (
            PermissionError(13, "Permission denied", "/secret"),
            2,
            {"code": "system.refused", "reason": "Permission denied", "file": "/secret"},
        ),
        (
            OSError(5, "Input/output error"),
            1,
            {"code": "system.refused", "reason": "Input/output error"},
        ),
    ],
)
@pytest.mark.expects_log
def test_every_exception_gives_one_sentence_and_a_code(
    run,
    write,
    monkeypatch: pytest.MonkeyPatch,
    error: BaseException,
    exit_code: int,
    expected: dict[str, str],
) -> None:
    monkeypatch.setattr("vomstudio.io.text.tables.read_points", lambda *a: raises(error)(*a))
    monkeypatch.delenv("VOMSTUDIO_DEBUG", raising=False)
    ran = run("fit", write(POINTS), "--json")
    assert ran.code == exit_code
    assert ran.json["error"].items() >= expected.items()
    assert ran.err.splitlines()[0] == "of a library"
    assert len(ran.err.splitlines()) == 2
    assert "Traceback" not in ran.err


@pytest.mark.expects_log
def test_traceback_is_shown_in_debug_mode(run, write, monkeypatch: pytest.MonkeyPatch) -> None:
    broken = raises(ZeroDivisionError("division by zero"))
    monkeypatch.setattr("vomstudio.io.text.tables.read_points", lambda *a: broken(*a))
    monkeypatch.setenv("VOMSTUDIO_DEBUG", "1")
    assert "Traceback" in run("fit", write(POINTS)).err


def test_undefined_and_infinite_numbers_are_null_in_json() -> None:
    value = {
        "a": [float("nan"), float("inf"), 1.5],
        "b": np.array([[1.0, np.nan]]),
        "c": np.float64("-inf"),
        "d": np.int64(3),
        "e": np.bool_(True),
        "f": Path("x") / "y",
        "g": (1, None),
    }
    assert json.loads(to_json(value)) == {
        "a": [None, None, 1.5],
        "b": [[1.0, None]],
        "c": None,
        "d": 3,
        "e": True,
        "f": str(Path("x") / "y"),
        "g": [1, None],
    }


def test_readable_text_goes_to_stderr_with_json(run, write) -> None:
    ran = run("fit", write(POINTS), "--json")
    assert list(ran.json)[:2] == ["planes", "skipped"]
    assert "quality" in ran.err
    plain = run("fit", write(POINTS), "--unit", "m", "--up", "z")
    assert "quality" in plain.out
    assert plain.err == ""


def test_unicode_names_are_supported(run, write) -> None:
    text = "x,y,z,t\n" + "".join(f"{p.replace(' ', ',')},層 é\n" for p in POINTS.splitlines())
    path = write(text, "层理 é.csv")
    assert run("fit", path, "--by", "t", "--json").json["planes"][0]["id"] == "層 é"


@pytest.mark.parametrize(
    ("words", "field"),
    [
        (["fit", "a", "--wrong", "3"], "--wrong"),
        (["fit"], "POINTS"),
        (["export", "a", "-o", "b"], "--to"),
        (["fit", "a", "--method", "magic"], "--method"),
    ],
)
def test_error_field_names_the_wrong_argument(run, words: list[str], field: str) -> None:
    assert run(*words, "--json").json["error"]["field"] == field


def test_error_of_project_action_names_project(run, tmp_path: Path) -> None:
    with vs.Project.create(tmp_path / "empty.vom"):
        pass
    for action in ("undo", "redo", "repair"):
        error = run("project", tmp_path / "empty.vom", action, "--json").json["error"]
        assert error["file"] == str(tmp_path / "empty.vom")


def test_tilde_expands_to_home_folder(
    run, write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("USERPROFILE", str(tmp_path))
    write(POINTS)
    assert run("fit", "~/in.csv", "--output=~/planes.csv", "--json").code == 0
    assert (tmp_path / "planes.csv").is_file()
    assert len(vs.read_orientations("~/planes.csv")) == 1
    # A folder that is really called so is meant by its name.
    monkeypatch.chdir(tmp_path)
    (tmp_path / "~").mkdir()
    (tmp_path / "~" / "in.csv").write_text("x,y,z\n")
    assert str(Path("~") / "in.csv") in run("fit", "~/in.csv").said


@pytest.mark.parametrize("command", ["fit", "stats", "fold"])
def test_stderr_contains_only_json_lines_with_progress_json(run, write, command: str) -> None:
    table = write("x,y,z,strike,dip\n0,0,0,10,20\n1,0,0,40,50\n0,1,1,90,60\n0,3,1,7,7\n")
    for path in (table, table.with_name("gone.csv")):
        ran = run(command, path, "--json", "--progress", "json")
        events = [json.loads(line) for line in ran.err.splitlines()]
        assert events
        assert all("event" in event for event in events)
        assert ("error" in events[-1]) == ("error" in ran.json)


# An unknown name is compared with those of all systems, which takes seconds.
@pytest.mark.full
@pytest.mark.parametrize("crs", first_in_default_tier(["EPSG:4326", "no such place"]))
@pytest.mark.parametrize(
    "words",
    [
        ["convert", "{model}", "{out}.ply"],
        ["dem", "{model}", "-o", "{out}.tif"],
        ["section", "{model}", "--plane", "0/90", "--through", "1,1,1", "-o", "{out}.csv"],
        ["register", "-", "--scale", "0,0,0,1,0,0,5"],
        ["project", "{project}", "add-model", "{model}"],
        ["reconstruct", "{photos}", "-o", "{out}"],
    ],
    ids=lambda words: " ".join(words[:1]),
)
def test_invalid_crs_error_names_crs_option(
    run, write, tmp_path: Path, words: list[str], crs: str
) -> None:
    with vs.Project.create(tmp_path / "p.vom") as project:
        project.save()
    places = {
        "model": write("v 0 0 0\nv 9 0 1\nv 0 9 2\nv 9 9 3\nf 1 2 3\nf 2 4 3\n", "a.obj"),
        "out": tmp_path / "out",
        "project": tmp_path / "p.vom",
        "photos": vs.sample("photos"),
    }
    ran = run(*(word.format(**places) for word in words), "--crs", crs, "--json")
    assert ran.code == 2
    code = "frame.not-projected" if crs == "EPSG:4326" else "frame.unknown-crs"
    assert (ran.json["error"]["code"], ran.json["error"]["field"]) == (code, "--crs")


@pytest.mark.parametrize(
    "words",
    [["--method", "PCA"], ["--method", "Regression", "--axis", "Z"], ["--profile", "TextBook"]],
)
def test_choices_are_case_insensitive(run, write, words: list[str]) -> None:
    path = write(POINTS)
    small = [word.lower() if not word.startswith("-") else word for word in words]
    assert run("fit", path, *words, "--json").json == run("fit", path, *small, "--json").json


def test_dash_is_refused_as_output(
    run, write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    ran = run("fit", write(POINTS), "-o", "-", "--json")
    assert ran.code == 2
    assert ran.json["error"]["field"] == "--output"
    assert not (tmp_path / "-").exists()
