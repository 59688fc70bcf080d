"""The maker of the sample outcrop, for tests: it lives in packaging/ and knows nothing of the
program."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType

import numpy as np

from vomstudio.geology.orientation import Line, Plane
from vomstudio.project.sample import SamplePicks, SampleTruth

PACKAGING = Path(__file__).resolve().parents[1] / "packaging"


def maker(module: str) -> ModuleType:
    """One module of packaging/sample_outcrop."""
    import importlib

    if str(PACKAGING) not in sys.path:
        sys.path.insert(0, str(PACKAGING))
    return importlib.import_module(f"sample_outcrop.{module}")


def drawn(cliff: object, courses: list, seed: int) -> tuple[SamplePicks, SampleTruth]:
    """Picks on the same rock with its unevenness, and the hand, drawn anew."""
    geology = maker("geology")
    rng = np.random.default_rng(seed)
    cliff.roughen(rng)  # type: ignore[attr-defined]
    made = maker("picks").draw(cliff, courses, rng)
    counts = [len(p.points) for p in made]
    picks = SamplePicks(
        tuple(p.name for p in made),
        tuple(p.kind for p in made),
        tuple(p.set_name for p in made),
        tuple(p.horizon for p in made),
        np.concatenate([p.points for p in made]) + geology.ORIGIN,
        np.concatenate([[0], np.cumsum(counts)]),
    )
    axis = Line(geology.AXIS_TREND_DEG, geology.AXIS_PLUNGE_DEG)
    planes = {p.name: Plane(*geology.plane_angles(p.normal)) for p in made}
    return picks, SampleTruth(planes, axis, axis, geology.DISPLACEMENT)
