"""Findings carry codes and values; their text is produced where a person reads it."""

from __future__ import annotations

import copy
import json
import pickle
import re
from dataclasses import asdict, dataclass
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from vomstudio.cli.common.output import to_json
from vomstudio.core.errors import InputError, from_dict
from vomstudio.core.finding_texts import SUBJECTS, TEXTS, get_texts
from vomstudio.core.findings import (
    Finding,
    cause_finding,
    to_finding,
    uncoded_finding,
    unique_findings,
)
from vomstudio.studio.jobs.serialisation import decode, encode

ROOT = Path(__file__).resolve().parents[2]
SENTENCE = re.compile(
    r"(?:[\"'“(]*[A-Z0-9{]|--|x and y |[a-z]+[_.][a-z]|vomstudio).*(?:[.?!…]['\"”’)]*|\})",
    re.DOTALL,
)


@dataclass
class Result:
    warnings: tuple[Finding, ...]


ASSUMED = Finding(
    "frame.assumed", file="a.obj", assumed=("z up", "no CRS"), up="z", unit="m", crs=None
)


def test_to_dict_has_code_severity_message_and_values() -> None:
    row = ASSUMED.to_dict()
    assert row["code"] == "frame.assumed"
    assert row["severity"] == "warning"
    assert {"up": "z", "unit": "m", "crs": None}.items() <= row.items()
    assert "a.obj" in row["message"]


def test_json_output_contains_findings_as_objects() -> None:
    answer = json.loads(to_json({"warnings": [ASSUMED], "n": 1}))
    assert answer["warnings"] == [ASSUMED.to_dict()]


@pytest.mark.parametrize(
    "finding", [ASSUMED, uncoded_finding("Plain."), uncoded_finding("Plain.").with_file("b")]
)
def test_finding_survives_pickling_and_serialisation(finding: Finding) -> None:
    assert pickle.loads(pickle.dumps(finding)) == finding
    assert copy.deepcopy(finding) == finding
    assert Finding.from_dict(json.loads(json.dumps(finding.to_dict()))) == finding
    sent = json.loads(json.dumps(encode(Result((finding, ASSUMED)))))
    assert decode(Result, sent).warnings == (finding, ASSUMED)
    assert asdict(Result((finding,)))["warnings"] == (finding,)


def test_a_finding_cannot_be_changed() -> None:
    with pytest.raises(AttributeError):
        ASSUMED.code = "other"  # type: ignore[misc]


def test_unknown_code_or_missing_value_raises_key_error() -> None:
    with pytest.raises(KeyError):
        Finding("no.such-code")
    with pytest.raises(KeyError):
        Finding("frame.assumed", file="a.obj")


def test_message_contains_file_only_once() -> None:
    assert ASSUMED.with_file("other.obj") is ASSUMED
    assert uncoded_finding("Plain.").with_file("b.obj").message == "b.obj: Plain."


def test_the_finding_of_an_error_states_its_file_line_and_field() -> None:
    error = InputError(Finding("number.invalid", text="1o"), file="a.csv", line=3, field="x")
    finding = to_finding(error)
    assert finding.values == {"file": "a.csv", "line": 3, "field": "x", "text": "1o"}
    assert finding.message == str(error)
    assert Finding.from_dict(finding.to_dict()) == finding
    assert cause_finding(error) == Finding("number.invalid", text="1o")
    argument = InputError(Finding("number.invalid", text="1o"), field="--x")
    assert to_finding(argument) == cause_finding(argument)


def test_finding_of_error_from_another_process_keeps_its_file() -> None:
    cause = Finding("registration.unknown-version", file="a.json", version="9", known=1)
    error = from_dict(InputError(cause, file="a.json").to_dict(), InputError.exit_code)
    assert cause_finding(error) == to_finding(error) == cause


def test_numbers_in_lists_survive_json() -> None:
    cause = Finding("path.invalid", reason="too far", limits_m=(1.0, float("inf")))
    assert Finding.from_dict(json.loads(json.dumps(cause.to_dict()))) == cause
    error = from_dict(json.loads(json.dumps(InputError(cause).to_dict())), InputError.exit_code)
    assert cause_finding(error) == cause


def test_duplicates_are_dropped_in_order() -> None:
    other = uncoded_finding("Plain.")
    assert unique_findings([other, ASSUMED, other, ASSUMED]) == (other, ASSUMED)


@pytest.mark.parametrize("subject", SUBJECTS, ids=lambda each: each.__name__.rpartition(".")[2])
def test_codes_and_texts_follow_the_rules_of_the_catalogue(subject: ModuleType) -> None:
    wrong = []
    for code in subject.TEXTS:
        if not re.fullmatch(r"[a-z]+(-[a-z]+)*(\.[a-z-]+)?", code):
            wrong.append(code)
        for text in get_texts(code):
            if len(re.sub(r"\{[^}]*\}", "", text).split()) > 25:
                wrong.append(f"{code} has more than 25 words")
            if code != "uncoded" and not SENTENCE.fullmatch(text):
                wrong.append(f"{code} is not a sentence: {text}")
    assert not wrong, "\n".join(wrong)


def test_each_code_has_one_subject_and_occurs_in_the_program() -> None:
    codes = [code for subject in SUBJECTS for code in subject.TEXTS]
    assert len(codes) == len(set(codes))
    program = "".join(
        path.read_text("utf-8")
        for path in (ROOT / "vomstudio").rglob("*.py")
        if "finding_texts" not in path.parts
    )
    used = {*re.findall(r'"([\w.-]+)(?=")', program), "uncoded"}
    assert [code for code in codes if code not in used] == []


def test_count_selects_singular_or_plural_text(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(TEXTS, "file.several", ("info", "{count} line.", "{count} lines."))
    assert [Finding("file.several", count=n).message for n in (1, 2)] == ["1 line.", "2 lines."]
    with pytest.raises(KeyError):
        Finding("file.several")


@pytest.mark.parametrize("spec", ["", ":g", ":.3g"])
def test_large_numbers_have_no_exponent(monkeypatch: pytest.MonkeyPatch, spec: str) -> None:
    monkeypatch.setitem(TEXTS, "file.deep", ("info", f"{{depth{spec}}} m deep."))
    texts = [Finding("file.deep", depth=depth).message for depth in (8132.0, 12.0, 4.5e7, 1e-9)]
    assert not any("e+" in text for text in texts)
    assert texts[1] == "12 m deep."
    assert texts[3] == "1e-09 m deep."
    for text, depth in zip(texts, (8132.0, 12.0, 4.5e7, 1e-9), strict=True):
        number = float(text.removesuffix(" m deep.").replace(",", ""))
        assert number == pytest.approx(depth, rel=0.005)


def test_values_are_json_serialisable() -> None:
    finding = Finding("uncoded", text="a", file=Path("b.obj"), n=np.int64(3), x=[np.float64(0.5)])
    assert json.loads(json.dumps(finding.values)) == {
        "text": "a",
        "file": "b.obj",
        "n": 3,
        "x": [0.5],
    }
