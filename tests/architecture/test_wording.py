"""Names and docstrings of the program do not become less idiomatic."""

from __future__ import annotations

import json

import pytest

from tests.architecture.counts import ROOT, assertions_on_wording, sources
from tests.architecture.wording import CEILINGS, counts, is_unidiomatic, places, unidiomatic

MAX_ASSERTIONS_ON_WORDING = 60


def test_no_package_has_more_unidiomatic_names_and_docstrings_than_before() -> None:
    ceilings = json.loads(CEILINGS.read_text())
    found = counts()
    assert found.keys() == ceilings.keys(), "run python -m tests.architecture.wording"
    above = [package for package in found if found[package] > ceilings[package]]
    listed = [place for package in above for place in list(places(package))[:20]]
    assert not above, "\n".join(listed)


@pytest.mark.parametrize("name", ["said", "_kept", "of_model", "by_kind", "_MOST_CELLS", "FEWEST"])
def test_unidiomatic_names_are_recognised(name: str) -> None:
    assert is_unidiomatic(name)


@pytest.mark.parametrize(
    "name", ["residuals", "from_dict", "MAX_CELLS", "ordinal", "founded", "as_", "office_hours"]
)
def test_plain_names_are_accepted(name: str) -> None:
    assert not is_unidiomatic(name)


def test_names_and_docstrings_are_collected_from_all_definitions() -> None:
    source = '''"""What a module says."""
def of_x(given): "Of a thing."
class Told: pass
self.kept = found = 1
'''
    texts = {text for _, text in unidiomatic(source)}
    assert texts == {"What a module says.", "kept", "found", "of_x", "Of a thing.", "given"}


@pytest.mark.full
def test_tests_rarely_assert_wording_of_messages() -> None:
    found = [
        f"{path.relative_to(ROOT)}:{line}"
        for path in sources("tests")
        for line in assertions_on_wording(path.read_text("utf-8"))
    ]
    assert len(found) <= MAX_ASSERTIONS_ON_WORDING, "\n".join(found)
