"""How `schema8.vom` was made: `python -m tests.specimens.make_schema8` with the program whose
journal had schema 8. It is kept to tell what is in the specimen, which is never made again: it
stands for the projects that users have.

The specimen of schema 7 was opened and brought to schema 8, and worked on: a station and a sample,
a contact line, an area of rock and a known line; a trace that repeats another, and by whom; a
polyline across the beds; a grid of what was looked at; a frame of which a part is known, a step
back; a save, and something that was thrown away.
"""

from __future__ import annotations

from dataclasses import replace

from tests.specimens import figures


def main() -> None:
    from vomstudio.document import edits, grid_edits, repeats
    from vomstudio.document.kinds.contact import Contact
    from vomstudio.document.kinds.dimension import Dimension
    from vomstudio.document.kinds.known_line import KnownLine
    from vomstudio.document.kinds.lithology import Lithology
    from vomstudio.document.kinds.station import Station
    from vomstudio.document.kinds.trace import Trace
    from vomstudio.document.records import FaceGrid, Frame, Model

    with figures.made_from("schema7", "schema8", 8) as opened:
        session = opened.session
        model = session.of(Model)[0]
        on = (model.id, model.content_hash)
        places = ((0.0, 0.0, 0.0), (2.0, 0.5, 0.2), (2.2, 0.6, 2.0), (0.1, 0.2, 1.9))
        first = session.of(Trace)[0]
        added = [
            Station("station-1", "St 1", *on, places[:1], number="17", notes="fossils"),
            Station("sample-1", "Sa 1", *on, places[1:2], "sample", "HL-3", "bag.jpg"),
            Contact("contact-1", "C1", first.type_id, *on, places[:3], "crest"),
            Lithology("rock-1", "R1", *on, places, "sandstone", 3.7),
            KnownLine("known-1", "K1", "azimuth", *on, places[:2], 31.0, 0.5),
            Dimension("across-beds", "section A", "polyline", *on, places[:3], notes="up"),
            replace(first, id="trace-again", name="again"),
        ]
        session.apply(edits.add_features(session.records, added))
        session.apply(repeats.link_repeat(session.records, "trace-again", first.id, "AB"))
        grid = FaceGrid(
            "grid-1", "", *on, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5, 4, 3
        )
        session.apply(grid_edits.add_grid(session.records, grid))
        session.apply(grid_edits.mark_cells(session.records, "grid-1", [0, 1, 5], "d"))
        session.apply(grid_edits.mark_cells(session.records, "grid-1", [2], "u"))
        assert model.registration is not None
        scaled = replace(model.registration, frame=Frame("scaled"))
        session.apply(edits.set_registration(session.records, scaled))
        session.undo()
        session.save()
        session.apply(edits.delete(session.records, ["rock-1"]))
        session.discard_unsaved()
        session.apply(edits.set_attributes(session.records, ["contact-1"], set_name="limb"))


if __name__ == "__main__":
    main()
