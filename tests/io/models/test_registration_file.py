"""`NAME.registration.json`: what is written is read again, and what cannot be used is a finding."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial.transform import Rotation

from tests.registrations import registration, similarity
from vomstudio.core.errors import TargetError
from vomstudio.geometry import transform
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.registration_frames import change_file_frame, change_world_frame
from vomstudio.geometry.registrations import Registration
from vomstudio.geometry.rotation_errors import errors_95_deg
from vomstudio.io.models.registration_file import (
    find_registration,
    registration_path,
    write_registration,
)

Array = npt.NDArray[np.float64]


@pytest.fixture
def model(tmp_path: Path) -> Path:
    path = tmp_path / "cliff.v2.ply"
    path.write_bytes(b"the bytes of a model")
    return path


def hash_of(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


# --- the file -------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    "record",
    [
        registration(),
        registration(covariance=None, centre=None, read_north=None, observations=()),
        replace(registration(), method="lines", frame=Frame("scaled", level=True)),
    ],
)
def test_registration_record_round_trips(model: Path, record: Registration) -> None:
    written = write_registration(record, [model])
    assert written == registration_path(model) == model.with_name("cliff.v2.registration.json")
    found = find_registration(model, hash_of(model))
    assert found.findings == ()
    assert found.registration is not None
    # The id is that of a record in a project, not of the file.
    assert replace(found.registration, id=record.id) == record


def test_file_states_parameters_with_their_units(model: Path) -> None:
    record = registration()
    plain = json.loads(write_registration(record, [model]).read_text("utf-8"))
    assert (plain["format"], plain["version"]) == ("vomstudio registration", 1)
    assert plain["files"] == {model.name: hash_of(model)}
    assert (plain["crs"], plain["north"]) == ("EPSG:32633", "grid")
    told = plain["covariance"]
    assert len(told["parameters"]) == len(told["units"]) == len(told["matrix"]) == 7
    sigma = np.sqrt(np.diag(told["matrix"]))[told["parameters"].index("turn_up")]
    rotation = record.rotation_covariance()
    assert rotation is not None
    assert sigma == pytest.approx(np.sqrt(rotation[2, 2]))
    assert plain["evidence"]["observations"][0]["count"] == 2


def test_models_with_the_same_name_share_one_registration_file(model: Path) -> None:
    other = model.with_suffix(".obj")
    other.write_bytes(b"the same surface in another format")
    write_registration(registration(), [model])
    write_registration(registration(), [other])
    for path in (model, other):
        assert find_registration(path, hash_of(path)).registration is not None
    another = registration(scale_error=0.5)
    with pytest.raises(TargetError):
        write_registration(another, [other])
    write_registration(another, [other], force=True)
    assert find_registration(other, hash_of(other)).registration is not None
    (finding,) = find_registration(model, hash_of(model)).findings
    assert finding.code == "registration.other-model"


def test_model_without_registration_file_has_no_registration_or_finding(model: Path) -> None:
    found = find_registration(model, hash_of(model))
    assert (found.registration, found.findings) == (None, ())


def changed(key: str, value: Any) -> Callable[[dict[str, Any]], None]:
    def change(plain: dict[str, Any]) -> None:
        *path, last = key.split("/")
        for name in path:
            plain = plain[name]
        if value is None:
            del plain[last]
        else:
            plain[last] = value

    return change


NEGATIVE = (-np.eye(7)).tolist()
SHORT = np.eye(6).tolist()
SKEWED = (np.eye(7) + np.eye(7, k=1) * 0.5).tolist()


@pytest.mark.parametrize(
    ("change", "code"),
    [
        (changed("format", "vomstudio cameras"), "damaged"),
        (changed("version", 2), "unknown-version"),
        (changed("version", None), "unknown-version"),
        (changed("files", ["cliff.ply"]), "damaged"),
        (changed("files", {"cliff.ply": "0" * 64}), "other-model"),
        (changed("matrix", None), "damaged"),
        (changed("matrix", np.diag([1.0, 2.0, 1.0, 1.0]).tolist()), "damaged"),
        (changed("matrix", np.diag([-1.0, 1.0, 1.0, 1.0]).tolist()), "damaged"),
        (changed("matrix", np.diag([1e200] * 3 + [1.0]).tolist()), "damaged"),
        (changed("matrix", "none"), "damaged"),
        (changed("covariance/matrix", NEGATIVE), "damaged"),
        (changed("covariance/matrix", SHORT), "damaged"),
        (changed("covariance/matrix", SKEWED), "damaged"),
        (changed("covariance/matrix", [[1e300] * 7] * 7), "damaged"),
        (changed("covariance/units", ["deg"] * 3 + ["1"] + ["m"] * 3), "damaged"),
        (changed("covariance/centre", [0.0, 0.0]), "damaged"),
        (changed("covariance", 5), "damaged"),
        (changed("crs", "EPSG:4326"), "damaged"),
        (changed("crs", "EPSG:2225"), "damaged"),
        (changed("crs", None), "damaged"),
        (changed("frame", ["crs"]), "damaged"),
        (changed("method", "by guess"), "damaged"),
        (changed("scale_error", -0.1), "damaged"),
        (changed("evidence", []), "damaged"),
        (changed("evidence/observations", [{"kind": 5, "labels": ["A"]}]), "damaged"),
        (changed("evidence/control", [{"label": "A"}]), "damaged"),
        (changed("shape/normal", [1.0]), "damaged"),
    ],
)
def test_unusable_registration_gives_a_finding_with_code(
    model: Path, change: Callable[[dict[str, Any]], None], code: str
) -> None:
    path = write_registration(registration(), [model])
    plain = json.loads(path.read_text("utf-8"))
    change(plain)
    path.write_text(json.dumps(plain), "utf-8")
    found = find_registration(model, hash_of(model))
    assert found.registration is None
    (finding,) = found.findings
    assert finding.code == f"registration.{code}"
    assert finding.values["file"] == path.name
    assert finding.message


@pytest.mark.parametrize("content", [b"", b"[]", b"5", b"{", b"\xff\xfe", b"[" * 100_000])
def test_file_that_is_not_a_registration_is_reported_as_damaged(
    model: Path, content: bytes
) -> None:
    registration_path(model).write_bytes(content)
    found = find_registration(model, hash_of(model))
    assert [each.code for each in found.findings] == ["registration.damaged"]


# --- other axes -----------------------------------------------------------------------------------
def normals(count: int) -> Array:
    vectors = np.random.default_rng(9).normal(size=(count, 3))
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def test_a_rotation_of_world_rotates_the_covariance() -> None:
    record = registration()
    turn = Rotation.from_euler("zxy", [77.0, -31.0, 15.0], degrees=True).as_matrix()
    by = similarity(1.0, turn, np.array([10.0, -20.0, 5.0]))
    moved = change_world_frame(record, by, Frame("local"))
    before, after = record.rotation_covariance(), moved.rotation_covariance()
    assert before is not None
    assert after is not None
    directions = normals(20)
    assert errors_95_deg(after, directions @ turn.T) == pytest.approx(
        errors_95_deg(before, directions), rel=1e-9
    )
    assert moved.scale_error == record.scale_error
    box = np.array([[-8.0, -3.0, -5.0], [8.0, 3.0, 5.0]])
    corners = np.array(np.meshgrid(*box.T)).reshape(3, -1).T + record.centre
    # The error of every place, not only that of directions.
    for place in corners:
        assert place_error(moved, transform.apply(by, [place])[0]) == pytest.approx(
            place_error(record, place), rel=1e-6
        )
    back = change_world_frame(moved, transform.invert(by), record.frame)
    assert np.array(back.covariance) == pytest.approx(np.array(record.covariance), abs=1e-12)
    assert np.array(back.matrix) == pytest.approx(np.array(record.matrix), rel=1e-9)
    assert back.control[0].world == pytest.approx(record.control[0].world)
    assert back.control[0].residual == pytest.approx(record.control[0].residual)


def place_error(record: Registration, place: Array) -> float:
    """One sigma of the distance of a place from where it is."""
    from vomstudio.registration.similarity import jacobian

    assert record.centre is not None
    moves = jacobian(place - record.centre)
    return float(np.sqrt(np.trace(moves @ np.array(record.covariance) @ moves.T)))


def test_changing_the_world_unit_scales_lengths_and_not_angles() -> None:
    record = registration()
    moved = change_world_frame(record, np.diag([2.0, 2.0, 2.0, 1.0]), Frame("local"))
    assert np.array(moved.covariance)[:4, :4] == pytest.approx(
        np.array(record.covariance)[:4, :4], rel=1e-12
    )
    assert np.diag(moved.covariance)[4:] == pytest.approx(4.0 * np.diag(record.covariance)[4:])
    assert moved.rms_control_m == pytest.approx(0.022)
    assert moved.reach_m == pytest.approx(24.0)


def test_changing_the_file_frame_keeps_position_and_errors() -> None:
    record = registration()
    by = similarity(0.01, Rotation.from_euler("x", 90, degrees=True).as_matrix(), np.ones(3))
    moved = change_file_frame(record, by)
    places = np.random.default_rng(1).uniform(-5, 5, (6, 3))
    assert transform.apply(moved.matrix, transform.apply(by, places)) == pytest.approx(
        transform.apply(record.matrix, places), rel=1e-12
    )
    assert (moved.covariance, moved.centre) == (record.covariance, record.centre)
    in_world = change_file_frame(record, record.matrix)
    assert np.array_equal(in_world.matrix, np.eye(4))
    assert in_world.control[0].model == pytest.approx(
        transform.apply(record.matrix, [record.control[0].model])[0]
    )
