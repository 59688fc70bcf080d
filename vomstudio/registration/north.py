"""From the north of a compass, or of the Earth, to that of the map."""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import date

import numpy as np
import numpy.typing as npt

from vomstudio.core.findings import Finding, Message
from vomstudio.errors import UsageError
from vomstudio.io.control.attitude_tables import AttitudeTable
from vomstudio.words import tr

Array = npt.NDArray[np.float64]

MAGNETIC_NORTH_SIGMA_DEG = 2.0
"""One sigma of the offset that all readings from magnetic north have in common. The declination of
a model of the Earth's main field contributes 0.3 to 0.5 degrees at middle latitudes (Chulliat et
al. 2015, Technical Report of the World Magnetic Model, section 3), instrument, rocks and steel
nearby the rest."""


def default_north_sigma_deg(north: str) -> float:
    """Return the common offset of readings from "grid", "true" or "magnetic" north, one sigma."""
    return MAGNETIC_NORTH_SIGMA_DEG if north == "magnetic" else 0.0


@dataclass(frozen=True)
class North:
    """What is known of north where a model is.

    crs : of the model, None where its frame is local, with true north up
    place : longitude and latitude; day : of the readings; declination_deg : as it was given, which
        counts more than the model of the field
    """

    crs: str | None = None
    place: tuple[float, float] | None = None
    day: date | None = None
    declination_deg: float | None = None

    def turn_deg(
        self,
        north: str,
        day: date | None = None,
        place: tuple[float, float] | None = None,
    ) -> float | None:
        """What is added to an azimuth from "grid", "true" or "magnetic" north; None where place or
        day is not known, by which that is found. Raises InputError."""
        if north == "grid":
            return 0.0
        there = place or self.place
        declination = 0.0
        if north == "true" and there is None and self.crs is not None:
            return None
        if north == "magnetic":
            if self.declination_deg is not None:
                declination = self.declination_deg
            else:
                when = day or self.day
                if there is None or when is None:
                    return None
                from vomstudio.io.gis.magnetic_north import declination_deg

                declination = declination_deg(*there, when)
        return declination - self.convergence_deg(there)

    def convergence_deg(self, place: tuple[float, float] | None = None) -> float:
        """By how much the north of the map lies east of true north, 0 where that is not known."""
        place = place or self.place
        from vomstudio.io.gis.crs import convergence_deg, from_degrees

        if self.crs is None or place is None:
            return 0.0
        there = from_degrees(self.crs)(*place)
        found = None if there is None else convergence_deg(self.crs, *there)
        return 0.0 if found is None else found


def on_grid(table: AttitudeTable, north: North, messages: list[Message]) -> AttitudeTable:
    """Convert all yaws to grid north.

    messages : a message about each correction is appended. Raises InputError.
    """
    angles = table.angles.copy()
    added: dict[str, list[float]] = {}
    lacking = 0
    known: dict[object, float | None] = {}
    for row, word in enumerate(table.norths):
        if not np.isfinite(angles[row, 0]):
            continue
        longitude, latitude = table.places[row].tolist()
        place = (longitude, latitude) if np.isfinite([longitude, latitude]).all() else None
        # The field hardly changes within a hundredth of a degree.
        key = (word, table.days[row], place and tuple(np.round(place, 2)))
        if key not in known:
            known[key] = north.turn_deg(word, table.days[row], place)
        turn = known[key]
        if turn is None:
            lacking += 1
        else:
            angles[row, 0] += turn
            added.setdefault(word, []).append(turn)
    messages += [_correction_finding(word, turns) for word, turns in added.items() if any(turns)]
    if lacking:
        messages.append(Finding("north.not-corrected", photos=lacking))
    return replace(table, angles=angles, norths=("grid",) * len(table.photos))


@dataclass(frozen=True)
class Turned:
    """Correction of azimuths from "grid", "true" or "magnetic" north to grid north.

    deg : added to azimuths; declination_deg : part of it, None if not needed; stated : whether the
    declination was given, not computed from a field model; convergence_deg : subtracted, None if
    not known
    """

    word: str
    deg: float
    declination_deg: float | None = None
    stated: bool = False
    convergence_deg: float | None = None
    day: date | None = None

    @property
    def finding(self) -> Finding | None:
        """The correction as a finding; None for grid north."""
        if self.word == "grid":
            return None
        correction = f"{self.deg:+.1f}°"
        if self.word == "true":
            return Finding("north.true-corrected", correction=correction, correction_deg=self.deg)
        declination = f"{self.declination_deg or 0.0:+.1f}°"
        if not self.stated:
            declination = tr("{angle} by IGRF-14 on {day}", angle=declination, day=self.day)
        known = self.convergence_deg is not None
        return Finding(
            "north.magnetic-corrected",
            correction=correction,
            correction_deg=self.deg,
            declination=declination,
            declination_deg=self.declination_deg,
            convergence=f"{self.convergence_deg:+.1f}°" if known else tr("not known"),
            convergence_deg=self.convergence_deg,
        )


def turned(word: str, north: North) -> Turned | None:
    """What becomes of azimuths; None where the declination, or the place of the convergence, is not
    known. Raises InputError."""
    deg = north.turn_deg(word)
    if deg is None:
        return None
    if word == "grid":
        return Turned(word, deg)
    # A local frame has true north up.
    sure = north.crs is None or north.place is not None
    convergence = north.convergence_deg() if sure else None
    if word == "true":
        return Turned(word, deg, convergence_deg=convergence)
    stated = north.declination_deg is not None
    declination = deg + (convergence or 0.0)
    return Turned(word, deg, declination, stated, convergence, north.day)


def turn_of(word: str, north: North, option: str) -> Turned:
    """Return the correction of azimuths from "true" or "magnetic" north.

    Raises
    ------
    UsageError
        If the declination is not known.
    """
    correction = turned(word, north)
    if correction is None:
        raise UsageError(
            Finding("north.no-declination"),
            field=option,
        )
    return correction


def _correction_finding(word: str, turns: list[float]) -> Finding:
    least, most = min(turns), max(turns)
    by = f"{least:+.1f}°" if most - least < 0.05 else f"{least:+.1f}° … {most:+.1f}°"
    if word == "magnetic":
        each = tr("that of each photo")
        return Finding(
            "north.magnetic-corrected", correction=by, declination=each, convergence=each
        )
    return Finding("north.true-corrected", correction=by)


def parse_day(text: str) -> date:
    """`2024-05-12`, and a year alone. Raises UsageError."""
    try:
        return date.fromisoformat(text if len(text) > 4 else f"{text}-07-01")
    except ValueError as error:
        raise UsageError(Finding("date.invalid", text=text[:40]), field="--date") from error


def place_of(crs: str, world: Array) -> tuple[float, float] | None:
    """Longitude and latitude of the middle of points (n, 3) in a CRS."""
    from pyproj import Transformer

    middle = np.median(world, axis=0)
    transformer = Transformer.from_crs(crs, "EPSG:4326", always_xy=True)
    longitude, latitude = transformer.transform(float(middle[0]), float(middle[1]))
    return (longitude, latitude) if np.isfinite([longitude, latitude]).all() else None
