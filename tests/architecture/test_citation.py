"""The page on citing has the version, title and authors of `CITATION.cff`."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def test_the_page_on_citing_agrees_with_the_citation_file() -> None:
    citation = (ROOT / "CITATION.cff").read_text("utf-8")
    page = " ".join((ROOT / "docs" / "citing.md").read_text("utf-8").split())
    for field in ("version", "title", "license", "name"):
        match = re.search(rf"^ *-? *{field}: \"?(.+?)\"?$", citation, re.MULTILINE)
        assert match is not None
        assert match[1] in page, field
