"""What edits do to the records, what they refuse, and what they call themselves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from tests.messages import refused
from tests.samples import ZIGZAG, bed, placed
from vomstudio.core.errors import DocumentError, GeometryError
from vomstudio.core.identifiers import new_id
from vomstudio.geometry.frames import UNDECLARED_FRAME, Frame
from vomstudio.project import edits
from vomstudio.project.edit import Edit, change
from vomstudio.project.kinds.dimension import Dimension
from vomstudio.project.kinds.intersection import Intersection
from vomstudio.project.kinds.lineation import Lineation
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.records import (
    DEFAULT_TYPES,
    SURROUNDINGS_RULE,
    FeatureType,
    Group,
    Model,
    Record,
)

HASH = "0" * 64
MODEL = Model("m1", "cliff", "cliff.obj", "mesh", HASH, Frame("local"))
TRACE = replace(bed("t1"), name="B01")
PATCH = Patch(
    "p1",
    "B02",
    "bedding",
    "m1",
    HASH,
    "face",
    ((0, 9),),
    9,
    (0.0, 0.0, 0.0),
    ((4.0, 0.0, 0.0), (0.0, 2.0, 0.0), (0.0, 0.0, 0.01)),
    9.0,
)
LINE = Lineation("l1", "L01", "lineation", "m1", HASH, ((0.0, 0.0, 0.0), (1.0, 0.0, -1.0)))
READING = Reading("r1", "B03", "bedding", "plane", 120.0, 40.0)
LENGTH = Dimension("d1", "D01", "distance", "m1", HASH, ((0.0, 0.0, 0.0), (3.0, 0.0, 0.0)))
MEETING = Intersection("i1", "F01", "fault", Group("t1"), Group("p1"))
FEATURES = (TRACE, PATCH, LINE, READING, LENGTH, MEETING)


def records(*some: Record) -> dict[str, Record]:
    return {r.id: r for r in (*DEFAULT_TYPES, MODEL, *(some or FEATURES))}


def done(before: dict[str, Record], edit: Edit) -> dict[str, Record]:
    after = dict(before)
    edit.swap(after)
    return after


# Nothing is replaced unasked


@pytest.mark.parametrize("feature", [PATCH, LINE, READING, LENGTH, MEETING, TRACE])
def test_feature_with_an_existing_id_is_not_added(feature: Record) -> None:
    there = records()
    for id_ in (feature.id, "t1", "m1", "bedding"):
        again = replace(feature, id=id_, notes="another")
        with refused("record.exists", DocumentError):
            edits.add_features(there, [again])
        if isinstance(again, Reading):
            with refused("record.exists", DocumentError):
                edits.add_readings(there, [again])
    trace = replace(bed("x"), id=feature.id, name="another")
    with refused("record.exists", DocumentError, name="another"):
        edits.add_trace(there, trace)
    fresh = replace(feature, id="new")
    with refused("record.exists", DocumentError):
        edits.add_features(there, [fresh, fresh])


def test_reading_type_or_model_with_an_existing_id_is_not_added() -> None:
    there = records()
    reading = replace(READING, id="new")
    with refused("record.exists", DocumentError):
        edits.add_readings(there, [reading, reading])
    kind = FeatureType("bedding", "Dyke", "#123456")
    with refused("record.exists", DocumentError, name="Dyke"):
        edits.add_type(there, kind)
    with refused("record.exists", DocumentError, name="Dyke"):
        edits.add_readings(there, [reading], [kind])
    with refused("record.exists", DocumentError):
        edits.add_model(there, MODEL)


def test_undo_restores_a_replaced_record() -> None:
    there = records()
    edit = change(there, "Change", {"t1": replace(TRACE, notes="x"), "new": READING, "p1": None})
    after = done(there, edit)
    assert "p1" not in after
    assert done(after, edit.inverse()) == there
    with refused("edit.stale", DocumentError):
        edit.swap(after)
    assert "p1" not in after
    loose = dict(after)
    edit.swap(loose, strict=False)
    assert loose == after
    with pytest.raises(ValueError, match="records"):
        Edit("x", {"a": None}, {})


# Labels

TURNED = placed(MODEL, [[2, 0, 0, 1], [0, 2, 0, 2], [0, 0, 2, 3], [0, 0, 0, 1]])
DYKE = FeatureType("n", "Dyke", "#aBcDeF")
EDITS: tuple[Callable[[dict[str, Record]], Edit], ...] = (
    lambda there: edits.add_features(there, [replace(PATCH, id="n"), replace(LINE, id="m")]),
    lambda there: edits.add_features(there, [replace(LENGTH, id="n", name="")]),
    lambda there: edits.add_trace(there, bed("n")),
    lambda there: edits.add_trace(there, replace(bed("n"), name="Limb")),
    lambda there: edits.add_readings(there, [replace(READING, id=f"n{k}") for k in range(5)]),
    lambda there: edits.add_readings(there, [replace(READING, id="n")]),
    lambda there: edits.set_attributes(there, ["t1", "p1"], set_name="S1", type_id="fault"),
    lambda there: edits.set_attributes(there, ["t1"], notes="wet"),
    lambda there: edits.add_type(there, DYKE),
    lambda there: edits.change_type(there, replace(DEFAULT_TYPES[0], color="#123456")),
    lambda there: edits.remove_type(there, "vein"),
    lambda there: edits.declare_frame(there, "m1", Frame("crs", "EPSG:32633", 0.001, "y")),
    lambda there: edits.declare_frame(
        there | {"m1": TURNED}, "m1", Frame("local"), replaces_registration=True
    ),
    lambda there: edits.relocate_model(there, "m1", "there/cliff.obj", HASH),
    lambda _: edits.remove_model(records(READING), "m1"),
    lambda there: edits.set_registration(there, TURNED.registration, ["m1"]),
)


def test_edits_have_descriptive_labels() -> None:
    assert [make(records()).label for make in EDITS] == [
        "Add 2 features",
        "Add distance D02",
        "Add bedding trace B04",
        "Add bedding trace Limb",
        "Import 5 field measurements",
        "Import 1 field measurement",
        "Change set and type of 2 features",
        "Change notes of B01",
        "Add feature type Dyke",
        "Change feature type Bedding",
        "Remove feature type Vein",
        "Declare the frame of cliff",
        "Declare the frame of cliff, in place of its registration",
        "Locate cliff",
        "Remove model cliff",
        "Register by turned",
    ]


# Adding


def test_added_features_continue_the_numbering_with_their_labels() -> None:
    there = records()
    edit = edits.add_features(there, [replace(PATCH, id="n1", name=""), replace(LINE, id="n2")])
    assert list(edit.after) == ["n1", "n2"]
    assert edit.after["n1"].name == "B04"  # type: ignore[union-attr]
    assert edit.after["n2"].name == "L01"  # type: ignore[union-attr]
    pair = edits.add_features(
        there, [replace(PATCH, id="n1", name=""), replace(PATCH, id="n2", name="")]
    )
    assert [r.name for r in pair.after.values()] == ["B04", "B05"]  # type: ignore[union-attr]
    named = edits.add_trace(there, replace(bed("n"), name="Limb"))
    assert named.after["n"].name == "Limb"  # type: ignore[union-attr]
    with refused("edit.empty", DocumentError):
        edits.add_features(there, [])


def test_naming_thousands_of_features_examines_each_name_once(monkeypatch) -> None:
    looked = []
    own = edits.name_number
    monkeypatch.setattr(edits, "name_number", lambda *of: looked.append(of) or own(*of))
    count = 3000
    many = [replace(PATCH, id=f"n{i}", name="") for i in range(count)]
    many[10] = replace(many[10], name="B70")
    added = list(edits.add_features(records(), many).after.values())
    names = [feature.name for feature in added]  # type: ignore[union-attr]
    assert names[:12] == [f"B{n:02d}" for n in (*range(4, 14), 70, 71)]
    assert len(set(names)) == count
    assert len(looked) <= count


def test_features_with_missing_dependencies_are_not_added() -> None:
    there = records()
    nowhere, unknown = {"model_id": "m9"}, {"type_id": "dyke"}
    for feature in (PATCH, LINE, LENGTH):
        with refused("record.missing", DocumentError, kind="model", id="m9"):
            edits.add_features(there, [replace(feature, id="n", **nowhere)])
    for feature in (PATCH, LINE, READING, MEETING):
        with refused("record.missing", DocumentError, kind="feature type", id="dyke"):
            edits.add_features(there, [replace(feature, id="n", **unknown)])
    with refused("record.missing", DocumentError, id="m9"):
        edits.add_trace(there, replace(bed("n"), **nowhere))
    with refused("record.missing", DocumentError, id="dyke"):
        edits.add_trace(there, replace(bed("n"), **unknown))
    # A type is no model, and a model no type.
    with refused("record.missing", DocumentError, kind="model", id="bedding"):
        edits.add_trace(there, replace(bed("n"), model_id="bedding"))
    with pytest.raises(GeometryError):
        edits.add_trace(there, replace(bed("n"), vertices=ZIGZAG[:2]))


def test_readings_are_numbered_within_their_type_and_add_new_types() -> None:
    there = records()
    dyke = FeatureType("dyke", "Dyke", "#123456")
    many = [replace(READING, id=f"n{k}", name="") for k in range(3)]
    many += [replace(READING, id="n3", name="", type_id="dyke"), replace(READING, id="n4")]
    edit = edits.add_readings(there, many, [dyke])
    names = [edit.after[f"n{k}"].name for k in range(5)]  # type: ignore[union-attr]
    assert names == ["B04", "B05", "B06", "D02", "B03"]
    assert edit.after["dyke"] == dyke
    with refused("edit.empty", DocumentError):
        edits.add_readings(there, [], [dyke])
    with refused("record.missing", DocumentError, id="dyke"):
        edits.add_readings(there, many)
    with refused("name.taken", DocumentError, name="Dyke"):
        edits.add_readings(there, many, [dyke, replace(dyke, id="other")])


# Changing


def test_changing_vertices_keeps_all_other_fields() -> None:
    there = records()
    moved = tuple((x, y, z + 1.0) for x, y, z in ZIGZAG)
    edit = edits.set_vertices(
        there, "t1", list(moved), resolution=0.05, outcrop_normal=(0.0, 0.0, 1.0)
    )
    assert edit.label == "Change trace B01"
    assert edit.after["t1"] == replace(
        TRACE,
        vertices=moved,
        resolution=0.05,
        outcrop_normal=(0.0, 0.0, 1.0),
        rule=SURROUNDINGS_RULE,
    )
    with pytest.raises(GeometryError):
        edits.set_vertices(there, "t1", moved[:2], resolution=None, outcrop_normal=None)
    with refused("record.missing", DocumentError, kind="trace", id="p1"):
        edits.set_vertices(there, "p1", moved, resolution=None, outcrop_normal=None)
    line = edits.set_line(there, "l1", moved[:2], resolution=0.1)
    assert line.after["l1"] == replace(LINE, vertices=moved[:2], resolution=0.1)
    assert line.label == "Change L01"
    length = edits.set_line(there, "d1", moved[:2], resolution=0.1)
    assert length.after["d1"] == replace(LENGTH, vertices=moved[:2], resolution=0.1)
    with refused("feature.has-plane", DocumentError, feature="B01"):
        edits.set_line(there, "t1", moved)


def test_feature_is_replaced_only_by_one_of_its_kind() -> None:
    there = records()
    grown = replace(PATCH, n=12)
    edit = edits.change_feature(there, grown, "Grow")
    assert (edit.label, edit.after["p1"]) == ("Grow B02", grown)
    assert edits.change_feature(there, grown).label == "Change B02"
    with refused("record.missing", DocumentError, kind="trace", id="p1"):
        edits.change_feature(there, replace(TRACE, id="p1"))
    with refused("record.missing", DocumentError, kind="patch", id="new"):
        edits.change_feature(there, replace(PATCH, id="new"))


def test_attributes_are_changed_only_if_all_features_have_them() -> None:
    there = records()
    edit = edits.set_attributes(there, ["t1", "p1"], set_name="S1", type_id="fault")
    assert edit.after == {
        "t1": replace(TRACE, set_name="S1", type_id="fault"),
        "p1": replace(PATCH, set_name="S1", type_id="fault"),
    }
    for values, code, told in (
        ({"type_id": "dyke"}, "record.missing", {"kind": "feature type", "id": "dyke"}),
        ({"name": "  "}, "name.empty", {"field": "name"}),
        ({"name": "9" * 201}, "name.too-long", {"field": "name"}),
        ({"set_name": "9" * 201}, "name.too-long", {"field": "name"}),
        ({"slip": "normal"}, "feature.no-attribute", {"feature": "B01", "attribute": "slip"}),
        ({"plane_id": "p1"}, "feature.no-attribute", {"attribute": "plane id"}),
    ):
        with refused(code, DocumentError, **told):
            edits.set_attributes(there, ["t1"], **values)
    with refused("selection.empty", DocumentError):
        edits.set_attributes(there, [], notes="x")
    with refused("record.missing", DocumentError, kind="feature", id="m1"):
        edits.set_attributes(there, ["m1"], name="x")


@pytest.mark.parametrize("text", ["Bed\nupper", "Bed\r\nupper", "Bed\N{LINE SEPARATOR}upper"])
def test_names_are_reduced_to_one_line_and_notes_keep_theirs(text: str) -> None:
    before = records()
    edit = edits.set_attributes(before, ["t1"], name=text, set_name=text, notes=text)
    after = done(before, edit)["t1"]
    assert (after.name, after.set_name, after.notes) == ("Bed upper", "Bed upper", text)
    edit = edits.set_attributes(done(before, edit), ["t1"], name="B01")
    assert "\n" not in edit.label
    kind = FeatureType("x", text, "#332288", "circle", "plane")
    assert done(before, edits.add_type(before, kind))["x"].name == "Bed upper"


def test_delete_removes_the_given_features_and_its_label_counts_them() -> None:
    there = records()
    edit = edits.delete(there, ["t1", "l1"])
    assert edit.label == "Delete 2 features"
    assert set(there) - set(done(there, edit)) == {"t1", "l1"}
    assert edits.delete(there, ["t1"]).label == "Delete B01"
    with refused("selection.empty", DocumentError):
        edits.delete(there, [])
    with refused("record.missing", DocumentError, kind="feature", id="bedding"):
        edits.delete(there, ["bedding"])


def test_names_continue_from_the_highest_number_of_their_letter() -> None:
    there = records(replace(TRACE, name="B07"), replace(PATCH, name="B0012"), replace(READING))
    kind = there["bedding"]
    assert isinstance(kind, FeatureType)
    assert edits.next_name(there, kind) == "B13"
    assert edits.next_name(there, "thickness") == "T01"
    odd = records(replace(TRACE, name="B7x"), replace(PATCH, name="xB9"), replace(READING, name=""))
    assert edits.next_name(odd, kind) == "B01"
    many = records(replace(TRACE, name="B99"))
    assert edits.next_name(many, kind) == "B100"
    # Other records have names too, which are no features'.
    assert edits.next_name({**many, "m2": replace(MODEL, id="m2", name="B500")}, kind) == "B100"


# Types


def test_type_needs_a_unique_name_and_a_valid_colour() -> None:
    there = records()
    for kind, code in (
        (FeatureType("n", " ", "#123456"), "name.empty"),
        (FeatureType("n", "9" * 201, "#123456"), "name.too-long"),
        (FeatureType("n", "Dyke", "#12345"), "type.colour"),
        (FeatureType("n", "Dyke", "#12345g"), "type.colour"),
        (FeatureType("n", "Dyke", "x#123456"), "type.colour"),
        (FeatureType("n", "Dyke", "#1234567"), "type.colour"),
        (FeatureType("n", " bEDDing ", "#123456"), "name.taken"),
    ):
        field = "color" if code == "type.colour" else "name"
        with refused(code, DocumentError, field=field):
            edits.add_type(there, kind)
        with refused(code, DocumentError, field=field):
            edits.change_type(there, replace(kind, id="fault"))
    same = edits.change_type(there, replace(DEFAULT_TYPES[0], color="#123456"))
    assert same.after["bedding"].color == "#123456"  # type: ignore[union-attr]
    with refused("record.missing", DocumentError, kind="feature type", id="n"):
        edits.change_type(there, FeatureType("n", "Dyke", "#123456"))


def test_type_is_removed_only_if_unused_and_not_the_last() -> None:
    there = records()
    edit = edits.remove_type(there, "vein")
    assert set(there) - set(done(there, edit)) == {"vein"}
    with refused("type.in-use", DocumentError, count=3, type="Bedding"):
        edits.remove_type(there, "bedding")
    with refused("type.in-use", DocumentError, count=1, type="Fault"):
        edits.remove_type(there, "fault")
    alone = {"vein": there["vein"]}
    with refused("type.last", DocumentError):
        edits.remove_type(alone, "vein")


def test_suggested_types_have_different_colours_while_available() -> None:
    there = records()
    seen = set()
    for number in range(7):
        kind = edits.suggest_type(there, f"  New {number} ")
        assert kind.name == f"New {number}"
        assert kind.color not in seen
        counts = [r.symbol for r in there.values() if isinstance(r, FeatureType)]
        assert counts.count(kind.symbol) == min(
            counts.count(s) for s in ("circle", "square", "triangle", "diamond", "pentagon", "star")
        )
        seen.add(kind.color)
        there = done(there, edits.add_type(there, kind))
    more = edits.suggest_type(there, "More", "line")
    assert more.color in seen
    assert (more.geometry, edits.suggest_type(there, "x").geometry) == ("line", "plane")
    ids = {new_id("a") for _ in range(200)}
    assert len(ids) == 200
    assert all(id_.startswith("a-") for id_ in ids)


# Models


def test_model_is_declared_relocated_and_removed() -> None:
    there = records(TRACE)
    frame = Frame("crs", "EPSG:32633", 0.001, "y")
    edit = edits.declare_frame(there, "m1", frame)
    assert edit.after == {"m1": replace(MODEL, placement=frame)}
    for wrong, code in (
        (Frame("local", unit_m=0.0), "frame.unit-not-positive"),
        (Frame("local", unit_m=-1.0), "frame.unit-not-positive"),
        (Frame("local", unit_m=float("nan")), "frame.unit-not-positive"),
        (Frame("crs", None), "frame.code-missing"),
        (Frame("crs", ""), "frame.code-missing"),
    ):
        with refused(code, DocumentError):
            edits.declare_frame(there, "m1", wrong)
    edits.declare_frame(there, "m1", UNDECLARED_FRAME)
    place = edits.relocate_model(there, "m1", "there/cliff.obj", HASH)
    assert place.after == {"m1": replace(MODEL, path="there/cliff.obj")}
    with refused("model.other-file", DocumentError, model="cliff"):
        edits.relocate_model(there, "m1", "there/cliff.obj", "1" * 64)
    with refused("model.in-use", DocumentError, count=1, model="cliff"):
        edits.remove_model(there, "m1")
    with refused("model.in-use", DocumentError, count=4, model="cliff"):
        edits.remove_model(records(), "m1")
    bare = records(READING)
    removed = edits.remove_model(bare, "m1")
    assert set(bare) - set(done(bare, removed)) == {"m1"}


def test_declaring_a_registered_model_requires_giving_up_the_registration() -> None:
    there = records(TRACE)
    there["m1"] = placed(MODEL, [[2, 0, 0, 1], [0, 2, 0, 2], [0, 0, 2, 3], [0, 0, 0, 1]])
    with refused("model.registered", DocumentError, registration="turned"):
        edits.declare_frame(there, "m1", Frame("local"))
    edit = edits.declare_frame(there, "m1", Frame("local"), replaces_registration=True)
    assert edit.after["m1"] == replace(MODEL, placement=Frame("local"))


def test_registration_moves_its_new_and_its_previous_models() -> None:
    there = records(TRACE)
    rows = [[2, 0, 0, 1], [0, 2, 0, 2], [0, 0, 2, 3], [0, 0, 0, 1]]
    first = placed(MODEL, rows)
    assert first.registration is not None
    other = replace(MODEL, id="m2", name="wall")
    there |= {"m1": first, "m2": other, "m3": replace(MODEL, id="m3")}
    better = placed(MODEL, [[3, 0, 0, 1], [0, 3, 0, 2], [0, 0, 3, 3], [0, 0, 0, 1]]).registration
    assert better is not None
    edit = edits.set_registration(there, better, ["m2"])
    assert edit.after == {
        better.id: better,
        "m1": replace(MODEL, placement=better),
        "m2": replace(other, placement=better),
    }
    with refused("record.missing", DocumentError, kind="model", id="t1"):
        edits.set_registration(there, better, ["t1"])
