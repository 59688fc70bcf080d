"""What everything else trusts the kinds of features to say of themselves."""

from __future__ import annotations

import ast
import dataclasses
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.messages import refused
from tests.samples import HASH, ONE_OF_EACH, bed
from vomstudio.core.errors import DocumentError
from vomstudio.geometry.frames import Frame
from vomstudio.project import catalogue, edits
from vomstudio.project.figures import Subject
from vomstudio.project.kind import Attribute
from vomstudio.project.kinds import (
    ATTRIBUTES,
    FIGURES,
    KINDS,
    RECORDS,
    _merge_attributes,
    get_kind,
    visibility_group,
)
from vomstudio.project.measurement_cache import Measurements, depends_on, measure_all
from vomstudio.project.records import Feature, Model, ModelFeature, PickedFeature

ROOT = Path(__file__).resolve().parents[2]
MODEL = Model("m1", "cliff", "cliff.obj", "mesh", HASH, Frame("local"))
RECORDS_OF_ALL = {"m1": MODEL, **{f.id: f for f in ONE_OF_EACH.values()}}


def test_every_kind_has_an_example_under_its_name():
    """Names on disk are kept by the specimen project, which is read with each of them."""
    assert {name: type(feature) for name, feature in ONE_OF_EACH.items()} == RECORDS
    assert [kind.name for kind in KINDS] == list(ONE_OF_EACH)


@pytest.mark.parametrize("name", ONE_OF_EACH)
def test_kind_measures_draws_and_names_its_features(name):
    feature = ONE_OF_EACH[name]
    kind = get_kind(feature)
    assert kind.name == name
    measured = measure_all(RECORDS_OF_ALL, [feature])[0]
    assert measured.kind == name
    assert measured.problem is None
    subject = Subject(feature, measured, RECORDS_OF_ALL)
    sketch = kind.sketch(subject, lambda id_: measure_all(RECORDS_OF_ALL, [RECORDS_OF_ALL[id_]])[0])
    assert sketch is not None
    assert sketch.anchor.shape == (3,)
    values = {figure.name: figure.value(subject) for figure in kind.figures}
    assert values["name"] == feature.name
    if kind.orientations:
        assert values["element"] in kind.orientations
    assert all(isinstance(figure.text(subject), str) for figure in kind.figures)


def test_measurements_of_many_kinds_are_in_the_requested_order():
    mixed = [*ONE_OF_EACH.values(), bed("t2", shift=5.0), *reversed(ONE_OF_EACH.values())]
    measured = measure_all(RECORDS_OF_ALL, mixed)
    assert [m.kind for m in measured] == [get_kind(f).name for f in mixed]
    assert measured[len(ONE_OF_EACH)].fit.centroid[2] == measured[0].fit.centroid[2] + 5.0


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_attributes_of_a_kind_are_record_fields_and_figure_names_are_unique(kind):
    fields = {field.name for field in dataclasses.fields(kind.record)}
    assert {attribute.field for attribute in kind.attributes} <= fields
    names = [figure.name for figure in kind.figures]
    assert len(set(names)) == len(names)
    if kind.layer is not None:
        assert {"id", "name"} <= {figure.name for figure in kind.layer.figures}
    assert kind.has_feature_type == ("type_id" in fields)


def test_figures_of_one_name_are_equal_in_every_kind():
    for kind in KINDS:
        for figure in kind.figures:
            first = FIGURES[figure.name]
            assert (figure.title, figure.unit, figure.form) == (first.title, first.unit, first.form)
            assert figure.explanation


def test_short_names_fit_a_shapefile_and_filter_words_are_unique():
    shorts = [figure.short for figure in FIGURES.values() if figure.short]
    assert len(set(shorts)) == len(shorts)
    assert max(map(len, shorts)) <= 10
    words = [word for figure in FIGURES.values() for word in figure.words]
    assert len(set(words)) == len(words)


def test_attributes_of_all_kinds_are_merged_in_the_order_of_each():
    merged = [attribute.field for attribute in ATTRIBUTES]
    assert len(set(merged)) == len(merged)
    assert (merged[0], merged[-1]) == ("name", "notes")
    for kind in KINDS:
        own = [attribute.field for attribute in kind.attributes]
        assert sorted(own, key=merged.index) == own


def test_only_attributes_of_its_kind_can_be_changed(session):
    session.apply(edits.add_trace(session.records, bed("t1")))
    with refused("feature.no-attribute", DocumentError, attribute="vertices"):
        edits.set_attributes(session.records, ["t1"], vertices=())
    with refused("feature.no-attribute", DocumentError, attribute="slip"):
        edits.set_attributes(session.records, ["t1"], slip="normal")


@pytest.mark.parametrize(
    ("changed", "looks_different"),
    [
        ("m1", {"i1", *(f.id for f in ONE_OF_EACH.values() if isinstance(f, ModelFeature))}),
        ("t1", {"l1", "d1", "i1"}),
        ("lineation", {"l1", "i1"}),
        ("p1", {"i1"}),
        ("r1", {"i1"}),
    ],
)
def test_features_depending_on_a_changed_record_are_found(changed, looks_different):
    others = {i: f for i, f in RECORDS_OF_ALL.items() if isinstance(f, Feature) and i != changed}
    found = {i for i, f in others.items() if depends_on(RECORDS_OF_ALL, f, {changed})}
    assert found == looks_different


def test_deleting_a_plane_affects_the_lines_on_it():
    without = {i: r for i, r in RECORDS_OF_ALL.items() if i != "t1"}
    assert depends_on(without, RECORDS_OF_ALL["l1"], {"t1"})
    measurements = Measurements()
    before = measurements.of(RECORDS_OF_ALL, ["l1"])["l1"]
    assert before.rake_deg is not None
    assert measurements.of(without, ["l1"])["l1"].rake_deg is None


def test_untyped_feature_is_in_the_group_of_its_kind():
    assert visibility_group(ONE_OF_EACH["dimension"]) == "dimensions"
    assert visibility_group(ONE_OF_EACH["patch"]) == "joint"


def test_records_import_no_kinds_and_kinds_no_slow_modules():
    def loaded(statement: str) -> set[str]:
        ask = f"{statement}\nimport sys; print(*sys.modules)"
        done = subprocess.run(
            [sys.executable, "-c", ask], cwd=ROOT, capture_output=True, text=True, timeout=60
        )
        assert done.returncode == 0, done.stderr
        return set(done.stdout.split())

    assert "vomstudio.project.kinds" not in loaded("import vomstudio.project.records")
    slow = {"scipy", "numba", "pandas", "PySide6", "vtkmodules", "matplotlib", "shapely"}
    assert not slow & loaded("import vomstudio.project.kinds")


def test_only_the_kinds_package_tests_for_record_classes():
    names = {cls.__name__ for cls in RECORDS.values()}
    mentioned = re.compile(rf"\b({'|'.join(names)})\b")
    asked = []
    for file in sorted((ROOT / "vomstudio").rglob("*.py")):
        text = file.read_text(encoding="utf-8")
        if "kinds" in file.parts or "isinstance(" not in text or not mentioned.search(text):
            continue
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "isinstance":
                used = {n.id for n in ast.walk(node.args[1]) if isinstance(n, ast.Name)}
                asked += [f"{file.relative_to(ROOT)}:{node.lineno}" for _ in used & names]
    assert asked == []


def test_subject_without_a_document_has_the_figures_of_its_fit():
    feature = ONE_OF_EACH["trace"]
    measured = measure_all(RECORDS_OF_ALL, [feature])[0]
    subject = Subject(None, measured)
    assert isinstance(feature, PickedFeature)
    assert catalogue.DIP.value(subject) == measured.plane.dip_deg
    assert catalogue.N_POINTS.value(subject) == len(feature.vertices)


def test_fields_of_a_new_kind_are_merged_in_order_into_existing_ones():
    """The window shows the fields of all selected features in one form, each kind in its order."""

    def merged(*lists: str) -> str:
        kinds = [tuple(Attribute(field, field) for field in own) for own in lists]
        return "".join(attribute.field for attribute in _merge_attributes(kinds))

    assert merged("abz", "acz") == "abcz"
    assert merged("axz", "ayxz") == "ayxz"
    assert merged("axz", "az", "axyz") == "axyz"
    assert merged("abz", "cdbez", "z") == "acdbez"
    assert merged("az", "abcz", "bdz", "azq") == "abcdzq"
    assert merged("bz", "abz") == "abz"
    assert merged("a", "ab", "abcd") == "abcd"
    assert merged("az", "adefz") == "adefz"
