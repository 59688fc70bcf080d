"""An attitude and its error are one text, which one function makes."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import vomstudio
from vomstudio.geology.notation import format_attitude, format_error_deg, format_line, format_plane
from vomstudio.geology.orientation import Line, Plane
from vomstudio.project.measurement import Measurement

FOLDER = Path(vomstudio.__file__).parent
ATTITUDE_AND_ERROR = re.compile(r"\{[^{}:]*\}[^{}±]{0,6}±\s*\{[^{}]*\}\s*(°|deg)")
"""A text, then ± an angle; a number before ± has a format of its own."""
FORMATTERS = {"degrees", "number", "figures"}
OTHER_FIGURES = {
    "cli/stats.py",
    "registration/summary.py",
    "photogrammetry/survey/survey_resolution.py",
}
"""alpha95 and the registration of means, axes of rotations, sizes of planes."""


def texts_in(tree: ast.AST) -> Iterator[str]:
    """Texts of a module, f-strings with their placeholders."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value
        elif isinstance(node, ast.JoinedStr):
            yield "".join(
                part.value if isinstance(part, ast.Constant) else "{" + _spec(part) + "}"
                for part in node.values
            )


def _spec(part: ast.expr) -> str:
    return ":" if isinstance(part, ast.FormattedValue) and part.format_spec is not None else ""


def formats_the_error(node: ast.AST) -> bool:
    """Whether a node makes text of a total error by itself."""
    if isinstance(node, ast.Call):
        name = getattr(node.func, "attr", getattr(node.func, "id", ""))
        parts = node.args if name in FORMATTERS else []
    elif isinstance(node, ast.FormattedValue):
        parts = [node.value]
    else:
        return False
    return any(
        (isinstance(part, ast.Attribute) and part.attr == "total95_deg")
        or (
            isinstance(part, ast.Subscript)
            and isinstance(part.slice, ast.Constant)
            and part.slice.value == "total95_deg"
        )
        for part in parts
    )


def test_only_format_attitude_joins_attitude_and_error() -> None:
    found = []
    for path in sorted(FOLDER.rglob("*.py")):
        name = path.relative_to(FOLDER).as_posix()
        source = path.read_text(encoding="utf-8")
        if name in OTHER_FIGURES or not ("±" in source or "total95_deg" in source):
            continue
        tree = ast.parse(source)
        found += [f"{name}: {text}" for text in texts_in(tree) if ATTITUDE_AND_ERROR.search(text)]
        found += [
            f"{name}:{getattr(node, 'lineno', 0)}"
            for node in ast.walk(tree)
            if formats_the_error(node)
        ]
    assert found == [], "use format_attitude of vomstudio/geology/notation.py"


@pytest.mark.parametrize(
    "text",
    [
        'f"{plane} ± {error:.1f}°"',
        'tr("bed {bed} ± {error:.1f}° (95 %)")',
        "degrees(m.total95_deg)",
        'f"{row.total95_deg:.2f}"',
        'text_tables.number(row["total95_deg"], 2)',
    ],
)
def test_joined_attitudes_and_errors_are_detected(text: str) -> None:
    tree = ast.parse(text)
    assert any(map(ATTITUDE_AND_ERROR.search, texts_in(tree))) or any(
        map(formats_the_error, ast.walk(tree))
    )


@pytest.mark.parametrize(
    ("error", "plane", "line"),
    [
        (2.4, "318/39 ± 2.4°", "052/07 ± 2.4°"),
        (0.43, "318.2/38.9 ± 0.43°", "052.1/07.3 ± 0.43°"),
        (0.04, "318.24/38.94 ± 0.04°", "052.06/07.27 ± 0.04°"),
        (13.7, "318/39 ± 14°", "052/07 ± 14°"),
        (90.0, "318/39 ± 90°", "052/07 ± 90°"),
        (None, "318/39", "052/07"),
    ],
)
def test_number_of_decimals_depends_on_error(error: float | None, plane: str, line: str) -> None:
    assert format_attitude(Plane(318.24, 38.94), error) == plane
    assert format_attitude(Line(52.06, 7.27), error) == line


def test_attitude_has_at_most_one_decimal_more_than_error() -> None:
    for error in (0.011, 0.0994, 0.0996, 0.2, 0.94, 0.994, 0.996, 1.0, 9.94, 9.96, 44.0):
        attitude, stated = format_attitude(Plane(0.0, 45.0), error).split(" ± ")
        decimals = len(attitude.partition("/")[2].partition(".")[2])
        assert 10.0**-decimals <= 10.0 * error
        assert float(stated.removesuffix("°")) == pytest.approx(error, rel=0.06, abs=0.006)


def test_measurement_attitude_is_formatted() -> None:
    measured = Measurement(
        points=[],
        resolution_m=None,
        outcrop_normal=None,
        fit=None,
        verdict=None,
        problem=None,
        plane=Plane(120.0, 30.0),
        max_confidence95_deg=3.2,
    )  # type: ignore[arg-type]
    assert measured.attitude() == f"{format_plane(Plane(120.0, 30.0))} ± {format_error_deg(3.2)}"
    assert measured.attitude("strike/dip") == "030/30 RHR ± 3.2°"
    assert measured.attitude("strike/dip", omit_hand_rule=True) == "030/30 ± 3.2°"
    assert format_line(Line(3.0, 4.0)) == format_attitude(Line(3.0, 4.0), None)
