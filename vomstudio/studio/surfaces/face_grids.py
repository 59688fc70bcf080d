"""Exposed surface area in the cells of the project's grids, computed in threads."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.signals import Signal
from vomstudio.geology.coverage.cells import ExposedArea, SquareGrid, measure_faces, measure_points
from vomstudio.geology.coverage.face_coverage import FaceCoverage, measure_coverage
from vomstudio.geometry import transform
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.project.edit import Edit
from vomstudio.project.figures import Subject
from vomstudio.project.grid_edits import grid_marks
from vomstudio.project.kinds import get_kind
from vomstudio.project.measurement import Measurement, matrix_to_world
from vomstudio.project.records import FaceGrid, Model, ModelFeature, Record, TypedFeature, get
from vomstudio.project.repeated_features import is_repeat
from vomstudio.project.tables.grid_layer import grid_in_file_frame
from vomstudio.studio.background import Background
from vomstudio.studio.models import Models
from vomstudio.studio.projects import Projects

Records = Mapping[str, Record]


def world_grid(grid: FaceGrid, model: Model | None) -> SquareGrid:
    """Return a grid in the World frame, in metres if the scale of the model is known."""
    rows = matrix_to_world(model)
    scale = transform.scale_factor(rows)
    rotation = rows[:3, :3] / scale
    origin = transform.apply(rows, [grid.origin])[0]
    right, up = rotation @ np.array(grid.right), rotation @ np.array(grid.up)
    return SquareGrid(origin, right, up, grid.cell * scale, grid.columns, grid.rows)


def compute_exposed_area(
    grid: FaceGrid, data: Mesh | PointCloud, resolution: float | None, *, includes_pieces: bool
) -> ExposedArea:
    """Measure the exposed area in the cells of a grid, in squared file units."""
    if isinstance(data, Mesh) and len(data.faces):
        return measure_faces(
            grid_in_file_frame(grid), data.vertices, data.faces, include_pieces=includes_pieces
        )
    points = data.vertices if isinstance(data, Mesh) else data.points
    return measure_points(grid_in_file_frame(grid), points, resolution or 0.0)


def picked_lines(
    records: Records, measurements: Mapping[str, Measurement], model_id: str
) -> list[FloatArray]:
    """Return the picks on a model as World lines (k, 3); a patch is reduced to its centre.

    Repeated picks are omitted.
    """
    lines = []
    for id_, measurement in measurements.items():
        feature = records.get(id_)
        if not (isinstance(feature, TypedFeature) and isinstance(feature, ModelFeature)):
            continue
        if (
            feature.model_id != model_id
            or not len(measurement.points)
            or is_repeat(feature, records)
        ):
            continue
        layer = get_kind(feature).layer
        shape = None
        if layer is not None and layer.geometry == "line":
            shape = layer.shape(Subject(feature, measurement, records))
        lines.append(measurement.points[:1] if shape is None else np.asarray(shape, np.float64))
    return lines


def compute_coverage(
    grid: FaceGrid, model: Model | None, exposed_area: ExposedArea, lines: Iterable[FloatArray]
) -> FaceCoverage:
    """Compute the coverage of a grid by picks; `lines` are the result of `picked_lines`."""
    grid_in_world = world_grid(grid, model)
    unit = (grid_in_world.cell / grid.cell) ** 2
    return measure_coverage(
        grid_in_world,
        grid_marks(grid),
        unit * exposed_area.surface,
        unit * exposed_area.covered,
        list(lines),
    )


@dataclass(frozen=True)
class _Geometry:
    """Geometry of a grid without its marks, which do not affect the exposed area."""

    model_id: str
    lattice: tuple[Any, ...]

    @classmethod
    def of(cls, grid: FaceGrid) -> _Geometry:
        return cls(
            grid.model_id,
            (grid.origin, grid.right, grid.up, grid.cell, grid.columns, grid.rows),
        )


class FaceGrids:
    """Exposed area in the cells of each grid; `changed` emits the id of a changed grid."""

    def __init__(self, projects: Projects, models: Models, background: Background) -> None:
        self.changed: Signal[str] = Signal()
        self._projects, self._models, self._background = projects, models, background
        self._exposed_areas: dict[str, tuple[_Geometry, ExposedArea | None]] = {}
        models.loaded.connect(self._follow_model)

    def all(self) -> list[FaceGrid]:
        """Return the grids of the project in order of creation."""
        return self._projects.of(FaceGrid)

    def exposure(self, grid_id: str) -> ExposedArea | None:
        """Return the exposed area in the cells of a grid, or None if it is not known yet."""
        grid = get(self._projects.records, grid_id, FaceGrid)
        entry = self._exposed_areas.get(grid_id)
        return entry[1] if grid is not None and entry and entry[0] == _Geometry.of(grid) else None

    def begin(self) -> None:
        """Reset for another project."""
        self._background.cancel_all()
        self._exposed_areas.clear()

    def follow_edit(self, edit: Edit) -> None:
        for id_, record in edit.after.items():
            if isinstance(record, FaceGrid):
                self._compute(record)
            elif isinstance(edit.before[id_], FaceGrid):
                self._background.cancel(id_)
                self._exposed_areas.pop(id_, None)
                self.changed.emit(id_)

    def _follow_model(self, model_id: str) -> None:
        for grid in self.all():
            if grid.model_id == model_id:
                self._compute(grid)

    def _compute(self, grid: FaceGrid) -> None:
        geometry, open_model = _Geometry.of(grid), self._models.open_models.get(grid.model_id)
        entry = self._exposed_areas.get(grid.id)
        if open_model is None or (entry is not None and entry[0] == geometry):
            return
        self._exposed_areas[grid.id] = (geometry, None)

        def store(exposed_area: ExposedArea | None) -> None:
            self._exposed_areas[grid.id] = (geometry, exposed_area)
            self.changed.emit(grid.id)

        self._background.run(
            lambda: compute_exposed_area(
                grid, open_model.data, open_model.resolution, includes_pieces=True
            ),
            store,
            lambda _: store(None),
            key=grid.id,
        )
