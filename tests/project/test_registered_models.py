"""A model that was registered hands the error of that on to what is measured on it."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from tests.messages import with_code
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.registrations import Registration, RegistrationPoint
from vomstudio.project import codec, edits
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.measurement import Measurement
from vomstudio.project.measurement_cache import measure_all
from vomstudio.project.records import Model

FACTOR = float(np.sqrt(chi2.ppf(0.95, 2)))
FRAME = Frame("crs", crs="EPSG:32633")


def registered(**errors: object) -> Registration:
    return Registration("r1", "points", "points", FRAME, **errors)  # type: ignore[arg-type]


def trace_of(dip_deg: float) -> Trace:
    """A rough trace on a plane that dips east, on model m1."""
    rng = np.random.default_rng(1)
    y = np.linspace(-5.0, 5.0, 40)
    x = 2.0 * np.sin(y)
    z = -np.tan(np.radians(dip_deg)) * x
    points = np.column_stack([x, y, z]) + rng.normal(0.0, 0.002, (40, 3))
    vertices = tuple(map(tuple, points.tolist()))
    return Trace("t1", "t", "bedding", "m1", "hash", vertices, resolution=0.001, rule=1)


def measured(placement: Registration | Frame, dip_deg: float = 30.0) -> Measurement:
    model = Model("m1", "m", "m.ply", "mesh", "hash", placement)
    (found,) = measure_all({"m1": model, "t1": trace_of(dip_deg)}, [trace_of(dip_deg)])
    return found


def test_declared_model_has_no_registration_error() -> None:
    assert measured(FRAME).registration_error_deg is None


def test_plane_error_comes_from_rotations_perpendicular_to_its_pole() -> None:
    """Turned about north by 2 degrees (1 sigma), the axis of strike: the whole of it is dip."""
    found = measured(registered(rotation_error_deg=(0.0, 0.0, 2.0)))
    assert found.registration_error_deg == pytest.approx(2.0 * FACTOR, rel=1e-3)
    # About up it moves the pole by the sine of the dip.
    found = measured(registered(rotation_error_deg=(2.0, 0.0, 0.0)))
    assert found.registration_error_deg == pytest.approx(2.0 * FACTOR * 0.5, rel=1e-2)


def test_verdict_uses_the_total_error_and_states_the_deciding_part() -> None:
    good = measured(FRAME)
    assert good.verdict is not None
    assert good.verdict.quality == "good"
    bad = measured(registered(rotation_error_deg=(0.0, 0.0, 4.0)))
    assert bad.verdict is not None
    assert bad.verdict.quality == "doubtful"
    (reason,) = with_code(bad.verdict.reasons, "plane.registration")
    assert reason.values == {
        "error_deg": pytest.approx(bad.registration_error_deg),
        "limit_deg": 5.0,
    }
    worse = measured(registered(rotation_error_deg=(0.0, 0.0, 8.0)))
    assert worse.verdict is not None
    assert worse.verdict.quality == "poor"


def test_covariance_overrides_the_axis_errors() -> None:
    covariance = np.zeros((7, 7))
    covariance[1, 1] = np.radians(3.0) ** 2
    rows = tuple(map(tuple, covariance.tolist()))
    record = registered(covariance=rows, rotation_error_deg=(9.0, 9.0, 9.0))
    assert measured(record).registration_error_deg == pytest.approx(3.0 * FACTOR, rel=1e-3)


def test_registering_a_model_updates_its_measurements() -> None:
    model = Model("m1", "m", "m.ply", "mesh", "hash", FRAME)
    records = {"m1": model, "t1": trace_of(30.0)}
    edit = edits.set_registration(records, registered(rotation_error_deg=(0, 0, 2.0)), ["m1"])
    after = {**records, **{id_: r for id_, r in edit.after.items() if r is not None}}
    (found,) = measure_all(after, [after["t1"]])
    assert found.registration_error_deg == pytest.approx(2.0 * FACTOR, rel=1e-3)


def test_control_points_and_covariance_survive_encoding() -> None:
    point = RegistrationPoint("A", (1.0, 2.0, 3.0), (4.0, 5.0, 6.0), (0.01, -0.02, 0.0), None, True)
    known = replace(point, label="B", sigma_m=(0.01, 0.01, 0.02), check=False)
    covariance = tuple(tuple(float(i == j) for j in range(7)) for i in range(7))
    record = registered(control=(point, known), covariance=covariance, centre=(1.0, 2.0, 3.0))
    plain = json.loads(json.dumps(codec.encode(record)))
    assert codec.decode(plain) == record
