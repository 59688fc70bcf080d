"""What a user reads, walked through as the code says it: every string passes through `tr`, with
named placeholders that are filled, and every message is a sentence."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from string import Formatter

import pytest

from vomstudio.core.finding_texts import TEXTS
from vomstudio.core.findings import placeholders

ROOT = Path(__file__).resolve().parents[1]
ERRORS = {
    *("VomError", "UsageError", "InputError", "TargetError", "GeometryError"),
    *("DocumentError", "WorkerError", "Cancelled"),
}
SHOWN = {
    *("setText", "setToolTip", "setWindowTitle", "setTitle", "setPlaceholderText", "setStatusTip"),
    *("setWhatsThis", "setLabelText", "setInformativeText", "setSpecialValueText", "setItemText"),
    *("addMenu", "addTab", "addRow", "addAction", "showMessage", "setTabText", "setTabToolTip"),
    *("setAccessibleName", "setHeaderLabels", "setHorizontalHeaderLabels"),
    *("QLabel", "QPushButton", "QCheckBox", "QRadioButton", "QGroupBox", "QAction", "QDockWidget"),
}
"""Calls whose texts stand on the screen."""
MARKERS = ("tr", "tr_n", "to_translate", "to_translate_n", "_")
WORD = re.compile(r"[A-Za-z]{3}")
BEGINS = re.compile(r"[\"“‘'(<]*(?:[A-Z0-9]|\{)|--|\.|[a-z]+[_.][a-z]|EPSG|vomstudio")
"""A capital, a number, what is filled in, an option, or a name that is written so."""
ENDS = re.compile(r"[.?!…]['\"”’)]*$|[.?!]\s*\{\w+\}$|\}$")


@dataclass(frozen=True)
class Call:
    """A call in the code, with the functions that it lies in."""

    file: str
    node: ast.Call
    inside: bool

    @property
    def place(self) -> str:
        return f"{self.file}:{self.node.lineno}"

    @property
    def name(self) -> str:
        function = self.node.func
        if isinstance(function, ast.Name):
            return function.id
        return function.attr if isinstance(function, ast.Attribute) else ""


@cache
def calls() -> tuple[Call, ...]:
    found = []
    for path in sorted((ROOT / "vomstudio").rglob("*.py")):
        file = path.relative_to(ROOT).as_posix()
        if file != "vomstudio/core/words.py":
            found += list(_calls(ast.parse(path.read_text("utf-8")), file, False))
    return tuple(found)


def _calls(node: ast.AST, file: str, inside: bool) -> Iterator[Call]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Call):
            yield Call(file, child, inside)
        within = inside or isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
        yield from _calls(child, file, within)


def texts(node: ast.expr) -> list[str] | None:
    """The constant texts that an expression may be, or None where it is something else."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return [node.value]
    if isinstance(node, ast.JoinedStr):
        return ["".join(str(p.value) for p in node.values if isinstance(p, ast.Constant))]
    if isinstance(node, ast.IfExp):
        either = [texts(node.body) or [], texts(node.orelse) or []]
        return either[0] + either[1] or None
    if isinstance(node, ast.BinOp):
        return (texts(node.left) or []) + (texts(node.right) or []) or None
    return None


def fields(message: str) -> set[str]:
    return {name for _, name, _, _ in Formatter().parse(message) if name is not None}


def messages() -> Iterator[tuple[Call, str]]:
    for call in calls():
        if call.name in MARKERS:
            for argument in call.node.args[: 2 if call.name.endswith("_n") else 1]:
                yield from ((call, text) for text in texts(argument) or [])


def test_code_walk_finds_the_strings() -> None:
    assert len(list(messages())) > 1000


def test_translatable_messages_are_single_literals() -> None:
    """A message made of parts, or filled before it is translated, is in no catalogue."""
    wrong = []
    for call in calls():
        if call.name in MARKERS and call.node.args:
            for argument in call.node.args[: 2 if call.name.endswith("_n") else 1]:
                if isinstance(argument, ast.JoinedStr | ast.BinOp):
                    wrong.append(call.place)
    assert not wrong


def test_placeholders_have_names_and_values() -> None:
    wrong = []
    for call in calls():
        if call.name not in ("tr", "tr_n"):
            continue
        given = {k.arg for k in call.node.keywords}
        for argument in call.node.args[: 2 if call.name.endswith("_n") else 1]:
            for text in texts(argument) or []:
                if call.name == "tr" and not given:
                    continue
                known = given | ({"count"} if call.name == "tr_n" else set())
                if None not in given and not fields(text) <= known:
                    wrong.append(f"{call.place}: {fields(text) ^ known}")
                if call.name == "tr" and None not in given and given - fields(text):
                    wrong.append(f"{call.place}: {given - fields(text)} is nowhere")
                if not all(name.isidentifier() for name in fields(text)):
                    wrong.append(f"{call.place}: {text}")
    assert not wrong


def test_findings_use_catalogue_codes_and_supply_their_values() -> None:
    wrong = []
    for call in calls():
        if call.name != "Finding" or not isinstance(call.node.args[0], ast.Constant):
            continue
        code = str(call.node.args[0].value)
        names = {each.arg for each in call.node.keywords}
        if code not in TEXTS:
            wrong.append(f"{call.place}: {code} is not in the catalogue")
        elif None not in names and (missing := placeholders(code) - names):
            wrong.append(f"{call.place}: {code} needs {sorted(missing)}")
    assert not wrong, "\n".join(wrong)


def test_strings_are_not_translated_at_import_time() -> None:
    wrong = [c.place for c in calls() if c.name in ("tr", "tr_n") and not c.inside]
    assert not wrong


def test_errors_are_translated() -> None:
    wrong = []
    for call in calls():
        if call.name in ERRORS and call.node.args:
            said = [text for text in texts(call.node.args[0]) or [] if WORD.search(text)]
            wrong += [f"{call.place}: {text}" for text in said]
    assert not wrong, "\n".join(wrong)


def test_messages_of_errors_are_sentences() -> None:
    wrong = []
    for call in calls():
        if call.name not in ERRORS or not call.node.args:
            continue
        cause = call.node.args[0]
        if isinstance(cause, ast.Call) and getattr(cause.func, "id", "") == "Finding":
            # Its values may be translated words; the sentence is in the catalogue.
            continue
        inner = [n for n in ast.walk(cause) if isinstance(n, ast.Call)]
        for each in inner:
            if not (isinstance(each.func, ast.Name) and each.func.id in ("tr", "tr_n")):
                continue
            for argument in each.args[: 2 if each.func.id == "tr_n" else 1]:
                for text in texts(argument) or []:
                    if not BEGINS.match(text) or not ENDS.search(text):
                        wrong.append(f"{call.place}: {text}")
    assert not wrong, "\n".join(wrong)


def test_displayed_texts_are_translated() -> None:
    wrong = []
    for call in calls():
        if (call.name in SHOWN and "/ui/" in call.file) or "/rendering/qt/" in call.file:
            if call.name not in SHOWN:
                continue
            for argument in call.node.args:
                said = [text for text in texts(argument) or [] if WORD.search(text)]
                wrong += [f"{call.place}: {text}" for text in said]
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("word", ["hardly at all", "nothing over to", "miss their place"])
def test_rejected_phrases_are_not_used_in_messages(word: str) -> None:
    assert not [call.place for call, text in messages() if word in text]


MAX_MESSAGE_WORDS, MAX_TOOLTIP_WORDS = 25, 12
TOOLTIPS = {"tip", "setToolTip", "setStatusTip", "setTabToolTip"}
LONGER_TEXTS = {
    "vomstudio/ui/commands/help.py": "the list of mouse gestures",
    "vomstudio/ui/panels/features/feature_filter.py": "the list of filter conditions",
}
"""Texts that are lists, with their reason."""


def word_count(text: str) -> int:
    """Number of words of a text, without the values that are inserted."""
    return len(re.sub(r"\{.*?\}", " ", text).split())


@pytest.mark.parametrize("code", sorted(TEXTS))
def test_findings_do_not_exceed_the_message_length(code: str) -> None:
    assert all(word_count(text) <= MAX_MESSAGE_WORDS for text in TEXTS[code][1:])


def test_panel_and_dialog_texts_do_not_exceed_the_message_length() -> None:
    wrong = [
        f"{call.place}: {text}"
        for call, text in messages()
        if call.file.startswith(("vomstudio/ui/", "vomstudio/studio/"))
        and call.file not in LONGER_TEXTS
        and word_count(text) > MAX_MESSAGE_WORDS
    ]
    assert not wrong, "\n".join(wrong)


def test_tooltips_do_not_exceed_their_maximum_length() -> None:
    wrong = []
    for call in calls():
        tips = [each.value for each in call.node.keywords if each.arg == "tip"]
        tips += call.node.args if call.name in TOOLTIPS else []
        for tip in tips:
            for node in ast.walk(tip):
                if isinstance(node, ast.Call) and getattr(node.func, "id", "") in MARKERS:
                    for text in texts(node.args[0]) or []:
                        if word_count(text) > MAX_TOOLTIP_WORDS:
                            wrong.append(f"{call.place}: {text}")
    assert not wrong, "\n".join(wrong)


MAX_LABEL_WORDS = 3
LABELS = {
    *("QPushButton", "QCheckBox", "QRadioButton", "QGroupBox"),
    *("addRow", "addTab", "addAction", "addMenu"),
}
LONGER_LABELS = {
    "vomstudio/ui/commands/survey.py": "the first entry of the menu File",
    "vomstudio/ui/dialogs/frame_dialog.py": "choices with their explanation",
}
"""Files with longer labels, with the reason."""


def test_labels_do_not_exceed_their_maximum_length() -> None:
    wrong = []
    for call in calls():
        if not call.file.startswith("vomstudio/ui/") or call.file in LONGER_LABELS:
            continue
        arguments = call.node.args[:1] if call.name in LABELS else []
        arguments += call.node.args[1:2] if call.name == "Command" else []
        for label in arguments:
            if isinstance(label, ast.Call) and getattr(label.func, "id", "") in MARKERS:
                for text in texts(label.args[0]) or []:
                    if word_count(text) > MAX_LABEL_WORDS:
                        wrong.append(f"{call.place}: {text}")
    assert not wrong, "\n".join(wrong)
