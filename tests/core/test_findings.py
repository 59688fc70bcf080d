"""Findings carry codes and values; their text is produced where a person reads it."""

from __future__ import annotations

import copy
import json
import pickle
import re
from dataclasses import asdict, dataclass

import pytest

from vomstudio.cli.common.output import to_json
from vomstudio.core.finding_texts import TEXTS
from vomstudio.core.findings import Finding, as_finding, uncoded, without_repeats
from vomstudio.jobs.serialisation import decode, encode


@dataclass
class Result:
    warnings: tuple[Finding | str, ...]


ASSUMED = Finding("frame.assumed", file="a.obj", up="z", unit="m", crs=None)


def test_json_has_code_severity_message_and_values() -> None:
    row = ASSUMED.to_dict()
    assert row["code"] == "frame.assumed"
    assert row["severity"] == "warning"
    assert {"up": "z", "unit": "m", "crs": None}.items() <= row.items()
    assert "a.obj" in row["message"]


def test_an_answer_prints_findings_and_sentences_as_objects() -> None:
    answer = json.loads(to_json({"warnings": [ASSUMED, "Plain."], "n": 1}))
    first, second = answer["warnings"]
    assert first == ASSUMED.to_dict()
    assert second == {"code": "uncoded", "severity": "warning", "message": "Plain."}


@pytest.mark.parametrize("finding", [ASSUMED, uncoded("Plain."), uncoded("Plain.").of_file("b")])
def test_a_finding_survives_every_way_between_processes(finding: Finding) -> None:
    assert pickle.loads(pickle.dumps(finding)) == finding
    assert copy.deepcopy(finding) == finding
    assert Finding.from_dict(json.loads(json.dumps(finding.to_dict()))) == finding
    sent = json.loads(json.dumps(encode(Result((finding, "Plain.")))))
    assert decode(Result, sent).warnings == (finding, "Plain.")
    assert asdict(Result((finding,)))["warnings"] == (finding,)


def test_a_finding_cannot_be_changed() -> None:
    with pytest.raises(AttributeError):
        ASSUMED.code = "other"  # type: ignore[misc]


def test_an_unknown_code_or_a_missing_value_is_an_error_of_the_programmer() -> None:
    with pytest.raises(KeyError):
        Finding("no.such-code")
    with pytest.raises(KeyError):
        Finding("frame.assumed", file="a.obj")


def test_a_finding_names_its_file_once() -> None:
    assert ASSUMED.of_file("other.obj") is ASSUMED
    assert uncoded("Plain.").of_file("b.obj").message == "b.obj: Plain."


def test_repeats_are_dropped_in_order() -> None:
    assert without_repeats(["a", ASSUMED, "a", ASSUMED]) == ("a", ASSUMED)
    assert as_finding("a") == uncoded("a")


@pytest.mark.parametrize("code", TEXTS)
def test_codes_and_texts_follow_the_rules_of_the_catalogue(code: str) -> None:
    assert re.fullmatch(r"[a-z]+(\.[a-z-]+)?", code)
    _, text = TEXTS[code]
    words = re.sub(r"\{[^}]*\}", "", text).split()
    assert len(words) <= 25
