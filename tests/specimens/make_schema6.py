"""How `schema6.vom` was made: `python -m tests.specimens.make_schema6` with the program whose
journal had schema 6. It is kept to tell what is in the specimen, which is never made again: it
stands for the projects that users have.

The specimen of schema 5 was opened and brought to schema 6, and worked on: control points were
clicked on its model, one of them not found and one that judges only, one moved and one taken away,
a step back; the model was fitted to another one, a save, and something that was thrown away.
"""

from __future__ import annotations

from dataclasses import replace

from tests.specimens import figures
from tests.specimens.make_schema4 import QUARTER
from tests.specimens.make_schema5 import COVARIANCE


def main() -> None:
    from vomstudio.document import edits
    from vomstudio.document.edit import change
    from vomstudio.document.kinds.control_point import ControlPoint
    from vomstudio.document.records import Frame, Model, Registration

    with figures.made_from("schema5", "schema6", 6) as opened:
        session = opened.session
        model = session.of(Model)[0]
        points = [
            ControlPoint(
                f"control-{i}", f"K{i}", model.id, model.content_hash,
                () if i == 4 else ((float(x), float(y), float(z)),),
                (400.0 - y, 5000.0 + x, 30.0 + z), (0.02, 0.02, 0.03) if i % 2 else None,
                check=i == 3, notes="painted cross" if i == 1 else "",
            )
            for i, (x, y, z) in enumerate(((0, 0, 0), (8, 0, 1), (1, 7, 2), (6, 5, 9), (2, 2, 2)))
        ]  # fmt: skip
        for point in points:
            session.apply(change(session.records, f"Add {point.name}", {point.id: point}))
        moved = replace(points[0], vertices=((0.1, 0.0, 0.0),))
        session.apply(change(session.records, "Move K0", {moved.id: moved}))
        session.apply(edits.delete(session.records, ["control-2"]))
        session.undo()
        fitted = Registration(
            "registration-fitted", "another model", "reference",
            Frame(kind="crs", crs="EPSG:32633"), QUARTER, rotation_error_deg=(0.05, 0.08, 0.1),
            scale_error=0.0003, rms_control_m=0.03, covariance=COVARIANCE,
            centre=(396.0, 5004.0, 33.0),
        )  # fmt: skip
        session.apply(edits.set_registration(session.records, fitted, [model.id]))
        session.save()
        session.apply(edits.delete(session.records, ["control-1"]))
        session.discard_unsaved()
        session.apply(edits.set_attributes(session.records, ["trace-by-rule"], set_name="limb"))


if __name__ == "__main__":
    main()
