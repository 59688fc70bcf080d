"""The table of all findings in `docs/cli.md`; ``python -m tests.architecture.finding_codes`` renews
it."""

from __future__ import annotations

from pathlib import Path

from vomstudio.core.finding_texts import TEXTS, get_texts

PAGE = Path(__file__).resolve().parents[2] / "docs" / "cli.md"
HEADING = "### Codes of findings\n"
END = "\n### "


def table() -> str:
    """Return the rows: code, severity and text of every finding."""
    rows = ["| code | severity | text |", "|---|---|---|"]
    for code, (severity, *_) in sorted(TEXTS.items()):
        text = get_texts(code)[-1]
        rows.append(f"| `{code}` | {severity} | {text.replace('|', chr(92) + '|')} |")
    return "\n".join(rows) + "\n"


def renewed(page: str) -> str:
    """Return the page with today's table under its heading."""
    start = page.index(HEADING) + len(HEADING)
    end = page.index(END, start)
    lead, _, _ = page[start:end].partition("| code")
    return page[:start] + lead + table() + page[end:]


if __name__ == "__main__":
    PAGE.write_text(renewed(PAGE.read_text("utf-8")), "utf-8")
