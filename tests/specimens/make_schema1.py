"""Rewrite the specimen of schema 1: `python -m tests.specimens.make_schema1`.

The specimen is a geologist's project at a small outcrop with one of everything that a project can
store: every kind of record, every field of each, every kind of journal row, models inside the
project, beside it and missing, a reconstruction, a mask, and the draft of an unfinished trace. The
field book is in `schema1.vom/journal.sqlite` itself; there is no other source for it.

Until schema 1 is released, run this after a change to a record or a new kind: it reads every row of
the journal, writes it as the present program does, adds what the specimen lacks (`additions`; of a
new kind the feature in `tests.samples.ONE_OF_EACH`) and records the figures. It refuses to do so if
a recorded figure differs, unless `--new-figures` is given. A specimen of a released schema is never
rewritten: it stands for the projects that users have.
"""

from __future__ import annotations

import argparse
import json
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from tests.samples import ONE_OF_EACH
from tests.specimens import figures
from vomstudio.geometry.registrations import NorthReference, ObservationGroup
from vomstudio.project import edits
from vomstudio.project.codec import decode_edit, encode_edit
from vomstudio.project.edit import change
from vomstudio.project.journal import replay as document_journal
from vomstudio.project.journal.database import SqliteJournal
from vomstudio.project.journal.replay import JournalRow, Replay
from vomstudio.project.kinds.contact import Contact
from vomstudio.project.kinds.dimension import Dimension
from vomstudio.project.kinds.intersection import Intersection
from vomstudio.project.kinds.known_line import KnownLine
from vomstudio.project.kinds.lineation import Lineation
from vomstudio.project.kinds.lithology import Lithology
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.kinds.station import Station
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.paths import JOURNAL_NAME
from vomstudio.project.records import (
    SURROUNDINGS_RULE,
    Compass,
    FaceGrid,
    Model,
    Record,
    compass_id,
)
from vomstudio.project.session import Session

SPECIMEN = "schema1"
BEDS = (("#0", "sandstone", "channel fill"), ("#1", "mudstone", ""))
DRAFT = {
    "tool": "trace",
    "trace_id": "trace-unfinished",
    "continued": False,
    "type_id": "fault",
    "set_name": "late",
    "vertices": [
        [1.819, 1.695, -1.975],
        [2.565, 2.33, -2.751],
        [-1.697, -1.564, 1.908],
        [0.659, 0.635, -0.903],
    ],
}
"""The state of a trace on the boulder that was open when the program ended."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--new-figures", action="store_true", help="record figures that differ")
    new_figures = parser.parse_args().new_figures
    recorded = figures.recorded(SPECIMEN)
    with tempfile.TemporaryDirectory() as place:
        folder = figures.copy_of(SPECIMEN, Path(place))
        rewrite(folder / JOURNAL_NAME)
        opened = figures.open_project(folder)
        add_missing(opened.session, {row.kind for row in opened.journal.rows()})
        opened.close()
        written = Path(place) / JOURNAL_NAME
        shutil.copy(folder / JOURNAL_NAME, written)
        found = json.loads(json.dumps(figures.figures_of(folder)))
        different = list(figures.differences(recorded, found, ignored=("history", "said")))
        if different and not new_figures:
            raise SystemExit("\n".join([*different, "Figures differ: nothing was written."]))
        shutil.copy(written, figures.HERE / f"{SPECIMEN}.vom" / JOURNAL_NAME)
    figures.record(SPECIMEN, found)


def rewrite(path: Path) -> None:
    """Replace a journal by one with the same rows as the present program encodes them."""
    old, new = SqliteJournal(path), path.with_suffix(".new")
    made = SqliteJournal(new, is_new=True)
    for row, before, after in encoded_again(old.rows()):
        if row.notice or row.problem:
            raise SystemExit(f"Row {row.seq} is damaged: {row.notice or row.problem}")
        made.copy_row(row.kind, row.of_seq, row.label, before, after, row)
    made.copy_views(old)
    old.close()
    made.close()
    new.replace(path)


def encoded_again(
    rows: Iterator[JournalRow],
) -> Iterator[tuple[JournalRow, Mapping[str, Any] | None, Mapping[str, Any] | None]]:
    """Rows with the maps before and after in the present encoding. Raises DocumentError."""
    state = Replay()
    for row in rows:
        before, after = row.before, row.after
        if row.kind in ("do", "discard", "amend"):
            edit = decode_edit(row.label, before or {}, after or {}, state.records)
            before, after = encode_edit(edit)
        document_journal._apply_row(state, row)
        yield row, before, after


def add_missing(session: Session, row_kinds: set[str]) -> None:
    """Add to the project what it has none of, as edits; some stay unsaved."""
    count = len(session.records)
    for label, added in additions(session.records).items():
        if not added.keys() <= session.records.keys():
            session.apply(change(session.records, label, added))
    model = next(model for model in session.of(Model) if model.registration is not None)
    for name, feature in ONE_OF_EACH.items():
        if not session.of(type(feature)):
            made = feature.replace_fields(id=f"specimen-{name}", model_id=model.id)
            made = made.replace_fields(model_hash=model.content_hash)
            session.apply(change(session.records, f"Add {made.name}", {made.id: made}))
    if "amend" not in row_kinds:
        noted = edits.set_attributes(session.records, ["reading-overturned"], notes="scoured")
        last = session.apply(noted)
        noted = edits.set_attributes(session.records, ["reading-overturned"], notes="scours")
        session.apply(noted, joins=last)
    if len(session.records) > count:
        session.save()
    station = session.of(Station)[0]
    if not session.dirty:
        name = f"St {len(session.of(Station)) + 1}"
        added = replace(station, id=f"unsaved {name}", name=name, number="")
        session.apply(change(session.records, f"Add {name}", {added.id: added}))
    if session.redo_label is None:
        session.apply(edits.set_attributes(session.records, [station.id], number="18"))
        session.undo()
    if session.draft is None:
        boulder = next(model for model in session.of(Model) if model.name == "boulder")
        on = {"model_id": boulder.id, "model_hash": boulder.content_hash}
        session.set_draft({**DRAFT, **on})


def additions(records: Mapping[str, Record]) -> dict[str, dict[str, Record]]:
    """Records for what the geologist's days left out, by the label of their edit."""
    model = next(r for r in records.values() if isinstance(r, Model) and r.registration is not None)
    placed = model.registration
    assert placed is not None

    def first(cls: type[Any], **values: Any) -> Any:
        return next(
            r
            for r in records.values()
            if isinstance(r, cls) and all(getattr(r, k) == v for k, v in values.items())
        )

    line = first(Lineation)
    patch = first(Patch, element="face")
    steep = first(Trace, id="trace-steep-regression")
    contact, rock = first(Contact), first(Lithology)
    intersection = first(Intersection)
    compass = Compass(
        compass_id(model.id), model.id, "magnetic", "2024-05-12", (13.35, 42.64), 3.9, 0.5
    )
    repeated = {"repeat_of": None, "interpreter": "AB"}
    return {
        "Add features with every field": {
            each.id: each
            for each in (
                replace(
                    steep,
                    id="trace-along-x",
                    name="along x",
                    type_id="vein",
                    axis="x",
                    domain="hanging wall",
                    beds=BEDS,
                ),
                replace(steep, id="trace-beside", name="beside", doubtful=((1, 2),)),
                replace(
                    contact,
                    id="contact-again",
                    name="C1 again",
                    domain="footwall",
                    beds=BEDS,
                    notes="covered",
                    interpreter="AB",
                    repeat_of=contact.id,
                ),
                replace(
                    line,
                    id="line-again",
                    name="line again",
                    domain="footwall",
                    **{**repeated, "repeat_of": line.id},
                ),
                replace(patch, id="patch-bent", name="bent", bend_deg=4.0),
                replace(
                    patch,
                    id="patch-again",
                    name="patch again",
                    bent=True,
                    level_gap=0.02,
                    domain="hanging wall",
                    notes="polished",
                    set_name="J9",
                    rule=SURROUNDINGS_RULE,
                    **{**repeated, "repeat_of": patch.id},
                ),
                replace(
                    rock,
                    id="rock-again",
                    name="R1 again",
                    notes="weathered",
                    **{**repeated, "repeat_of": rock.id},
                ),
                replace(first(Dimension, kind="polyline"), id="log-line", name="log", beds=BEDS),
                replace(intersection, id="axis-in-domain", name="axis", domain="hanging wall"),
                Reading(
                    "reading-overturned",
                    "overturned",
                    "foliation",
                    "plane",
                    75.0,
                    60.0,
                    overturned=True,
                    domain="footwall",
                ),
                KnownLine(
                    "known-plane",
                    "K2",
                    "plane",
                    model.id,
                    model.content_hash,
                    (),
                    110.0,
                    3.0,
                    True,
                    "Clar compass",
                    62.0,
                    steep.id,
                ),
            )
        },
        "Set the compass": {compass.id: compass},
        "Register by compass": {
            "registration-compass": replace(
                placed,
                id="registration-compass",
                name="compass",
                method="lines",
                read_north=NorthReference("magnetic", 2.4, 3.9, True, "2024-05-12", 0.5),
            )
        },
        "Read at a station": {
            "reading-station": Reading(
                "reading-station", "KB-17 a", "bedding", "plane", 100.0, 30.0, station="KB-17"
            ),
        },
        "Measure with a resolution": {
            "line-resolved": replace(
                first(Dimension, kind="polyline"),
                id="line-resolved",
                name="resolved",
                resolution=0.02,
            ),
        },
        "Register by points and lengths": {
            "registration-observed": replace(
                placed,
                id="registration-observed",
                name="points and lengths",
                observations=(
                    ObservationGroup("points", ("P1", "P2", "P3")),
                    ObservationGroup("lengths", ("P1 - P2",)),
                ),
            )
        },
        "Register by clicked points": {
            "registration-clicked": replace(
                placed, id="registration-clicked", name="clicked points", click_sigma_m=0.02
            )
        },
        "Add a grid": {
            "grid-noted": replace(
                first(FaceGrid), id="grid-noted", name="grid 2", notes="upper bench"
            )
        },
    }


if __name__ == "__main__":
    main()
