"""How `schema3.vom` was made: `python -m tests.specimens.make_schema3` with the program whose
journal had schema 3. It is kept to tell what is in the specimen, which is never made again: it
stands for the projects that users have.

The specimen of schema 2 was opened and brought to schema 3, and worked on: traces by inertia and by
regression, with and without surroundings, how sure lines of slip are, steps back and forth, a save,
and something that was thrown away.
"""

from __future__ import annotations

import numpy as np

from tests.specimens import figures

DIPS = {"gentle": 12.0, "middling": 41.0, "steep": 84.0}


def points(dip_deg: float, azimuth_deg: float, seed: int) -> tuple[tuple[float, float, float], ...]:
    """Points of a rough trace along a plane."""
    random = np.random.default_rng(seed)
    across = np.linspace(-2.0, 2.0, 14)
    down = 0.8 * np.sin(1.3 * across)
    dip, azimuth = np.radians([dip_deg, azimuth_deg])
    along = np.array([-np.cos(azimuth), np.sin(azimuth), 0.0])
    steepest = np.array([np.sin(azimuth) * np.cos(dip), np.cos(azimuth) * np.cos(dip),
                         -np.sin(dip)])  # fmt: skip
    found = np.outer(across, along) + np.outer(down, steepest)
    return tuple(map(tuple, (found + random.normal(0.0, 0.01, found.shape)).tolist()))


def main() -> None:
    from vomstudio.document import edits
    from vomstudio.document.kinds.trace import Trace
    from vomstudio.document.records import Model

    with figures.made_from("schema2", "schema3", 3) as opened:
        session = opened.session
        model = session.of(Model)[0]
        for number, (name, dip) in enumerate(DIPS.items()):
            for method in ("pca", "regression"):
                known = method == "pca"
                trace = Trace(
                    f"trace-{name}-{method}", f"{name} {method}", "bedding", model.id,
                    model.content_hash, points(dip, 70.0 + 100.0 * number, number),
                    resolution=0.02 if known else None,
                    outcrop_normal=(0.0, -1.0, 0.0) if known else None,
                )  # fmt: skip
                session.apply(edits.add_trace(session.records, trace))
                if not known:
                    change = edits.set_attributes(session.records, [trace.id], method=method)
                    session.apply(change)
        lines = ["line-west-steep-sinistral", "line-east-gentle-normal"]
        session.apply(edits.set_attributes(session.records, lines, slip_confidence="probable"))
        session.apply(edits.set_attributes(session.records, lines[:1], slip_confidence="certain"))
        session.undo()
        session.save()
        session.apply(edits.delete(session.records, ["trace-gentle-pca"]))
        session.discard_unsaved()
        session.apply(edits.set_attributes(session.records, ["trace-steep-pca"], set_name="limb"))
        session.apply(edits.set_attributes(session.records, ["trace-steep-pca"], notes="rough"))
        session.undo()


if __name__ == "__main__":
    main()
