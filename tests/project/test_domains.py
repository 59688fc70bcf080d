"""Features in domains: named, parted by a plane, and told in tables."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.messages import refused
from vomstudio.core.errors import DocumentError
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.frames import Frame
from vomstudio.project.domains import domain_names, split_by_plane
from vomstudio.project.edits import set_attributes
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.record_map import RecordMap
from vomstudio.project.records import DEFAULT_TYPES, Model
from vomstudio.project.tables.project_table import project_table

MODEL = Model("m", "face", "face.ply", "mesh", "0" * 64, Frame("local"))


def on(plane: Plane, id_: str, type_id: str, centre: tuple[float, float, float]) -> Trace:
    u = np.linspace(-1.0, 1.0, 12)
    v = 0.4 * np.sin(7.0 * u)
    xyz = np.outer(u, plane.strike_vector()) + np.outer(v, plane.dip_vector()) + np.array(centre)
    return Trace(id_, id_.upper(), type_id, "m", "0" * 64, tuple(map(tuple, xyz.tolist())))


BED, FAULT = Plane(20.0, 15.0), Plane(90.0, 60.0)
FEATURES = (
    on(FAULT, "f", "fault", (0.0, 0.0, 0.0)),
    on(BED, "a", "bedding", (8.0, 0.0, 0.0)),
    on(BED, "b", "bedding", (-8.0, 0.0, 1.0)),
    on(BED, "c", "bedding", (0.0, 0.0, 0.0)),
)


def records(*features: Trace) -> dict:  # type: ignore[type-arg]
    return {r.id: r for r in (*DEFAULT_TYPES, MODEL, *(features or FEATURES))}


def parted(now: dict, id_: str = "f"):  # type: ignore[no-untyped-def,type-arg]
    measurements = Measurements()
    return split_by_plane(now, id_, lambda ids: measurements.of(now, ids))


def test_features_above_a_fault_are_in_its_hanging_wall() -> None:
    """A fault that dips east has its hanging wall in the east."""
    edit, crossing = parted(records())
    assert {id_: r.domain for id_, r in edit.after.items()} == {  # type: ignore[union-attr]
        "a": "hanging wall",
        "b": "footwall",
    }
    assert crossing == 1


def test_sides_of_an_upright_fault_are_named_by_compass_points() -> None:
    upright = on(Plane(90.0, 89.8), "f", "fault", (0.0, 0.0, 0.0))
    edit, _ = parted(records(upright, *FEATURES[1:]))
    assert {r.domain for r in edit.after.values()} == {"E side", "W side"}  # type: ignore[union-attr]


def test_splitting_needs_a_plane_and_other_features() -> None:
    with refused("domain.no-plane", DocumentError):
        parted(records(), "m")
    with refused("edit.no-change", DocumentError):
        parted(records(FEATURES[0]))


def test_domains_are_attributes_and_a_column_if_any_is_named() -> None:
    now = records()
    assert project_table(now).extra_columns == ()
    edit = set_attributes(now, ["a", "b"], domain="footwall")
    now |= edit.after
    table = project_table(now)
    assert domain_names(RecordMap(now)) == ["footwall"]
    assert table.extra_columns == ("domain",)
    assert {row["id"]: row.get("domain") for row in table.rows} == {
        "f": None,
        "a": "footwall",
        "b": "footwall",
        "c": None,
    }
    assert replace(now["a"], domain="") == FEATURES[1]
