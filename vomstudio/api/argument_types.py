"""Types of the arguments of the Python interface, for editors and type checkers."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from os import PathLike
from typing import TYPE_CHECKING, Protocol, TypeAlias

from vomstudio.core.arrays import AnyArray

if TYPE_CHECKING:
    import pandas
    from numpy.typing import ArrayLike
    from shapely.geometry.base import BaseGeometry


class ModelLike(Protocol):
    """Mesh or point cloud: `vs.Mesh`, `vs.PointCloud`."""

    def to_pyvista(self) -> object:
        """Convert to a data set of PyVista."""


class StoredModelLike(Protocol):
    """Model of a project: `vs.ProjectModel`."""

    def read(self) -> ModelLike:
        """Read the model from its file."""


class DataSetLike(Protocol):
    """Data set of PyVista: pyvista.DataSet or pyvista.MultiBlock."""

    @property
    def field_data(self) -> object:
        """Arrays that belong to the whole data set."""


class PlaneLike(Protocol):
    """Plane with an attitude in degrees: `vs.PlaneFit`."""

    @property
    def dip_direction_deg(self) -> float | None:
        """Dip direction; None if the plane is horizontal."""

    @property
    def dip_deg(self) -> float:
        """Dip."""


# Quoted, because pandas and Shapely are not imported before they are needed.
PathArgument: TypeAlias = str | PathLike[str]
"""Path of a file or folder."""
TableArgument: TypeAlias = "pandas.DataFrame | PathArgument"
"""Table, or its file."""
OrientationsArgument: TypeAlias = "TableArgument | Sequence[ArrayLike] | AnyArray"
"""Table of orientations, its file, or the pair (dip directions, dips) in degrees."""
VerticesArgument: TypeAlias = "ArrayLike | pandas.DataFrame"
"""Coordinates (n, 3), or a DataFrame with the columns x, y and z."""
ModelArgument: TypeAlias = (
    "ModelLike | StoredModelLike | DataSetLike | PathArgument | AnyArray | pandas.DataFrame"
)
"""Model, its file, or the points (n, 3) of a cloud."""
PointsArgument: TypeAlias = "VerticesArgument | ModelArgument"
"""Points (n, 3), a model, or a file with points."""
GroupsArgument: TypeAlias = "Mapping[Hashable, PointsArgument] | pandas.DataFrame"
"""Points by the id of their group, or a DataFrame with a column of ids."""
PlaneArgument: TypeAlias = str | Sequence[float] | PlaneLike
"""Plane as "DD/D", as (dip direction, dip) in degrees, or as the result of a fit."""
LinesArgument: TypeAlias = (
    "PathArgument | Sequence[ArrayLike] | Sequence[BaseGeometry] | pandas.DataFrame"
)
"""Lines as a layer file, arrays (k, 2) or (k, 3), Shapely lines or a GeoDataFrame."""
ShapeArgument: TypeAlias = "PathArgument | BaseGeometry | ArrayLike"
"""Line or polygon as a layer file, a Shapely geometry or corners (k, 2) or (k, 3)."""
