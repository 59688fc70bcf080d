"""Mutants are one slip each; those that a test sees die, the others are told."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.mutants.__main__ import ROOT, equivalent, summary
from tests.mutants.draw import Mutant, mutant_of, places_of


def all_of(text: str) -> list[Mutant]:
    made = [mutant_of("a.py", text, change) for place in places_of(text) for change in place]
    return [mutant for mutant in made if mutant is not None]


def after(text: str) -> set[str]:
    return {mutant.after for mutant in all_of(text)}


@pytest.mark.parametrize(
    ("line", "wanted"),
    [
        ("x = a < b", {"x = a <= b", "x = a >= b"}),
        ("x = (a) is not (b)", {"x = (a) is (b)"}),
        ("x = a not in b", {"x = a in b"}),
        ("x = a - b", {"x = a + b"}),
        ("x = a and not b", {"x = a or not b", "x = a and (b)"}),
        ("x += a", {"x -= a", "pass"}),
        ("x = 3", {"x = 4", "x = (2)"}),
        ("x = 0.5", {"x = (1.0)", "x = (0.25)", "x = (-0.5)"}),
        ("x = 1e-5", {"x = (0.01)", "x = (1e-08)", "x = (-1e-05)"}),
        ("x = True", {"x = False"}),
        ("x = -a", {"x = (a)"}),
        ("x = f(a, b)", {"x = f(b, a)"}),
        ("x = sin(a)", {"x = cos(a)"}),
        ("x[a] = b", {"pass"}),
        ("f(a)", {"pass"}),
        ("x = a if b else c", {"x = a if (not b) else c"}),
    ],
)
def test_each_line_yields_the_expected_mutants(line: str, wanted: set[str]) -> None:
    assert after(line) == wanted


def test_return_values_defaults_and_raises_are_mutated() -> None:
    text = 'def f(a, b=2):\n    if a:\n        raise ValueError(f"{a + 1}")\n    return a, b\n'
    assert after(text) == {
        "def f(a, b=3):",
        "def f(a, b=(1)):",
        "if (not a):",
        "pass",
        "return b, a",
    }


def test_removed_single_word_statement_is_identified_by_the_line_above() -> None:
    text = "for a in b:\n    if c(a):\n        continue\n    if d(a):\n        continue\n"
    removed = [m for m in all_of(text) if m.kind == "statement removed"]
    assert [m.before for m in removed] == ["if c(a): continue", "if d(a): continue"]
    assert [m.after for m in removed] == ["if c(a): pass", "if d(a): pass"]


@pytest.mark.parametrize(
    "line",
    [
        "x: int | None",
        "def f(a: Literal[1, 2] = b) -> A[0]: ...",
        "@cache(1)\ndef f(): ...",
        "x = zip(a, strict=True)",
        "x = minimum(a, b)",
        "import a",
        'x = f"{a + 1}"',
        "x = a.reshape(-1, 3)",
    ],
)
def test_code_without_effect_on_results_is_not_mutated(line: str) -> None:
    assert after(line) <= {"x = maximum(a, b)"}


def test_mutation_offsets_are_correct_beside_multibyte_characters() -> None:
    text = '"""Größe"""\nx = "°", a < b  # <\ny = (\n    a\n    + b\n)\n'
    made = all_of(text)
    assert [m.line for m in made] == [2, 2, 5]
    assert made[0].text == text.replace("a < b", "a <= b")
    assert (made[2].before, made[2].after) == ("+ b", "- b")


def test_equivalent_mutants_exist_in_the_source_and_have_a_reason() -> None:
    """An entry whose line is gone would hide nothing, and say what is no longer so."""
    for (file, before, _), reason in equivalent().items():
        text = " ".join((ROOT / file).read_text().split())
        assert " ".join(before.split()) in text, (file, before)
        assert len(reason.split()) > 3, (file, before)


def test_timeouts_count_as_killed_and_equivalent_mutants_are_ignored() -> None:
    states = ["killed"] * 5 + ["timeout", "survived", "survived", "equivalent"]
    assert summary([{"state": state} for state in states]).endswith(
        "75 % of those that matter died"
    )


SMALL = """
def half(x):
    if x < 0:
        raise ValueError(x)
    return x / 2


def unseen(x):
    return x + 1


def endless(n):
    while n > 0:
        n = n - 1
    return n
"""
TESTS = """
import pytest
from vomstudio.small import endless, half


def test_half():
    assert half(4) == 2
    with pytest.raises(ValueError):
        half(-1)
    assert endless(3) == 0
"""


@pytest.mark.full
def test_detected_mutants_are_killed_and_the_file_is_restored(tmp_path: Path) -> None:
    tree, scratch = tmp_path / "tree", tmp_path / "scratch"
    for folder in (tree / "vomstudio", tree / "tests", scratch):
        folder.mkdir(parents=True)
    (tree / "pyproject.toml").write_text(
        '[tool.pytest.ini_options]\naddopts = "--import-mode=importlib"\npythonpath = ["."]\n'
    )
    small = tree / "vomstudio" / "small.py"
    small.write_text(SMALL)
    (tree / "vomstudio" / "__init__.py").write_text("")
    (tree / "vomstudio" / "other.py").write_text("")
    (tree / "tests" / "test_small.py").write_text(TESTS)
    name = "vomstudio/small.py"
    asked: list[dict[str, object]] = [{"times": None}]
    for old, new in (
        ("x / 2", "x * 2"),
        ("x < 0", "x > 0"),
        ("x < 0", "x <= 0"),
        ("x + 1", "x - 1"),
        ("n - 1", "n + 1"),
    ):
        # The last one never ends.
        limit = 3.0 if new == "n + 1" else 20.0
        asked.append({"file": name, "text": SMALL.replace(old, new), "limit_s": limit})
    asked.append({"file": "vomstudio/other.py", "text": "x = 1", "limit_s": 20.0})
    run = subprocess.run(
        [sys.executable, "-m", "tests.mutants.nursery", "tests", str(scratch), "1e9"],
        cwd=tree,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        text=True,
        check=True,
        input="".join(json.dumps(each) + "\n" for each in asked),
        stdout=subprocess.PIPE,
    )
    answers = [json.loads(line) for line in run.stdout.splitlines()]
    states = [answer["state"] for answer in answers]
    assert states == ["survived", "killed", "killed", "survived", "survived", "timeout", "survived"]
    assert answers[1]["by"] == "tests/test_small.py::test_half"
    assert list(answers[0]["times"]) == ["tests/test_small.py::test_half"]
    assert small.read_text() == SMALL
