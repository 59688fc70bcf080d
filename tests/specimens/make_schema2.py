"""How `schema2.vom` was made: `python -m tests.specimens.make_schema2` with the program whose
journal had schema 2. It is kept to tell what is in the specimen, which is never made again: it
stands for the projects that users have.

The specimen of schema 1 was opened and taken over, and worked on: a compass plane of either side of
the net and of each steepness with lines of every sense of slip on it, changes of single fields,
steps back and forth, a save, and something that was thrown away.
"""

from __future__ import annotations

from tests.specimens import figures

PLANES = {"east": (80.0, 55.0), "west": (260.0, 40.0), "upright": (130.0, 90.0), "flat": (0.0, 0.0)}
WAYS = {"steep": (0.4, 0.2, -0.9), "gentle": (-0.3, 0.9, -0.2)}
SENSES = ("", "normal", "reverse", "sinistral", "dextral")


def main() -> None:
    from vomstudio.document import edits
    from vomstudio.document.kinds.lineation import Lineation
    from vomstudio.document.kinds.reading import Reading
    from vomstudio.document.records import Model

    with figures.made_from("schema1", "schema2", 2) as opened:
        session = opened.session
        model = session.of(Model)[0]
        for name, (azimuth, dip) in PLANES.items():
            plane = Reading(f"reading-{name}", name, "fault", "plane", azimuth, dip)
            session.apply(edits.add_features(session.records, [plane]))
            for way, (x, y, z) in WAYS.items():
                lines = [
                    Lineation(
                        f"line-{name}-{way}-{sense or 'none'}", f"{name} {way} {sense}".strip(),
                        "lineation", model.id, model.content_hash,
                        ((0.0, 0.0, 0.0), (x, y, z), (2.0 * x, 2.0 * y + 0.01, 2.0 * z)),
                        plane_id=plane.id, slip=sense,
                    )
                    for sense in SENSES
                ]  # fmt: skip
                session.apply(edits.add_features(session.records, lines))
        some = ["line-east-steep-normal", "line-west-gentle-dextral"]
        session.apply(edits.set_attributes(session.records, some, set_name="striae"))
        session.apply(edits.set_attributes(session.records, some[:1], slip="reverse"))
        session.undo()
        session.save()
        session.apply(edits.delete(session.records, ["line-flat-steep-none"]))
        session.discard_unsaved()
        session.apply(edits.set_attributes(session.records, some[1:], notes="polished"))
        session.undo()


if __name__ == "__main__":
    main()
