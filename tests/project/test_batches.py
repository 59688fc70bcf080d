"""Many features measured together say what each of them says alone, to the last digit."""

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.samples import ZIGZAG, bed, placed
from vomstudio.geology.orientation import Plane
from vomstudio.geometry import transform
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.plane_discs import disc
from vomstudio.geometry.planes import PlaneFits, fit_planes
from vomstudio.geometry.vectors import wrap360
from vomstudio.project.measurement import world_lines
from vomstudio.project.measurement_cache import Measurements, measure_all
from vomstudio.project.record_map import RecordMap
from vomstudio.project.records import DEFAULT_TYPES, Model
from vomstudio.project.tables.project_table import project_table

TURN = np.array(
    [
        [1.7, -0.4, 0.0, 576_700.3],
        [0.4, 1.7, 0.0, 5_188_100.1],
        [0.0, 0.0, 1.7463, 180.7],
        [0.0, 0.0, 0.0, 1.0],
    ]
)


def models() -> list[Model]:
    """One as its file is, one far away and turned, one that has no north."""
    first = Model("m1", "cliff", "cliff.obj", "mesh", "0" * 64, Frame("local"))
    return [first, placed(replace(first, id="m2"), TURN), replace(first, id="m3")]


def traces():
    rng = np.random.default_rng(7)
    made = []
    for i in range(60):
        n = (3, 4, 5, 8, 11)[i % 5]
        points = (
            rng.normal(0.0, (3.0, 2.0, 0.05), (n, 3)) @ np.linalg.qr(rng.normal(size=(3, 3)))[0]
        )
        trace = bed(f"t{i}", vertices=tuple(map(tuple, points.tolist())))
        made.append(
            replace(
                trace,
                model_id=("m1", "m2", "m3", "gone")[i % 4],
                resolution=(None, 0.02, 0.4)[i % 3],
                outcrop_normal=(None, (0.0, 0.6, 0.8), (0.1, -0.97, 0.22))[i // 3 % 3],
                method=("pca", "regression")[i // 7 % 2],
            )
        )
    # What has no plane stands among the others.
    return [
        *made,
        bed("line", vertices=((0, 0, 0), (1, 1, 1), (2, 2, 2))),
        bed("two", vertices=ZIGZAG[:2]),
    ]


def plain(value):
    """Arrays as lists, records as their fields, so that equality is that of every digit."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if hasattr(value, "__dataclass_fields__"):
        return {f.name: plain(getattr(value, f.name)) for f in fields(value)}
    return value


def test_batch_measurements_and_rows_equal_single_ones():
    """Fewer than 12 points: no roughness is told from them, so that fits hang on nothing else."""
    records = {r.id: r for r in (*DEFAULT_TYPES, *models(), *traces())}
    together = measure_all(records, traces())
    rows = {row["id"]: row for row in project_table(records).rows}
    assert len(rows) > 50
    for trace, measured in zip(traces(), together, strict=True):
        alone = measure_all(records, [trace])[0]
        assert plain(measured) == plain(alone)
        own = {k: v for k, v in records.items() if not k.startswith("t") or k == trace.id}
        own = {k: v for k, v in own.items() if k not in ("line", "two")} | {trace.id: trace}
        for row in project_table(own).rows:
            assert row == rows[row["id"]]


def test_world_points_are_the_similarity_of_each_vertex():
    known = {m.id: m for m in models()}
    for trace, points in zip(
        traces(), world_lines(traces(), [known.get(t.model_id) for t in traces()]), strict=True
    ):
        model = known.get(trace.model_id)
        wanted = (
            trace.vertices if model is None else transform.apply(model.to_world, trace.vertices)
        )
        np.testing.assert_array_equal(points, np.asarray(wanted, float))


@pytest.mark.parametrize("method", ["pca", "regression"])
def test_fit_has_the_values_of_its_index_in_the_batch(method):
    groups = [np.asarray(t.vertices, float) for t in traces()]
    cuts = np.concatenate([[0], np.cumsum([len(g) for g in groups])])
    fits = fit_planes(np.concatenate(groups), cuts, method=method)
    for i, fit in enumerate(fits.rows()):
        for f in fields(PlaneFits):
            column, value = getattr(fits, f.name), getattr(fit, f.name)
            stored = column if isinstance(column, str | bool) else column[i]
            if isinstance(stored, np.ndarray):
                np.testing.assert_array_equal(value, stored)
            elif isinstance(stored, np.floating):
                assert value == (float(stored) if np.isfinite(stored) else None)
            else:
                assert value == stored
    assert plain(fits[-3]) == plain(fits.rows()[-3])
    with pytest.raises(IndexError):
        fits[len(fits)]


def test_planes_from_many_normals_equal_those_from_single_ones():
    rng = np.random.default_rng(3)
    normals = [*rng.normal(size=(200, 3)), [0, 0, 1], [0, 0, -2], [1, 0, 0], [0, -1, 1e-300]]
    assert Plane.from_normals(normals) == [Plane.from_normal(n) for n in normals]
    assert Plane.from_normals([]) == []


@given(st.floats(-1e9, 1e9) | st.sampled_from([0.0, -0.0, 360.0, -1e-20, 720.0, -360.0]))
def test_single_azimuth_is_wrapped_like_an_array(angle):
    one, many = wrap360(angle), wrap360(np.array([angle]))[0]
    assert (one, np.signbit(one)) == (many, np.signbit(many))
    assert 0.0 <= one < 360.0


def test_disc_is_in_its_plane_around_its_centre():
    rng = np.random.default_rng(5)
    for _ in range(20):
        normal = rng.normal(size=3)
        normal /= np.linalg.norm(normal)
        centre = rng.uniform(-1e3, 1e3, 3)
        off = disc(centre, normal, 2.5) - centre
        np.testing.assert_allclose(np.linalg.norm(off, axis=1), 2.5, rtol=1e-9)
        np.testing.assert_allclose(off @ normal, 0.0, atol=1e-9)
        turns = np.cross(off, np.roll(off, -1, axis=0)) @ normal
        assert (turns > 0.0).all() or (turns < 0.0).all()


def test_measurements_follow_every_edit_of_a_document():
    records = RecordMap({r.id: r for r in (*DEFAULT_TYPES, *models(), *traces())})
    keep = Measurements()
    first = keep.of(records, list(records))
    moved = bed("t0", 3.0)
    records.apply({"t0": moved, "t1": None})
    keep.keep_after_edit(records, ["t0", "t1"])
    after = keep.of(records, list(records))
    assert "t1" not in after
    assert {i for i in after if after[i] is not first[i]} == {"t0"}
    np.testing.assert_array_equal(after["t0"].points, np.asarray(moved.vertices, float))
    # An edit that nobody told of is seen as well.
    records.apply({"t2": bed("t2", 5.0)})
    again = keep.of(records, list(records))
    assert {i for i in again if again[i] is not after[i]} == {"t2"}
