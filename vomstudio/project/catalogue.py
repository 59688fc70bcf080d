"""Figures shared by several kinds, with the figures of planes and lines in table order."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from vomstudio.core.arrays import FloatArray
from vomstudio.core.words import to_translate, tr
from vomstudio.core.words import to_translate as _
from vomstudio.geometry.planes import FittedPlane
from vomstudio.project.figures import Figure, Subject
from vomstudio.project.figures import figure_in_degrees as _degrees
from vomstudio.project.figures import figure_in_metres as _metres
from vomstudio.project.figures import text_figure as _text
from vomstudio.project.records import ModelFeature
from vomstudio.project.slip_figures import SLIP

MISSING_MODEL_TEXT = to_translate("local frame: the model is missing")
GRID_NORTH_TEXT = to_translate("grid north, as entered")

Value = Callable[[Subject], Any]


def _fit(name: str) -> Value:
    return lambda subject: (
        None if subject.measured.fit is None else getattr(subject.measured.fit, name)
    )


def _plane(name: str) -> Value:
    return lambda subject: (
        None if subject.measured.plane is None else getattr(subject.measured.plane, name)
    )


def _line(name: str) -> Value:
    return lambda subject: (
        None if subject.measured.line is None else getattr(subject.measured.line, name)
    )


def _fit_value(plane_name: str, line_name: str) -> Value:
    """Return a function for a value of a fitted plane, otherwise of a fitted line."""

    def value(s: Subject) -> Any:
        fit, line = s.measured.fit, s.measured.line_fit
        if fit is not None:
            return getattr(fit, plane_name)
        return None if line is None else getattr(line, line_name)

    return value


def _feature(name: str) -> Value:
    """Return a function for a record field, which returns None if it is empty or missing."""
    return lambda subject: getattr(subject.feature, name, None) or None


def _type(subject: Subject) -> str | None:
    kind = subject.type
    return kind.name.casefold() if kind is not None else getattr(subject.feature, "type_id", None)


def _is_undefined(subject: Subject) -> bool | None:
    orientation = subject.measured.fit or subject.measured.plane or subject.measured.line
    return None if orientation is None else bool(orientation.undefined)


def _element(subject: Subject) -> str | None:
    if subject.measured.plane is not None:
        return "plane"
    return None if subject.measured.line is None else "line"


def feature_centre(subject: Subject) -> FloatArray | None:
    """Return the centre (3,) of a feature in the World frame, or None if it has no points."""
    if subject.measured.fit is not None:
        return subject.measured.fit.centroid
    return subject.measured.points.mean(axis=0) if len(subject.measured.points) else None


def _place(axis: int) -> Value:
    def value(s: Subject) -> float | None:
        position = feature_centre(s)
        return None if position is None else float(position[axis])

    return value


def _normal(axis: int) -> Value:
    def value(s: Subject) -> float | None:
        fit: FittedPlane | None = s.measured.fit
        if fit is not None:
            return float(fit.normal[axis])
        return None if s.measured.plane is None else float(s.measured.plane.normal()[axis])

    return value


def _eigenvalue(index: int) -> Value:
    def value(s: Subject) -> float | None:
        return None if s.measured.fit is None else float(s.measured.fit.eigenvalues[index])

    return value


def _ratio(subject: Subject) -> float | None:
    fit, resolution = subject.measured.fit, subject.measured.resolution_m
    extent = None if fit is None else fit.extent
    return extent / resolution if extent and math.isfinite(extent) and resolution else None


def _quality(subject: Subject) -> str | None:
    return subject.measured.verdict.quality if subject.measured.verdict else None


def _reasons(subject: Subject) -> str | None:
    if subject.measured.verdict is None:
        return None if subject.measured.problem is None else str(subject.measured.problem)
    return " ".join(item.message for item in subject.measured.verdict.reasons)


def _reason_codes(subject: Subject) -> str | None:
    if subject.measured.verdict is None:
        return None if subject.measured.problem is None else subject.measured.problem.code
    return " ".join(item.code for item in subject.measured.verdict.reasons)


def _quality_notes(subject: Subject) -> str | None:
    notes = subject.measured.verdict.notes if subject.measured.verdict else ()
    return " ".join(item.message for item in notes) if subject.measured.verdict else None


def _profile(subject: Subject) -> str | None:
    return subject.measured.verdict.profile if subject.measured.verdict else None


def _covariance(row: int, column: int) -> Value:
    """Return a function for one element of the covariance of a plane's normal."""

    def value(s: Subject) -> float | None:
        covariance = s.normal_covariance
        return None if covariance is None else float(covariance[row, column])

    return value


def _method(subject: Subject) -> str | None:
    if subject.measured.fit is not None:
        return subject.measured.fit.method
    return None if subject.measured.line_fit is None else "line"


def _model(subject: Subject) -> str | None:
    model = subject.model
    return None if model is None else model.name


def _frame(subject: Subject) -> str:
    if not isinstance(subject.feature, ModelFeature):
        return tr(GRID_NORTH_TEXT)
    model = subject.model
    return tr(MISSING_MODEL_TEXT) if model is None else model.frame.name()


def _is_overturned(subject: Subject) -> bool | None:
    value = getattr(subject.feature, "overturned", None)
    return None if value is None else bool(value)


def _angle_to_pick(subject: Subject) -> float | None:
    pick = subject.nearest()
    return None if pick is None else pick.angle_deg


def _measured_value(name: str) -> Value:
    return lambda subject: getattr(subject.measured, name)


def _quality_text(subject: Subject) -> str:
    return _quality(subject) or (tr("no plane") if subject.measured.problem else "–")


ID = _text(
    "id", _("Id"), _("Permanent identifier of the record"), lambda subject: subject.feature.id
)
NAME = _text(
    "name",
    _("Name"),
    _("Name"),
    lambda subject: subject.feature.name,
    words=("name",),
    attribute="name",
)
KIND = _text(
    "kind",
    _("Type"),
    _("Feature type"),
    _type,
    words=("type",),
    format_text=lambda subject: subject.type.name if subject.type else "",
)
ELEMENT = _text("element", _("Element"), _("Plane or line"), _element)
SET = _text("set", _("Set"), _("Set"), _feature("set_name"), words=("set",), attribute="set_name")
DOMAIN = _text("domain", _("Domain"), _("Domain"), _feature("domain"), words=("domain",))
STATION = _text(
    "station",
    _("Station"),
    _("Number of the station at which a reading was taken"),
    _feature("station"),
    words=("station",),
    attribute="station",
)
OVERTURNED = Figure(
    "overturned",
    _("Overturned"),
    _("The bed is overturned: its younging direction is known"),
    _is_overturned,
    "flag",
    words=("overturned",),
    attribute="overturned",
)
UNDEFINED = Figure(
    "undefined",
    _("Undefined"),
    _("Azimuth undefined: horizontal plane or vertical line"),
    _is_undefined,
    "flag",
)
DIP_DIRECTION = _degrees(
    "dip_direction_deg",
    _("Dip dir."),
    _("Azimuth of the steepest direction down the plane"),
    _plane("dip_direction_deg"),
    "azimuth",
    short="dip_dir",
    words=("dipdir", "dd", "azimuth"),
)
DIP = _degrees(
    "dip_deg",
    _("Dip"),
    _("Angle of the plane from the horizontal"),
    _plane("dip_deg"),
    "angle",
    short="dip",
    words=("dip",),
)
STRIKE = _degrees(
    "strike_rhr_deg",
    _("Strike"),
    _("Right-hand rule: dip direction minus 90 degrees"),
    _plane("strike_rhr_deg"),
    "azimuth",
    short="strike_rhr",
    words=("strike",),
)
POLE_TREND = _degrees(
    "pole_trend_deg",
    _("Pole trend"),
    _("Azimuth of the plane's downward normal"),
    _plane("pole_trend_deg"),
    "azimuth",
    short="pole_trend",
)
POLE_PLUNGE = _degrees(
    "pole_plunge_deg",
    _("Pole plunge"),
    _("Plunge of the plane's downward normal"),
    _plane("pole_plunge_deg"),
    "angle",
    short="pole_plung",
)
TREND = _degrees(
    "trend_deg",
    _("Trend"),
    _("Azimuth of the downward direction of the line"),
    _line("trend_deg"),
    "azimuth",
    short="trend",
    words=("trend",),
)
PLUNGE = _degrees(
    "plunge_deg",
    _("Plunge"),
    _("Angle of the line from the horizontal"),
    _line("plunge_deg"),
    "angle",
    short="plunge",
    words=("plunge",),
)
X, Y, Z = (
    Figure(axis, axis, explanation, _place(i), "index", "m")
    for i, (axis, explanation) in enumerate(
        (
            ("x", _("Position in World, toward east")),
            ("y", _("Position in World, toward north")),
            ("z", _("Position in World, upward")),
        )
    )
)
NORMAL_X, NORMAL_Y, NORMAL_Z = (
    Figure(
        f"normal_{axis}", f"Normal {axis}", _("Component of the plane's upward normal"), _normal(i)
    )
    for i, axis in enumerate("xyz")
)
N_POINTS = Figure(
    "n_points", "n", _("Number of points"), _fit_value("n", "n"), "count", words=("n",)
)
EXTENT = _metres(
    "extent_m",
    _("Extent"),
    _("Longest axis of the trace, diameter of the patch"),
    _fit_value("extent", "length"),
    short="extent_m",
    words=("extent",),
)
AREA = Figure(
    "area_m2",
    _("Area"),
    _("Area of the patch's faces"),
    _measured_value("area_m2"),
    "area",
    "m2",
    words=("area",),
)
RMS = _metres(
    "rms_m",
    _("RMS"),
    _("Root mean square distance from the plane"),
    _fit_value("rms", "rms"),
    words=("rms",),
)
LAMBDA_1, LAMBDA_2, LAMBDA_3 = (
    Figure(
        f"lambda{i + 1}",
        f"λ{i + 1}",
        _("Eigenvalue of the points' scatter; the three sum to 1"),
        _eigenvalue(i),
    )
    for i in range(3)
)
COPLANARITY = Figure(
    "coplanarity",
    _("Coplan."),
    _("Coplanarity index 1/l3 (textbook eq. 20)"),
    _fit("coplanarity"),
    short="coplanar",
    words=("coplanarity",),
)
COLLINEARITY = Figure(
    "collinearity",
    _("Collin."),
    _("Collinearity index l1/l2 (textbook eq. 21)"),
    _fit("collinearity"),
    short="collinear",
    words=("collinearity",),
)
M = Figure("M", "M", _("ln(l1/l3): over 4 is well defined"), _fit("M"), words=("M",))
K = Figure("K", "K", _("ln(l1/l2)/ln(l2/l3): under 0.8 is not a line"), _fit("K"), words=("K",))
MAX_ANGULAR_ERROR = _degrees(
    "max_angular_error_deg",
    _("Ang. error max"),
    _("Largest hyperbolic angular error of the plane (Quinn and Ehlmann 2019)"),
    _fit("max_angular_error_deg"),
    short="max_angle",
)
MIN_ANGULAR_ERROR = _degrees(
    "min_angular_error_deg",
    _("Ang. error min"),
    _("Smallest hyperbolic angular error of the plane"),
    _fit("min_angular_error_deg"),
    short="min_angle",
)
MAX_CONFIDENCE = _degrees(
    "max_confidence95_deg",
    _("Fit max"),
    _("Largest tilt inside the joint 95 % confidence region of the plane or line"),
    _measured_value("max_confidence95_deg"),
    short="max_conf95",
    words=("95max",),
)
MIN_CONFIDENCE = _degrees(
    "min_confidence95_deg",
    _("Fit min"),
    _("Smallest tilt on the edge of the joint 95 % confidence region of the plane or line"),
    _measured_value("min_confidence95_deg"),
    short="min_conf95",
    words=("95min",),
)
ERROR_RAKE = _degrees(
    "error_rake_deg",
    _("Error rake"),
    _("Rake of the direction of largest tilt error"),
    _fit("error_rake_deg"),
    "angle",
    short="error_rake",
)
DIP_ERROR = _degrees(
    "dip_error_deg",
    _("± dip"),
    _("95 % error of the dip"),
    _fit("dip_error_deg"),
    short="dip_error",
    words=("dip_error",),
)
DIP_DIRECTION_ERROR = _degrees(
    "dip_direction_error_deg",
    _("± dip dir."),
    _("95 % error of the dip direction; undefined near horizontal"),
    _fit("dip_direction_error_deg"),
    short="dipdir_err",
    words=("dipdir_error",),
)
REGISTRATION_ERROR = _degrees(
    "registration_error_deg",
    _("Registration"),
    _("95 % error (half-angle) due to the rotation of the model"),
    _measured_value("registration_error_deg"),
    short="reg_error",
)
TOTAL_ERROR = _degrees(
    "total95_deg",
    _("95 % error"),
    _(
        "Larger half-angle of the 95 % region, from fit, resolution and registration; determines"
        " the verdict"
    ),
    _measured_value("total95_deg"),
    short="total95",
    words=("error", "95"),
)
NORMAL_COVARIANCE = tuple(
    Figure(
        f"normal_cov_{first}{second}",
        f"cov {first}{second}",
        _("Covariance of the upward normal (east, north, up), with all parts of the total error"),
        _covariance(i, j),
        short=f"ncov_{first}{second}",
    )
    for i, first in enumerate("enu")
    for j, second in enumerate("enu")
    if i <= j
)
BEND = _degrees(
    "bend_deg",
    _("Bend"),
    _("Angle by which a curved face bends from edge to edge"),
    _measured_value("bend_deg"),
    words=("bend",),
)
ATTITUDE_SCALE = _text(
    "attitude_scale",
    _("Scale"),
    _("Scale of the attitude: local (this position only) or regional"),
    _measured_value("attitude_scale"),
    short="att_scale",
    words=("scale", "local", "regional"),
)
RESOLUTION = _metres(
    "resolution_m",
    _("Resolution"),
    _("Effective resolution of the model around the feature (point spacing or noise)"),
    _measured_value("resolution_m"),
    short="resolution",
)
EXTENT_OVER_RESOLUTION = Figure(
    "extent_over_resolution",
    _("Ext./res."),
    _("Extent divided by the model's resolution; at least 100 recommended"),
    _ratio,
    "ratio",
    short="extent_res",
    words=("resolution", "ext/res", "ratio"),
)
QUALITY = _text(
    "quality",
    _("Quality"),
    _("Verdict on the plane or line, with its reasons"),
    _quality,
    words=("quality", "verdict"),
    format_text=_quality_text,
)
REASONS = _text(
    "quality_reason",
    _("Reasons"),
    _("Reasons for a lower verdict"),
    _reasons,
    short="reason",
    words=("reasons",),
)
REASON_CODES = _text(
    "reason_codes",
    _("Reason codes"),
    _("Codes of the findings that lowered the verdict"),
    _reason_codes,
    short="codes",
    words=("codes",),
)
QUALITY_NOTES = _text(
    "quality_notes",
    _("Notes on shape"),
    _("Shape and extent with their recommended values, and questions"),
    _quality_notes,
    short="q_notes",
)
PROFILE = _text("profile", _("Profile"), _("Profile with the limits of the verdict"), _profile)
METHOD = _text("method", _("Method"), _("Method of the fit or measurement"), _method)
MODEL = _text("model", _("Model"), _("Model on which it was measured"), _model)
FRAME = _text("frame", _("Frame"), _("North reference of the azimuths"), _frame)
NOTES = _text(
    "notes", _("Notes"), _("Notes"), _feature("notes"), words=("notes", "note"), attribute="notes"
)

ORIENTATION: tuple[Figure, ...] = (
    ID,
    NAME,
    KIND,
    ELEMENT,
    SET,
    DIP_DIRECTION,
    DIP,
    STRIKE,
    POLE_TREND,
    POLE_PLUNGE,
    TREND,
    PLUNGE,
    *SLIP,
    OVERTURNED,
    UNDEFINED,
    X,
    Y,
    Z,
    NORMAL_X,
    NORMAL_Y,
    NORMAL_Z,
    N_POINTS,
    EXTENT,
    AREA,
    RMS,
    LAMBDA_1,
    LAMBDA_2,
    LAMBDA_3,
    COPLANARITY,
    COLLINEARITY,
    M,
    K,
    MAX_ANGULAR_ERROR,
    MIN_ANGULAR_ERROR,
    MAX_CONFIDENCE,
    MIN_CONFIDENCE,
    ERROR_RAKE,
    DIP_ERROR,
    DIP_DIRECTION_ERROR,
    REGISTRATION_ERROR,
    TOTAL_ERROR,
    *NORMAL_COVARIANCE,
    RESOLUTION,
    EXTENT_OVER_RESOLUTION,
    BEND,
    ATTITUDE_SCALE,
    QUALITY,
    REASONS,
    REASON_CODES,
    QUALITY_NOTES,
    PROFILE,
    METHOD,
    MODEL,
    FRAME,
    NOTES,
)
"""Columns of the orientation table, in table order."""

ANGLE_TO_PICK = _degrees(
    "to_pick_deg",
    _("Nearest pick"),
    _(
        "Angle between a compass reading and the nearest pick of its type (without position: the"
        " most similar)"
    ),
    _angle_to_pick,
)
ANGLE = _degrees(
    "angle_deg", _("Angle"), _("Angle between the two planes"), _measured_value("angle_deg")
)

# --- groups ----------------------------------------------------------------------------------
NAME_FIGURES = (ID, NAME, KIND, SET)
PLACE = (X, Y, Z)
PLANE = (
    ELEMENT,
    DIP_DIRECTION,
    DIP,
    STRIKE,
    POLE_TREND,
    POLE_PLUNGE,
    UNDEFINED,
    NORMAL_X,
    NORMAL_Y,
    NORMAL_Z,
)
LINE = (ELEMENT, TREND, PLUNGE, UNDEFINED)
SIZE = (N_POINTS, EXTENT, RMS)
CONFIDENCE = (MAX_CONFIDENCE, MIN_CONFIDENCE)
FIT_FIGURES = (
    *SIZE,
    LAMBDA_1,
    LAMBDA_2,
    LAMBDA_3,
    COPLANARITY,
    COLLINEARITY,
    M,
    K,
    MAX_ANGULAR_ERROR,
    MIN_ANGULAR_ERROR,
    *CONFIDENCE,
    ERROR_RAKE,
    DIP_ERROR,
    DIP_DIRECTION_ERROR,
    REGISTRATION_ERROR,
    TOTAL_ERROR,
    *NORMAL_COVARIANCE,
    RESOLUTION,
    EXTENT_OVER_RESOLUTION,
    BEND,
    ATTITUDE_SCALE,
    METHOD,
)
VERDICT = (QUALITY, REASONS, REASON_CODES, QUALITY_NOTES, PROFILE)
MODEL_FIGURES = (MODEL, FRAME)
