"""The records with their indices say what a look at every record says, after any edits."""

import re
from dataclasses import replace

from hypothesis import given
from hypothesis import strategies as st

from tests.project.test_kinds import ONE_OF_EACH, RECORDS_OF_ALL
from vomstudio.project.edits import NextNames
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.record_map import RecordMap, highest_number
from vomstudio.project.records import DEFAULT_TYPES, Feature, FeatureType, Model, TypedFeature

CLASSES = (Feature, TypedFeature, Trace, Model, FeatureType)
NAMES = st.sampled_from(["B1", "B02", "B10", "B7a", "B", "J3", "", "12", "B٣", "Bed 5"])
IDS = st.sampled_from(["t1", "p1", "l1", "new1", "new2"])
MAKERS = st.sampled_from(["trace", "patch", "lineation", "reading", "type", None])
CHANGES = st.lists(st.dictionaries(IDS, st.tuples(MAKERS, NAMES), min_size=1), max_size=12)


def made(id_: str, what: str | None, name: str):
    if what is None:
        return None
    record = DEFAULT_TYPES[0] if what == "type" else ONE_OF_EACH[what]
    return replace(record, id=id_, name=name)


def scanned(records, prefix: str) -> int:
    found = [
        int(match[1])
        for r in records.values()
        if isinstance(r, Feature) and (match := re.fullmatch(rf"{prefix}(\d+)", r.name))
    ]
    return max(found, default=0)


def numbers_of(records, prefix: str) -> int:
    return highest_number(records, prefix)


@given(CHANGES, st.booleans())
def test_indices_match_a_full_scan_after_any_edits(changes, asked_before):
    plain = dict(RECORDS_OF_ALL)
    records = RecordMap(plain)
    for edit in changes:
        if asked_before:
            for cls in CLASSES:
                records.of(cls)
            numbers_of(records, "B")
            records.cached(len)
        after = {id_: made(id_, *what) for id_, what in edit.items()}
        records.apply(after)
        for id_, record in after.items():
            if record is None:
                plain.pop(id_, None)
            else:
                plain[id_] = record
        assert list(records.items()) == list(plain.items())
        assert records == plain
        for cls in CLASSES:
            assert records.of(cls) == [r for r in plain.values() if isinstance(r, cls)]
        for prefix in ("B", "J", "1", ""):
            assert (
                numbers_of(records, prefix) == scanned(plain, prefix) == numbers_of(plain, prefix)
            )
        assert records.cached(len) == len(plain)


def test_next_name_skips_names_reserved_by_the_same_edit():
    bedding = DEFAULT_TYPES[0]
    records = RecordMap(RECORDS_OF_ALL)
    taken = made("new1", "trace", f"{bedding.name[0]}41")
    names = NextNames(records)
    names.reserve(taken)
    assert names.propose_name(bedding) == f"{bedding.name[0]}42"


def test_returned_lists_are_copies_of_the_index():
    records = RecordMap(RECORDS_OF_ALL)
    records.of(Feature).clear()
    assert records.of(Feature)
