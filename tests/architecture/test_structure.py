"""The house keeps its measures: small modules, classes and functions, and no circles.

`python -m tests.architecture.structure` prints the numbers.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.architecture import structure
from tests.architecture.structure import Part, Structure, measure, over


@pytest.fixture(scope="module")
def found() -> Structure:
    return measure()


def told(parts: list[Part]) -> str:
    return "\n" + "\n".join(map(str, parts))


def test_at_most_three_modules_are_long_and_say_why(found: Structure) -> None:
    long = over(found.modules, structure.MODULE_LINES)
    unexplained = [module for module in long if structure.reason_of(module) is None]
    assert not unexplained, told(unexplained)
    assert len(long) <= structure.LONG_MODULES, told(long)


def test_no_folder_holds_more_modules_than_can_be_kept_in_mind(found: Structure) -> None:
    full = over(found.folders, structure.MODULES_IN_A_FOLDER)
    assert not full, told(full)


def test_no_class_is_over_its_limit(found: Structure) -> None:
    long = over(found.classes, structure.CLASS_LINES)
    assert not long, told(long)


def test_no_function_is_over_its_limit(found: Structure) -> None:
    long = over(found.functions, structure.FUNCTION_LINES)
    assert not long, told(long)


def test_no_siblings_import_each_other_in_a_circle() -> None:
    found = structure.circles()
    assert not found, "\n" + "\n".join(found)


def test_what_is_too_large_is_found_wherever_it_stands(tmp_path: Path) -> None:
    folder = tmp_path / "vomstudio" / "room"
    folder.mkdir(parents=True)
    (folder / "__init__.py").write_text("")
    body = "    pass\n" * 81
    (folder / "long.py").write_text(
        '"""A room.\n\nLonger than other modules, since\nits table is one.\n"""\n'
        f"class A:\n    def outer(self):\n        if True:\n            def inner():\n"
        f"{body.replace('    pass', '                pass')}" + "x = 1\n" * 500
    )
    for number in range(30):
        (folder / f"module{number}.py").write_text("")
    made = measure(tmp_path)
    (long,) = over(made.modules, structure.MODULE_LINES)
    assert long.name == "vomstudio/room/long.py"
    assert structure.reason_of(long, tmp_path) == "its table is one."
    assert [part.name for part in over(made.functions, structure.FUNCTION_LINES)] == [
        "vomstudio/room/long.py: A.outer",
        "vomstudio/room/long.py: A.outer.inner",
    ]
    assert over(made.folders, structure.MODULES_IN_A_FOLDER) == [Part("vomstudio/room", 31)]
