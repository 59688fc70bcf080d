"""The page on the Python interface; tests/architecture/test_document_commands.py runs its code."""

from __future__ import annotations

from pathlib import Path

import vomstudio as vs

PAGE = Path(__file__).resolve().parents[2] / "docs" / "api.md"


def test_page_names_every_public_function() -> None:
    text = PAGE.read_text(encoding="utf-8")
    functions = [n for n in vs.__all__ if n[0].islower() and n not in ("errors",)]
    assert [name for name in functions if f"vs.{name}" not in text] == []
