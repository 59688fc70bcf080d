"""Kinematics of the faults of a table, for `vomstudio slip`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.reprs import PrintableResult
from vomstudio.geology.faults.kinematics import (
    fault_movements,
    kinematic_axes,
    p_axes,
    right_dihedra,
    t_axes,
)
from vomstudio.geology.orientation import vectors_to_lines


class SlipRows(Protocol):
    """Table of n faults with the directed rakes of their slip."""

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
    """Axis of a fault, given by its trend and plunge, degrees."""

    trend_deg: float
    plunge_deg: float


@dataclass(frozen=True)
class FaultSlip:
    """Fault with its slip and its P and T axes.

    `slip` is the trend and plunge of the movement of the hanging wall; a negative plunge points up.
    """

    id: str
    dip_direction_deg: float
    dip_deg: float
    slip_rake_deg: float
    slip: Axis
    P: Axis
    T: Axis


@dataclass(frozen=True)
class KinematicAxis(Axis):
    """Kinematic axis with its eigenvalue.

    Attributes
    ----------
    value : float
        Eigenvalue of the kinematic tensor, -1 to 1.
    confidence95_deg : float or None
        Half-angle of the cone that contains 95 % of the resamples, degrees; None for fewer than
        five faults.
    """

    value: float
    confidence95_deg: float | None


@dataclass(frozen=True)
class TableKinematicAxes:
    """Kinematic axes of all faults (linked Bingham statistic)."""

    shortening: KinematicAxis
    intermediate: KinematicAxis
    extension: KinematicAxis


@dataclass(frozen=True)
class DihedraAxis(Axis):
    """Axis of the right dihedra, with the share of faults whose dihedra contain it."""

    share: float


@dataclass(frozen=True)
class TableDihedra:
    """Centres of the maximum overlap of the dihedra of each kind."""

    compression: DihedraAxis
    extension: DihedraAxis


@dataclass(frozen=True, repr=False)
class TableSlip(PrintableResult):
    """Kinematics of n faults; `dropped_lines` and `warnings` are those of the table."""

    n: int
    kinematic_axes: TableKinematicAxes
    right_dihedra: TableDihedra
    faults: tuple[FaultSlip, ...]
    dropped_lines: tuple[int, ...]
    warnings: tuple[Finding, ...]


def table_slip(table: SlipRows) -> TableSlip:
    """Compute the P and T axes of faults, and their kinematic axes and right dihedra.

    Parameters
    ----------
    table : SlipRows

    Returns
    -------
    TableSlip
    """
    normals, slips = fault_movements(table.dip_direction_deg, table.dip_deg, table.slip_rake_deg)
    axes = kinematic_axes(normals, slips)
    cones = [None] * 3 if axes.confidence95_deg is None else axes.confidence95_deg.tolist()
    lines = _axes(axes.axes)
    extension, intermediate, shortening = (
        KinematicAxis(*line, value, cone)
        for line, value, cone in zip(lines, axes.values.tolist(), cones, strict=True)
    )
    dihedra = right_dihedra(normals, slips)
    compression_axis, extension_axis = (
        DihedraAxis(*_axes(axis[None])[0], share)
        for axis, share in (dihedra.compression_maximum(), dihedra.extension_maximum())
    )
    rows = zip(
        table.ids,
        table.dip_direction_deg.tolist(),
        table.dip_deg.tolist(),
        table.slip_rake_deg.tolist(),
        _axes(slips, is_directed=True),
        _axes(p_axes(normals, slips)),
        _axes(t_axes(normals, slips)),
        strict=True,
    )
    return TableSlip(
        n=len(table.ids),
        kinematic_axes=TableKinematicAxes(shortening, intermediate, extension),
        right_dihedra=TableDihedra(compression_axis, extension_axis),
        faults=tuple(
            FaultSlip(id_, azimuth, dip, rake, Axis(*slip), Axis(*p), Axis(*t))
            for id_, azimuth, dip, rake, slip, p, t in rows
        ),
        dropped_lines=table.dropped,
        warnings=table.warnings,
    )


def _axes(vectors: FloatArray, *, is_directed: bool = False) -> list[tuple[float, float]]:
    trend, plunge, _ = vectors_to_lines(vectors, is_directed=is_directed)
    return list(zip(trend.tolist(), plunge.tolist(), strict=True))
