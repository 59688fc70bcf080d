"""Names in files of other people steer no terminal."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from vomstudio.cli import main
from vomstudio.cli.common.output import escape_for_terminal, to_json

NAME = "B\x1b]0;mine\x07\x9b31m\u202egnp.\u2066"
IN_A_TABLE = "B\x9b31m\u202egnp.\u2066"
"""A table with other control characters is none."""
STEERING = set("\x1b\x07\x9b\x7f\r\u202e\u2066")


def table(folder: Path) -> Path:
    path = folder / "planes.csv"
    rows = [f"{IN_A_TABLE},{90 + k},{30 + k % 3}" for k in range(6)]
    path.write_text("set,dip_direction,dip\n" + "\n".join(rows) + "\n", "utf-8")
    return path


def test_control_characters_in_table_are_escaped(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert main(["stats", str(table(tmp_path)), "--by", "set"]) == 0
    said = "".join(capfd.readouterr())
    assert "B\\u009b31m\\u202egnp" in said
    assert not STEERING & set(said)


def test_control_characters_in_error_are_escaped(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / f"{NAME}.obj"
    path.write_text("nothing")
    assert main(["info", str(path)]) == 2
    said = "".join(capfd.readouterr())
    assert "\\u001b]0;mine" in said
    assert not STEERING & set(said)


def test_json_output_escapes_control_characters_losslessly(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert main(["stats", str(table(tmp_path)), "--by", "set", "--json"]) == 0
    said = capfd.readouterr().out
    assert not STEERING & set(said)
    assert IN_A_TABLE in words_in(json.loads(said))


def words_in(value: object) -> str:
    if isinstance(value, dict):
        return " ".join(f"{key} {words_in(each)}" for key, each in value.items())
    if isinstance(value, list):
        return " ".join(map(words_in, value))
    return str(value)


def test_ordinary_unicode_text_is_unchanged() -> None:
    words = "Störung 60°, ± 3\tשכבה أساس 地層\n"
    assert escape_for_terminal(words) == words
    assert json.loads(to_json({"name": NAME})) == {"name": NAME}
