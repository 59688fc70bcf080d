"""Photos, their points, marks and masks: what an edit leaves alone, and what keeps its identity."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from tests.messages import refused
from vomstudio.core.errors import DocumentError
from vomstudio.geometry.registrations import Registration
from vomstudio.project import photo_edits
from vomstudio.project.edit import Edit
from vomstudio.project.photo_edits import PointState, photo_set_name
from vomstudio.project.records import (
    Asset,
    ImageMark,
    MarkedPoint,
    Mask,
    PhotoSet,
    ReconstructionRecord,
    Record,
)

SET = PhotoSet("s1", "cliff photos", "photos", "EPSG:32633")
OTHER = PhotoSet("s2", "more photos", "more")
A, B = PointState("A", (1.0, 2.0, 3.0), 0.01), PointState("B", (4.0, 5.0, 6.0), None, True)
MARKS = {("A", "1.jpg"): (10.0, 20.0), ("A", "2.jpg"): (11.0, 21.0), ("B", "1.jpg"): (30.0, 40.0)}
FILE, FINER = Asset("masks/a.png", 10), Asset("masks/b.png", 12)

Records = dict[str, Record]


def test_photos_are_named_after_the_outcrop(tmp_path: Path) -> None:
    """A folder that only says "photos" does not."""
    assert photo_set_name(tmp_path / "cliff") == "cliff"
    assert photo_set_name(tmp_path / "cliff" / "images") == "cliff"
    assert photo_set_name(tmp_path / "cliff" / "JPG") == "cliff"
    assert photo_set_name(Path("/photos")) == "photos"


def done(before: Records, edit: Edit) -> Records:
    after = dict(before)
    edit.swap(after)
    return after


@pytest.fixture
def there() -> Records:
    start = done({}, photo_edits.add_photo_set({}, OTHER, [A], {("A", "9.jpg"): (1.0, 2.0)}))
    return done(start, photo_edits.add_photo_set(start, SET, [A, B], MARKS, {"1.jpg": FILE}))


def point(records: Records, label: str, set_id: str = "s1") -> MarkedPoint:
    (found,) = [p for p in photo_edits.points_of(records, set_id) if p.label == label]
    return found


def marks(records: Records, set_id: str = "s1") -> dict[tuple[str, str], ImageMark]:
    return {(p.label, m.photo): m for p, m in photo_edits.marks_of(records, set_id)}


def test_photo_set_is_added_with_its_points_marks_and_masks(there: Records) -> None:
    a, b = point(there, "A"), point(there, "B")
    assert a == MarkedPoint(a.id, "s1", "A", (1.0, 2.0, 3.0), 0.01, False)
    assert b == MarkedPoint(b.id, "s1", "B", (4.0, 5.0, 6.0), None, True)
    found = marks(there)
    assert {key: (m.x, m.y) for key, m in found.items()} == MARKS
    assert found["B", "1.jpg"].point_id == b.id
    assert [(photo, m.file) for photo, m in photo_edits.get_masks(there, "s1").items()] == [
        ("1.jpg", FILE)
    ]
    assert photo_edits.get_masks(there, "s2") == {}
    assert list(photo_edits.photo_sets(there)) == [OTHER, SET]
    assert [p.label for p in photo_edits.points_of(there, "s2")] == ["A"]


EDITS: tuple[Callable[[Records], Edit], ...] = (
    lambda _: photo_edits.add_photo_set({}, SET),
    lambda there: photo_edits.import_sidecar_data(there, "s1", [A], {}, {}, "EPSG:25833"),
    lambda there: photo_edits.locate_photos(there, "s1", "there"),
    lambda there: photo_edits.add_reconstruction(
        there,
        ReconstructionRecord("k1", "s1", "cliff", "cliff", "low", "0" * 64),
        Registration("g1", "GPS", "gps", reconstruction_id="k1"),
    ),
)


def test_edit_labels_describe_the_edits(there: Records) -> None:
    assert [make(there).label for make in EDITS] == [
        "Add the photos cliff photos",
        "Use files next to the photos cliff photos",
        "Locate the photos cliff photos",
        "Make a model of cliff",
    ]


def test_photo_set_with_existing_id_is_rejected(there: Records) -> None:
    with refused("record.exists", DocumentError, name="cliff photos"):
        photo_edits.add_photo_set(there, SET)


def test_mark_of_unknown_point_creates_tie_point(there: Records) -> None:
    edit = photo_edits.set_points(
        there, "s1", [A, B], {**MARKS, ("T", "1.jpg"): (5.0, 6.0)}, "Mark T"
    )
    assert edit.label == "Mark T"
    after = done(there, edit)
    tie = point(after, "T")
    assert (tie.position, tie.sigma_m, tie.check) == (None, None, False)
    assert marks(after)["T", "1.jpg"].point_id == tie.id
    assert len(edit.after) == 2


def test_edit_contains_changed_records_only(there: Records) -> None:
    assert photo_edits.set_points(there, "s1", [A, B], MARKS, "x").after == {}
    moved = replace(A, position=(1.0, 2.0, 3.5))
    edit = photo_edits.set_points(there, "s1", [moved, B], MARKS, "x")
    assert list(edit.after) == [point(there, "A").id]
    assert edit.after[point(there, "A").id].position == (1.0, 2.0, 3.5)  # type: ignore[union-attr]
    other = {**MARKS, ("A", "2.jpg"): (11.0, 21.5)}
    edit = photo_edits.set_points(there, "s1", [A, B], other, "x")
    assert edit.after == {
        marks(there)["A", "2.jpg"].id: replace(marks(there)["A", "2.jpg"], y=21.5)
    }
    crs = photo_edits.set_points(there, "s1", [A, B], MARKS, "x", crs="EPSG:25833")
    assert crs.after == {"s1": replace(SET, crs="EPSG:25833")}
    assert photo_edits.set_points(there, "s1", [A, B], MARKS, "x", crs=SET.crs).after == {}


def test_only_missing_points_and_marks_are_deleted(there: Records) -> None:
    fewer = {key: at for key, at in MARKS.items() if key[0] == "A"}
    edit = photo_edits.set_points(there, "s1", [A], fewer, "x")
    gone = {point(there, "B").id, marks(there)["B", "1.jpg"].id}
    assert edit.after == dict.fromkeys(gone)
    after = done(there, edit)
    assert len(marks(after, "s2")) == 1
    single = dict(list(MARKS.items())[1:])
    edit = photo_edits.set_points(there, "s1", [A, B], single, "x")
    assert edit.after == {marks(there)["A", "1.jpg"].id: None}


def test_renamed_point_keeps_its_id(there: Records) -> None:
    renamed = {("Z" if label == "A" else label, photo): at for (label, photo), at in MARKS.items()}
    edit = photo_edits.set_points(there, "s1", [replace(A, label="Z"), B], renamed, "x")
    assert edit.after == {point(there, "A").id: replace(point(there, "A"), label="Z")}
    # With marks in other photos it is another one.
    elsewhere = {("Z", "7.jpg"): (1.0, 1.0), ("B", "1.jpg"): (30.0, 40.0)}
    after = done(
        there, photo_edits.set_points(there, "s1", [replace(A, label="Z"), B], elsewhere, "x")
    )
    assert point(after, "Z").id != point(there, "A").id
    # And where two came for two it is not known which is which.
    both = {(label + "x", photo): at for (label, photo), at in MARKS.items()}
    states = [replace(A, label="Ax"), replace(B, label="Bx")]
    after = done(there, photo_edits.set_points(there, "s1", states, both, "x"))
    assert not {p.id for p in photo_edits.points_of(after, "s1")} & set(there)


def test_masks_are_added_changed_and_removed(there: Records) -> None:
    (old,) = photo_edits.get_masks(there, "s1").values()
    edit = photo_edits.set_masks(there, "s1", {"1.jpg": FINER, "2.jpg": FILE, "3.jpg": None}, "x")
    assert edit.after[old.id] == replace(old, file=FINER)
    (new,) = [m for m in edit.after.values() if m is not None and m.id != old.id]
    assert new == Mask(new.id, "s1", "2.jpg", FILE)
    assert len(edit.after) == 2
    assert photo_edits.set_masks(there, "s1", {"1.jpg": FILE}, "x").after == {}
    assert photo_edits.set_masks(there, "s1", {"1.jpg": None}, "x").after == {old.id: None}


def test_sidecar_data_replaces_points_marks_and_masks(there: Records) -> None:
    edit = photo_edits.import_sidecar_data(there, "s1", [A], {}, {"1.jpg": None}, "EPSG:25833")
    after = done(there, edit)
    assert after["s1"] == replace(SET, crs="EPSG:25833")
    assert [p.label for p in photo_edits.points_of(after, "s1")] == ["A"]
    assert marks(after) == {}
    assert photo_edits.get_masks(after, "s1") == {}
    kept = photo_edits.import_sidecar_data(there, "s1", [A, B], MARKS, {})
    assert done(there, kept)["s1"] == SET


def test_unknown_photo_set_is_rejected(there: Records) -> None:
    for call in (
        lambda: photo_edits.import_sidecar_data(there, "s9", [], {}, {}),
        lambda: photo_edits.set_points(there, "s9", [], {}, "x"),
        lambda: photo_edits.set_masks(there, "s9", {}, "x"),
        lambda: photo_edits.locate_photos(there, "s9", "there"),
        lambda: photo_edits.set_masks(there, point(there, "A").id, {}, "x"),
    ):
        with refused("record.missing", DocumentError):
            call()
    place = photo_edits.locate_photos(there, "s1", "there")
    assert place.after == {"s1": replace(SET, path="there")}


def test_reconstruction_replaces_the_earlier_one_in_the_same_folder(there: Records) -> None:
    first = ReconstructionRecord("k1", "s1", "cliff", "cliff", "low", "0" * 64)
    beside = replace(first, id="k2", name="wall", folder="wall")
    by = Registration("g1", "GPS", "gps", reconstruction_id="k1")
    edit = photo_edits.add_reconstruction(there, first, by)
    assert edit.after == {"k1": first, "g1": by}
    records = done(there, edit)
    records = done(records, photo_edits.add_reconstruction(records, beside, replace(by, id="g2")))
    again = photo_edits.add_reconstruction(
        records, replace(first, id="k3"), replace(by, id="g3", reconstruction_id="k3")
    )
    assert again.after["k1"] is None
    assert "k2" not in again.after
    records = done(records, again)
    assert photo_edits.find_reconstruction(records, "cliff") == replace(first, id="k3")
    assert photo_edits.find_reconstruction(records, "nowhere") is None
    assert photo_edits.reconstruction_registration(records, "k3").id == "g3"  # type: ignore[union-attr]
    assert photo_edits.reconstruction_registration(records, "k9") is None
    with refused("record.missing", DocumentError):
        photo_edits.add_reconstruction(records, replace(first, photo_set_id="s9"), by)
