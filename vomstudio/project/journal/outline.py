"""Outline of the steps of a project without coordinates and user-defined names."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

from vomstudio.project.journal.replay import JournalRow

# Words used in the labels of edits; any other word in a label is a name.
_WORDS = frozenset(
    """add axis bedding beds change changes contact declare delete dimension dip discard fault
    feature features field fold foliation fracture frame import in intersection joint line
    lineation locate measurement measurements model move name names notes of open overturned
    patch reading readings redo remove rename set sets smear stroke the to trace traces type
    types undo vein vertex vertices""".split()  # noqa: SIM905 - a list of words, as words
)
_NAME = re.compile(r"[a-z_][a-z0-9_]*", re.IGNORECASE)


def outline(rows: Iterable[JournalRow]) -> list[str]:
    """Return one line per row: number, kind, time, version, label, and changed fields.

    The lines contain no coordinates and no names typed by the user.
    """
    return [_line(row) for row in rows]


def _line(row: JournalRow) -> str:
    undo_text = "" if row.of_seq is None else f" of {row.of_seq}"
    parts = [f"{row.seq} {_word(row.kind)}{undo_text}, {row.time}, version {row.version}"]
    if row.label:
        parts.append(_label(row.label))
    if row.kind == "draft":
        parts.append(_draft_text(row.after))
    else:
        parts += _changed_parts(_fields(row.before), _fields(row.after))
    return ": ".join(parts[:1]) + "".join(f"; {part}" for part in parts[1:])


def _label(label: str) -> str:
    """Replace each sequence of words that are not in `_WORDS` by "…"."""
    labels = [
        word if word.lower() in _WORDS or re.fullmatch(r"\d{1,3}", word) else "…"
        for word in label.split()
    ]
    return re.sub(r"…(?: …)+", "…", " ".join(labels))


def _draft_text(state: Mapping[str, Any] | None) -> str:
    if not isinstance(state, Mapping):
        return "discarded"
    vertices = state.get("vertices", ())
    count = len(vertices) if isinstance(vertices, list | tuple) else 0
    return f"tool {_word(state.get('tool'))}, vertices {count}"


def _changed_parts(before: Mapping[str, Any], after: Mapping[str, Any]) -> list[str]:
    counts: dict[str, int] = {}
    for id_ in dict.fromkeys([*before, *after]):
        change = _change(before.get(id_), after.get(id_))
        counts[change] = counts.get(change, 0) + 1
    return [change if count == 1 else f"{count} times {change}" for change, count in counts.items()]


def _change(before: Any, after: Any) -> str:
    old_fields, new_fields = _fields(before), _fields(after)
    kind = _word(new_fields.get("record", old_fields.get("record")))
    if not old_fields and not new_fields:
        return "nothing"
    if not old_fields:
        return f"{kind} added ({_names(new_fields)})"
    if not new_fields:
        return f"{kind} removed"
    names = _names(
        n for n in {**old_fields, **new_fields} if old_fields.get(n) != new_fields.get(n)
    )
    return f"{kind} changed ({names})"


def _fields(record: Any) -> Mapping[str, Any]:
    return record if isinstance(record, Mapping) else {}


def _names(fields: Iterable[str]) -> str:
    return ", ".join(_word(name) for name in fields if name != "record")


def _word(name: object) -> str:
    return name if isinstance(name, str) and _NAME.fullmatch(name) else "unknown"
