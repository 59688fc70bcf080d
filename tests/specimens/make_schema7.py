"""How `schema7.vom` was made: `python -m tests.specimens.make_schema7` with the program whose
journal had schema 7. It is kept to tell what is in the specimen, which is never made again: it
stands for the projects that users have.

The specimen of schema 6 was opened and brought to schema 7, and worked on: its model was placed by
a registration that says how far the model reaches, of its mean plane and of its lenses, once more
with other lenses, a step back; a line and a control point that is not found yet were added, a save,
and something that was thrown away.
"""

from __future__ import annotations

from dataclasses import replace

from tests.specimens import figures
from tests.specimens.make_schema4 import QUARTER
from tests.specimens.make_schema5 import COVARIANCE


def main() -> None:
    from vomstudio.document import edits
    from vomstudio.document.kinds.control_point import ControlPoint
    from vomstudio.document.kinds.lineation import Lineation
    from vomstudio.document.records import Frame, Model, Registration

    with figures.made_from("schema6", "schema7", 7) as opened:
        session = opened.session
        model = session.of(Model)[0]
        bowed = Registration(
            "registration-bowed", "points and lenses", "points",
            Frame(kind="crs", crs="EPSG:32633"), QUARTER, rotation_error_deg=(0.05, 0.08, 0.1),
            scale_error=0.0003, rms_control_m=0.03, covariance=COVARIANCE,
            centre=(396.0, 5004.0, 33.0), reach_m=6.5, normal=(0.6, -0.64, 0.48),
            lens_bowing95_deg=0.35, lens_stretch95=0.002,
        )  # fmt: skip
        session.apply(edits.set_registration(session.records, bowed, [model.id]))
        worse = replace(bowed, lens_bowing95_deg=3.5, lens_stretch95=None)
        session.apply(edits.set_registration(session.records, worse))
        session.undo()
        type_id = session.of(Lineation)[0].type_id
        line = Lineation(
            "line-on-bowed", "L-bowed", type_id, model.id, model.content_hash,
            ((0.0, 0.0, 0.0), (1.0, 0.5, 2.0), (2.0, 1.1, 3.9)), 0.01, notes="across the face",
        )  # fmt: skip
        later = ControlPoint(
            "control-later", "K9", model.id, model.content_hash, (), (390.0, 5001.0, 31.0)
        )
        session.apply(edits.add_features(session.records, [line, later]))
        session.save()
        session.apply(edits.delete(session.records, ["line-on-bowed"]))
        session.discard_unsaved()
        session.apply(edits.set_attributes(session.records, ["trace-by-rule"], set_name="crest"))


if __name__ == "__main__":
    main()
