"""Frames, types and the plain records, as files and other parts of the program rely on them."""

from __future__ import annotations

import re

import numpy as np
import pytest

from vomstudio.geometry.frames import UNDECLARED_FRAME, Frame
from vomstudio.geometry.matrices import IDENTITY
from vomstudio.geometry.registrations import Registration
from vomstudio.project.codec import decode
from vomstudio.project.edits import suggest_type
from vomstudio.project.records import (
    DEFAULT_TYPES,
    FeatureType,
    MarkedPoint,
    Model,
    PhotoSet,
    ReconstructionRecord,
    get,
    get_feature,
)

MODEL = Model("m1", "cliff", "cliff.obj", "mesh", "0" * 64)
MATRIX = ((0.0, -2.0, 0.0, 5.0), (2.0, 0.0, 0.0, 6.0), (0.0, 0.0, 2.0, 7.0), (0.0, 0.0, 0.0, 1.0))


# Frames


@pytest.mark.parametrize("unit", [1.0, 0.001, 0.3048])
def test_frame_maps_file_axes_to_world_axes(unit: float) -> None:
    """z up: as it is. y up, as glTF has it: x east, y up, z south."""
    up = np.array(Frame("local", None, unit, "z").to_world())
    assert up.tolist() == np.diag([unit, unit, unit, 1.0]).tolist()
    gltf = np.array(Frame("local", None, unit, "y").to_world())
    east, north, high = np.eye(3)
    for axis, towards in zip(np.eye(3), (east, high, -north), strict=True):
        assert (gltf[:3, :3] @ axis).tolist() == (unit * towards).tolist()
    assert gltf[:3, 3].tolist() == [0.0, 0.0, 0.0]
    assert gltf[3].tolist() == [0.0, 0.0, 0.0, 1.0]


def test_frame_name_states_whether_north_and_scale_are_known() -> None:
    for frame, north, metres, words in (
        (Frame("crs", "EPSG:32633"), True, True, "EPSG:32633, grid north"),
        (Frame("local"), True, True, "local, north known"),
        (Frame("scaled"), False, True, "local frame in metres: not registered"),
        (UNDECLARED_FRAME, False, False, "local frame: not registered"),
    ):
        assert (frame.has_north, frame.has_metres, frame.name()) == (north, metres, words)


def test_model_without_frame_keeps_its_file_coordinates() -> None:
    assert np.array(IDENTITY).tolist() == np.eye(4).tolist()
    assert MODEL.frame == UNDECLARED_FRAME
    assert np.array(MODEL.to_world).tolist() == np.eye(4).tolist()
    assert MODEL.registration is None
    assert np.array(Registration("g", "g", "gps").to_world()).tolist() == np.eye(4).tolist()


def test_model_transform_comes_from_its_frame_or_registration() -> None:
    by = Registration("g1", "control", "control", Frame("crs", "EPSG:32633"), MATRIX)
    model = Model("m1", "cliff", "cliff.obj", "mesh", "0" * 64, by)
    assert (model.registration, model.frame, model.to_world) == (by, by.frame, MATRIX)
    declared = Frame("local", None, 0.01, "y")
    model = Model("m1", "cliff", "cliff.obj", "mesh", "0" * 64, declared)
    assert model.registration is None
    assert (model.frame, model.to_world) == (declared, declared.to_world())


# Types


def test_default_types_have_distinct_colours_and_symbols() -> None:
    assert len({kind.color for kind in DEFAULT_TYPES}) == len(DEFAULT_TYPES)
    for geometry in ("plane", "line"):
        own = [kind.symbol for kind in DEFAULT_TYPES if kind.geometry == geometry]
        assert own
        assert len(set(own)) == len(own)
    # A suggestion takes from the symbols that the net can draw.
    known, records = set(), {}
    for number in range(12):
        kind = suggest_type(records, str(number))
        records[kind.id] = kind
        known.add(kind.symbol)
    for kind in DEFAULT_TYPES:
        # The id is in every journal there is, and the fallback where a type is gone.
        assert kind.id == kind.name.casefold().replace(" ", "_")
        assert re.fullmatch(r"[A-Z][a-z ]+", kind.name)
        assert re.fullmatch(r"#[0-9a-f]{6}", kind.color)
        assert kind.symbol in known
        assert kind.geometry == ("line" if kind.id in ("fold_axis", "lineation") else "plane")
    assert FeatureType("d", "Dyke", "#123456").geometry == "plane"


# What older journals leave out


def test_missing_record_fields_get_default_values() -> None:
    """Fields come with versions: a journal from before them must open and claim nothing."""
    photos = decode({"record": "photo_set", "id": "s", "name": "p", "path": "p"})
    assert photos == PhotoSet("s", "p", "p", "")
    point = decode({"record": "marked_point", "id": "q", "photo_set_id": "s", "label": "A"})
    assert point == MarkedPoint("q", "s", "A", None, None, False)
    made = decode(
        {
            "record": "reconstruction",
            "id": "c",
            "photo_set_id": "s",
            "name": "n",
            "folder": "f",
            "quality": "low",
            "result_sha256": "0",
        }
    )
    assert isinstance(made, ReconstructionRecord)
    assert (made.photos, made.registered, made.settings) == (0, 0, ())
    assert (made.reprojection_error_px, made.software, made.finished) == (None, "", "")
    common = {"id": "f", "name": "F", "type_id": "bedding", "model_id": "m", "model_hash": "0"}
    trace = decode({"record": "trace", **common, "vertices": []})
    assert (trace.overturned, trace.method, trace.set_name) == (False, "pca", "")
    patch = decode(
        {
            "record": "patch",
            **common,
            "element": "face",
            "runs": [],
            "n": 0,
            "mean": [0, 0, 0],
            "scatter": [[0, 0, 0]] * 3,
            "n_effective": 0,
        }
    )
    assert (patch.overturned, patch.area, patch.outline) == (False, None, ())
    reading = decode(
        {
            "record": "reading",
            "id": "r",
            "name": "R",
            "type_id": "bedding",
            "geometry": "plane",
            "azimuth_deg": 1.0,
            "inclination_deg": 2.0,
        }
    )
    assert (reading.turned_deg, reading.overturned, reading.position) == (0.0, False, None)


# Asking for one


def test_a_record_is_found_by_its_id_and_class() -> None:
    records = {"m1": MODEL, "bedding": DEFAULT_TYPES[0]}
    assert get(records, "m1", Model) is MODEL
    assert get(records, "m1", FeatureType) is get(records, "m2", Model) is None
    assert get(records, None, Model) is get_feature(records, "m1") is None
