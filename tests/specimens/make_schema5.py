"""How `schema5.vom` was made: `python -m tests.specimens.make_schema5` with the program whose
journal had schema 5. It is kept to tell what is in the specimen, which is never made again: it
stands for the projects that users have.

The specimen of schema 4 was opened and brought to schema 5, and worked on: its model was placed by
points that were found on it, with what is left over at each, the covariance and its centre, once
more with a point that judges only, a step back, a save, and something that was thrown away.
"""

from __future__ import annotations

from dataclasses import replace

from tests.specimens import figures
from tests.specimens.make_schema4 import QUARTER

COVARIANCE = tuple(
    tuple(
        (4.0e-6, 9.0e-6, 1.0e-6, 2.0e-8, 1e-4, 1e-4, 4e-4)[i] if i == j else 0.0 for j in range(7)
    )
    for i in range(7)
)


def main() -> None:
    from vomstudio.document import edits
    from vomstudio.document.records import Frame, Model, Registration, RegistrationPoint

    with figures.made_from("schema4", "schema5", 5) as opened:
        session = opened.session
        model = session.of(Model)[0]
        frame = Frame(kind="crs", crs="EPSG:32633")
        points = tuple(
            RegistrationPoint(
                f"P{i}", (float(x), float(y), float(z)), (400.0 - y, 5000.0 + x, 30.0 + z),
                (0.01 * i, -0.01, 0.0), (0.02, 0.02, 0.03) if i % 2 else None, check=i == 3,
            )
            for i, (x, y, z) in enumerate(((0, 0, 0), (8, 0, 1), (1, 7, 2), (6, 5, 9)))
        )  # fmt: skip
        placed = Registration(
            "registration-points", "points", "points", frame, QUARTER,
            rotation_error_deg=(0.06, 0.11, 0.17), scale_error=0.00014, rms_control_m=0.02,
            rms_check_m=0.04, control=points, covariance=COVARIANCE, centre=(396.0, 5004.0, 33.0),
        )  # fmt: skip
        session.apply(edits.set_registration(session.records, placed, [model.id]))
        fewer = replace(placed, control=points[:3], rms_check_m=None)
        session.apply(edits.set_registration(session.records, fewer))
        session.undo()
        session.save()
        session.apply(edits.delete(session.records, ["trace-by-rule"]))
        session.discard_unsaved()
        session.apply(edits.set_attributes(session.records, ["trace-by-rule"], set_name="hinge"))


if __name__ == "__main__":
    main()
