"""What a panel and a report say of a registration, by whatever it was found."""

from __future__ import annotations

from typing import get_args, get_type_hints

import numpy as np
import pytest

from tests.messages import with_code
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.registrations import Registration, RegistrationPoint
from vomstudio.registration.summary import summarize_registration

METHOD_NAMES = get_args(get_type_hints(Registration)["method"])
HERE = (0.0, 0.0, 0.0)
POINTS = tuple(RegistrationPoint(f"P{i}", HERE, HERE, (0.01, 0.0, 0.0)) for i in range(3))


def registration(method: str, **more: object) -> Registration:
    spread = np.diag([*np.radians([2.0, 1.0, 0.5]) ** 2, 1e-6, 1.0, 1.0, 1.0])
    return Registration(
        "r1",
        "r1",
        method,
        Frame("local"),
        control=POINTS,
        scale_error=1e-3,
        covariance=tuple(map(tuple, spread.tolist())),
        centre=HERE,
        **more,
    )


@pytest.mark.parametrize("method", METHOD_NAMES)
def test_summary_covers_every_registration_method(method: str) -> None:
    told = summarize_registration(registration(method))
    facts = {fact.code: fact for fact in told.facts}
    assert facts["method"].values == {"method": method}
    assert all(fact.name and fact.text for fact in told.facts)
    # 1.96 times two degrees about east, which is the weakest axis.
    assert facts["turned-about-east"].values["error95_deg"] == pytest.approx(3.92, abs=1e-3)
    assert facts["weakest-axis"].values["error95_deg"] == pytest.approx(3.92, abs=1e-3)
    assert facts["turned-about-east"].text == "± 3.9°"
    assert told.rotation is not None
    assert told.rotation.values["error95_deg"] == pytest.approx(3.92, abs=1e-3)
    assert "3.9" in told.rotation.message


def test_fit_to_reference_needs_no_redundant_or_check_points() -> None:
    by_points = {each.code for each in summarize_registration(registration("points")).warnings}
    judged = {"control.no-redundancy", "control.no-check-points"}
    assert judged <= by_points
    fitted = {each.code for each in summarize_registration(registration("reference")).warnings}
    assert not judged & fitted


def test_rotation_error_beyond_180_degrees_is_reported_as_unknown() -> None:
    """One of four points is clicked where another one is: one sigma came out as 120 degrees, and
    as 451448516490.5 where the points were a little different."""
    from vomstudio.registration.placing import register_points

    model = np.array([[0, 0, 0], [12, 0.3, 2.3], [3, -0.3, 4], [12, 0.1, 0]], float)
    world = model.copy()
    world[3] = model[0]
    warnings = register_points(model, world).warnings
    assert with_code(warnings, "registration.rotation-unknown")
    assert not with_code(warnings, "registration.weak-rotation")
