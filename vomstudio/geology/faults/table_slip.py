"""The faults of a table together: what `vomstudio slip` prints."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.reprs import PrintableResult
from vomstudio.geology.faults.kinematics import (
    kinematic_axes,
    movements,
    p_axes,
    right_dihedra,
    t_axes,
)
from vomstudio.geology.orientation import vectors_to_lines


class SlipRows(Protocol):
    """n faults with the directed rake of their slip, wherever they were read."""

    @property
    def path(self) -> Path: ...
    @property
    def ids(self) -> tuple[str, ...]: ...
    @property
    def dip_direction_deg(self) -> FloatArray: ...
    @property
    def dip_deg(self) -> FloatArray: ...
    @property
    def slip_rake_deg(self) -> FloatArray: ...
    @property
    def dropped(self) -> tuple[int, ...]: ...
    @property
    def warnings(self) -> tuple[Finding, ...]: ...


@dataclass(frozen=True)
class Axis:
    """Trend and plunge, degrees."""

    trend_deg: float
    plunge_deg: float


@dataclass(frozen=True)
class FaultSlip:
    """A fault with the trend and plunge (negative: up) of its hanging wall's movement, and its axes
    of shortening (P) and extension (T)."""

    id: str
    dip_direction_deg: float
    dip_deg: float
    slip_rake_deg: float
    slip: Axis
    P: Axis
    T: Axis


@dataclass(frozen=True)
class KinematicAxis(Axis):
    """value : of the tensor, from -1 to 1. confidence95_deg : the cone that holds 95 % of
    resamples, None of fewer than five faults"""

    value: float
    confidence95_deg: float | None


@dataclass(frozen=True)
class KinematicAxesFound:
    """Of all faults together (linked Bingham)."""

    shortening: KinematicAxis
    intermediate: KinematicAxis
    extension: KinematicAxis


@dataclass(frozen=True)
class DihedraAxis(Axis):
    """share : of the faults whose dihedra hold it"""

    share: float


@dataclass(frozen=True)
class DihedraFound:
    """The middles of where most dihedra of one kind overlap."""

    compression: DihedraAxis
    extension: DihedraAxis


@dataclass(frozen=True, repr=False)
class TableSlip(PrintableResult):
    """n : faults. dropped_lines, warnings : of the table as it was read"""

    n: int
    kinematic_axes: KinematicAxesFound
    right_dihedra: DihedraFound
    faults: tuple[FaultSlip, ...]
    dropped_lines: tuple[int, ...]
    warnings: tuple[Finding, ...]


def table_slip(table: SlipRows) -> TableSlip:
    """P and T axes of each fault, and what all say together."""
    normals, slips = movements(table.dip_direction_deg, table.dip_deg, table.slip_rake_deg)
    axes = kinematic_axes(normals, slips)
    cones = [None] * 3 if axes.confidence95_deg is None else axes.confidence95_deg.tolist()
    lines = _axes(axes.axes)
    extension, intermediate, shortening = (
        KinematicAxis(*line, value, cone)
        for line, value, cone in zip(lines, axes.values.tolist(), cones, strict=True)
    )
    dihedra = right_dihedra(normals, slips)
    compressed, extended = (
        DihedraAxis(*_axes(axis[None])[0], share)
        for axis, share in (dihedra.most_compressed(), dihedra.most_extended())
    )
    rows = zip(
        table.ids,
        table.dip_direction_deg.tolist(),
        table.dip_deg.tolist(),
        table.slip_rake_deg.tolist(),
        _axes(slips, directed=True),
        _axes(p_axes(normals, slips)),
        _axes(t_axes(normals, slips)),
        strict=True,
    )
    return TableSlip(
        n=len(table.ids),
        kinematic_axes=KinematicAxesFound(shortening, intermediate, extension),
        right_dihedra=DihedraFound(compressed, extended),
        faults=tuple(
            FaultSlip(id_, azimuth, dip, rake, Axis(*slip), Axis(*p), Axis(*t))
            for id_, azimuth, dip, rake, slip, p, t in rows
        ),
        dropped_lines=table.dropped,
        warnings=table.warnings,
    )


def _axes(vectors: FloatArray, *, directed: bool = False) -> list[tuple[float, float]]:
    trend, plunge, _ = vectors_to_lines(vectors, directed=directed)
    return list(zip(trend.tolist(), plunge.tolist(), strict=True))
