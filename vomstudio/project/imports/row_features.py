"""Features of a project from the rows of a file."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.identifiers import new_id
from vomstudio.geology.orientation import Plane, angle_between_planes
from vomstudio.geometry import transform
from vomstudio.geometry.lines import ring_area
from vomstudio.geometry.matrices import Point
from vomstudio.project.imports.listed_rows import ListedRow
from vomstudio.project.kinds.contact import Contact
from vomstudio.project.kinds.lineation import Lineation
from vomstudio.project.kinds.lithology import Lithology
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.kinds.station import STATION_KINDS, Station, StationKind
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.measurement_cache import measure_all
from vomstudio.project.records import (
    SURROUNDINGS_RULE,
    Feature,
    FeatureType,
    Model,
    PickedFeature,
    Record,
    TypedFeature,
)

AreaFunction = Callable[[FloatArray], float | None]
MeasureSurroundings = Callable[[Sequence[Point]], tuple[float | None, Point | None]]
"""Function that returns resolution and outcrop normal around vertices in the file frame."""
MIN_POINTS = {
    "stations": 1,
    "contacts": 2,
    "lithologies": 3,
    "traces": 3,
    "lineations": 2,
    "planes": 1,
}
MIN_DIFFERENCE_DEG = 1.0
"""Largest difference between two orientations that were rounded to whole degrees."""


@dataclass
class FeatureFactory:
    """Factory that creates features from rows.

    Attributes
    ----------
    model : Model
        Model on which the features lie.
    types : sequence of FeatureType
        Feature types of the project.
    source : str
        Name of the file.
    area_inside, surroundings
        As for `read_listed_features`.
    replaced_types : dict
        Names of the types used in place of types that the project does not contain, keyed by the
        missing type in lower case.
    """

    model: Model
    types: Sequence[FeatureType]
    source: str
    area_inside: AreaFunction | None = None
    surroundings: MeasureSurroundings | None = None
    replaced_types: dict[str, str] = field(default_factory=dict)

    def create(self, row: ListedRow, vertices: tuple[Point, ...], points: FloatArray) -> Feature:
        """Create a feature from its vertices in the file frame and its points in World."""
        if row.layer == "stations":
            return self._station(row, vertices)
        if row.layer == "lithologies":
            return self._lithology(row, vertices, points)
        notes = row.text("notes", "note", "description") or row.notes
        model, name = self.model, row.text("name")
        set_name = row.text("set", "set_name") or self._structure(row)
        resolution, outcrop_normal = None, None
        if row.layer in ("traces", "lineations") and self.surroundings is not None:
            resolution, outcrop_normal = self.surroundings(vertices)
        if row.layer == "contacts":
            return Contact(
                new_id("contact"),
                name,
                self._type_id(row, "plane"),
                model.id,
                model.content_hash,
                vertices,
                set_name,
                notes,
            )
        if row.layer == "planes":
            assert row.plane is not None
            return Reading(
                new_id("reading"),
                name,
                self._type_id(row, "plane"),
                "plane",
                row.plane.dip_direction_deg,
                row.plane.dip_deg,
                position=_to_point(points[0]),
                source=self.source,
                set_name=set_name,
                notes=notes,
            )
        if row.layer == "lineations":
            return Lineation(
                new_id("line"),
                name,
                self._type_id(row, "line"),
                model.id,
                model.content_hash,
                vertices,
                resolution=resolution,
                set_name=set_name,
                notes=notes,
            )
        return Trace(
            new_id("trace"),
            name,
            self._type_id(row, "plane"),
            model.id,
            model.content_hash,
            vertices,
            resolution=resolution,
            outcrop_normal=outcrop_normal,
            set_name=set_name,
            notes=notes,
            rule=0 if self.surroundings is None else SURROUNDINGS_RULE,
            axis="auto",
        )

    def line_kind(self, row: ListedRow) -> str:
        """Return "lineations" for a trace whose feature type is linear, otherwise its layer."""
        if row.layer != "traces":
            return row.layer
        named_type = self._named_type(row)
        is_line = named_type is not None and named_type.geometry == "line"
        return "lineations" if is_line else row.layer

    def _named_type(self, row: ListedRow) -> FeatureType | None:
        """Return the type that the attributes or groups of a row name, or None."""
        groups = [word for group in reversed(row.groups) for word in (group, _base(group))]
        for name in (row.text("kind", "type"), *groups):
            key = name.strip().casefold()
            for each in self.types:
                if key and key in (each.name.casefold(), each.id.casefold()):
                    return each
        return None

    def _type_id(self, row: ListedRow, geometry: Literal["plane", "line"]) -> str:
        named_type = self._named_type(row)
        if named_type is not None and named_type.geometry == geometry:
            return named_type.id
        types = [each for each in self.types if each.geometry == geometry]
        if not types:
            return ""
        default_id = "contact" if geometry == "plane" else "lineation"
        default = next((each for each in types if each.id == default_id), types[0])
        if kind := row.text("kind", "type"):
            self.replaced_types[kind.casefold()] = default.name
        return default.id

    def _structure(self, row: ListedRow) -> str:
        """Return the structure that contains a row, unless it is named after the type."""
        named_type = self._named_type(row)
        type_names = () if named_type is None else (named_type.id, named_type.name.casefold())
        return "" if row.structure.casefold() in type_names else row.structure

    def _station(self, row: ListedRow, vertices: tuple[Point, ...]) -> Station:
        kind = row.text("kind", "what", "type").casefold()
        station_kind: StationKind = next(
            (choice for choice, _ in STATION_KINDS if choice == kind), "station"
        )
        return Station(
            new_id("station"),
            row.text("name"),
            self.model.id,
            self.model.content_hash,
            vertices[:1],
            station_kind,
            row.text("number", "station"),
            row.text("photo"),
            row.text("notes", "note", "description"),
        )

    def _lithology(
        self, row: ListedRow, vertices: tuple[Point, ...], points: FloatArray
    ) -> Lithology:
        lithology = Lithology(
            new_id("lithology"),
            row.text("name"),
            self.model.id,
            self.model.content_hash,
            vertices,
            row.text("lithology", "rock"),
            None,
            row.text("notes", "note", "description"),
        )
        area = (
            None if self.area_inside is None else self.area_inside(np.asarray(vertices, np.float64))
        )
        if area is None and (area_text := row.text("area_m2")):
            # The model is not loaded, so use the stored area if it is plausible.
            scale = transform.scale_factor(transform.matrix(self.model.to_world))
            try:
                # Balloons of KML have the unit behind the value.
                value = float(area_text.split()[0])
            except ValueError:
                value = 0.0
            is_plausible = math.isfinite(value) and value >= 0.5 * ring_area(points) > 0.0
            area = value / scale**2 if is_plausible else None
        return replace(lithology, area=area)


def _base(group: str) -> str:
    """Return the name of a layer up to its last `_`, e.g. `fault` of `fault_contacts`."""
    return group.rpartition("_")[0]


def _to_point(coordinates: FloatArray) -> Point:
    """Convert coordinates (3,) to a point."""
    x, y, z = coordinates.tolist()
    return (x, y, z)


def check_measurements(
    records: Mapping[str, Record], features: Sequence[Feature], planes: Mapping[str, Plane]
) -> tuple[dict[str, Finding], list[Finding]]:
    """Measure new features, and compare their planes with those that the file states.

    Parameters
    ----------
    records : mapping
        Records of the project, with the model.
    features : sequence of Feature
    planes : mapping of str to Plane
        Plane that the file states, by ID of the feature.

    Returns
    -------
    problems : dict
        Reasons why traces and lineations have no orientation, by ID.
    findings : list of Finding
        ``import.orientations-differ`` if planes differ by more than their 95 % error and by more
        than `MIN_DIFFERENCE_DEG`.
    """
    measured_features = [
        each
        for each in features
        if isinstance(each, PickedFeature) and isinstance(each, TypedFeature)
    ]
    records = {**records, **{each.id: each for each in measured_features}}
    problems: dict[str, Finding] = {}
    differences: list[tuple[float, str]] = []
    compared_count = 0
    measurements = measure_all(records, measured_features)
    for number, (feature, measured) in enumerate(
        zip(measured_features, measurements, strict=True), 1
    ):
        if measured.problem is not None:
            problems[feature.id] = measured.problem
            continue
        plane = planes.get(feature.id)
        if plane is None or measured.plane is None:
            continue
        compared_count += 1
        angle_deg = angle_between_planes(plane, measured.plane)
        if angle_deg > max(measured.total95_deg or 0.0, MIN_DIFFERENCE_DEG):
            differences.append((angle_deg, feature.name or f"#{number}"))
    if not differences:
        return problems, []
    largest_deg, name = max(differences)
    finding = Finding(
        "import.orientations-differ",
        count=len(differences),
        total=compared_count,
        name=name,
        angle=f"{largest_deg:.1f}",
    )
    return problems, [finding]
