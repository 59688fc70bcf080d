"""Orthographic images of a model along any direction."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vomstudio.api.checking import check_flag, name_argument_in_errors, optional_path, to_path, warn
from vomstudio.api.declared_options import name_arguments_in_errors, options_from_arguments
from vomstudio.api.models import Mesh, PointCloud, to_model
from vomstudio.api.planes import plane_text
from vomstudio.api.reporting import ProgressArgument, to_progress
from vomstudio.api.sets import fold as fold_of
from vomstudio.core.arrays import ByteArray, Float32Array
from vomstudio.core.findings import Finding
from vomstudio.core.reprs import html_table, text_table
from vomstudio.core.results import HIDDEN_IN_JSON
from vomstudio.geology.notation import format_azimuth
from vomstudio.geology.table_folds import TableFold
from vomstudio.products.ortho.drawn_picture import DrawnPicture, draw_picture, picture_figures
from vomstudio.products.ortho.ortho_options import OrthoOptions
from vomstudio.products.ortho.orthophoto import write_orthophoto
from vomstudio.products.ortho.requests import (
    FoldView,
    OrthophotoFigures,
    PlannedPicture,
    direction_from_options,
    plan_picture,
)

if TYPE_CHECKING:
    from vomstudio.api.argument_types import ModelArgument, OrientationsArgument, PlaneArgument


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Orthophoto(OrthophotoFigures):
    """Orthographic image of a model with the World coordinates of its pixels.

    Attributes
    ----------
    image
        (h, w, 4) uint8 values of red, green, blue and opacity.
    depth
        (h, w) float32 distance along the view direction from the plane through
        ``reference_point``, metres, increasing away from the viewer; NaN if no surface is
        visible.
    width, height
        Size of the image, pixels.
    gsd_m
        Ground sampling distance, metres per pixel.
    coverage
        Share of the image that shows the model.
    trend_deg, plunge_deg
        View direction; the plunge is negative upwards.
    right, down, direction
        (3,) unit vectors in the World frame, in the image plane and along the view.
    sense, sense_reason
        Selected one of the two opposite view directions, and the reason.
    reference_point
        (3,) point in the World frame at which the depth is 0.
    pixel_to_world
        (4, 4) matrix that transforms (column, row, depth, 1) to the World frame. (0, 0) is
        the outer corner of the top-left pixel, and (0.5, 0.5) is its centre.
    crs
        CRS if the view is straight down or up, otherwise None.
    fold
        Fold axis along which the model is viewed; None if no fold is given.
    warnings
        Findings about the model, the view and the image.

    Examples
    --------
    World coordinates of the centre of the image, at the depth of the reference point:

    >>> import vomstudio as vs
    >>> photo = vs.orthophoto(vs.sample("sample.obj"), trend_deg=0, plunge_deg=0, gsd_m=0.5)
    >>> x, y, z, _ = photo.pixel_to_world @ [photo.width / 2, photo.height / 2, 0, 1]
    >>> bool(abs(x - photo.reference_point[0]) < photo.gsd_m)
    True
    """

    image: ByteArray = field(metadata=HIDDEN_IN_JSON)
    depth: Float32Array = field(metadata=HIDDEN_IN_JSON)
    fold: FoldView | None
    warnings: tuple[Finding, ...]
    _model: Mesh | PointCloud = field(metadata=HIDDEN_IN_JSON)
    _request: PlannedPicture = field(metadata=HIDDEN_IN_JSON)
    _picture: DrawnPicture = field(metadata=HIDDEN_IN_JSON)

    def save(
        self, path: str | Path, *, sheet: str | Path | None = None, force: bool = False
    ) -> tuple[Path, ...]:
        """Write NAME.tif with NAME_depth.tif, NAME.json and, for a map, NAME.tfw.

        Parameters
        ----------
        path : str or Path
            Path of NAME.tif.
        sheet : str or Path, optional
            Additional image (.png, .jpg, .pdf) with a scale bar and a north arrow.
        force : bool
            Whether to replace existing files.

        Returns
        -------
        tuple of Path
            Paths of the written files.

        Raises
        ------
        vs.errors.UsageError
            If the suffix is not .tif.
        vs.errors.TargetError
            If a file exists or cannot be written.
        """
        file, sheet_path = to_path(path, "path"), optional_path(sheet, "sheet")
        with name_argument_in_errors("path", "--output"):
            result = write_orthophoto(
                self._model._data,
                self._request.plan,
                file,
                crs=self._model._source.world_crs,
                model=str(self._model.path),
                content_hash=self._model._source.content_hash,
                sheet=sheet_path,
                force=check_flag(force, "force"),
                drawn_source=self._picture,
            )
        files = (result.image, result.depth, result.sidecar, result.world_file, result.sheet)
        return tuple(file for file in files if file is not None)

    def _repr_values(self) -> dict[str, Any]:
        azimuth = format_azimuth(self.trend_deg, 1)
        return {
            "pixels": f"{self.width} x {self.height} of {self.gsd_m:g} m",
            "toward": f"{azimuth}/{self.plunge_deg:.1f} trend/plunge, {self.sense}",
            "coverage": f"{100 * self.coverage:.0f} %",
            "crs": self.crs,
            "warnings": self.warnings or None,
        }

    def __repr__(self) -> str:
        return text_table("Orthophoto", self._repr_values())

    def _repr_html_(self) -> str:
        return html_table("Orthophoto", self._repr_values())


def orthophoto(
    model: ModelArgument,
    *,
    trend_deg: float | None = None,
    plunge_deg: float | None = None,
    plane: PlaneArgument | None = None,
    fold: OrientationsArgument | TableFold | None = None,
    gsd_m: float | None = None,
    flip: bool = False,
    progress: ProgressArgument = None,
) -> Orthophoto:
    """Create an orthographic image of a model along a view direction, in memory.

    Parameters
    ----------
    model : Mesh, PointCloud, model of a project, path, or (n, 3) array
        Model in the World frame, metres.
    trend_deg, plunge_deg : float, optional
        View direction; a plunge of 90 is straight down.
    plane : str, (float, float) or PlaneFit, optional
        Alternatively, plane that is viewed against its upward normal: "DD/D", (dip
        direction, dip) or a PlaneFit.
    fold : DataFrame, path or TableFold, optional
        Alternatively, planes along whose fold axis the model is viewed, as a table for
        `vs.fold` or its result. The view is down-plunge unless the viewer would be inside
        the cliff.
    gsd_m : float, optional
        Ground sampling distance, metres per pixel; by default the resolution of the texture
        or cloud.
    flip : bool, optional
        Whether to view from the opposite side.
    progress : callable or Progress, optional
        Called with (stage, completed steps, total steps or None).

    Returns
    -------
    Orthophoto
        ``image``, ``depth``, ``pixel_to_world``, ``coverage`` and the other figures of the
        command; ``.save(path)`` writes its files.

    Raises
    ------
    vs.errors.UsageError
        If not exactly one direction is given, the plunge exceeds 90 degrees, or the image
        would be too large.
    vs.errors.InputError
        If the model has no surface.

    Notes
    -----
    Parallel rays are cast; the nearest surface is visible.

    Examples
    --------
    >>> import vomstudio as vs
    >>> picture = vs.orthophoto(vs.sample("sample.obj"), trend_deg=0, plunge_deg=90, gsd_m=0.5)
    >>> picture.image.shape == (*picture.depth.shape, 4), picture.crs
    (True, 'EPSG:32633')
    """
    # `fold` is a table or its fold here, but a file on the command line.
    options = options_from_arguments(
        OrthoOptions, locals(), plane=plane_text(plane), fold=None if fold is None else "fold"
    )
    report = to_progress(progress)
    if fold is None or isinstance(fold, TableFold):
        table = fold
    else:
        with name_argument_in_errors("fold", "table"):
            table = fold_of(fold)
    with name_arguments_in_errors(OrthoOptions):
        direction = direction_from_options(options, table)
    data = to_model(model)
    source = data._source
    request = plan_picture(
        data._data,
        direction,
        to_world=np.eye(4),
        path=data.path,
        gsd_m=options.gsd_m,
        flip=options.flip,
        is_placed=source.is_placed,
        is_metric=source.is_metric,
    )
    picture = draw_picture(data._data, request.plan, report)
    figures = picture_figures(picture, request.plan, source.world_crs)
    findings = (*request.warnings, *request.plan.notes, *picture.findings)
    warn(findings)
    return Orthophoto(
        **vars(figures),
        image=picture.rgba,
        depth=picture.depth,
        fold=request.fold,
        warnings=findings,
        _model=data,
        _request=request,
        _picture=picture,
    )
