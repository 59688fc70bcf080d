"""Pure functions that create the edits of a user from the given records.

Each function raises a DocumentError or GeometryError if the edit is not possible.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal

from vomstudio.core.errors import DocumentError
from vomstudio.core.findings import Finding
from vomstudio.core.identifiers import new_id
from vomstudio.geology.profiles import PROFILES_BY_NAME, Thresholds
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.matrices import Point
from vomstudio.geometry.registrations import Registration
from vomstudio.project.bed_descriptions import vertex_fields
from vomstudio.project.edit import Edit, change, check_name
from vomstudio.project.kind import get_kind
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.measurement_cache import measure_feature
from vomstudio.project.record_map import RecordMap, highest_number, name_number
from vomstudio.project.records import (
    PROFILE_ID,
    SURROUNDINGS_RULE,
    FaceGrid,
    Feature,
    FeatureType,
    Model,
    ModelFeature,
    PickedFeature,
    Record,
    SurfaceFeature,
    TypedFeature,
    VerdictProfile,
    compass_id,
)

Records = Mapping[str, Record]
_AUTOMATIC_NAME = re.compile(r"[^\W\d_]\d{2,}")
"""Names created by `next_name`: the letter of the type and a number."""


def add_model(records: Records, model: Model, label: str = "") -> Edit:
    """Add a model, and its registration if the project does not contain it yet.

    `label` is the label of the edit; it is empty if the model comes from an opened file. Raises
    DocumentError if the project already contains the model.
    """
    if model.id in records:
        raise DocumentError(Finding("record.exists", name=model.name))
    new_records: dict[str, Record | None] = {}
    if model.registration is not None and model.registration.id not in records:
        new_records[model.registration.id] = model.registration
    new_records[model.id] = model
    return change(records, label or f"Open model {model.name}", new_records)


def declare_frame(
    records: Records, model_id: str, frame: Frame, *, replaces_registration: bool = False
) -> Edit:
    """Declare the axes, unit and position of a model; all its features move with it.

    A registered model is rejected unless `replaces_registration` is set.
    """
    model = _get_record(records, model_id, Model)
    if model.registration is not None and not replaces_registration:
        raise DocumentError(
            Finding("model.registered", model=model.name, registration=model.registration.name)
        )
    if not frame.unit_m > 0:
        raise DocumentError(Finding("frame.unit-not-positive"), field="unit")
    if frame.kind == "crs" and not frame.crs:
        raise DocumentError(
            Finding("frame.code-missing"),
            field="CRS",
        )
    label = f"Declare the frame of {model.name}"
    if model.registration is not None:
        label += ", in place of its registration"
    return change(records, label, {model_id: replace(model, placement=frame)})


def set_registration(
    records: Records, registration: Registration, models: Iterable[str] = ()
) -> Edit:
    """Add or update a registration and place models with it, together with their features.

    The models are those in `models` and those that the registration already places.
    """
    new_records: dict[str, Record | None] = {registration.id: registration}
    models_to_place = [_get_record(records, id_, Model) for id_ in models]
    placed_models = [
        record
        for record in records.values()
        if isinstance(record, Model) and _is_placed_by(record, registration)
    ]
    for model in (*models_to_place, *placed_models):
        new_records[model.id] = replace(model, placement=registration)
    return change(records, f"Register by {registration.name}", new_records)


def _is_placed_by(model: Model, registration: Registration) -> bool:
    return model.registration is not None and model.registration.id == registration.id


def relocate_model(records: Records, model_id: str, path: str, content_hash: str) -> Edit:
    """Change the path of a model whose file has been moved.

    Raises DocumentError if the content of the file is different.
    """
    model = _get_record(records, model_id, Model)
    if content_hash != model.content_hash:
        raise DocumentError(Finding("model.other-file", path=path, model=model.name))
    return change(records, f"Locate {model.name}", {model_id: replace(model, path=path)})


def remove_model(records: Records, model_id: str) -> Edit:
    """Remove a model from the project. A model with features is rejected.

    Features need the frame of their model, which exists only as long as the model.
    """
    model = _get_record(records, model_id, Model)
    count = sum(
        isinstance(record, ModelFeature | FaceGrid) and record.model_id == model_id
        for record in records.values()
    )
    if count:
        raise DocumentError(Finding("model.in-use", count=count, model=model.name))
    ids = [id_ for id_ in (model_id, compass_id(model_id)) if id_ in records]
    return change(records, f"Remove model {model.name}", dict.fromkeys(ids))


def add_trace(records: Records, trace: Trace) -> Edit:
    """Add a trace. Raises GeometryError if its vertices do not define a plane."""
    model = _get_record(records, trace.model_id, Model)
    feature_type = _get_record(records, trace.type_id, FeatureType)
    if trace.id in records:
        raise DocumentError(Finding("record.exists", name=trace.name))
    if not trace.name:
        trace = replace(trace, name=next_name(records, feature_type))
    measure_feature(trace, model)
    return change(records, f"Add {feature_type.name.lower()} trace {trace.name}", {trace.id: trace})


def set_vertices(
    records: Records,
    trace_id: str,
    vertices: Sequence[Point],
    *,
    resolution: float | None,
    outcrop_normal: Point | None,
    rule: int = SURROUNDINGS_RULE,
) -> Edit:
    """Replace the vertices of a trace.

    `rule` is the version of the rule with which resolution and normal were measured.
    """
    trace = _get_record(records, trace_id, Trace)
    edited_feature = replace(
        trace,
        **vertex_fields(trace, vertices),
        doubtful=_remaining_stretches(trace, vertices),
        resolution=resolution,
        outcrop_normal=outcrop_normal,
        rule=rule,
    )
    model = records.get(trace.model_id)
    measure_feature(edited_feature, model if isinstance(model, Model) else None)
    return change(records, f"Change trace {trace.name}", {trace_id: edited_feature})


def _remaining_stretches(trace: Trace, vertices: Sequence[Point]) -> tuple[tuple[int, int], ...]:
    """Return the doubtful stretches whose ends both still exist."""
    if not trace.doubtful:
        return ()
    row = {vertex: i for i, vertex in enumerate(vertices)}
    n = len(trace.vertices)
    ends = [
        (row.get(trace.vertices[first_vertex], -1), row.get(trace.vertices[last_vertex], -1))
        for first_vertex, last_vertex in trace.doubtful
        if 0 <= first_vertex <= last_vertex < n
    ]
    return tuple(
        (first_vertex, last_vertex)
        for first_vertex, last_vertex in ends
        if 0 <= first_vertex <= last_vertex
    )


def update_surroundings(records: Records, measured_fields: Mapping[str, Mapping[str, Any]]) -> Edit:
    """Store resolution and outcrop normal of features, measured with the current rule.

    Parameters
    ----------
    records : Records
    measured_fields : mapping
        Values of "resolution" and, for traces, "outcrop_normal" by feature ID.

    Raises
    ------
    DocumentError
        If `measured_fields` is empty or contains an ID that is not that of a trace or patch.
    """
    new_records: dict[str, Record | None] = {}
    for id_, values in measured_fields.items():
        feature = records.get(id_)
        if not isinstance(feature, SurfaceFeature):
            raise DocumentError(Finding("record.missing", id=id_, kind="trace or patch"))
        new_records[id_] = feature.replace_fields(**values, rule=SURROUNDINGS_RULE)
    if not new_records:
        raise DocumentError(Finding("surroundings.up-to-date"))
    return change(records, f"Update the surroundings of {len(new_records)} features", new_records)


def add_features(records: Records, features: Sequence[Feature]) -> Edit:
    """Add features other than traces, and name those without a name.

    Traces are added by `add_trace`, which requires their vertices to define a plane. Raises
    DocumentError if there are no features or if one of them already exists.
    """
    new_records: dict[str, Record | None] = {}
    names = NextNames(records)
    for feature in features:
        if feature.id in records or feature.id in new_records:
            raise DocumentError(Finding("record.exists", name=feature.name))
        if isinstance(feature, ModelFeature):
            _get_record(records, feature.model_id, Model)
        feature_type: FeatureType | str
        if isinstance(feature, TypedFeature):
            feature_type = _get_record(records, feature.type_id, FeatureType)
        else:
            feature_type = get_kind(feature).prefix(feature)
        if not feature.name:
            feature = feature.replace_fields(name=names.propose_name(feature_type))
        names.reserve(feature)
        new_records[feature.id] = feature
    if not new_records:
        raise DocumentError(Finding("edit.empty"))
    first_record = next(iter(new_records.values()))
    description = f"{len(new_records)} features"
    if len(new_records) == 1 and isinstance(first_record, Feature):
        description = f"{get_kind(first_record).noun(first_record)} {first_record.name}"
    return change(records, f"Add {description}", new_records)


def set_line(
    records: Records,
    feature_id: str,
    vertices: Sequence[Point],
    *,
    resolution: float | None = None,
) -> Edit:
    """Replace the vertices of a feature without a plane, and the resolution around them.

    Raises DocumentError if the feature has a plane.
    """
    feature = _get_record(records, feature_id, PickedFeature)
    if get_kind(feature).plane is not None:
        raise DocumentError(Finding("feature.has-plane", feature=feature.name))
    edited_feature = feature.replace_fields(**vertex_fields(feature, vertices))
    if hasattr(edited_feature, "resolution"):
        edited_feature = replace(edited_feature, resolution=resolution)
    return change(records, f"Change {feature.name}", {feature_id: edited_feature})


def add_readings(
    records: Records, readings: Sequence[Reading], types: Sequence[FeatureType] = ()
) -> Edit:
    """Add compass readings and their new feature types in a single edit.

    Readings without a name are numbered within their type. Raises DocumentError if there are no
    readings or if one of them already exists.
    """
    new_records: dict[str, Record | None] = {}
    for feature_type in types:
        other_records = [
            new_record for new_record in new_records.values() if new_record is not None
        ]
        new_records |= add_type(
            {**records, **{other_record.id: other_record for other_record in other_records}},
            feature_type,
        ).after
    if not readings:
        raise DocumentError(Finding("edit.empty"))
    all_records = {**records, **{feature_type.id: feature_type for feature_type in types}}
    names = NextNames(records)
    for reading in readings:
        feature_type = _get_record(all_records, reading.type_id, FeatureType)
        if reading.id in records or reading.id in new_records:
            raise DocumentError(Finding("record.exists", name=reading.name))
        if not reading.name:
            reading = replace(reading, name=names.propose_name(feature_type))
        names.reserve(reading)
        new_records[reading.id] = reading
    n = len(readings)
    return change(records, f"Import {n} field measurement{'s' if n > 1 else ''}", new_records)


def change_feature(records: Records, feature: Feature, verb: str = "Change") -> Edit:
    """Replace a feature by another one with the same ID and kind; `verb` begins the label."""
    _get_record(records, feature.id, type(feature))
    return change(records, f"{verb} {feature.name}", {feature.id: feature})


def set_attributes(records: Records, ids: Iterable[str], **values: Any) -> Edit:
    """Set attributes that all of the given features have.

    The attributes are those of the kinds of the features (`Kind.attributes`). Raises DocumentError
    if there are no features, if a feature does not have an attribute, or if a value is invalid.
    """
    features: list[Feature] = [_get_record(records, id_, Feature) for id_ in ids]
    if not features:
        raise DocumentError(Finding("selection.empty"))
    if "type_id" in values:
        _get_record(records, values["type_id"], FeatureType)
    if "name" in values:
        check_name(str(values["name"]))
    # Checked once for each kind, because there may be thousands of features.
    first_features: dict[type[Feature], Feature] = {}
    for feature in features:
        first_features.setdefault(type(feature), feature)
    for feature in first_features.values():
        _check_attributes(feature, values)
    # A newly selected regression uses the axis nearest to the normal.
    defaults = {"axis": "auto"} if "method" in values else {}
    new_records: dict[str, Record | None] = {
        feature.id: feature.replace_fields(**values, **defaults) for feature in features
    }
    attribute_names = (
        key.removesuffix("_id").removesuffix("_name").replace("_", " ") for key in values
    )
    attributes = " and ".join(attribute_names)
    description = f"{len(new_records)} features"
    if len(new_records) == 1:
        description = next(iter(new_records.values())).name  # type: ignore[union-attr]
    return change(records, f"Change {attributes} of {description}", new_records)


def _check_attributes(feature: Feature, values: Mapping[str, Any]) -> None:
    """Check that a feature has attributes, and that their values are valid for its kind.

    Raises DocumentError.
    """
    attributes = {attribute.field: attribute for attribute in get_kind(feature).attributes}
    for field, value in values.items():
        attribute = attributes.get(field)
        if attribute is None:
            raise DocumentError(
                Finding(
                    "feature.no-attribute",
                    feature=feature.name,
                    attribute=field.replace("_", " "),
                )
            )
        if attribute.form == "text":
            check_name(str(value), may_be_empty=True)
        if attribute.form == "choice" and value not in dict(attribute.choices):
            raise DocumentError(
                Finding(
                    "option.not-a-choice",
                    value=value,
                    choices=[word for word, _ in attribute.choices],
                ),
                field=field,
            )


def find_misnamed_features(records: Records, features: Iterable[Feature]) -> list[Feature]:
    """Return the features that have an automatic name of another type.

    Parameters
    ----------
    records : Records
    features : iterable of Feature
    """
    other_prefixes = _other_prefixes(records)
    # There may be thousands of features, so the fast tests are made first.
    return [
        feature
        for feature in features
        if feature.name[:1] in other_prefixes.get(getattr(feature, "type_id", ""), ())
        and isinstance(feature, TypedFeature)
        and _AUTOMATIC_NAME.fullmatch(feature.name)
    ]


def _other_prefixes(records: Records) -> dict[str, frozenset[str]]:
    """Return the letters with which automatic names of other types begin, for each type ID."""
    types = (
        records.of(FeatureType)
        if isinstance(records, RecordMap)
        else [record for record in records.values() if isinstance(record, FeatureType)]
    )
    prefixes = {feature_type.id: feature_type.name[:1].upper() for feature_type in types}
    return {id_: frozenset(prefixes.values()) - {prefix} for id_, prefix in prefixes.items()}


def rename_by_type(records: Records, ids: Iterable[str]) -> Edit:
    """Give features with the automatic name of another type the next name of their type.

    Parameters
    ----------
    records : Records
    ids : iterable of str
        IDs of the features; those with other names are not renamed.

    Returns
    -------
    Edit

    Raises
    ------
    DocumentError
        If no feature has an automatic name of another type.
    """
    names = NextNames(records)
    new_records: dict[str, Record | None] = {}
    features: list[Feature] = [_get_record(records, id_, Feature) for id_ in ids]
    for feature in find_misnamed_features(records, features):
        assert isinstance(feature, TypedFeature)
        name = names.propose_name(_get_record(records, feature.type_id, FeatureType))
        new_records[feature.id] = renamed_feature = replace(feature, name=name)
        names.reserve(renamed_feature)
    if not new_records:
        raise DocumentError(Finding("edit.no-change"))
    if len(new_records) > 1:
        return change(records, f"Rename {len(new_records)} features", new_records)
    id_, renamed = next(iter(new_records.items()))
    assert isinstance(renamed, Feature)
    return change(records, f"Rename {records[id_].name} to {renamed.name}", new_records)


def assign_sets(records: Records, names: Mapping[str, str]) -> Edit:
    """Assign features to sets by feature ID ("" for no set), in a single edit.

    Raises DocumentError if nothing would change.
    """
    new_records: dict[str, Record | None] = {}
    for id_, name in names.items():
        feature = _get_record(records, id_, Feature)
        if getattr(feature, "set_name", name) != name:
            new_records[id_] = replace(feature, set_name=name)
    if not new_records:
        raise DocumentError(Finding("edit.no-change"))
    count = len({name for name in names.values() if name})
    label_start = f"Put {len(new_records)} feature{'s' if len(new_records) > 1 else ''} in "
    return change(records, label_start + f"{count} set{'s' if count != 1 else ''}", new_records)


def delete(records: Records, ids: Iterable[str]) -> Edit:
    """Delete features. Features that depend on them are kept and report the missing inputs.

    Raises DocumentError if no features are given.
    """
    features: list[Feature] = [_get_record(records, id_, Feature) for id_ in ids]
    if not features:
        raise DocumentError(Finding("selection.empty"))
    description = features[0].name if len(features) == 1 else f"{len(features)} features"
    return change(records, f"Delete {description}", {feature.id: None for feature in features})


def add_type(records: Records, feature_type: FeatureType) -> Edit:
    """Add a feature type.

    Raises DocumentError if its name is empty or already in use, or if its colour is not valid.
    """
    _check_type(records, feature_type)
    if feature_type.id in records:
        raise DocumentError(Finding("record.exists", name=feature_type.name))
    return change(records, f"Add feature type {feature_type.name}", {feature_type.id: feature_type})


# Tol's muted set (2021), used after the default types' colours by Okabe and Ito.
_MORE_COLORS = ("#332288", "#882255", "#117733", "#aa4499", "#999933", "#44aa99", "#661100")
_SYMBOLS = ("circle", "square", "triangle", "diamond", "pentagon", "star")


def suggest_type(
    records: Records, name: str, geometry: Literal["plane", "line"] = "plane"
) -> FeatureType:
    """Return a new feature type with an unused colour, if any, and the least used symbol."""
    kinds = [record for record in records.values() if isinstance(record, FeatureType)]
    used_colors = {feature_type.color for feature_type in kinds}
    color = next(
        (candidate for candidate in _MORE_COLORS if candidate not in used_colors),
        _MORE_COLORS[len(kinds) % 7],
    )
    symbols = [feature_type.symbol for feature_type in kinds]
    symbol = min(_SYMBOLS, key=symbols.count)
    return FeatureType(new_id("type"), name.strip(), color, symbol, geometry)


def change_type(records: Records, feature_type: FeatureType) -> Edit:
    """Change the name, colour or symbol of a type.

    Raises DocumentError if the name or the colour is not valid, as in `add_type`.
    """
    _get_record(records, feature_type.id, FeatureType)
    _check_type(records, feature_type)
    return change(
        records, f"Change feature type {feature_type.name}", {feature_type.id: feature_type}
    )


def remove_type(records: Records, type_id: str) -> Edit:
    """Remove a type that no feature uses. The last type of a project is rejected."""
    feature_type = _get_record(records, type_id, FeatureType)
    count = sum(
        isinstance(record, TypedFeature) and record.type_id == type_id
        for record in records.values()
    )
    if count:
        raise DocumentError(Finding("type.in-use", count=count, type=feature_type.name))
    if sum(isinstance(record, FeatureType) for record in records.values()) == 1:
        raise DocumentError(Finding("type.last"))
    return change(records, f"Remove feature type {feature_type.name}", {type_id: None})


def _check_type(records: Records, feature_type: FeatureType) -> None:
    check_name(feature_type.name)
    if not re.fullmatch(r"#[0-9a-fA-F]{6}", feature_type.color):
        raise DocumentError(Finding("type.colour", colour=feature_type.color), field="color")
    is_same = feature_type.name.strip().casefold()
    for other_type in records.values():
        if (
            isinstance(other_type, FeatureType)
            and other_type.id != feature_type.id
            and other_type.name.casefold() == is_same
        ):
            raise DocumentError(
                Finding("name.taken", name=other_type.name),
                field="name",
            )


def judge_by(records: Records, limits: Thresholds) -> Edit:
    """Judge all features of the project with the thresholds of a profile.

    Raises DocumentError if the thresholds are not valid or nothing would change.
    """
    name = limits.profile.strip()
    check_name(name, "profile")
    standard_profile = PROFILES_BY_NAME.get(name)
    if standard_profile is not None and standard_profile != limits:
        raise DocumentError(
            Finding("profile.fixed", profile=name),
            field="profile",
        )
    for field in dataclasses.fields(limits):
        value = getattr(limits, field.name)
        if isinstance(value, float) and not 0.0 < value < math.inf:
            raise DocumentError(
                Finding("profile.limit-not-positive", value=value), field=field.name
            )
    if limits.good_confidence95_deg > limits.poor_confidence95_deg:
        raise DocumentError(
            Finding(
                "profile.limits-crossed",
                good_deg=limits.good_confidence95_deg,
                poor_deg=limits.poor_confidence95_deg,
            ),
            field="good_confidence95_deg",
        )
    current_profile = records.get(PROFILE_ID)
    if isinstance(current_profile, VerdictProfile) and current_profile.limits == limits:
        raise DocumentError(Finding("edit.no-change"))
    record = VerdictProfile(PROFILE_ID, replace(limits, profile=name))
    return change(records, f"Judge by the profile {name}", {PROFILE_ID: record})


def next_name(records: Records, feature_type: FeatureType | str) -> str:
    """Return the next name for a type, such as B02 after B01 for Bedding."""
    return NextNames(records).propose_name(feature_type)


class NextNames:
    """Names for features that are added together; each feature is examined only once."""

    def __init__(self, records: Records) -> None:
        self._records = records
        self._reserved_records: list[Record] = []
        self._highest_numbers: dict[str, tuple[int, int]] = {}

    def reserve(self, feature: Record) -> None:
        """Reserve the name of a feature."""
        self._reserved_records.append(feature)

    def propose_name(self, kind: FeatureType | str) -> str:
        """Return the next name: the first letter and the highest number in use plus one."""
        prefix = (kind if isinstance(kind, str) else kind.name)[:1].upper()
        checked, highest = self._highest_numbers.get(prefix, (0, -1))
        if highest < 0:
            highest = highest_number(self._records, prefix)
        for feature in self._reserved_records[checked:]:
            highest = max(highest, name_number(prefix, feature) or 0)
        self._highest_numbers[prefix] = len(self._reserved_records), highest
        return f"{prefix}{highest + 1:02d}"


def _get_record(records: Records, id_: str, cls: type[Any]) -> Any:
    record = records.get(id_)
    if not isinstance(record, cls):
        type_name = re.sub("(?<=[a-z])(?=[A-Z])", " ", cls.__name__).lower()
        feature_type = "feature" if cls is PickedFeature else type_name
        raise DocumentError(Finding("record.missing", kind=feature_type, id=id_))
    return record
