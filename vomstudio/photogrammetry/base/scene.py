"""Cameras and tie points after the alignment, which are the input of all later stages."""

from __future__ import annotations

import json
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import (
    BoolArray,
    ByteArray,
    Float32Array,
    FloatArray,
    Int32Array,
    IntArray,
)
from vomstudio.core.errors import InputError
from vomstudio.core.files.arrays import open_arrays
from vomstudio.core.files.disk_errors import damage_reason
from vomstudio.core.files.regular import read_json
from vomstudio.core.findings import Finding
from vomstudio.geometry.cameras import View
from vomstudio.geometry.units import UNPLACED_AXES, WORLD_AXES, Axes
from vomstudio.io.photos.cameras_file import view_from_dict, view_to_dict

_VERSION = 1


@dataclass(frozen=True, eq=False)
class SparseScene:
    """One connected component of an alignment.

    Attributes
    ----------
    views : tuple of View
        Photos with a pose, in the order of their names.
    points : (n, 3) float64 array
        Tie points; World coordinates minus `origin` once the scene is registered.
    colors : (n, 3) uint8 array
    errors_px : (n,) float32 array
        Mean reprojection error of each point.
    track_offsets : (n + 1,) int64 array
        First observation (row) of each point, and the number of observations m.
    track_views : (m,) int32 array
        Row in `views` of each observation.
    track_pixels : (m, 2) float32 array
        Observed pixel of each observation.
    origin : (int, int, int)
        World coordinates subtracted from all positions.
    crs : str or None
        CRS of the World frame, "EPSG:n"; None for a local frame.
    scaled : bool
        Whether lengths are in metres; False while the unit of length is arbitrary.
    """

    views: tuple[View, ...]
    points: FloatArray
    colors: ByteArray
    errors_px: Float32Array
    track_offsets: IntArray
    track_views: Int32Array
    track_pixels: Float32Array
    origin: tuple[int, int, int] = (0, 0, 0)
    crs: str | None = None
    scaled: bool = False
    notes: tuple[str, ...] = field(default=())

    @cached_property
    def track_lengths(self) -> IntArray:
        """Number (n,) of photos that see each point."""
        return np.diff(self.track_offsets)

    @cached_property
    def track_points(self) -> IntArray:
        """Row (m,) of the point of each observation."""
        return np.repeat(np.arange(len(self.points)), self.track_lengths)

    @property
    def axes(self) -> Axes:
        """Known properties of the frame, for files and labels."""
        return WORLD_AXES if self.scaled or self.crs is not None else UNPLACED_AXES

    @property
    def centres(self) -> FloatArray:
        """Projection centres (v, 3)."""
        return np.array([view.centre for view in self.views]).reshape(-1, 3)

    def view(self, name: str) -> View:
        """Return a view by name. Raises KeyError if the photo has no pose."""
        for view in self.views:
            if view.name == name:
                return view
        raise KeyError(name)

    def observed_points(self, view: int) -> IntArray:
        """Return the rows of the points that a view observes."""
        return np.asarray(self.track_points[self.track_views == view])

    def select_points(self, is_selected: BoolArray) -> SparseScene:
        """Return the scene with only the selected tie points (n,), and all photos."""
        observations = is_selected[self.track_points]
        return replace(
            self,
            points=self.points[is_selected],
            colors=self.colors[is_selected],
            errors_px=self.errors_px[is_selected],
            track_offsets=np.concatenate([[0], np.cumsum(self.track_lengths[is_selected])]),
            track_views=self.track_views[observations],
            track_pixels=self.track_pixels[observations],
        )

    def median_pixel_size(self, positions: FloatArray) -> float:
        """Return the median pixel size of the photos at points (n, 3), in units of the scene."""
        sizes = [
            np.median(np.abs(view.depths(positions))) / np.mean(view.intrinsics.focal)
            for view in self.views
        ]
        return float(np.median(sizes))

    def save(self, folder: str | Path) -> None:
        """Write `scene.json` and `scene.npz` into an existing folder."""
        folder = Path(folder)
        np.savez(
            folder / "scene.npz",
            points=self.points,
            colors=self.colors,
            errors_px=self.errors_px,
            track_offsets=self.track_offsets,
            track_views=self.track_views,
            track_pixels=self.track_pixels,
        )
        header = {
            "version": _VERSION,
            "origin": list(self.origin),
            "crs": self.crs,
            "scaled": self.scaled,
            "notes": list(self.notes),
            "views": [view_to_dict(view) for view in self.views],
        }
        (folder / "scene.json").write_text(json.dumps(header, indent=1), encoding="utf-8")

    @classmethod
    def load(cls, folder: str | Path) -> SparseScene:
        """Load a scene.

        Raises InputError if the folder is incomplete or comes from a newer version of the program.
        """
        folder = Path(folder)
        try:
            header = read_json(folder / "scene.json")
            if header["version"] > _VERSION:
                raise InputError(
                    Finding("alignment.newer-version"),
                    file=folder / "scene.json",
                )
            with open_arrays(folder / "scene.npz") as arrays:
                return cls(
                    tuple(view_from_dict(view) for view in header["views"]),
                    **{name: arrays[name] for name in arrays.files},
                    origin=tuple(header["origin"]),
                    crs=header["crs"],
                    scaled=header["scaled"],
                    notes=tuple(header["notes"]),
                )
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise InputError(
                Finding("alignment.damaged", reason=damage_reason(error)),
                file=folder,
            ) from error
