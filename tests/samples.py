"""Small records that several tests make."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from vomstudio.geometry.registrations import Registration
from vomstudio.project.kinds.contact import Contact
from vomstudio.project.kinds.control_point import ControlPoint
from vomstudio.project.kinds.dimension import Dimension
from vomstudio.project.kinds.intersection import Intersection
from vomstudio.project.kinds.known_line import KnownLine
from vomstudio.project.kinds.lineation import Lineation
from vomstudio.project.kinds.lithology import Lithology
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.kinds.station import Station
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.records import FaceGrid, Feature, Group, Model

# A zigzag on a plane that dips, with a little roughness.
ZIGZAG = (
    (0.0, 0.0, 0.0),
    (1.0, 0.2, 0.51),
    (2.0, -0.1, 0.98),
    (2.5, 1.5, 1.27),
    (4.0, 1.2, 2.03),
)


def bed(id_: str, shift: float = 0.0, vertices: tuple | None = None) -> Trace:
    """A bedding trace on model m1."""
    points = vertices or tuple((x, y, z + shift) for x, y, z in ZIGZAG)
    return Trace(id_, "", "bedding", "m1", "0" * 64, points)


HASH = "0" * 64
ONE_OF_EACH: dict[str, Feature] = {
    "trace": bed("t1"),
    "contact": Contact("k1", "K01", "fault", "m1", HASH, ZIGZAG),
    "lineation": Lineation("l1", "L01", "lineation", "m1", HASH, ZIGZAG[:3], plane_id="t1"),
    "patch": Patch(
        "p1",
        "J01",
        "joint",
        "m1",
        HASH,
        "face",
        ((0, 9),),
        9,
        (1.0, 2.0, 3.0),
        ((4.0, 0.0, 0.0), (0.0, 3.0, 0.0), (0.0, 0.0, 0.01)),
        9.0,
        outline=((0.0, 0.0, 3.0), (2.0, 0.0, 3.0), (1.0, 3.0, 3.0)),
    ),
    "lithology": Lithology("a1", "A01", "m1", HASH, ZIGZAG, "sandstone", 12.5),
    "dimension": Dimension(
        "d1", "D01", "thickness", "m1", HASH, ZIGZAG[:2], plane_id="t1", resolution=0.02
    ),
    "intersection": Intersection(
        "i1", "I01", "lineation", Group(feature_id="t1"), Group(feature_id="p1")
    ),
    "reading": Reading(
        "r1", "R01", "bedding", "plane", 100.0, 30.0, position=(0.0, 0.0, 0.0), station="KB-17"
    ),
    "station": Station("s1", "S01", "m1", HASH, ZIGZAG[:1], "sample", "KB-17", "DSC_12.jpg"),
    "control_point": ControlPoint(
        "c1",
        "C01",
        "m1",
        HASH,
        ((1.0, 2.0, 3.0),),
        (398_000.0, 4_980_000.0, 320.0),
        sigma_m=(0.01, 0.01, 0.02),
        check=True,
    ),
    "known_line": KnownLine("w1", "K01", "azimuth", "m1", HASH, ZIGZAG[:2], 113.5, 2.0),
}
"""A feature of every kind by the kind's name, on model m1."""
GRID = FaceGrid("g1", "", "m1", HASH, (0.0, 0.0, 5.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5, 3, 2)
"""Of six cells, on model m1."""


def placed(model: Model, matrix: Any) -> Model:
    """The model where a similarity (4, 4) from its file brings it, its frame as it was."""
    rows = tuple(tuple(float(v) for v in row) for row in np.asarray(matrix))
    return replace(model, placement=Registration("r1", "turned", "control", model.frame, rows))
