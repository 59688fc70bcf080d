"""How `schema4.vom` was made: `python -m tests.specimens.make_schema4` with the program whose
journal had schema 4. It is kept to tell what is in the specimen, which is never made again: it
stands for the projects that users have.

The specimen of schema 3 was opened and brought to schema 4, and worked on: another profile of
verdicts, a trace whose surroundings were measured by the rule of today, a model that was moved to
its place by a registration without points, changes of that, steps back and forth, a save, and
something that was thrown away.
"""

from __future__ import annotations

from dataclasses import replace

from tests.specimens import figures
from tests.specimens.make_schema3 import points

QUARTER = (
    (0.0, -1.0, 0.0, 400.0),
    (1.0, 0.0, 0.0, 5000.0),
    (0.0, 0.0, 1.0, 30.0),
    (0.0, 0.0, 0.0, 1.0),
)
"""A quarter about the vertical, and a shift."""


def main() -> None:
    from vomstudio.document import edits
    from vomstudio.document.kinds.trace import Trace
    from vomstudio.document.records import Frame, Model, Registration
    from vomstudio.geology.profiles import PROFILES

    with figures.made_from("schema3", "schema4", 4) as opened:
        session = opened.session
        model = session.of(Model)[0]
        trace = Trace(
            "trace-by-rule", "by rule", "bedding", model.id, model.content_hash,
            points(33.0, 210.0, 7), resolution=0.02, outcrop_normal=(0.0, -1.0, 0.0), rule=1,
        )  # fmt: skip
        session.apply(edits.add_trace(session.records, trace))
        session.apply(edits.judge_by(session.records, PROFILES["textbook"]))
        frame = Frame(kind="crs", crs="EPSG:32633")
        placed = Registration("registration-1", "control", "control", frame, QUARTER)
        session.apply(edits.set_registration(session.records, placed, [model.id]))
        better = replace(placed, rms_control_m=0.02, rms_check_m=0.03, scale_error=0.001)
        session.apply(edits.set_registration(session.records, better))
        session.save()
        session.apply(edits.delete(session.records, ["trace-by-rule"]))
        session.discard_unsaved()
        session.apply(edits.set_attributes(session.records, ["trace-by-rule"], set_name="limb"))
        session.apply(edits.judge_by(session.records, PROFILES["error"]))
        session.undo()


if __name__ == "__main__":
    main()
