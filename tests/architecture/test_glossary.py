"""The glossary has each term once, in alphabetical order, with a short explanation."""

from __future__ import annotations

import re
from pathlib import Path

PAGE = Path(__file__).resolve().parents[2] / "docs" / "glossary.md"
MAX_SENTENCES = 3


def test_terms_are_in_alphabetical_order_with_short_explanations() -> None:
    rows = re.findall(r"^\| (?!term \||-)(.+?) \| (.+) \|$", PAGE.read_text("utf-8"), re.MULTILINE)
    assert len(rows) > 200
    terms = [re.sub(r"[^a-z0-9 ]", "", term.lower().replace("-", " ")) for term, _ in rows]
    assert terms == sorted(set(terms))
    long = [term for term, text in rows if len(re.findall(r"[.?!](?= |$)", text)) > MAX_SENTENCES]
    assert long == []
