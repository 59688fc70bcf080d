"""Models of files in World, for commands that work with two of them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.moving import moved
from vomstudio.io.gis.crs import world_crs
from vomstudio.io.models.opening import read_model
from vomstudio.io.models.reader import LoadedModel
from vomstudio.io.photos.cameras_file import scale_known
from vomstudio.progress import Progress
from vomstudio.workspace.frame_declaration import DeclaredFrame, declared_frame


@dataclass(frozen=True, eq=False)
class WorldModel:
    """data : in World, metres; crs : of World, None for a local frame
    metric : its file states its unit; warnings : of its reader
    to_world : (4, 4) from the frame of its file
    """

    data: Mesh | PointCloud
    crs: str | None
    metric: bool
    warnings: tuple[str, ...]
    loaded: LoadedModel
    to_world: npt.NDArray[np.float64]

    @property
    def placed(self) -> bool:
        """Whether north and Up are those of the Earth: not of a model that was made of photos
        without control points or GPS."""
        return self.crs is not None or scale_known(self.loaded.path) is not False


def read_in_world(
    path: str | Path, progress: Progress | None = None, declared: DeclaredFrame | None = None
) -> WorldModel:
    """The model in a file, as its file says that it stands; one that says nothing as declared, else
    as local, in metres, z up. Raises InputError, UsageError, Cancelled."""
    declared = declared or DeclaredFrame()
    loaded = read_model(path, progress)
    turned = loaded.turned_about is not None
    frame = declared_frame(loaded.path, loaded.crs, turned, declared).frame
    crs = None if frame.crs is None else world_crs(frame.crs, frame.unit_m)
    metric = loaded.unit_m is not None or frame.crs is not None or declared.unit is not None
    matrix = np.asarray(frame.to_world(), np.float64)
    data = moved(loaded.data, matrix)
    return WorldModel(data, crs, metric, loaded.warnings, loaded, matrix)
