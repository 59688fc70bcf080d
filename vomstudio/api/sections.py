"""Sections and profiles of models."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vomstudio.api.checking import (
    check_flag,
    numbers,
    require_valid_rows,
    to_path,
    wrong_shape_error,
)
from vomstudio.api.declared_options import name_arguments_in_errors, options_from_arguments
from vomstudio.api.models import Mesh, PointCloud, to_model
from vomstudio.api.planes import plane_text
from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding, to_json_list
from vomstudio.core.reprs import html_table, text_table
from vomstudio.core.results import to_dict
from vomstudio.geology.notation import format_azimuth
from vomstudio.products.section.cutting import Cut, cut_model
from vomstudio.products.section.section_lines import (
    Curtain,
    curtain_from_line,
    curtain_from_options,
)
from vomstudio.products.section.section_options import SectionOptions
from vomstudio.products.section.writing import (
    SectionFigures,
    WrittenSection,
    section_figures,
    write_section,
)

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from vomstudio.api.argument_types import ModelArgument, PlaneArgument


@dataclass(frozen=True, eq=False, repr=False)
class Section:
    """Intersection of a model with a plane or a vertical curtain.

    Attributes
    ----------
    polylines
        Lines (n, 3) of the intersection in the World frame.
    profiles
        The same lines as (n, 2): distance along the section, and height in it (Z if the
        section is vertical), metres.
    figures
        Figures as printed by the command; some of them are also attributes, such
        as length_m and slab_m.

    Examples
    --------
    >>> import vomstudio as vs
    >>> cliff = vs.read(vs.sample("sample.obj"))
    >>> across = vs.section(cliff, plane=(110, 90), through=cliff.bounds.mean(axis=0))
    >>> len(across.polylines) == len(across.profiles), across.length_m > 10
    (True, True)
    """

    polylines: tuple[FloatArray, ...]
    profiles: tuple[FloatArray, ...]
    figures: SectionFigures
    _model: Mesh | PointCloud = field(repr=False)
    _curtain: Curtain = field(repr=False)
    _cut: Cut = field(repr=False)

    @property
    def length_m(self) -> float:
        """Total length of all lines, metres."""
        return self.figures.length_m

    @property
    def slab_m(self) -> float | None:
        """Thickness of the slab of cloud points, metres; None for a mesh."""
        return self.figures.slab_m

    @property
    def dip_direction_deg(self) -> float | None:
        """Dip direction of the section plane; None for a bent section."""
        return self.figures.dip_direction_deg

    @property
    def dip_deg(self) -> float | None:
        """Dip of the section plane; None for a bent section."""
        return self.figures.dip_deg

    @property
    def left_deg(self) -> float:
        """Azimuth of the left end, degrees."""
        return self.figures.left_deg

    @property
    def right_deg(self) -> float:
        """Azimuth of the right end, degrees."""
        return self.figures.right_deg

    @property
    def warnings(self) -> tuple[Finding, ...]:
        """Findings about the model, such as an assumed frame."""
        return self._model.warnings

    def to_dict(self) -> dict[str, object]:
        """Return the object that ``--json`` prints, without the names of files."""
        return to_dict(self.figures) | {"warnings": to_json_list(self.warnings)}

    def save(self, path: str | Path, *, force: bool = False) -> WrittenSection:
        """Write the section as .csv, .dxf or .svg, as the command does.

        Parameters
        ----------
        path : str or Path
            Path of the file; the suffix determines the format.
        force : bool, optional
            Whether to replace an existing file.

        Returns
        -------
        WrittenSection
            Result as the command prints it.

        Raises
        ------
        vs.errors.UsageError
            If the suffix is unknown.
        vs.errors.TargetError
            If the file exists or cannot be written.
        """
        file, replace = to_path(path, "path"), check_flag(force, "force")
        source = self._model._source
        return write_section(
            file,
            self._cut,
            self._curtain,
            self.figures,
            crs=self._model.crs,
            model=str(source.path),
            is_metric=source.is_metric or source.is_placed,
            is_north_known=source.is_placed,
            force=replace,
        )

    def _repr_values(self) -> dict[str, Any]:
        f = self.figures
        return {
            "lines": f"{f.polylines}, {f.length_m:.3f} m in all",
            "from": f"{format_azimuth(f.left_deg, 1)} deg",
            "toward": f"{format_azimuth(f.right_deg, 1)} deg",
            "slab": None if f.slab_m is None else f"{f.slab_m:.3g} m",
        }

    def __repr__(self) -> str:
        return text_table("Section", self._repr_values())

    def _repr_html_(self) -> str:
        return html_table("Section", self._repr_values())


def section(
    model: ModelArgument,
    *,
    plane: PlaneArgument | None = None,
    through: ArrayLike | None = None,
    section_line: ArrayLike | None = None,
    flip: bool = False,
    slab_m: float | None = None,
) -> Section:
    """Cut a model along a plane, or vertically along a line.

    Parameters
    ----------
    model : Mesh, PointCloud, model of a project, path, or (n, 3) array
        Model in the World frame, metres.
    plane : str, (float, float) or PlaneFit, optional
        Plane of the section as "DD/D", (dip direction, dip) or a PlaneFit.
    through : (3,) array, optional
        Point on the plane in the World frame, metres.
    section_line : (n, 2) array, optional
        Alternatively, a line on the map as x, y in the World frame, metres.
    flip : bool, optional
        Whether to view the section from the other side, as a mirror image.
    slab_m : float, optional
        Thickness of the slab of cloud points along the section, metres; by default four
        times the mean spacing of the points.

    Returns
    -------
    Section
        ``polylines`` in the World frame, ``profiles`` in the section, ``length_m``;
        ``.save(path)`` writes a file.

    Raises
    ------
    vs.errors.UsageError
        If not exactly one of a plane (with a point) and a line is given.
    vs.errors.InputError
        If the section misses the model, or the line has another shape.

    Notes
    -----
    A mesh is cut exactly, triangle by triangle. The points of a cloud in the slab are linked.

    Examples
    --------
    >>> import vomstudio as vs
    >>> cliff = vs.read(vs.sample("sample.obj"))
    >>> cut = vs.section(cliff, plane="121/90", through=cliff.bounds.mean(axis=0))
    >>> cut.length_m > 5
    True
    """
    point = None if through is None else numbers(through, "through")
    options = options_from_arguments(
        SectionOptions,
        locals(),
        plane=plane_text(plane),
        through=None if point is None else ",".join(map(repr, point.ravel().tolist())),
        section_line=None if section_line is None else "section_line",
    )
    with name_arguments_in_errors(SectionOptions):
        if section_line is None:
            curtain = curtain_from_options(options)
        else:
            line = numbers(section_line, "section_line")
            if line.ndim != 2 or line.shape[1] < 2:
                raise wrong_shape_error(line, "(n, 2)", "section_line")
            require_valid_rows(np.asarray(~np.isfinite(line).all(axis=1)), "section_line")
            curtain = curtain_from_line(line)
            curtain = curtain.flipped() if flip else curtain
        data = to_model(model)
        cut = cut_model(data._data, curtain, options.slab_m)
    figures = section_figures(cut, curtain, (), 0)
    return Section(cut.world, cut.lines, figures, data, curtain, cut)
