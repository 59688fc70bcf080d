"""Correction of azimuths from magnetic or true north to grid north."""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import date, datetime, time

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.registrations import NorthKind, NorthReference
from vomstudio.io.control.attitude_tables import AttitudeTable

MAGNETIC_NORTH_SIGMA_DEG = 2.0
"""One-sigma error common to all readings from magnetic north. The declination from a model of the
Earth's main field contributes 0.3 to 0.5 degrees at middle latitudes (Chulliat et al. 2015,
Technical Report of the World Magnetic Model, section 3). The rest is caused by the instrument,
rocks and nearby steel."""


FIRST_YEAR, LAST_YEAR = 1900, 2029
"""First and last year covered by the field model."""
_MAX_LATITUDE_DEG = 89.9
_MIN_HORIZONTAL_FIELD_NT = 2000.0
"""Horizontal field below which a compass does not work (WMM2025 report, "blackout zone")."""
_YAW_CORRECTION_CODES = {
    "true": "north.true-yaws-corrected",
    "magnetic": "north.magnetic-yaws-corrected",
}


def default_north_sigma_deg(north: str) -> float:
    """Return the default one-sigma error that is common to all readings.

    Parameters
    ----------
    north : {"grid", "true", "magnetic"}
        North reference of the readings.

    Returns
    -------
    float
    """
    return MAGNETIC_NORTH_SIGMA_DEG if north == "magnetic" else 0.0


@dataclass(frozen=True)
class NorthCorrection:
    """Correction of azimuths from "grid", "true" or "magnetic" north to grid north.

    Parameters
    ----------
    north : {"grid", "true", "magnetic"}
    deg : float
        Angle that is added to azimuths.
    declination_deg : float or None
        Contribution of the declination, or None if it is not needed.
    stated : bool
        Whether the declination was stated instead of computed from a field model.
    convergence_deg : float or None
        Meridian convergence, which is subtracted, or None if unknown.
    day : date or None
        Day of the readings.
    """

    north: NorthKind
    deg: float
    declination_deg: float | None = None
    stated: bool = False
    convergence_deg: float | None = None
    day: date | None = None

    def read_north(self, sigma_deg: float) -> NorthReference:
        """Return the record of the correction.

        `sigma_deg` is the one-sigma error common to all readings.
        """
        day = "" if self.day is None else self.day.isoformat()
        return NorthReference(
            self.north, self.deg, self.declination_deg, self.stated, day, sigma_deg
        )

    @property
    def finding(self) -> Finding | None:
        """Finding that describes the correction, or None for grid north."""
        if self.north == "grid":
            return None
        values = {"correction_deg": self.deg}
        if self.north == "true":
            if self.convergence_deg is None:
                return Finding("north.true-unchanged")
            return Finding("north.true-corrected", **values)
        source = tr("as stated") if self.stated else f"IGRF-14, {self.day}"
        if self.convergence_deg is None:
            return Finding("north.declination-added", **values, source=source)
        return Finding(
            "north.magnetic-corrected",
            **values,
            source=source,
            declination_deg=self.declination_deg,
            convergence_deg=self.convergence_deg,
        )

    @property
    def summary(self) -> str:
        """Sentence that describes the correction."""
        finding = self.finding
        return tr("Azimuths are used as read.") if finding is None else finding.message


@dataclass(frozen=True)
class NorthInputs:
    """Data required to correct azimuths at the location of a model.

    Parameters
    ----------
    crs : str or None
        CRS of the model, or None if its frame is local with y towards true north.
    location : (float, float) or None
        Longitude and latitude, degrees.
    day : date or None
        Day of the readings.
    declination_deg : float or None
        Stated declination, used instead of the field model.
    """

    crs: str | None = None
    location: tuple[float, float] | None = None
    day: date | None = None
    declination_deg: float | None = None

    def correction(
        self, north: str, day: date | None = None, place: tuple[float, float] | None = None
    ) -> NorthCorrection | None:
        """Return the correction of azimuths, or None if a required location or day is unknown.

        Parameters
        ----------
        north : {"grid", "true", "magnetic"}
        day, place : optional
            Day, and longitude and latitude, of the readings; by default those of the model.

        Raises
        ------
        InputError
            For the reasons given in the function `declination_deg`.
        """
        day, place = day or self.day, place or self.location
        if north == "grid":
            return NorthCorrection("grid", 0.0, day=day)
        convergence = self.convergence_deg(place)
        if north == "true":
            if convergence is None and self.crs is not None:
                return None
            return NorthCorrection(
                "true", -(convergence or 0.0), convergence_deg=convergence, day=day
            )
        declination = self.declination_deg
        if declination is None:
            if place is None or day is None:
                return None
            declination = declination_deg(*place, day)
        is_stated = self.declination_deg is not None
        deg = declination - (convergence or 0.0)
        return NorthCorrection("magnetic", deg, declination, is_stated, convergence, day)

    def require_correction(self, north: str, option: str = "") -> NorthCorrection:
        """Return the correction of azimuths.

        Raises
        ------
        UsageError
            If the declination, or the location required for the convergence, is unknown.
        InputError
            For the reasons given in the function `declination_deg`.
        """
        correction = self.correction(north)
        if correction is None:
            code = "north.no-declination" if north == "magnetic" else "north.no-convergence"
            raise UsageError(Finding(code), field=option)
        return correction

    def convergence_deg(self, place: tuple[float, float] | None = None) -> float | None:
        """Return the angle from true to grid north, positive eastwards, or None if unknown."""
        place = place or self.location
        from vomstudio.io.gis.crs import convergence_deg, degrees_to_grid

        if self.crs is None or place is None:
            return None
        grid_position = degrees_to_grid(self.crs)(*place)
        return None if grid_position is None else convergence_deg(self.crs, *grid_position)


def declination_deg(
    longitude_deg: float, latitude_deg: float, day: date, height_m: float = 0.0
) -> float:
    """Return the angle from true to magnetic north, positive eastwards.

    The angle follows the International Geomagnetic Reference Field, 14th generation (IAGA, doi
    10.5281/zenodo.14012302), and is computed with the `ppigrf` package of IAGA. The crustal field,
    which the model does not contain, changes the angle by some tenths of a degree.

    Raises
    ------
    InputError
        If the day is outside the years of the model, or the magnetic pole is so near that a compass
        does not point north.
    """
    from ppigrf import igrf

    if not FIRST_YEAR <= day.year <= LAST_YEAR:
        raise InputError(
            Finding("north.unknown-year", first=FIRST_YEAR, last=LAST_YEAR, year=day.year)
        )
    latitude = float(np.clip(latitude_deg, -_MAX_LATITUDE_DEG, _MAX_LATITUDE_DEG))
    noon = datetime.combine(day, time(12))
    east, north, _ = igrf(longitude_deg, latitude, height_m / 1000.0, noon)
    x, y = float(np.ravel(north)[0]), float(np.ravel(east)[0])
    if np.hypot(x, y) < _MIN_HORIZONTAL_FIELD_NT:
        raise InputError(Finding("north.near-pole"))
    return float(np.degrees(np.arctan2(y, x)))


def convert_to_grid_north(
    table: AttitudeTable, north: NorthInputs, findings: list[Finding]
) -> AttitudeTable:
    """Convert yaws to grid north.

    Yaws whose correction is unknown are left unchanged and reported.

    Parameters
    ----------
    table : AttitudeTable
    north : NorthInputs
    findings : list of Finding
        List to which findings about the corrections are appended.

    Returns
    -------
    AttitudeTable

    Raises
    ------
    InputError
        For the reasons given in the function `declination_deg`.
    """
    angles = table.angles.copy()
    corrections_by_reference: dict[str, list[float]] = {}
    uncorrected_count = 0
    cached_corrections: dict[object, NorthCorrection | None] = {}
    for row, reference in enumerate(table.north_references):
        if not np.isfinite(angles[row, 0]):
            continue
        longitude, latitude = table.coordinates[row].tolist()
        location = (longitude, latitude) if np.isfinite([longitude, latitude]).all() else None
        # The field is practically constant within a hundredth of a degree.
        key = (reference, table.days[row], location and tuple(np.round(location, 2)))
        if key not in cached_corrections:
            cached_corrections[key] = north.correction(reference, table.days[row], location)
        correction = cached_corrections[key]
        if correction is None:
            uncorrected_count += 1
        else:
            angles[row, 0] += correction.deg
            corrections_by_reference.setdefault(reference, []).append(correction.deg)
    findings += [
        Finding(
            _YAW_CORRECTION_CODES[reference],
            minimum_deg=min(corrections_deg),
            maximum_deg=max(corrections_deg),
        )
        for reference, corrections_deg in corrections_by_reference.items()
        if any(corrections_deg)
    ]
    if uncorrected_count:
        findings.append(Finding("north.not-corrected", photos=uncorrected_count))
    return replace(table, angles=angles, north_references=("grid",) * len(table.photos))


def parse_angle(text: str, field: str = "", minimum: float = -180.0) -> float:
    """Parse an angle of at most 180 degrees.

    Parameters
    ----------
    text : str
    field : str, optional
        Option that is named in the error.
    minimum : float, optional
        Minimum angle, degrees.

    Returns
    -------
    float
        Angle, degrees.

    Raises
    ------
    UsageError
        If the text is not an angle in this range.
    """
    try:
        value = float(text.strip().rstrip("°").replace(",", ".").replace("−", "-"))
    except ValueError:
        value = np.nan
    if not minimum <= value <= 180.0:
        raise UsageError(Finding("number.not-an-angle", text=text.strip()[:40]), field=field)
    return value


def parse_day(text: str) -> date:
    """Parse a day such as `2024-05-12`, or a year.

    Parameters
    ----------
    text : str

    Returns
    -------
    date

    Raises
    ------
    UsageError
        If the text is neither a day nor a year.
    """
    try:
        return date.fromisoformat(text if len(text) > 4 else f"{text}-07-01")
    except ValueError as error:
        raise UsageError(Finding("date.invalid", text=text[:40]), field="--date") from error


def centre_longitude_latitude(crs: str, world: FloatArray) -> tuple[float, float] | None:
    """Return the longitude and latitude of the centre of points.

    Parameters
    ----------
    crs : str
    world : (n, 3) ndarray

    Returns
    -------
    tuple of float or None
        Longitude and latitude, degrees, or None if it is outside the CRS.
    """
    from vomstudio.io.gis.crs import to_degrees

    median = np.median(world, axis=0)
    location = to_degrees(crs, median[:1], median[1:2])
    return None if location is None else (float(location[0][0]), float(location[1][0]))
